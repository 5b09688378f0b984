// Laws by their forces along the measured path.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <set>

#include "amb_rotor/effects/law_terms.hpp"
#include "amb_rotor/validation/start_screen.hpp"
#include "law_search.hpp"
#include "path_forces.hpp"

namespace amb_rotor {
namespace {

/// Rounds along the measured path; what is left out of the begin of a run, in which the force sets in.
constexpr int path_rounds = 3;
constexpr double begin_left_out_s = 0.1, begin_left_out_share = 0.2;
/// Terms by which places are held to each other: of each set of quantities those that differ most.
constexpr effects::LawTerms::Term telling_places_apart[] = {
    effects::LawTerms::position,          effects::LawTerms::position_cube,        effects::LawTerms::velocity,
    effects::LawTerms::velocity_square,   effects::LawTerms::velocity_sign,        effects::LawTerms::velocity_position,
    effects::LawTerms::cross,             effects::LawTerms::cross_speed,          effects::LawTerms::position_speed,
    effects::LawTerms::velocity_speed,    effects::LawTerms::velocity_cross_speed, effects::LawTerms::thrice_cosine,
    effects::LawTerms::thrice_sine,       effects::LawTerms::drift_x,              effects::LawTerms::drift_y,
    effects::LawTerms::position_turn};

}  // namespace

/// As linearise(), where no term acts, with the terms' forces along the measured path.
/// @return chi2 at the start, to second order, less the number of residuals
double LawSearch::followPath(const StartScreen& screen, const Eigen::VectorXd& x, const std::vector<int>& library, Eigen::MatrixXd& h,
                             Eigen::VectorXd& g) const {
  const Model model = bare_.model(x.head(first_));
  std::vector<EffectSetting> forces;
  for (const int k : library) {
    forces.push_back(place_.withoutForce(frequency_hz_));
    if (number_ >= 0) forces.back().values.back() = place_.isPlane() ? x[number_] : std::exp(x[number_]);
    forces.back().values[k - first_] = space_.coordinates()[k].scale;
  }
  double from_s = begin_left_out_s;
  for (const int r : fit_) from_s = std::min(from_s, begin_left_out_share * recordings_[r].duration());
  const int terms = static_cast<int>(library.size());
  const Eigen::MatrixXd all = screen.products(terms, [&](const ReferenceRun& run) {
    auto changes = responsesAlongPath(run, model, forces);
    for (int t = 0; t < terms && run.recording.standstill; ++t)
      if (place_.readsAngle(library[t] - first_)) changes[t].clear();
    return changes;
  }, from_s);
  std::vector<int> place = base_;
  place.insert(place.end(), library.begin(), library.end());
  const auto column = [&](int i) { return i < first_ ? i : i + 1; };  // the residual stands between
  const auto scale = [&](int i) { return i < first_ ? 1.0 : space_.coordinates()[place[i]].scale; };
  h = Eigen::MatrixXd::Zero(space_.size(), space_.size());
  g = Eigen::VectorXd::Zero(space_.size());
  for (int i = 0; i < static_cast<int>(place.size()); ++i) {
    g[place[i]] = all(column(i), first_) / scale(i);
    for (int j = 0; j < static_cast<int>(place.size()); ++j)
      h(place[i], place[j]) = all(column(i), column(j)) / (scale(i) * scale(j));
  }
  const Eigen::VectorXd from_start = x - startAt(x);
  g += h * from_start;
  double above = all(first_, first_) + from_start.dot(2.0 * g - h * from_start);
  priors(h, g);
  for (int k = 0; k < space_.nuisances(); ++k) {
    const Coordinate& c = space_.coordinates()[k];
    above += std::pow((space_.start()[k] - c.prior_mean) / c.prior_std, 2);
  }
  for (const int r : fit_) {
    const Recording& rec = recordings_[r];
    const long from = std::lround(from_s * rec.run.sample_rate_hz);
    above -= static_cast<double>(rec.samples - from) *
             static_cast<double>(std::count_if(rec.noise.begin(), rec.noise.end(), [](double noise) { return noise > 0.0; }));
  }
  return above;
}

StartScreen LawSearch::screenAt(const Eigen::VectorXd& x, const std::vector<LocalState>& local) const {
  return StartScreen(recordings_, fit_, bare_, x.head(first_), local, offset_std_);
}

/// The best law whose terms depend on just these quantities.
TermChoice LawSearch::bestOfSet(unsigned quantities, const std::vector<int>& library, const Eigen::MatrixXd& h,
                                const Eigen::VectorXd& g, const Stakes& stakes) const {
  std::vector<int> alike;
  for (const int k : library)
    if (quantitiesIn({k}) == quantities) alike.push_back(k);
  const std::vector<unsigned> of_these(alike.size(), quantities);
  return bestTerms(h, g, base_, alike, of_these, stakes.least, stakes.tie, most_terms);
}

TermChoice LawSearch::bestOfOneSet(const std::vector<int>& library, const Eigen::MatrixXd& h, const Eigen::VectorXd& g,
                                   const Stakes& stakes) const {
  TermChoice best;
  for (const unsigned quantities : std::set<unsigned>(quantities_.begin(), quantities_.end())) {
    TermChoice one = bestOfSet(quantities, library, h, g, stakes);
    if (one.drop > best.drop) best = std::move(one);
  }
  return best;
}

/// @param above  see followPath()
LawSearch::Left LawSearch::leftByOneSet(double above, const std::vector<int>& library, const Eigen::VectorXd& x, const Eigen::MatrixXd& h,
                                        const Eigen::VectorXd& g, const Stakes& stakes) const {
  const TermChoice best = bestOfOneSet(library, h, g, stakes);
  std::vector<int> free = base_;
  free.insert(free.end(), best.terms.begin(), best.terms.end());
  const Eigen::VectorXd goal = solveFor(h, g, free);
  Left out = {above, startAt(x)};
  for (const int k : best.terms) out.reads_angle = out.reads_angle || place_.readsAngle(k - first_);
  for (std::size_t i = 0; i < free.size(); ++i) {
    const double move = goal[static_cast<long>(i)];
    out.above -= move * g[free[i]];
    if (free[i] < first_) out.x[free[i]] += move;
  }
  out.above = std::isfinite(out.above) ? std::max(0.0, out.above) : std::numeric_limits<double>::infinity();
  out.x = space_.clamped(out.x);
  return out;
}

LawSearch::Left LawSearch::leftByOneSet(const StartScreen& screen, const Eigen::VectorXd& nuisance, const Stakes& stakes) const {
  std::vector<int> library;
  for (const int term : telling_places_apart) library.push_back(first_ + term);
  Eigen::MatrixXd h;
  Eigen::VectorXd g;
  Eigen::VectorXd x = space_.start();
  x.head(first_) = nuisance.head(first_);
  const double above = followPath(screen, x, library, h, g);
  return leftByOneSet(above, library, x, h, g, stakes);
}

double LawSearch::aboveAtStandstill(const Eigen::VectorXd& x, const std::vector<LocalState>& local) const {
  std::vector<LocalState> own = local;
  EvaluationOptions options;
  options.jacobian = false;
  const NormalEquations normal = problem_.evaluate(x, still_, own, options);
  return normal.finite ? std::max(0.0, normal.chi2 - normal.count) : 0.0;
}

/// Laws of one to three terms by their forces along the measured path, the nuisance led by the best of them: that law, what
/// it has of each set of quantities and the best of that set alone, and the best of one term and of two.
LawSearch::AlongPath LawSearch::alongPath(const Hypothesis& about, const Stakes& stakes) const {
  AlongPath out;
  Eigen::VectorXd x = about.x;
  x.segment(first_, place_.terms()).setZero();
  Eigen::MatrixXd h;
  Eigen::VectorXd g;
  const auto solved = [&](const std::vector<int>& terms) {
    std::vector<int> free = base_;
    free.insert(free.end(), terms.begin(), terms.end());
    const Eigen::VectorXd goal = solveFor(h, g, free);
    Eigen::VectorXd at = startAt(x);
    for (std::size_t i = 0; i < free.size(); ++i) at[free[i]] += goal[static_cast<long>(i)];
    return space_.clamped(at);
  };
  TermChoice best;
  double above = 0.0;
  for (int round = 0; round < path_rounds; ++round) {
    const StartScreen screen = screenAt(x, about.local);
    if (!screen.isFinite()) {  // the law's nuisance loses the rotor without the law
      if (round == 0) return out;
      break;
    }
    above = followPath(screen, x, library_, h, g);
    const std::vector<int> before = best.terms;
    best = bestTerms(h, g, base_, library_, quantities_, stakes.least, stakes.tie, most_terms);
    out.promised = best.drop;
    if (best.terms.empty()) return out;
    if (best.terms == before) break;
    x = solved(best.terms);
    x.segment(first_, place_.terms()).setZero();
  }
  const auto add = [&](std::vector<int> terms) {
    std::sort(terms.begin(), terms.end());
    if (terms.empty() || std::any_of(out.laws.begin(), out.laws.end(), [&](const Hypothesis& o) { return o.terms == terms; })) return;
    Hypothesis one;
    one.x = solved(terms);
    one.terms = std::move(terms);
    one.local = about.local;
    out.laws.push_back(std::move(one));
  };
  out.by_one_set = bestOfOneSet(library_, h, g, stakes).drop;
  // one plane next to a bearing is a term and its like that differs between the bearings: all that would be left to a plane is taken then
  std::vector<int> alike;
  std::copy_if(library_.begin(), library_.end(), std::back_inserter(alike),
               [&](int k) { return k - first_ < effects::LawTerms::antisym_position; });
  out.left = leftByOneSet(above, alike, x, h, g, stakes);
  add(best.terms);
  for (const int term : best.terms) {
    std::vector<int> own;
    for (const int k : best.terms)
      if (quantitiesIn({k}) == quantitiesIn({term})) own.push_back(k);
    add(own);
    add(bestOfSet(quantitiesIn({term}), library_, h, g, stakes).terms);
  }
  for (const TermChoice& one : bestSubsets(h, g, base_, library_, 1, first_singles)) add(one.terms);
  for (const TermChoice& two : bestSubsets(h, g, base_, library_, 2, first_pairs)) add(two.terms);
  return out;
}

LawSearch::Begun LawSearch::begin(const Eigen::VectorXd& at, const std::vector<LocalState>& local, double before,
                                  double count) {
  Begun out = {{}, Stakes(before, count), {}, {}, {}};
  out.without.x = at;
  out.without.local = local;
  out.without.chi2 = before;
  // a signal that is off shows another path than the rotor's
  if (!place_.isSensors()) out.along = alongPath(believed(out.without), out.stakes);
  return out;
}

const Hypothesis& LawSearch::plainAlongPath(Begun& begun) {
  if (begun.plain_along_path) return *begun.plain_along_path;
  const Stakes& stakes = begun.stakes;
  begun.plain_along_path = begun.without;
  std::vector<Hypothesis> these;
  for (const Hypothesis& law : begun.along.laws)
    if (quantitiesIn(law.terms) == quantitiesIn({law.terms[0]})) these.push_back(law);
  refineBest(these);
  if (these.empty() || !stakes.nothingLeft(chosen(these, stakes).chi2)) return *begun.plain_along_path;
  Hypothesis law = chosen(these, stakes);
  if (law.terms.size() > 1) {  // several may make up one that stands out near the right motion
    these = contenders(law, 0, 0, stakes, first_singles);
    refineBest(these);
    these.push_back(law);
    law = chosen(these, stakes);
  }
  begun.plain_along_path = std::move(law);
  return *begun.plain_along_path;
}

}  // namespace amb_rotor
