#pragma once
// From a recording and a model to what predict() needs.
#include <vector>

#include "amb_rotor/validation/recording.hpp"

namespace amb_rotor {

/// The whole of a recording, for the lanes.
Stretch stretchOf(const Recording& rec, const Model& model);

/// One lane of it. At standstill the shaft has the angle given [rad].
LaneJob jobOf(const Recording& rec, const Model& model, double standstill_angle);

/// Turns the shaft of a run by what has been found beyond its pulses.
void turnShaft(const Recording& rec, const ShaftTurn& turn, LaneJob& job);

/// A trial weight in a run is known: it joins the machine's unbalance.
std::vector<Model> withTrialWeights(const std::vector<Model>& models, const Recording& rec);

/// Angle and speed of the shaft at a time of a run of constant speed, which spin_drag may lower.
ShaftInstant shaftAt(const Recording& rec, const Model& model, double time);

/// Step that the lanes need for a model's fastest motion away from contact, and through contact [s].
double freeStep(const Model& model);
double contactStep(const Model& model);

/// Time in which a weakly damped resonance of an effect forgets how it began [s]; 0: none has one.
double settlingTime(const Model& model);

/// Run-in behind which a recording without contact begins settled [s]: that of the stretch, doubled until twice as long
/// a one changes the first 20 ms by less than 0.05 of the noise, or of what the prediction is off there if that is more, and
/// 2.4 s at most. A loop of weak damping needs it: what still rings at the start would be taken for the missing physics. What
/// does not settle (a limit cycle) keeps the stretch's.
double settledRunIn(const Recording& rec, const Model& model, const Stretch& stretch, double standstill_angle);

/// Whether the ends, where they touch in instants first .. last - 1, slide fast enough that set-valued and regularised
/// friction are one: then the lanes may take them. The surface's speed R |W| less the whirl's bounds the sliding speed from
/// below; the whirl's is read off the measurement. Never with a ring that turns itself, nor where a sensor is missing.
bool slidesThroughout(const Recording& rec, const Model& model, long first, long last);

/// Value and slope [per s] of a measured channel at instant `at`, from a parabola over `count` instants from `from` on (at the
/// ends of a recording over the first or last).
void localParabola(const Recording& rec, int channel, long from, long count, long at, double& value, double& slope);

/// Instants that a local parabola goes through: the first of them, counted from the one looked at, and how many.
struct MeasuredFrom {
  long from = 0, count = 8;
};

/// A starting state at instant `first`, read off the measurement by local parabolas: mechanics, currents, and what the
/// controller would remember.
MachineState<double> stateFromMeasurement(const Recording& rec, const Model& model, Spin spin, long first,
                                          const MeasuredFrom& span = {});

}  // namespace amb_rotor
