#include "amb_rotor/validation/compare.hpp"

#include <tbb/global_control.h>

#include <cmath>
#include <memory>
#include <numeric>

#include "amb_rotor/validation/breakdown.hpp"
#include "amb_rotor/validation/fit.hpp"
#include "amb_rotor/validation/sensor_remarks.hpp"
#include "amb_rotor/validation/stretches.hpp"
#include "side_by_side.hpp"

namespace amb_rotor {

Comparison sideBySide(const std::vector<Recording>& recordings, const FitSpace& space, double offset_std_m, const FitResult& fitted,
                      std::vector<LocalState> local, const std::vector<RunResult>& known) {
  Comparison out;
  const FitProblem problem(recordings, space, offset_std_m);
  std::vector<int> everything(recordings.size()), validate, asked;
  std::iota(everything.begin(), everything.end(), 0);
  std::vector<RunResult> results = known;
  results.resize(recordings.size());
  for (const int i : everything) {
    if (recordings[i].run.use == RunUse::validate) validate.push_back(i);
    if (results[i].predicted.empty()) asked.push_back(i);
  }
  EvaluationOptions evaluation;
  evaluation.jacobian = false;
  evaluation.keep_prediction = true;
  evaluation.window_passes = 3;
  evaluation.thorough = true;
  std::vector<RunResult> own;
  evaluateSettled(problem, fitted.x, asked, local, evaluation, own);
  for (std::size_t k = 0; k < asked.size(); ++k) results[asked[k]] = std::move(own[k]);
  out.model = space.model(fitted.x);
  out.nuisance = space.nuisanceValues(fitted.x, fitted.covariance);
  for (int i : everything) {
    const Recording& rec = recordings[i];
    PredictedRun run;
    run.id = rec.run.id;
    run.use = rec.run.use == RunUse::fit ? "fit" : "validate";
    run.kind = runKindName(rec.run.kind);
    run.sample_rate_hz = rec.run.sample_rate_hz;
    run.error = std::sqrt(results[i].mean_square);
    run.measured = rec.measured;
    run.predicted = std::move(results[i].predicted);
    run.noise = rec.noise;
    for (long k = 0; k < rec.samples; ++k) {
      const ShaftInstant shaft = shaftAt(rec, out.model, k / rec.run.sample_rate_hz);
      run.angle_rad.push_back(shaft.angle);
      run.speed_rad_s.push_back(shaft.speed);
    }
    out.runs.push_back(std::move(run));
  }
  constexpr double no_motion = 1e149;  // the root of what stands for no finite prediction
  std::string diverging;
  for (const auto& run : out.runs)
    if (!(run.error < no_motion)) diverging += (diverging.empty() ? "" : ", ") + run.id;
  if (!diverging.empty())
    out.remarks.push_back(diverging + ": the model's motion grows beyond all numbers; its loop is not stable with these (amb modes)");
  for (const auto& remark : remarksOn(recordings)) out.remarks.push_back(remark);
  out.errors = breakDown(recordings, out.runs, everything);
  out.validation_errors = breakDown(recordings, out.runs, validate);
  return out;
}

Comparison compare(const Model& model, const Dataset& dataset, const CompareOptions& options) {
  std::unique_ptr<tbb::global_control> limit;
  if (options.threads > 0)
    limit = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism, options.threads);
  const auto progress = [&](double share, const char* what) {
    if (options.progress) options.progress(share, what);
  };
  progress(0.0, "reading");
  const std::vector<Recording> recordings = prepareRecordings(dataset);
  Model belief = trustedAs(model, dataset);
  if (!options.refit) {
    Model fixed = belief;
    for (auto it = fixed.uncertainty.begin(); it != fixed.uncertainty.end();)
      it = isMachineUncertainty(it->first) ? fixed.uncertainty.erase(it) : std::next(it);
    belief = fixed;
  }
  const auto offset = belief.uncertainty.find("sensor.offset_m");
  const FitSpace space(belief, {});
  const double offset_std_m = offset != belief.uncertainty.end() ? offset->second : 0.0;
  const FitProblem problem(recordings, space, offset_std_m);
  std::vector<LocalState> local(recordings.size());
  std::vector<int> fit_free, fit_all;
  for (int i = 0; i < static_cast<int>(recordings.size()); ++i) {
    if (recordings[i].run.use != RunUse::fit) continue;
    fit_all.push_back(i);
    if (!recordings[i].holdsContact()) fit_free.push_back(i);
  }
  FitResult fitted;
  fitted.x = space.start();
  fitted.covariance = Eigen::MatrixXd::Zero(space.size(), space.size());
  if (space.size() > 0 && !fit_all.empty()) {
    progress(0.1, "refitting the nuisance");
    FitOptions fit_options;
    fit_options.scores = true;
    fit_options.most_iterations = most_iterations_from_belief;
    if (!fit_free.empty()) fitted = fitFromBelief(problem, fit_free, local, fit_options);
    progress(0.4, "refitting through contact");
    if (fit_all.size() > fit_free.size()) fitted = fit(problem, fitted.x, fit_all, local, fit_options);
  }
  std::vector<std::string> remarks;
  if (options.refit && fit_all.empty())
    remarks.push_back("no run has use: fit: the model's numbers are taken as they are");
  if (fit_all.size() == recordings.size()) remarks.push_back("no run has use: validate: nothing is held out to judge by");
  progress(0.8, "predicting");
  Comparison out = sideBySide(recordings, space, offset_std_m, fitted, std::move(local));
  out.remarks.insert(out.remarks.begin(), remarks.begin(), remarks.end());
  progress(1.0, "done");
  return out;
}

}  // namespace amb_rotor
