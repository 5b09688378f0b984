#pragma once
// The contact laws that most machines have, linear and Hertz's with constant friction
// (auxiliary_bearing/contact_law.hpp), one end at a time or at all nodes of a step at once.
#include <algorithm>
#include <cmath>

#include "amb_rotor/auxiliary_bearing/contact_law.hpp"
#include "amb_rotor/integration/contact_flow.hpp"

namespace amb_rotor {

/// The two contact laws that most machines have, with constant friction, without the detours of the general
/// one.
struct PlainLaw {
  bool known = false, hertz = false;
  double stiffness = 0.0, compliance = 0.0, damping = 0.0, friction = 0.0, clearance = 0.0,
         surface_speed = 0.0;

  double force(const double* w, double* u, EndContacts::Normal& normal) const {
    const double distance = std::sqrt(w[0] * w[0] + w[1] * w[1] + 1e-30), inverse = 1.0 / distance;
    const double nx = w[0] * inverse, ny = w[1] * inverse, depth = distance - clearance;
    const double rate = nx * w[2] + ny * w[3], slip = surface_speed + nx * w[3] - ny * w[2];
    double margin;
    if (hertz) {
      const NormalForce<double> law = hertzContact(stiffness, damping, depth, rate);
      normal = {law.force, law.slope, law.damping, nx, ny};
      margin = law.margin;
    } else {
      normal = {stiffness * depth + damping * rate, stiffness, damping, nx, ny};
      margin = normal.force * compliance;
    }
    const double share = slip * (1.0 / friction_regularisation_m_s);
    const double tangential = -friction * normal.force *
                              (std::abs(share) > saturated ? std::copysign(1.0, share) : std::tanh(share));
    u[0] = -normal.force * nx - tangential * ny;
    u[1] = -normal.force * ny + tangential * nx;
    return std::min(depth, margin);
  }
  /// Where tanh is 1 but for round-off.
  static constexpr double saturated = 20.0;
};

/// EndContacts::forces() by a plain law.
using PlainForces = void (*)(const PlainLaw& law, int first, int count, const double* w, double* u,
                             ContactNodes& nodes);
PlainForces plainForcesBaseline();
PlainForces plainForcesAvx2();    ///< null: not in this build
PlainForces plainForcesAvx512();  ///< likewise
/// By the widest instructions that this processor has.
PlainForces plainForces();

}  // namespace amb_rotor
