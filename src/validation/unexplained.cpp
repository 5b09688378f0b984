#include "amb_rotor/validation/unexplained.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <sstream>

#include "amb_rotor/common/units.hpp"
#include "amb_rotor/effects/catalogue.hpp"
#include "amb_rotor/effects/force_law.hpp"
#include "amb_rotor/validation/common_line.hpp"
#include "law_search.hpp"

namespace amb_rotor {
namespace {

/// Share of the unexplained that a line of fixed frequency must hold to be named without a law; and to be sought for no further.
constexpr double least_line_share = 0.3, plain_line_share = 0.8;
/// Where nothing is found.
const char* const no_law =
    "no force at the bearings in position, velocity, spin speed, shaft angle, control current or time takes 5 % of the "
    "unexplained error";

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

/// @param level  of what the law leaves: the standard deviations are over it
void describe(const LawSearch& search, const Hypothesis& law, double level, Unexplained& out) {
  const auto& parameters = effectCatalogue().find("force_law")->parameters;
  const int first = search.first();
  std::ostringstream shape;
  shape << "force at the bearings = ";
  out.depends_on.clear();
  out.terms.clear();
  for (std::size_t t = 0; t < law.terms.size(); ++t) {
    const int k = law.terms[t];
    const ParameterSchema& p = parameters[k - first];
    out.terms.push_back({p.name, law.x[k], std::sqrt(std::max(0.0, level * law.covariance(k, k)))});
    for (const auto& q : quantitiesOf(p.meaning))
      if (std::find(out.depends_on.begin(), out.depends_on.end(), q) == out.depends_on.end())
        out.depends_on.push_back(q);
    shape << (t > 0 ? " + " : "") << law.x[k] << " " << p.unit << " * "
          << p.meaning.substr(p.meaning.find(": ") + 2);
  }
  std::sort(out.depends_on.begin(), out.depends_on.end());
  if (out.frequency_hz > 0.0) shape << ", f = " << out.frequency_hz << " Hz";
  out.shape = shape.str();
}

}  // namespace

struct UnexplainedSearch::Parts {
  std::vector<LocalState> local;
  std::vector<ResidualRows> residuals;  ///< of the runs to fit
  CommonLine line;
  LawSearch search;
  std::vector<ResidualRows> held_out;  ///< of the runs to validate
  Eigen::VectorXd stood;  ///< the model as it stands, in the search's space
  double before = 0.0, count = 0.0;
  std::optional<LawSearch::Begun> begun = {};

  Parts(const std::vector<Recording>& recordings, const FitSpace& space, const Eigen::VectorXd& x,
        const std::vector<LocalState>& own, const std::vector<int>& free, double offset_std_m)
      : local(own),
        residuals(residualsOf(recordings, space.model(x), free, local, offset_std_m)),
        line(commonLine(residuals)),
        search(recordings, space.model(believed(space, x)), space.fitted(), line.frequency_hz, offset_std_m),
        held_out(untouched(recordings, space.model(x), search.heldOut(), local, offset_std_m)),
        stood(search.space().start()) {
    stood.head(x.size()) = x;
    before = search.chi2(stood, search.fitted(), local, &count);
  }
  /// Residuals of runs whose unknowns stay as they are: a law may lead such a run into another motion.
  static std::vector<ResidualRows> untouched(const std::vector<Recording>& recordings, const Model& model, const std::vector<int>& which,
                                             std::vector<LocalState> local, double offset_std_m) {
    return residualsOf(recordings, model, which, local, offset_std_m);
  }
  /// Of what is above the noise, the line's share.
  double shareOfLine(const std::vector<ResidualRows>& runs) const {
    double squares = 0.0, numbers = 0.0;
    for (const auto& run : runs)
      for (const auto& row : run.channels) {
        for (const double r : row) squares += r * r;
        numbers += static_cast<double>(row.size());
      }
    return line.frequency_hz > 0.0 ? squaresOfLine(runs, line.frequency_hz) / std::max(1.0, squares - numbers) : 0.0;
  }
  /// The law's terms are new unknowns, from zero, beside the nuisance with its own prior and what was adopted.
  static Eigen::VectorXd believed(const FitSpace& space, const Eigen::VectorXd& x) {
    Eigen::VectorXd out = x;
    for (int k = 0; k < space.nuisances(); ++k) out[k] = space.coordinates()[k].prior_mean;
    return out;
  }
};

UnexplainedSearch::UnexplainedSearch(const std::vector<Recording>& recordings, const FitSpace& space, const Eigen::VectorXd& x,
                                     const std::vector<LocalState>& local, double offset_std_m) {
  std::vector<int> free;
  for (int i = 0; i < static_cast<int>(recordings.size()); ++i)
    if (!recordings[i].holdsContact() && recordings[i].run.use == RunUse::fit) free.push_back(i);
  if (!free.empty()) parts_ = std::make_unique<Parts>(recordings, space, x, local, free, offset_std_m);
}

UnexplainedSearch::UnexplainedSearch(UnexplainedSearch&&) noexcept = default;
UnexplainedSearch& UnexplainedSearch::operator=(UnexplainedSearch&&) noexcept = default;
UnexplainedSearch::~UnexplainedSearch() = default;

Unexplained UnexplainedSearch::law(LawEffort effort) {
  Unexplained out;
  if (parts_ == nullptr) {
    out.shape = "no run without contact to look at";
    return out;
  }
  LawSearch& search = parts_->search;
  const CommonLine& line = parts_->line;
  const double before = parts_->before, count = parts_->count, excess = std::max(1.0, before - count);
  const double line_share = parts_->shareOfLine(parts_->residuals);
  if (!parts_->begun) parts_->begun = search.begin(parts_->stood, parts_->local, before, count);
  const bool own_phases = line_share > plain_line_share && parts_->begun->along.promised < 0.5 * line_share * excess;
  if (effort == LawEffort::foreseen && line_share < plain_line_share && !parts_->begun->along.foreseesPlain()) return out;
  const bool plain = effort != LawEffort::whole;
  const Hypothesis law = own_phases                      ? parts_->begun->without
                         : effort == LawEffort::foreseen ? search.plainAlongPath(*parts_->begun)
                         : plain                         ? search.plain(*parts_->begun)
                                                         : search.best(*parts_->begun);
  const auto inCatalogue = [&](int term) { return effects::ForceLaw::alsoInCatalogue(term - search.first()); };
  const bool none = law.terms.empty() || (plain && std::any_of(law.terms.begin(), law.terms.end(), inCatalogue));
  if (plain && none && line_share < plain_line_share) return out;
  const double reached = law.terms.empty() ? before : law.chi2;
  const std::vector<int>& terms = law.terms;
  if (none || (before - reached < 0.5 * line_share * excess && line_share > least_line_share)) {
    if (line_share > least_line_share) {
      std::ostringstream shape;
      shape << "a force that repeats at " << line.frequency_hz
            << " Hz whatever the speed, with a phase of its own in each run";
      out.depends_on = {"time"};
      out.shape = shape.str();
      out.frequency_hz = line.frequency_hz;
      out.held_out_gain = parts_->shareOfLine(parts_->held_out);
      return out;
    }
    if (out.shape.empty())
      out.shape = no_law;
    return out;
  }
  const int first = search.first();
  if (std::any_of(terms.begin(), terms.end(),
                  [&](int k) { return k - first >= effects::ForceLaw::hum_x_cosine && k - first <= effects::ForceLaw::hum_y_sine; }))
    out.frequency_hz = line.frequency_hz;
  describe(search, law, std::max(1.0, reached / std::max(1.0, count)), out);
  if (!search.heldOut().empty()) {
    double held = 0.0;
    std::vector<LocalState> fresh = parts_->local;
    const double was = search.chi2(parts_->stood, search.heldOut(), fresh, &held);
    const double is = search.chi2(law.x, search.heldOut(), fresh, nullptr);
    out.held_out_gain = (was - is) / std::max(1.0, was - held);
    if (out.held_out_gain < least_term_share) {  // it only repeats the runs that it was fitted to
      out = Unexplained();
      out.shape = no_law;
    }
  }
  return out;
}

}  // namespace amb_rotor
