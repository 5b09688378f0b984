// What the event integrator must keep whatever the system: energy, count of events, typed results, no
// allocation.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <limits>
#include <new>

#include "../support/hybrid_systems.hpp"
#include "../support/models.hpp"
#include "amb_rotor/machine/basic_orbit.hpp"
#include "amb_rotor/machine/modal_stepper.hpp"

namespace {
std::atomic<long> allocations{0};

void* counted(std::size_t size) {
  ++allocations;
  void* block = std::malloc(size > 0 ? size : 1);
  if (block == nullptr) throw std::bad_alloc();
  return block;
}
}  // namespace

// This executable counts its allocations.
void* operator new(std::size_t size) { return counted(size); }
void* operator new[](std::size_t size) { return counted(size); }
void operator delete(void* block) noexcept { std::free(block); }
void operator delete[](void* block) noexcept { std::free(block); }
void operator delete(void* block, std::size_t) noexcept { std::free(block); }
void operator delete[](void* block, std::size_t) noexcept { std::free(block); }

namespace amb_rotor {
namespace {

using namespace testing_support;

IntegratorOptions tight(double tolerance = 1e-10) {
  IntegratorOptions options;
  options.relative_tolerance = tolerance;
  options.absolute = {1e-3, 1e-1};
  return options;
}

TEST(IntegrationProperty, EnergyIsKeptOverTenThousandImpacts) {
  FloorBounce system;
  EventIntegrator integrator(system, tight());
  double y[2] = {0.02, 0.0};
  const double before = system.energy(y);
  double time = 0.0;
  while (system.touches < 10000) {
    const auto result = integrator.advance(time, time + 10.0, y);
    ASSERT_EQ(result.status, IntegrationStatus::ok) << result.reason();
    time = result.time;
  }
  // 1e-10 of the state a step, some 30 steps an impact: systematic drift of 1e-10 an impact would be 1e-6
  EXPECT_NEAR(system.energy(y) / before, 1.0, 1e-6);
  // and nothing but the two events of each impact: a mode that flips back and forth would count more
  EXPECT_LE(std::labs(integrator.statistics().events - 2 * system.touches), 1);
}

TEST(IntegrationProperty, BouncesFollowTheClosedForm) {
  // Free fall from h, then a half wave of the spring about its loaded rest: x = -(g/w^2)(1 - cos wt) - v/w
  // sin wt.
  FloorBounce system;
  const double height = 0.02, g = system.gravity, w = std::sqrt(system.stiffness);
  const double fall = std::sqrt(2.0 * height / g), v = g * fall;
  const double contact = 2.0 / w * (M_PI - std::atan(v * w / g));
  const double period = 2.0 * fall + contact;
  EventIntegrator integrator(system, tight(1e-12));
  double y[2] = {height, 0.0};
  const double end = fall + 0.3 * contact + 37.0 * period;
  ASSERT_EQ(integrator.advance(0.0, end, y).status, IntegrationStatus::ok);
  ASSERT_EQ(system.touches, 38);
  const double t = 0.3 * contact;
  // 38 periods at 1e-12 a step: the errors are a phase that grows evenly, below 1e-9 of the amplitudes
  EXPECT_NEAR(y[0], -(g / (w * w)) * (1.0 - std::cos(w * t)) - v / w * std::sin(w * t), 1e-9 * v / w * 10);
  EXPECT_NEAR(y[1], -(g / w) * std::sin(w * t) - v * std::cos(w * t), 1e-8 * v);
}

/// A ball thrown at a ceiling at x = 0 (from below) so that it just reaches or misses it.
struct Graze final : HybridSystem {
  int mode = 0;
  long touches = 0;
  int size() const override { return 2; }
  int guards() const override { return 1; }
  void derivatives(double, const double* y, double* rate) const override {
    rate[0] = y[1];
    rate[1] = -9.81 - (mode == 1 ? 1e6 * y[0] : 0.0);
  }
  void guardValues(double, const double* y, double* guard) const override {
    guard[0] = mode == 1 ? y[0] : -y[0];
  }
  void onEvent(int, double, double*) override {
    mode = 1 - mode;
    touches += mode;
  }
};

TEST(IntegrationProperty, AGrazingContactIsSeenInsideAStep) {
  // Apex above the ceiling by a millionth to a tenth of the height, wherever in the step it falls: free
  // flight is a parabola that the method integrates exactly, so its steps would be as long as they may.
  for (double excess : {1e-6, 1e-4, 1e-2, 1e-1}) {
    for (double span : {0.17, 0.23, 0.4, 1.0}) {
      Graze system;
      EventIntegrator integrator(system, tight());
      const double depth = 0.05, v = std::sqrt(2.0 * 9.81 * depth * (1.0 + excess));
      double y[2] = {-depth, v};
      ASSERT_EQ(integrator.advance(0.0, span, y).status, IntegrationStatus::ok);
      EXPECT_EQ(system.touches, 1) << "excess " << excess << " span " << span;
      EXPECT_EQ(system.mode, 0);
    }
  }
}

TEST(IntegrationProperty, AGrazingMissIsNoContact) {
  for (double lack : {1e-6, 1e-3}) {
    Graze system;
    EventIntegrator integrator(system, tight());
    const double depth = 0.05, v = std::sqrt(2.0 * 9.81 * depth * (1.0 - lack));
    double y[2] = {-depth, v};
    ASSERT_EQ(integrator.advance(0.0, 0.4, y).status, IntegrationStatus::ok);
    EXPECT_EQ(system.touches, 0) << lack;
    EXPECT_NEAR(y[0], -depth + v * 0.4 - 0.5 * 9.81 * 0.16, 1e-12);
  }
}

TEST(IntegrationProperty, StepLimitIsATypedResult) {
  FloorBounce system;
  IntegratorOptions options = tight();
  options.step_limit = 20;
  EventIntegrator integrator(system, options);
  double y[2] = {0.02, 0.0};
  const auto result = integrator.advance(0.0, 100.0, y);
  EXPECT_EQ(result.status, IntegrationStatus::step_limit);
  EXPECT_GT(result.time, 0.0);
  EXPECT_LT(result.time, 100.0);
  EXPECT_FALSE(result.reason().empty());
  EXPECT_TRUE(std::isfinite(y[0]));
}

TEST(IntegrationProperty, EventLimitIsATypedResult) {
  FloorBounce system;
  IntegratorOptions options = tight();
  options.event_limit = 7;
  EventIntegrator integrator(system, options);
  double y[2] = {0.02, 0.0};
  EXPECT_EQ(integrator.advance(0.0, 100.0, y).status, IntegrationStatus::event_limit);
}

TEST(IntegrationProperty, ASingularMotionIsATypedResult) {
  // x' = x^2 from 1 is infinite at t = 1
  Smooth system(1, [](double, const double* y, double* r) { r[0] = y[0] * y[0]; });
  IntegratorOptions options;
  EventIntegrator integrator(system, options);
  double y[1] = {1.0};
  const auto result = integrator.advance(0.0, 2.0, y);
  EXPECT_NE(result.status, IntegrationStatus::ok);
  EXPECT_NEAR(result.time, 1.0, 1e-6);
}

TEST(IntegrationProperty, NotANumberIsATypedResult) {
  Smooth late(1, [](double t, const double*, double* r) {
    r[0] = t < 0.5 ? 1.0 : std::numeric_limits<double>::quiet_NaN();
  });
  EventIntegrator integrator(late, {});
  double y[1] = {0.0};
  const auto result = integrator.advance(0.0, 1.0, y);
  EXPECT_EQ(result.status, IntegrationStatus::not_finite) << result.reason();
  EXPECT_LE(result.time, 0.5 + 1e-9);
  EXPECT_TRUE(std::isfinite(y[0])) << "the state before the fault is kept";

  Smooth plain(1, [](double, const double* state, double* r) { r[0] = -state[0]; });
  EventIntegrator second(plain, {});
  y[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(second.advance(0.0, 1.0, y).status, IntegrationStatus::not_finite);
}

TEST(IntegrationProperty, NoAllocationInAStep) {
  FloorBounce system;
  EventIntegrator integrator(system, tight());
  double y[2] = {0.02, 0.0};
  const long before = allocations;
  integrator.advance(0.0, 5.0, y);
  EXPECT_EQ(allocations - before, 0);
  EXPECT_GE(system.touches, 10);
}

TEST(IntegrationProperty, NoAllocationInARunOfTheBasicModel) {
  BasicParameters<double> p;
  p.frequency_ratio = 1.05;
  const BasicOrbitOptions options;
  const BasicState<double> start{1.0, 0.0, 0.0, 0.0};
  const long before = allocations;
  const BasicOrbit orbit = advanceBasic(p, start, 20, options);
  EXPECT_EQ(allocations - before, 0);
  EXPECT_GE(orbit.touch_downs, 5);
}

TEST(IntegrationProperty, NoAllocationInTheModalStepper) {
  // With compliant mounts and a released rotor: flights, touch-downs, lift-offs and steps in contact.
  Model model = withUnbalance(with(springBeam(), "compliant_mount", typicalValues("compliant_mount")), 1e-5);
  model.rig.gravity_m_s2 = 9.81;
  const Machine<double> machine({&model});
  Drive<double> drive;
  drive.speed = 300.0;
  const Simulator<double> sim(machine, drive, 0.0);
  MachineState<double> state = sim.atRest(0.0);
  ModalStepper stepper(machine, 1e-8);
  Simulator<double>::Held held{{0.0, 0.0, 0.0, 0.0}, {{0.0, 0.0}, {0.0, 0.0}}};  // the bearings are off
  ASSERT_TRUE(stepper.advance(sim, 0.0, 0.001, state, held));  // reads the machine's equations
  const long before = allocations;
  ASSERT_TRUE(stepper.advance(sim, 0.001, 0.03, state, held));
  EXPECT_EQ(allocations - before, 0);
  EXPECT_EQ(stepper.reason(), "");
  EXPECT_GE(stepper.statistics().events, 4);
}

TEST(IntegrationProperty, NoAllocationInTheMachinesDerivatives) {
  const Model model = withUnbalance(levitated(), 1e-5);
  const Machine<double> machine({&model});
  std::vector<double> state(machine.stateSize(), 1e-5), rate(machine.stateSize());
  Inputs<double> in;
  in.shaft = Shaft<double>::at(0.3, 400.0, 0.0);
  const long before = allocations;
  for (int i = 0; i < 100; ++i) machine.derivatives(in, state.data(), rate.data());
  EXPECT_EQ(allocations - before, 0);
}

TEST(IntegrationProperty, TheCounterOfAllocationsCounts) {
  const long before = allocations;
  const std::vector<double> block(100, 1.0);
  EXPECT_EQ(allocations - before, 1) << block.size();
}

}  // namespace
}  // namespace amb_rotor
