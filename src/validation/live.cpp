#include "amb_rotor/validation/live.hpp"

#include <algorithm>
#include <cmath>

#include "amb_rotor/common/units.hpp"
#include "amb_rotor/validation/fit.hpp"
#include "amb_rotor/validation/stretches.hpp"

namespace amb_rotor {
namespace {

/// Share of the clearance from which on the rotor may touch: the sensors' offsets are not known well.
constexpr double touching = 0.9;
constexpr double standstill_hz = 0.5;
constexpr double speed_change_share = 0.01;  ///< over a block
constexpr double longest_block = 1.03, whole = 1e-6;

/// The shaft through the samples of a block, at constant speed beyond them.
class SampledShaft final : public ShaftPath {
 public:
  SampledShaft(const std::vector<LiveSample>& samples, double rate_hz) : rate_(rate_hz) {
    for (const auto& s : samples) instants_.push_back({s.angle_rad, s.speed_rad_s, 0.0});
    for (std::size_t i = 0; i + 1 < instants_.size(); ++i)
      instants_[i].acceleration = (instants_[i + 1].speed - instants_[i].speed) * rate_;
  }
  ShaftInstant at(double time) const override {
    const long last = static_cast<long>(instants_.size()) - 1;
    const long i = std::clamp(static_cast<long>(std::floor(time * rate_ + 1e-6)), 0L, last);
    const ShaftInstant& from = instants_[i];
    const double dt = time - i / rate_;
    const double acceleration = dt < 0.0 ? 0.0 : from.acceleration;
    return {from.angle + from.speed * dt + 0.5 * acceleration * dt * dt, from.speed + acceleration * dt, acceleration};
  }

 private:
  double rate_;
  std::vector<ShaftInstant> instants_;
};

Model withoutUncertainty(Model model) {
  model.uncertainty.clear();
  return model;
}

}  // namespace

LiveComparison::LiveComparison(const Model& model, const LiveOptions& options)
    : model_(withoutUncertainty(model)), options_(options) {
  const double sample_rate = model.amb_model == AmbModel::linear ? model.rig.controller.sample_rate_hz : 0.0;
  const long wished = std::lround(options.block_s * options.rate_hz);
  for (long n = std::max(wished, 16L); n <= longest_block * wished + 16; ++n) {
    const double samples = n / options.rate_hz * sample_rate;
    if (std::fabs(samples - std::round(samples)) > whole) continue;
    length_ = n;
    controller_samples_ = std::lround(samples);
    break;
  }
  if (length_ == 0)
    throw InputError({{"", 0, "block", std::to_string(options.block_s),
                       "no block of about this length is a whole number of samples of both recording and controller"}});
  samples_.reserve(length_);
}

bool LiveComparison::add(const LiveSample& sample) {
  double sum = sample.angle_rad + sample.speed_rad_s;
  for (int a = 0; a < 4; ++a) sum += sample.displacement_m[a] + sample.current_A[a] + sample.excitation_A[a];
  if (!std::isfinite(sum)) return false;  // lost: the next one shows a gap
  if (next_ >= 0 && sample.index != next_) {
    ++gaps_;
    samples_.clear();
    state_.mechanics.clear();
  }
  next_ = sample.index + 1;
  samples_.push_back(sample);
  if (static_cast<long>(samples_.size()) < length_) return false;
  judge();
  samples_.clear();
  return true;
}

Recording LiveComparison::recordingOfBlock() const {
  Recording rec;
  rec.run.id = "block";
  rec.run.kind = mayTouch() ? RunKind::rub : RunKind::steady;
  rec.run.sample_rate_hz = options_.rate_hz;
  rec.samples = length_;
  rec.excitation.rate_hz = options_.rate_hz;
  for (int c = 0; c < predicted_channels; ++c) rec.noise[c] = c < 4 ? options_.noise_m : options_.noise_A;
  if (model_.amb_model != AmbModel::linear) std::fill(rec.noise.begin() + 4, rec.noise.end(), 0.0);
  std::vector<FaultEvent> faults;
  bool on[4] = {true, true, true, true};
  for (long i = 0; i < length_; ++i) {
    const LiveSample& s = samples_[i];
    for (int a = 0; a < 4; ++a) {
      rec.measured.push_back(s.displacement_m[a]);
      rec.excitation.axis[a].push_back(s.excitation_A[a]);
      if (s.bearing_on[a] == on[a]) continue;
      on[a] = s.bearing_on[a];
      FaultEvent fault;
      fault.type = on[a] ? FaultType::amb_on : FaultType::amb_off;
      fault.start_s = i / options_.rate_hz;
      fault.end = a / 2;
      fault.axis = a % 2;
      faults.push_back(fault);
    }
    for (double current : s.current_A) rec.measured.push_back(current);
  }
  rec.schedule = Schedule({}, faults);
  rec.path = std::make_shared<SampledShaft>(samples_, options_.rate_hz);
  return rec;
}

bool LiveComparison::mayTouch() const {
  const double near = touching * model_.rig.auxiliary_bearing.clearance_m;
  for (const auto& s : samples_) {
    if (!std::all_of(s.bearing_on, s.bearing_on + 4, [](bool on) { return on; })) return true;
    for (double z : model_.rig.planes.aux)
      if (radiusAt(s.displacement_m, model_, z) > near) return true;
  }
  return false;
}

std::string LiveComparison::regimeOf() const {
  if (mayTouch()) {
    for (const auto& s : samples_)
      if (!std::all_of(s.bearing_on, s.bearing_on + 4, [](bool on) { return on; })) return "amb_off";
    return "contact";
  }
  for (const auto& s : samples_)
    if (std::any_of(s.excitation_A, s.excitation_A + 4, [](double i) { return i != 0.0; })) return "excited";
  const double from = samples_.front().speed_rad_s, to = samples_.back().speed_rad_s;
  if (std::max(std::fabs(from), std::fabs(to)) < radPerSecond(standstill_hz)) return "standstill";
  return std::fabs(to - from) > speed_change_share * std::fabs(from) ? "speed_change" : "steady";
}

void LiveComparison::predictFree(const Recording& rec) {
  block_.judged = !state_.mechanics.empty();
  if (!block_.judged) {
    block_.regime = "settling";
    state_ = stateFromMeasurement(rec, model_, Spin::prescribed, 0);
  }
  Stretch stretch = stretchOf(rec, model_);
  stretch.spin = Spin::prescribed;
  const MachineState<double> start = state_;
  std::vector<LaneJob> jobs(1);
  jobs[0].model = &model_;
  jobs[0].start = &start;
  block_.predicted.assign(length_ * predicted_channels, 0.0);
  jobs[0].out = block_.predicted.data();
  jobs[0].end = &state_;
  predict(stretch, jobs);
  if (!jobs[0].finite) {  // the model flies where the rig does not: it has been left, and begins anew
    block_.judged = true;
    block_.error = 1e6;
    state_.mechanics.clear();
    return;
  }
  // the next block counts its time from its own start
  state_.time -= length_ / options_.rate_hz;
  state_.next_record -= length_;
  state_.next_sample -= controller_samples_;
  for (auto& command : state_.pending) command.due -= length_ / options_.rate_hz;

  double sum = 0.0;
  int present = 0;
  for (int c = 0; c < predicted_channels; ++c) {
    if (rec.noise[c] <= 0.0) continue;
    double mean = 0.0, squares = 0.0;
    if (c < 4) {
      for (long i = 0; i < length_; ++i)
        mean += rec.measured[i * predicted_channels + c] - block_.predicted[i * predicted_channels + c];
      mean = std::clamp(mean / length_, -options_.offset_limit_m, options_.offset_limit_m);
      block_.offset_m[c] = mean;
    }
    for (long i = 0; i < length_; ++i) {
      double& value = block_.predicted[i * predicted_channels + c];
      value += mean;
      squares += std::pow((rec.measured[i * predicted_channels + c] - value) / rec.noise[c], 2);
    }
    block_.channel_error[c] = std::sqrt(squares / length_);
    sum += squares / length_;
    ++present;
  }
  block_.error = std::sqrt(sum / std::max(present, 1));
}

void LiveComparison::predictWindows(const Recording& rec) {
  const std::vector<Recording> one = {rec};
  const FitSpace space(model_, {});
  const FitProblem problem(one, space, options_.offset_limit_m / 3.0);
  std::vector<LocalState> local(1);
  EvaluationOptions evaluation;
  evaluation.jacobian = false;
  evaluation.keep_prediction = true;
  evaluation.window_passes = 3;
  evaluation.thorough = true;
  std::vector<RunResult> results;
  problem.evaluate(space.start(), {0}, local, evaluation, nullptr);  // finds the offsets
  problem.evaluate(space.start(), {0}, local, evaluation, &results);
  block_.judged = true;
  block_.error = results[0].finite ? std::sqrt(results[0].mean_square) : 1e6;
  block_.predicted = std::move(results[0].predicted);
  for (int c = 0; c < predicted_channels; ++c) {
    double squares = 0.0;
    for (long i = 0; i < length_ && rec.noise[c] > 0.0; ++i)
      squares += std::pow((rec.measured[i * predicted_channels + c] - block_.predicted[i * predicted_channels + c]) /
                              rec.noise[c],
                          2);
    block_.channel_error[c] = std::sqrt(squares / length_);
    if (c < 4) block_.offset_m[c] = local[0].offset_m[c];
  }
  state_.mechanics.clear();  // free again: a new start
}

void LiveComparison::judge() {
  block_ = LiveBlock();
  block_.first = samples_.front().index;
  block_.samples = length_;
  block_.regime = regimeOf();
  block_.speed_hz = 0.5 * (samples_.front().speed_rad_s + samples_.back().speed_rad_s) / two_pi;
  const Recording rec = recordingOfBlock();
  block_.measured = rec.measured;
  rec.holdsContact() ? predictWindows(rec) : predictFree(rec);
  count();
}

void LiveComparison::count() {
  if (block_.judged) {
    const bool contact = block_.regime == "contact" || block_.regime == "amb_off";
    const bool holds = block_.error <= (contact ? options_.limit_contact : options_.limit);
    against_ = holds == left_ ? against_ + 1 : 0;
    if (against_ >= options_.patience) {
      left_ = !left_;
      against_ = 0;
    }
  }
  block_.left = left_;
}

}  // namespace amb_rotor
