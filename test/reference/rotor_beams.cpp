// The finite element rotor against closed forms of beams and rotors.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "amb_rotor/rotor/flexible_rotor.hpp"
#include "amb_rotor/rotor/reduction.hpp"
#include "amb_rotor/rotor/rotor_modes.hpp"

namespace amb_rotor {
namespace {

const double kPi = std::acos(-1.0);
constexpr double kLength = 0.5;     // [m]
constexpr double kDiameter = 0.03;  // [m]
constexpr int kElements = 30;
// Cubic elements: relative error (beta l)^4/1440 of mode beta; third mode of the free beam, beta L = 11, has
// beta l = 0.37 and 1.3e-5.
constexpr double kMesh = 2e-5;

FlexibleRotor uniform(BeamTheory theory, bool rotary, int count = kElements) {
  const Material steel{7850.0, 206e9, 0.3};
  std::vector<ShaftElement> elements(count, cylinder(kLength / count, kDiameter, 0.0, steel, theory));
  for (ShaftElement& element : elements) element.rotary_inertia = rotary;
  return FlexibleRotor(elements, {});
}

/// sqrt(E I/(rho A)) [m2/s]
double waveConstant() { return std::sqrt(206e9 / 7850.0) * kDiameter / 4.0; }

TEST(RotorBeams, FreeFree) {
  const FreeModes modes = freeModes(uniform(BeamTheory::euler_bernoulli, false));
  const double roots[] = {4.730040745, 7.853204624, 10.99560784};  // cos b cosh b = 1
  for (int i = 0; i < 3; ++i) {
    const double exact = waveConstant() * std::pow(roots[i] / kLength, 2);
    EXPECT_NEAR(modes.frequency(2 + i), exact, kMesh * exact) << i;
  }
}

TEST(RotorBeams, Cantilever) {
  const FlexibleRotor rotor = uniform(BeamTheory::euler_bernoulli, false);
  const Eigen::VectorXd found = constrainedFrequencies(rotor, {}, {rotor.left()});
  const double roots[] = {1.875104069, 4.694091133, 7.854757438};  // cos b cosh b = -1
  for (int i = 0; i < 3; ++i) {
    const double exact = waveConstant() * std::pow(roots[i] / kLength, 2);
    EXPECT_NEAR(found(i), exact, kMesh * exact) << i;
  }
}

TEST(RotorBeams, PinnedPinned) {
  const FlexibleRotor rotor = uniform(BeamTheory::euler_bernoulli, false);
  const Eigen::VectorXd found = constrainedFrequencies(rotor, {rotor.left(), rotor.right()}, {});
  for (int i = 0; i < 3; ++i) {
    const double exact = waveConstant() * std::pow((i + 1) * kPi / kLength, 2);
    EXPECT_NEAR(found(i), exact, kMesh * exact) << i;
  }
}

TEST(RotorBeams, PinnedTimoshenko) {
  // rho I rho/(k G) w^4 - (rho A + rho I (1 + E/(k G)) q^2) w^2 + E I q^4 = 0, q = n pi/L; the lower root.
  const FlexibleRotor rotor = uniform(BeamTheory::timoshenko, true);
  const FlexibleRotor finer = uniform(BeamTheory::timoshenko, true, 2 * kElements);
  const Eigen::VectorXd found = constrainedFrequencies(rotor, {rotor.left(), rotor.right()}, {});
  const Eigen::VectorXd fine = constrainedFrequencies(finer, {finer.left(), finer.right()}, {});
  const double area = kPi / 4.0 * kDiameter * kDiameter;
  const double moment = kPi / 64.0 * std::pow(kDiameter, 4);
  const double shear = hutchinsonShearFactor(0.0, 0.3) * 206e9 / 2.6;
  for (int i = 0; i < 4; ++i) {
    const double q = (i + 1) * kPi / kLength;
    const double a = 7850.0 * moment * 7850.0 / shear;
    const double b = 7850.0 * area + 7850.0 * moment * (1.0 + 206e9 / shear) * q * q;
    const double c = 206e9 * moment * std::pow(q, 4);
    const double exact = std::sqrt(2.0 * c / (b + std::sqrt(b * b - 4.0 * a * c)));
    // With constant shear in an element the order falls from 4 to 2, by the part that shear has in the mode:
    // (q^2 E I/(k G A)) (q l)^2/24 beside the cubic's own error.
    const double part = q * q * 206e9 * moment / (shear * area);
    const double mesh = part * std::pow(q * kLength / kElements, 2) / 24.0 + kMesh;
    EXPECT_NEAR(found(i), exact, mesh * exact) << i;
    if (i == 3) {
      // 4 for order 2.
      EXPECT_GT((found(i) - exact) / (fine(i) - exact), 3.5);
    }
    const double slender = waveConstant() * q * q;
    if (i == 3) {
      EXPECT_GT(slender / exact, 1.02) << "shear and rotary inertia must be visible";
    }
  }
}

TEST(RotorBeams, SpinningPinnedRayleighBeam) {
  // -(rho A + rho I q^2) w^2 + 2 rho I q^2 W w + E I q^4 = 0: forward; backward with -W. The pins are
  // springs of 1e12 N/m, five decades and more above the beam's own stiffness.
  const ReducedRotor rotor = allModes(uniform(BeamTheory::euler_bernoulli, true));
  const double speed = 20000.0;
  const RotorModes modes =
      rotorModes(rotor, {isotropicSupport(rotor.left(), 1e12), isotropicSupport(rotor.right(), 1e12)}, speed);
  const double area = kPi / 4.0 * kDiameter * kDiameter;
  const double moment = kPi / 64.0 * std::pow(kDiameter, 4);
  for (int i = 0; i < 2; ++i) {
    const double q2 = std::pow((i + 1) * kPi / kLength, 2);
    const double mass = 7850.0 * (area + moment * q2);
    const double half = 7850.0 * moment * q2 * speed / mass;
    const double root = std::sqrt(half * half + 206e9 * moment * q2 * q2 / mass);
    EXPECT_NEAR(modes.oscillating[2 * i].damped_frequency, root - half, 1e-4 * root) << i;
    EXPECT_NEAR(modes.oscillating[2 * i + 1].damped_frequency, root + half, 1e-4 * root) << i;
    EXPECT_EQ(modes.oscillating[2 * i].whirl, Whirl::backward);
    EXPECT_EQ(modes.oscillating[2 * i + 1].whirl, Whirl::forward);
    EXPECT_GT(half, 0.01 * root) << "the split must be a hundred tolerances";
  }
}

TEST(RotorBeams, StodolaDiscOnAnOverhungShaft) {
  // Rigid disc on a shaft without mass, bearings (springs k) at 0 and a, disc at a + c. Compliances at the
  // disc:
  //   w/F = c^2 (a+c)/(3 E I) + ((a+c)^2 + c^2)/(a^2 k)
  //   psi/F = w/M = c (2 a + 3 c)/(6 E I) + (a + 2 c)/(a^2 k)
  //   psi/M = (a + 3 c)/(3 E I) + 2/(a^2 k)
  // then det(A^-1 - w^2 diag(m, It) + W w diag(0, Ip)) = 0; negative roots are backward.
  const double a = 0.4;
  const double c = 0.1;
  const double k = 2e7;
  const double m = 5.0;
  const double polar = 0.04;
  const double transverse = 0.021;
  const FlexibleRotor shaft = [&] {
    const Material light{0.5, 206e9, 0.3};
    std::vector<ShaftElement> elements(
        20, cylinder(kLength / 20, kDiameter, 0.0, light, BeamTheory::euler_bernoulli));
    return FlexibleRotor(elements, {{a + c, m, polar, transverse}});
  }();
  const ReducedRotor rotor = allModes(shaft);
  const double bending = 206e9 * kPi / 64.0 * std::pow(kDiameter, 4);
  Eigen::Matrix2d compliance;
  compliance(0, 0) = c * c * (a + c) / (3.0 * bending) + ((a + c) * (a + c) + c * c) / (a * a * k);
  compliance(0, 1) = compliance(1, 0) =
      c * (2.0 * a + 3.0 * c) / (6.0 * bending) + (a + 2.0 * c) / (a * a * k);
  compliance(1, 1) = (a + 3.0 * c) / (3.0 * bending) + 2.0 / (a * a * k);
  const Eigen::Matrix2d stiffness = compliance.inverse();
  const double from_left = rotor.left();
  const std::vector<RotorSupport> supports = {isotropicSupport(from_left, k),
                                              isotropicSupport(from_left + a, k)};
  for (double speed : {0.0, 500.0, 2000.0}) {
    const RotorModes modes = rotorModes(rotor, supports, speed);
    for (int i = 0; i < 4; ++i) {
      const RotorMode& mode = modes.oscillating[i];
      const auto determinant = [&](double w) {
        return (stiffness(0, 0) - w * w * m) * (stiffness(1, 1) - w * w * transverse + speed * w * polar) -
               stiffness(0, 1) * stiffness(0, 1);
      };
      const double sign = mode.whirl == Whirl::backward ? -1.0 : 1.0;
      const double w = sign * mode.damped_frequency;
      // The shaft's 0.18 g against 5 kg: frequencies from 1e-5 too low. A change of sign within 1e-4 is a
      // root.
      EXPECT_LT(determinant(w * 0.9999) * determinant(w * 1.0001), 0.0) << speed << " " << i;
      if (speed > 0.0) {
        EXPECT_NE(mode.whirl, Whirl::planar);
      }
    }
  }
}

TEST(RotorBeams, CriticalSpeedsOfTheStodolaDisc) {
  // Thin disc, Ip > It: one forward critical speed, where the Campbell line of the first mode meets the spin.
  const Material steel{7850.0, 206e9, 0.3};
  std::vector<ShaftElement> elements(10, cylinder(0.05, kDiameter, 0.0, steel));
  const ReducedRotor rotor = allModes(FlexibleRotor(elements, {{0.5, 5.0, 0.04, 0.021}}));
  const std::vector<RotorSupport> supports = {isotropicSupport(rotor.left(), 2e7),
                                              isotropicSupport(rotor.left() + 0.4, 2e7)};
  for (int i = 0; i < 3; ++i) {
    const CriticalSpeed critical = criticalSpeeds(rotor, supports)[i];
    double nearest = 1e9;
    for (const RotorMode& mode : rotorModes(rotor, supports, critical.speed).oscillating) {
      if (mode.whirl == critical.whirl) {
        nearest = std::min(nearest, std::abs(mode.damped_frequency - critical.speed));
      }
    }
    // Two eigenvalue problems of the same matrices: round-off of a model that spans six decades.
    EXPECT_LT(nearest, 1e-6 * critical.speed);
  }
}

}  // namespace
}  // namespace amb_rotor
