#pragma once
// The motion of one basic model at evenly spaced phases: what time histories, orbits, spectra, contact forces
// and hysteresis loops are drawn from.
//
// The event-accurate motion (basic_orbit.hpp) takes steps of its own length, each ending at a contact event
// at the latest; between the ends of a step the state is the cubic Hermite polynomial of displacement and
// velocity (Hermite of velocity and acceleration for the velocity would need the acceleration; the
// polynomial's slope is used). Its error is h^4/384 times the fourth derivative for the displacement: below
// 1e-5 of the clearance at the steps that the default tolerance asks for.
//
//   normal force   N [clearance k1] = alpha (r - 1), or kappa (r - 1)^1.5 max(0, 1 + 1.5 a r'), r > 1, else 0
//
// Units: dimensionless as in basic_model.hpp; phase [rad]. Errors: InputError for counts below 1; a motion
// that cannot be integrated ends early with finite = false. Left out: the friction force (s N,
// basic_model.hpp).
#include <vector>

#include "amb_rotor/machine/basic_orbit.hpp"

namespace amb_rotor {

struct BasicRecord {
  std::vector<double> phase;  ///< of the shaft since the start of the first kept turn
  std::vector<BasicState<double>> state;
  std::vector<double> normal_force;  ///< [clearance k1]
  std::vector<double> depth_rate;    ///< r' [clearance w_n], the penetration's rate where in contact
  BasicState<double> end;            ///< after the last kept turn
  double contact_fraction = 0.0;     ///< of the kept turns
  int touch_downs = 0;               ///< in the kept turns
  bool finite = true;
};

/// Normal force [clearance k1] at a state.
double basicNormalForce(const BasicParameters<double>& p, const BasicState<double>& state,
                        BasicContact contact);

/// Runs `turns_skipped` turns from phase 0, then records `turns_kept` turns, `samples_per_turn` each.
BasicRecord recordBasic(const BasicParameters<double>& p, const BasicState<double>& initial,
                        int turns_skipped, int turns_kept, int samples_per_turn,
                        const BasicOrbitOptions& options);

}  // namespace amb_rotor
