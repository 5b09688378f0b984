#include "amb_rotor/ros/plant_stepper.hpp"

#include <algorithm>

#include "amb_rotor/machine/assembly.hpp"
#include "amb_rotor/machine/set_valued_friction.hpp"
#include "amb_rotor/ros/conversions.hpp"

namespace amb_rotor {
namespace {

LocalContact<double> localContact(const EndContact& message) {
  LocalContact<double> law;
  law.centre = {message.centre_x, message.centre_y};
  law.centre_velocity = {message.centre_velocity_x, message.centre_velocity_y};
  law.clearance = message.clearance;
  law.penetration0 = message.penetration;
  law.rate0 = message.rate;
  law.force = message.force;
  law.slope = message.slope;
  law.damping = message.damping;
  law.friction_coefficient = message.friction_coefficient;
  law.surface_speed = message.surface_speed;
  return law;
}

}  // namespace

class PlantStepper::System final : public HybridSystem {
 public:
  System(const Machine<double>& machine, const CurrentTrack<double>& track)
      : machine_(machine),
        track_(track),
        sliding_(machine),
        moving_(machine.electricsOffset() > 2 * machine.coordinates()) {}

  int size() const override { return machine_.stateSize(); }
  /// Contact of each end; with set-valued friction the sliding of each end, too.
  int guards() const override { return 2 + sliding_.guards(); }

  void begin(const StepInputs& step, MachineState<double>& state) {
    step_ = &step;
    state_ = &state;
    lag_work_ = state.lag;
    for (int end = 0; end < 2; ++end) law_[end] = localContact(step.contact->ends[end]);
    start_shaft_ = shaftAt(step.from, state.mechanics.data());
    if (moving_) observeBearings(step.from, state.mechanics.data(), start_);
    forces_.resize(step.injection->forces.size());
    factors_.resize(step.injection->unbalances.size());
    LocalContact<double> now[2];
    Inputs<double> in;
    if (sliding_.guards() > 0) inputs(step.from, state.mechanics.data(), now, in);
    sliding_.begin(in, state.mechanics.data(), state);
  }

  /// Everything that acts at a time; `now` stays with `in`.
  void inputs(double time, const double* y, LocalContact<double> now[2], Inputs<double>& in) const {
    lawsAt(time, y, now);
    in.shaft = shaftAt(time, y);
    for (int a = 0; a < 4; ++a)
      (a % 2 == 0 ? in.bearing_on[a / 2].x : in.bearing_on[a / 2].y) =
          step_->injection->bearing_on[a] ? 1.0 : 0.0;
    currentsAt(time, in);
    electricsAt(time, in);
    injectedAt(time, in);
    in.contact_mode = state_->contact_mode;
    in.contact = now;
  }

  void derivatives(double time, const double* y, double* rate) const override {
    LocalContact<double> now[2];
    Inputs<double> in;
    inputs(time, y, now, in);
    double force[2];
    sliding_.complete(in, y, force);
    machine_.derivatives(in, y, rate);
  }

  void stickForce(double time, const double* y, double force[2]) const {
    LocalContact<double> now[2];
    Inputs<double> in;
    force[0] = force[1] = 0.0;
    if (sliding_.guards() > 0) inputs(time, y, now, in);
    sliding_.complete(in, y, force);
  }

  void guardValues(double time, const double* y, double* guard) const override {
    LocalContact<double> now[2];
    lawsAt(time, y, now);
    const auto& rotor = machine_.rotor();
    for (int end = 0; end < 2; ++end) {
      const LocalContact<double>& law = now[end];
      const auto g = contactGeometry(
          rotor.at(plane_aux + end, y) - law.centre,
          rotor.at(plane_aux + end, y + machine_.coordinates()) - law.centre_velocity, law.clearance);
      const double force =
          law.force + law.slope * (g.penetration - law.penetration0) + law.damping * (g.rate - law.rate0);
      const double inside = std::min(g.penetration, force / std::max(law.slope, 1.0));
      guard[end] = state_->contact_mode[end] != 0 ? inside : -inside;
    }
    if (sliding_.guards() == 0) return;
    Inputs<double> in;
    inputs(time, y, now, in);
    sliding_.guardValues(in, y, guard + 2);
  }

  void readCoils(MachineState<double>& state) const {
    machine_.electrics().currents(state.mechanics.data() + machine_.electricsOffset(), state.current);
  }

  void onEvent(int guard, double time, double* y) override {
    LocalContact<double> now[2];
    Inputs<double> in;
    if (sliding_.guards() > 0) inputs(time, y, now, in);
    if (guard >= 2) return sliding_.onGuard(guard - 2, in, y);
    state_->contact_mode[guard] = 1 - state_->contact_mode[guard];
    sliding_.onContact(guard, in, y);
  }

 private:
  struct Bearings {
    Vec2<double> centre[2], velocity[2];
    double ring_speed[2] = {0.0, 0.0};
  };

  Shaft<double> shaftAt(double time, const double* y) const {
    Shaft<double> shaft = machine_.spin() == Spin::prescribed
                              ? shaftFrom(step_->injection->shaft, time - step_->from)
                              : machine_.shaftOf(y);
    shaft.time = time;
    return shaft;
  }

  /// Where the auxiliary bearings are by the machine's own state.
  void observeBearings(double time, const double* y, Bearings& out) const {
    Inputs<double> in;
    in.shaft = shaftAt(time, y);
    Observation<double> seen;
    machine_.observe(in, y, nullptr, seen);
    const auto& bearing = machine_.rig().auxiliary_bearing;
    for (int end = 0; end < 2; ++end) {
      const Contact<double>& c = seen.contact[end];
      out.centre[end] = c.centre;
      out.ring_speed[end] = seen.ring_speed[end];
      const double arm = bearing.rotor_radius_m + bearing.clearance_m + std::max(c.penetration, 0.0);
      const double tangential = c.slip - bearing.rotor_radius_m * in.shaft.speed + arm * out.ring_speed[end];
      out.velocity[end] = {seen.aux_velocity[end].x - (c.rate * c.normal.x - tangential * c.normal.y),
                           seen.aux_velocity[end].y - (c.rate * c.normal.y + tangential * c.normal.x)};
    }
  }

  /// The partner's laws, moved on with the bearings and the shaft since the start of the step.
  void lawsAt(double time, const double* y, LocalContact<double> now[2]) const {
    const auto& bearing = machine_.rig().auxiliary_bearing;
    const double surface = bearing.rotor_radius_m * (shaftAt(time, y).speed - start_shaft_.speed);
    Bearings here;
    if (moving_) observeBearings(time, y, here);
    for (int end = 0; end < 2; ++end) {
      now[end] = law_[end];
      now[end].surface_speed += surface;
      if (moving_) {
        now[end].centre += here.centre[end] - start_.centre[end];
        now[end].centre_velocity += here.velocity[end] - start_.velocity[end];
        now[end].surface_speed -=
            (bearing.rotor_radius_m + bearing.clearance_m) * (here.ring_speed[end] - start_.ring_speed[end]);
      } else {
        now[end].centre += (time - step_->from) * law_[end].centre_velocity;
      }
    }
  }

  void currentsAt(double time, Inputs<double>& in) const {
    double current[4];
    std::copy(state_->current, state_->current + 4, current);
    std::copy(state_->lag.begin(), state_->lag.end(), lag_work_.begin());
    track_.move(track_.decay(time - step_->from), step_->target, current, lag_work_.data());
    track_.forceCurrent(current, lag_work_.data(), in.force_current);
  }

  void electricsAt(double time, Inputs<double>& in) const {
    std::copy(step_->target, step_->target + 4, in.target);
    if (!machine_.electrics().filters()) return;
    const Injection& injection = *step_->injection;
    const double span = injection.valid_until - step_->from;
    const double share = span > 0.0 ? (time - step_->from) / span : 0.0;
    for (int a = 0; a < 4; ++a)
      in.sensor_offset[a] = parabola(axisOf(injection.sensor_offset_start, a), axisOf(injection.sensor_offset_middle, a),
                                     axisOf(injection.sensor_offset_end, a), share);
  }

  void injectedAt(double time, Inputs<double>& in) const {
    const Injection& injection = *step_->injection;
    const double span = injection.valid_until - step_->from;
    const double share = span > 0.0 ? (time - step_->from) / span : 0.0;
    for (std::size_t i = 0; i < forces_.size(); ++i) {
      const AppliedForce& f = injection.forces[i];
      forces_[i] = {parabola(f.x[0], f.x[1], f.x[2], share), parabola(f.y[0], f.y[1], f.y[2], share)};
    }
    for (std::size_t i = 0; i < factors_.size(); ++i) {
      const auto& f = injection.unbalances[i].factor;
      factors_[i] = parabola(f[0], f[1], f[2], share);
    }
    in.extra_force = forces_.data();
    in.extra_unbalance = factors_.data();
  }

  const Machine<double>& machine_;
  const CurrentTrack<double>& track_;
  SlidingModes sliding_;
  bool moving_;
  const StepInputs* step_ = nullptr;
  MachineState<double>* state_ = nullptr;
  Shaft<double> start_shaft_;
  Bearings start_;
  LocalContact<double> law_[2];
  mutable std::vector<double> lag_work_, factors_;
  mutable std::vector<Vec2<double>> forces_;
};

PlantStepper::PlantStepper(const Machine<double>& machine, double relative_tolerance) : track_(machine) {
  system_ = std::make_unique<System>(machine, track_);
  IntegratorOptions options;  // the scales of the in-process run (machine/event_stepper.hpp)
  options.relative_tolerance = relative_tolerance;
  options.absolute.assign(machine.stateSize(), 1e-3);
  for (int i = 0; i < machine.coordinates(); ++i) {
    options.absolute[i] = 1e-5;
    options.absolute[machine.coordinates() + i] = 1e-2;
  }
  integrator_ = std::make_unique<EventIntegrator>(*system_, options);
}

PlantStepper::~PlantStepper() = default;

bool PlantStepper::advance(const StepInputs& inputs, MachineState<double>& state) {
  system_->begin(inputs, state);
  integrator_->restart();  // the commands' jump is a kink of the motion
  result_ = integrator_->advance(inputs.from, inputs.to, state.mechanics.data());
  if (result_.status != IntegrationStatus::ok) return false;
  system_->stickForce(inputs.to, state.mechanics.data(), stick_force_);
  track_.move(track_.decay(inputs.to - inputs.from), inputs.target, state.current, state.lag.data());
  system_->readCoils(state);
  state.time = inputs.to;
  return true;
}

}  // namespace amb_rotor
