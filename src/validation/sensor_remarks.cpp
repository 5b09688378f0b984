#include "amb_rotor/validation/sensor_remarks.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <complex>

#include "amb_rotor/common/units.hpp"
#include "number_text.hpp"

namespace amb_rotor {
namespace {

constexpr long least_samples = 200;
constexpr double resolved = 0.5;            // noise over resolution from which values seldom repeat
constexpr double stuck_share = 0.05;        // of a run
constexpr long least_clipped = 20;
constexpr double clipped_share = 0.5;
constexpr int blocks = 20;
constexpr double too_noisy = 2.0, too_quiet = 0.25;
constexpr double backward_over_forward = 3.0, least_over_noise = 3.0;
constexpr double least_turns = 4.0;

/// A value of a channel in the unit that people read.
std::string valueText(const Channel& channel, double value) {
  return channel.meaning == ChannelMeaning::displacement ? text("%.4g um", 1e6 * value) : text("%.4g A", value);
}

std::vector<double> column(const Recording& rec, int channel) {
  std::vector<double> out(static_cast<std::size_t>(rec.samples));
  for (long i = 0; i < rec.samples; ++i) out[i] = rec.measured[i * predicted_channels + channel];
  return out;
}

/// Scatter of the quietest part by fourth differences.
double scatterOf(const std::vector<double>& y) {
  double least = 1e300;
  const std::size_t n = y.size();
  for (int b = 0; b < blocks; ++b) {
    const std::size_t from = n * b / blocks, to = n * (b + 1) / blocks;
    double sum = 0.0, count = 0.0;
    for (std::size_t i = from; i + 4 < to; ++i, ++count) {
      const double d = y[i] - 4.0 * y[i + 1] + 6.0 * y[i + 2] - 4.0 * y[i + 3] + y[i + 4];
      sum += d * d;
    }
    if (count > 0.0) least = std::min(least, std::sqrt(sum / count / 70.0));
  }
  return least;
}

void repeatedValues(const Channel& channel, const std::vector<double>& y, double rate, std::vector<std::string>& remarks) {
  const auto extremes = std::minmax_element(y.begin(), y.end());
  const double low = *extremes.first, high = *extremes.second;
  std::size_t longest = 1, begin = 0, length = 1;
  for (std::size_t i = 1; i < y.size(); ++i) {
    length = y[i] == y[i - 1] ? length + 1 : 1;
    if (length > longest) longest = length, begin = i + 1 - length;
  }
  const bool is_limit = y[begin] == low || y[begin] == high;
  if (static_cast<double>(longest) > stuck_share * y.size() && !is_limit) {
    remarks.push_back(channel.name + " stays at " + valueText(channel, y[begin]) + " from " + text("%.3g", begin / rate) +
                      " s on, for " + text("%.3g", longest / rate) + " s: it is stuck there");
    return;
  }
  for (const double limit : {low, high}) {
    const auto at = std::count(y.begin(), y.end(), limit);
    const auto near = std::count_if(y.begin(), y.end(), [&](double v) { return std::fabs(v - limit) < channel.noise(); });
    if (at >= least_clipped && at > clipped_share * near) {
      remarks.push_back(channel.name + " is cut off at " + valueText(channel, limit) + " (" + std::to_string(at) +
                        " samples): the sensor or its converter is at its end");
      return;
    }
  }
}

/// "ax_um, ay_um and bx_um".
std::string listed(const std::vector<std::string>& names) {
  std::string out = names[0];
  for (std::size_t i = 1; i < names.size(); ++i) out += (i + 1 < names.size() ? ", " : " and ") + names[i];
  return out;
}

std::string wordsOnly(const std::string& remark) {
  std::string out;
  for (const char c : remark)
    if (!std::isdigit(static_cast<unsigned char>(c)) && c != '.' && c != '-' && c != '+') out += c;
  return out;
}

}  // namespace

std::vector<std::string> sensorRemarks(const Recording& rec, const Dataset& dataset) {
  std::vector<std::string> remarks;
  if (rec.samples < least_samples) {
    remarks.push_back("only " + std::to_string(rec.samples) + " samples: too short to tell anything");
    return remarks;
  }
  std::vector<std::string> dead, scattering[2];  // less than stated, more
  double dead_value = 0.0, share_of[2] = {};
  const double gap = dataset.belief.amb_model == AmbModel::linear ? dataset.belief.rig.amb.air_gap_m : 1e300;
  for (int c = 0; c < predicted_channels; ++c) {
    if (rec.noise[c] <= 0.0) continue;
    const bool displacement = c < axis_count;
    const Channel& channel =
        *dataset.findChannel(displacement ? ChannelMeaning::displacement : ChannelMeaning::control_current, c % axis_count);
    const std::vector<double> y = column(rec, c);
    const auto worst = std::max_element(y.begin(), y.end(), [](double a, double b) { return std::fabs(a) < std::fabs(b); });
    if (displacement && !rec.holdsContact() && std::fabs(*worst) > gap)
      remarks.push_back(channel.name + " reads " + valueText(channel, *worst) + " at " +
                        text("%.4g", (worst - y.begin()) / rec.run.sample_rate_hz) + " s, beyond the air gap of " +
                        text("%.4g um", 1e6 * gap) + ": a spike, or another unit");
    if (channel.noise_rms < resolved * channel.resolution) continue;  // values repeat for their rounding
    if (*std::min_element(y.begin(), y.end()) == *std::max_element(y.begin(), y.end())) {
      if (dead.empty()) dead_value = y[0] / channel.unit_factor;
      dead.push_back(channel.name);
      continue;
    }
    const std::size_t before = remarks.size();
    repeatedValues(channel, y, rec.run.sample_rate_hz, remarks);
    if (remarks.size() > before || !displacement || rec.holdsContact()) continue;
    const double share = scatterOf(y) / channel.noise();
    if (share <= too_noisy && share >= too_quiet) continue;
    const int more = share > too_noisy ? 1 : 0;
    if (scattering[more].empty()) share_of[more] = share;
    scattering[more].push_back(channel.name);
  }
  if (!dead.empty())
    remarks.push_back("one value throughout (" + text("%.4g", dead_value) + ") in " + listed(dead) +
                      ": a sensor or its wire is dead; leave such channels out");
  for (const int more : {0, 1})
    if (!scattering[more].empty())
      remarks.push_back("the scatter is " + text("%.2g", share_of[more]) + " of the stated noise in " + listed(scattering[more]) +
                        ": errors over the noise are off by as much");
  return remarks;
}

std::vector<std::string> turningRemarks(const Recording& rec) {
  std::vector<std::string> remarks;
  if (rec.standstill && rec.pulses.state == TachoState::turning && rec.pulses.time.size() > 2) {
    const double turns = static_cast<double>(rec.pulses.turn.back() - rec.pulses.turn.front());
    remarks.push_back("stated as standing still, but the tacho shows " +
                      text("%.4g Hz", turns / (rec.pulses.time.back() - rec.pulses.time.front())));
  }
  if (rec.standstill || rec.holdsContact() || rec.pulses.state != TachoState::turning) return remarks;
  for (int a = 0; a < axis_count; ++a)
    if (rec.noise[a] <= 0.0) return remarks;
  const ShaftAngle shaft(rec.pulses);
  const long from = static_cast<long>(std::ceil(rec.pulses.time.front() * rec.run.sample_rate_hz));
  const long to = std::min(rec.samples, static_cast<long>(rec.pulses.time.back() * rec.run.sample_rate_hz));
  if (static_cast<double>(rec.pulses.turn.back() - rec.pulses.turn.front()) < least_turns) return remarks;
  double least = 1e300;
  for (int end = 0; end < 2; ++end) {
    std::complex<double> forward = 0.0, backward = 0.0;
    for (long i = from; i < to; ++i) {
      const std::complex<double> z(rec.measured[i * predicted_channels + 2 * end], rec.measured[i * predicted_channels + 2 * end + 1]);
      const std::complex<double> turn = std::polar(1.0, -shaft.angle(i / rec.run.sample_rate_hz));
      forward += z * turn;
      backward += z * std::conj(turn);
    }
    if (std::abs(backward) < least_over_noise * rec.noise[2 * end] * static_cast<double>(to - from)) return remarks;
    least = std::min(least, std::abs(backward) / std::max(std::abs(forward), 1e-300));
  }
  if (least > backward_over_forward)
    remarks.push_back("the first harmonic whirls backward at both ends, " + text("%.2g", least) +
                      " times the forward one: x and y are swapped, one of them is mirrored, or the spin is negative");
  return remarks;
}

std::vector<std::string> remarksOn(const std::vector<Recording>& recordings) {
  struct Group {
    std::string words, first;
    std::vector<std::string> runs;
  };
  std::vector<Group> groups;
  for (const Recording& rec : recordings)
    for (const std::string& remark : rec.remarks) {
      const std::string words = wordsOnly(remark);
      auto found = std::find_if(groups.begin(), groups.end(), [&](const Group& g) { return g.words == words; });
      if (found == groups.end()) found = groups.insert(groups.end(), {words, remark, {}});
      if (found->runs.empty() || found->runs.back() != rec.run.id) found->runs.push_back(rec.run.id);
    }
  std::vector<std::string> out;
  for (const Group& group : groups) {
    std::string where = group.runs[0];
    if (group.runs.size() > 1) {
      where += " and " + std::to_string(group.runs.size() - 1) + " more (";
      for (std::size_t i = 1; i < group.runs.size(); ++i) where += (i > 1 ? ", " : "") + group.runs[i];
      where += ")";
    }
    out.push_back(where + ": " + group.first);
  }
  return out;
}

}  // namespace amb_rotor
