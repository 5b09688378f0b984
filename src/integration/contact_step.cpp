// A step of contact: the forces of all nodes of a step by Newton's method, its error, and what it does to s.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>

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

void ContactFlow::pushAtNodes(const LinearFlow::Table& table, double time) {
  const double* x = LinearFlow::abscissae();
  const int others = flow_.inputs() - end_inputs;
  for (int j = 0; j < points; ++j) {
    (*pushes_)(time + x[j] * table.h, pushed_.data());
    for (int i = 0; i < others; ++i) u_[LinearFlow::column(end_inputs + i, j)] = pushed_[i];
  }
  free_.noalias() += table.forced.rightCols(others * points) * u_.tail(others * points);
}

/// The last step's polynomial at this one's nodes: kept, as steps of a length follow each other.
void ContactFlow::weighGuess(double begin, double stretch) {
  if (begin == guess_begin_ && stretch == guess_stretch_) return;
  guess_begin_ = begin;
  guess_stretch_ = stretch;
  for (int i = 0; i < points; ++i) LinearFlow::interpolation(begin + LinearFlow::abscissae()[i] * stretch, guess_weight_[i]);
}

void ContactFlow::guess(const LinearFlow::Table& table, const int* mode) {
  u_.head(end_inputs * points).setZero();
  if (last_h_ > 0.0) weighGuess((last_ended_ ? 1.0 : 0.0), table.h / last_h_);
  for (int e = 0; e < ends; ++e) {
    if (mode[e] == 0) continue;
    for (int i = 0; i < points; ++i) {
      double* u = &u_[LinearFlow::column(2 * e, i)];
      if (last_h_ <= 0.0) {
        EndContacts::Normal none;
        contacts_.force(e, &free_[i * rows + per_end * e], u, none);
        continue;
      }
      for (int j = 0; j < points; ++j) {
        const double* last = &last_u_[LinearFlow::column(2 * e, j)];
        u[0] += guess_weight_[i][j] * last[0];
        u[1] += guess_weight_[i][j] * last[1];
      }
    }
  }
}

/// Outputs at all nodes and the end under the forces.
void ContactFlow::push(const LinearFlow::Table& table, const int* mode) {
  constexpr int of_end = 2 * points;
  w_ = free_;
  for (int e = 0; e < ends; ++e)
    if (mode[e] != 0)
      product(table.forced.col(of_end * e).data(), (points + 1) * rows, of_end, &u_[of_end * e], w_.data(), true);
}

/// How far the drive's angle and decay get to the nodes and the end of a step: kept, as each step of the ladder is taken
/// over and over.
const ContactFlow::Turn& ContactFlow::turnOf(const LinearFlow::Table& table) {
  Turn& turn = turn_[&table - table_];
  if (turn.h == table.h) return turn;
  const double* x = LinearFlow::abscissae();
  turn.h = table.h;
  for (int i = 0; i <= points; ++i) {
    const double t = (i < points ? x[i] : 1.0) * table.h;
    turn.cosine[i] = std::cos(drive_.speed * t);
    turn.sine[i] = std::sin(drive_.speed * t);
    turn.decay[i] = std::exp(-drive_.rate * t);
  }
  return turn;
}

bool ContactFlow::solve(const LinearFlow::Table& table, double time, const double* s, const int* mode) {
  const double* x = LinearFlow::abscissae();
  product(table.free.data(), table.free.rows(), flow_.size(), s, free_.data(), false);
  const Turn& turn = turnOf(table);
  const Phase& begun = phaseAt(time);
  for (int i = 0; i <= points; ++i) {
    const double t = (i < points ? x[i] : 1.0) * table.h;
    const Phase now = begun.turned(turn, i, t);
    const double share[kept_columns] = {1.0, now.cosine, now.sine, now.decay, t, t * t};
    product(kept_.data(), rows, kept_columns, share, &free_[i * rows], true);
  }
  if (pushes_ != nullptr) pushAtNodes(table, time);
  guess(table, mode);
  unknowns_ = 0;
  for (int e = 0; e < ends; ++e)
    for (int i = 0; i < points && mode[e] != 0; ++i) unknown_[unknowns_++] = i * ends + e;
  const bool same = contraction_h_ == table.h && ++since_measured_ < measured_every;
  double previous = 0.0;
  for (int pass = 0; pass < flow_iterations; ++pass) {
    before_.swap(w_);
    push(table, mode);
    double most[per_end] = {};  // of all nodes and ends in contact
    for (int k = 0; k < unknowns_; ++k) {
      const int at = unknown_[k] / ends * rows + unknown_[k] % ends * per_end;
      for (int o = 0; o < per_end; ++o) most[o] = std::max(most[o], std::abs(w_[at + o] - before_[at + o]));
    }
    const double change = std::max(std::max(most[0], most[1]) / options_.length_scale,
                                   std::max(most[2], most[3]) / options_.speed_scale) / options_.tolerance;
    if (pass > 0) {
      if (!std::isfinite(change)) return false;
      if (pass > 1 && previous > converged) {  // below that it is round-off that changes
        contraction_ = change / previous;
        contraction_h_ = table.h;
        since_measured_ = 0;
      }
      const double left = change * contraction_ / std::max(1e-3, 1.0 - contraction_);
      if (unknowns_ == 0 || change < converged ||
          ((pass > 1 || same) && contraction_ < 0.7 && left < converged)) {
        return true;
      }
      if (pass > 2 && change > 0.7 * previous) return false;
    }
    previous = change;
    evaluate();
    const bool anew = pass == 0 && !stillFits(table);
    if (unknowns_ == points) {  // one end
      if (anew) linearise<points>(table);
      correct<points>();
    } else if (unknowns_ == most_unknowns) {
      if (anew) linearise<most_unknowns>(table);
      correct<most_unknowns>();
    }
  }
  return false;
}

/// Forces at all nodes.
void ContactFlow::evaluate() {
  for (int k = 0; k < unknowns_; ++k) {
    const int i = unknown_[k] / ends, e = unknown_[k] % ends;
    const double* at = &w_[i * rows + per_end * e];
    guards_[i * ends + e] = contacts_.force(e, at, &evaluated_[LinearFlow::column(2 * e, i)], normal_[k]);
    const double inverse = 1.0 / std::sqrt(at[0] * at[0] + at[1] * at[1]);
    direction_[k][0] = at[0] * inverse;
    direction_[k][1] = at[1] * inverse;
  }
  statistics_.evaluations += unknowns_;
}

/// Whether the factors that are there serve this step, too: the same table, and tangents and directions that
/// have changed by little (which the contraction that is measured tells of).
bool ContactFlow::stillFits(const LinearFlow::Table& table) const {
  if (lu_h_ != table.h || lu_unknowns_ != unknowns_) return false;
  for (int k = 0; k < unknowns_; ++k) {
    const EndContacts::Normal &now = normal_[k], &then = lu_normal_[k];
    if (unknown_[k] != lu_unknown_[k] || std::abs(now.slope - then.slope) > stale * then.slope ||
        std::abs(now.damping - then.damping) > stale * then.damping ||
        std::abs(direction_[k][0] * lu_direction_[k][1] - direction_[k][1] * lu_direction_[k][0]) > stale)
      return false;
  }
  return true;
}

/// N_i = k_i n_i.x_i + c_i n_i.v_i + ..., x_i and v_i moved by all u_j = -N_j e_j (e: the normal, turned by
/// the friction's share): factors of the matrix of N - k n.x(N) - c n.v(N).
template <int count>
void ContactFlow::linearise(const LinearFlow::Table& table) {
  double turned[most_unknowns][2];
  for (int l = 0; l < count; ++l) {
    const int j = unknown_[l] / ends, f = unknown_[l] % ends;
    const double* u = &evaluated_[LinearFlow::column(2 * f, j)];
    const double inverse = normal_[l].force != 0.0 ? -1.0 / normal_[l].force : 0.0;
    turned[l][0] = inverse != 0.0 ? u[0] * inverse : direction_[l][0];
    turned[l][1] = inverse != 0.0 ? u[1] * inverse : direction_[l][1];
  }
  double weight[most_unknowns][per_end];
  for (int k = 0; k < count; ++k)
    for (int axis = 0; axis < 2; ++axis) {
      weight[k][axis] = normal_[k].slope * direction_[k][axis];
      weight[k][2 + axis] = normal_[k].damping * direction_[k][axis];
    }
  Eigen::Matrix<double, points * rows, 1> moved;  // outputs at the nodes by one unknown
  for (int l = 0; l < count; ++l) {
    const int j = unknown_[l] / ends, f = unknown_[l] % ends, column = LinearFlow::column(2 * f, j);
    moved = turned[l][0] * table.forced.col(column).head<points * rows>() +
            turned[l][1] * table.forced.col(column + 1).head<points * rows>();
    for (int k = 0; k < count; ++k) {
      const double* at = &moved[unknown_[k] / ends * rows + unknown_[k] % ends * per_end];
      double sum = k == l ? 1.0 : 0.0;
      for (int o = 0; o < per_end; ++o) sum += weight[k][o] * at[o];
      lu_[k][l] = sum;
    }
  }
  lu_h_ = table.h;
  lu_unknowns_ = count;
  std::copy(std::begin(unknown_), std::end(unknown_), lu_unknown_);
  std::copy(std::begin(normal_), std::end(normal_), lu_normal_);
  std::memcpy(lu_direction_, direction_, sizeof direction_);
  // the matrix is near 1 where the step suits the contact: no pivoting; where it is not, the passes do not
  // contract
  for (int p = 0; p < count; ++p) {
    lu_[p][p] = 1.0 / lu_[p][p];
    for (int k = p + 1; k < count; ++k) {
      const double factor = lu_[k][p] *= lu_[p][p];
      for (int l = p + 1; l < count; ++l) lu_[k][l] -= factor * lu_[p][l];
    }
  }
}

/// Newton's step in the normal forces; directions are those of the evaluation.
template <int count>
void ContactFlow::correct() {
  double moved[most_unknowns], plain[most_unknowns];  // Newton's step, the fixed point's
  for (int k = 0; k < count; ++k) {
    const int i = unknown_[k] / ends, e = unknown_[k] % ends;
    const double* u = &u_[LinearFlow::column(2 * e, i)];
    moved[k] = normal_[k].force + u[0] * direction_[k][0] + u[1] * direction_[k][1];
    plain[k] = moved[k];
    for (int l = 0; l < k; ++l) moved[k] -= lu_[k][l] * moved[l];
  }
  for (int k = count - 1; k >= 0; --k) {
    for (int l = k + 1; l < count; ++l) moved[k] -= lu_[k][l] * moved[l];
    moved[k] *= lu_[k][k];
  }
  for (int k = 0; k < count; ++k) {
    const int i = unknown_[k] / ends, e = unknown_[k] % ends, column = LinearFlow::column(2 * e, i);
    const double beyond = moved[k] - plain[k], force = normal_[k].force;
    for (int axis = 0; axis < 2; ++axis) {
      const double evaluated = evaluated_[column + axis];
      u_[column + axis] = evaluated + beyond * (force != 0.0 ? evaluated / force : -direction_[k][axis]);
    }
  }
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

void ContactFlow::take(const LinearFlow::Table& table, const int* mode, double* s) {
  flow_.move(table.real.data(), table.imaginary.data(), table.h, s);
  drift(table.h, s);
  constexpr int of_end = 2 * points;
  const auto add = [&](int first, int columns) {
    product(table.response.col(first).data(), flow_.size(), columns, &u_[first], s, true);
  };
  for (int e = 0; e < ends; ++e)
    if (mode[e] != 0) add(of_end * e, of_end);
  if (pushes_ != nullptr) add(end_inputs * points, (flow_.inputs() - end_inputs) * points);
}

}  // namespace amb_rotor
