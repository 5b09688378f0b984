#pragma once
// Event-accurate motion of a linear system with contact at two ends: the linear part exactly, the contact
// forces, which are few, by collocation.
//
//   s in modal coordinates (linear_flow.hpp);  w = C s + w_p(t): four outputs an end, its displacement and
//   velocity in its bearing;  u: two forces an end, u = F(w) while it carries and 0 while it does not
//
// Free flight: closed form. The first touch-down is looked for by steps that cannot pass it, by
// bounds of the speed and the acceleration, which the amplitudes of the modes give. Grazing is not missed but where it stays
// shallower than what half a microsecond of acceleration makes. In contact: over a step h, u is a polynomial
// through 4 Gauss nodes, so that  w_i = (free motion)_i + sum_j K_ij u_j holds without further error; u_i =
// F(w_i) by Newton's method in the normal forces of all nodes and ends (directions follow from pass to pass;
// contact_newton.hpp), begun with the polynomial through the last step's nodes and the last one of the step
// before; a step that does not converge is halved. Order 8. The error estimate
// is what the highest Legendre component of u moves at the end of the step, and, because a force that begins
// as t^1.5 moves a free body by less than its error, the square of that component over the mean. Steps are a
// length h0 halved so and so often, whose tables are kept; only the step up to an event or an end has its
// own. A lift-off, or a touch-down at the other end, is found at the nodes and the end of a step; the step is
// repeated with the length to it, first by the depths and their rates around it, which mostly does, then by
// Newton's method, until the guard is 0 within a tenth of the tolerance.
//
// Further forces, known as functions of time, are inputs behind those of the ends: while they act the motion
// goes by the same steps, with their values at the nodes.
//
// No allocation after construction. Left out: forces that depend on more than an end's own displacement and
// velocity; a touch-down and lift-off between two nodes of a step.
#include <functional>
#include <vector>

#include "amb_rotor/integration/contact_newton.hpp"
#include "amb_rotor/integration/event_integrator.hpp"
#include "amb_rotor/integration/linear_flow.hpp"

namespace amb_rotor {

/// The law of contact of the ends.
class EndContacts {
 public:
  virtual ~EndContacts() = default;
  /// The normal force, away from the bearing's centre against the displacement, with its derivatives by depth
  /// and by the depth's rate [N, N/m, N s/m]; the displacement's direction.
  struct Normal {
    double force = 0.0, slope = 0.0, damping = 0.0, x = 1.0, y = 0.0;
  };
  /// Force on the system at an end that carries, and its guard: positive while it goes on carrying [m].
  virtual double force(int end, const double* w, double* u, Normal& normal) const = 0;
  /// The same at all nodes of a step, for ends that follow each other: w by LinearFlow::row(), u by its
  /// column(), from those of the first of these ends on.
  virtual void forces(int first, int count, const double* w, double* u, ContactNodes& nodes) const;
};

class ContactFlow {
 public:
  struct Options {
    double tolerance = 1e-8;                         ///< of displacement and velocity at the ends, each step
    double length_scale = 1e-5, speed_scale = 1e-2;  ///< below these only the absolute error counts
    double clearance = 0.0;      ///< of every end: where |displacement| exceeds it it touches
    double longest_step = 1e-4;  ///< h0
  };
  ContactFlow(const LinearFlow& flow, const EndContacts& contacts, const Options& options);

  /// What is not the modes' own motion, for as long as the machine is this one. `held`: values that are
  /// constant from one begin() to the next (commands), `excess`: what decays to them.
  struct Drive {
    Eigen::VectorXd rest, drift;        ///< constant forces: their rest, and what they do to the drift
    Eigen::MatrixXd rest_by, drift_by;  ///< the same of each held value
    Eigen::MatrixXd decay_by;           ///< of each excess, times exp(-rate t)
    Eigen::VectorXd cosine, sine;       ///< of the angle
    Eigen::VectorXd place;              ///< outputs at s = 0
    double speed = 0.0, rate = 0.0;
  };
  void setDrive(const Drive& drive);
  /// Values of the inputs behind the ends' (LinearFlow::inputs() less four) at a time since the start.
  using Pushes = std::function<void(double, double*)>;
  /// Begins an interval at an angle with these values; pushes: null where none acts (it is called until
  /// advance() returns).
  void begin(double angle, const double* held, const double* excess, const Pushes* pushes);

  /// Advances s (the modes' own motion, without what the drive keeps up) by `length` [s], from the drive's
  /// start. mode: per end, 1 carries; onEvent(end, time since the start, s) after each change.
  using Observer = std::function<void(int, double)>;
  IntegrationStatus advance(double length, double* s, int* mode, const Observer& onEvent);

  /// s of all that moves at a time: the modes' own motion and what the drive keeps up; and back.
  void whole(double time, const Eigen::VectorXd& own, Eigen::VectorXd& out) const;
  void own(double time, const Eigen::VectorXd& whole, Eigen::VectorXd& out) const;
  const IntegratorStatistics& statistics() const { return statistics_; }
  static constexpr int ends = 2;

 private:
  static constexpr int points = LinearFlow::nodes;
  static constexpr int levels = 14, per_end = 4, rows = per_end * ends, end_inputs = 2 * ends;
  /// Row of an output at a node or, as the last point, at the end of a step.
  static constexpr int rowOf(int output, int point) {
    return point < points ? LinearFlow::row(output, point) : points * rows + output;
  }

  const LinearFlow::Table& ladder(int level);
  void keptUp(double time, double* w) const;       ///< outputs of the drive
  void outputs(const double* s, double* w) const;  ///< of the modes' own motion
  void drift(double t, double* s) const;           ///< under the drive's constant forces
  double guard(int end, const double* w, int mode, double* u) const;
  void bounds(const double* s, double horizon, double speed[ends], double acceleration[ends]) const;
  double staysInside(const double* at, double acceleration, double most) const;
  double threshold() const { return 0.1 * options_.tolerance * options_.length_scale; }
  bool flight(double& time, double length, double* s, const int* mode, int& end);
  void pushAtNodes(const LinearFlow::Table& table, double time);
  void guess(const LinearFlow::Table& table);
  void pushRows(const AlignedMatrix& forced, int first_row);
  void addOfEnds(const AlignedMatrix& a, double* y) const;
  struct Turn {
    double h = -1.0;
    double cosine[points + 1], sine[points + 1], decay[points + 1];
    Eigen::Matrix<double, (points + 1) * rows, 2> by_angle;  ///< outputs there from the angle's cosine and sine at the start
    long interval = -1;                                      ///< of what follows
    Eigen::Matrix<double, (points + 1) * rows, 1>
        resting;  ///< outputs there from what is constant, and its drift
  };
  const Turn& turnOf(const LinearFlow::Table& table);
  /// Of the drive at a time since the start.
  struct Phase {
    double time = -1.0, cosine = 1.0, sine = 0.0, decay = 1.0;
    Phase turned(const Turn& by, int point, double later) const {
      return {time + later, cosine * by.cosine[point] - sine * by.sine[point],
              sine * by.cosine[point] + cosine * by.sine[point], decay * by.decay[point]};
    }
  };
  Phase phaseOf(double time) const;
  const Phase& exactPhase(double time) const;
  const Phase& phaseAt(double time);
  void weighGuess(double begin, double stretch, double earlier);
  bool stillFits(const LinearFlow::Table& table) const;
  bool solve(const LinearFlow::Table& table, double time, const double* s, const int* mode);
  double error(const LinearFlow::Table& table);
  void take(const LinearFlow::Table& table, double* s);
  /// An end's depth and its rate.
  struct Depth {
    double value = 0.0, rate = 0.0;
  };
  Depth depth(int end, const double* w) const;
  double newton(int end, const double* w, double t, double g) const;
  /// Where in a step an end's guard becomes negative: between two looks (times into the step, and guards there).
  struct Change {
    int end = -1;
    double low = 0.0, low_guard = 0.0, high = 0.0, high_guard = 0.0;
    Depth low_depth, high_depth;
    double first() const;
  };
  bool findEvent(double time, double h, const double* s, const int* mode, Change& change);
  const LinearFlow::Table* toEvent(double time, const double* s, const int* mode, Change change);
  const LinearFlow::Table& ownTable(double h);

  const LinearFlow& flow_;
  const EndContacts& contacts_;
  Options options_;
  IntegratorStatistics statistics_;
  Drive drive_;
  double angle_ = 0.0;  ///< at the start
  long interval_ = 0;   ///< counted by begin()
  const Pushes* pushes_ = nullptr;
  Eigen::VectorXd rest_now_, drift_now_, decay_now_;  ///< of the values of this interval
  Eigen::VectorXd drift_later_;                       ///< J drift_now_
  Eigen::MatrixXd rest_outputs_, decay_outputs_;      ///< of rest_by, decay_by
  Eigen::VectorXd rest_output_;
  static constexpr int kept_own = 4;          ///< lengths to the instants of a period come again
  LinearFlow::Table table_[levels + kept_own];  ///< of the ladder's steps, then of lengths of their own
  Turn turn_[levels + kept_own];
  int next_own_ = 0;
  Phase phase_;
  mutable Phase exact_;
  static constexpr int guess_nodes = points + 1;  ///< of the last step, and the last of the one before
  double guess_begin_ = -1.0, guess_stretch_ = 0.0, guess_earlier_ = 0.0, guess_weight_[guess_nodes][points];
  int level_ = 4, first_level_ = 4;
  bool fresh_ = false;
  Eigen::VectorXd own_real_, own_imaginary_, span_real_, span_imaginary_, moved_;
  double span_ = -1.0;                  ///< that span_real_ belongs to
  Eigen::MatrixXd speed_weight_;        ///< per end and mode
  Eigen::VectorXd pole_size_;           ///< |lambda|
  std::vector<int> growing_;            ///< modes
  static constexpr int kept_columns = 6;
  Eigen::Matrix<double, rows, kept_columns> kept_;  ///< outputs: rest, cosine, sine, decay; of the drift by t and t^2
  Eigen::VectorXd free_, w_, before_, u_, last_u_, start_w_, pushed_, parts_;
  ContactNodes evaluations_[2];  ///< the last one, and the one that the inverse was made of
  ContactNodes *nodes_ = &evaluations_[0], *made_ = &evaluations_[0];
  const ContactKernels& kernels_ = contactKernels();
  alignas(64) double inverse_[ContactNodes::most][ContactNodes::most];  ///< of Newton's matrix, by columns
  int first_ = 0, carrying_ = 0;  ///< ends that carry follow each other from the first on
  double made_h_ = -1.0;          ///< what the inverse was made of
  int made_first_ = 0, made_carrying_ = 0;
  double contraction_ = 1.0,
         contraction_h_ = 0.0;  ///< of one pass, as last measured, and the step it belongs to
  int since_measured_ = 0;
  Eigen::VectorXd evaluated_;  ///< forces of the last evaluation
  double last_h_ = 0.0;        ///< of the step that last_u_ belongs to; 0: none
  double earlier_h_ = 0.0;     ///< of the step before, whose forces at its last node are earlier_u_; 0: none
  double earlier_u_[end_inputs] = {};
  bool last_ended_ = false;    ///< that step was taken: the next begins at its end
};

}  // namespace amb_rotor
