#pragma once
// The motion that a machine settles in at a constant speed W, out of contact, where machine and controller are linear: found
// in closed form where a run-in from rest would take as long as its least damped mode rings.
//
// From one sample of the controller to the next, a period T, all that the machine remembers, z (mechanics, currents, lags, the
// controller's memory, commands on their way), goes as
//   z' = A z + f(angle'),  f(angle) = sum over h < harmonics of f_h cos(h angle) + g_h sin(h angle)
// with the shaft's angle at the period's end. A and f are read from the simulator itself: a period from every unit of z, and a
// period from none at twice as many angles as there are harmonics. Two times m periods are then
//   A(2m) = A(m) A(m),   f(2m)(angle) = A(m) f(m)(angle - m T W) + f(m)(angle)
// and are taken until they change nothing: f has become the settled motion, and A what never moves (an integrator at rest).
//
// solved() is false where the machine does not settle within `most_doublings` (unstable, or undamped), where a period from the
// settled motion is not what the equations say (a sensor or a converter that is not linear, a command beyond its limit), or
// where it reaches the auxiliary bearings. The drive has neither excitation nor schedule.
// Valid: machines for which ExactStepper::takes(); runouts of fewer orders than `harmonics`. All lanes or none.
// Source: doubling of a linear recursion, as in the matrix exponential's scaling and squaring.
#include <algorithm>
#include <cmath>
#include <vector>

#include "amb_rotor/common/units.hpp"
#include "amb_rotor/machine/exact_stepper.hpp"

namespace amb_rotor {

template <class S>
class SettledMotion {
 public:
  /// @param drive          of the run-in: constant speed, `machine`'s
  /// @param time           that the motion is wanted for, an instant of the controller [s]
  /// @param period_s       of the controller; without one any that the machine's motion is smooth in
  /// @param integral_m_s   that the PIDs' integrators begin with
  /// @param prepare        void(Simulator<S>&): what the run-in asks of its simulators (integrators at rest or leaking)
  /// @param keeps_clear    whether the motion must keep out of the auxiliary bearings
  template <class Prepare>
  SettledMotion(const Machine<S>& machine, const Drive<S>& drive, double time, double period_s, const S integral_m_s[4],
                double largest_step_s, bool keeps_clear, const Prepare& prepare)
      : machine_(machine),
        drive_(drive),
        own_angle_(drive.shaft(time).angle),
        speed_(drive.shaft(time).speed),
        time_(time),
        period_(period_s),
        linear_(machine, drive_, 0.0),
        limited_(machine, drive_, 0.0),
        stepper_(machine, largest_step_s, 0.0) {
    drive_.turned = drive_.path != nullptr;
    prepare(linear_);
    prepare(limited_);
    linear_.liftLimits();
    if (!begin(integral_m_s)) return;
    read();
    solved_ = settles() && holds() && !(keeps_clear && touches());
    if (solved_) put(motion(own_angle_), state_);
  }
  SettledMotion(const SettledMotion&) = delete;
  SettledMotion& operator=(const SettledMotion&) = delete;

  bool solved() const { return solved_; }
  /// Before the instant `time` is dealt with; next_record is 0.
  const MachineState<S>& state() const { return state_; }

 private:
  using Vector = std::vector<S>;
  static constexpr int harmonics = 8, angles = 2 * harmonics, rows = angles - 1;
  /// 2^26 periods of 1e-4 s are 2 hours.
  static constexpr int most_doublings = 26;
  /// What a doubling may change at last, of each number's own size and of its kind's. The next one changes its square.
  static constexpr double change_of_own = 1e-7, change_of_kind = 1e-9;
  /// Misfit of a period that counts as nonlinear, likewise.
  static constexpr double misfit_of_own = 1e-7, misfit_of_kind = 1e-9;
  static constexpr int trials = 3;
  static constexpr std::size_t columns_at_once = 4;

  /// The state a period earlier, whose numbers are to be filled in.
  bool begin(const S integral_m_s[4]) {
    const auto unseen = [](const Record<S>&) {};
    const double delay = machine_.ambModel() == AmbModel::linear ? laneValue(machine_.rig().controller.delay_s, 0) : 0.0;
    const int warm = static_cast<int>(std::ceil(delay / period_)) + 2;
    state_ = linear_.atRest(time_ - (warm + 1) * period_);
    for (int a = 0; a < 4; ++a) state_.controller[a].integral = integral_m_s[a];
    if (!linear_.run(state_, time_ - period_, stepper_, unseen)) return false;
    earlier_ = state_;
    if (!linear_.run(state_, time_, stepper_, unseen)) return false;
    return earlier_.pending.size() == state_.pending.size();
  }

  /// All numbers of a state in a row.
  template <class State, class Visit>
  static void each(State& state, Visit&& visit) {
    for (auto& value : state.mechanics) visit(value);
    for (auto& memory : state.controller) {
      visit(memory.previous_signal);
      visit(memory.derivative);
      visit(memory.integral);
    }
    for (auto& value : state.control) visit(value);
    for (auto& value : state.command) visit(value);
    for (auto& value : state.current) visit(value);
    for (auto& value : state.lag) visit(value);
    for (auto& command : state.pending)
      for (auto& value : command.command) visit(value);
  }
  static Vector numbers(const MachineState<S>& state) {
    Vector out;
    each(state, [&out](const S& value) { out.push_back(value); });
    return out;
  }
  static void put(const Vector& numbers, MachineState<S>& state) {
    auto from = numbers.begin();
    each(state, [&from](S& value) { value = *from++; });
  }
  /// The size of each number's kind: what counts as nothing is measured by it.
  Vector kinds() const {
    const S place = machine_.rig().auxiliary_bearing.clearance_m, rate = S(100.0) * place;
    MachineState<S> unit = state_;
    for (std::size_t i = 0; i < unit.mechanics.size(); ++i)
      unit.mechanics[i] = static_cast<int>(i) < machine_.coordinates() ? place : rate;
    for (auto& memory : unit.controller) {
      memory.previous_signal = place;
      memory.derivative = rate;
      memory.integral = S(0.01) * place;
    }
    for (auto& value : unit.control) value = place;
    for (auto& value : unit.command) value = S(1.0);
    for (auto& value : unit.current) value = S(1.0);
    for (auto& value : unit.lag) value = S(1.0);
    for (auto& command : unit.pending)
      for (auto& value : command.command) value = S(1.0);
    return numbers(unit);
  }

  /// All numbers a period later, with the shaft at an angle then; empty where that fails.
  Vector after(const Simulator<S>& sim, const Vector& from, const S& angle_at_end) {
    const S own = drive_.angle0;
    drive_.angle0 += angle_at_end - own_angle_;
    work_ = earlier_;
    put(from, work_);
    const bool done = sim.run(work_, time_, stepper_, [](const Record<S>&) {});
    drive_.angle0 = own;
    return done ? numbers(work_) : Vector();
  }

  void read() {
    begun_ = numbers(state_);
    size_ = begun_.size();
    const Vector none(size_, S(0.0));
    const Vector at_zero = after(linear_, none, S(0.0));
    matrix_.assign(size_ * size_, S(0.0));
    Vector unit = none;
    for (std::size_t j = 0; j < size_; ++j) {
      unit[j] = S(1.0);
      const Vector column = after(linear_, unit, S(0.0));
      for (std::size_t i = 0; i < size_; ++i) matrix_[j * size_ + i] = column[i] - at_zero[i];
      unit[j] = S(0.0);
    }
    forced_.assign(rows, none);
    for (int k = 0; k < angles; ++k) {
      const double angle = two_pi * k / angles;
      const Vector seen = k == 0 ? at_zero : after(linear_, none, S(angle));
      for (int row = 0; row < rows; ++row) {
        const int order = (row + 1) / 2;
        const double share = (row % 2 == 1 ? std::sin(order * angle) : std::cos(order * angle)) * (row == 0 ? 1.0 : 2.0) / angles;
        for (std::size_t i = 0; i < size_; ++i) forced_[row][i] += S(share) * seen[i];
      }
    }
    // orders that are not there but for round-off
    const Vector kind = kinds();
    for (int row = 1; row < rows; ++row)
      for (std::size_t i = 0; i < size_; ++i) {
        const S least = S(1e-13) * (magnitude(forced_[0][i]) + magnitude(forced_[1][i]) + magnitude(forced_[2][i]) + kind[i]);
        forced_[row][i] = select(magnitude(forced_[row][i]) < least, S(0.0), forced_[row][i]);
      }
  }

  static bool allZero(const S& value) {
    for (std::size_t l = 0; l < ScalarTraits<S>::lanes; ++l)
      if (laneValue(value, l) != 0.0) return false;
    return true;
  }
  /// out = matrix x, four columns at a time.
  void multiply(const Vector& x, std::size_t from, Vector& out, std::size_t to) {
    const S* factors = x.data() + from;
    S* sum = out.data() + to;
    std::fill(sum, sum + size_, S(0.0));
    present_.clear();
    for (std::size_t k = 0; k < size_; ++k)
      if (!allZero(factors[k])) present_.push_back(k);
    for (std::size_t k = 0; k < present_.size(); k += columns_at_once) {
      const S* column[columns_at_once];
      S factor[columns_at_once];
      for (std::size_t c = 0; c < columns_at_once; ++c) {
        const bool there = k + c < present_.size();
        column[c] = matrix_.data() + (there ? present_[k + c] : 0) * size_;
        factor[c] = there ? factors[present_[k + c]] : S(0.0);
      }
      for (std::size_t i = 0; i < size_; ++i) {
        S value = sum[i];
        for (std::size_t c = 0; c < columns_at_once; ++c) value = multiplyAdd(column[c][i], factor[c], value);
        sum[i] = value;
      }
    }
  }
  static bool within(const S& change, const S& allowed) {
    for (std::size_t l = 0; l < ScalarTraits<S>::lanes; ++l)
      if (!(std::fabs(laneValue(change, l)) <= laneValue(allowed, l))) return false;
    return true;
  }

  /// Doubles until nothing changes.
  bool settles() {
    const Vector kind = kinds();
    Vector squared(size_ * size_), constant(size_), turned(size_);
    std::vector<Vector> forced = forced_;
    for (int doubling = 0; doubling < most_doublings; ++doubling) {
      const S turn = S(std::ldexp(period_, doubling)) * speed_;
      multiply(begun_, 0, constant, 0);
      for (int row = 0; row < rows; ++row) {
        turnBack(row, turn, turned);
        multiply(turned, 0, forced[row], 0);
        for (std::size_t i = 0; i < size_; ++i) forced[row][i] += forced_[row][i];
      }
      bool still = true;
      for (std::size_t i = 0; i < size_ && still; ++i) {
        S own = magnitude(constant[i]), change = magnitude(constant[i] - begun_[i]);
        for (int row = 0; row < rows; ++row) {
          own += magnitude(forced[row][i]);
          change += magnitude(forced[row][i] - forced_[row][i]);
        }
        still = within(change, S(change_of_own) * own + S(change_of_kind) * kind[i]);
      }
      begun_.swap(constant);
      forced_.swap(forced);
      if (still) return true;
      for (std::size_t j = 0; j < size_; ++j) multiply(matrix_, j * size_, squared, j * size_);
      matrix_.swap(squared);
    }
    return false;
  }

  /// A row of the motion `turn` earlier: of  s sin(h (angle - turn)) + c cos(h (angle - turn)).
  void turnBack(int row, const S& turn, Vector& out) const {
    const int order = (row + 1) / 2;
    S sine, cosine;
    sineCosine(S(static_cast<double>(order)) * turn, sine, cosine);
    const bool of_sine = row % 2 == 1;
    const Vector &own = forced_[row], &other = row == 0 ? own : forced_[of_sine ? row + 1 : row - 1];
    const S share = row == 0 ? S(0.0) : of_sine ? sine : -sine;
    for (std::size_t i = 0; i < size_; ++i) out[i] = own[i] * cosine + other[i] * share;
  }

  /// The settled motion with the shaft at an angle.
  Vector motion(const S& angle) const {
    Vector out = begun_;
    for (int row = 0; row < rows; ++row) {
      const int order = (row + 1) / 2;
      S sine, cosine;
      sineCosine(S(static_cast<double>(order)) * angle, sine, cosine);
      for (std::size_t i = 0; i < size_; ++i) out[i] += forced_[row][i] * (row % 2 == 1 ? sine : cosine);
    }
    return out;
  }

  /// Whether a period from the settled motion, limits and all, ends in it.
  bool holds() {
    const Vector kind = kinds();
    for (int trial = 0; trial < trials; ++trial) {
      const S end = own_angle_ + S(two_pi * (trial / static_cast<double>(trials) + 0.03));
      const Vector expected = motion(end), seen = after(limited_, motion(end - S(period_) * speed_), end);
      if (seen.empty()) return false;
      for (std::size_t i = 0; i < size_; ++i) {
        S own = magnitude(begun_[i]);
        for (int row = 0; row < rows; ++row) own += magnitude(forced_[row][i]);
        if (!within(seen[i] - expected[i], S(misfit_of_own) * own + S(misfit_of_kind) * kind[i])) return false;
      }
    }
    return !commandsAtTheirLimit();
  }

  /// Whether a command passes what the amplifiers give, at any angle.
  bool commandsAtTheirLimit() const {
    if (machine_.ambModel() != AmbModel::linear) return false;
    const Amplifier<S> amplifier(machine_.rig());
    const std::size_t first = machine_.stateSize() + 12 + state_.control.size();
    for (int a = 0; a < 4; ++a) {
      S most = magnitude(begun_[first + a] + forced_[0][first + a]);
      for (int row = 1; row < rows; row += 2) {
        const S s = forced_[row][first + a], c = forced_[row + 1][first + a];
        most += squareRoot(s * s + c * c);
      }
      if (!within(most - amplifier.limited(most), S(0.0))) return true;
    }
    return false;
  }

  /// Whether it comes to the auxiliary bearings.
  bool touches() const {
    for (int k = 0; k < 4 * angles; ++k) {
      const Vector at = motion(S(two_pi * k / (4.0 * angles)));
      for (int end = 0; end < 2; ++end) {
        S penetration, rate;
        machine_.approach(end, at.data(), penetration, rate);
        if (any(penetration > S(0.0))) return true;
      }
    }
    return false;
  }

  const Machine<S>& machine_;
  Drive<S> drive_;  ///< turned as is needed: the simulators look at it
  S own_angle_, speed_;
  double time_, period_;
  Simulator<S> linear_, limited_;
  ExactStepper<S> stepper_;
  bool solved_ = false;
  MachineState<S> state_, earlier_, work_;  ///< at `time`, a period before, and of a period looked at
  std::size_t size_ = 0;
  Vector begun_;                ///< what is left of the beginning
  Vector matrix_;               ///< A by columns
  std::vector<std::size_t> present_;  ///< scratch of multiply()
  std::vector<Vector> forced_;  ///< f: constant, then sine and cosine of each order
};

}  // namespace amb_rotor
