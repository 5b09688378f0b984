#pragma once
// A linear system in the coordinates of its own modes, in which its motion is exact:
//
//   y' = A y + B u + g,   w = C y,   y = M s
//   s: a complex coordinate a mode (pairs of conjugate eigenvalues once, real ones with no imaginary part),
//      z' = lambda z + b u,  and the real coordinates n of the eigenvalue 0,  n' = J n + ..., J J = 0 (a free
//      body drifts)
//
// Layout of s: real parts, imaginary parts, n. A table holds what a step of one length needs: the motion of
// s, the outputs w at Gauss's nodes and at the end, and what forces u(t) given at the nodes (a polynomial of
// degree nodes - 1 between them) add to each:  int_0^t exp(lambda (t - r)) L_j(r/h) dr  in closed form.
//
// Not usable (reason() says why): eigenvectors that do not span the space other than by eigenvalue 0, a chain
// longer than 2 there. Checked by putting A together again to 1e-9 of its size. No allocation after
// construction.
#include <Eigen/Core>
#include <complex>
#include <string>
#include <utility>
#include <vector>

#include "amb_rotor/common/aligned_matrix.hpp"

namespace amb_rotor {

struct LinearSystem {
  Eigen::MatrixXd a, b, c;
  /// Of each pair the state along x and the one along y, where that is all of them: where A is the same turned by a
  /// quarter (a machine without a preferred direction), its eigenproblem is one of x + j y, of half the size.
  std::vector<std::pair<int, int>> pairs;
};

class LinearFlow {
 public:
  static constexpr int nodes = 4;  ///< Gauss: order 8

  explicit LinearFlow(const LinearSystem& system);

  bool usable() const { return reason_.empty(); }
  const std::string& reason() const { return reason_; }
  int modes() const { return static_cast<int>(lambda_.size()); }
  int size() const { return 2 * modes() + zeros_; }
  int inputs() const { return static_cast<int>(b_.cols()); }
  int outputs() const { return static_cast<int>(c_.rows()); }

  const Eigen::MatrixXd& toModal() const { return to_modal_; }      ///< size() x states
  const Eigen::MatrixXd& fromModal() const { return from_modal_; }  ///< states x size()
  const AlignedMatrix& outputMatrix() const { return c_; }        ///< outputs() x size()
  /// y = M s, where y holds places and their rates by half that product: a row of A that is a unit vector
  /// says that one state is the rate of another, whose row of M it has times lambda. `turned`: scratch of
  /// size().
  void mechanics(const Eigen::VectorXd& s, Eigen::VectorXd& turned, Eigen::VectorXd& y) const;
  const Eigen::VectorXcd& eigenvalues() const { return lambda_; }
  const Eigen::MatrixXd& chain() const { return chain_; }  ///< J

  /// Motion that a constant g (in modal coordinates) keeps: a rest of the modes; `drift` is what it does to
  /// n'.
  void rest(const Eigen::VectorXd& g, Eigen::VectorXd& s, Eigen::VectorXd& drift) const;
  /// Motion s = c cos + i sin under g = gc cos(W t) + gs sin(W t).
  void harmonic(const Eigen::VectorXd& gc, const Eigen::VectorXd& gs, double speed, Eigen::VectorXd& c,
                Eigen::VectorXd& s) const;
  /// Motion s exp(-r t) under g exp(-r t).
  Eigen::VectorXd decaying(const Eigen::VectorXd& g, double rate) const;

  /// exp(lambda t) of every mode.
  void factors(double t, double* real, double* imaginary) const;
  /// s after t by these factors, without forces.
  void move(const double* real, const double* imaginary, double t, double* s) const;

  struct Table {
    double h = -1.0;
    Eigen::VectorXd real, imaginary;  ///< exp(lambda h)
    AlignedMatrix free;  ///< outputs at nodes (row()), then at the end, from s: (nodes + 1) outputs x size
    AlignedMatrix forced;    ///< the same from u, at nodes: nodes outputs x inputs nodes
    AlignedMatrix forced_end;  ///< at the end: outputs x inputs nodes
    AlignedMatrix response;  ///< s at the end from u: size x inputs nodes
    AlignedMatrix parts;     ///< outputs at the end from parts of u, 3 outputs x inputs nodes: from its highest Legendre
                               ///< polynomial, from its mean, and from that polynomial's coefficient as if it were constant
  };
  /// Column of u for an input at a node, and row of an output at a node: node by node of one, then of the
  /// next.
  static constexpr int column(int input, int node) { return input * nodes + node; }
  static constexpr int row(int output, int node) { return output * nodes + node; }
  Table emptyTable() const;
  void build(double h, Table& table) const;

  /// Gauss's nodes on [0, 1].
  static const double* abscissae();
  /// Value at x (in steps) of the polynomial through values at the nodes: weights of the values.
  static void interpolation(double x, double* weight);

 private:
  /// Eigenvalues with an imaginary part of 0 or more, once each, and their vectors.
  struct Modes {
    std::vector<std::complex<double>> values;
    std::vector<bool> pair;  ///< stands for its conjugate, too
    Eigen::MatrixXcd vectors;
    int zeros = 0;
    bool found = false;
    /// Where known already: what makes the coordinates (columns: real parts' and imaginary parts' in turn) of states, and
    /// the error of A put together again, of its size.
    Eigen::MatrixXd back;
    double misfit = 0.0;
  };
  static Modes modesOf(const Eigen::MatrixXd& a);
  static Modes modesOf(const Eigen::MatrixXd& a, const std::vector<std::pair<int, int>>& pairs);
  void splitRows(const Eigen::MatrixXd& a);

  std::string reason_;
  Eigen::VectorXcd lambda_;
  int zeros_ = 0;
  Eigen::MatrixXd chain_, to_modal_, from_modal_, b_;
  AlignedMatrix c_;
  Eigen::MatrixXd later_seen_, later_pushed_, drifts_, later_drifts_;  ///< of the zeros: C J, J B, C B, C J B
  struct Transfer {
    int input, output, outputs;  ///< from the first output on, so many
  };
  struct Place {
    int place, rate;
  };
  std::vector<Place> places_;
  std::vector<int> others_;  ///< states that are neither
  AlignedMatrix place_rows_, other_rows_;
  mutable Eigen::VectorXd place_, rate_, other_;
  Eigen::MatrixXd carried_real_, carried_imaginary_;  ///< outputs by each mode's inputs
  std::vector<Transfer> transfer_;                    ///< of mode k: from transfer_begin_[k] on
  std::vector<int> transfer_begin_;
};

}  // namespace amb_rotor
