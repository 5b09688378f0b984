// Newton's method on contact forces and the plain laws, by every instruction set that this processor has,
// against Eigen's inverse and the law of one end.
#include "amb_rotor/integration/contact_newton.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <string>
#include <vector>

#include "../../src/machine/plain_law.hpp"

namespace amb_rotor {
namespace {

constexpr int all = ContactNodes::most, per_end = 4, rows = per_end * all, columns = 2 * all;

struct ContactSet {
  std::string name;
  ContactKernels kernels;
  PlainForces forces;
};

std::vector<ContactSet> contactSetsHere() {
  std::vector<ContactSet> sets = {{"baseline", contactKernelsBaseline(), plainForcesBaseline()}};
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && plainForcesAvx2() != nullptr)
    sets.push_back({"AVX2", contactKernelsAvx2(), plainForcesAvx2()});
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
      plainForcesAvx512() != nullptr)
    sets.push_back({"AVX-512", contactKernelsAvx512(), plainForcesAvx512()});
#endif
  return sets;
}

/// Both ends, one of them, or the other.
struct Ends {
  int first, count;
};
const Ends cases[] = {{0, 2}, {0, 1}, {1, 1}};

PlainLaw plainLaw(bool hertz, double surface_speed) {
  PlainLaw law;
  law.known = true;
  law.hertz = hertz;
  law.clearance = 2e-4;
  law.stiffness = hertz ? 2.4e9 : 3e7;
  law.compliance = 1.0 / law.stiffness;
  law.damping = hertz ? 0.5 : 400.0;
  law.friction = 0.1;
  law.surface_speed = surface_speed;
  return law;
}

/// Outputs at the nodes: some ends inside the clearance, some outside.
Eigen::VectorXd outputsNearTheRim() {
  Eigen::VectorXd w = Eigen::VectorXd::Random(rows);
  for (int end = 0; end < 2; ++end)
    for (int i = 0; i < ContactNodes::nodes; ++i) {
      const double angle = 3.0 * w[LinearFlow::row(per_end * end, i)];
      const double radius = 2e-4 + 1e-5 * (i == 1 ? -1.0 : 1.0 + i);
      w[LinearFlow::row(per_end * end, i)] = radius * std::cos(angle);
      w[LinearFlow::row(per_end * end + 1, i)] = radius * std::sin(angle);
      w[LinearFlow::row(per_end * end + 2, i)] *= 0.3;
      w[LinearFlow::row(per_end * end + 3, i)] *= 0.3;
    }
  return w;
}

TEST(PlainForces, AllSetsGiveTheLawOfOneEndAtEachNodeAndTouchNoOtherEnd) {
  constexpr double untouched = 77.0;
  for (const ContactSet& set : contactSetsHere())
    for (const bool hertz : {false, true})
      for (const double speed : {7.5, 0.0, -7.5})  // slides either way, or next to nothing
        for (const Ends& ends : cases) {
          const PlainLaw law = plainLaw(hertz, speed);
          const Eigen::VectorXd w = outputsNearTheRim();
          Eigen::VectorXd u = Eigen::VectorXd::Constant(columns, untouched);
          ContactNodes nodes;
          set.forces(law, ends.first, ends.count, w.data(), u.data(), nodes);
          for (int end = 0; end < 2; ++end)
            for (int i = 0; i < ContactNodes::nodes; ++i) {
              const int k = end * ContactNodes::nodes + i;
              const double ux = u[LinearFlow::column(2 * end, i)], uy = u[LinearFlow::column(2 * end + 1, i)];
              if (end < ends.first || end >= ends.first + ends.count) {
                EXPECT_EQ(ux, untouched);
                EXPECT_EQ(uy, untouched);
                EXPECT_EQ(nodes.force[k], 0.0);
                continue;
              }
              double at[per_end], expected[2];
              for (int o = 0; o < per_end; ++o) at[o] = w[LinearFlow::row(per_end * end + o, i)];
              EndContacts::Normal normal;
              const double guard = law.force(at, expected, normal);
              const std::string where =
                  set.name + (hertz ? " Hertz" : " linear") + ", node " + std::to_string(k);
              // round-off of a depth that is the difference of lengths twenty times its own
              const double close = 1e-11 * (normal.slope * 1e-5 + std::abs(normal.force) + 1e-12);
              EXPECT_NEAR(nodes.force[k], normal.force, close) << where;
              EXPECT_NEAR(ux, expected[0], close) << where;
              EXPECT_NEAR(uy, expected[1], close) << where;
              EXPECT_NEAR(nodes.slope[k], normal.slope, 1e-11 * normal.slope) << where;
              EXPECT_NEAR(nodes.damping[k], normal.damping, 1e-11 * (std::abs(normal.damping) + 1e-9))
                  << where;
              EXPECT_NEAR(nodes.x[k], normal.x, 1e-15) << where;
              EXPECT_NEAR(nodes.y[k], normal.y, 1e-15) << where;
              EXPECT_NEAR(nodes.guard[k], guard, 1e-15) << where;
            }
        }
}

/// A step of a machine that answers forces somehow, and Newton's matrix of it as the header has it.
struct NewtonCase {
  Eigen::MatrixXd forced = 1e-8 * Eigen::MatrixXd::Random(rows, columns);
  Eigen::VectorXd evaluated = Eigen::VectorXd::Zero(columns), u = 30.0 * Eigen::VectorXd::Random(columns);
  ContactNodes nodes;

  NewtonCase() {
    plainForcesBaseline()(plainLaw(true, 7.5), 0, 2, outputsNearTheRim().data(), evaluated.data(), nodes);
    for (int end = 0; end < 2; ++end)  // velocities answer more than places do
      forced.middleRows(LinearFlow::row(per_end * end + 2, 0), 2 * ContactNodes::nodes) *= 1e4;
  }
  /// Of the ends: N - k n.x(N) - c n.v(N), x and v moved by -N e.
  Eigen::MatrixXd matrix(const Ends& ends) const {
    const int n = ContactNodes::nodes, size = ends.count * n;
    Eigen::MatrixXd out = Eigen::MatrixXd::Identity(size, size);
    for (int row = 0; row < size; ++row)
      for (int column = 0; column < size; ++column) {
        const int by = ends.first * n + column, at = ends.first * n + row, end = at / n, node = at % n;
        const int x = LinearFlow::column(by / n * 2, by % n), y = LinearFlow::column(by / n * 2 + 1, by % n);
        const double force = nodes.force[by];
        const double ex = force != 0.0 ? -evaluated[x] / force : nodes.x[by];
        const double ey = force != 0.0 ? -evaluated[y] / force : nodes.y[by];
        const Eigen::VectorXd moved = forced.col(x) * ex + forced.col(y) * ey;
        const auto of = [&](int output) { return moved[LinearFlow::row(per_end * end + output, node)]; };
        out(row, column) += nodes.slope[at] * (nodes.x[at] * of(0) + nodes.y[at] * of(1)) +
                            nodes.damping[at] * (nodes.x[at] * of(2) + nodes.y[at] * of(3));
      }
    return out;
  }
};

TEST(ContactNewton, AllSetsInvertTheMatrixAndTakeItsStep) {
  for (const ContactSet& set : contactSetsHere())
    for (const Ends& ends : cases) {
      const NewtonCase step;
      const int n = ContactNodes::nodes, size = ends.count * n;
      const Eigen::MatrixXd matrix = step.matrix(ends), expected = matrix.inverse();
      ASSERT_GT((matrix - Eigen::MatrixXd::Identity(size, size)).norm(), 0.1) << "the test is about a matrix";
      alignas(64) double inverse[all][all];
      set.kernels.linearise(ends.first, ends.count, step.forced.data(), step.nodes, step.evaluated.data(),
                            inverse);
      for (int row = 0; row < size; ++row)
        for (int column = 0; column < size; ++column)
          EXPECT_NEAR(inverse[column][row], expected(row, column), 1e-12 * expected.norm()) << set.name;
      Eigen::VectorXd u = step.u, plain(size);
      set.kernels.correct(ends.first, ends.count, step.nodes, step.evaluated.data(), inverse, u.data());
      const auto component = [&](const Eigen::VectorXd& of, int k, int axis) {
        return of[LinearFlow::column(2 * (k / n) + axis, k % n)];
      };
      for (int k = 0; k < size; ++k) {
        const int at = ends.first * n + k;
        plain[k] = step.nodes.force[at] + component(step.u, at, 0) * step.nodes.x[at] +
                   component(step.u, at, 1) * step.nodes.y[at];
      }
      const Eigen::VectorXd beyond = expected * plain - plain;
      for (int k = 0; k < 2 * n; ++k)
        for (int axis = 0; axis < 2; ++axis) {
          const int at = k - ends.first * n;
          double wanted = component(step.u, k, axis);
          if (at >= 0 && at < size) {
            const double force = step.nodes.force[k], evaluated = component(step.evaluated, k, axis);
            const double normal = axis == 0 ? step.nodes.x[k] : step.nodes.y[k];
            wanted = evaluated + (force != 0.0 ? beyond[at] / force * evaluated : -beyond[at] * normal);
          }
          EXPECT_NEAR(component(u, k, axis), wanted, 1e-11 * (std::abs(wanted) + 1.0))
              << set.name << " " << k;
        }
    }
}

TEST(ContactNewton, TheLargestChangeIsInItsUnitsAndOfTheEndsThatCarry) {
  for (const ContactSet& set : contactSetsHere())
    for (const Ends& ends : cases)
      for (int r = 0; r < rows; ++r) {
        const Eigen::VectorXd before = Eigen::VectorXd::Random(rows);
        Eigen::VectorXd w = before;
        w[r] += r % 3 == 0 ? 0.25 : -0.25;
        const int end = r / (per_end * ContactNodes::nodes), output = r / ContactNodes::nodes % per_end;
        const bool seen = end >= ends.first && end < ends.first + ends.count;
        const double expected = seen ? 0.25 / (output < 2 ? 0.5 : 2.0) : 0.0;
        EXPECT_NEAR(set.kernels.change(ends.first, ends.count, w.data(), before.data(), 0.5, 2.0), expected,
                    1e-14)
            << set.name;
      }
}

}  // namespace
}  // namespace amb_rotor
