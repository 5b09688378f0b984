#include "amb_rotor/machine/basic_harmonic_balance.hpp"

#include <cmath>

#include "amb_rotor/common/linear_algebra.hpp"
#include "amb_rotor/common/units.hpp"
#include "basic_laws.hpp"

namespace amb_rotor {
namespace {

using Four = Dual<double, 4>;
using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Values, slopes and projection between the coefficients and the instants.
struct Basis {
  MatrixXd value, slope, project;
  VectorXd second;       ///< factor of the second derivative of each coefficient
  ArrayXd cosine, sine;  ///< of the phase at the instants

  Basis(int turns, int harmonics, Index instants) {
    const Index size = 2 * harmonics + 1;
    value.resize(instants, size);
    slope.resize(instants, size);
    second = VectorXd::Zero(size);
    cosine.resize(instants);
    sine.resize(instants);
    value.col(0).setOnes();
    slope.col(0).setZero();
    for (Index i = 0; i < instants; ++i) {
      const double angle = two_pi * static_cast<double>(i) / static_cast<double>(instants);
      cosine[i] = std::cos(turns * angle);
      sine[i] = std::sin(turns * angle);
      for (int k = 1; k <= harmonics; ++k) {
        const double order = static_cast<double>(k) / turns;
        // k i modulo the instants keeps the argument small.
        const double at = two_pi * static_cast<double>((k * i) % instants) / static_cast<double>(instants);
        value(i, 2 * k - 1) = std::cos(at);
        value(i, 2 * k) = std::sin(at);
        slope(i, 2 * k - 1) = -order * std::sin(at);
        slope(i, 2 * k) = order * std::cos(at);
        second[2 * k - 1] = second[2 * k] = -order * order;
      }
    }
    project = value.transpose() * (2.0 / static_cast<double>(instants));
    project.row(0) *= 0.5;
  }
};

/// Accelerations at the instants, with their derivatives by x, y, x', y' (columns).
struct Field {
  VectorXd ax, ay;
  MatrixXd dax, day;
};

template <class Model>
Field fieldAt(const BasicCoefficients<double>& c, const Basis& basis, const VectorXd& x, const VectorXd& y) {
  const VectorXd px = basis.value * x, py = basis.value * y, vx = basis.slope * x, vy = basis.slope * y;
  const Index count = px.size();
  Field field{VectorXd(count), VectorXd(count), MatrixXd(count, 4), MatrixXd(count, 4)};
  for (Index i = 0; i < count; ++i) {
    Four q[4] = {Four(px[i]), Four(py[i]), Four(vx[i]), Four(vy[i])}, ax, ay;
    for (int j = 0; j < 4; ++j) q[j].slope[j] = 1.0;
    Model::acceleration(c, c.forcing * basis.cosine[i], c.forcing * basis.sine[i], q[0], q[1], q[2], q[3], ax,
                        ay);
    field.ax[i] = ax.value;
    field.ay[i] = ay.value;
    for (int j = 0; j < 4; ++j) {
      field.dax(i, j) = ax.slope[j];
      field.day(i, j) = ay.slope[j];
    }
  }
  return field;
}

template <class Model>
void solve(const BasicCoefficients<double>& c, const Basis& basis, const HarmonicBalanceOptions& options,
           HarmonicBalance& out) {
  const Index size = out.x.size();
  const auto residualOf = [&](const Field& field, const VectorXd& x, const VectorXd& y) {
    VectorXd r(2 * size);
    r << basis.second.cwiseProduct(x) - basis.project * field.ax,
        basis.second.cwiseProduct(y) - basis.project * field.ay;
    return r;
  };
  Field field = fieldAt<Model>(c, basis, out.x, out.y);
  VectorXd residual = residualOf(field, out.x, out.y);
  for (; out.iterations < options.most_iterations; ++out.iterations) {
    out.residual = residual.lpNorm<Eigen::Infinity>();
    if (out.residual < options.tolerance) break;
    MatrixXd jacobian(2 * size, 2 * size);
    for (int row = 0; row < 2; ++row) {
      const MatrixXd& d = row == 0 ? field.dax : field.day;
      for (int column = 0; column < 2; ++column) {
        jacobian.block(row * size, column * size, size, size) =
            -basis.project *
            (d.col(column).asDiagonal() * basis.value + d.col(column + 2).asDiagonal() * basis.slope);
      }
      jacobian.block(row * size, row * size, size, size).diagonal() += basis.second;
    }
    const VectorXd change = solveLu(jacobian, VectorXd(-residual));
    if (!change.allFinite()) return;
    double share = 1.0;
    bool better = false;
    for (; share > 1e-3 && !better; share *= 0.5) {
      const VectorXd x = out.x + share * change.head(size), y = out.y + share * change.tail(size);
      const Field next = fieldAt<Model>(c, basis, x, y);
      const VectorXd r = residualOf(next, x, y);
      if (!(r.norm() < residual.norm())) continue;
      better = true;
      out.x = x;
      out.y = y;
      field = next;
      residual = r;
    }
    if (!better) break;  // at round-off, or stuck
  }
  out.residual = residual.lpNorm<Eigen::Infinity>();
  out.converged = out.residual < options.tolerance;
}

}  // namespace

HarmonicBalance harmonicBalance(const BasicParameters<double>& given,
                                const std::vector<BasicState<double>>& guess,
                                const HarmonicBalanceOptions& options) {
  if (options.turns < 1 || options.harmonics < options.turns) {
    throw InputError({{"", 0, "harmonics", std::to_string(options.harmonics),
                       "at least one turn, and at least as many harmonics as turns"}});
  }
  const BasicParameters<double> p = rotatedToPhaseZero(given);
  const double eta = p.frequency_ratio;
  const Basis basis(options.turns, options.harmonics, 8 * static_cast<Index>(options.harmonics));
  HarmonicBalance out;
  out.x = out.y = VectorXd::Zero(2 * options.harmonics + 1);
  if (guess.empty()) {
    // Without contact: (k - eta^2 + j d eta) z = eta^2 e exp(j phi).
    const double real = p.support_stiffness - eta * eta, imaginary = p.damping * eta;
    const double force = eta * eta * p.eccentricity / (real * real + imaginary * imaginary);
    const Index first = 2 * options.turns - 1;
    out.x[first] = out.y[first + 1] = force * real;
    out.x[first + 1] = force * imaginary;
    out.y[first] = -force * imaginary;
  } else {
    const auto count = static_cast<Index>(guess.size());
    const int kept = static_cast<int>(std::min<Index>(options.harmonics, (count - 1) / 2));
    const Basis sampled(options.turns, kept, count);
    VectorXd x(count), y(count);
    for (Index i = 0; i < count; ++i) {
      const auto s = rotated(guess[static_cast<std::size_t>(i)], -given.unbalance_phase);
      x[i] = s.x;
      y[i] = s.y;
    }
    out.x.head(2 * kept + 1) = sampled.project * x;
    out.y.head(2 * kept + 1) = sampled.project * y;
  }
  withBasicModel(options.contact, options.friction, [&](auto model) {
    using Model = decltype(model);
    solve<Model>(basicCoefficients<typename Model::Contact>(p, 1.0 / eta), basis, options, out);
  });
  const Index size = out.x.size(), last = std::max<Index>(2, size / 10);
  out.last_harmonics =
      std::max(out.x.tail(last).lpNorm<Eigen::Infinity>(), out.y.tail(last).lpNorm<Eigen::Infinity>());
  out.state = rotated({basis.value.row(0).dot(out.x), basis.value.row(0).dot(out.y),
                       eta * basis.slope.row(0).dot(out.x), eta * basis.slope.row(0).dot(out.y)},
                      given.unbalance_phase);
  return out;
}

}  // namespace amb_rotor
