// Where the fit of an effect of one's own begins.
#include <algorithm>
#include <cmath>

#include "amb_rotor/common/units.hpp"
#include "amb_rotor/validation/starts.hpp"

namespace amb_rotor {
namespace {

constexpr std::size_t most_starts = 10;
/// A range that spans more than this factor is divided by ratios.
constexpr double wide_range = 10.0;
/// Places within a range, as shares of it.
constexpr double places[] = {0.1, 0.3, 0.5, 0.7, 0.9};
/// Limits beyond this multiple of the typical value say nothing; the typical value's own decade does then.
constexpr double no_limit = 1e4;

/// Whether a number shapes the effect: where it stands does not make it vanish.
bool shapes(const ParameterSchema& p) { return p.role == ParameterRole::phase || !std::isfinite(p.neutral); }

std::vector<double> acrossRange(const ParameterSchema& p) {
  double lower = p.lower, upper = p.upper;
  const double size = std::fabs(p.typical);
  if (p.role == ParameterRole::phase) {
    lower = -pi;
    upper = pi;
  } else if (size > 0.0) {
    const bool positive = lower >= 0.0;
    if (upper > no_limit * size) upper = 10.0 * size;
    if (positive && lower < size / no_limit) lower = 0.1 * size;
    if (!positive && lower < -no_limit * size) lower = -10.0 * size;
  }
  std::vector<double> out;
  for (const double share : places)
    out.push_back(lower > 0.0 && upper > wide_range * lower ? lower * std::pow(upper / lower, share)
                                                            : lower + share * (upper - lower));
  return out;
}

}  // namespace

std::vector<std::vector<double>> startsOfOwnEffect(const EffectSchema& schema) {
  std::vector<double> neutral, typical, turned;
  for (const auto& p : schema.parameters) {
    const auto within = [&](double value) { return std::clamp(value, p.lower, p.upper); };
    const bool size = std::isfinite(p.neutral) && p.role != ParameterRole::fixed;
    neutral.push_back(within(std::isfinite(p.neutral) ? p.neutral : p.typical));
    typical.push_back(within(p.typical));
    turned.push_back(size ? within(2.0 * p.neutral - p.typical) : typical.back());
  }
  std::vector<std::vector<double>> out = {neutral};
  const auto add = [&](const std::vector<double>& start) {
    if (out.size() < most_starts && std::find(out.begin(), out.end(), start) == out.end())
      out.push_back(start);
  };
  add(typical);
  for (std::size_t i = 0; i < schema.parameters.size(); ++i) {
    if (!shapes(schema.parameters[i]) || schema.parameters[i].role == ParameterRole::fixed) continue;
    for (const double value : acrossRange(schema.parameters[i])) {
      std::vector<double> start = neutral;
      start[i] = std::clamp(value, schema.parameters[i].lower, schema.parameters[i].upper);
      add(start);
    }
  }
  add(turned);
  return out;
}

}  // namespace amb_rotor
