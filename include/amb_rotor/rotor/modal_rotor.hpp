#pragma once
// An axisymmetric rotor in coordinates in which mass, stiffness and damping are diagonal, the same in
// both planes. With q the x coordinates and r the y coordinates (n each), and shape_k(z) their shapes:
//
//   x(z) = sum_k shape_k(z) q_k,   y(z) = sum_k shape_k(z) r_k
//   m_k q_k'' + d_k q_k' + k_k q_k + Omega sum_l g_kl r_l' = sum_planes shape_k(z) Fx(z)
//   m_k r_k'' + d_k r_k' + k_k r_k - Omega sum_l g_kl q_l' = sum_planes shape_k(z) Fy(z)
//
// rigid mass: n = 1, shape (1). rigid beam: n = 2, shape (1, z), masses (m, It), g_22 = Ip: with
// q_2 = beta (tilt about y) and r_2 = -alpha (tilt about x) this is
//   It beta'' - Ip Omega alpha' = My,  It alpha'' + Ip Omega beta' = Mx.
// Flexible: further modes. SI; Omega positive about z.
// Valid: small tilts; both planes alike; frequencies below that of the first mode left out.
// Source: thesis 3.1 (rigid mass), 5.2.1 (rigid beam), 3.15 (flexible); the gyroscopic terms, which it neglects, derived in
// doc/physics.md section 1.
// Left out: axial and torsional motion,
// rotor anisotropy (see shaft_crack), the acceleration term Omega' g q of a gyroscopic rotor in run-up.
#include <vector>

#include "amb_rotor/common/check.hpp"
#include "amb_rotor/common/scalar.hpp"

namespace amb_rotor {

template <class S>
class ModalRotor {
 public:
  /// @param modes  coordinates per plane
  explicit ModalRotor(int modes = 0)
      : modes_(modes),
        mass_(modes, S(1.0)),
        stiffness_(modes, S(0.0)),
        damping_(modes, S(0.0)),
        gyroscopic_(modes * modes, S(0.0)) {}

  int modes() const { return modes_; }
  S& mass(int k) { return mass_[k]; }
  S& stiffness(int k) { return stiffness_[k]; }
  S& damping(int k) { return damping_[k]; }
  S& gyroscopic(int k, int l) { return gyroscopic_[k * modes_ + l]; }
  const S& mass(int k) const { return mass_[k]; }
  const S& stiffness(int k) const { return stiffness_[k]; }

  /// Registers a plane by its shapes (size modes()); returns its index.
  int addPlane(const std::vector<S>& shape) {
    AMB_ROTOR_CHECK(static_cast<int>(shape.size()) == modes_, "one shape value for each mode");
    shapes_.insert(shapes_.end(), shape.begin(), shape.end());
    return planes_++;
  }
  int planes() const { return planes_; }
  const S& shape(int plane, int k) const { return shapes_[plane * modes_ + k]; }

  /// Displacement (or velocity) of a plane; q holds the x coordinates, then the y coordinates.
  /// Always inline, as push() is: a pack returned through memory costs more than these products.
  [[gnu::always_inline]] Vec2<S> at(int plane, const S* q) const {
    const S* phi = &shapes_[plane * modes_];
    if (modes_ == 2)  // the rigid beam, the most frequent
      return {phi[0] * q[0] + phi[1] * q[1], phi[0] * q[2] + phi[1] * q[3]};
    Vec2<S> w{phi[0] * q[0], phi[0] * q[modes_]};
    for (int k = 1; k < modes_; ++k) {
      w.x += phi[k] * q[k];
      w.y += phi[k] * q[modes_ + k];
    }
    return w;
  }

  /// Adds a force at a plane to the generalised forces (size 2 modes()).
  [[gnu::always_inline]] void push(int plane, const Vec2<S>& force, S* generalised) const {
    const S* phi = &shapes_[plane * modes_];
    if (modes_ == 2) {
      generalised[0] += phi[0] * force.x;
      generalised[1] += phi[1] * force.x;
      generalised[2] += phi[0] * force.y;
      generalised[3] += phi[1] * force.y;
      return;
    }
    for (int k = 0; k < modes_; ++k) {
      generalised[k] += phi[k] * force.x;
      generalised[modes_ + k] += phi[k] * force.y;
    }
  }

  /// Called once all entries are set.
  void finish() {
    inverse_mass_.clear();
    for (const S& m : mass_) inverse_mass_.push_back(S(1.0) / m);
    has_gyroscopic_ = false;
    for (const S& g : gyroscopic_)
      for (std::size_t i = 0; i < ScalarTraits<S>::lanes; ++i)
        if (laneValue(g, i) != 0.0) has_gyroscopic_ = true;
    rigid_ = true;
    for (int k = 0; k < modes_; ++k)
      for (std::size_t i = 0; i < ScalarTraits<S>::lanes; ++i)
        if (laneValue(stiffness_[k], i) != 0.0 || laneValue(damping_[k], i) != 0.0) rigid_ = false;
  }

  /// accelerations = M^-1 (generalised forces - own stiffness, damping and gyroscopic forces).
  void accelerations(const S* q, const S* v, const S& speed, S* generalised, S* a) const {
    const int n = modes_;
    if (!rigid_)
      for (int k = 0; k < n; ++k) {
        generalised[k] -= stiffness_[k] * q[k] + damping_[k] * v[k];
        generalised[n + k] -= stiffness_[k] * q[n + k] + damping_[k] * v[n + k];
      }
    if (has_gyroscopic_)
      for (int k = 0; k < n; ++k)
        for (int l = 0; l < n; ++l) {
          const S g = gyroscopic_[k * n + l] * speed;
          generalised[k] -= g * v[n + l];
          generalised[n + k] += g * v[l];
        }
    for (int k = 0; k < n; ++k) {
      a[k] = inverse_mass_[k] * generalised[k];
      a[n + k] = inverse_mass_[k] * generalised[n + k];
    }
  }

 private:
  int modes_ = 0;
  int planes_ = 0;
  bool has_gyroscopic_ = false;
  bool rigid_ = true;
  std::vector<S> mass_, stiffness_, damping_, gyroscopic_, inverse_mass_, shapes_;
};

}  // namespace amb_rotor
