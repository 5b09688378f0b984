// The table of a run: columns by their channels, time checked.
#include <algorithm>
#include <cmath>
#include <filesystem>

#include "amb_rotor/common/units.hpp"
#include "amb_rotor/validation/dataset.hpp"
#include "amb_rotor/validation/table.hpp"

namespace amb_rotor {
namespace {

/// Printed times are rounded: a step may be off by this part of it.
constexpr double step_tolerance = 0.5;
/// The stated rate is a nominal one, a recorder's clock is good to far below this.
constexpr double rate_tolerance = 1e-3;

/// The position of t_s (or t_ms, t_us); -1 with a fault where there is none.
int findTime(const NumericTable& table, double& factor, FaultList& faults) {
  for (const char* unit : {"s", "ms", "us"}) {
    const int index = table.indexOf(std::string("t_") + unit);
    if (index < 0) continue;
    factor = *unitFactor(unit);
    return index;
  }
  faults.add(1, "t_s", "", "the column is missing");
  return -1;
}

void checkColumns(const NumericTable& table, const Dataset& dataset, int time, FaultList& faults) {
  std::vector<std::string> names;
  for (const Channel& channel : dataset.channels) {
    names.push_back(channel.name);
    if (table.indexOf(channel.name) < 0) faults.add(1, channel.name, "", "the column is missing");
  }
  for (std::size_t i = 0; i < table.columns.size(); ++i) {
    const std::string& name = table.columns[i];
    if (static_cast<int>(i) == time || std::find(names.begin(), names.end(), name) != names.end()) continue;
    const std::string unit = splitUnit(name).unit;
    const std::string nearest = names.empty() ? "" : "; nearest: " + nearestWord(name, names);
    if (!unit.empty() && !unitFactor(unit)) {
      faults.add(1, name, "", "the unit " + unit + " is not known, and no channel has this name" + nearest);
    } else {
      faults.add(1, name, "", "no channel of the data set has this name" + nearest);
    }
  }
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// The rate that the times show. Printed times are rounded, so it is taken over the whole run where the
/// steps are even; with gaps in it, from the usual step.
double shownRate(const std::vector<double>& steps, double span) {
  const double step = median(steps);
  const bool is_even = std::all_of(steps.begin(), steps.end(),
                                   [&](double s) { return std::fabs(s - step) <= step_tolerance * step; });
  return is_even ? static_cast<double>(steps.size()) / span : 1.0 / step;
}

void checkTime(const std::vector<double>& time_s, const Run& run, FaultList& faults) {
  if (time_s.empty()) return;  // reported by the table
  if (time_s.size() < 2) {
    faults.add(0, "t_s", "", "a run needs at least two rows");
    return;
  }
  std::vector<double> steps;
  for (std::size_t i = 1; i < time_s.size(); ++i) steps.push_back(time_s[i] - time_s[i - 1]);
  if (median(steps) > 0.0) {
    const double rate = shownRate(steps, time_s.back() - time_s.front());
    if (std::fabs(rate / run.sample_rate_hz - 1.0) > rate_tolerance) {
      faults.add(0, "t_s", numberText(rate) + " Hz",
                 "the times contradict sample_rate_hz, " + numberText(run.sample_rate_hz) + " Hz");
      return;
    }
  }
  if (std::all_of(steps.begin(), steps.end(), [](double step) { return step <= 0.0; })) {
    faults.add(0, "t_s", numberText(time_s.front()) + " to " + numberText(time_s.back()), "the time must rise; it nowhere does");
    return;
  }
  std::size_t bad = 0;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const double samples = steps[i] * run.sample_rate_hz;
    if (steps[i] > 0.0 && std::fabs(samples - 1.0) <= step_tolerance) continue;
    if (++bad > max_cell_faults) continue;
    const int line = NumericTable::lineOf(i + 1);
    const std::string value = numberText(time_s[i + 1]);
    if (steps[i] <= 0.0) {
      faults.add(line, "t_s", value, "the time must rise; the line before has " + numberText(time_s[i]));
    } else if (samples > 1.0) {
      faults.add(line, "t_s", value,
                 "a gap: " + numberText(std::round(samples) - 1.0) + " samples are missing before");
    } else {
      faults.add(line, "t_s", value, "comes sooner than the sample rate allows");
    }
  }
  if (bad > max_cell_faults)
    faults.add(0, "t_s", "", "and " + std::to_string(bad - max_cell_faults) + " more faults of the time");
}

std::vector<double>& columnOf(RunTable& run, const Channel& channel) {
  switch (channel.meaning) {
    case ChannelMeaning::displacement:
      return run.displacement_m[channel.index()];
    case ChannelMeaning::control_current:
      return run.current_A[channel.index()];
    case ChannelMeaning::excitation_current:
      return run.excitation_A[channel.index()];
    case ChannelMeaning::tacho:
      break;
  }
  return run.tacho;
}

void scale(std::vector<double>& values, double factor) {
  if (factor == 1.0) return;
  for (double& value : values) value *= factor;
}

}  // namespace

RunTable readRun(const Dataset& dataset, const Run& run) {
  FaultList faults((std::filesystem::path(dataset.folder) / run.file).string());
  NumericTable table = readTable(faults.file(), faults);
  if (table.columns.empty()) faults.throwIfAny();
  double time_factor = 1.0;
  const int time = findTime(table, time_factor, faults);
  checkColumns(table, dataset, time, faults);
  const bool is_readable = faults.empty();
  RunTable result;
  if (time >= 0) {
    result.time_s = std::move(table.values[static_cast<std::size_t>(time)]);
    scale(result.time_s, time_factor);
    // Cells that could not be read would show as faults of the time too.
    const auto& found = faults.faults();
    const bool is_whole =
        std::none_of(found.begin(), found.end(), [](const Fault& fault) { return fault.line > 1; });
    if (is_whole) checkTime(result.time_s, run, faults);
    if (is_readable && !run.events.empty() && run.events.back().time_s > result.time_s.back())
      faults.add(0, "events", numberText(run.events.back().time_s),
                 "an event comes after the end of the run, " + numberText(result.time_s.back()) + " s");
    if (is_readable && !run.events.empty() && run.events.front().time_s < result.time_s.front())
      faults.add(0, "events", numberText(run.events.front().time_s),
                 "an event comes before the run's first time, " + numberText(result.time_s.front()) + " s");
  }
  faults.throwIfAny();
  result.begins_s = result.time_s.front();
  for (double& t : result.time_s) t -= result.begins_s;
  for (const Channel& channel : dataset.channels) {
    auto& column = columnOf(result, channel);
    column = std::move(table.values[static_cast<std::size_t>(table.indexOf(channel.name))]);
    scale(column, channel.unit_factor);
  }
  return result;
}

}  // namespace amb_rotor
