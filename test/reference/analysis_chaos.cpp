// Lyapunov exponents, winding numbers, jump matrix and regime on systems with published answers.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <complex>
#include <random>

#include "amb_rotor/analysis/determinism.hpp"
#include "amb_rotor/analysis/lyapunov.hpp"
#include "amb_rotor/analysis/regime.hpp"
#include "amb_rotor/common/error.hpp"

namespace amb_rotor {
namespace {

// ---- maps

bool henon(Eigen::VectorXd& s, Eigen::MatrixXd& tangent) {
  Eigen::Matrix2d jacobian;
  jacobian << -2.8 * s(0), 1.0, 0.3, 0.0;
  tangent = jacobian * tangent;
  s = Eigen::Vector2d(1.0 - 1.4 * s(0) * s(0) + s(1), 0.3 * s(0)).eval();
  return true;
}

std::vector<double> logistic(double r, int n) {
  std::vector<double> u(n);
  double x = 0.3141;
  for (int i = 0; i < 500; ++i) x = r * x * (1.0 - x);
  for (double& value : u) value = x = r * x * (1.0 - x);
  return u;
}

TEST(AnalysisChaos, HenonMap) {
  const LyapunovResult r = lyapunovBenettin(henon, Eigen::Vector2d(0.1, 0.1), 2, 1.0, 100000, 1000);
  ASSERT_TRUE(r.valid);
  // 0.41922 (Grassberger and others); standard error over 1e5 steps about 1.5e-3 by the spread of the
  // local exponents (0.5); four of them would be 6e-3, the anticorrelation makes it less.
  EXPECT_NEAR(r.exponents(0), 0.4192, 0.005);
  EXPECT_NEAR(r.exponents.sum(), std::log(0.3), 1e-10);  // det = -0.3 everywhere
  EXPECT_GT(r.standard_error, 1e-4);
  EXPECT_LT(r.standard_error, 4e-3);
}

TEST(AnalysisChaos, LogisticMapIsLnTwo) {
  const TangentFlow map = [](Eigen::VectorXd& s, Eigen::MatrixXd& tangent) {
    tangent *= 4.0 * (1.0 - 2.0 * s(0));
    s(0) = 4.0 * s(0) * (1.0 - s(0));
    return true;
  };
  const LyapunovResult r = lyapunovBenettin(map, Eigen::VectorXd::Constant(1, 0.3141), 1, 1.0, 100000, 100);
  ASSERT_TRUE(r.valid) << r.reason;
  // Conjugate to the tent map: telescoping local exponents, error about (spread of ln |x|)/n, well below
  // 1e-3.
  EXPECT_NEAR(r.exponents(0), std::log(2.0), 1e-3);
}

TEST(AnalysisChaos, FromASeries) {
  Eigen::VectorXd s = Eigen::Vector2d(0.1, 0.1);
  Eigen::MatrixXd unused = Eigen::MatrixXd::Identity(2, 2);
  std::vector<double> x;
  for (int i = 0; i < 2100; ++i) {
    unused.setIdentity();
    henon(s, unused);
    if (i >= 100) x.push_back(s(0));
  }
  // The exponent of HenonMap above; 10 % for a slope through few steps of 2000 values.
  const SeriesLyapunov h = lyapunovFromSeries(delayEmbedding(x, 2, 1));
  ASSERT_TRUE(h.valid) << h.reason;
  EXPECT_NEAR(h.exponent, 0.419, 0.042);
  const SeriesLyapunov l = lyapunovFromSeries(delayEmbedding(logistic(4.0, 1000), 1, 1));
  ASSERT_TRUE(l.valid) << l.reason;
  EXPECT_NEAR(l.exponent, std::log(2.0), 0.07);  // the same 10 %
  // Quasi-periodic: neighbours stay neighbours.
  std::vector<double> q;
  for (int i = 0; i < 1000; ++i) q.push_back(std::cos(2.0 * M_PI * 0.6180339887498949 * i));
  const SeriesLyapunov flat = lyapunovFromSeries(delayEmbedding(q, 2, 1));
  ASSERT_TRUE(flat.valid) << flat.reason;
  EXPECT_LT(std::fabs(flat.exponent), 0.005);
  // White noise: the distance jumps to its plateau at once, there is no exponent.
  std::mt19937 generator(5);
  std::normal_distribution<double> normal;
  for (double& value : q) value = normal(generator);
  EXPECT_FALSE(lyapunovFromSeries(delayEmbedding(q, 2, 1)).valid);
}

TEST(AnalysisChaos, ZeroOneTestAndForecast) {
  // K is near 1 for chaos (r = 4), near 0 for a periodic motion (r = 3.55, period 8).
  EXPECT_GT(zeroOneTest(logistic(4.0, 1000)), 0.95);
  EXPECT_LT(std::fabs(zeroOneTest(logistic(3.55, 1000))), 0.1);
  const auto ratio = [](const std::vector<double>& u) { return forecastRatio(delayEmbedding(u, 1, 1), 2); };
  EXPECT_LT(ratio(logistic(4.0, 500)), 0.1);
  std::mt19937 generator(5);
  std::normal_distribution<double> normal;
  std::vector<double> noise(500);
  for (double& value : noise) value = normal(generator);
  EXPECT_GT(zeroOneTest(noise), 0.9);   // noise grows like chaos here; the forecast tells them apart
  EXPECT_NEAR(ratio(noise), 1.0, 0.2);  // independent points; 500 of them, standard error of the ratio 4 %
  EXPECT_THROW(forecastRatio(delayEmbedding(noise, 1, 1), 0), InputError);
}

TEST(AnalysisChaos, CircleMap) {
  const auto lift = [](double omega, double k, int n) {
    std::vector<double> u = {0.1};
    for (int i = 0; i < n; ++i) {
      u.push_back(u.back() + omega - k / (2.0 * M_PI) * std::sin(2.0 * M_PI * u.back()));
    }
    return u;
  };
  EXPECT_NEAR(windingNumber(lift(0.3, 0.0, 100)), 0.3, 1e-13);
  // Locked on 1/2 in the tongue about 1/2; the transient's weight at the start is exp(-2000/n) and less.
  EXPECT_NEAR(windingNumber(lift(0.5, 0.9, 2000)), 0.5, 1e-10);
  // Shenker (1982): at K = 1 the golden mean belongs to Omega = 0.60666106347; slow convergence at
  // criticality.
  EXPECT_NEAR(windingNumber(lift(0.60666106347, 1.0, 10000)), 0.6180339887, 1e-6);
  // Points on a closed curve about a centre; the small divisor 2 * 0.489 - 1 = -0.022 wants 4000 of them.
  std::vector<double> x, y;
  for (int k = 0; k < 4000; ++k) {
    const double a = 2.0 * M_PI * 0.489 * k;
    x.push_back(3.0 + std::cos(a));
    y.push_back(-1.0 + 0.4 * std::sin(a));
  }
  EXPECT_NEAR(windingNumber(x, y, 3.0, -1.0), 0.489, 1e-9);
}

TEST(AnalysisChaos, CircleMapRegimes) {
  const auto regime = [](double omega) {
    RegimeInput input;
    input.clearance = 1.0;
    input.max_radius = 1.0;
    input.contact.contact_fraction = 0.3;
    double u = 0.1;
    for (int i = 0; i < 800; ++i) {
      u += omega - 0.9 / (2.0 * M_PI) * std::sin(2.0 * M_PI * u);
      PoincarePoint p;
      p.x = 0.6 * std::cos(2.0 * M_PI * u);
      p.y = 0.6 * std::sin(2.0 * M_PI * u);
      if (i >= 300) input.points.push_back(p);
    }
    return decideRegime(input, 0.01);
  };
  EXPECT_EQ(regime(0.5).regime, Regime::period);
  EXPECT_EQ(regime(0.5).period, 2);
  EXPECT_EQ(regime(0.0).period, 1);
  EXPECT_EQ(regime(0.6066).regime, Regime::quasi_periodic);
}

// ---- Duffing (Ueda): x'' + 0.05 x' + x^3 = 7.5 cos t

struct Duffing {
  static Eigen::Vector2d field(double t, const Eigen::Vector2d& s) {
    return {s(1), -0.05 * s(1) - s(0) * s(0) * s(0) + 7.5 * std::cos(t)};
  }
  static Eigen::Matrix2d jacobian(const Eigen::Vector2d& s) {
    Eigen::Matrix2d j;
    j << 0.0, 1.0, -3.0 * s(0) * s(0), -0.05;
    return j;
  }
  /// One period of the drive, Runge-Kutta of order 4 with 200 steps.
  static bool period(Eigen::VectorXd& state, Eigen::MatrixXd& tangent) {
    constexpr int steps = 200;
    constexpr double h = 2.0 * M_PI / steps;
    Eigen::Vector2d s = state;
    Eigen::MatrixXd q = tangent;
    for (int i = 0; i < steps; ++i) {
      const double t = i * h;
      const Eigen::Vector2d k1 = field(t, s);
      const Eigen::Vector2d s2 = s + 0.5 * h * k1;
      const Eigen::Vector2d k2 = field(t + 0.5 * h, s2);
      const Eigen::Vector2d s3 = s + 0.5 * h * k2;
      const Eigen::Vector2d k3 = field(t + 0.5 * h, s3);
      const Eigen::Vector2d s4 = s + h * k3;
      const Eigen::Vector2d k4 = field(t + h, s4);
      const Eigen::MatrixXd q1 = jacobian(s) * q;
      const Eigen::MatrixXd q2 = jacobian(s2) * (q + 0.5 * h * q1);
      const Eigen::MatrixXd q3 = jacobian(s3) * (q + 0.5 * h * q2);
      const Eigen::MatrixXd q4 = jacobian(s4) * (q + h * q3);
      s += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
      q += h / 6.0 * (q1 + 2.0 * q2 + 2.0 * q3 + q4);
    }
    state = s;
    tangent = q;
    return true;
  }
};

TEST(AnalysisChaos, DuffingOfUeda) {
  const LyapunovResult r =
      lyapunovBenettin(Duffing::period, Eigen::Vector2d(2.5, 0.0), 2, 2.0 * M_PI, 2000, 100);
  ASSERT_TRUE(r.valid) << r.reason;
  // Sprott (2003), table of driven systems: 0.1034, 0, -0.1534. 2000 periods: four standard errors.
  EXPECT_NEAR(r.exponents(0), 0.1034, 4.0 * r.standard_error + 1e-4);
  EXPECT_LT(r.standard_error, 0.003);
  // Divergence of the field is -0.05 everywhere; order 4 with h = 0.03: 1e-5.
  EXPECT_NEAR(r.exponents.sum(), -0.05, 1e-5);

  RegimeInput input;
  input.clearance = 4.0;
  input.max_radius = 8.0;
  input.contact.contact_fraction = 0.3;
  Eigen::VectorXd state = Eigen::Vector2d(2.5, 0.0);
  Eigen::MatrixXd tangent = Eigen::MatrixXd::Identity(2, 1);
  for (int i = 0; i < 400; ++i) {
    tangent.setIdentity();
    Duffing::period(state, tangent);
    PoincarePoint p;
    p.x = state(0);
    p.y = state(1);
    if (i >= 100) input.points.push_back(p);
  }
  EXPECT_EQ(decideRegime(input, 0.01).regime, Regime::chaotic);
}

// ---- bouncing ball

TEST(AnalysisChaos, JumpMatrixOfABallOnAFixedFloor) {
  const double g = 9.81, v = -3.0, e = 0.8;
  HybridEvent event;
  event.field_before = Eigen::Vector2d(v, -g);
  event.field_after = Eigen::Vector2d(-e * v, -g);
  event.normal = Eigen::Vector2d(1.0, 0.0);
  event.reset_jacobian = Eigen::Vector2d(1.0, -e).asDiagonal();
  const SaltationMatrix s = saltationMatrix(event);
  ASSERT_FALSE(s.grazing);
  Eigen::Matrix2d exact;  // by hand: the disturbed ball arrives dt = -dx/v later
  exact << -e, 0.0, -(1.0 + e) * g / v, -e;
  EXPECT_LT((s.matrix - exact).norm(), 1e-14);
  event.field_before(0) = 0.0;
  EXPECT_TRUE(saltationMatrix(event).grazing);
  event.normal.resize(3);
  EXPECT_THROW(saltationMatrix(event), InputError);
}

TEST(AnalysisChaos, JumpMatrixIsTheUnitMatrixForAContinuousField) {
  HybridEvent event;
  event.field_before = event.field_after = Eigen::Vector3d(1.0, 2.0, 3.0);
  event.normal = Eigen::Vector3d(0.5, -1.0, 0.2);
  EXPECT_LT((saltationMatrix(event).matrix - Eigen::Matrix3d::Identity()).norm(), 1e-15);
}

TEST(AnalysisChaos, JumpMatrixOfAMovingGuardEqualsTheExtendedState) {
  // Time as input (guard_rate, reset_rate) against time as a third state: the upper left block agrees.
  const double e = 0.6, amplitude = 1.2, phase = 0.7, u = -3.0;
  HybridEvent moving;
  moving.field_before = Eigen::Vector2d(u, -1.0);
  moving.field_after = Eigen::Vector2d(-e * u + (1.0 + e) * amplitude * std::cos(phase), -1.0);
  moving.normal = Eigen::Vector2d(1.0, 0.0);
  moving.guard_rate = -amplitude * std::cos(phase);
  moving.reset_jacobian = Eigen::Vector2d(1.0, -e).asDiagonal();
  moving.reset_rate = Eigen::Vector2d(0.0, -(1.0 + e) * amplitude * std::sin(phase));
  HybridEvent extended;
  extended.field_before = Eigen::Vector3d(u, -1.0, 1.0);
  extended.field_after = Eigen::Vector3d(moving.field_after(0), -1.0, 1.0);
  extended.normal = Eigen::Vector3d(1.0, 0.0, moving.guard_rate);
  extended.reset_jacobian = Eigen::Vector3d(1.0, -e, 1.0).asDiagonal();
  extended.reset_jacobian(1, 2) = moving.reset_rate(1);
  EXPECT_LT((saltationMatrix(moving).matrix - saltationMatrix(extended).matrix.topLeftCorner<2, 2>()).norm(),
            1e-14);
}

/// Monodromy matrix of the bounce locked to every k-th period of a table a sin t, g = 1, in (height, speed,
/// time).
Eigen::Matrix3d lockedBounce(double gamma, double e, int k) {
  const double cosine = M_PI * k * (1.0 - e) / ((1.0 + e) * gamma);
  const double sine = std::sqrt(1.0 - cosine * cosine);  // the branch that can be stable
  const double u = -M_PI * k;
  HybridEvent event;
  event.field_before = Eigen::Vector3d(u, -1.0, 1.0);
  event.field_after = Eigen::Vector3d(-u, -1.0, 1.0);
  event.normal = Eigen::Vector3d(1.0, 0.0, -gamma * cosine);
  event.reset_jacobian = Eigen::Vector3d(1.0, -e, 1.0).asDiagonal();
  event.reset_jacobian(1, 2) = -(1.0 + e) * gamma * sine;
  Eigen::Matrix3d flight = Eigen::Matrix3d::Identity();
  flight(0, 1) = 2.0 * M_PI * k;
  return saltationMatrix(event).matrix * flight;
}

TEST(AnalysisChaos, BouncingBallLosesItsPeriodWhereLuckAndMehtaSay) {
  for (int k : {1, 2}) {
    for (double e : {0.3, 0.5, 0.85}) {
      // Bouncing ball with a finite restitution (1993): flip at Gamma^2 = (k pi (1-e)/(1+e))^2 + (2 (1+e^2)/(1+e)^2)^2.
      const double published =
          std::hypot(k * M_PI * (1.0 - e) / (1.0 + e), 2.0 * (1.0 + e * e) / ((1.0 + e) * (1.0 + e)));
      double low = k * M_PI * (1.0 - e) / (1.0 + e) * (1.0 + 1e-9), high = low + 3.0;
      const auto flip = [&](double gamma) {
        return (lockedBounce(gamma, e, k) + Eigen::Matrix3d::Identity()).determinant();
      };
      ASSERT_LT(flip(low) * flip(high), 0.0);
      const double at_low = flip(low);
      for (int i = 0; i < 60; ++i) {
        const double middle = 0.5 * (low + high);
        (flip(middle) * at_low > 0.0 ? low : high) = middle;
      }
      EXPECT_NEAR(0.5 * (low + high), published, 1e-10);
      // The flow's direction has the multiplier 1.
      EXPECT_NEAR((lockedBounce(published, e, k) - Eigen::Matrix3d::Identity()).determinant(), 0.0, 1e-10);
    }
  }
}

TEST(AnalysisChaos, BenettinReportsWhatEndsIt) {
  const TangentFlow ends = [](Eigen::VectorXd&, Eigen::MatrixXd&) { return false; };
  const LyapunovResult r = lyapunovBenettin(ends, Eigen::Vector2d(0.0, 0.0), 1, 1.0, 10);
  EXPECT_FALSE(r.valid);
  EXPECT_FALSE(r.reason.empty());
  const TangentFlow vanishes = [](Eigen::VectorXd&, Eigen::MatrixXd& q) {
    q.setZero();
    return true;
  };
  EXPECT_FALSE(lyapunovBenettin(vanishes, Eigen::Vector2d(0.0, 0.0), 1, 1.0, 10).valid);
  EXPECT_THROW(lyapunovBenettin(ends, Eigen::Vector2d(0.0, 0.0), 3, 1.0, 10), InputError);
}

}  // namespace
}  // namespace amb_rotor
