#pragma once
// Event-accurate integration of a hybrid system: smooth between events, with modes that change where a
// guard crosses zero.
//
// Method: Dormand and Prince 5(4) with first-same-as-last, dense output of order 4 (Hairer, Norsett, Wanner,
// Solving Ordinary Differential Equations I, II.5, II.6), PI step control. Events are
// looked for on the dense output: a guard that is negative at a quarter of a step, or dips below zero between two of
// them. The step is then repeated with exactly the length to the event and corrected until the state lies behind it,
// so that the state at the event has the order of the method, not of the dense output.
// No allocation after construction.
#include <functional>
#include <string>
#include <vector>

namespace amb_rotor {

/// What an integrator needs to know of a system.
class HybridSystem {
 public:
  virtual ~HybridSystem() = default;
  virtual int size() const = 0;
  /// Derivatives with the modes as they are now.
  virtual void derivatives(double time, const double* state, double* rate) const = 0;
  virtual int guards() const { return 0; }
  /// Guard values with the modes as they are now. An event is a crossing from >= 0 to < 0; so every guard is
  /// written to be positive while its mode is valid.
  virtual void guardValues(double, const double*, double*) const {}
  /// Changes the mode after guard crossed zero at a time and state; may change the state (a jump).
  virtual void onEvent(int, double, double*) {}
};

struct IntegratorOptions {
  double relative_tolerance = 1e-8;   ///< of each component's scale
  std::vector<double> absolute;       ///< scale of each component below which only the absolute error counts
  double largest_step = 0.0;          ///< 0: none
  double first_step = 0.0;            ///< 0: chosen
  double smallest_step = 1e-15;       ///< below: IntegrationStatus::step_too_small
  long step_limit = 50'000'000;       ///< of one advance()
  long event_limit = 5'000'000;       ///< of one advance()
};

enum class IntegrationStatus { ok, step_too_small, step_limit, event_limit, not_finite };

struct IntegrationResult {
  IntegrationStatus status = IntegrationStatus::ok;
  double time = 0.0;  ///< reached
  std::string reason() const;
};

struct IntegratorStatistics {
  long steps = 0, rejected = 0, evaluations = 0, events = 0;
};

class EventIntegrator {
 public:
  EventIntegrator(HybridSystem& system, IntegratorOptions options);

  /// Advances state (size of the system) from start to end. On failure state is that at result.time.
  IntegrationResult advance(double start, double end, double* state);
  /// Called after each accepted step with (start, end, dense) where dense(t, out) gives the state in between.
  using Dense = std::function<void(double, double*)>;
  void setObserver(std::function<void(double, double, const Dense&)> observer) { observer_ = std::move(observer); }
  /// Next call starts with a fresh step size and derivative (after a jump of the inputs).
  void restart() { have_rate_ = false; }
  const IntegratorStatistics& statistics() const { return statistics_; }

 private:
  /// One trial step; returns the error norm (1: at the tolerance).
  double trial(double time, const double* state, double h);
  void dense(double share, double* out) const;
  /// First event on the dense output of a step: its share of the step and its guard.
  bool locate(double time, double h, double& at, int& guard);
  double guardAt(double time, double h, double share, int guard);
  /// A place inside a quarter of a step where a guard that is positive at both ends dips below zero; -1: none.
  double dip(double time, double h, int guard, int interval);
  /// Repeats the step up to just behind an event; returns its length, -1: the event is not within the step.
  double cross(double time, const double* y, double width, double longest, int guard);

  HybridSystem& system_;
  IntegratorOptions options_;
  IntegratorStatistics statistics_;
  int n_;
  std::vector<double> k_[7], next_, work_, start_, dense_state_, samples_, guard_now_;
  std::vector<double> dense_[5];
  double step_ = 0.0, previous_error_ = 1.0;
  double start_time_ = 0.0;
  bool have_rate_ = false;
  std::function<void(double, double, const Dense&)> observer_;
};

}  // namespace amb_rotor
