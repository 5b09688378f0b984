#include "diagnosis_words.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "amb_rotor/effects/catalogue.hpp"

namespace amb_rotor {
namespace {

/// Deviations of the sensors' offsets, by chance 1, from which on the reader is told.
constexpr double offsets_worth_a_word = 2.5;

std::string twoPlaces(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f", value);
  return text;
}

}  // namespace

std::vector<std::string> sentencesOf(const Diagnosis& d) {
  std::vector<std::string> out;
  out.push_back("On the runs to validate, the believed model stands at " + twoPlaces(d.baseline.validation_error) +
                " times the noise, all its uncertain numbers refitted.");
  std::string together;
  for (const auto& step : d.steps) {
    together += step.added;
    if (step.only_with_next)
      together += " and, neither of them alone, ";
    else
      out.push_back("With " + together + " it stands at " + twoPlaces(step.errors.validation_error) + ".");
    if (!step.only_with_next) together.clear();
  }
  for (const auto& name : d.withdrawn)
    out.push_back(name + (d.steps.empty() ? " only bends towards what is missing: a law of a few terms leaves less than it does."
                                          : " was adopted on the way and is needless beside the others."));
  const CandidateErrors& last = d.steps.empty() ? d.baseline : d.steps.back().errors;
  if (showsInFitOnly(d.baseline))
    out.push_back("On the runs to fit it stands at " + twoPlaces(d.baseline.fit_error) +
                  (d.steps.empty() ? ": something is missing that those to validate do not show."
                                   : ", with what was added at " + twoPlaces(last.fit_error) + ": those to validate hardly show it."));
  if (d.baseline.offset_deviations > offsets_worth_a_word)
    out.push_back("For that the sensors' offsets lie " + twoPlaces(d.baseline.offset_deviations) +
                  " of their stated deviations from zero" +
                  (d.steps.empty() ? "" : ", with " + d.steps.back().added + " " + twoPlaces(last.offset_deviations)) +
                  ": the controller holds an offset as it holds a force.");
  if (d.steps.empty()) out.push_back("No effect of the catalogue earns its place on these runs.");
  std::string unseen;
  for (const auto& c : d.ranking)
    if (!c.excited) unseen += (unseen.empty() ? "" : ", ") + c.effect;
  if (!unseen.empty()) out.push_back("These runs cannot show: " + unseen + ".");
  return out;
}

std::vector<std::string> strainsOf(const Trial& standing) {
  std::vector<std::string> out;
  const FitSpace& space = *standing.space;
  const auto found = space.nuisanceValues(standing.fit.x, standing.fit.covariance);
  for (const int k : space.farFromBelief(standing.fit.x, far_by_chance)) {
    const Coordinate& c = space.coordinates()[k];
    char text[160];
    std::snprintf(text, sizeof text, "%.3g where the model has %.3g, %.0f of its stated deviations away", found[k].value,
                  c.by_logarithm ? std::exp(c.prior_mean) : c.prior_mean, std::fabs(standing.fit.x[k] - c.prior_mean) / c.prior_std);
    out.push_back("To fit these runs, " + c.name + " is " + text + ": the belief is wrong there, or it stands for an effect that these runs do not tell from it.");
  }
  return out;
}

std::string powerOf(const Trial& trial, double least_evidence) {
  const int more = static_cast<int>(trial.space->size() - trial.space->nuisances());
  const double wanted = std::sqrt(2.0 * least_evidence + more * std::log(std::max(2.0, trial.fit.count)));
  const EffectSchema& schema = *effectCatalogue().find(trial.effect);
  const auto values = trial.space->effectValues(static_cast<int>(trial.space->fitted().size()) - 1, trial.fit.x,
                                                trial.fit.covariance);
  std::string out;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const ParameterSchema& p = schema.parameters[i];
    const bool measures = p.role != ParameterRole::phase && p.role != ParameterRole::fixed && std::isfinite(p.neutral);
    if (!measures || !(values[i].std > 0.0) || !std::isfinite(values[i].std)) continue;
    char text[96];
    if (p.neutral == 0.0)
      std::snprintf(text, sizeof text, "%s %.2g %s", p.name.c_str(), wanted * values[i].std, p.unit.c_str());
    else
      std::snprintf(text, sizeof text, "%s %.4g +- %.2g %s", p.name.c_str(), p.neutral, wanted * values[i].std, p.unit.c_str());
    out += (out.empty() ? "would have been seen from about " : ", ") + std::string(text);
  }
  return out;
}

std::string leftOpenInWords(const LeftOpen& open, Through through, const CandidateErrors& errors) {
  const bool contact = through == Through::contact;
  char text[64];
  std::snprintf(text, sizeof text, "%.1f", open.deviations);
  return std::string(contact ? "through" : "without") + " contact the runs to validate stand at " +
         twoPlaces(contact ? errors.validation_error_contact : errors.validation_error_free) +
         " times the noise, which what the runs to fit leave open accounts for: with the model's numbers moved by " + text +
         " of their stated deviations, all together, they stand at " + twoPlaces(open.error);
}

Unexplained inContactOnly() {
  Unexplained out;
  out.depends_on = {"position", "velocity"};
  out.shape = "it shows in contact only: a force at the auxiliary bearings, where the rotor has used up the clearance";
  return out;
}

}  // namespace amb_rotor
