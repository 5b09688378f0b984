#pragma once
// Effects that help only together. One after the other neither earns its place; the sensitivities of all
// candidates at once say to first order which two would (foreseen.hpp), of those that vanish somewhere; so the best few
// are then fitted in full, with the pair of the two best single candidates.
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "candidates.hpp"

namespace amb_rotor {

struct PairTrial {
  std::string first, second;
  Trial trial;  ///< with what was adopted and both of them
  bool contact = false;
};

/// What the linear look says of two effects.
struct PairGain {
  std::string first, second;
  double evidence = 0.0;  ///< expected
  double more = 0.0;      ///< than the better of the two alone
};

/// Expected gains out of one evaluation of a model with all effects in it, best first; only pairs that
/// promise more than `least` beyond the better of the two.
std::vector<PairGain> pairGains(const Trial& all, const std::vector<std::string>& effects, double least);

/// Fits of the most promising pairs, best evidence first; at most six. `tell` hears the names.
/// @param least  evidence that a pair must promise
std::vector<PairTrial> tryPairs(const Candidates& candidates, const std::vector<Trial>& screened,
                                const Settings& adopted, const References& references, double least,
                                const std::function<void(const std::string&)>& tell);

}  // namespace amb_rotor
