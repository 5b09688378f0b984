#include "breakdown_words.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdio>
#include <map>

#include "amb_rotor/analysis/spectrum.hpp"
#include "amb_rotor/common/units.hpp"

namespace amb_rotor {
namespace {

constexpr const char* spoken_channels[predicted_channels] = {"ax",  "ay",  "bx",  "by",
                                                           "iax", "iay", "ibx", "iby"};
constexpr const char* pair_names[4] = {"displacement at end a", "displacement at end b",
                                       "control current at end a", "control current at end b"};
constexpr int spoken_harmonics = 4;
/// Turns over which a turning part's size and phase are taken as one.
constexpr double turns_in_block = 4.0;
/// Squares over the floor below which there is nothing to say, and shares from which on a part is worth a
/// sentence.
constexpr double least_excess = 0.1, least_share = 0.15;
/// A part belongs to a frequency where its middle half lies within this share of it.
constexpr double narrow = 0.15;
/// Residuals far from the centre count as larger from this ratio of mean squares on.
constexpr double position_ratio = 3.0;

std::string percent(double share) {
  return std::to_string(static_cast<int>(std::lround(100.0 * std::min(std::max(share, 0.0), 1.0)))) + " %";
}

std::string number(double value, int digits = 2) {
  char text[32];
  if (value >= 100.0)
    std::snprintf(text, sizeof text, "%.0f", value);
  else
    std::snprintf(text, sizeof text, "%.*g", digits, value);
  return text;
}

/// A value with its share of the error: what is weighed by shares.
struct Weighed {
  double value, weight;
};

double quantile(std::vector<Weighed> all, double share) {
  std::sort(all.begin(), all.end(), [](const Weighed& a, const Weighed& b) { return a.value < b.value; });
  double whole = 0.0, sum = 0.0;
  for (const auto& one : all) whole += one.weight;
  for (const auto& one : all)
    if ((sum += one.weight) >= share * whole) return one.value;
  return all.empty() ? 0.0 : all.back().value;
}

struct Block {
  double speed_hz, amplitude, energy;
};

/// Squares over the floor, all runs weighing alike, by what they belong to.
struct Cells {
  double excess = 0.0;
  std::map<std::string, double> run, regime;
  double channel[predicted_channels] = {};
  std::map<std::pair<int, int>, std::vector<Block>> turning;  ///< order (0: constant), pair
  double inside = 0.0, outside = 0.0, inside_count = 0.0, outside_count = 0.0;

  void add(const Recording& rec, const PredictedRun& run_here);
};

void Cells::add(const Recording& rec, const PredictedRun& here) {
  const long n = static_cast<long>(here.predicted.size()) / predicted_channels;
  int present = 0;
  for (const double noise : here.noise) present += noise > 0.0 ? 1 : 0;
  if (n == 0 || present == 0) return;
  const double weight = 1.0 / (static_cast<double>(n) * present);
  const Tags tags(rec, here);
  const auto value = [&](long i, int c) {
    const std::size_t at = i * predicted_channels + c;
    return here.noise[c] > 0.0 ? (here.measured[at] - here.predicted[at]) / here.noise[c] : 0.0;
  };
  double reach = 0.0;
  for (long i = 0; i < n; ++i)
    for (int end = 0; end < 2; ++end)
      reach = std::max(reach, std::hypot(here.measured[i * predicted_channels + 2 * end],
                                         here.measured[i * predicted_channels + 2 * end + 1]));
  const bool turns = !rec.standstill && !rec.holdsContact();
  std::complex<double> sums[4][2 * spoken_harmonics + 1] = {};
  double speeds = 0.0;
  long in_block = 0;
  const auto close = [&] {
    if (in_block < 8) return;
    for (int pair = 0; pair < 4; ++pair)
      for (int k = -spoken_harmonics; k <= spoken_harmonics; ++k) {
        const double size = std::abs(sums[pair][spoken_harmonics + k]) / static_cast<double>(in_block);
        // what taking it away removes, less what it would of plain noise
        const double energy = weight * (static_cast<double>(in_block) * size * size - 2.0);
        turning[{k, pair}].push_back({speeds / static_cast<double>(in_block) / two_pi, size, energy});
      }
  };
  double block_start = turns ? here.angle_rad[0] : 0.0;
  for (long i = 0; i < n; ++i) {
    double square = 0.0;
    for (int c = 0; c < predicted_channels; ++c) {
      const double v = value(i, c);
      if (here.noise[c] <= 0.0) continue;
      square += v * v;
      channel[c] += weight * (v * v - 1.0);
    }
    regime[tags.at(i)] += weight * (square - present);
    for (int end = 0; end < 2 && reach > 0.0 && !rec.holdsContact(); ++end) {
      const double* m = here.measured.data() + i * predicted_channels + 2 * end;
      const double share = std::hypot(m[0], m[1]) / reach;
      (share > 2.0 / 3.0 ? outside : inside) +=
          share > 2.0 / 3.0 || share < 1.0 / 3.0 ? square - present : 0.0;
      (share > 2.0 / 3.0 ? outside_count : inside_count) +=
          share > 2.0 / 3.0 || share < 1.0 / 3.0 ? present : 0.0;
    }
    if (!turns) continue;
    if (std::fabs(here.angle_rad[i] - block_start) >= turns_in_block * two_pi) {
      close();
      for (auto& pair : sums)
        for (auto& one : pair) one = 0.0;
      speeds = 0.0;
      in_block = 0;
      block_start = here.angle_rad[i];
    }
    const std::complex<double> turn = std::polar(1.0, -here.angle_rad[i]);
    std::complex<double> power[spoken_harmonics + 1] = {1.0};
    for (int k = 1; k <= spoken_harmonics; ++k) power[k] = power[k - 1] * turn;
    for (int pair = 0; pair < 4; ++pair) {
      const std::complex<double> z(value(i, 2 * pair), value(i, 2 * pair + 1));
      for (int k = -spoken_harmonics; k <= spoken_harmonics; ++k)
        sums[pair][spoken_harmonics + k] += z * (k >= 0 ? power[k] : std::conj(power[-k]));
    }
    speeds += std::fabs(here.speed_rad_s[i]);
    ++in_block;
  }
  const double over = here.error * here.error - 1.0;
  run[here.id] = std::max(over, 0.0);
  excess += std::max(over, 0.0);
}

const std::map<std::string, std::string>& regimeWords() {
  static const std::map<std::string, std::string> words = {
      {"standstill", "at standstill"},
      {"steady", "at constant speeds"},
      {"speed_change", "while the speed changes"},
      {"excited_standstill", "under excitation at standstill"},
      {"excited_turning", "under excitation of the turning rotor"},
      {"rub", "in runs with contact"},
      {"amb_off", "with the magnetic bearings off"}};
  return words;
}

std::string runsSentence(const Cells& cells, const ErrorBreakdown& errors) {
  const auto worst = std::max_element(cells.run.begin(), cells.run.end(),
                                      [](const auto& a, const auto& b) { return a.second < b.second; });
  std::string out = percent(worst->second / cells.excess) + " of the error above the floor is in run " +
                    worst->first + " (" + number(errors.by_run.at(worst->first)) + " times the noise)";
  const auto regime = std::max_element(cells.regime.begin(), cells.regime.end(),
                                       [](const auto& a, const auto& b) { return a.second < b.second; });
  if (cells.regime.size() > 1) {
    const auto words = regimeWords().find(regime->first);
    out += "; " + percent(regime->second / cells.excess) + " of it arises " +
           (words != regimeWords().end() ? words->second : "in the regime " + regime->first);
  }
  return out + ".";
}

/// Speeds of a turning part, and how it grows with them.
std::string speedWords(const std::vector<Block>& blocks, bool constant) {
  std::vector<Weighed> speeds;
  double least = 1e300, most = 0.0;
  for (const auto& b : blocks) {
    speeds.push_back({b.speed_hz, std::max(b.energy, 0.0)});
    least = std::min(least, b.speed_hz);
    most = std::max(most, b.speed_hz);
  }
  const double low = quantile(speeds, 0.25), middle = quantile(speeds, 0.5), high = quantile(speeds, 0.75);
  if (most < 1.2 * least) return ", at " + number(middle, 3) + " Hz";
  if (high - low < 2.0 * narrow * middle) return ", near " + number(middle, 3) + " Hz";
  std::string out = ", from " + number(low, 3) + " to " + number(high, 3) + " Hz";
  // the slope of the logarithms, by least squares: the power of the speed
  double s = 0.0, sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0, syy = 0.0;
  for (const auto& b : blocks) {
    if (b.amplitude <= 0.0 || b.speed_hz <= 0.0) continue;
    const double x = std::log(b.speed_hz), y = std::log(b.amplitude);
    s += 1.0;
    sx += x;
    sy += y;
    sxx += x * x;
    sxy += x * y;
    syy += y * y;
  }
  const double vx = sxx - sx * sx / std::max(s, 1.0), vy = syy - sy * sy / std::max(s, 1.0),
               cov = sxy - sx * sy / std::max(s, 1.0);
  if (constant || s < 4.0 || vx <= 0.0 || most < 1.5 * least) return out;
  const double slope = cov / vx, fit = vy > 0.0 ? cov * cov / (vx * vy) : 1.0;
  if (std::fabs(slope) < 0.4)
    out += ", not growing with the speed";
  else if (fit > 0.7 && slope > 0.0)
    out += ", growing with the speed to the power " + number(slope);
  return out;
}

std::string turningSentence(const Cells& cells) {
  if (cells.turning.empty()) return "";
  std::map<int, double> orders;
  std::map<std::pair<int, int>, double> parts;
  double all = 0.0;
  for (const auto& [cell, blocks] : cells.turning)
    for (const auto& b : blocks) {
      orders[cell.first] += b.energy;
      parts[cell] += b.energy;
    }
  for (const auto& [order, sum] : orders) all += std::max(sum, 0.0);
  const auto less = [](const auto& a, const auto& b) { return a.second < b.second; };
  const auto best = std::max_element(orders.begin(), orders.end(), less);
  if (best->second < least_share * cells.excess)
    return " Little of it is constant or turns with the shaft (" + percent(all / cells.excess) + ").";
  const int order = best->first;
  std::pair<int, int> which{order, 0};
  std::vector<Block> blocks;
  for (int pair = 0; pair < 4; ++pair) {
    if (parts[{order, pair}] > parts[which]) which.second = pair;
    const auto& own = cells.turning.at({order, pair});
    blocks.insert(blocks.end(), own.begin(), own.end());
  }
  const auto words = [](int k) {
    return k == 0 ? std::string("constant")
                  : std::to_string(std::abs(k)) + "X " + (k > 0 ? "forward" : "backward");
  };
  std::string out = " Of all of it, " + percent(best->second / cells.excess) + " is " + words(order) +
                    " in the turning runs" + speedWords(blocks, order == 0) + ", most in the " +
                    pair_names[which.second];
  orders.erase(best);
  const auto second = std::max_element(orders.begin(), orders.end(), less);
  if (second != orders.end() && second->second > least_share * cells.excess)
    out += "; " + percent(second->second / cells.excess) + " is " + words(second->first);
  return out + ".";
}

std::string channelSentence(const Cells& cells, const ErrorBreakdown& errors) {
  const int worst =
      static_cast<int>(std::max_element(cells.channel, cells.channel + predicted_channels) - cells.channel);
  double sum = 0.0;
  for (const double value : cells.channel) sum += std::max(value, 0.0);
  const auto error = errors.by_channel.find(spoken_channels[worst]);
  if (sum <= 0.0 || error == errors.by_channel.end()) return "";
  return " The worst channel is " + error->first + " (" + percent(cells.channel[worst] / sum) + " of it, " +
         number(error->second) + " times its noise).";
}

std::string positionSentence(const Cells& cells) {
  if (cells.inside_count < 1000.0 || cells.outside_count < 100.0) return "";
  const double inside = 1.0 + std::max(cells.inside / cells.inside_count, 0.0),
               outside = 1.0 + std::max(cells.outside / cells.outside_count, 0.0);
  if (outside < position_ratio * inside) return "";
  return " It is larger far from the centre: " + number(std::sqrt(outside)) +
         " times the noise in the outer third of the orbits, " + number(std::sqrt(inside)) + " in the inner.";
}

/// The frequencies of the worst channel's residual in the worst run without contact.
std::string frequencySentence(const std::vector<Recording>& recordings, const std::vector<PredictedRun>& runs,
                              const std::vector<int>& which) {
  double worst = 0.0;
  int run = -1, channel = 0;
  for (const int r : which) {
    if (recordings[r].holdsContact()) continue;
    const PredictedRun& here = runs[r];
    const long n = static_cast<long>(here.predicted.size()) / predicted_channels;
    for (int c = 0; c < predicted_channels; ++c) {
      if (here.noise[c] <= 0.0 || n < 64) continue;
      double sum = 0.0;
      for (long i = c; i < n * predicted_channels; i += predicted_channels)
        sum += std::pow((here.measured[i] - here.predicted[i]) / here.noise[c], 2);
      if (sum / n > worst) {
        worst = sum / n;
        run = r;
        channel = c;
      }
    }
  }
  if (run < 0 || worst < 2.0) return "";
  const PredictedRun& here = runs[run];
  std::vector<double> row;
  for (std::size_t i = channel; i < here.predicted.size(); i += predicted_channels)
    row.push_back(here.measured[i] - here.predicted[i]);
  const Spectrum spectrum = amplitudeSpectrum(row, here.sample_rate_hz);
  std::vector<Weighed> lines;
  double floor = 0.0;  // white noise is even over all lines
  for (const double a : spectrum.amplitude)
    floor += a * a / worst / static_cast<double>(spectrum.amplitude.size());
  for (std::size_t k = 1; k < spectrum.amplitude.size(); ++k)
    lines.push_back(
        {spectrum.frequency[k], std::max(spectrum.amplitude[k] * spectrum.amplitude[k] - 2.0 * floor, 0.0)});
  const double low = quantile(lines, 0.25), middle = quantile(lines, 0.5), high = quantile(lines, 0.75);
  if (middle <= 3.0 * spectrum.resolution)
    return " In run " + here.id + " the residual of " + spoken_channels[channel] +
           " is a slow or constant one.";
  std::string out = " In run " + here.id + " the residual of " + spoken_channels[channel] + " lies ";
  return out + (high - low < 2.0 * narrow * middle
                    ? "near " + number(middle, 3) + " Hz."
                    : "between " + number(low, 3) + " and " + number(high, 3) + " Hz for the most part.");
}

}  // namespace

std::string whereItFails(const std::vector<Recording>& recordings, const std::vector<PredictedRun>& runs,
                         const std::vector<int>& which, const ErrorBreakdown& errors) {
  if (std::max(errors.error * errors.error - 1.0, 0.0) < least_excess)
    return "The residual is at the noise floor in every cell (error " + number(errors.error, 3) +
           " of the noise).";
  Cells cells;
  for (const int r : which) cells.add(recordings[r], runs[r]);
  if (cells.excess <= 0.0) return "";
  return runsSentence(cells, errors) + turningSentence(cells) + channelSentence(cells, errors) +
         positionSentence(cells) + frequencySentence(recordings, runs, which);
}

}  // namespace amb_rotor
