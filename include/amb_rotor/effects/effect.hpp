#pragma once
// How an effect enters a machine. An effect is one header under effects/: a struct with
//   static EffectSchema schema();                    its name, parameters, limits, the data that show it
//   template <class S> struct Physics : EffectPhysics<S>   its equations, for double and for lanes
// A Physics overrides the ports it acts on and says which in roles(). It is immutable; what changes is
// in the continuous state that it declares. Adding an effect: the header, and its line in effects/all.hpp.
//
// Order in a machine: rig() and rotor() once; then at each instant stator, flux(),
// bearingForce(), contactCentre()/contactEdge()/normalForce()/friction(), rotorForce(), and last the reactions. Effects of one port
// act in the order of effects/all.hpp (sensors: rotation, then runout, then gain).
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "amb_rotor/auxiliary_bearing/contact_law.hpp"
#include "amb_rotor/common/shaft.hpp"
#include "amb_rotor/common/units.hpp"
#include "amb_rotor/magnetic_bearing/magnetic_force.hpp"
#include "amb_rotor/model/effect_schema.hpp"
#include "amb_rotor/model/model.hpp"
#include "amb_rotor/rotor/modal_rotor.hpp"

namespace amb_rotor {

enum Role : unsigned {
  acts_on_rig = 1u << 0,
  acts_on_rotor = 1u << 1,
  acts_on_sensor = 1u << 2,
  acts_on_force_current = 1u << 3,
  acts_on_flux = 1u << 4,
  acts_on_bearing_force = 1u << 5,
  acts_on_rotor_force = 1u << 6,
  acts_on_contact_centre = 1u << 7,
  acts_on_normal_force = 1u << 8,
  acts_on_friction = 1u << 9,
  acts_on_spin = 1u << 10,
  is_mount = 1u << 11,
  is_ring = 1u << 12,
  is_stator = 1u << 13,
  acts_on_contact_edge = 1u << 14
};

/// Lets an effect shape the rotor before a machine is built.
template <class S>
class RotorPort {
 public:
  virtual ~RotorPort() = default;
  /// A plane at axial position z; returns the index for RotorForces.
  virtual int addPlane(const S& z) = 0;
  /// One more mode per plane with its shape at the amb, sensor and aux planes (a, b) and at the unbalance.
  virtual void addMode(const S& mass, const S& frequency_hz, const S& damping_ratio, const S shape_amb[2],
                       const S shape_sensor[2], const S shape_aux[2], const S& shape_unbalance) = 0;
};

/// Lets an effect read the rotor at planes and push it there. Displacements are relative to the stator. What pushes
/// stands on the stator (a seal's housing, a motor's winding) and pushes that back; a load comes from elsewhere. A torque
/// about the shaft's axis counts where the spin is free; else the drive gives it.
template <class S>
class RotorForces {
 public:
  virtual ~RotorForces() = default;
  virtual Vec2<S> position(int plane) const = 0;
  virtual Vec2<S> velocity(int plane) const = 0;
  virtual void push(int plane, const Vec2<S>& force) = 0;
  virtual void load(int plane, const Vec2<S>& force) = 0;
  virtual void twist(const S& torque) = 0;
};

/// One magnetic bearing at an instant.
template <class S>
struct BearingSite {
  const Rig<S>* rig;
  const Shaft<S>* shaft;
  int end;                  ///< 0 a, 1 b
  Vec2<S> position;         ///< [m], relative to the stator
  Vec2<S> velocity;         ///< [m/s]
  Vec2<S> current;          ///< that makes the force [A]
  S net_stiffness = S(0.0);     ///< Ki kp - Ks, or the equivalent stiffness [N/m]
  Vec2<S> on = {S(1.0), S(1.0)};  ///< 1 on, 0 off, each axis: what bearingForce() adds is taken times it
};

template <class S>
class EffectPhysics {
 public:
  virtual ~EffectPhysics() = default;
  virtual unsigned roles() const = 0;

  virtual void rig(Rig<S>&) {}
  virtual void rotor(const Rig<S>&, RotorPort<S>&) {}

  virtual int stateSize() const { return 0; }
  /// Starting values; default 0.
  virtual void initialState(S*) const {}

  /// Signals of the two sensor pairs, in place.
  virtual void sense(const Shaft<S>&, Vec2<S>[2]) const {}
  /// Lags between the current channel and the current that makes the force: i_force = sum of weight times a
  /// first-order lag of rate [1/s]; weights add up to 1. Appended.
  virtual void relaxation(std::vector<S>&, std::vector<S>&) const {}
  /// Flux of one axis' coils, in place, from current and position.
  virtual void flux(const Rig<S>&, const S&, const S&, CoilFlux<S>&) const {}
  /// Force that is added at a magnetic bearing while it is on.
  virtual void bearingForce(const BearingSite<S>&, Vec2<S>&) const {}
  /// Torque [N m] on a free spin that belongs to that force: where it is -dV/dp of a potential V(p, angle) [J] it is
  /// -dV/dangle. `on` is not taken off it.
  virtual S bearingTorque(const BearingSite<S>&) const { return S(0.0); }
  virtual void rotorForce(const Shaft<S>&, RotorForces<S>&) const {}
  virtual void contactCentre(int, Vec2<S>&) const {}
  /// Centre of the edge that a rotor at `offset` from the bearing's centre meets, in place (a tilted bearing).
  virtual void contactEdge(int, const Vec2<S>&, Vec2<S>&) const {}
  virtual void normalForce(const S&, const S&, NormalForce<S>&) const {}
  virtual void friction(const S&, S&) const {}
  /// Adds to Omega' [rad/s^2] of a shaft whose drive keeps a constant speed.
  virtual void spin(const Rig<S>&, const S&, S&) const {}
  /// Compliant mount: where the auxiliary bearing of an end is (absolute), and its state's rates under the force of
  /// the rotor on it. `rest` is where it stands unloaded, moving with the stator.
  virtual void mountPosition(int, const S*, Vec2<S>&, Vec2<S>&) const {}
  virtual Vec2<S> mountRates(int, const Vec2<S>&, const Vec2<S>&, const Vec2<S>&, const S*, S*) const {
    return {};
  }
  /// Inner ring: its spin [rad/s], and its rate under the friction torque [N m] on it.
  virtual S ringSpeed(int, const S*) const { return S(0.0); }
  virtual void ringRates(int, const S&, const S*, S*) const {}
  /// Moving stator: its displacement and velocity, and its rates under the reaction of the bearings.
  virtual void statorPosition(const S*, Vec2<S>&, Vec2<S>&) const {}
  virtual void statorRates(const Vec2<S>&, const S*, S*) const {}
};

/// A parameter row of a schema, in one call.
inline ParameterSchema parameter(const char* name, const char* unit, double lower, double upper, double typical,
                                 double neutral, const char* meaning, ParameterRole role = ParameterRole::plain) {
  return {name, unit, lower, upper, typical, neutral, role, meaning};
}

/// A parameter that stands in place of a number of the rig (its name out of Rig::visit).
inline ParameterSchema inPlaceOf(const char* rig_number, ParameterSchema parameter) {
  parameter.replaces = rig_number;
  return parameter;
}

}  // namespace amb_rotor
