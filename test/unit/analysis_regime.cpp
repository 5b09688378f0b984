// Each regime's detector on motions whose kind is known.
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <functional>
#include <random>

#include "amb_rotor/analysis/regime.hpp"
#include "amb_rotor/common/error.hpp"

namespace amb_rotor {
namespace {

constexpr double clearance = 2e-4;
constexpr double tolerance = 0.01;

/// Points z(k) in clearances with normal noise of a given size an axis; contact now and then.
RegimeInput inputOf(int count, const std::function<std::complex<double>(int)>& z, double noise = 0.0,
                    unsigned seed = 1) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal;
  RegimeInput input;
  input.clearance = clearance;
  input.max_radius = 1.05 * clearance;
  input.spin = 500.0;
  input.contact.contact_fraction = 0.2;
  input.contact.impacts = 100;
  for (int k = 0; k < count; ++k) {
    PoincarePoint p;
    p.index = k;
    p.x = clearance * (z(k).real() + noise * normal(generator));
    p.y = clearance * (z(k).imag() + noise * normal(generator));
    input.points.push_back(p);
  }
  return input;
}

/// n different points, none of a shorter period.
std::complex<double> cycle(int n, int k) { return std::polar(0.5 + 0.03 * (k % n), 2.4 * (k % n)); }

TEST(AnalysisRegime, EveryPeriodToSixteenWithAThousandthOfNoise) {
  for (int n = 1; n <= 16; ++n) {
    for (unsigned seed = 0; seed < 20; ++seed) {
      const RegimeResult r = decideRegime(inputOf(
                                              100, [n](int k) { return cycle(n, k); }, 1e-3, seed),
                                          tolerance);
      EXPECT_EQ(r.regime, Regime::period) << n << " " << r.reason;
      EXPECT_EQ(r.period, n);
      EXPECT_TRUE(r.certain);
      // 2 s for noise of s an axis; standard error of an rms of 160 to 200 numbers about 6 %, five of them.
      EXPECT_NEAR(r.repeat_error, 2e-3, 6e-4);
    }
  }
}

TEST(AnalysisRegime, PeriodSeventeenDoesNotRepeatWithinSixteen) {
  const PeriodDetection d = detectPeriod(
      [] {
        Eigen::MatrixXd m(2, 200);
        for (int k = 0; k < 200; ++k) m.col(k) << cycle(17, k).real(), cycle(17, k).imag();
        return m;
      }(),
      tolerance);
  EXPECT_EQ(d.period, 0);
}

TEST(AnalysisRegime, SmallSplitOfAPeriodDoublingAboveTheNoise) {
  // Two points 0.8 % of the clearance apart: inside the tolerance, yet told apart from noise of 0.1 %.
  const auto split = [](int k) { return std::complex<double>(0.5 + (k % 2 ? 0.008 : 0.0), 0.1); };
  EXPECT_EQ(decideRegime(inputOf(200, split, 1e-3), tolerance).period, 2);
  // 0.1 % apart: one point for this tolerance, by choice; two for a finer one without noise.
  const auto fine = [](int k) { return std::complex<double>(0.5 + (k % 2 ? 0.001 : 0.0), 0.1); };
  EXPECT_EQ(decideRegime(inputOf(200, fine), tolerance).period, 1);
  EXPECT_EQ(decideRegime(inputOf(200, fine), 1e-4).period, 2);
}

TEST(AnalysisRegime, QuasiPeriodic) {
  const double golden = 0.6180339887498949;
  for (double noise : {0.0, 1e-3}) {
    const RegimeResult r =
        decideRegime(inputOf(
                         300,
                         [golden](int k) {
                           return std::complex<double>(0.3, 0.1) + std::polar(0.4, 2.0 * M_PI * golden * k);
                         },
                         noise),
                     tolerance);
    EXPECT_EQ(r.regime, Regime::quasi_periodic) << r.reason;
    EXPECT_EQ(r.period, 0);
    // Golden mean less a whole turn; noise of 0.0025 rad in the angle weighs little over 300 points.
    EXPECT_NEAR(r.winding_number, golden - 1.0, noise > 0.0 ? 1e-4 : 1e-9);
  }
}

TEST(AnalysisRegime, SlowDriftRoundAClosedCurveIsNoPeriod) {
  // 0.4 * 2 pi * 0.002 = 0.005 of the clearance a turn: within the tolerance from turn to turn.
  const RegimeResult r =
      decideRegime(inputOf(300, [](int k) { return std::polar(0.4, 2.0 * M_PI * 0.00201 * k); }), tolerance);
  EXPECT_NE(r.regime, Regime::period) << r.period;
}

TEST(AnalysisRegime, HenonPointsAreChaotic) {
  double x = 0.1, y = 0.1;
  const auto henon = [&](int) {
    const double next = 1.0 - 1.4 * x * x + y;
    y = 0.3 * x;
    x = next;
    return std::complex<double>(0.5 * x, 0.5 * y);
  };
  for (double noise : {0.0, 1e-3}) {
    const RegimeResult r = decideRegime(inputOf(300, henon, noise), tolerance);
    EXPECT_EQ(r.regime, Regime::chaotic) << r.reason;
    EXPECT_EQ(r.period, 0);
    EXPECT_TRUE(r.certain);
  }
}

TEST(AnalysisRegime, NoiseIsNotChaos) {
  for (unsigned seed = 0; seed < 10; ++seed) {
    // Noise of 5 % of the clearance: above the tolerance.
    const RegimeResult one =
        decideRegime(inputOf(
                         300, [](int) { return std::complex<double>(0.5, 0.0); }, 0.05, seed),
                     tolerance);
    EXPECT_EQ(one.regime, Regime::period) << one.reason;
    EXPECT_EQ(one.period, 1);
    EXPECT_FALSE(one.certain);
    EXPECT_NEAR(one.scatter, 0.05 * std::sqrt(2.0), 0.01);  // rms of 600 numbers: 3 %; five of them
    const RegimeResult three = decideRegime(inputOf(
                                                300, [](int k) { return cycle(3, k); }, 0.03, seed),
                                            tolerance);
    EXPECT_EQ(three.regime, Regime::period) << three.reason;
    EXPECT_EQ(three.period, 3);
    EXPECT_FALSE(three.certain);
  }
}

TEST(AnalysisRegime, TheCallersExponentDecides) {
  RegimeInput input = inputOf(40, [](int k) { return std::polar(0.4, 2.0 * M_PI * 0.6180339887498949 * k); });
  EXPECT_EQ(decideRegime(input, tolerance).regime, Regime::undecided);  // 40 points are too few alone
  input.largest_lyapunov = 0.2;
  EXPECT_EQ(decideRegime(input, tolerance).regime, Regime::chaotic);
  input.largest_lyapunov = 0.0;
  EXPECT_EQ(decideRegime(input, tolerance).regime, Regime::quasi_periodic);
}

TEST(AnalysisRegime, NoContactFullRubAndDryWhirl) {
  RegimeInput input = inputOf(50, [](int) { return std::complex<double>(1.05, 0.0); });
  input.contact.contact_fraction = 0.0;
  input.contact.impacts = 0;
  EXPECT_EQ(decideRegime(input, tolerance).regime, Regime::no_contact);
  EXPECT_EQ(decideRegime(input, tolerance).period, 1);

  input.contact.contact_fraction = 1.0;
  input.whirl.direction = WhirlDirection::forward;
  input.whirl.frequency = input.spin;
  input.whirl.forward_share = 1.0;
  input.whirl.mean_radius = 1.05 * clearance;
  EXPECT_EQ(decideRegime(input, tolerance).regime, Regime::full_annular_rub);
  // Pressed on at one side, not going round: period 1 only.
  input.whirl.direction = WhirlDirection::none;
  input.whirl.frequency = 0.0;
  EXPECT_EQ(decideRegime(input, tolerance).regime, Regime::period);

  input.whirl.direction = WhirlDirection::backward;
  input.whirl.forward_share = 0.0;
  input.whirl.frequency = -1500.0;
  input.rotor_radius = 0.012;
  EXPECT_EQ(decideRegime(input, tolerance).regime, Regime::dry_whirl);
  EXPECT_EQ(decideRegime(input, tolerance).slip, SlipKind::slipping);
  input.whirl.frequency = -input.rotor_radius * input.spin / input.whirl.mean_radius;
  EXPECT_EQ(decideRegime(input, tolerance).slip, SlipKind::rolling);
  input.whirl.resolved = false;  // the direction may be aliased: no dry whirl on that ground
  EXPECT_NE(decideRegime(input, tolerance).regime, Regime::dry_whirl);
}

TEST(AnalysisRegime, DivergedTooFewAndBadInput) {
  RegimeInput input = inputOf(50, [](int k) { return std::complex<double>(k == 40 ? NAN : 0.1, 0.0); });
  EXPECT_EQ(decideRegime(input, tolerance).regime, Regime::diverged);
  input = inputOf(50, [](int) { return std::complex<double>(0.1, 0.0); });
  input.max_radius = 11.0 * clearance;
  EXPECT_EQ(decideRegime(input, tolerance).regime, Regime::diverged);
  input = inputOf(3, [](int) { return std::complex<double>(0.1, 0.0); });
  EXPECT_EQ(decideRegime(input, tolerance).regime, Regime::undecided);
  EXPECT_FALSE(decideRegime(input, tolerance).certain);
  EXPECT_THROW(decideRegime(input, 0.0), InputError);
  input.clearance = 0.0;
  EXPECT_THROW(decideRegime(input, tolerance), InputError);
  EXPECT_EQ(toString(Regime::full_annular_rub), "full_annular_rub");
  EXPECT_EQ(toString(Regime::quasi_periodic), "quasi_periodic");
}

}  // namespace
}  // namespace amb_rotor
