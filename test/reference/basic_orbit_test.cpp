// The motion of the basic model by Taylor series against Boost.odeint, closed forms and itself at other
// tolerances.
#include "amb_rotor/machine/basic_orbit.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <boost/numeric/odeint.hpp>
#include <cmath>

#include "amb_rotor/common/units.hpp"

namespace amb_rotor {
namespace {

BasicParameters<double> displaced() {
  BasicParameters<double> p;
  p.frequency_ratio = 1.05;
  p.misalignment_x = 0.65;
  p.misalignment_y = -0.1;
  p.friction = 0.05;
  return p;
}

const BasicState<double> start{0.1, -0.2, 0.3, 0.1};

double distance(const BasicState<double>& a, const BasicState<double>& b) {
  return std::hypot(std::hypot(a.x - b.x, a.y - b.y), std::hypot(a.vx - b.vx, a.vy - b.vy));
}

TEST(BasicTaylor, EndsWhereAnIndependentIntegratorEnds) {
  using State = std::array<double, 4>;
  using namespace boost::numeric::odeint;
  using Model = BasicModel<LinearContact, SpinFriction>;
  constexpr int turns = 10;
  const auto p = displaced();
  const auto c = basicCoefficients<LinearContact>(p, 1.0);
  const double eta = p.frequency_ratio;
  State q{start.x, start.y, start.vx, start.vy};
  const auto rate = [&](const State& s, State& out, double t) {
    out[0] = s[2];
    out[1] = s[3];
    Model::acceleration(c, c.forcing * std::cos(eta * t), c.forcing * std::sin(eta * t), s[0], s[1], s[2],
                        s[3], out[2], out[3]);
  };
  integrate_adaptive(make_controlled(1e-13, 1e-13, runge_kutta_dopri5<State>()), rate, q, 0.0,
                     turns * two_pi / eta, 1e-3);
  BasicOrbitOptions options;
  options.tolerance = 1e-13;
  const BasicOrbit orbit = advanceBasic(p, start, turns, options);
  EXPECT_GE(orbit.touch_downs, turns) << "the test is about contact";
  // 1e-13 a step, some 1e4 steps of the other program over kinks, a motion that multiplies differences by ten
  // or so
  EXPECT_LT(distance(orbit.end, {q[0], q[1], q[2], q[3]}), 1e-9);
}

TEST(BasicTaylor, ErrorFallsWithTheTolerance) {
  BasicOrbitOptions options;
  options.tolerance = 1e-14;
  const BasicOrbit truth = advanceBasic(displaced(), start, 10, options);
  ASSERT_GE(truth.touch_downs, 10);
  double previous = 1.0;
  for (double tolerance : {1e-5, 1e-7, 1e-9, 1e-11}) {
    options.tolerance = tolerance;
    const BasicOrbit orbit = advanceBasic(displaced(), start, 10, options);
    EXPECT_EQ(orbit.touch_downs, truth.touch_downs);
    const double error = distance(orbit.end, truth.end);
    EXPECT_LT(error, 1e3 * tolerance) << tolerance;  // a hundred steps, differences multiplied by ten or so
    EXPECT_LT(error, 0.2 * previous) << tolerance;
    previous = error;
  }
}

TEST(BasicTaylor, EventsLieOnTheClearance) {
  const auto p = displaced();
  BasicOrbitOptions options;
  int events = 0;
  bool was = false;
  advanceBasic(p, start, 10, options, [&](double, const BasicState<double>& s, bool contact) {
    const double gap = std::hypot(s.x - p.misalignment_x, s.y - p.misalignment_y) - 1.0;
    if (contact != was) {
      ++events;
      EXPECT_NEAR(gap, 0.0, 1e-13);  // round-off of a polynomial's root and of the turned axes
    } else {
      EXPECT_GT(contact ? gap : -gap, -1e-13) << "a point on the wrong side";
    }
    was = contact;
  });
  EXPECT_GE(events, 20);
}

/// Its flights get shorter from bounce to bounce, until it stays in contact.
BasicParameters<double> settling() {
  BasicParameters<double> p;
  p.frequency_ratio = 1.05;
  return p;
}

TEST(BasicTaylor, AFlightShorterThanASampleEndsWhereItTouches) {
  // it begins at a root of the gap, too, which is not the one that ends it
  BasicOrbitOptions options;
  int touched = 0;
  for (int i = 1; i <= 60; ++i) {
    // turned, so that round-off leaves gaps of either sign
    const double inwards = 5e-4 * i, around = 1.3, c = std::cos(0.1 * i), d = std::sin(0.1 * i);
    bool was = true;
    double lifted = 0.0;
    const BasicOrbit orbit =
        advanceBasic(settling(), {c, d, -inwards * c - around * d, around * c - inwards * d}, 1, options,
                     [&](double phase, const BasicState<double>& s, bool contact) {
                       const double gap = std::hypot(s.x, s.y) - 1.0;
                       if (contact == was) {
                         EXPECT_GT(contact ? gap : -gap, -1e-13) << inwards << " at " << phase;
                       }
                       if (contact && !was && phase - lifted < 0.1) ++touched;
                       if (!contact && was) lifted = phase;
                       was = contact;
                     });
    EXPECT_TRUE(orbit.finite);
    EXPECT_LT(orbit.steps, 100);
  }
  EXPECT_GT(touched, 50) << "the test is about flights shorter than the distance of samples";
}

TEST(BasicTaylor, ARubThatSettlesIsAsAccurateAsItsTolerance) {
  BasicOrbitOptions options;
  options.tolerance = 5e-14;
  const BasicOrbit truth = advanceBasic(settling(), {1.0, 0.0, 0.0, 0.0}, 300, options);
  for (double tolerance : {1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12}) {
    options.tolerance = tolerance;
    // what bounces multiply is damped where it stays in contact
    EXPECT_LT(distance(advanceBasic(settling(), {1.0, 0.0, 0.0, 0.0}, 300, options).end, truth.end),
              100.0 * tolerance);
  }
}

TEST(BasicTaylor, TheLargestRadiusOfAContactIsSeenInsideItsSteps) {
  BasicOrbitOptions options;
  options.tolerance = 1e-8;
  const BasicState<double> settled = advanceBasic(settling(), {1.0, 0.0, 0.0, 0.0}, 300, options).end;
  for (int i = 0; i < 20; ++i) {
    BasicState<double> pushed = settled;
    pushed.vx += 0.003 * std::cos(0.3 * i);
    pushed.vy += 0.003 * std::sin(0.3 * i);
    double largest = 0.0, smallest = 2.0;
    const BasicOrbit orbit =
        advanceBasic(settling(), pushed, 2, options, [&](double, const BasicState<double>& s, bool) {
          largest = std::max(largest, std::hypot(s.x, s.y));
          smallest = std::min(smallest, std::hypot(s.x, s.y));
        });
    ASSERT_EQ(orbit.contact_fraction, 1.0) << "the test is about contact";
    // samples are a fifteenth of the contact's own period apart
    EXPECT_NEAR(orbit.max_radius, largest, 0.03 * (largest - smallest)) << i;
  }
}

TEST(BasicTaylor, AGrazingTouchIsSeenInsideAStepAndAMissIsNone) {
  // x = A sin t without damping, unbalance and friction: reaches the clearance where A > 1.
  BasicParameters<double> p;
  p.damping = p.eccentricity = p.friction = 0.0;
  for (double excess : {-1e-3, -1e-9, 1e-9, 1e-6, 1e-3}) {
    for (double eta : {0.7, 1.0, 3.1}) {  // moves the apex about in the steps
      p.frequency_ratio = eta;
      const int turns = static_cast<int>(std::ceil(eta));
      const BasicOrbit orbit = advanceBasic(p, {0.0, 0.0, 1.0 + excess, 0.0}, turns, {});
      const double span = turns * two_pi / eta;
      if (excess > 0.0) {
        // a touch each half period, which the contact's own stiffness shortens a little
        EXPECT_NEAR(orbit.touch_downs, span / pi, 1.0) << excess << " " << eta;
        EXPECT_EQ(orbit.largest_free_radius, 0.0);
      } else {
        EXPECT_EQ(orbit.touch_downs, 0) << excess << " " << eta;
        EXPECT_NEAR(orbit.largest_free_radius, 1.0 + excess, 1e-11);  // tolerance 1e-10 a step, few steps
      }
    }
  }
}

TEST(BasicTaylor, DampedFlightFollowsTheClosedForm) {
  BasicParameters<double> p;
  p.frequency_ratio = 1.3;
  p.eccentricity = 0.0;
  const double d = p.damping, w = std::sqrt(1.0 - 0.25 * d * d), t = 7 * two_pi / p.frequency_ratio;
  const BasicOrbit orbit = advanceBasic(p, {0.5, 0.0, 0.0, 0.2}, 7, {});
  const double decay = std::exp(-0.5 * d * t);
  EXPECT_NEAR(orbit.end.x, 0.5 * decay * (std::cos(w * t) + 0.5 * d / w * std::sin(w * t)), 1e-8);
  EXPECT_NEAR(orbit.end.y, 0.2 * decay / w * std::sin(w * t), 1e-8);  // 1e-10 a step, some 20 steps
  EXPECT_LT(orbit.steps, 60) << "a linear flight takes long steps";
}

}  // namespace
}  // namespace amb_rotor
