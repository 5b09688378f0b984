#include "amb_rotor/validation/unexplained.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <sstream>

#include "amb_rotor/common/units.hpp"
#include "amb_rotor/effects/catalogue.hpp"
#include "amb_rotor/effects/law_terms.hpp"
#include "amb_rotor/validation/common_line.hpp"
#include "law_search.hpp"

namespace amb_rotor {
namespace {

/// Share of the unexplained that a line of fixed frequency must hold to be named without a law; and to be sought for no further.
constexpr double least_line_share = 0.3, plain_line_share = 0.8;
/// Where nothing is found.
const char* const no_law =
    "no force at the bearings, at one plane or against the tilt in position, velocity, spin speed, shaft angle, control current or "
    "time takes 5 % of the unexplained error, and no term of the sensors' signals nearly all of it";
/// Of what forces along the measured path leave at the bearings, what the best other place of a round behind the first may leave to look
/// closer, and the best of all to try a law there.
constexpr double less_at_round = 0.9, less_at_best = 0.5;
/// Planes from end to end of the rotor's own; rounds, of those in which the tilt takes part.
constexpr int first_planes = 7, place_rounds = 4, tilt_rounds = 2;

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

/// Share of what is above the noise that is taken away: all of it, where the noise is less than stated and more is taken.
double shareOf(double taken, double above) { return std::min(1.0, taken / std::max(1.0, above)); }

/// Whether a law at the bearings is one term with one sign at both: what acts elsewhere is two terms there, or more.
bool isOneAlikeAtBoth(const LawSearch& search, const Hypothesis& law) {
  return law.terms.size() == 1 && law.terms.front() - search.first() < effects::LawTerms::antisym_position;
}

/// Whether a law is one term of the control current: the controller passes what is in its signals on to that.
bool isOneOfCurrent(const LawSearch& search, const Hypothesis& law) {
  if (law.terms.size() != 1) return false;
  const auto quantities = quantitiesOf(search.place().schema().parameters[law.terms.front() - search.first()].meaning);
  return quantities.size() == 1 && quantities.front() == "control current";
}

void describe(const LawSearch& search, const Hypothesis& law, Unexplained& out) {
  const auto& parameters = search.place().schema().parameters;
  const int first = search.first(), number = search.numberCoordinate();
  const auto deviation = [&](int k) { return std::sqrt(std::max(0.0, law.covariance(k, k))); };
  std::ostringstream shape;
  out.place = search.place().kind;
  switch (out.place) {
    case LawPlace::Kind::rotor:
      out.plane_z_m = law.x[number];
      out.plane_std_m = deviation(number);
      shape << "force at the plane z = " << *out.plane_z_m << " m = ";
      break;
    case LawPlace::Kind::tilt:
      shape << "couple F at bearing b and -F at a, with p = (p_b - p_a)/2: F = ";
      break;
    case LawPlace::Kind::sensors:
      shape << "signal of each sensor pair = s + ";
      break;
    case LawPlace::Kind::magnetic_bearings:
      shape << "force at the bearings = ";
  }
  out.depends_on.clear();
  out.terms.clear();
  for (std::size_t t = 0; t < law.terms.size(); ++t) {
    const int k = law.terms[t];
    const ParameterSchema& p = parameters[k - first];
    if (!search.place().isPlane() && search.place().readsNumber(k - first)) out.step_width = std::exp(law.x[number]);
    out.terms.push_back({p.name, law.x[k], deviation(k)});
    for (const auto& q : quantitiesOf(p.meaning))
      if (std::find(out.depends_on.begin(), out.depends_on.end(), q) == out.depends_on.end())
        out.depends_on.push_back(q);
    shape << (t > 0 ? " + " : "") << law.x[k] << " " << p.unit << " * "
          << p.meaning.substr(p.meaning.find(": ") + 2);
  }
  std::sort(out.depends_on.begin(), out.depends_on.end());
  if (out.frequency_hz > 0.0) shape << ", f = " << out.frequency_hz << " Hz";
  if (out.step_width > 0.0) shape << ", w = " << out.step_width << (search.place().isSensors() ? " m" : " A");
  out.shape = shape.str();
}

}  // namespace

struct UnexplainedSearch::Parts {
  /// A search at a place, with the model as it stands in its space.
  struct Sought {
    LawSearch search;
    Eigen::VectorXd stood;
    std::optional<LawSearch::Begun> begun = {};

    Sought(const std::vector<Recording>& recordings, const Model& belief, const std::vector<EffectSetting>& adopted,
           const Eigen::VectorXd& x, double frequency_hz, double offset_std_m, LawPlace place)
        : search(recordings, belief, adopted, frequency_hz, offset_std_m, place), stood(search.space().start()) {
      stood.head(x.size()) = x;
    }
    LawSearch::Begun& begin(const std::vector<LocalState>& local, double before, double count) {
      if (!begun) begun = search.begin(stood, local, before, count);
      return *begun;
    }
  };

  const std::vector<Recording>& recordings;
  Eigen::VectorXd x;
  Model belief;
  std::vector<EffectSetting> adopted;
  double offset_std_m;
  std::vector<LocalState> local;
  std::vector<ResidualRows> residuals;  ///< of the runs to fit
  CommonLine line;
  Sought at_bearings;
  std::optional<std::unique_ptr<Sought>> elsewhere = {};  ///< once it was looked for; null: no place promises more than the bearings
  bool sought_about_law = false;
  std::unique_ptr<Sought> in_sensors = {};  ///< once it was asked for
  std::vector<ResidualRows> held_out;  ///< of the runs to validate
  double before = 0.0, count = 0.0;

  Parts(const std::vector<Recording>& all, const FitSpace& space, const Eigen::VectorXd& at,
        const std::vector<LocalState>& own, const std::vector<int>& free, double offset_std)
      : recordings(all),
        x(at),
        belief(space.model(believed(space, at))),
        adopted(space.fitted()),
        offset_std_m(offset_std),
        local(own),
        residuals(residualsOf(all, space.model(at), free, local, offset_std)),
        line(commonLine(residuals)),
        at_bearings(all, belief, adopted, at, line.frequency_hz, offset_std, {}),
        held_out(untouched(all, space.model(at), at_bearings.search.heldOut(), local, offset_std)) {
    before = at_bearings.search.chi2(at_bearings.stood, at_bearings.search.fitted(), local, &count);
  }
  std::unique_ptr<Sought> soughtAt(LawPlace place) const {
    return std::make_unique<Sought>(recordings, belief, adopted, x, line.frequency_hz, offset_std_m, place);
  }
  Sought& inSensors() {
    if (in_sensors == nullptr) in_sensors = soughtAt(LawPlace::inSensors());
    return *in_sensors;
  }
  double excess() const { return std::max(1.0, before - count); }
  /// The search at the plane, or against the tilt, that leaves least along the measured path, where that is far less than at the
  /// bearings. Null: there is none.
  /// @param law  at the bearings: one that leaves nothing has the nuisance right
  Sought* otherPlace(const Hypothesis& law) {
    const bool about_law = !law.terms.empty();
    if (!elsewhere || (*elsewhere == nullptr && about_law && !sought_about_law)) elsewhere = seekPlace(law);
    sought_about_law = sought_about_law || about_law;
    return elsewhere->get();
  }
  std::unique_ptr<Sought> seekPlace(const Hypothesis& law) {
    const LawSearch::AlongPath& bearings = at_bearings.begin(local, before, count).along;
    if (bearings.laws.empty()) return nullptr;  // the path tells nothing
    const LawSearch::Stakes stakes(before, count);
    const auto& own = belief.rig.planes;
    const auto ends = std::minmax({own.amb[0], own.amb[1], own.sensor[0], own.sensor[1], own.aux[0], own.aux[1]});
    double spacing = (ends.second - ends.first) / (first_planes - 1);
    std::vector<LawPlace> places;
    for (int plane = 0; plane < first_planes; ++plane) places.push_back(LawPlace::atPlane(ends.first + plane * spacing));
    LawPlace best_place;
    // about the law's nuisance or the belief, then ever closer about the nuisance that the best so far asks for
    LawSearch::Left best = {0.0, law.terms.empty() ? at_bearings.search.space().start() : law.x};
    for (int round = 0; round < place_rounds; ++round) {
      if (round < tilt_rounds) places.push_back(LawPlace::ofTilt());
      const Eigen::VectorXd about = best.x;
      const StartScreen screen = at_bearings.search.screenAt(about, local);
      if (!screen.isFinite()) return nullptr;
      best.above = std::numeric_limits<double>::infinity();
      for (const LawPlace& place : places) {
        LawSearch::Left one = soughtAt(place)->search.leftByOneSet(screen, about, stakes);
        if (one.above < best.above) {
          best = std::move(one);
          best_place = place;
        }
      }
      if (round > 0 && !leavesLess(best, less_at_round)) return nullptr;
      spacing *= 0.5;
      places = {best_place};
      if (best_place.isPlane())
        for (const double z : {best_place.plane_z_m - spacing, best_place.plane_z_m + spacing}) places.push_back(LawPlace::atPlane(z));
    }
    std::unique_ptr<Sought> there = soughtAt(best_place);
    return leavesLess(there->begin(local, before, count).along.left, less_at_best) ? std::move(there) : nullptr;
  }
  /// Whether a law elsewhere leaves less along the measured path than a share of what one at the bearings leaves. What a law that goes by
  /// the shaft's angle leaves at standstill does not count: there the angle is fitted, and the path does not tell it.
  bool leavesLess(const LawSearch::Left& there, double share) const {
    const double not_told = there.reads_angle ? at_bearings.search.aboveAtStandstill(at_bearings.stood, local) : 0.0;
    return there.above - not_told < share * (at_bearings.begun->along.left.above - not_told);
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
    return line.frequency_hz > 0.0 ? shareOf(squaresOfLine(runs, line.frequency_hz), squares - numbers) : 0.0;
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
  const CommonLine& line = parts_->line;
  const double before = parts_->before, count = parts_->count, excess = parts_->excess();
  const double line_share = parts_->shareOfLine(parts_->residuals);
  const auto begunAt = [&](Parts::Sought& sought) -> LawSearch::Begun& { return sought.begin(parts_->local, before, count); };
  const bool own_phases = line_share > plain_line_share && begunAt(parts_->at_bearings).along.promised < 0.5 * line_share * excess;
  const bool plain = effort != LawEffort::whole;
  Parts::Sought* sought = &parts_->at_bearings;
  Hypothesis law = begunAt(*sought).without;
  // what the measured path tells of the bearings; of another place, unless that is one term, alike at both; then what else the bearings have
  if (!own_phases && (effort != LawEffort::foreseen || begunAt(*sought).along.foreseesPlain()))
    law = sought->search.plainAlongPath(begunAt(*sought));
  if (!own_phases && !isOneAlikeAtBoth(sought->search, law)) {
    Parts::Sought* const other = parts_->otherPlace(law);
    // another place counts as a term; of equals it is the plainer one
    const LawSearch::Stakes stakes(before, count);
    const auto costOf = [&](const Hypothesis& one, bool elsewhere) {
      return one.terms.empty() ? std::numeric_limits<double>::infinity()
                               : one.chi2 + stakes.least * static_cast<double>(one.terms.size()) + (elsewhere ? stakes.least - stakes.tie : 0.0);
    };
    const auto prefer = [&](Parts::Sought& there, Hypothesis one) {
      if (!(costOf(one, &there != &parts_->at_bearings) < costOf(law, sought != &parts_->at_bearings))) return;
      law = std::move(one);
      sought = &there;
    };
    const auto bestAt = [&](Parts::Sought& there) { return plain ? there.search.plain(begunAt(there)) : there.search.best(begunAt(there)); };
    if (other != nullptr && effort != LawEffort::foreseen)
      prefer(*other, bestAt(*other));
    else if (other != nullptr && begunAt(*other).along.foreseesPlain())
      prefer(*other, other->search.plainAlongPath(begunAt(*other)));
    // a signal's term is its law only where it explains all: beside two effects that are not known it would take much, too
    const auto leaves = [&] { return effort != LawEffort::foreseen && (law.terms.empty() || !begunAt(*sought).stakes.nothingLeft(law.chi2)); };
    if (leaves()) prefer(parts_->inSensors(), parts_->inSensors().search.plain(begunAt(parts_->inSensors())));
    if (leaves()) prefer(parts_->at_bearings, bestAt(parts_->at_bearings));
  }
  if (const LawSearch::Stakes stakes(before, count); isOneOfCurrent(sought->search, law) && stakes.nothingLeft(law.chi2)) {
    // a step in a signal makes one in the current: where both laws explain all but a little, what they leave tells; of two steps, each
    // with its width, that alone
    const Hypothesis& signal = parts_->inSensors().search.plain(begunAt(parts_->inSensors()));
    const bool step = sought->search.place().readsNumber(law.terms.front() - sought->search.first());
    if (!signal.terms.empty() && signal.chi2 < law.chi2 - (step ? 0.0 : stakes.tie)) {
      law = signal;
      sought = &parts_->inSensors();
    }
  }
  LawSearch& search = sought->search;
  const auto inCatalogue = [&](int term) { return search.place().isInCatalogue(term - search.first()); };
  const bool none = law.terms.empty() || (plain && std::any_of(law.terms.begin(), law.terms.end(), inCatalogue));
  if (plain && none && line_share < plain_line_share) return out;
  const double reached = law.terms.empty() ? before : law.chi2;
  const std::vector<int> terms = law.terms;
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
  if (std::any_of(terms.begin(), terms.end(), [&](int k) { return search.place().repeatsInTime(k - search.first()); }))
    out.frequency_hz = line.frequency_hz;
  law = search.toItsEnd(law);
  describe(search, law, out);
  if (!search.heldOut().empty()) {
    double held = 0.0;
    std::vector<LocalState> fresh = parts_->local;
    const double was = search.chi2(sought->stood, search.heldOut(), fresh, &held);
    const double is = search.chi2(law.x, search.heldOut(), fresh, nullptr);
    out.held_out_gain = shareOf(was - is, was - held);
    if (out.held_out_gain < least_term_share) {  // it only repeats the runs that it was fitted to
      out = Unexplained();
      out.shape = no_law;
    }
  }
  return out;
}

}  // namespace amb_rotor
