#include "amb_rotor/validation/breakdown.hpp"

#include <algorithm>
#include <cmath>
#include <complex>

#include "amb_rotor/common/units.hpp"

namespace amb_rotor {
namespace {

constexpr const char* channel_names[predicted_channels] = {"ax", "ay", "bx", "by", "iax", "iay", "ibx", "iby"};
constexpr int most_harmonic = 4;
constexpr double speed_bin_hz = 10.0;

/// Sum of squares and how many went into it.
struct Mean {
  double sum = 0.0, count = 0.0;
  void add(double value) {
    sum += value;
    count += 1.0;
  }
  double root() const { return count > 0.0 ? std::sqrt(sum / count) : 0.0; }
};


class Tags {
 public:
  Tags(const Recording& rec, const PredictedRun& run) : rec_(rec), run_(run) {
    for (const auto& axis : rec.excitation.axis)
      for (double value : axis) excited_ = excited_ || value != 0.0;
    for (const auto& event : rec.run.events)
      if (!event.amb_on) off_from_ = std::min(off_from_, event.time_s);
  }
  std::string at(long i) const {
    const double time = i / run_.sample_rate_hz;
    if (time >= off_from_) return "amb_off";
    if (rec_.holdsContact()) return "rub";
    if (excited_) return rec_.standstill ? "excited_standstill" : "excited_turning";
    if (rec_.standstill) return "standstill";
    return rec_.path != nullptr ? "speed_change" : "steady";
  }

 private:
  const Recording& rec_;
  const PredictedRun& run_;
  bool excited_ = false;
  double off_from_ = 1e300;
};

std::string percent(double share) { return std::to_string(static_cast<int>(std::lround(100.0 * share))) + " %"; }

}  // namespace

ErrorBreakdown breakDown(const std::vector<Recording>& recordings, const std::vector<PredictedRun>& runs,
                         const std::vector<int>& which) {
  ErrorBreakdown out;
  Mean all, free, contact;
  std::map<std::string, Mean> channel, regime;
  std::map<int, Mean> harmonic;
  std::map<int, Mean> speed;
  std::map<std::pair<int, int>, double> harmonic_of_pair;
  for (int index : which) {
    const Recording& rec = recordings[index];
    const PredictedRun& run = runs[index];
    const double square = run.error * run.error;
    all.add(square);
    (rec.holdsContact() ? contact : free).add(square);
    out.by_run[run.id] = run.error;
    const Tags tags(rec, run);
    const long n = static_cast<long>(run.predicted.size()) / predicted_channels;
    std::complex<double> sums[4][2 * most_harmonic + 1] = {};
    for (long i = 0; i < n; ++i) {
      double value[predicted_channels];
      double mean = 0.0;
      int present = 0;
      for (int c = 0; c < predicted_channels; ++c) {
        value[c] = 0.0;
        if (run.noise[c] <= 0.0) continue;
        const std::size_t at = i * predicted_channels + c;
        value[c] = (run.measured[at] - run.predicted[at]) / run.noise[c];
        channel[channel_names[c]].add(value[c] * value[c]);
        mean += value[c] * value[c];
        ++present;
      }
      if (present == 0) continue;
      mean /= present;
      regime[tags.at(i)].add(mean);
      speed[static_cast<int>(std::floor(std::fabs(run.speed_rad_s[i]) / two_pi / speed_bin_hz))].add(mean);
      if (!rec.standstill && !rec.holdsContact()) {
        const std::complex<double> turn = std::polar(1.0, -run.angle_rad[i]);
        for (int pair = 0; pair < 4; ++pair) {
          const std::complex<double> z(value[2 * pair], value[2 * pair + 1]);
          std::complex<double> power = 1.0;
          sums[pair][most_harmonic] += z;
          for (int k = 1; k <= most_harmonic; ++k) {
            power *= turn;
            sums[pair][most_harmonic + k] += z * power;
            sums[pair][most_harmonic - k] += z * std::conj(power);
          }
        }
      }
    }
    if (!rec.standstill && !rec.holdsContact() && n > 0)
      for (int k = -most_harmonic; k <= most_harmonic; ++k) {
        if (k == 0) continue;
        for (int pair = 0; pair < 4; ++pair) {
          const double part = 0.5 * std::norm(sums[pair][most_harmonic + k] / static_cast<double>(n));
          harmonic[k].add(part);
          harmonic_of_pair[{k, pair}] += part;
        }
      }
  }
  out.error = all.root();
  if (free.count > 0.0) out.error_free = free.root();
  if (contact.count > 0.0) out.error_contact = contact.root();
  for (const auto& c : channel) out.by_channel[c.first] = c.second.root();
  for (const auto& r : regime) out.by_regime[r.first] = r.second.root();
  for (const auto& h : harmonic) out.by_harmonic[h.first] = h.second.root();
  for (const auto& s : speed) out.by_speed.push_back({(s.first + 0.5) * speed_bin_hz, s.second.root()});

  // the worst cell: which share of the error above the floor it carries
  const double excess = std::max(out.error * out.error - 1.0, 0.0);
  if (excess < 0.1) {
    out.worst = "The residual is at the noise floor in every cell (error " + std::to_string(out.error).substr(0, 5) +
                " of the noise).";
    return out;
  }
  const auto worst_run = std::max_element(out.by_run.begin(), out.by_run.end(),
                                          [](const auto& a, const auto& b) { return a.second < b.second; });
  double runs_excess = 0.0;
  for (const auto& r : out.by_run) runs_excess += std::max(r.second * r.second - 1.0, 0.0);
  const auto worst_channel = std::max_element(out.by_channel.begin(), out.by_channel.end(),
                                              [](const auto& a, const auto& b) { return a.second < b.second; });
  const auto worst_regime = std::max_element(out.by_regime.begin(), out.by_regime.end(),
                                             [](const auto& a, const auto& b) { return a.second < b.second; });
  out.worst = percent((worst_run->second * worst_run->second - 1.0) / std::max(runs_excess, 1e-9)) +
              " of the error above the floor is in run " + worst_run->first + "; the worst channel is " +
              worst_channel->first + " (" + std::to_string(worst_channel->second).substr(0, 4) +
              " of its noise), the worst regime " + worst_regime->first + " (" +
              std::to_string(worst_regime->second).substr(0, 4) + ").";
  if (!out.by_harmonic.empty()) {
    double best = 0.0;
    int order = 0, pair = 0;
    double total = 0.0;
    for (const auto& h : harmonic_of_pair) {
      total += h.second;
      if (h.second > best) {
        best = h.second;
        order = h.first.first;
        pair = h.first.second;
      }
    }
    if (order != 0 && total > 0.0)
      out.worst += " Of what turns with the shaft, " + percent(best / total) + " is " + std::to_string(std::abs(order)) +
                   "X " + (order > 0 ? "forward" : "backward") + " in the " +
                   (pair < 2 ? "displacement" : "current") + " at end " + (pair % 2 == 0 ? "a" : "b") + ".";
  }
  return out;
}

}  // namespace amb_rotor
