#pragma once
// A machine: a model file assembled into one system of equations for a Scalar.
//
// Continuous state (mechanics), in this order:
//   q   2n  rotor coordinates, x then y (rotor/modal_rotor.hpp)
//   v   2n  their rates
//   effects' states, in the order of effects/all.hpp
//   filters of the signals and currents of the coils, where the model has them (magnetic_bearing/electrics.hpp)
//   angle, speed of the shaft, only where the spin is a state (Spin::drag, Spin::free)
// Everything else (currents, controller, contact mode, time) is in machine/state.hpp. The derivatives are a
// pure function of inputs and state; nothing is remembered between calls.
//
// Without coils currents are no state here: behind a held command they are known exactly (amplifier.hpp).
#include <array>
#include <memory>
#include <vector>

#include "amb_rotor/effects/effect.hpp"
#include "amb_rotor/machine/contact.hpp"
#include "amb_rotor/magnetic_bearing/controller.hpp"
#include "amb_rotor/magnetic_bearing/electrics.hpp"

namespace amb_rotor {

enum class Spin {
  prescribed,  ///< angle and speed come from outside
  drag,        ///< a state; the drive keeps the speed but for spin_drag
  free         ///< a state; spin_drag, friction in contacts and rotor, and the unbalance change it; Ip > m e^2
};

/// A plane or an unbalance beyond those of the rig, for excitation and faults.
template <class S>
struct ExtraPlanes {
  std::vector<S> force_z_m;
  std::vector<Unbalance<S>> unbalance;
};

/// What acts on the machine at an instant, from outside its equations of motion.
template <class S>
struct Inputs {
  Shaft<S> shaft;               ///< ignored where the spin is a state
  bool hold_speed = false;      ///< where the spin is a state: the drive keeps the speed (run-in)
  Vec2<S> force_current[2];     ///< the current that makes the force, end a, b [A]; ignored with coils
  S target[4] = {S(0.0), S(0.0), S(0.0), S(0.0)};         ///< limited commands [A]; coils follow them
  S sensor_offset[4] = {S(0.0), S(0.0), S(0.0), S(0.0)};  ///< [m], in front of the filters of the signals
  Vec2<S> bearing_on[2] = {{S(1.0), S(1.0)}, {S(1.0), S(1.0)}};  ///< 1 on, 0 off, each axis
  const Vec2<S>* extra_force = nullptr;        ///< one for each ExtraPlanes::force_z_m [N]
  const S* extra_unbalance = nullptr;          ///< factor of each ExtraPlanes::unbalance
  const int* contact_mode = nullptr;           ///< per end: 1 carries, 0 not; null: cut off by sign
  const int* sliding = nullptr;                ///< per end, set-valued friction: +-1 slides, 0 sticks; null: regularised
  const S* stick_force = nullptr;              ///< per end: friction force where it sticks [N]
  bool far_from_contact = false;               ///< the caller knows that no end of a lane touches
  const LocalContact<S>* contact = nullptr;    ///< per end: a contact from outside; null: the machine's own
};

/// What can be looked at.
template <class S>
struct Observation {
  Shaft<S> shaft;
  Vec2<S> centre;              ///< of gravity, absolute [m]
  Vec2<S> sensor_position[2];  ///< rotor at the sensors relative to the stator [m]
  Vec2<S> amb_position[2];
  Vec2<S> aux_position[2];     ///< rotor at the auxiliary bearings, absolute [m]
  Vec2<S> aux_velocity[2];
  Vec2<S> bearing_force[2];    ///< magnetic, on the rotor [N]
  S coil_voltage[4] = {S(0.0), S(0.0), S(0.0), S(0.0)};  ///< of the + coils less the bias's; 0 without coils [V]
  Contact<S> contact[2];
  S ring_speed[2] = {S(0.0), S(0.0)};
};

template <class S>
class Machine {
 public:
  /// @param models  one for each lane (fewer: the last is repeated); all of the same structure: rotor model,
  ///                bearing model, the same effects in any order, as many unbalances.
  /// @throw InputError: a free spin with too little polar inertia for its unbalance
  explicit Machine(const std::vector<const Model*>& models, Spin spin = Spin::prescribed,
                   const ExtraPlanes<double>& extra = {});

  int stateSize() const { return size_; }
  int coordinates() const { return 2 * rotor_.modes(); }
  const Rig<S>& rig() const { return rig_; }
  const ModalRotor<S>& rotor() const { return rotor_; }
  AmbModel ambModel() const { return amb_model_; }
  FrictionLaw frictionLaw() const { return friction_law_; }
  Spin spin() const { return spin_; }
  bool isFlexible() const { return rotor_.modes() > 2; }
  /// Where the mounts' states begin (b, b' of end a, then b), and the rings' speeds; below 0: there are none.
  int mountState() const { return mount_ != nullptr ? mount_->offset : -1; }
  int ringState() const { return ring_ != nullptr ? ring_->offset : -1; }

  /// Fills the effects' part of a state with its starting values.
  void initialise(S* state) const;

  void derivatives(const Inputs<S>& in, const S* state, S* rate) const { evaluate(in, state, rate, nullptr); }
  /// rate may be null.
  void observe(const Inputs<S>& in, const S* state, S* rate, Observation<S>& seen) const {
    evaluate(in, state, rate, &seen);
  }

  /// The sensors' signals from the rotor's position at the sensors: rotation, runout, gain.
  void sense(const Shaft<S>& shaft, Vec2<S> signal[2]) const {
    for (const auto* effect : sensing_) effect->sense(shaft, signal);
  }
  /// Signals at a state.
  void signals(const Shaft<S>& shaft, const S* state, Vec2<S> signal[2]) const;
  /// The rotor at the magnetic bearings relative to the stator [m]: what their air gaps see.
  void atMagnets(const S* state, Vec2<S> position[2]) const;
  /// Shaft of a state where the spin is a state.
  Shaft<S> shaftOf(const S* state) const {
    return Shaft<S>::at(state[size_ - 2], state[size_ - 1], S(0.0));
  }
  /// Filters and coils, and their place in a state.
  const Electrics<S>& electrics() const { return electrics_; }
  int electricsOffset() const { return electrics_offset_; }
  const ControlOptions& controlOptions() const { return control_; }
  /// The sampled controller of the rig behind all effects.
  Controller<S> controller() const { return Controller<S>(rig_, control_, chain_); }
  /// Lags between current and force; empty: none.
  const std::vector<S>& relaxationWeights() const { return relaxation_weights_; }
  const std::vector<S>& relaxationRates() const { return relaxation_rates_; }

  /// Positive while an end carries contact, negative while it does not [m]; sign as the smaller of penetration and margin.
  S contactGuard(int end, const S* state) const;
  /// The guard, and how fast regularised friction would bring sliding to rest [1/s]: mu N/v_0 times the inverse mass of the
  /// surfaces; 0 where a step of dt [s] stays far from sticking. A step of fixed length must resolve it.
  void contactPace(int end, const Inputs<S>& in, const S* state, double dt, S& guard, S& friction_rate) const;
  /// Penetration [m] (negative: gap) and its rate at an end.
  void approach(int end, const S* state, S& penetration, S& rate) const;

  /// Sliding speed of the surfaces at an end [m/s], positive where the rotor's goes with the spin.
  S slip(int end, const Inputs<S>& in, const S* state) const;
  /// Its rate [m/s^2] from a state and that state's rates:
  ///   v = R W + t.u - arm w  ->  v' = R W' + t.u' - (t.u)(n.u)/|r| - arm w' - arm' w,  u = r', |r| the distance of the
  ///   centres, arm that of ringArm()
  S slipRate(int end, const Inputs<S>& in, const S* state, const S* rate) const;

  /// Contact at both ends for a state, as a partner in the node graph computes it.
  void contacts(const Inputs<S>& in, const S* state, Contact<S> contact[2]) const;
  /// Contact at an end from the places and velocities of rotor and bearing (a solver that has them without a state).
  Contact<S> contactAt(int end, const Vec2<S>& position, const Vec2<S>& velocity, const Shaft<S>& shaft,
                       const Vec2<S>& centre, const Vec2<S>& centre_velocity, const S& ring_speed,
                       const Inputs<S>& in) const;

 private:
  struct Part {
    std::unique_ptr<EffectPhysics<S>> physics;
    unsigned roles = 0;
    int offset = 0;  ///< of its state
  };
  class Forces;

  void evaluate(const Inputs<S>& in, const S* state, S* rate, Observation<S>* seen) const;
  std::size_t actingUnbalances(const Inputs<S>& in) const {
    return in.extra_unbalance != nullptr ? unbalance_.size() : own_unbalances_;
  }
  S unbalanceMoment(std::size_t i, const Inputs<S>& in) const {
    const S& moment = unbalance_[i].moment_kg_m;
    return i < own_unbalances_ ? moment : moment * in.extra_unbalance[i - own_unbalances_];
  }
  /// What a torque on the shaft and the unbalance's reaction add to a free spin's W', in the accelerations of the
  /// coordinates, too.
  S spinReaction(const Inputs<S>& in, const Shaft<S>& shaft, S torque, S* acceleration) const;
  void requireFreeSpin() const;
  [[gnu::always_inline]] ContactGeometry<S> geometryAt(int end, const S* state) const;
  [[gnu::always_inline]] NormalForce<S> normalForce(const ContactGeometry<S>& g) const;
  [[gnu::always_inline]] S frictionCoefficient(const S& slip) const;
  [[gnu::noinline]] S frictionByEffects(S slip, S coefficient) const;
  [[gnu::noinline]] NormalForce<S> normalForceByEffects(S penetration, S rate, NormalForce<S> n) const;
  /// What the equations need of contactAt(); the rest where `all` is not null.
  [[gnu::always_inline]] ContactPush<S> contactOf(int end, const Vec2<S>& position, const Vec2<S>& velocity,
                                                  const Shaft<S>& shaft, const Vec2<S>& centre,
                                                  const Vec2<S>& centre_velocity, const S& ring_speed, const Inputs<S>& in,
                                                  Contact<S>* all) const;
  /// Arm of the friction about the ring's centre [m]: the rotor's radius and the distance of the centres, so that the
  /// torques on rotor and ring and the moment of the force between the centres add up to nothing.
  S ringArm(const S& penetration) const { return ring_arm_ + maximum(penetration, S(0.0)); }
  Vec2<S> magneticForce(const Vec2<S>& current, const Vec2<S>& position, const Vec2<S>& velocity) const;

  void electricRates(const Inputs<S>& in, const Shaft<S>& shaft, const S* state, S* rate, Observation<S>* seen) const;

  Spin spin_;
  AmbModel amb_model_;
  ControlOptions control_;
  SignalChain chain_;
  Electrics<S> electrics_;
  FrictionLaw friction_law_;
  Rig<S> rig_;
  ModalRotor<S> rotor_;
  std::vector<Part> parts_;
  std::vector<const EffectPhysics<S>*> sensing_, flux_, bearing_, pushing_, centring_, edging_, normal_, friction_,
      spinning_;
  const Part* mount_ = nullptr;
  const Part* ring_ = nullptr;
  const Part* stator_ = nullptr;
  std::vector<S> relaxation_weights_, relaxation_rates_;
  std::vector<int> unbalance_plane_, extra_force_plane_;
  std::vector<Unbalance<S>> unbalance_;   ///< the rig's, then the extra ones
  std::vector<RotorPhase<S>> unbalance_phase_;
  std::size_t own_unbalances_ = 0;
  S net_stiffness_ = S(0.0), ring_arm_ = S(0.0), contact_compliance_ = S(0.0);
  int cg_plane_ = 0;
  int electrics_offset_ = 0;
  int size_ = 0;
};

}  // namespace amb_rotor
