// Tables of a step's length: what the motion and forces as polynomials through Gauss's nodes do at the nodes and at the end.
#include <Eigen/LU>
#include <cmath>

#include "amb_rotor/integration/linear_flow.hpp"

namespace amb_rotor {
namespace {

constexpr int flow_nodes = LinearFlow::nodes;

struct Gauss {
  double x[flow_nodes] = {0.06943184420297371, 0.33000947820757187, 0.66999052179242813, 0.93056815579702629};
  double weight[flow_nodes] = {0.17392742256872693, 0.32607257743127307, 0.32607257743127307,
                               0.17392742256872693};
  double lagrange[flow_nodes][flow_nodes];  ///< L_j(x) = sum_p lagrange[j][p] x^p
  double top[flow_nodes];                   ///< coefficient of the highest Legendre polynomial, of the values
  double top_value[flow_nodes];             ///< that polynomial
  Gauss() {
    Eigen::Matrix<double, flow_nodes, flow_nodes> powers;
    for (int i = 0; i < flow_nodes; ++i)
      for (int p = 0; p < flow_nodes; ++p) powers(i, p) = std::pow(x[i], p);
    const Eigen::Matrix<double, flow_nodes, flow_nodes> inverted = powers.inverse();
    for (int j = 0; j < flow_nodes; ++j)
      for (int p = 0; p < flow_nodes; ++p) lagrange[j][p] = inverted(p, j);
    const auto legendre = [](double at) {  // P_3 on [0, 1]
      const double t = 2.0 * at - 1.0;
      return 0.5 * t * (5.0 * t * t - 3.0);
    };
    for (int i = 0; i < flow_nodes; ++i) {
      top_value[i] = legendre(x[i]);
      top[i] = top_value[i] * weight[i] * (2 * (flow_nodes - 1) + 1);
    }
  }
};
const Gauss gauss_rule;

struct Reciprocal {
  double value[64] = {};
  Reciprocal() {
    for (int k = 1; k < 64; ++k) value[k] = 1.0 / k;
  }
  double operator[](int k) const { return value[k]; }
};
const Reciprocal reciprocal;

/// int_0^t exp(lambda (t - r)) (r/h)^p dr for p = 0 .. m-1, for t = x h. By parts, with I_p the integral:
///   lambda I_p = (p/h) I_(p-1) - x^p,
/// upwards where lambda t is large; downwards from a series where it is small, which would lose digits
/// upwards.
void moments(std::complex<double> lambda, double h, double x, std::complex<double> e,
             std::complex<double>* out) {
  const double t = x * h;
  const double zr = lambda.real() * t, zi = lambda.imag() * t;
  if (zr * zr + zi * zi < 2.25) {
    double re = 1.0 / flow_nodes, im = 0.0, sum_re = re, sum_im = 0.0;
    for (int q = 1; q < 30 && std::abs(re) + std::abs(im) > 1e-17; ++q) {
      const double next = (zr * re - zi * im) * reciprocal[flow_nodes + q];
      im = (zr * im + zi * re) * reciprocal[flow_nodes + q];
      re = next;
      sum_re += re;
      sum_im += im;
    }
    double power = t;
    for (int p = 1; p < flow_nodes; ++p) power *= x;
    out[flow_nodes - 1] = std::complex<double>(power * sum_re, power * sum_im);
    for (int p = flow_nodes - 1; p > 0; --p) {
      power /= x;  // t x^(p-1)
      const std::complex<double> before = out[p];
      const double scale = h / p;
      out[p - 1] = {scale * (lambda.real() * before.real() - lambda.imag() * before.imag() + power * x / t),
                    scale * (lambda.real() * before.imag() + lambda.imag() * before.real())};
    }
    return;
  }
  const std::complex<double> inverse = 1.0 / lambda;
  double power = 1.0;
  out[0] = (e - 1.0) * inverse;
  for (int p = 1; p < flow_nodes; ++p) {
    power *= x;
    out[p] = (double(p) / h * out[p - 1] - power) * inverse;
  }
}

}  // namespace

const double* LinearFlow::abscissae() { return gauss_rule.x; }

void LinearFlow::interpolation(double x, double* weight) {
  for (int j = 0; j < flow_nodes; ++j) {
    double value = 0.0;
    for (int p = flow_nodes - 1; p >= 0; --p) value = value * x + gauss_rule.lagrange[j][p];
    weight[j] = value;
  }
}

LinearFlow::Table LinearFlow::emptyTable() const {
  Table t;
  t.real.setZero(modes());
  t.imaginary.setZero(modes());
  t.free.setZero((flow_nodes + 1) * outputs(), size());
  t.forced.setZero(flow_nodes * outputs(), inputs() * flow_nodes);
  t.forced_end.setZero(outputs(), inputs() * flow_nodes);
  t.response.setZero(size(), inputs() * flow_nodes);
  t.parts.setZero(3 * outputs(), inputs() * flow_nodes);
  return t;
}

void LinearFlow::build(double h, Table& table) const {
  constexpr int points = flow_nodes + 1;  // the nodes, the end
  table.h = h;
  const int n = modes(), rows = outputs();
  table.forced.setZero();
  table.forced_end.setZero();
  const auto abscissa = [](int point) { return point < flow_nodes ? gauss_rule.x[point] : 1.0; };
  const auto free = [&](int output, int point) {
    return point < flow_nodes ? row(output, point) : flow_nodes * rows + output;
  };
  // adds to an output's rows for an input at a node
  const auto push = [&](int output, int at, const double* first, double by_first, const double* second,
                        double by_second) {
    double* to = &table.forced(row(output, 0), at);
    for (int i = 0; i < flow_nodes; ++i) to[i] += first[i] * by_first + second[i] * by_second;
    table.forced_end(output, at) += first[flow_nodes] * by_first + second[flow_nodes] * by_second;
  };
  for (int k = 0; k < n; ++k) {
    double real[flow_nodes][points], imaginary[flow_nodes][points];  // of a force at a node, at a point
    for (int point = 0; point < points; ++point) {
      const double x = abscissa(point);
      const std::complex<double> e = std::exp(lambda_[k] * (x * h));
      for (int o = 0; o < rows; ++o) {
        table.free(free(o, point), k) = c_(o, k) * e.real() + c_(o, n + k) * e.imag();
        table.free(free(o, point), n + k) = -c_(o, k) * e.imag() + c_(o, n + k) * e.real();
      }
      if (point == flow_nodes) {
        table.real[k] = e.real();
        table.imaginary[k] = e.imag();
      }
      std::complex<double> power[flow_nodes];
      moments(lambda_[k], h, x, e, power);
      for (int j = 0; j < flow_nodes; ++j) {
        double re = 0.0, im = 0.0;
        for (int p = 0; p < flow_nodes; ++p) {
          re += gauss_rule.lagrange[j][p] * power[p].real();
          im += gauss_rule.lagrange[j][p] * power[p].imag();
        }
        real[j][point] = re;
        imaginary[j][point] = im;
      }
    }
    for (int at = transfer_begin_[k]; at < transfer_begin_[k + 1]; ++at) {
      const Transfer& q = transfer_[at];
      const int by = k * inputs() + q.input;
      for (int o = q.output; o < q.output + q.outputs; ++o)
        for (int j = 0; j < flow_nodes; ++j)
          push(o, column(q.input, j), real[j], carried_real_(o, by), imaginary[j],
               -carried_imaginary_(o, by));
    }
    for (int i = 0; i < inputs(); ++i)
      for (int j = 0; j < flow_nodes; ++j) {
        const int at = column(i, j);
        const double re = real[j][flow_nodes], im = imaginary[j][flow_nodes];
        table.response(k, at) = re * b_(k, i) - im * b_(n + k, i);
        table.response(n + k, at) = re * b_(n + k, i) + im * b_(k, i);
      }
  }
  if (zeros_ > 0) {
    // int (1 + J (t - r)) (r/h)^p dr
    double once[flow_nodes][points] = {}, twice[flow_nodes][points] = {};
    for (int point = 0; point < points; ++point) {
      const double x = abscissa(point), t = x * h;
      for (int o = 0; o < rows; ++o)
        table.free.row(free(o, point)).tail(zeros_) = c_.row(o).tail(zeros_) + t * later_seen_.row(o);
      for (int j = 0; j < flow_nodes; ++j) {
        double power = t;
        for (int p = 0; p < flow_nodes; ++p, power *= x) {
          once[j][point] += gauss_rule.lagrange[j][p] * power / (p + 1);
          twice[j][point] += gauss_rule.lagrange[j][p] * power * t / ((p + 1) * (p + 2));
        }
      }
    }
    for (int i = 0; i < inputs(); ++i)
      for (int j = 0; j < flow_nodes; ++j) {
        const int at = column(i, j);
        for (int o = 0; o < rows; ++o) push(o, at, once[j], drifts_(o, i), twice[j], later_drifts_(o, i));
        table.response.col(at).tail(zeros_) =
            once[j][flow_nodes] * b_.col(i).tail(zeros_) + twice[j][flow_nodes] * later_pushed_.col(i);
      }
  }
  for (int i = 0; i < inputs(); ++i)
    for (int o = 0; o < rows; ++o) {
      double constant = 0.0, highest = 0.0;
      for (int j = 0; j < flow_nodes; ++j) {
        const double response = table.forced_end(o, column(i, j));
        constant += response;
        highest += response * gauss_rule.top_value[j];
      }
      for (int j = 0; j < flow_nodes; ++j) {
        table.parts(o, column(i, j)) = highest * gauss_rule.top[j];
        table.parts(rows + o, column(i, j)) = constant * gauss_rule.weight[j];
        table.parts(2 * rows + o, column(i, j)) = constant * gauss_rule.top[j];
      }
    }
}

}  // namespace amb_rotor
