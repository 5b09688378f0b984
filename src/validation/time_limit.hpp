#pragma once
// How long a diagnosis may begin anything new. Sets exist on which a search goes on for many minutes; what has been found by
// then is worth more than no answer. What ends early is told, so that nobody takes it for what was looked at.
#include <chrono>

namespace amb_rotor {

class TimeLimit {
 public:
  TimeLimit() = default;
  /// From now on [s]; 0 or less: none.
  explicit TimeLimit(double seconds) : seconds_(seconds > 0.0 ? seconds : 0.0) {}

  /// Nothing new is to be begun.
  bool isUp() const { return passed(1.0); }
  /// A fit that is under way is to end where it is.
  bool isLongUp() const { return passed(patience); }

 private:
  /// A last refit begun just before may go on for so many times the limit.
  static constexpr double patience = 4.0 / 3.0;
  using Clock = std::chrono::steady_clock;

  bool passed(double times) const {
    return seconds_ > 0.0 && std::chrono::duration<double>(Clock::now() - begin_).count() > times * seconds_;
  }

  double seconds_ = 0.0;
  Clock::time_point begin_ = Clock::now();
};

}  // namespace amb_rotor
