// A step of contact: the forces of all nodes of a step by Newton's method, its error, and what it does to s.
#include <algorithm>
#include <cmath>

#include "amb_rotor/integration/contact_flow.hpp"
#include "amb_rotor/integration/dense_products.hpp"

namespace amb_rotor {
namespace {

constexpr int flow_iterations = 14;
/// Error of Gauss's rule for a force that begins as t^1.5 (Hertz): 1.2e-4 of its impulse, 4.8e-4 of what that
/// moves, over the square of the third Legendre component's share of the mean, 0.027. For smooth forces the
/// product is of order 6.
constexpr double roughness = 0.5;
/// Passes end where what is left to change, by their contraction, is this part of the tolerance.
constexpr double converged = 0.05;
/// The contraction is measured anew after so many steps, which takes a pass more.
constexpr int measured_every = 8;
/// Change of tangents (of their size) and of directions [rad] from which Newton's matrix is made anew.
constexpr double stale = 0.05;

}  // namespace

void EndContacts::forces(int first, int count, const double* w, double* u, ContactNodes& out) const {
  for (int e = first; e < first + count; ++e)
    for (int i = 0; i < ContactNodes::nodes; ++i) {
      double at[4], force[2];
      for (int o = 0; o < 4; ++o) at[o] = w[LinearFlow::row(4 * e + o, i)];
      Normal normal;
      const int k = e * ContactNodes::nodes + i;
      out.guard[k] = this->force(e, at, force, normal);
      out.force[k] = normal.force;
      out.slope[k] = normal.slope;
      out.damping[k] = normal.damping;
      out.x[k] = normal.x;
      out.y[k] = normal.y;
      u[LinearFlow::column(2 * e, i)] = force[0];
      u[LinearFlow::column(2 * e + 1, i)] = force[1];
    }
}

void ContactFlow::pushAtNodes(const LinearFlow::Table& table, double time) {
  const double* x = LinearFlow::abscissae();
  const int others = flow_.inputs() - end_inputs;
  for (int j = 0; j < points; ++j) {
    (*pushes_)(time + x[j] * table.h, pushed_.data());
    for (int i = 0; i < others; ++i) u_[LinearFlow::column(end_inputs + i, j)] = pushed_[i];
  }
  free_.head<points * rows>().noalias() += table.forced.rightCols(others * points) * u_.tail(others * points);
  free_.tail<rows>().noalias() += table.forced_end.rightCols(others * points) * u_.tail(others * points);
}

/// The last step's polynomial at this one's nodes, with the last node of the step before where one was taken:
/// kept, as steps of a length follow each other.
void ContactFlow::weighGuess(double begin, double stretch, double earlier) {
  if (begin == guess_begin_ && stretch == guess_stretch_ && earlier == guess_earlier_) return;
  guess_begin_ = begin;
  guess_stretch_ = stretch;
  guess_earlier_ = earlier;
  const double* x = LinearFlow::abscissae();
  const double before = earlier > 0.0 ? (x[points - 1] - 1.0) * earlier : 0.0;
  double beside = 1.0;
  for (int j = 0; j < points; ++j) beside *= before - x[j];
  for (int i = 0; i < points; ++i) {
    const double to = begin + x[i] * stretch;
    double weight[points], product = 1.0;
    LinearFlow::interpolation(to, weight);
    for (int j = 0; j < points; ++j) {
      guess_weight_[j][i] = earlier > 0.0 ? weight[j] * (to - before) / (x[j] - before) : weight[j];
      product *= to - x[j];
    }
    guess_weight_[points][i] = earlier > 0.0 ? product / beside : 0.0;
  }
}

void ContactFlow::guess(const LinearFlow::Table& table) {
  u_.head(end_inputs * points).setZero();
  if (carrying_ == 0) return;
  if (last_h_ <= 0.0) return contacts_.forces(first_, carrying_, free_.data(), u_.data(), *nodes_);
  weighGuess(last_ended_ ? 1.0 : 0.0, table.h / last_h_, last_ended_ ? earlier_h_ / last_h_ : 0.0);
  for (int input = 2 * first_; input < 2 * (first_ + carrying_); ++input) {
    const double* last = &last_u_[LinearFlow::column(input, 0)];
    double sum[points];
    for (int i = 0; i < points; ++i) sum[i] = guess_weight_[points][i] * earlier_u_[input];
    for (int j = 0; j < points; ++j)
      for (int i = 0; i < points; ++i) sum[i] += guess_weight_[j][i] * last[j];
    std::copy_n(sum, points, &u_[LinearFlow::column(input, 0)]);
  }
}

/// Outputs under the forces, of those rows: what they are without, and a product for the ends that carry.
void ContactFlow::pushRows(const AlignedMatrix& forced, int first_row) {
  double* const w = &w_[first_row];
  std::copy_n(&free_[first_row], forced.rows(), w);
  addOfEnds(forced, w);
}

/// y += A u, of the forces of the ends that carry.
void ContactFlow::addOfEnds(const AlignedMatrix& a, double* y) const {
  if (carrying_ == 0) return;
  const int first = LinearFlow::column(2 * first_, 0);
  product(a.col(first).data(), a.rows(), 2 * points * carrying_, &u_[first], y, true);
}

/// How far the drive's angle and decay get to the nodes and the end of a step: kept, as each step of the ladder is taken
/// over and over.
const ContactFlow::Turn& ContactFlow::turnOf(const LinearFlow::Table& table) {
  Turn& turn = turn_[&table - table_];
  const bool known = turn.h == table.h;
  if (known && turn.interval == interval_) return turn;
  const double* x = LinearFlow::abscissae();
  for (int i = 0; i <= points; ++i) {
    const double t = (i < points ? x[i] : 1.0) * table.h;
    for (int o = 0; o < rows; ++o)
      turn.resting[rowOf(o, i)] = kept_(o, 0) + t * (kept_(o, 4) + t * kept_(o, 5));
  }
  turn.interval = interval_;
  if (known) return turn;
  turn.h = table.h;
  for (int i = 0; i <= points; ++i) {
    const double t = (i < points ? x[i] : 1.0) * table.h;
    turn.cosine[i] = std::cos(drive_.speed * t);
    turn.sine[i] = std::sin(drive_.speed * t);
    turn.decay[i] = std::exp(-drive_.rate * t);
    for (int o = 0; o < rows; ++o)
      turn.by_angle.row(rowOf(o, i)) << turn.cosine[i] * kept_(o, 1) + turn.sine[i] * kept_(o, 2),
          turn.cosine[i] * kept_(o, 2) - turn.sine[i] * kept_(o, 1);
  }
  return turn;
}

bool ContactFlow::solve(const LinearFlow::Table& table, double time, const double* s, const int* mode) {
  const Turn& turn = turnOf(table);
  const Phase& begun = phaseAt(time);
  const double angle[] = {begun.cosine, begun.sine};
  free_ = turn.resting;
  product(table.free.data(), table.free.rows(), flow_.size(), s, free_.data(), true);
  product(turn.by_angle.data(), turn.by_angle.rows(), 2, angle, free_.data(), true);
  for (int i = 0; i <= points && begun.decay > 0.0; ++i) {
    const double decay = begun.decay * turn.decay[i];
    for (int o = 0; o < rows; ++o) free_[rowOf(o, i)] += decay * kept_(o, 3);
  }
  if (pushes_ != nullptr) pushAtNodes(table, time);
  carrying_ = mode[0] + mode[1];
  first_ = mode[0] != 0 ? 0 : 1;
  guess(table);
  const bool same = contraction_h_ == table.h && ++since_measured_ < measured_every;
  double previous = 0.0;
  for (int pass = 0; pass < flow_iterations; ++pass) {
    before_.swap(w_);
    pushRows(table.forced, 0);
    const double change = kernels_.change(first_, carrying_, w_.data(), before_.data(), options_.length_scale,
                                          options_.speed_scale) /
                          options_.tolerance;
    if (pass > 0) {
      if (!std::isfinite(change)) return false;
      if (pass > 1 && previous > converged) {  // below that it is round-off that changes
        contraction_ = change / previous;
        contraction_h_ = table.h;
        since_measured_ = 0;
      }
      const double left = change * contraction_ / std::max(1e-3, 1.0 - contraction_);
      if (carrying_ == 0 || change < converged ||
          ((pass > 1 || same) && contraction_ < 0.7 && left < converged)) {
        pushRows(table.forced_end, points * rows);
        return true;
      }
      if (pass > 2 && change > 0.7 * previous) return false;
    }
    previous = change;
    if (carrying_ == 0) continue;
    if (nodes_ == made_) nodes_ = &evaluations_[nodes_ == &evaluations_[0] ? 1 : 0];
    contacts_.forces(first_, carrying_, w_.data(), evaluated_.data(), *nodes_);
    statistics_.evaluations += carrying_ * points;
    if (pass == 0 && !stillFits(table)) {
      kernels_.linearise(first_, carrying_, table.forced.data(), *nodes_, evaluated_.data(), inverse_);
      made_h_ = table.h;
      made_first_ = first_;
      made_carrying_ = carrying_;
      made_ = nodes_;
    }
    kernels_.correct(first_, carrying_, *nodes_, evaluated_.data(), inverse_, u_.data());
  }
  return false;
}

/// Whether the inverse that is there serves this step, too: the same table, and tangents and directions that
/// have changed by little (which the contraction that is measured tells of).
bool ContactFlow::stillFits(const LinearFlow::Table& table) const {
  if (made_h_ != table.h || made_first_ != first_ || made_carrying_ != carrying_) return false;
  const ContactNodes &now = *nodes_, &then = *made_;
  for (int k = first_ * points; k < (first_ + carrying_) * points; ++k)
    if (std::abs(now.slope[k] - then.slope[k]) > stale * then.slope[k] ||
        std::abs(now.damping[k] - then.damping[k]) > stale * then.damping[k] ||
        std::abs(now.x[k] * then.y[k] - now.y[k] * then.x[k]) > stale)
      return false;
  return true;
}

double ContactFlow::error(const LinearFlow::Table& table) {
  product(table.parts, u_, parts_);
  const double *top = parts_.data(), *by_mean = top + rows, *by_third = by_mean + rows;
  double most = 0.0;
  for (int o = 0; o < rows; ++o) {
    const bool length = o % per_end < 2;
    const double scale =
        std::max(length ? options_.length_scale : options_.speed_scale, std::abs(w_[points * rows + o]));
    const double mean = std::abs(by_mean[o]), third = std::abs(by_third[o]);
    // a component that is larger than the mean leaves nothing to square
    const double rough = third < mean ? third * third / mean : mean > 0.0 ? third : 0.0;
    most = std::max(most, std::max(std::abs(top[o]), roughness * rough) / scale);
  }
  return most / options_.tolerance;
}

void ContactFlow::take(const LinearFlow::Table& table, double* s) {
  flow_.move(table.real.data(), table.imaginary.data(), table.h, s);
  drift(table.h, s);
  addOfEnds(table.response, s);
  if (pushes_ == nullptr) return;
  const int first = LinearFlow::column(end_inputs, 0);
  product(table.response.col(first).data(), flow_.size(), (flow_.inputs() - end_inputs) * points, &u_[first],
          s, true);
}

}  // namespace amb_rotor
