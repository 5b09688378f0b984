// The runs of a made data set: as on the tutorial rigs.
#include <algorithm>
#include <cmath>

#include "amb_rotor/common/units.hpp"
#include "make_dataset_parts.hpp"

namespace amb_rotor::making {
namespace {

constexpr double speed_belief_std = 0.001;  ///< of a constant speed as stated
constexpr double excitation_step_A = 1e-4;

double stepped(double current) { return excitation_step_A * std::round(current / excitation_step_A); }

class Plans {
 public:
  Plans(Dice& dice, const Model& belief, double amplitude)
      : dice_(dice), critical_(criticalHz(belief)), top_(topSpeedHz(belief)) {
    const auto& rig = belief.rig;
    reach_A_ = amplitude * rig.auxiliary_bearing.clearance_m * netStiffness(belief) /
               rig.amb.current_stiffness_N_per_A;
  }

  RunPlan& add(RunKind kind, RunUse use, double duration, double speed_hz) {
    RunPlan plan;
    plan.run.kind = kind;
    plan.run.use = use;
    int number = 1;
    for (const auto& other : plans_) number += other.run.kind == kind ? 1 : 0;
    plan.run.id = std::string(runKindName(kind)) + "_" + std::to_string(number);
    plan.run.file = "runs/" + plan.run.id + ".csv.gz";
    plan.run.sample_rate_hz = sample_rate_hz;
    plan.samples = std::lround(duration * sample_rate_hz) + 1;
    plan.angle0 = dice_.uniform(0.0, two_pi);
    plan.speed_hz = speed_hz;
    if (speed_hz != 0.0)
      plan.run.speed_hz = 1e-3 * std::round(1e3 * speed_hz * (1.0 + speed_belief_std * dice_.normal()));
    plan.excitation.rate_hz = sample_rate_hz;
    for (auto& axis : plan.excitation.axis) axis.assign(plan.samples, 0.0);
    plans_.push_back(std::move(plan));
    return plans_.back();
  }
  double speed(double from, double to) { return critical_ * dice_.uniform(from, to); }

  void chirp(RunUse use, double speed_hz, std::vector<int> axes) {
    RunPlan& plan = add(RunKind::chirp, use, 1.0, speed_hz);
    const double from_hz = dice_.uniform(5.0, 20.0), to_hz = dice_.uniform(350.0, 450.0);
    for (int axis : axes) {
      const double amplitude = 0.11 * reach_A_ * dice_.uniform(0.8, 1.2) / std::sqrt(double(axes.size()));
      const double turn = dice_.uniform(0.0, two_pi);
      for (long i = 200; i < plan.samples - 300; ++i) {
        const double share = (i - 200.0) / (plan.samples - 500.0), t = (i - 200.0) / sample_rate_hz;
        const double edge = std::min(1.0, std::min(share, 1.0 - share) * 40.0);
        const double phase = two_pi * (from_hz * t + 0.5 * (to_hz - from_hz) * t * share) + turn;
        plan.excitation.axis[axis][i] = stepped(amplitude * edge * std::sin(phase));
      }
    }
  }
  void step(RunUse use, int axis) {
    RunPlan& plan = add(RunKind::step, use, 0.4, 0.0);
    const double amplitude = stepped(dice_.sign() * 0.26 * reach_A_ * dice_.uniform(0.85, 1.15));
    const long end = std::lround(dice_.uniform(1800.0, 2300.0));
    for (long i = 500; i < end; ++i) plan.excitation.axis[axis][i] = amplitude;
  }
  void steady(RunUse use, double speed_hz) { add(RunKind::steady, use, 1.0, speed_hz); }
  void ramp(RunUse use, bool up) {
    RunPlan& plan = add(up ? RunKind::run_up : RunKind::coast_down, use, 1.2, 0.0);
    const double low = dice_.uniform(15.0, 25.0), high = top_ * dice_.uniform(0.9, 1.0);
    plan.run.speed_from_tacho = true;
    plan.speed_hz = up ? low : high;
    plan.end_speed_hz = up ? high : low;
  }
  void rub(RunUse use) {
    RunPlan& plan = add(RunKind::rub, use, 0.6, speed(0.25, 0.5));
    const double hz = speed(0.85, 1.05), way = dice_.chance(0.7) ? 1.0 : -1.0, amplitude = 0.35 * reach_A_;
    constexpr long from = 600, to = 3840;
    for (long i = from; i < to; ++i) {
      const double size = amplitude * std::sin(pi * (i - from) / double(to - from));
      const double turn = two_pi * hz * (i - from) / sample_rate_hz;
      for (int a = 0; a < 4; ++a)
        plan.excitation.axis[a][i] = stepped(size * (a % 2 == 0 ? std::cos(turn) : way * std::sin(turn)));
    }
  }
  void drop(RunUse use, double at) {
    RunPlan& plan = add(RunKind::drop, use, 0.5, speed(0.6, 1.1));
    plan.run.events.push_back({at, false});
  }
  std::vector<RunPlan> take() { return std::move(plans_); }

 private:
  Dice& dice_;
  double critical_, top_, reach_A_ = 0.0;
  std::vector<RunPlan> plans_;
};

}  // namespace

std::vector<RunPlan> drawPlans(Dice& dice, const Model& belief, bool contact, double amplitude) {
  Plans plans(dice, belief, amplitude);
  constexpr RunUse fit = RunUse::fit, validate = RunUse::validate;
  const bool up = dice.chance(0.6);
  plans.chirp(fit, 0.0, {0});
  plans.chirp(fit, 0.0, {3});
  plans.chirp(fit, plans.speed(0.8, 1.2), {1});
  plans.step(fit, 0);
  plans.steady(fit, plans.speed(0.35, 0.5));
  plans.steady(fit, plans.speed(0.65, 0.85));
  plans.steady(fit, plans.speed(1.4, 1.65));
  plans.ramp(fit, up);
  plans.chirp(validate, dice.chance(0.5) ? 0.0 : plans.speed(0.5, 1.4), {1, 2});
  plans.step(validate, 1);
  plans.steady(validate, plans.speed(0.5, 0.65));
  plans.ramp(validate, up);
  if (contact) {
    plans.rub(fit);
    plans.drop(fit, 0.05);
    plans.rub(validate);
    plans.drop(validate, 0.06);
  }
  return plans.take();
}

bool makeRubsTouch(const TrueMachine& machine, std::vector<RunPlan>& plans) {
  constexpr int most_tries = 7;
  for (auto& plan : plans) {
    if (plan.run.kind != RunKind::rub) continue;
    bool touched = false;
    for (int i = 0; i < most_tries && !touched; ++i) {
      const Signals signals = runMachine(machine, plan, nullptr);
      if (!signals.sound) return false;
      touched = signals.reach > 1.01;
      if (touched) break;
      for (auto& axis : plan.excitation.axis)
        for (double& current : axis) current = stepped(1.3 * current);
    }
    if (!touched) return false;
  }
  return true;
}

}  // namespace amb_rotor::making
