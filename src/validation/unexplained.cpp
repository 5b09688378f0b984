#include "amb_rotor/validation/unexplained.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>

#include "amb_rotor/common/units.hpp"
#include "amb_rotor/effects/catalogue.hpp"
#include "amb_rotor/effects/force_law.hpp"
#include "amb_rotor/validation/common_line.hpp"
#include "amb_rotor/validation/term_search.hpp"

namespace amb_rotor {
namespace {

using Law = effects::ForceLaw;

/// A further term must take this share of what is above the noise; subsets this close to each other count as
/// equal.
constexpr double least_share = 0.05, tie_share = 0.01;
/// Linearised so often about what was found; at first, where nothing is known of the nuisance, for two terms
/// at most.
constexpr int most_rounds = 4, most_halvings = 4;
/// Prior standard deviations by which a nuisance counts as pulled away.
constexpr double far_from_belief = 1.0;
/// Share of the unexplained that a line of fixed frequency must hold to be named without a law.
constexpr double least_line_share = 0.3;
/// Where nothing is found.
const char* const no_law =
    "no force at the bearings in position, velocity, spin speed, shaft angle, control current or time takes 5 % of the "
    "unexplained error";

/// Quantities of a term, out of its meaning ("position, velocity: ...").
std::vector<std::string> quantitiesOf(const std::string& meaning) {
  std::vector<std::string> out;
  std::stringstream list(meaning.substr(0, meaning.find(':')));
  for (std::string q; std::getline(list, q, ',');) out.push_back(q.substr(q.find_first_not_of(' ')));
  return out;
}

class LawSearch {
 public:
  LawSearch(const std::vector<Recording>& recordings, const Model& belief,
            const std::vector<EffectSetting>& adopted, double frequency_hz, double offset_std_m)
      : space_(belief, withLaw(adopted, frequency_hz)), problem_(recordings, space_, offset_std_m) {
    first_ = space_.size() - Law::term_count;
    const auto& parameters = effectCatalogue().find("force_law")->parameters;
    std::map<std::string, unsigned> bits;
    for (int k = 0; k < first_; ++k) base_.push_back(k);
    for (int term = 0; term < Law::term_count; ++term) {
      const bool hum = term >= Law::hum_x_cosine && term <= Law::hum_y_sine;
      if (hum && frequency_hz <= 0.0) continue;
      library_.push_back(first_ + term);
      unsigned all = 0;
      for (const auto& q : quantitiesOf(parameters[term].meaning))
        all |= bits.emplace(q, 1u << bits.size()).first->second;
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

  const std::vector<int>& fitted() const { return fit_; }
  const std::vector<int>& heldOut() const { return held_out_; }
  const FitSpace& space() const { return space_; }
  int first() const { return first_; }
  const FitProblem& problem() const { return problem_; }

  /// Normal equations about x, moved to the start, priors included. False: not finite.
  bool linearise(const Eigen::VectorXd& x, std::vector<LocalState>& local, Eigen::MatrixXd& h,
                 Eigen::VectorXd& g) const {
    NormalEquations sum = problem_.evaluate(x, turning_, local, {});
    NormalEquations still = problem_.evaluate(x, still_, local, {});
    // at standstill the shaft's angle is not known: what its terms do there is taken as free
    for (int term = 0; term < Law::term_count; ++term)
      if (Law::readsAngle(term)) {
        const int k = first_ + term;
        still.h.row(k).setZero();
        still.h.col(k).setZero();
        still.g[k] = 0.0;
      }
    sum.add(still);
    h = sum.h;
    g = sum.g + sum.h * (x - space_.start());
    for (int k = 0; k < space_.nuisances(); ++k) {
      const Coordinate& c = space_.coordinates()[k];
      const double weight = 1.0 / (c.prior_std * c.prior_std);
      h(k, k) += weight;
      g[k] += weight * (c.prior_mean - space_.start()[k]);
    }
    return sum.finite;
  }
  double chi2(const Eigen::VectorXd& x, const std::vector<int>& which, std::vector<LocalState>& local,
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
  /// The point that base and terms lead to, and their covariance.
  Eigen::VectorXd solve(const Eigen::MatrixXd& h, const Eigen::VectorXd& g, const std::vector<int>& terms,
                        Eigen::MatrixXd* covariance) const {
    std::vector<int> chosen = base_;
    chosen.insert(chosen.end(), terms.begin(), terms.end());
    const Eigen::VectorXd solution = solveFor(h, g, chosen, covariance);
    Eigen::VectorXd x = space_.start();
    for (std::size_t i = 0; i < chosen.size(); ++i) x[chosen[i]] += solution[static_cast<long>(i)];
    return space_.clamped(x);
  }

  /// Whether the nuisance is away from what the owner believes.
  bool pulled(const Eigen::VectorXd& x) const {
    for (int k = 0; k < space_.nuisances(); ++k)
      if (std::fabs(x[k] - space_.coordinates()[k].prior_mean) >
          far_from_belief * space_.coordinates()[k].prior_std)
        return true;
    return false;
  }

  struct Step {
    std::vector<int> terms;
    Eigen::VectorXd x;
    Eigen::MatrixXd covariance;
    double chi2 = 1e300;
  };
  /// The best terms about a point, and the step there: a shorter one where a law is too large to be linear.
  Step stepFrom(const Eigen::VectorXd& point, double excess, double reached, int most,
                std::vector<LocalState>& local) const {
    Step step;
    Eigen::MatrixXd h;
    Eigen::VectorXd g;
    if (!linearise(point, local, h, g)) return step;
    const TermChoice choice =
        bestTerms(h, g, base_, library_, quantities_, least_share * excess, tie_share * excess, most);
    if (choice.terms.empty()) return step;
    step.terms = choice.terms;
    const Eigen::VectorXd goal = solve(h, g, choice.terms, &step.covariance);
    Eigen::VectorXd from = point;
    for (int k = first_; k < space_.size(); ++k)
      if (std::find(choice.terms.begin(), choice.terms.end(), k) == choice.terms.end()) from[k] = 0.0;
    double share = 1.0;
    for (int i = 0; i < most_halvings && step.chi2 >= reached; ++i, share *= 0.5) {
      step.x = from + share * (goal - from);
      std::vector<LocalState> there = local;
      step.chi2 = chi2(step.x, fit_, there, nullptr);
    }
    return step;
  }

 private:
  static std::vector<EffectSetting> withLaw(std::vector<EffectSetting> effects, double frequency_hz) {
    std::vector<double> values(Law::term_count + 1, 0.0);
    values[Law::term_count] = frequency_hz > 0.0 ? frequency_hz : 50.0;
    effects.push_back({"force_law", values});
    return effects;
  }

  FitSpace space_;
  int first_ = 0;  ///< coordinate of the law's first term; those before are always fitted
  FitProblem problem_;
  std::vector<int> base_, library_, fit_, still_, turning_, held_out_;
  std::vector<unsigned> quantities_;
};

/// Residuals over the noise of the model as it stands, for the runs given.
std::vector<ResidualRows> residualsOf(const std::vector<Recording>& recordings, const Model& model,
                                      const std::vector<int>& which, std::vector<LocalState>& local,
                                      double offset_std_m) {
  const FitSpace space(model, {});
  const FitProblem problem(recordings, space, offset_std_m);
  EvaluationOptions options;
  options.jacobian = false;
  options.keep_prediction = true;
  std::vector<RunResult> results;
  problem.evaluate(space.start(), which, local, options, &results);
  std::vector<ResidualRows> out;
  for (std::size_t r = 0; r < which.size(); ++r) {
    const Recording& rec = recordings[which[r]];
    ResidualRows rows;
    rows.sample_rate_hz = rec.run.sample_rate_hz;
    for (int c = 0; c < predicted_channels && !results[r].predicted.empty(); ++c) {
      if (rec.noise[c] <= 0.0) continue;
      std::vector<double> row(rec.samples);
      for (long i = 0; i < rec.samples; ++i) {
        const std::size_t at = i * predicted_channels + c;
        row[i] = (rec.measured[at] - results[r].predicted[at]) / rec.noise[c];
      }
      rows.channels.push_back(std::move(row));
    }
    out.push_back(std::move(rows));
  }
  return out;
}

/// What a line of a frequency takes of the sum of squares, with a phase of its own in each run and channel.
double squaresOfLine(const std::vector<ResidualRows>& runs, double frequency_hz) {
  double sum = 0.0;
  for (const auto& run : runs)
    for (const auto& row : run.channels) {
      const double step = two_pi * frequency_hz / run.sample_rate_hz, n = static_cast<double>(row.size());
      double c = 0.0, s = 0.0;
      for (std::size_t i = 0; i < row.size(); ++i) {
        c += row[i] * std::cos(step * i);
        s += row[i] * std::sin(step * i);
      }
      sum += 2.0 * (c * c + s * s) / n;
    }
  return sum;
}

void describe(const LawSearch& search, const std::vector<int>& terms, const Eigen::VectorXd& x,
              const Eigen::MatrixXd& covariance, Unexplained& out) {
  const auto& parameters = effectCatalogue().find("force_law")->parameters;
  const int first = search.first();
  std::ostringstream shape;
  shape << "force at the bearings = ";
  out.depends_on.clear();
  out.terms.clear();
  for (std::size_t t = 0; t < terms.size(); ++t) {
    const ParameterSchema& p = parameters[terms[t] - first];
    const int place = first + static_cast<int>(t);
    out.terms.push_back({p.name, x[terms[t]], std::sqrt(std::max(0.0, covariance(place, place)))});
    for (const auto& q : quantitiesOf(p.meaning))
      if (std::find(out.depends_on.begin(), out.depends_on.end(), q) == out.depends_on.end())
        out.depends_on.push_back(q);
    shape << (t > 0 ? " + " : "") << x[terms[t]] << " " << p.unit << " * "
          << p.meaning.substr(p.meaning.find(": ") + 2);
  }
  std::sort(out.depends_on.begin(), out.depends_on.end());
  if (out.frequency_hz > 0.0) shape << ", f = " << out.frequency_hz << " Hz";
  out.shape = shape.str();
}

}  // namespace

Unexplained searchUnexplained(const std::vector<Recording>& recordings, const FitSpace& space,
                              const Eigen::VectorXd& x, const std::vector<LocalState>& local,
                              double offset_std_m) {
  Unexplained out;
  std::vector<int> free;
  for (int i = 0; i < static_cast<int>(recordings.size()); ++i)
    if (!recordings[i].holdsContact() && recordings[i].run.use == RunUse::fit) free.push_back(i);
  if (free.empty()) {
    out.shape = "no run without contact to look at";
    return out;
  }
  // the law's terms are new unknowns, from zero, beside the nuisance with its own prior and what was adopted
  const Model model = space.model(x);
  Eigen::VectorXd believed = x;
  for (int k = 0; k < space.nuisances(); ++k) believed[k] = space.coordinates()[k].prior_mean;
  std::vector<LocalState> own = local;
  const std::vector<ResidualRows> residuals = residualsOf(recordings, model, free, own, offset_std_m);
  const CommonLine line = commonLine(residuals);
  const LawSearch search(recordings, space.model(believed), space.fitted(), line.frequency_hz, offset_std_m);
  Eigen::VectorXd at = search.space().start();
  at.head(x.size()) = x;
  double count = 0.0;
  const double before = search.chi2(at, search.fitted(), own, &count);
  const double excess = std::max(1.0, before - count);
  double reached = before;
  std::vector<int> terms;
  Eigen::MatrixXd covariance;
  for (int round = 0; round < most_rounds; ++round) {
    // at first also from the believed nuisance, where what is missing has pulled it away
    std::vector<Eigen::VectorXd> points = {at};
    if (round == 0 && search.pulled(at)) {
      points.push_back(at);
      points.back().head(space.nuisances()) = search.space().start().head(space.nuisances());
    }
    LawSearch::Step best;
    for (const Eigen::VectorXd& point : points) {
      const LawSearch::Step step = search.stepFrom(point, excess, reached, round == 0 ? 2 : 3, own);
      if (step.chi2 < best.chi2) best = step;
    }
    if (best.chi2 >= reached) break;
    // nothing is left that a further term could earn, or nothing more is to be had
    const bool done = best.chi2 - count < least_share * excess ||
                      (reached - best.chi2 < 0.01 * excess && terms == best.terms);
    terms = best.terms;
    covariance = best.covariance * std::max(1.0, best.chi2 / std::max(1.0, count));
    at = best.x;
    reached = best.chi2;
    if (done) break;
  }
  const double line_share =
      line.frequency_hz > 0.0 ? squaresOfLine(residuals, line.frequency_hz) / excess : 0.0;
  if (terms.empty() || (before - reached < 0.5 * line_share * excess && line_share > least_line_share)) {
    if (line_share > least_line_share) {
      std::ostringstream shape;
      shape << "a force that repeats at " << line.frequency_hz
            << " Hz whatever the speed, with a phase of its own in each run";
      out.depends_on = {"time"};
      out.shape = shape.str();
      out.frequency_hz = line.frequency_hz;
      return out;
    }
    if (out.shape.empty())
      out.shape = no_law;
    return out;
  }
  const int first = search.first();
  if (std::any_of(terms.begin(), terms.end(),
                  [&](int k) { return k - first >= Law::hum_x_cosine && k - first <= Law::hum_y_sine; }))
    out.frequency_hz = line.frequency_hz;
  describe(search, terms, at, covariance, out);
  if (!search.heldOut().empty()) {
    double held = 0.0;
    std::vector<LocalState> fresh = own;
    Eigen::VectorXd stood = search.space().start();
    stood.head(x.size()) = x;
    const double was = search.chi2(stood, search.heldOut(), fresh, &held);
    const double is = search.chi2(at, search.heldOut(), fresh, nullptr);
    out.held_out_gain = (was - is) / std::max(1.0, was - held);
    if (out.held_out_gain < least_share) {  // it only repeats the runs that it was fitted to
      out = Unexplained();
      out.shape = no_law;
    }
  }
  return out;
}

}  // namespace amb_rotor
