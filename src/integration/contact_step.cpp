// A step of contact: the forces of all nodes of a step by Newton's method, its error, and what it does to s.
#include <algorithm>
#include <cmath>
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

/// The inverse of a matrix near 1, in its place (Gauss and Jordan, without pivoting). A row is one run of numbers without
/// exceptions: its pivot's column is what the row that is subtracted has there, 1 more than what is to stay.
template <int count, int width>
void invert(double (&a)[width][width]) {
  static const Eigen::Matrix<double, count, count> one = Eigen::Matrix<double, count, count>::Identity();
  for (int p = 0; p < count; ++p) {
    const double inverse = 1.0 / a[p][p];
    const double* unit = &one(0, p);
    double row[count];
    for (int l = 0; l < count; ++l) row[l] = (a[p][l] + unit[l]) * inverse;
    for (int l = 0; l < count; ++l) a[p][l] = row[l] - unit[l];
    const auto clear = [&](double* other) {
      const double factor = other[p];
      for (int l = 0; l < count; ++l) other[l] -= factor * row[l];
    };
    for (int k = 0; k < p; ++k) clear(a[k]);
    for (int k = p + 1; k < count; ++k) clear(a[k]);
  }
}

}  // namespace

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

/// Outputs under the forces, of those rows: what they are without, and a product for the ends that carry.
void ContactFlow::pushRows(const AlignedMatrix& forced, int first_row, const int* mode) {
  constexpr int of_end = 2 * points;
  double* const w = &w_[first_row];
  std::copy_n(&free_[first_row], forced.rows(), w);
  const auto add = [&](int first, int columns) {
    product(forced.col(first).data(), forced.rows(), columns, &u_[first], w, true);
  };
  if (mode[0] != 0 && mode[1] != 0) return add(0, ends * of_end);
  for (int e = 0; e < ends; ++e)
    if (mode[e] != 0) add(of_end * e, of_end);
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
    turn.by_angle.middleRows<rows>(i * rows) << turn.cosine[i] * kept_.col(1) + turn.sine[i] * kept_.col(2),
        turn.cosine[i] * kept_.col(2) - turn.sine[i] * kept_.col(1);
  }
  return turn;
}

bool ContactFlow::solve(const LinearFlow::Table& table, double time, const double* s, const int* mode) {
  const double* x = LinearFlow::abscissae();
  product(table.free.data(), table.free.rows(), flow_.size(), s, free_.data(), false);
  const Turn& turn = turnOf(table);
  const Phase& begun = phaseAt(time);
  const double angle[] = {begun.cosine, begun.sine};
  product(turn.by_angle.data(), turn.by_angle.rows(), 2, angle, free_.data(), true);
  for (int i = 0; i <= points; ++i) {
    const double decay = begun.decay * turn.decay[i];
    free_.segment<rows>(i * rows) += kept_.col(0) + decay * kept_.col(3);
  }
  for (int i = 0; i <= points && drift_now_.size() > 0; ++i) {
    const double t = (i < points ? x[i] : 1.0) * table.h;
    free_.segment<rows>(i * rows) += t * kept_.col(4) + t * t * kept_.col(5);
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
    pushRows(table.forced, 0, mode);
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
        pushRows(table.forced_end, points * rows, mode);
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
  }
  statistics_.evaluations += unknowns_;
}

/// Whether the inverse that is there serves this step, too: the same table, and tangents and directions that
/// have changed by little (which the contraction that is measured tells of).
bool ContactFlow::stillFits(const LinearFlow::Table& table) const {
  if (made_h_ != table.h || made_unknowns_ != unknowns_) return false;
  for (int k = 0; k < unknowns_; ++k) {
    const EndContacts::Normal &now = normal_[k], &then = made_normal_[k];
    if (unknown_[k] != made_unknown_[k] || std::abs(now.slope - then.slope) > stale * then.slope ||
        std::abs(now.damping - then.damping) > stale * then.damping ||
        std::abs(now.x * then.y - now.y * then.x) > stale)
      return false;
  }
  return true;
}

/// N_i = k_i n_i.x_i + c_i n_i.v_i + ..., x_i and v_i moved by all u_j = -N_j e_j (e: the normal, turned by
/// the friction's share): the inverse of the matrix of N - k n.x(N) - c n.v(N), by columns.
template <int count>
void ContactFlow::linearise(const LinearFlow::Table& table) {
  constexpr int carrying = count / points;
  double weight[count][per_end];
  for (int k = 0; k < count; ++k) {
    const EndContacts::Normal& n = normal_[k];
    const double of_outputs[per_end] = {n.slope * n.x, n.slope * n.y, n.damping * n.x, n.damping * n.y};
    std::copy(std::begin(of_outputs), std::end(of_outputs), weight[k]);
  }
  int end[carrying];
  for (int c = 0; c < carrying; ++c) end[c] = unknown_[c * points] % ends;
  for (int l = 0; l < count; ++l) {
    const int column = LinearFlow::column(2 * end[l / points], l % points);
    const EndContacts::Normal& n = normal_[l];
    const double share = n.force != 0.0 ? -1.0 / n.force : 0.0;
    const double ex = share != 0.0 ? evaluated_[column] * share : n.x;
    const double ey = share != 0.0 ? evaluated_[column + 1] * share : n.y;
    const double *by_x = table.forced.col(column).data(), *by_y = by_x + points * rows;
    for (int c = 0; c < carrying; ++c)
      for (int i = 0; i < points; ++i) {
        const double *x = by_x + i * rows + end[c] * per_end, *y = by_y + i * rows + end[c] * per_end;
        const double* w = weight[c * points + i];
        double sum[2];  // of displacements and velocities, along each axis
        for (int axis = 0; axis < 2; ++axis)
          sum[axis] = w[axis] * (ex * x[axis] + ey * y[axis]) + w[2 + axis] * (ex * x[2 + axis] + ey * y[2 + axis]);
        inverse_[l][c * points + i] = sum[0] + sum[1];
      }
    inverse_[l][l] += 1.0;
  }
  made_h_ = table.h;
  made_unknowns_ = count;
  std::copy(std::begin(unknown_), std::end(unknown_), made_unknown_);
  std::copy(std::begin(normal_), std::end(normal_), made_normal_);
  // the matrix is near 1 where the step suits the contact; where it is not, the passes do not contract
  invert<count>(inverse_);
}

/// Newton's step in the normal forces; directions are those of the evaluation.
template <int count>
void ContactFlow::correct() {
  double moved[count] = {}, plain[count];  // Newton's step, the fixed point's
  for (int k = 0; k < count; ++k) {
    const int i = unknown_[k] / ends, e = unknown_[k] % ends;
    const double* u = &u_[LinearFlow::column(2 * e, i)];
    plain[k] = normal_[k].force + u[0] * normal_[k].x + u[1] * normal_[k].y;
  }
  for (int l = 0; l < count; ++l)
    for (int k = 0; k < count; ++k) moved[k] += inverse_[l][k] * plain[l];
  for (int k = 0; k < count; ++k) {
    const int i = unknown_[k] / ends, e = unknown_[k] % ends, column = LinearFlow::column(2 * e, i);
    const EndContacts::Normal& n = normal_[k];
    const double* const evaluated = &evaluated_[column];
    const double beyond = moved[k] - plain[k], share = beyond / n.force;
    u_[column] = evaluated[0] + (n.force != 0.0 ? share * evaluated[0] : -beyond * n.x);
    u_[column + 1] = evaluated[1] + (n.force != 0.0 ? share * evaluated[1] : -beyond * n.y);
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
  if (mode[0] != 0 && mode[1] != 0) {
    add(0, ends * of_end);
  } else {
    for (int e = 0; e < ends; ++e)
      if (mode[e] != 0) add(of_end * e, of_end);
  }
  if (pushes_ != nullptr) add(end_inputs * points, (flow_.inputs() - end_inputs) * points);
}

}  // namespace amb_rotor
