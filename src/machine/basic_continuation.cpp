#include "amb_rotor/machine/basic_continuation.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "amb_rotor/common/check.hpp"
#include "amb_rotor/common/linear_algebra.hpp"
#include "amb_rotor/common/units.hpp"

namespace amb_rotor {
namespace {

using Vector5 = Eigen::Matrix<double, 5, 1>;
using Matrix45 = Eigen::Matrix<double, 4, 5>;

/// A point of the branch: unknowns (4 states in phase units, scaled parameter), tangent and what was found.
struct Node {
  Vector5 u, tangent;
  BranchPoint point;
  Eigen::Matrix4d monodromy;
  double flip_test = 0.0, torus_test = 0.0;
};

constexpr std::size_t most_branches = 12;
constexpr double same_motion =
    1e-6;  // [clearance] above the corrector's 1e-9 times the growth along the orbit

class Follower {
 public:
  Follower(const ContinuationProblem& problem, const ContinuationOptions& options, int turns)
      : problem_(problem), options_(options), turns_(turns), scale_(options.to - options.from) {}

  double parameter(const Vector5& u) const { return u[4] * scale_; }

  Vector5 unknowns(const BasicState<double>& state, double value) const {
    const Eigen::Vector4d q = phaseUnits(state, problem_.machineAt(value).frequency_ratio);
    Vector5 u;
    u << q, value / scale_;
    return u;
  }

  /// Newton on P(q) = q and row . (u - anchor) = 0; empty: no convergence.
  std::optional<Node> correct(Vector5 u, const Vector5& anchor, const Vector5& row,
                              int* iterations = nullptr) const {
    for (int i = 0; i < 12; ++i) {
      const BasicParameters<double> machine = problem_.machineAt(parameter(u));
      if (!(machine.frequency_ratio > 0.0) || !u.allFinite() || u.head<4>().norm() > 100.0)
        return std::nullopt;
      BasicOrbitOptions orbit_options = problem_.orbit;
      orbit_options.direction = problem_.directionAt(parameter(u));
      const BasicOrbit orbit =
          basicOrbit(machine, timeUnits(u.head<4>(), machine.frequency_ratio), turns_, orbit_options);
      if (!orbit.finite) return std::nullopt;
      Vector5 residual;
      residual << phaseUnits(orbit.end, machine.frequency_ratio) - u.head<4>(), row.dot(u - anchor);
      Eigen::Matrix<double, 5, 5> jacobian;
      jacobian << orbit.monodromy - Eigen::Matrix4d::Identity(), scale_ * orbit.by_parameter, row.transpose();
      if (residual.head<4>().norm() < options_.newton_tolerance && std::abs(residual[4]) < 1e-9) {
        if (iterations != nullptr) *iterations = i;
        return node(u, orbit, row, jacobian.topRows<4>());
      }
      const Vector5 change = solveFullPivoting(jacobian, -residual);
      if (!change.allFinite() || change.norm() > 2.0) return std::nullopt;
      u += change;
    }
    return std::nullopt;
  }

  Node node(const Vector5& u, const BasicOrbit& orbit, const Vector5& row, const Matrix45& jacobian) const {
    Node n;
    n.u = u;
    n.monodromy = orbit.monodromy;
    // Tangent: null vector of the 4 x 5 Jacobian, in the sense of the row.
    n.tangent = nullVector(jacobian).normalized();
    if (n.tangent.dot(row) < 0.0) n.tangent = -n.tangent;
    Eigen::Vector4cd eigen = generalEigenvalues(orbit.monodromy);
    std::sort(eigen.data(), eigen.data() + 4, [](auto a, auto b) { return std::abs(a) > std::abs(b); });
    n.point.parameter = parameter(u);
    n.point.state = timeUnits(u.head<4>(), problem_.machineAt(parameter(u)).frequency_ratio);
    std::complex<double> flip = 1.0, torus = 1.0;
    for (int i = 0; i < 4; ++i) {
      n.point.multipliers[static_cast<std::size_t>(i)] = eigen[i];
      flip *= eigen[i] + 1.0;
      for (int j = 0; j < i; ++j) torus *= eigen[i] * eigen[j] - 1.0;
    }
    n.flip_test = flip.real();
    n.torus_test = torus.real();
    n.point.stable = std::abs(eigen[0]) < 1.0;
    n.point.max_radius = orbit.max_radius;
    n.point.contact_fraction = orbit.contact_fraction;
    n.point.touch_downs = orbit.touch_downs;
    return n;
  }

  std::optional<Node> step(const Node& from, double length, int* iterations = nullptr) const {
    const Vector5 predicted = from.u + length * from.tangent;
    return correct(predicted, predicted, from.tangent, iterations);
  }

  /// How far turns_ / factor turns move the motion, for each prime factor of its period: nothing where it has
  /// that smaller period.
  std::vector<Eigen::Vector4d> moved(const Node& n) const {
    std::vector<Eigen::Vector4d> all;
    const BasicParameters<double> machine = problem_.machineAt(n.point.parameter);
    for (int factor = 2, rest = turns_; rest > 1; ++factor) {
      if (rest % factor != 0) continue;
      while (rest % factor == 0) rest /= factor;
      const auto part = advanceBasic(machine, n.point.state, turns_ / factor, problem_.orbit);
      all.push_back(phaseUnits(part.end, machine.frequency_ratio) - n.u.head<4>());
    }
    return all;
  }

  /// The motion repeats earlier than after turns_.
  bool repeatsEarlier(const Node& n) const {
    for (const auto& shift : moved(n)) {
      if (shift.norm() < same_motion) return true;
    }
    return false;
  }

  /// Follows in one sense of the tangent.
  void follow(Node now, Branch& branch) const {
    double length = options_.first_step;
    const Vector5 origin = now.u, origin_tangent = now.tangent;
    for (int i = 0; i < options_.most_points; ++i) {
      if (options_.alive) options_.alive();
      int iterations = 0;
      const auto next = step(now, length, &iterations);
      // A tangent that turns sharply, or a jump to another branch, is a step too long.
      if (!next || next->tangent.dot(now.tangent) < 0.8) {
        length *= 0.5;
        if (length < options_.smallest_step) {
          branch.ended += "no further at " + std::to_string(now.point.parameter) + "; ";
          return;
        }
        continue;
      }
      if (joins(now, *next, length, branch)) return;
      detect(now, *next, length, branch);
      now = *next;
      branch.points.push_back(now.point);
      if (i > 10 && (now.u - origin).norm() < 0.6 * length && now.tangent.dot(origin_tangent) > 0.8) {
        branch.ended += "closed; ";
        return;
      }
      if (now.point.parameter < options_.from || now.point.parameter > options_.to) {
        branch.ended += "end of the range; ";
        return;
      }
      if (iterations <= 4) length = std::min(1.4 * length, options_.largest_step);
    }
    branch.ended += "most points; ";
  }

 private:
  template <class Crossed>
  Node bisect(const Node& from, double length, Crossed&& crossed) const {
    double low = 0.0, high = length;
    Node best = from;
    for (int i = 0; i < 30; ++i) {
      const double middle = 0.5 * (low + high);
      const auto node = step(from, middle);
      if (!node) break;
      best = *node;
      (crossed(best) ? high : low) = middle;
    }
    return best;
  }

  /// At the flip where a doubled motion ends, its two points meet and change places behind it (the same
  /// motion, half a period later), or the corrector lands on the motion of half the period: the branch ends
  /// there.
  bool joins(const Node& a, const Node& b, double length, Branch& branch) const {
    if (turns_ == 1) return false;
    const auto before = moved(a), after = moved(b);
    for (std::size_t i = 0; i < before.size(); ++i) {
      const bool on_it = after[i].norm() < same_motion;
      if (!on_it && before[i].dot(after[i]) > 0.0) continue;
      Node end = a;
      if (!on_it) end = bisect(a, length, [&](const Node& n) { return before[i].dot(moved(n)[i]) <= 0.0; });
      branch.points.push_back(end.point);
      branch.ended += "joins a motion of a smaller period at " + std::to_string(end.point.parameter) + "; ";
      return true;
    }
    return false;
  }

  void detect(const Node& a, const Node& b, double length, Branch& branch) const {
    const auto add = [&](BifurcationKind kind, const Node& node) {
      Bifurcation found{kind, node.point, {}};
      if (kind == BifurcationKind::flip) {
        const GeneralEigen eigen = generalEigen(node.monodromy);
        int at = 0;
        for (int i = 1; i < 4; ++i) {
          if (std::abs(eigen.values[i] + 1.0) < std::abs(eigen.values[at] + 1.0)) at = i;
        }
        for (int i = 0; i < 4; ++i)
          found.direction[static_cast<std::size_t>(i)] = eigen.vectors(i, at).real();
      }
      branch.bifurcations.push_back(found);
    };
    if (a.tangent[4] * b.tangent[4] < 0.0) {
      add(BifurcationKind::fold,
          bisect(a, length, [&](const Node& n) { return n.tangent[4] * a.tangent[4] < 0.0; }));
    }
    if (a.flip_test * b.flip_test < 0.0) {
      add(BifurcationKind::flip,
          bisect(a, length, [&](const Node& n) { return n.flip_test * a.flip_test < 0.0; }));
    }
    if (a.torus_test * b.torus_test < 0.0) {
      const Node n = bisect(a, length, [&](const Node& m) { return m.torus_test * a.torus_test < 0.0; });
      // The test also vanishes where two real multipliers have the product 1, which is no bifurcation.
      for (const auto& mu : n.point.multipliers) {
        if (std::abs(mu.imag()) > 1e-6 && std::abs(std::abs(mu) - 1.0) < 1e-3) {
          add(BifurcationKind::neimark_sacker, n);
          break;
        }
      }
    }
    if (a.point.touch_downs != b.point.touch_downs) {
      add(BifurcationKind::grazing,
          bisect(a, length, [&](const Node& n) { return n.point.touch_downs != a.point.touch_downs; }));
    }
  }

  const ContinuationProblem& problem_;
  ContinuationOptions options_;
  int turns_;
  double scale_;
};

std::optional<Branch> tryBranch(const ContinuationProblem& problem, const ContinuationOptions& options,
                                double at, const BasicState<double>& near, int turns) {
  const Follower follower(problem, options, turns);
  Vector5 row = Vector5::Zero();
  row[4] = 1.0;
  const Vector5 u = follower.unknowns(near, at);
  const auto start = follower.correct(u, u, row);
  if (!start || follower.repeatsEarlier(*start)) return std::nullopt;
  Branch branch;
  branch.turns = turns;
  Node back = *start;
  back.tangent = -back.tangent;
  follower.follow(back, branch);
  std::reverse(branch.points.begin(), branch.points.end());
  branch.points.push_back(start->point);
  follower.follow(*start, branch);
  return branch;
}

/// The branch of twice the period that begins at a flip: points along the eigenvector of -1, on both sides.
std::optional<Branch> doubledBranch(const ContinuationProblem& problem, const ContinuationOptions& options,
                                    const Branch& branch, const Bifurcation& flip) {
  const double scale = options.to - options.from;
  for (double shift : {1e-3, -1e-3, 4e-3, -4e-3, 2e-4, -2e-4}) {
    const double at = flip.at.parameter + shift * scale;
    for (double size : {0.02, 0.05, 0.1}) {
      Eigen::Vector4d q = phaseUnits(flip.at.state, problem.machineAt(flip.at.parameter).frequency_ratio);
      for (int i = 0; i < 4; ++i) q[i] += size * flip.direction[static_cast<std::size_t>(i)];
      const Follower follower(problem, options, 2 * branch.turns);
      Vector5 row = Vector5::Zero();
      row[4] = 1.0;
      Vector5 u;
      u << q, at / scale;
      const auto found = follower.correct(u, u, row);
      if (!found) continue;
      if (follower.repeatsEarlier(*found)) continue;  // the motion that it branches from
      const auto& s = found->point.state;
      if (std::hypot(s.x - flip.at.state.x, s.y - flip.at.state.y) > 0.3) continue;
      return tryBranch(problem, options, at, s, 2 * branch.turns);
    }
  }
  return std::nullopt;
}

/// Both ends of a bubble of doubled period are flips: the branch is followed from one of them only.
bool begins(const Branch& branch, const Bifurcation& flip, double range) {
  for (const auto& point : branch.points) {
    if (std::abs(point.parameter - flip.at.parameter) < 2e-3 * range &&
        std::hypot(point.state.x - flip.at.state.x, point.state.y - flip.at.state.y) < 0.03) {
      return true;
    }
  }
  return false;
}

}  // namespace

const char* name(BifurcationKind kind) {
  switch (kind) {
    case BifurcationKind::fold:
      return "fold";
    case BifurcationKind::flip:
      return "flip";
    case BifurcationKind::neimark_sacker:
      return "neimark_sacker";
    case BifurcationKind::grazing:
      return "grazing";
  }
  return "";
}

BasicParameters<double> ContinuationProblem::machineAt(double value) const {
  NamedValues all = parameters;
  all.emplace_back(parameter, value);
  return rotatedToPhaseZero(basicParametersFrom(all));
}

BasicParameters<double> ContinuationProblem::directionAt(double value) const {
  // Fields are linear in a name's value, or a power, sine or cosine of it: the third derivative is of the
  // field's size (degrees: (pi/180)^3 of it), so that the quotient is right to 1e-9, far finer than Newton's
  // method needs.
  const double step = 1e-5 * std::max(1.0, std::abs(value));
  BasicParameters<double> direction = machineAt(value + step);
  const BasicParameters<double> lower = machineAt(value - step);
  std::vector<double> below;
  BasicParameters<double>::visit(lower, [&](const char*, const double& field) { below.push_back(field); });
  std::size_t i = 0;
  BasicParameters<double>::visit(
      direction, [&](const char*, double& field) { field = (field - below[i++]) / (2.0 * step); });
  return direction;
}

Branch followBranch(const ContinuationProblem& problem, const ContinuationOptions& options, double at,
                    const BasicState<double>& near, int turns) {
  auto branch = tryBranch(problem, options, at, near, turns);
  if (!branch) {
    throw InputError({{"", 0, "continuation.starts", std::to_string(at),
                       "no motion of period " + std::to_string(turns) + " near the state given"}});
  }
  return *branch;
}

ContinuationProblem continuationProblem(const BasicSweep& sweep) {
  const ContinuationRequest& request = sweep.continuation;
  ContinuationProblem problem;
  problem.parameter = request.parameter;
  for (const auto& [key, value] : sweep.parameters) {
    if (key != request.parameter) problem.parameters.emplace_back(key, value);
  }
  if (request.parameter == "unbalance_phase_deg") {
    throw InputError({{"", 0, "continuation.parameter", request.parameter,
                       "turns the whole motion; misalignment_angle_deg can be followed"}});
  }
  if (request.parameter == "friction_sign") {
    throw InputError({{"", 0, "continuation.parameter", request.parameter, "cannot be followed"}});
  }
  for (const auto& axis : sweep.swept) {
    if (axis.parameter != request.parameter) {
      throw InputError({{"", 0, "continuation.parameter", request.parameter,
                         axis.parameter + " is swept, so it has no value here: follow the swept parameter"}});
    }
  }
  problem.orbit.contact = sweep.run.contact;
  problem.orbit.friction = sweep.run.friction;
  return problem;
}

std::vector<Branch> runContinuation(const BasicSweep& sweep, const std::function<void()>& alive) {
  const ContinuationRequest& request = sweep.continuation;
  const ContinuationProblem problem = continuationProblem(sweep);
  ContinuationOptions options;
  options.from = request.from;
  options.to = request.to;
  options.first_step = request.first_step;
  options.alive = alive;
  std::vector<Branch> branches;
  for (const auto& start : request.starts) {
    BasicLaneOptions run = sweep.run;
    run.turns_skipped = 960;  // a multiple of every period up to 6, so that the phase of the motion is kept
    run.turns_kept = 0;
    NamedValues values = problem.parameters;
    values.emplace_back(problem.parameter, start.at);
    const auto initial = overOwnClearance({start.x, start.y, start.vx, start.vy}, values);
    const auto settled = runBasicLanes({problem.machineAt(start.at)}, {initial}, run).end.front();
    branches.push_back(followBranch(problem, options, start.at, settled, start.turns));
  }
  for (std::size_t i = 0; i < branches.size() && branches.size() < most_branches; ++i) {
    if (2 * branches[i].turns > options.most_turns) continue;
    const auto flips = branches[i].bifurcations;
    for (const auto& flip : flips) {
      if (flip.kind != BifurcationKind::flip) continue;
      bool known = false;
      for (const auto& other : branches) {
        known =
            known || (other.turns == 2 * branches[i].turns && begins(other, flip, options.to - options.from));
      }
      if (known) continue;
      const auto doubled = doubledBranch(problem, options, branches[i], flip);
      if (doubled) branches.push_back(*doubled);
    }
  }
  return branches;
}

}  // namespace amb_rotor
