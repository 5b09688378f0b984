#include "law_search.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <bitset>
#include <cmath>
#include <map>

#include "amb_rotor/validation/start_screen.hpp"

namespace amb_rotor {
namespace {

/// Contenders for a further term.
constexpr int further_singles = 3;
/// Single terms that are fitted after the screen, rounds of the screen, and how far a round may move a term's size.
constexpr std::size_t screened_singles = 5;
constexpr int screen_rounds = 3;
constexpr std::size_t plain_finalists = 2;
/// Share of what is unexplained that a term must take to be a relative of the right one.
constexpr double related_share = 0.3;
constexpr double largest_move = 30.0, retreat = 0.2;
/// Iterations of a contender's first look, and of the best of them after it.
constexpr int glance_iterations = 2, refining_iterations = 5;
constexpr std::size_t finalists = 3;
/// Share of what is unexplained that terms must take to bring in quantities that the other terms do not depend on, where these
/// alone leave no more than the other share.
constexpr double further_quantity_share = 0.1, nearly_all_left = 0.2;
/// Prior standard deviations by which a nuisance counts as pulled away.
constexpr double far_from_belief = 1.0;

std::vector<EffectSetting> with(std::vector<EffectSetting> effects, EffectSetting one) {
  effects.push_back(std::move(one));
  return effects;
}

}  // namespace

LawSearch::LawSearch(const std::vector<Recording>& recordings, const Model& belief,
                     const std::vector<EffectSetting>& adopted, double frequency_hz, double offset_std_m, LawPlace place)
    : place_(place),
      recordings_(recordings),
      offset_std_(offset_std_m),
      bare_(belief, adopted),
      space_(belief, with(adopted, place.withoutForce(frequency_hz))),
      frequency_hz_(frequency_hz),
      problem_(recordings, space_, offset_std_m) {
  first_ = bare_.size();
  if (place.hasNumber()) number_ = first_ + place.terms();
  const auto& parameters = place.schema().parameters;
  std::map<std::string, unsigned> bits;
  for (int k = 0; k < first_; ++k) base_.push_back(k);
  for (int term = 0; term < place_.terms(); ++term) {
    if (place_.repeatsInTime(term) && frequency_hz <= 0.0) continue;
    library_.push_back(first_ + term);
    unsigned all = 0;
    for (const auto& q : quantitiesOf(parameters[term].meaning)) all |= bits.emplace(q, 1u << bits.size()).first->second;
    quantities_.push_back(all);
  }
  for (int i = 0; i < static_cast<int>(recordings.size()); ++i) {
    if (recordings[i].holdsContact()) continue;
    if (recordings[i].run.use != RunUse::fit)
      held_out_.push_back(i);
    else
      (recordings[i].standstill ? still_ : turning_).push_back(i);
  }
  fit_ = still_;
  fit_.insert(fit_.end(), turning_.begin(), turning_.end());
}

/// The start, with the plane of x, or the width of its step.
Eigen::VectorXd LawSearch::startAt(const Eigen::VectorXd& x) const {
  Eigen::VectorXd out = space_.start();
  if (number_ >= 0) out[number_] = x[number_];
  return out;
}

/// Normal equations about x, moved to the start, priors included. False: not finite.
bool LawSearch::linearise(const Eigen::VectorXd& x, std::vector<LocalState>& local, Eigen::MatrixXd& h,
                          Eigen::VectorXd& g) const {
  NormalEquations sum = problem_.evaluate(x, turning_, local, {});
  NormalEquations still = problem_.evaluate(x, still_, local, {});
  // at standstill the shaft's angle is not known: what its terms do there is taken as free
  for (int term = 0; term < place_.terms(); ++term)
    if (place_.readsAngle(term)) {
      const int k = first_ + term;
      still.h.row(k).setZero();
      still.h.col(k).setZero();
      still.g[k] = 0.0;
    }
  sum.add(still);
  h = sum.h;
  g = sum.g + sum.h * (x - startAt(x));
  priors(h, g);
  return sum.finite;
}

void LawSearch::priors(Eigen::MatrixXd& h, Eigen::VectorXd& g) const {
  for (int k = 0; k < space_.nuisances(); ++k) {
    const Coordinate& c = space_.coordinates()[k];
    const double weight = 1.0 / (c.prior_std * c.prior_std);
    h(k, k) += weight;
    g[k] += weight * (c.prior_mean - space_.start()[k]);
  }
}

double LawSearch::chi2(const Eigen::VectorXd& x, const std::vector<int>& which, std::vector<LocalState>& local,
                       double* count) const {
  EvaluationOptions options;
  options.jacobian = false;
  const NormalEquations normal = problem_.evaluate(x, which, local, options);
  if (count != nullptr) *count = normal.count;
  double sum = normal.finite ? normal.chi2 : 1e300;
  for (int k = 0; k < space_.nuisances(); ++k) {
    const Coordinate& c = space_.coordinates()[k];
    sum += std::pow((x[k] - c.prior_mean) / c.prior_std, 2);
  }
  return sum;
}

unsigned LawSearch::quantitiesIn(const std::vector<int>& terms) const {
  unsigned bits = 0;
  for (std::size_t i = 0; i < library_.size(); ++i)
    if (std::find(terms.begin(), terms.end(), library_[i]) != terms.end()) bits |= quantities_[i];
  return bits;
}

int LawSearch::quantityCount(const std::vector<int>& terms) const {
  return static_cast<int>(std::bitset<32>(quantitiesIn(terms)).count());
}

/// Laws about a point, not fitted yet: its own terms with one or two more, the best that forgets its own, and single ones
/// that do. They start at the point where it has no terms, else where the linearised equations lead.
std::vector<Hypothesis> LawSearch::contenders(const Hypothesis& about, int singles, int pairs, const Stakes& stakes,
                                              int instead) const {
  std::vector<Hypothesis> out;
  Eigen::MatrixXd h;
  Eigen::VectorXd g;
  std::vector<LocalState> local = about.local;
  if (!linearise(about.x, local, h, g)) return out;
  std::vector<int> base = base_, library;
  base.insert(base.end(), about.terms.begin(), about.terms.end());
  for (const int k : library_)
    if (std::find(about.terms.begin(), about.terms.end(), k) == about.terms.end()) library.push_back(k);
  const auto add = [&](std::vector<int> terms) {
    std::sort(terms.begin(), terms.end());
    if (terms.empty() || std::any_of(out.begin(), out.end(), [&](const Hypothesis& o) { return o.terms == terms; })) return;
    Hypothesis one;
    one.x = about.x;
    if (!about.terms.empty()) {
      std::vector<int> free = base_;
      free.insert(free.end(), terms.begin(), terms.end());
      const Eigen::VectorXd goal = solveFor(h, g, free);
      one.x = startAt(about.x);
      for (std::size_t i = 0; i < free.size(); ++i) one.x[free[i]] += goal[static_cast<long>(i)];
      one.x = space_.clamped(one.x);
    }
    one.terms = std::move(terms);
    one.local = local;
    out.push_back(std::move(one));
  };
  for (int size = 1; size <= 2; ++size)
    for (TermChoice& more : bestSubsets(h, g, base, library, size, size == 1 ? singles : pairs)) {
      more.terms.insert(more.terms.end(), about.terms.begin(), about.terms.end());
      if (static_cast<int>(more.terms.size()) <= most_terms) add(more.terms);
    }
  if (singles > 0) add(bestTerms(h, g, base_, library_, quantities_, stakes.least, stakes.tie, about.terms.empty() ? 2 : 3).terms);
  for (const TermChoice& other : bestSubsets(h, g, base_, library_, 1, instead)) add(other.terms);
  return out;
}

/// Fits its terms, the nuisance and the adopted effects' numbers.
FitResult LawSearch::fitTo(Hypothesis& law, FitOptions options) const {
  for (auto& local : law.local) local.evaluations = 0;  // of another machine
  options.held.assign(space_.size(), false);
  for (int k = first_; k < first_ + place_.terms(); ++k)
    options.held[k] = std::find(law.terms.begin(), law.terms.end(), k) == law.terms.end();
  if (number_ >= 0)
    options.held[number_] = std::none_of(law.terms.begin(), law.terms.end(), [&](int k) { return place_.readsNumber(k - first_); });
  FitResult found = fit(problem_, law.x, fit_, law.local, options);
  law.x = found.x;
  law.covariance = found.covariance;
  law.chi2 = found.finite ? found.chi2 : 1e300;
  return found;
}

Hypothesis LawSearch::toItsEnd(const Hypothesis& law) const {
  Hypothesis out = law;
  FitOptions options;
  options.scores = true;
  return fitTo(out, options).finite ? out : law;
}

/// Fits each: its terms, the nuisance and the adopted effects' numbers. Best first, laws of the same terms once.
void LawSearch::refine(std::vector<Hypothesis>& these, int iterations) {
  std::vector<char> known(these.size(), 0);
  for (std::size_t i = 0; i < these.size(); ++i)
    if (const Hypothesis* settled = fitted_.settled(these[i].terms, iterations)) {
      these[i] = *settled;
      known[i] = 1;
    }
  tbb::parallel_for(std::size_t{0}, these.size(), [&](std::size_t i) {
    if (known[i]) return;
    FitOptions options;
    options.most_iterations = iterations;
    options.covariance = false;
    options.columns_at_once = true;
    fitTo(these[i], options);
  });
  std::vector<Hypothesis> different;
  for (std::size_t i = 0; i < these.size(); ++i) {
    const Hypothesis& best = known[i] ? these[i] : fitted_.add(these[i], iterations);
    const auto same = std::find_if(different.begin(), different.end(), [&](const Hypothesis& o) { return o.terms == best.terms; });
    if (same == different.end())
      different.push_back(best);
    else if (best.chi2 < same->chi2)
      *same = best;
  }
  these = std::move(different);
  std::stable_sort(these.begin(), these.end(), [](const Hypothesis& a, const Hypothesis& b) { return a.chi2 < b.chi2; });
}

/// Of those in order of their chi2: the one of fewest terms that no longer one beats by `least` a term; of equals the one
/// that depends on fewest quantities.
const Hypothesis& LawSearch::chosen(const std::vector<Hypothesis>& these, const Stakes& stakes) const {
  const auto numbers = [&](const Hypothesis& one) {  // the width of a step is one more; a plane all have
    const bool step = !place_.isPlane() && std::any_of(one.terms.begin(), one.terms.end(), [&](int k) { return place_.readsNumber(k - first_); });
    return static_cast<double>(one.terms.size() + (step ? 1 : 0));
  };
  const auto cost = [&](const Hypothesis& one) { return one.chi2 + stakes.least * numbers(one); };
  const auto cheapest =
      std::min_element(these.begin(), these.end(), [&](const Hypothesis& a, const Hypothesis& b) { return cost(a) < cost(b); });
  const Hypothesis* best = &*cheapest;
  for (const auto& one : these)
    if (one.terms.size() <= best->terms.size() && cost(one) < cost(*cheapest) + stakes.tie &&
        quantityCount(one.terms) < quantityCount(best->terms))
      best = &one;
  return *best;
}

/// Single terms at the size that does best by itself, as predicted and not as linearised, best first.
std::vector<Hypothesis> LawSearch::screened(const Hypothesis& about) const {
  const StartScreen screen(recordings_, fit_, bare_, about.x.head(first_), about.local, offset_std_);
  std::vector<Hypothesis> out;
  for (const bool angle : {false, true}) {
    std::vector<int> terms;
    for (const int k : library_)
      if (place_.readsAngle(k - first_) == angle) terms.push_back(k);
    std::vector<double> size, gain(terms.size(), 0.0);
    for (const int k : terms) size.push_back(space_.coordinates()[k].scale);
    for (int round = 0; round < screen_rounds; ++round) {
      std::vector<Model> models;
      for (std::size_t i = 0; i < terms.size(); ++i) {
        Eigen::VectorXd x = about.x;
        x[terms[i]] = size[i];
        models.push_back(space_.model(space_.clamped(x)));
      }
      const auto gains = screen.gains(models, true, !angle);
      for (std::size_t i = 0; i < terms.size(); ++i) {
        gain[i] = gains[i].gain;
        if (gains[i].gain < 0.0)
          size[i] *= retreat;
        else if (round == 0)
          size[i] *= gains[i].share;  // from next to nothing: as far as that is linear
        else
          size[i] *= std::clamp(gains[i].share, -largest_move, largest_move);
      }
    }
    for (std::size_t i = 0; i < terms.size(); ++i) {
      if (!(gain[i] > 0.0) || size[i] == 0.0) continue;
      Hypothesis one;
      one.terms = {terms[i]};
      one.x = about.x;
      one.x[terms[i]] = size[i];
      one.local = about.local;
      one.chi2 = -gain[i];
      out.push_back(std::move(one));
    }
  }
  std::stable_sort(out.begin(), out.end(), [](const Hypothesis& a, const Hypothesis& b) { return a.chi2 < b.chi2; });
  // of each set of quantities the best: next to each other's size they are alike, and relatives are told apart later; of signals,
  // which have few terms, the best of all: about one that nearly does its relatives are not told
  std::vector<Hypothesis> different;
  for (auto& one : out) {
    const auto alike = [&](const Hypothesis& d) { return quantitiesIn(d.terms) == quantitiesIn(one.terms); };
    if (different.size() < screened_singles && (place_.isSensors() || std::none_of(different.begin(), different.end(), alike)))
      different.push_back(std::move(one));
  }
  return different;
}

const Hypothesis& LawSearch::plain(Begun& begun) {
  if (!begun.plain) begun.plain = plainAlongPath(begun).terms.empty() ? plainByScreen(begun) : plainAlongPath(begun);
  return *begun.plain;
}

Hypothesis LawSearch::believed(const Hypothesis& about) const {
  Hypothesis out = about;
  out.x.head(space_.nuisances()) = space_.start().head(space_.nuisances());
  return out;
}

/// Fitted: a look at each, and the best of them to their end.
void LawSearch::refineBest(std::vector<Hypothesis>& these) {
  refine(these, glance_iterations);
  these.resize(std::min(these.size(), plain_finalists));
  refine(these, refining_iterations);
}

/// The one term that explains all but what a further one could earn, over a relative that bends the motion about right.
Hypothesis LawSearch::plainByScreen(const Begun& begun) {
  const Hypothesis& none = begun.without;
  const Stakes& stakes = begun.stakes;
  const double excess = none.chi2 - stakes.count;
  if (!begun.along.laws.empty() && begun.along.promised < related_share * excess) return none;
  std::vector<Hypothesis> these = screened(believed(none));
  if (!space_.farFromBelief(none.x, far_from_belief).empty())
    for (auto& one : screened(none)) these.push_back(std::move(one));
  refineBest(these);
  if (these.empty() || none.chi2 - these[0].chi2 < related_share * excess) return none;
  // a relative of the right term: the motion is about right there, so what is linear about it tells others apart
  const Hypothesis relative = these[0];
  these = contenders(relative, 0, 0, stakes, first_singles);
  refineBest(these);
  these.push_back(relative);
  const Hypothesis& one = chosen(these, stakes);
  return stakes.nothingLeft(one.chi2) ? one : none;
}

/// The law without terms of quantities that the others have not, where these take little of what the others explain nearly
/// all of: the force along a path that is a little off has a shape that another term can mend.
Hypothesis LawSearch::sparing(const Hypothesis& law, const Stakes& stakes) {
  Hypothesis out = law;
  for (bool less = true; less && out.terms.size() > 1;) {
    less = false;
    std::vector<Hypothesis> shorter;
    for (const int term : out.terms) {
      Hypothesis one = out;
      one.terms.clear();
      for (const int k : out.terms)
        if (quantitiesIn({k}) != quantitiesIn({term})) one.terms.push_back(k);
      if (one.terms.empty() || quantityCount(one.terms) == quantityCount(out.terms)) continue;
      for (const int k : out.terms)
        if (std::find(one.terms.begin(), one.terms.end(), k) == one.terms.end()) one.x[k] = 0.0;
      shorter.push_back(std::move(one));
    }
    refine(shorter, refining_iterations);
    if (shorter.empty()) break;
    const double excess = stakes.least / least_term_share;
    if (shorter[0].chi2 - stakes.count < nearly_all_left * excess && shorter[0].chi2 - out.chi2 < further_quantity_share * excess) {
      out = shorter[0];
      less = true;
    }
  }
  return out;
}

Hypothesis LawSearch::best(Begun& begun) { return sparing(ofTerms(begun), begun.stakes); }

Hypothesis LawSearch::ofTerms(Begun& begun) {
  if (!plain(begun).terms.empty()) return plain(begun);
  const Stakes& stakes = begun.stakes;
  Hypothesis stands = begun.without;
  std::vector<Hypothesis> these = contenders(stands, first_singles, first_pairs, stakes);
  if (!space_.farFromBelief(stands.x, far_from_belief).empty())  // also from the belief: what is missing may have pulled the nuisance away
    for (auto& one : contenders(believed(stands), first_singles, first_pairs, stakes)) these.push_back(std::move(one));
  these.insert(these.end(), begun.along.laws.begin(), begun.along.laws.end());
  for (;;) {
    refine(these, glance_iterations);
    if (these.size() > finalists) these.resize(finalists);
    refine(these, refining_iterations);
    if (these.empty()) return stands;
    const Hypothesis& next = chosen(these, stakes);
    const long more = static_cast<long>(next.terms.size()) - static_cast<long>(stands.terms.size());
    if (!(stands.chi2 - next.chi2 > stakes.least * static_cast<double>(std::max(1L, more)))) return stands;
    stands = next;
    if (stakes.nothingLeft(stands.chi2) || static_cast<int>(stands.terms.size()) == most_terms) return stands;
    these = contenders(stands, further_singles, 0, stakes);
  }
}

}  // namespace amb_rotor
