// amb_rotor._core: data sets, comparison with a model, diagnosis.
#include "amb_rotor/validation/compare.hpp"
#include "amb_rotor/validation/dataset.hpp"
#include "amb_rotor/model/scenario_reader.hpp"
#include "amb_rotor/validation/diagnosis.hpp"
#include "amb_rotor/validation/experiments.hpp"
#include "amb_rotor/validation/modes_dataset.hpp"
#include "amb_rotor/validation/table.hpp"
#include "bind.hpp"

namespace py = pybind11;

namespace amb_rotor {
namespace {

/// Below 0 stands for: there is none.
py::object optionalError(double error) {
  if (error < 0.0) return py::none();
  return py::float_(error);
}

const char* useName(RunUse use) { return use == RunUse::fit ? "fit" : "validate"; }

py::dict parametersDict(const std::vector<FittedParameter>& parameters, bool with_unit) {
  py::dict all;
  for (const auto& p : parameters) {
    py::dict d;
    d["value"] = p.value;
    d["std"] = p.std;
    if (with_unit) d["unit"] = p.unit;
    all[py::str(p.name)] = d;
  }
  return all;
}

py::dict breakdownDict(const ErrorBreakdown& e) {
  py::dict d, by_harmonic;
  py::list by_speed;
  for (const auto& [order, error] : e.by_harmonic) by_harmonic[py::str(std::to_string(order))] = error;
  for (const auto& bin : e.by_speed) {
    py::dict row;
    row["speed_hz"] = bin.speed_hz;
    row["error"] = bin.error;
    by_speed.append(row);
  }
  d["error"] = optionalError(e.error);
  d["error_free"] = optionalError(e.error_free);
  d["error_contact"] = optionalError(e.error_contact);
  d["noise_floor"] = e.noise_floor;
  d["by_run"] = e.by_run;
  d["by_channel"] = e.by_channel;
  d["by_regime"] = e.by_regime;
  d["by_harmonic"] = by_harmonic;
  d["by_speed"] = by_speed;
  d["worst"] = e.worst;
  return d;
}

py::dict runDict(PredictedRun&& run) {
  py::dict d;
  const auto n = static_cast<py::ssize_t>(run.measured.size() / predicted_channels);
  d["id"] = run.id;
  d["use"] = run.use;
  d["kind"] = run.kind;
  d["sample_rate_hz"] = run.sample_rate_hz;
  d["error"] = run.error;
  d["noise"] = std::vector<double>(run.noise.begin(), run.noise.end());
  d["angle_rad"] = ownedArray(std::move(run.angle_rad));
  d["speed_rad_s"] = ownedArray(std::move(run.speed_rad_s));
  d["measured"] = ownedArray(std::move(run.measured), {n, predicted_channels});
  d["predicted"] = ownedArray(std::move(run.predicted), {n, predicted_channels});
  return d;
}

py::dict comparisonDict(Comparison&& c) {
  py::dict d;
  py::list runs;
  for (auto& run : c.runs) runs.append(runDict(std::move(run)));
  d["errors"] = breakdownDict(c.errors);
  d["validation_errors"] = breakdownDict(c.validation_errors);
  d["nuisance"] = parametersDict(c.nuisance, false);
  d["runs"] = runs;
  d["model"] = std::move(c.model);
  d["remarks"] = c.remarks;
  return d;
}

void putErrors(py::dict& d, const CandidateErrors& e, bool with_fit) {
  if (with_fit) d["fit_error"] = e.fit_error;
  d["validation_error"] = e.validation_error;
  d["validation_error_free"] = optionalError(e.validation_error_free);
  d["validation_error_contact"] = optionalError(e.validation_error_contact);
  d["offset_deviations"] = optionalError(e.offset_deviations);
}

py::dict candidateDict(const Candidate& c) {
  py::dict d;
  d["effect"] = c.effect;
  d["parameters"] = parametersDict(c.parameters, true);
  putErrors(d, c.errors, true);
  d["evidence"] = c.evidence;
  d["confounded_with"] = c.confounded_with;
  d["experiment"] = c.experiment;
  d["excited"] = c.excited;
  d["plausible"] = c.plausible;
  d["beside"] = c.beside;
  d["note"] = c.note;
  return d;
}

py::dict experimentDict(const Experiment& e, const Diagnosis& diagnosis) {
  py::dict d, overrides;
  d["effect"] = e.effect;
  d["against"] = e.against;
  d["name"] = e.name;
  d["what"] = e.what;
  d["separation"] = e.separation;
  d["evidence"] = e.evidence;
  d["scenario"] = scenarioText(e.scenario);
  for (const auto& name : {e.effect, e.against}) {
    const auto model = diagnosis.rivals.find(name);
    if (model != diagnosis.rivals.end()) overrides[py::str(name)] = experimentOverrides(e, model->second);
  }
  d["overrides"] = overrides;
  return d;
}

py::dict diagnosisDict(const Diagnosis& diagnosis) {
  py::dict d, baseline, unexplained;
  putErrors(baseline, diagnosis.baseline, true);
  baseline["nuisance"] = parametersDict(diagnosis.nuisance, false);
  py::list ranking, steps, terms, experiments;
  for (const auto& experiment : diagnosis.experiments) experiments.append(experimentDict(experiment, diagnosis));
  for (const auto& candidate : diagnosis.ranking) ranking.append(candidateDict(candidate));
  for (const auto& step : diagnosis.steps) {
    py::dict row;
    row["added"] = step.added;
    row["parameters"] = parametersDict(step.parameters, true);
    putErrors(row, step.errors, true);
    row["only_with_next"] = step.only_with_next;
    steps.append(row);
  }
  for (const auto& term : diagnosis.unexplained.terms) {
    py::dict row;
    row["term"] = term.term;
    row["coefficient"] = term.coefficient;
    row["std"] = term.std;
    terms.append(row);
  }
  unexplained["depends_on"] = diagnosis.unexplained.depends_on;
  unexplained["shape"] = diagnosis.unexplained.shape;
  unexplained["terms"] = terms;
  unexplained["frequency_hz"] = diagnosis.unexplained.frequency_hz > 0.0
                                    ? py::object(py::float_(diagnosis.unexplained.frequency_hz))
                                    : py::object(py::none());
  unexplained["held_out_gain"] = diagnosis.unexplained.held_out_gain;
  switch (diagnosis.unexplained.place) {
    case EffectLaw::Place::rotor:
      unexplained["place"] = "rotor";
      break;
    case EffectLaw::Place::tilt:
      unexplained["place"] = "tilt";
      break;
    case EffectLaw::Place::sensors:
      unexplained["place"] = "sensors";
      break;
    case EffectLaw::Place::magnetic_bearings:
      unexplained["place"] = "magnetic_bearings";
  }
  const bool signals = diagnosis.unexplained.place == EffectLaw::Place::sensors;
  unexplained["step_width_m"] = py::none();
  unexplained["step_width_A"] = py::none();
  if (diagnosis.unexplained.step_width > 0.0) unexplained[signals ? "step_width_m" : "step_width_A"] = diagnosis.unexplained.step_width;
  unexplained["plane_z_m"] = py::none();
  if (diagnosis.unexplained.plane_z_m) {
    py::dict plane;
    plane["value"] = *diagnosis.unexplained.plane_z_m;
    plane["std"] = diagnosis.unexplained.plane_std_m;
    unexplained["plane_z_m"] = plane;
  }
  d["format"] = "amb-diagnosis/1";
  d["verdict"] = diagnosis.verdict;
  d["noise_floor"] = diagnosis.noise_floor;
  d["baseline"] = baseline;
  d["ranking"] = ranking;
  d["steps"] = steps;
  d["experiments"] = experiments;
  d["unexplained"] = unexplained;
  d["withdrawn"] = diagnosis.withdrawn;
  d["sentences"] = diagnosis.sentences;
  d["remarks"] = diagnosis.remarks;
  d["seconds"] = diagnosis.seconds;
  d["time_limit_reached"] = diagnosis.time_limit_reached;
  return d;
}

py::list runList(const Dataset& dataset) {
  py::list runs;
  for (const auto& run : dataset.runs) {
    py::dict d;
    d["id"] = run.id;
    d["file"] = run.file;
    d["kind"] = runKindName(run.kind);
    d["use"] = useName(run.use);
    d["sample_rate_hz"] = run.sample_rate_hz;
    d["speed_hz"] = run.speed_from_tacho ? py::object(py::none()) : py::object(py::float_(run.speed_hz));
    d["holds_contact"] = run.holdsContact();
    runs.append(d);
  }
  return runs;
}

py::dict tableDict(const Dataset& dataset, const std::string& id) {
  const Run* run = dataset.findRun(id);
  if (run == nullptr)
    throw InputError({{datasetFile(dataset.folder), 0, "runs", id, "there is no such run"}});
  RunTable table = readRun(dataset, *run);
  static const char* axes[4] = {"ax", "ay", "bx", "by"};
  py::dict d;
  d["t_s"] = ownedArray(std::move(table.time_s));
  if (!table.tacho.empty()) d["tacho"] = ownedArray(std::move(table.tacho));
  for (int a = 0; a < 4; ++a) {
    const std::string axis = axes[a];
    if (!table.displacement_m[a].empty())
      d[py::str(axis + "_m")] = ownedArray(std::move(table.displacement_m[a]));
    if (!table.current_A[a].empty())
      d[py::str("i" + axis + "_A")] = ownedArray(std::move(table.current_A[a]));
    if (!table.excitation_A[a].empty())
      d[py::str("exc_" + axis + "_A")] = ownedArray(std::move(table.excitation_A[a]));
  }
  return d;
}

py::list pointList(const ModesDataset& dataset) {
  py::list points;
  for (const auto& point : dataset.points) {
    py::dict d;
    d["run"] = point.run;
    d["use"] = useName(point.use);
    d["condition"] = point.condition;
    d["speed_hz"] = point.speed_hz;
    d["frequency_hz"] = point.frequency_hz;
    d["std_hz"] = point.std_hz;
    points.append(d);
  }
  return points;
}

}  // namespace

void bindValidation(py::module_& m) {
  py::class_<Dataset>(m, "Dataset", "A measured data set, format amb-dataset/1.")
      .def_readonly("name", &Dataset::name)
      .def_readonly("folder", &Dataset::folder)
      .def_readonly("belief", &Dataset::belief)
      .def_property_readonly("runs", &runList)
      .def_property_readonly("lacking_uses", [](const Dataset& dataset) {
        std::vector<std::string> rules;
        for (const Fault& fault : lackingUses(dataset)) rules.push_back(fault.rule);
        return rules;
      }, "What a diagnosis lacks: runs to fit, or to validate.")
      .def("table", &tableDict, py::arg("run"), "Columns of a run in SI.");
  m.def("read_dataset", &readDataset, py::arg("folder"));
  m.def(
      "other_table_format", [](const std::string& text) { return otherTableFormat(text); }, py::arg("text"),
      "How a text is no table as a whole, and what to do; empty: nothing of the kind.");
  m.def("is_modes_dataset", &isModesDataset, py::arg("folder"));
  py::class_<ModesDataset>(m, "ModesDataset", "A data set of kind modes.")
      .def_readonly("name", &ModesDataset::name)
      .def_readonly("folder", &ModesDataset::folder)
      .def_readonly("belief", &ModesDataset::belief)
      .def_readonly("conditions", &ModesDataset::conditions)
      .def_readonly("mode_count", &ModesDataset::mode_count)
      .def_property_readonly("points", &pointList)
      .def("model_at", [](const ModesDataset& dataset, const Model& model, std::size_t point) {
        return modelAt(model, dataset, dataset.points.at(point));
      });
  m.def("read_modes_dataset", &readModesDataset, py::arg("folder"));

  m.def(
      "compare",
      [](const Model& model, const Dataset& dataset, bool refit, int threads, py::object progress) {
        requireModes(model);
        PythonProgress report(std::move(progress));
        CompareOptions options;
        options.refit = refit;
        options.threads = threads;
        options.progress = std::ref(report);
        Comparison comparison;
        {
          const py::gil_scoped_release release;
          comparison = compare(model, dataset, options);
        }
        return comparisonDict(std::move(comparison));
      },
      py::arg("model"), py::arg("dataset"), py::arg("refit") = true, py::arg("threads") = 0,
      py::arg("progress") = py::none());
  m.def(
      "diagnose",
      [](const Model& model, const Dataset& dataset, const std::vector<std::string>& candidates,
         int threads, int most_steps, double time_limit_s, py::object progress, std::optional<py::list> comparisons) {
        requireModes(model);
        PythonProgress report(std::move(progress));
        DiagnosisOptions options;
        options.comparisons = comparisons.has_value();
        options.candidates = candidates;
        options.threads = threads;
        options.most_steps = most_steps;
        options.time_limit_s = time_limit_s;
        options.progress = std::ref(report);
        Diagnosis diagnosis;
        {
          const py::gil_scoped_release release;
          diagnosis = diagnose(model, dataset, options);
        }
        for (auto* one : {&diagnosis.before, &diagnosis.after})
          if (one->has_value()) comparisons->append(comparisonDict(std::move(**one)));
        py::dict found = diagnosisDict(diagnosis);
        py::dict rivals;
        for (auto& [effect, model] : diagnosis.rivals) rivals[py::str(effect)] = std::move(model);
        return py::make_tuple(found, diagnosis.adopted, rivals);
      },
      py::arg("model"), py::arg("dataset"), py::arg("candidates") = std::vector<std::string>(),
      py::arg("threads") = 0, py::arg("most_steps") = 3, py::arg("time_limit_s") = 0.0,
      py::arg("progress") = py::none(), py::arg("comparisons") = py::none(),
      "The diagnosis as of amb-diagnosis/1, the model with all its steps, and the models of its experiments by effect. To the list "
      "`comparisons` are added, as compare() returns them, the belief beside all runs and, where it has steps and keeps the rules of "
      "models, the model with them.");
}

}  // namespace amb_rotor
