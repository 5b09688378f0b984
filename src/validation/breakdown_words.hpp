#pragma once
// Where a model fails, in sentences: runs, regimes, turning parts with their speeds, channels, places in the
// orbit, frequencies.
#include <string>
#include <vector>

#include "amb_rotor/validation/compare.hpp"

namespace amb_rotor {

/// What the rotor was doing at an instant of a recording.
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

/// @param errors  filled but for `worst`
std::string whereItFails(const std::vector<Recording>& recordings, const std::vector<PredictedRun>& runs,
                         const std::vector<int>& which, const ErrorBreakdown& errors);

}  // namespace amb_rotor
