#pragma once
// A step of a machine whose equations out of contact are linear (machine/linear_lanes.hpp), exact at a constant speed.
//
// Between two instants, with y' = A y + B i_f + g + what turns:
//   commands c are held,  i - c = e,  e' = -a e,   lags z - c = l,  l' = r (e - l),   i_f = i or the weighted sum of z,
//   angle' = W
// are linear too:  w = (y, u), u = (e, l, c, 1, turning pairs), w' = [A B; 0 D] w. A step of length h multiplies y and u
// with the upper rows of the exponential of that matrix, found once by halving h, Taylor's series and squaring; u itself is
// known in closed form.
#include <algorithm>
#include <cmath>
#include <vector>

#include "amb_rotor/machine/linear_lanes.hpp"
#include "amb_rotor/machine/simulator.hpp"

namespace amb_rotor {

/// The upper rows of the exponential for one step.
template <class S>
class LinearStep {
 public:
  LinearStep(const LinearLanes<S>& linear, const CurrentTrack<S>& track, double dt_s)
      : dt_(dt_s), n_(linear.size()), lags_(static_cast<int>(track.rates().size())) {
    inputs_ = inputs(track);
    fill(linear, track);
  }

  /// y at the end of the step, from w = (y, u) at its beginning.
  void move(const S* w, S* out) const {
    for (const Block& block : blocks_) {
      S s0(0.0), s1(0.0), s2(0.0), s3(0.0);
      const S* m = matrix_.data() + block.values;
      for (int k = block.first; k < block.last; ++k, m += rows_of_block) {
        const S& x = w[sources_[k]];
        s0 = multiplyAdd(m[0], x, s0);
        s1 = multiplyAdd(m[1], x, s1);
        s2 = multiplyAdd(m[2], x, s2);
        s3 = multiplyAdd(m[3], x, s3);
      }
      const S sum[rows_of_block] = {s0, s1, s2, s3};
      for (int k = 0; k < block.count; ++k) out[block.row[k]] = sum[k];
    }
  }

  static int inputs(const CurrentTrack<S>& track) {
    return 4 + 4 * static_cast<int>(track.rates().size()) + 5 + LinearLanes<S>::turning_columns;
  }
  /// u of a state, held commands and a shaft.
  static void read(const CurrentTrack<S>& track, const MachineState<S>& state, const S target[4], const Shaft<S>& shaft,
                   S* u) {
    const int lags = static_cast<int>(track.rates().size());
    for (int a = 0; a < 4; ++a) {
      u[a] = state.current[a] - target[a];
      for (int j = 0; j < lags; ++j) u[4 + a * lags + j] = state.lag[a * lags + j] - target[a];
      u[4 + 4 * lags + a] = target[a];
    }
    u[8 + 4 * lags] = S(1.0);
    LinearLanes<S>::turningInputs(shaft, u + 9 + 4 * lags);
  }

 private:
  using Columns = std::vector<std::vector<S>>;
  /// Taylor's series ends after so many terms, of a matrix whose norm is at most `largest_norm`: 0.25^13/13! is 2e-18.
  static constexpr int terms = 12;
  static constexpr double largest_norm = 0.25;
  static constexpr int pairs = LinearLanes<S>::turning_columns / 2;

  int lagColumn(int axis, int j) const { return 4 + axis * lags_ + j; }
  int commandColumn(int axis) const { return 4 + 4 * lags_ + axis; }
  int turning(int pair) const { return 4 + 4 * lags_ + 5 + 2 * pair; }

  /// out += y-part of X times the upper rows [A B], and X's u-part times D, all times h.
  void timesMatrix(const LinearLanes<S>& linear, const CurrentTrack<S>& track, const Columns& b, const Columns& x,
                   const S& h, Columns& out) const {
    const auto product = [&](const std::vector<S>& coefficients, std::vector<S>& column) {
      for (int j = 0; j < n_; ++j)
        for (int i = 0; i < n_; ++i) column[i] += x[j][i] * coefficients[j];
    };
    for (auto& column : out) column.assign(n_, S(0.0));
    for (int j = 0; j < n_; ++j) product(linear.column(j), out[j]);
    for (int j = 0; j < inputs_; ++j) product(b[j], out[n_ + j]);
    const auto add = [&](int to, int from, const S& factor) {
      for (int i = 0; i < n_; ++i) out[n_ + to][i] += factor * x[n_ + from][i];
    };
    for (int a = 0; a < 4; ++a) {
      add(a, a, -track.amplifier().rate());
      for (int j = 0; j < lags_; ++j) {
        add(a, lagColumn(a, j), track.rates()[j]);
        add(lagColumn(a, j), lagColumn(a, j), -track.rates()[j]);
      }
    }
    for (int pair = 0; pair < pairs; ++pair) {
      add(turning(pair), turning(pair) + 1, linear.speed());
      add(turning(pair) + 1, turning(pair), -linear.speed());
    }
    for (auto& column : out)
      for (S& value : column) value *= h;
  }

  /// Largest over lanes of the norm of A, once its states are scaled so that rows and columns are alike, and of D's rates.
  static double norm(const LinearLanes<S>& linear, const CurrentTrack<S>& track) {
    const auto largestLane = [](const S& value) {
      double largest = 0.0;
      for (std::size_t l = 0; l < ScalarTraits<S>::lanes; ++l) largest = std::max(largest, std::fabs(laneValue(value, l)));
      return largest;
    };
    const int n = linear.size();
    std::vector<double> a(n * n), scale(n, 1.0);
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) a[i * n + j] = largestLane(linear.a(i, j));
    constexpr int sweeps = 6;
    for (int sweep = 0; sweep < sweeps; ++sweep)
      for (int k = 0; k < n; ++k) {
        double row = 0.0, column = 0.0;
        for (int j = 0; j < n; ++j) {
          if (j == k) continue;
          row += a[k * n + j] * scale[j] / scale[k];
          column += a[j * n + k] * scale[k] / scale[j];
        }
        if (row > 0.0 && column > 0.0) scale[k] *= std::sqrt(row / column);
      }
    double norm = std::max(largestLane(track.amplifier().rate()), largestLane(linear.speed()));
    for (const S& rate : track.rates()) norm = std::max(norm, largestLane(rate));
    for (int i = 0; i < n; ++i) {
      double row = 0.0;
      for (int j = 0; j < n; ++j) row += a[i * n + j] * scale[j] / scale[i];
      norm = std::max(norm, row);
    }
    return norm;
  }

  /// What u does to y' at once.
  Columns inputColumns(const LinearLanes<S>& linear, const CurrentTrack<S>& track) const {
    Columns b(inputs_, std::vector<S>(n_, S(0.0)));
    S through(lags_ == 0 ? 1.0 : 0.0);  // of a command in the long run
    for (int j = 0; j < lags_; ++j) through += track.weights()[j];
    for (int a = 0; a < 4; ++a)
      for (int i = 0; i < n_; ++i) {
        const S& force = linear.byCurrent(a)[i];
        if (lags_ == 0) b[a][i] = force;
        for (int j = 0; j < lags_; ++j) b[lagColumn(a, j)][i] = track.weights()[j] * force;
        b[commandColumn(a)][i] = through * force;
      }
    b[turning(0) - 1] = linear.constant();
    for (int k = 0; k < 2 * pairs; ++k) b[turning(0) + k] = linear.turning(k);
    return b;
  }

  void fill(const LinearLanes<S>& linear, const CurrentTrack<S>& track) {
    const Columns b = inputColumns(linear, track);
    const int halvings = std::max(0, static_cast<int>(std::ceil(std::log2(norm(linear, track) * dt_ / largest_norm))));
    const double part = std::ldexp(dt_, -halvings);
    const int columns = n_ + inputs_;
    Columns sum(columns, std::vector<S>(n_, S(0.0))), term = sum, next = sum;
    for (int i = 0; i < n_; ++i) sum[i][i] = term[i][i] = S(1.0);
    for (int k = 1; k <= terms; ++k) {
      timesMatrix(linear, track, b, term, S(part / k), next);
      term.swap(next);
      for (int j = 0; j < columns; ++j)
        for (int i = 0; i < n_; ++i) sum[j][i] += term[j][i];
    }
    Growth growth(track, linear.speed(), part);
    for (int k = 0; k < halvings; ++k) square(growth, sum, next);
    arrange(sum);
  }

  /// Rows that know of each other (an axis, mostly: nothing couples x and y) in blocks of four, each with the columns that
  /// it has.
  void arrange(const Columns& x) {
    const auto any = [&](int row, int column) {
      for (std::size_t l = 0; l < ScalarTraits<S>::lanes; ++l)
        if (laneValue(x[column][row], l) != 0.0) return true;
      return false;
    };
    std::vector<int> group(n_);
    for (int i = 0; i < n_; ++i) group[i] = i;
    for (int i = 0; i < n_; ++i)
      for (int j = 0; j < n_; ++j) {
        const int one = group[i], other = group[j];
        if (one != other && any(i, j)) std::replace(group.begin(), group.end(), other, one);
      }
    for (int g = 0; g < n_; ++g) {
      std::vector<int> rows;
      for (int i = 0; i < n_; ++i)
        if (group[i] == g) rows.push_back(i);
      for (std::size_t from = 0; from < rows.size(); from += rows_of_block)
        append(std::vector<int>(rows.begin() + from, rows.begin() + std::min(from + rows_of_block, rows.size())), x, any);
    }
  }

  template <class Any>
  void append(const std::vector<int>& rows, const Columns& x, const Any& any) {
    Block block;
    block.count = static_cast<int>(rows.size());
    std::copy(rows.begin(), rows.end(), block.row);
    block.first = static_cast<int>(sources_.size());
    block.values = matrix_.size();
    for (int j = 0; j < n_ + inputs_; ++j) {
      if (std::none_of(rows.begin(), rows.end(), [&](int row) { return any(row, j); })) continue;
      sources_.push_back(j);
      for (std::size_t k = 0; k < rows_of_block; ++k) matrix_.push_back(k < rows.size() ? x[j][rows[k]] : S(0.0));
    }
    block.last = static_cast<int>(sources_.size());
    blocks_.push_back(block);
  }

  /// exp(D h), doubled with each squaring.
  struct Growth {
    Growth(const CurrentTrack<S>& track, const S& speed, double h) : amplifier(track.amplifier().decay(h)) {
      for (std::size_t j = 0; j < track.rates().size(); ++j) {
        lag.push_back(exponential(-track.rates()[j] * S(h)));
        into_lag.push_back(track.gains()[j] * (amplifier - lag[j]));
      }
      sineCosine(speed * S(h), sine, cosine);
    }
    void twice() {
      for (std::size_t j = 0; j < lag.size(); ++j) {
        into_lag[j] = into_lag[j] * (amplifier + lag[j]);
        lag[j] *= lag[j];
      }
      amplifier *= amplifier;
      const S turned = cosine * cosine - sine * sine;
      sine = S(2.0) * sine * cosine;
      cosine = turned;
    }
    S amplifier, sine, cosine;
    std::vector<S> lag, into_lag;
  };

  /// [P Q] -> [P P, P Q + Q exp(D h)].
  void square(Growth& growth, Columns& x, Columns& out) const {
    for (int j = 0; j < n_ + inputs_; ++j) {
      out[j].assign(n_, S(0.0));
      for (int k = 0; k < n_; ++k)
        for (int i = 0; i < n_; ++i) out[j][i] += x[k][i] * x[j][k];
    }
    const auto add = [&](int to, int from, const S& factor) {
      for (int i = 0; i < n_; ++i) out[n_ + to][i] += factor * x[n_ + from][i];
    };
    for (int a = 0; a < 4; ++a) {
      add(a, a, growth.amplifier);
      for (int j = 0; j < lags_; ++j) {
        add(a, lagColumn(a, j), growth.into_lag[j]);
        add(lagColumn(a, j), lagColumn(a, j), growth.lag[j]);
      }
      add(commandColumn(a), commandColumn(a), S(1.0));
    }
    add(turning(0) - 1, turning(0) - 1, S(1.0));
    for (int pair = 0; pair < pairs; ++pair) {
      const int c = turning(pair), s = c + 1;
      add(c, c, growth.cosine);
      add(c, s, growth.sine);
      add(s, c, -growth.sine);
      add(s, s, growth.cosine);
    }
    growth.twice();
    x.swap(out);
  }

  double dt_;
  int n_, lags_, inputs_ = 0;
  static constexpr std::size_t rows_of_block = 4;
  struct Block {
    int row[rows_of_block] = {0, 0, 0, 0}, count = 0;
    int first = 0, last = 0;  ///< of sources_
    std::size_t values = 0;   ///< where its values begin in matrix_, four for each source
  };
  std::vector<Block> blocks_;
  std::vector<int> sources_;  ///< places in w
  std::vector<S> matrix_;
};

}  // namespace amb_rotor
