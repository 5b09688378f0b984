// A scenario's excitation current is held from one sample of the controller to the next: the motion does not depend on
// what is recorded, and the current is the closed form of a held waveform.
#include <gtest/gtest.h>

#include "../support/models.hpp"

namespace amb_rotor {
namespace {

using namespace testing_support;

Excitation shaking(Waveform waveform) {
  Excitation e;
  e.kind = Excitation::Kind::current;
  e.waveform = waveform;
  e.axis = 1;
  e.amplitude = 0.3;
  e.start_s = 0.00123;  // between two samples
  e.duration_s = waveform == Waveform::impulse ? 0.0021 : 0.0377;
  e.start_hz = 40.0;
  e.end_hz = 900.0;
  return e;
}

TEST(ExcitationHold, MotionDoesNotDependOnTheRecordRate) {
  for (const Waveform waveform : {Waveform::chirp, Waveform::sine, Waveform::impulse, Waveform::step}) {
    Simulation runs[3];
    const double rates[3] = {10000.0, 37000.0, 1000.0};
    for (int i = 0; i < 3; ++i) {
      Scenario scenario = from(constantSpeed(0.0, 0.04, rates[i]), {0, 0, 0, 0}, {});
      scenario.excitations.push_back(shaking(waveform));
      runs[i] = simulate(levitated(), scenario);
      ASSERT_EQ(runs[i].outcome.status, RunStatus::ok);
    }
    ASSERT_GT(largest(runs[0].trajectory.position_m[1]), 1e-7);
    for (int i = 1; i < 3; ++i)
      for (std::size_t k = 0; k < 8; ++k)
        // the integrator restarts at records: its tolerance, 1e-8 of 1e-5 m and 1e-2 m/s, over some 100 steps that the
        // loop has not forgotten
        EXPECT_NEAR(runs[i].final_state.mechanics[k], runs[0].final_state.mechanics[k], k < 4 ? 1e-11 : 1e-8)
            << "record rate " << rates[i] << ", waveform " << static_cast<int>(waveform) << ", state " << k;
  }
}

TEST(ExcitationHold, CurrentIsTheHeldWaveformBehindTheAmplifier) {
  Model model = levitated();
  model.rig.controller.kp_A_per_m = model.rig.controller.kd_A_s_per_m = 0.0;
  model.rig.amb.displacement_stiffness_N_per_m = 0.0;
  const Excitation e = shaking(Waveform::chirp);
  Scenario scenario = from(constantSpeed(0.0, 0.02, 50000.0), {0, 0, 0, 0}, {});
  scenario.excitations.push_back(e);
  const auto run = simulate(model, scenario);
  // step by step of 20 us: the target of the last controller sample (10 kHz), 0 before the start
  const double decay = std::exp(-two_pi * 2000.0 * 2e-5);
  double current = 0.0, most = 0.0;
  for (int n = 0; n + 1 < 1000; ++n) {
    const double sampled = 1e-4 * (n / 5), t = sampled - e.start_s;
    const double target =
        t > 0.0 ? e.amplitude * std::sin(two_pi * (e.start_hz * t + 0.5 * (900.0 - 40.0) * t * t / e.duration_s)) : 0.0;
    current = target + (current - target) * decay;
    ASSERT_NEAR(run.trajectory.current_A[1][static_cast<std::size_t>(n) + 1], current, 1e-12) << n;
    most = std::max(most, std::fabs(current));
  }
  EXPECT_GT(most, 0.1);
}

}  // namespace
}  // namespace amb_rotor
