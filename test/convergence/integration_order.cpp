// Order of the event integrator by halving its step and its tolerance, smooth and through contact events.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "../support/hybrid_systems.hpp"

namespace amb_rotor {
namespace {

using testing_support::FloorBounce;
using testing_support::Smooth;

IntegratorOptions fixedStep(double h) {
  IntegratorOptions options;
  options.relative_tolerance = 1e6;  // every step is accepted, so the largest step is the step
  options.largest_step = h;
  options.first_step = h;
  return options;
}

IntegratorOptions byTolerance(double tolerance) {
  IntegratorOptions options;
  options.relative_tolerance = tolerance;
  options.absolute = {1e-2, 1e-1};
  return options;
}

/// A bounce with forces of every power, so that no stage is exact by accident.
FloorBounce bounce() {
  FloorBounce system;
  system.square = 30.0;
  system.cubic = 4000.0;
  system.damping = 12.0;
  return system;
}

struct End {
  double x, v;
  long touches;
};

End bounceEnd(const IntegratorOptions& options, double span = 1.0) {
  FloorBounce system = bounce();
  EventIntegrator integrator(system, options);
  double y[2] = {0.1, 0.3};
  EXPECT_EQ(integrator.advance(0.0, span, y).status, IntegrationStatus::ok);
  return {y[0], y[1], system.touches};
}

TEST(IntegrationOrder, FiveForASmoothMotion) {
  // Kepler ellipse of eccentricity 0.3 over one turn: returns to its start.
  double previous = 0.0;
  for (int halvings = 0; halvings < 4; ++halvings) {
    Smooth system(4, [](double, const double* y, double* r) {
      const double cube = std::pow(y[0] * y[0] + y[1] * y[1], 1.5);
      r[0] = y[2];
      r[1] = y[3];
      r[2] = -y[0] / cube;
      r[3] = -y[1] / cube;
    });
    const double start[4] = {0.7, 0.0, 0.0, std::sqrt(1.3 / 0.7)};
    double y[4] = {start[0], start[1], start[2], start[3]};
    const int steps = 100 << halvings;
    EventIntegrator integrator(system, fixedStep(2.0 * M_PI / steps));
    ASSERT_EQ(integrator.advance(0.0, 2.0 * M_PI, y).status, IntegrationStatus::ok);
    double error = 0.0;
    for (int i = 0; i < 4; ++i) error = std::max(error, std::fabs(y[i] - start[i]));
    // the limit is 5; at these steps the next order still shows by some tenths
    if (halvings > 0) {
      EXPECT_GT(std::log2(previous / error), 4.6) << steps;
    }
    previous = error;
  }
  EXPECT_LT(previous, 1e-8);
}

TEST(IntegrationOrder, FiveThroughContactEvents) {
  const End truth = bounceEnd(byTolerance(1e-13));
  ASSERT_GE(truth.touches, 3) << "the test is about contact";
  // The place of an event within a step moves as the step is halved, which makes the error of a single
  // halving uneven; over a factor of 16 the slope must still be near 5 (a method that steps over events has 1
  // to 2).
  std::vector<double> errors;
  for (int steps : {500, 1000, 2000, 4000, 8000}) {
    const End end = bounceEnd(fixedStep(1.0 / steps));
    EXPECT_EQ(end.touches, truth.touches) << steps;
    errors.push_back(std::hypot((end.x - truth.x) * 10.0, end.v - truth.v));
  }
  EXPECT_GT(std::log2(errors.front() / errors.back()) / 4.0, 4.3) << errors.front() << " " << errors.back();
  EXPECT_LT(errors.back(), 1e-8);
}

TEST(IntegrationOrder, ErrorThroughContactFallsWithTheTolerance) {
  const End truth = bounceEnd(byTolerance(1e-13));
  ASSERT_GE(truth.touches, 3);
  double previous = 1.0;
  for (double tolerance : {1e-5, 1e-7, 1e-9, 1e-11}) {
    const End end = bounceEnd(byTolerance(tolerance));
    EXPECT_EQ(end.touches, truth.touches);
    const double error = std::hypot((end.x - truth.x) * 10.0, end.v - truth.v);
    // tolerance of a step, about 300 steps, bounces that multiply errors by a few: a hundredfold and some
    EXPECT_LT(error, 1e3 * tolerance) << tolerance;
    EXPECT_LT(error, 0.2 * previous) << tolerance;
    previous = error;
  }
}

TEST(IntegrationOrder, DenseOutputHasOrderFour) {
  // sin(t) read at odd places inside steps of h and h/2: an interpolant of order 4 has a local error of h^5
  double previous = 0.0;
  for (int halvings = 0; halvings < 3; ++halvings) {
    const double h = 0.4 / (1 << halvings);
    Smooth system(2, [](double, const double* y, double* r) {
      r[0] = y[1];
      r[1] = -y[0];
    });
    EventIntegrator integrator(system, fixedStep(h));
    double worst = 0.0;
    long seen = 0;
    integrator.setObserver([&](double start, double end, const EventIntegrator::Dense& dense) {
      double out[2];
      for (double share : {0.0, 0.13, 0.37, 0.5, 0.71, 0.94, 1.0}) {
        const double t = start + share * (end - start);
        dense(t, out);
        worst = std::max(worst, std::fabs(out[0] - std::sin(t)));
        ++seen;
      }
    });
    double y[2] = {0.0, 1.0};
    ASSERT_EQ(integrator.advance(0.0, 2.0, y).status, IntegrationStatus::ok);
    EXPECT_GT(seen, 30);
    if (halvings > 0) {
      EXPECT_GT(std::log2(previous / worst), 4.2) << h;
    }
    previous = worst;
  }
}

TEST(IntegrationOrder, DenseOutputMeetsTheStepsEnds) {
  FloorBounce system = bounce();
  EventIntegrator integrator(system, byTolerance(1e-8));
  double y[2] = {0.1, 0.3}, last[2] = {0.1, 0.3};
  double last_time = 0.0;
  integrator.setObserver([&](double start, double end, const EventIntegrator::Dense& dense) {
    EXPECT_DOUBLE_EQ(start, last_time);
    double out[2];
    dense(start, out);
    // the same numbers up to the rounding of the interpolant's sums: its terms are a hundred times the state
    EXPECT_NEAR(out[0], last[0], 1e-14);
    EXPECT_NEAR(out[1], last[1], 1e-13);
    dense(end, out);
    last[0] = out[0];
    last[1] = out[1];
    last_time = end;
  });
  ASSERT_EQ(integrator.advance(0.0, 1.0, y).status, IntegrationStatus::ok);
  EXPECT_GE(system.touches, 3);
  EXPECT_NEAR(last[0], y[0], 1e-14);
}

}  // namespace
}  // namespace amb_rotor
