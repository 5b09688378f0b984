#pragma once
// Shaft flexibility: the first bending mode of the free rotor joins the rigid modes, with modal mass = rotor mass,
//   m (q'' + 2 zeta w q' + w^2 q) = sum of shape(plane) times force, displacement += shape(plane) q, in x and y.
// Shapes are given at the amb, sensor and aux planes of each end and at the unbalance's plane; between them, for forces of other
// effects, they are interpolated along z. Left out: gyroscopic moment of the mode, higher modes.
// Valid: below the second bending mode.
// Source: modal expansion, Friswell, Penny, Garvey and Lees, Dynamics of Rotating Machines, Cambridge 2010.
#include "amb_rotor/effects/effect.hpp"

namespace amb_rotor::effects {

struct ShaftFlexibility {
  static EffectSchema schema() {
    EffectSchema s{"shaft_flexibility", "the first bending mode of the free rotor matters",
                   "chirp, step or impact that reaches the bending frequency", {}, false};
    s.parameters = {parameter("frequency_hz", "Hz", 5.0, 1e5, 400.0, std::nan(""), "free-free"),
                    parameter("damping_ratio", "1", 0.0, 1.0, 0.005, std::nan(""), "of critical")};
    for (const std::string plane : {"amb_a", "amb_b", "sensor_a", "sensor_b", "aux_a", "aux_b", "unbalance"}) {
      s.parameters.push_back({"shape_" + plane, "1", -20.0, 20.0, plane == "unbalance" ? -0.7 : 0.7, 0.0, ParameterRole::factor,
                              "mode shape there"});
      s.parameters.back().needs_contact = plane == "aux_a" || plane == "aux_b";
    }
    return s;
  }

  template <class S>
  class Physics final : public EffectPhysics<S> {
   public:
    explicit Physics(const std::vector<S>& p) : p_(p) {}
    unsigned roles() const override { return acts_on_rotor; }
    void rotor(const Rig<S>& rig, RotorPort<S>& port) override {
      port.addMode(rig.rotor.mass_kg, p_[0], p_[1], &p_[2], &p_[4], &p_[6], p_[8]);
    }

   private:
    std::vector<S> p_;
  };
};

}  // namespace amb_rotor::effects
