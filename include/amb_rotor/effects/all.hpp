#pragma once
// Every effect of the program, in the order in which they act (sensors: rotation, runout, gain; flux: gap law, then
// saturation). A new effect is one more header and one more name in this list; or a file (law_effect.hpp), which acts
// after all of these.
#include "amb_rotor/effects/amplifier_lag.hpp"
#include "amb_rotor/effects/auxiliary_bearing_misalignment.hpp"
#include "amb_rotor/effects/auxiliary_bearing_tilt.hpp"
#include "amb_rotor/effects/compliant_mount.hpp"
#include "amb_rotor/effects/control_delay.hpp"
#include "amb_rotor/effects/couple_unbalance.hpp"
#include "amb_rotor/effects/cross_coupled_stiffness.hpp"
#include "amb_rotor/effects/current_saturation.hpp"
#include "amb_rotor/effects/eddy_current_lag.hpp"
#include "amb_rotor/effects/force_law.hpp"
#include "amb_rotor/effects/force_law_at_plane.hpp"
#include "amb_rotor/effects/force_law_of_tilt.hpp"
#include "amb_rotor/effects/foundation_resonance.hpp"
#include "amb_rotor/effects/fractional_mount.hpp"
#include "amb_rotor/effects/gyroscopic_coupling.hpp"
#include "amb_rotor/effects/hertzian_contact.hpp"
#include "amb_rotor/effects/inner_ring_spin.hpp"
#include "amb_rotor/effects/internal_damping.hpp"
#include "amb_rotor/effects/law_effect.hpp"
#include "amb_rotor/effects/magnetic_nonlinearity.hpp"
#include "amb_rotor/effects/magnetic_saturation.hpp"
#include "amb_rotor/effects/motor_magnetic_pull.hpp"
#include "amb_rotor/effects/sensor_axis_rotation.hpp"
#include "amb_rotor/effects/sensor_gain_error.hpp"
#include "amb_rotor/effects/sensor_runout.hpp"
#include "amb_rotor/effects/shaft_bow.hpp"
#include "amb_rotor/effects/shaft_crack.hpp"
#include "amb_rotor/effects/shaft_flexibility.hpp"
#include "amb_rotor/effects/signal_law.hpp"
#include "amb_rotor/effects/spin_drag.hpp"
#include "amb_rotor/effects/static_load.hpp"
#include "amb_rotor/effects/stiffness_anisotropy.hpp"
#include "amb_rotor/effects/velocity_dependent_friction.hpp"

namespace amb_rotor::effects {

template <class... Effects>
struct EffectList {
  template <class F>
  static void forEach(F&& f) {
    (f(static_cast<Effects*>(nullptr)), ...);
  }
};

using All = EffectList<SensorAxisRotation, SensorRunout, SensorGainError, CoupleUnbalance, ShaftBow, StaticLoad,
                       GyroscopicCoupling, StiffnessAnisotropy, CrossCoupledStiffness, InternalDamping,
                       MotorMagneticPull, FoundationResonance, MagneticNonlinearity, MagneticSaturation,
                       CurrentSaturation, AmplifierLag, ControlDelay, EddyCurrentLag, AuxiliaryBearingMisalignment,
                       AuxiliaryBearingTilt, HertzianContact, CompliantMount, FractionalMount,
                       VelocityDependentFriction, InnerRingSpin, SpinDrag, ShaftCrack, ShaftFlexibility, ForceLaw,
                       ForceLawAtPlane, ForceLawOfTilt, SignalLaw>;

/// Place of an effect in the order in which they act; -1: unknown.
template <class F>
void forEachEffect(F&& f) {
  All::forEach(std::forward<F>(f));
}

/// The name of an effect, whose schema is then made once.
template <class Effect>
const std::string& idOf() {
  static const std::string id = Effect::schema().id;
  return id;
}

/// The physics of one effect for a Scalar, from its parameters in the order of its schema; null: unknown id.
template <class S>
std::unique_ptr<EffectPhysics<S>> makePhysics(const std::string& id, const std::vector<S>& values) {
  std::unique_ptr<EffectPhysics<S>> made;
  forEachEffect([&](auto* effect) {
    using Effect = std::remove_pointer_t<decltype(effect)>;
    if (idOf<Effect>() == id) made = std::make_unique<typename Effect::template Physics<S>>(values);
  });
  if (made == nullptr)
    if (const auto law = effectLaw(id)) made = std::make_unique<LawPhysics<S>>(law, values);
  return made;
}

}  // namespace amb_rotor::effects
