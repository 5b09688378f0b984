#include "amb_rotor/validation/experiments.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "amb_rotor/common/units.hpp"
#include "amb_rotor/effects/catalogue.hpp"
#include "amb_rotor/validation/stretches.hpp"
#include "amb_rotor/common/linear_algebra.hpp"

namespace amb_rotor {
namespace {

constexpr double farthest_reach = 0.8;       ///< of the clearance, in a run without contact
constexpr double top_speed_ratio = 1.5;  ///< of the critical speed
constexpr double default_share = 0.1;    ///< of the clearance, where no recording was excited
/// Of the largest excitation in the recordings: a chirp meets the resonances, a step may be larger.
constexpr double chirp_share = 0.4, strong_chirp_share = 0.9;
constexpr const char* axis_names[4] = {"ax", "ay", "bx", "by"};

double netStiffness(const Model& model) {
  const auto& rig = model.rig;
  if (model.amb_model != AmbModel::linear) return rig.amb.stiffness_N_per_m;
  return rig.amb.current_stiffness_N_per_A * rig.controller.kp_A_per_m -
         rig.amb.displacement_stiffness_N_per_m;
}

double criticalHz(const Model& model) {
  return std::sqrt(std::max(2.0 * netStiffness(model) / model.rig.rotor.mass_kg, 1.0)) / two_pi;
}

double usualCurrent(const Model& belief, const std::vector<Recording>& recordings) {
  double largest = 0.0;
  for (const auto& rec : recordings)
    if (!rec.holdsContact())
      for (const auto& axis : rec.excitation.axis)
        for (double i : axis) largest = std::max(largest, std::fabs(i));
  if (largest > 0.0) return largest;
  const double ki = belief.rig.amb.current_stiffness_N_per_A;
  return ki > 0.0 ? default_share * belief.rig.auxiliary_bearing.clearance_m * netStiffness(belief) / ki
                  : 0.0;
}

std::string text(double value, int digits = 3) {
  char out[32];
  std::snprintf(out, sizeof out, "%.*g", digits, value);
  return out;
}

/// To the digits that a person sets on a rig.
double rounded(double value) { return std::strtod(text(value).c_str(), nullptr); }

class Plans {
 public:
  Plans(const Model& belief, const std::vector<Recording>& recordings)
      : belief_(belief),
        rate_(recordings[0].run.sample_rate_hz),
        current_(usualCurrent(belief, recordings)) {}

  Experiment& add(const std::string& name, double duration, double speed_hz, const std::string& what) {
    Experiment one;
    one.name = name;
    one.what = what;
    one.scenario.name = name;
    one.scenario.duration_s = duration;
    one.scenario.record_rate_hz = rate_;
    one.scenario.speed.start_hz = speed_hz;
    one.gravity_m_s2 = belief_.rig.gravity_m_s2;
    all_.push_back(one);
    return all_.back();
  }
  void constant(const std::string& name, double speed_hz, const std::string& what) {
    const double speed = rounded(speed_hz), duration = rounded(std::min(3.0, std::max(1.0, 8.0 / speed)));
    add(name, duration, speed, what + ": constant " + text(speed) + " Hz for " + text(duration) + " s");
  }
  void ramp(double from_hz, double to_hz) {
    const double from = rounded(from_hz), to = rounded(to_hz);
    Experiment& one =
        add("run_up", 2.0, from,
            "run-up through the critical speed: " + text(from) + " to " + text(to) + " Hz in 1.8 s");
    one.scenario.speed.type = SpeedType::ramp;
    one.scenario.speed.start_s = 0.1;
    one.scenario.speed.duration_s = 1.8;
    one.scenario.speed.end_hz = to;
  }
  void trialWeight(double speed_hz) {
    if (belief_.rig.unbalance.empty()) return;
    Unbalance<double> weight = belief_.rig.unbalance[0];
    weight.moment_kg_m = rounded(std::max(weight.moment_kg_m, 5e-6 * belief_.rig.rotor.mass_kg));
    weight.phase_rad += 0.5 * pi;
    const double speed = rounded(speed_hz);
    Experiment& one = add("trial_weight", 1.0, speed,
                          "another unbalance: a trial weight of " + text(weight.moment_kg_m) +
                              " kg m at z = " + text(weight.plane_z_m) +
                              " m, a quarter turn ahead of the rotor's own, at " + text(speed) + " Hz");
    one.trial_weights.push_back(weight);
  }
  void chirp(const std::string& name, int axis, double factor, double speed_hz) {
    const double amplitude = rounded(factor * current_);
    if (belief_.amb_model != AmbModel::linear || amplitude <= 0.0) return;
    const double speed = rounded(speed_hz);
    Experiment& one =
        add(name, 1.0, speed,
            (factor > chirp_share ? "strong current chirp on " : "current chirp on ") +
                std::string(axis_names[axis]) + " of " + text(amplitude) + " A, 5 to 400 Hz in 1 s, " +
                (speed > 0.0 ? "at " + text(speed) + " Hz" : "at standstill"));
    Excitation e;
    e.kind = Excitation::Kind::current;
    e.waveform = Waveform::chirp;
    e.end = axis / 2;
    e.axis = axis % 2;
    e.amplitude = amplitude;
    e.start_s = 0.05;
    e.duration_s = 0.9;
    e.start_hz = 5.0;
    e.end_hz = 400.0;
    one.scenario.excitations.push_back(e);
  }
  void drop(const std::string& name, double speed_hz) {
    const double speed = rounded(speed_hz);
    Experiment& one = add(name, 0.4, speed,
                          "drop by power failure " +
                              (speed > 0.0 ? "at " + text(speed) + " Hz" : std::string("at standstill")));
    FaultEvent fault;
    fault.type = FaultType::amb_off;
    fault.start_s = 0.05;
    one.scenario.faults.push_back(fault);
  }
  void turnGravity(const std::string& name, double speed_hz) {
    constant(name, speed_hz, "");
    Experiment& one = all_.back();
    const bool lying = belief_.rig.gravity_m_s2 != 0.0;
    one.gravity_m_s2 = lying ? 0.0 : standard_gravity_m_s2;
    one.what = (lying ? "rotor upright, so that no weight loads the bearings"
                      : "rotor lying, so that its weight loads the bearings") +
               one.what;
  }
  std::vector<Experiment> take() { return std::move(all_); }

 private:
  const Model& belief_;
  double rate_, current_;
  std::vector<Experiment> all_;
};

/// What is left of a model's difference to `measured` after its refit: chi2, and the number of residuals.
double left(const Rival& model, const Experiment& experiment, const std::vector<double>& measured,
            const Recording& like, double offset_std, double& count) {
  std::vector<Recording> one = {recordingOf(experiment, like)};
  one[0].measured = measured;
  Model belief = model.belief;
  belief.rig.gravity_m_s2 = experiment.gravity_m_s2;
  const FitSpace space(belief, model.fitted);
  const FitProblem problem(one, space, offset_std);
  std::vector<LocalState> local(1);
  const NormalEquations normal = problem.evaluate(model.x, {0}, local, {});
  if (!normal.finite) return -1.0;
  count = normal.count;
  const Eigen::MatrixXd h = normal.h + model.information;
  const double taken = normal.g.dot(Ldlt(h).solve(normal.g));
  return std::isfinite(taken) ? std::max(normal.chi2 - taken, 0.0) : -1.0;
}

}  // namespace

std::vector<Experiment> feasibleExperiments(const Model& belief, const std::vector<Recording>& recordings,
                                            bool contact) {
  if (recordings.empty()) return {};
  const double critical = criticalHz(belief);
  Plans plans(belief, recordings);
  if (contact) {
    plans.drop("drop_standstill", 0.0);
    plans.drop("drop_slow", 0.3 * critical);
    plans.drop("drop_fast", 0.9 * critical);
    return plans.take();
  }
  plans.constant("slow_roll", 0.1 * critical, "slow roll");
  plans.constant("below_critical", 0.6 * critical, "below the critical speed");
  plans.constant("above_critical", top_speed_ratio * critical, "above the critical speed");
  plans.ramp(0.2 * critical, top_speed_ratio * critical);
  plans.trialWeight(0.6 * critical);
  for (int axis = 0; axis < 4; ++axis) plans.chirp(std::string("chirp_") + axis_names[axis], axis, chirp_share, 0.0);
  plans.chirp("chirp_strong_ax", 0, strong_chirp_share, 0.0);
  plans.chirp("chirp_turning_ay", 1, chirp_share, 0.9 * critical);
  plans.turnGravity(belief.rig.gravity_m_s2 != 0.0 ? "upright" : "lying", 0.5 * critical);
  return plans.take();
}

Model inExperiment(const Experiment& experiment, Model model) {
  model.rig.gravity_m_s2 = experiment.gravity_m_s2;
  model.rig.unbalance.insert(model.rig.unbalance.end(), experiment.trial_weights.begin(),
                             experiment.trial_weights.end());
  return model;
}

Recording recordingOf(const Experiment& experiment, const Recording& like) {
  const Scenario& scenario = experiment.scenario;
  Recording rec;
  rec.run.id = experiment.name;
  rec.run.sample_rate_hz = scenario.record_rate_hz;
  rec.run.unbalance = experiment.trial_weights;
  rec.run.speed_hz = scenario.speed.start_hz;
  rec.run.speed_from_tacho = scenario.speed.type == SpeedType::ramp;
  rec.run.kind = !scenario.faults.empty()       ? RunKind::drop
                 : rec.run.speed_from_tacho     ? RunKind::run_up
                 : scenario.excitations.empty() ? RunKind::steady
                                                : RunKind::chirp;
  rec.samples = std::lround(scenario.duration_s * scenario.record_rate_hz) + 1;
  rec.measured.assign(static_cast<std::size_t>(rec.samples) * predicted_channels, 0.0);
  rec.noise = like.noise;
  rec.excitation.rate_hz = scenario.record_rate_hz;
  rec.schedule = Schedule(scenario.excitations, scenario.faults);
  rec.standstill = scenario.speed.start_hz == 0.0;
  rec.speed_rad_s = radPerSecond(scenario.speed.start_hz);
  rec.angle0_rad = scenario.speed.initial_angle_rad;
  if (rec.run.speed_from_tacho) rec.path = std::make_shared<PiecewiseShaft>(shaftPath(scenario));
  if (!rec.standstill) {
    rec.pulses.state = TachoState::turning;
    const double first = std::ceil(rec.angle0_rad / two_pi - 1e-9);
    for (long turn = 0; !rec.path && turn < 20; ++turn) {
      rec.pulses.time.push_back((two_pi * (first + turn) - rec.angle0_rad) / rec.speed_rad_s);
      rec.pulses.turn.push_back(turn);
    }
  }
  return rec;
}

std::vector<double> signalsOf(const Experiment& experiment, const Model& model, const Recording& like,
                              bool free) {
  const Recording rec = recordingOf(experiment, like);
  const Model rig = inExperiment(experiment, model);
  Stretch stretch = stretchOf(rec, rig);
  if (free)
    stretch.settle_s = settledRunIn(rec, rig, stretch, 0.0);
  else
    stretch.contact_step_s = contactStep(rig);
  stretch.by_events = !free && rig.friction_law == FrictionLaw::set_valued;
  std::vector<double> out(rec.measured.size());
  std::vector<LaneJob> jobs = {jobOf(rec, rig, 0.0)};
  jobs[0].out = out.data();
  predict(stretch, jobs);
  if (!jobs[0].finite) return {};
  if (!free) return out;
  for (long i = 0; i < rec.samples; ++i)
    for (const double z : rig.rig.planes.aux)
      if (radiusAt(out.data() + i * predicted_channels, rig, z) > farthest_reach * rig.rig.auxiliary_bearing.clearance_m)
        return {};
  return out;
}

std::vector<Experiment> rankExperiments(const Rival& one, const Rival& other,
                                        const std::vector<Recording>& recordings, double offset_std_m) {
  const bool contact = needsContact(one.effect) || needsContact(other.effect);
  std::vector<Experiment> all = feasibleExperiments(one.belief, recordings, contact);
  const Model models[2] = {FitSpace(one.belief, one.fitted).model(one.x),
                           FitSpace(other.belief, other.fitted).model(other.x)};
  const Rival* rivals[2] = {&one, &other};
  const Recording& like = recordings[0];
  tbb::parallel_for(std::size_t{0}, all.size(), [&](std::size_t k) {
    Experiment& e = all[k];
    e.effect = one.effect;
    e.against = other.effect;
    e.separation = e.evidence = -1.0;
    double least = 1e300, residuals = 0.0;
    for (int truth = 0; truth < 2; ++truth) {
      const std::vector<double> measured = signalsOf(e, models[truth], like, !contact);
      if (measured.empty()) return;
      const double chi2 = left(*rivals[1 - truth], e, measured, like, offset_std_m, residuals);
      if (chi2 < 0.0) return;
      least = std::min(least, chi2);
    }
    e.evidence = 0.5 * least;
    e.separation = std::sqrt(least / std::max(1.0, residuals));
  });
  all.erase(std::remove_if(all.begin(), all.end(), [](const Experiment& e) { return e.separation < 0.0; }),
            all.end());
  std::stable_sort(all.begin(), all.end(),
                   [](const Experiment& a, const Experiment& b) { return a.evidence > b.evidence; });
  return all;
}

std::vector<std::string> experimentOverrides(const Experiment& experiment, const Model& model) {
  std::vector<std::string> out;
  if (experiment.gravity_m_s2 != model.rig.gravity_m_s2)
    out.push_back("rig.gravity_m_s2=" + text(experiment.gravity_m_s2, 9));
  if (!experiment.trial_weights.empty() && !model.rig.unbalance.empty()) {
    // a weight in the plane of the rotor's first unbalance: one vector with it
    const Unbalance<double>&own = model.rig.unbalance[0], &weight = experiment.trial_weights[0];
    const double x =
        own.moment_kg_m * std::cos(own.phase_rad) + weight.moment_kg_m * std::cos(weight.phase_rad);
    const double y =
        own.moment_kg_m * std::sin(own.phase_rad) + weight.moment_kg_m * std::sin(weight.phase_rad);
    out.push_back("rig.unbalance.0.moment_kg_m=" + text(std::hypot(x, y), 9));
    out.push_back("rig.unbalance.0.phase_rad=" + text(std::atan2(y, x), 9));
  }
  return out;
}

}  // namespace amb_rotor
