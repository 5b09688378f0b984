#include "amb_rotor/machine/basic_annular_rub.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "amb_rotor/common/error.hpp"
#include "amb_rotor/common/linear_algebra.hpp"

namespace amb_rotor {
namespace {

struct Quadratic {
  double a, b, c;
  double discriminant() const { return b * b - 4.0 * a * c; }
};

double signedFriction(const BasicParameters<double>& p) { return p.friction_sign * p.friction; }

Quadratic radiusEquation(const BasicParameters<double>& p) {
  if (p.misalignment_x != 0.0 || p.misalignment_y != 0.0) {
    throw InputError(
        {{"", 0, "misalignment", "", "must be 0: the closed form is that of a centred bearing"}});
  }
  const double eta = p.frequency_ratio, alpha = p.contact_stiffness, s = signedFriction(p);
  const double k = p.support_stiffness + alpha - eta * eta, d = p.damping * eta + s * alpha;
  const double force = eta * eta * p.eccentricity;
  return {k * k + d * d, -2.0 * alpha * (k + s * d), alpha * alpha * (1.0 + s * s) - force * force};
}

BasicParameters<double> at(BasicParameters<double> p, double eta) {
  p.frequency_ratio = eta;
  return p;
}

}  // namespace

std::vector<double> annularRubRadii(const BasicParameters<double>& p) {
  const Quadratic q = radiusEquation(p);
  const double discriminant = q.discriminant();
  std::vector<double> radii;
  if (discriminant < 0.0 || q.a == 0.0) return radii;
  for (double sign : {-1.0, 1.0}) {
    const double radius = (-q.b + sign * std::sqrt(discriminant)) / (2.0 * q.a);
    if (radius >= 1.0) radii.push_back(radius);
  }
  return radii;
}

BasicState<double> annularRubState(const BasicParameters<double>& p, double radius) {
  const double eta = p.frequency_ratio, n = p.contact_stiffness * (1.0 - 1.0 / radius);
  const std::complex<double> stiffness(p.support_stiffness - eta * eta + n,
                                       p.damping * eta + signedFriction(p) * n);
  const std::complex<double> z = std::polar(eta * eta * p.eccentricity, p.unbalance_phase) / stiffness;
  const std::complex<double> v = std::complex<double>(0.0, eta) * z;
  return {z.real(), z.imag(), v.real(), v.imag()};
}

std::array<double, 5> annularRubPolynomial(const BasicParameters<double>& p, double radius) {
  const double eta = p.frequency_ratio, d = p.damping, s = signedFriction(p);
  const double n = p.contact_stiffness * (1.0 - 1.0 / radius), g = p.contact_stiffness / radius;
  const double tangential = p.support_stiffness - eta * eta + n, radial = tangential + g;
  const double b = d * eta + s * n, e = b + s * g;
  // (l^2 + d l + radial)(l^2 + d l + tangential) + (2 eta l + b)(2 eta l + e)
  return {1.0, 2.0 * d, radial + tangential + d * d + 4.0 * eta * eta,
          d * (radial + tangential) + 2.0 * eta * (b + e), radial * tangential + b * e};
}

std::vector<std::complex<double>> annularRubExponents(const BasicParameters<double>& p, double radius) {
  const auto c = annularRubPolynomial(p, radius);
  Eigen::Matrix4d companion = Eigen::Matrix4d::Zero();
  for (int i = 0; i < 4; ++i) companion(0, i) = -c[static_cast<std::size_t>(i) + 1];
  for (int i = 0; i < 3; ++i) companion(i + 1, i) = 1.0;
  const Eigen::Vector4cd roots = generalEigenvalues(companion);
  return {roots.data(), roots.data() + 4};
}

bool annularRubStable(const BasicParameters<double>& p, double radius) {
  for (const auto& exponent : annularRubExponents(p, radius)) {
    if (exponent.real() >= 0.0) return false;
  }
  return true;
}

std::vector<double> annularRubFolds(const BasicParameters<double>& p, double from, double to) {
  const auto discriminant = [&](double eta) { return radiusEquation(at(p, eta)).discriminant(); };
  constexpr int parts = 2000;
  std::vector<double> folds;
  for (int i = 0; i < parts; ++i) {
    double low = from + (to - from) * i / parts, high = from + (to - from) * (i + 1) / parts;
    const bool rising = discriminant(high) > 0.0;
    if (rising == (discriminant(low) > 0.0)) continue;
    for (int j = 0; j < 60; ++j) {
      const double middle = 0.5 * (low + high);
      ((discriminant(middle) > 0.0) == rising ? high : low) = middle;
    }
    const Quadratic q = radiusEquation(at(p, low));
    if (-q.b / (2.0 * q.a) >= 1.0) folds.push_back(low);
  }
  return folds;
}

double annularRubFrictionBorder(const BasicParameters<double>& given) {
  const auto stable = [&](double friction) {
    BasicParameters<double> p = given;
    p.friction = friction;
    const auto radii = annularRubRadii(p);
    return !radii.empty() && annularRubStable(p, radii.back());
  };
  if (!stable(0.0)) return 0.0;
  double low = 0.0, high = 0.0;
  for (double friction = 0.0005; friction <= 1.0 && high == 0.0; friction += 0.0005) {
    (stable(friction) ? low : high) = friction;
  }
  if (high == 0.0) return std::numeric_limits<double>::infinity();
  for (int i = 0; i < 50; ++i) {
    const double middle = 0.5 * (low + high);
    (stable(middle) ? low : high) = middle;
  }
  return low;
}

double frictionBorderWithoutClearance(const BasicParameters<double>& p) {
  return p.damping * std::sqrt(p.support_stiffness + p.contact_stiffness) / p.contact_stiffness;
}

}  // namespace amb_rotor
