#include "amb_rotor/validation/breakdown.hpp"

#include <algorithm>
#include <cmath>
#include <complex>

#include "amb_rotor/common/units.hpp"
#include "breakdown_words.hpp"

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

}  // namespace

ErrorBreakdown breakDown(const std::vector<Recording>& recordings, const std::vector<PredictedRun>& runs,
                         const std::vector<int>& which) {
  ErrorBreakdown out;
  Mean all, free, contact;
  std::map<std::string, Mean> channel, regime;
  std::map<int, Mean> harmonic;
  std::map<int, Mean> speed;
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
        }
      }
  }
  out.error = all.count > 0.0 ? all.root() : -1.0;
  if (free.count > 0.0) out.error_free = free.root();
  if (contact.count > 0.0) out.error_contact = contact.root();
  for (const auto& c : channel) out.by_channel[c.first] = c.second.root();
  for (const auto& r : regime) out.by_regime[r.first] = r.second.root();
  for (const auto& h : harmonic) out.by_harmonic[h.first] = h.second.root();
  for (const auto& s : speed) out.by_speed.push_back({(s.first + 0.5) * speed_bin_hz, s.second.root()});

  out.worst = whereItFails(recordings, runs, which, out);
  return out;
}

}  // namespace amb_rotor
