#include "seen_shapes.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "amb_rotor/common/linear_algebra.hpp"
#include "foreseen.hpp"

namespace amb_rotor {
namespace {

constexpr int outputs = 2, inputs = 3;
/// Shapes at which a mode hardly acts: the change goes with their product.
constexpr double small_shape = 0.1;
/// Largest shape of a start; and rounds of solving for either side.
constexpr double largest_shape = 3.0;
constexpr int rounds = 20;
/// Directions that differ by less than this share of their squares count as one.
constexpr double nearly_one = 1e-4;

struct Places {
  int sensor[2], amb[2], aux[2], unbalance;
};

Places placesOf(const EffectSchema& schema) {
  Places at;
  const char* end[2] = {"a", "b"};
  for (int e = 0; e < 2; ++e) {
    at.sensor[e] = schema.indexOf(std::string("shape_sensor_") + end[e]);
    at.amb[e] = schema.indexOf(std::string("shape_amb_") + end[e]);
    at.aux[e] = schema.indexOf(std::string("shape_aux_") + end[e]);
  }
  at.unbalance = schema.indexOf("shape_unbalance");
  return at;
}

/// A mode that one sensor sees and one input excites, both by a little.
EffectSetting oneWay(EffectSetting mode, const Places& at, int output, int input) {
  std::fill(mode.values.begin() + 2, mode.values.end(), 0.0);
  mode.values[at.sensor[output]] = small_shape;
  mode.values[input < 2 ? at.amb[input] : at.unbalance] = small_shape;
  return mode;
}

/// The s of length 1, and p, whose product s p' is nearest to a matrix.
std::pair<Eigen::VectorXd, Eigen::VectorXd> nearestProduct(const Eigen::MatrixXd& m) {
  const Eigen::VectorXd s = symmetricEigen(m * m.transpose()).vectors.col(m.rows() - 1);
  return {s, m.transpose() * s};
}

/// The mode with the shapes whose products these are.
EffectSetting shaped(EffectSetting mode, const Places& at, const Eigen::Matrix<double, outputs, inputs>& products) {
  auto [seen, driven] = nearestProduct(products);
  const double at_magnets = std::max(driven.head(2).norm(), 0.1 * driven.norm());
  if (!(at_magnets > 0.0)) return mode;
  const double even = std::sqrt(at_magnets / seen.norm());
  seen *= even;
  driven /= even;
  const auto within = [](double shape) { return std::clamp(shape, -largest_shape, largest_shape); };
  for (int e = 0; e < 2; ++e) {
    mode.values[at.sensor[e]] = within(seen[e]);
    mode.values[at.amb[e]] = within(driven[e]);
    mode.values[at.aux[e]] = within(0.5 * (seen[e] + driven[e]));
  }
  mode.values[at.unbalance] = within(driven[2]);
  return mode;
}

/// The shapes that runs without contact tell of: at the sensors, at the magnetic bearings, at the unbalance.
constexpr int told = 5, of_a_curve = 3;

/// Values at a place of the curves that a smooth shape is made of.
Eigen::RowVector3d curvesAt(double z, double length) { return {1.0, z / length, z / length * (z / length)}; }

}  // namespace

std::optional<EffectSetting> smoothMode(const Model& belief, const EffectSetting& mode) {
  const auto& rig = belief.rig;
  const EffectSchema& schema = *effectCatalogue().find(mode.id);
  const Places at = placesOf(schema);
  const double length = std::fabs(rig.planes.aux[1] - rig.planes.aux[0]);
  if (rig.unbalance.empty() || !(length > 0.0)) return {};
  Eigen::Matrix<double, told, of_a_curve> curves;
  Eigen::Matrix<double, told, 2> sides = Eigen::Matrix<double, told, 2>::Zero();  // what grows as the other falls
  for (int e = 0; e < 2; ++e) {
    curves.row(e) = curvesAt(rig.planes.sensor[e], length);
    curves.row(2 + e) = curvesAt(rig.planes.amb[e], length);
    sides(e, 0) = mode.values[at.sensor[e]];
    sides(2 + e, 1) = mode.values[at.amb[e]];
  }
  curves.row(4) = curvesAt(rig.unbalance[0].plane_z_m, length);
  sides(4, 1) = mode.values[at.unbalance];
  if (!(sides.colwise().norm().minCoeff() > 0.0)) return {};
  // the least share of the shapes' squares that is off a curve, over the factors of both sides
  const auto onCurve = [&](const Eigen::VectorXd& of) { return leastSquares(curves, of); };  // planes may lie together
  Eigen::MatrixXd off = sides;
  for (int side = 0; side < 2; ++side) off.col(side) -= curves * onCurve(sides.col(side));
  const Eigen::VectorXd factors = generalizedSymmetricEigen(off.transpose() * off, sides.transpose() * sides).vectors.col(0);
  if (!factors.allFinite() || !(factors[0] * factors[1] > 0.0)) return {};
  const double grown = std::sqrt(factors[0] / factors[1]);
  const Eigen::VectorXd curve = onCurve(sides * Eigen::Vector2d(grown, 1.0 / grown));
  EffectSetting smooth = mode;
  const auto set = [&](int i, double shape) { smooth.values[i] = std::clamp(shape, schema.parameters[i].lower, schema.parameters[i].upper); };
  for (int e = 0; e < 2; ++e) {
    set(at.sensor[e], grown * mode.values[at.sensor[e]]);
    set(at.amb[e], mode.values[at.amb[e]] / grown);
    set(at.aux[e], curvesAt(rig.planes.aux[e], length).dot(curve));
  }
  set(at.unbalance, mode.values[at.unbalance] / grown);
  return smooth;
}

Eigen::Matrix<double, 2, 3> likeliestProducts(const Eigen::MatrixXd& given, const Eigen::VectorXd& along) {
  Eigen::MatrixXd squares = given;
  squares.diagonal() *= 1.0 + nearly_one;
  squares.diagonal().array() += 1e-12 * std::max(squares.diagonal().maxCoeff(), 1e-300);
  const Eigen::VectorXd free = Ldlt(squares).solve(along);
  const Eigen::Matrix<double, outputs, inputs> any = Eigen::Map<const Eigen::Matrix<double, outputs, inputs, Eigen::RowMajor>>(free.data());
  auto [seen, driven] = nearestProduct(any);
  Eigen::MatrixXd of_driven = Eigen::MatrixXd::Zero(outputs * inputs, inputs), of_seen(outputs * inputs, outputs);
  for (int round = 0; round < rounds && seen.norm() > 0.0 && driven.norm() > 0.0; ++round) {
    of_seen.setZero();
    for (int i = 0; i < outputs; ++i) of_driven.block(i * inputs, 0, inputs, inputs) = seen[i] * Eigen::MatrixXd::Identity(inputs, inputs);
    driven = Ldlt(of_driven.transpose() * squares * of_driven).solve(of_driven.transpose() * along);
    for (int i = 0; i < outputs; ++i) of_seen.block(i * inputs, i, inputs, 1) = driven;
    seen = Ldlt(of_seen.transpose() * squares * of_seen).solve(of_seen.transpose() * along);
  }
  return seen * driven.transpose();
}

bool hasShapes(const std::string& effect) { return effect == "shaft_flexibility"; }

void addSeenShapes(const Model& belief, const Eigen::VectorXd& nuisance, const References& references, std::vector<Settings>& starts) {
  if (starts.empty() || !hasShapes(starts[0].back().id)) return;
  const Places at = placesOf(*effectCatalogue().find(starts[0].back().id));
  const std::size_t given = starts.size();
  for (std::size_t n = 0; n < given; ++n) {
    std::vector<Settings> ways(outputs * inputs, starts[n]);
    for (int i = 0; i < outputs; ++i)
      for (int j = 0; j < inputs; ++j) ways[i * inputs + j].back() = oneWay(starts[n].back(), at, i, j);
    const StartScreen::Freed changes = references.screen->freed(modelsOf(belief, ways, nuisance), true);
    if (std::any_of(changes.lost.begin(), changes.lost.end(), [](bool one) { return one; })) continue;
    // a way that changes nothing, of an unbalance that a rig does not state, is none of the mode's
    if (!changes.squares.allFinite() || !changes.along.allFinite() || !(changes.squares.diagonal().maxCoeff() > 0.0)) continue;
    const auto products = likeliestProducts(changes.squares, changes.along);
    if (!products.allFinite()) continue;
    starts.push_back(starts[n]);
    starts.back().back() = shaped(starts[n].back(), at, small_shape * small_shape * products);
  }
}

}  // namespace amb_rotor
