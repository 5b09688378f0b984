#include "amb_rotor/ros/validator.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "amb_rotor/common/units.hpp"
#include "amb_rotor/ros/conversions.hpp"
#include "amb_rotor/ros/node_setup.hpp"

namespace amb_rotor {
namespace {

using visualization_msgs::Marker;

constexpr double validator_diagnostics_period_s = 0.5;  // of the wall
constexpr const char* channels[predicted_channels] = {"displacement ax", "displacement ay", "displacement bx",
                                                      "displacement by", "current ax",      "current ay",
                                                      "current bx",      "current by"};

Marker orbit(const RotorState& last, const std::string& name, int end, float red, float green, float blue) {
  Marker m;
  m.header.frame_id = stator_frame;
  m.header.stamp = last.header.stamp;
  m.ns = name;
  m.id = end;
  m.type = Marker::LINE_STRIP;
  m.action = Marker::ADD;
  m.pose.orientation.w = 1.0;
  m.scale.x = 0.001;
  m.color.r = red;
  m.color.g = green;
  m.color.b = blue;
  m.color.a = 1.0F;
  return m;
}

LiveOptions optionsOf(const ros::NodeHandle& own) {
  LiveOptions o;
  o.block_s = numberOr(own, "block", o.block_s);
  o.noise_m = numberOr(own, "displacement_noise", o.noise_m);
  o.noise_A = numberOr(own, "current_noise", o.noise_A);
  o.offset_limit_m = numberOr(own, "offset_limit", o.offset_limit_m);
  o.limit = numberOr(own, "limit", o.limit);
  o.limit_contact = numberOr(own, "limit_contact", o.limit_contact);
  o.patience = integerOr(own, "patience", o.patience);
  const std::pair<const char*, double> positive[] = {{"block", o.block_s},
                                                     {"displacement_noise", o.noise_m},
                                                     {"current_noise", o.noise_A},
                                                     {"offset_limit", o.offset_limit_m},
                                                     {"limit", o.limit},
                                                     {"limit_contact", o.limit_contact},
                                                     {"patience", double(o.patience)}};
  std::vector<Fault> faults;
  for (const auto& [name, value] : positive)
    if (!(value > 0.0)) faults.push_back({"", 0, own.resolveName(name), std::to_string(value), "must be above 0"});
  if (!faults.empty()) throw InputError(faults);
  return o;
}

}  // namespace

Validator::Validator(const ros::NodeHandle& nodes, const ros::NodeHandle& own)
    : nodes_(nodes),
      model_(modelOf(own)),
      hash_(hashNumber(model_)),
      options_(optionsOf(own)),
      with_injection_(switchOr(own, "injection", true)),
      clearance_shown_(numberOr(own, "clearance_shown", 0.05)),
      updater_(nodes_, own, own.getNamespace()) {
  const unsigned queue = static_cast<unsigned>(std::max(integerOr(own, "queue", 0), 0));
  updater_.setHardwareID(model_.name);
  updater_.add("model against rig", this, &Validator::diagnose);
  timer_ = nodes_.createWallTimer(ros::WallDuration(validator_diagnostics_period_s),
                                  [this](const ros::WallTimerEvent&) { updater_.force_update(); });
  marker_publisher_ = nodes_.advertise<visualization_msgs::MarkerArray>("validator/markers", 1, true);
  residual_publisher_ = nodes_.advertise<ModelResidual>("validator/residual", keep_all);
  if (with_injection_)
    injection_subscriber_ = nodes_.subscribe("injector/injection", queue, &Validator::takeInjection, this, noDelay());
  state_subscriber_ = nodes_.subscribe("rotor/state", queue, &Validator::takeState, this, noDelay());
}

void Validator::takeState(const RotorState::ConstPtr& state) {
  if (!with_injection_) {
    if (state->record >= 0) take(*state, nullptr);
    return;
  }
  if (live_ != nullptr && state->run != run_) {
    states_.clear();
    injections_.clear();
  }
  states_.emplace(state->step, state);  // a step published again is the same
  join();
}

void Validator::takeInjection(const Injection::ConstPtr& injection) {
  injections_.emplace(injection->step, injection);
  join();
}

/// Each step with its injection, in order. What lost its partner is left out: a gap.
void Validator::join() {
  while (!states_.empty() && !injections_.empty()) {
    const auto state = states_.begin();
    const auto injection = injections_.begin();
    if (injection->first < state->first) {
      injections_.erase(injection);
      continue;
    }
    if (injection->first == state->first && injection->second->run == state->second->run) {
      if (state->second->record >= 0) take(*state->second, injection->second.get());
      injections_.erase(injection);
    }
    states_.erase(state);
  }
}

void Validator::begin(const RotorState& state) {
  run_ = state.run;
  options_.rate_hz = state.record_rate;
  live_ = std::make_unique<LiveComparison>(model_, options_);
  regimes_.clear();
}

void Validator::take(const RotorState& state, const Injection* injection) {
  try {
    if (live_ == nullptr || state.run != run_) begin(state);
  } catch (const InputError& error) {
    ROS_ERROR_THROTTLE(5.0, "validator: %s", error.what());
    return;
  }
  LiveSample sample;
  sample.index = state.record;
  sample.angle_rad = state.shaft.angle;
  sample.speed_rad_s = state.shaft.speed;
  readAxes(state.sensor_signal, sample.displacement_m);
  readAxes(state.current, sample.current_A);
  if (injection != nullptr) {
    readAxes(injection->current, sample.excitation_A);
    std::copy(injection->bearing_on.begin(), injection->bearing_on.end(), sample.bearing_on);
  }
  if (live_->add(sample)) publish(state);
}

void Validator::publish(const RotorState& last) {
  const LiveBlock& block = live_->block();
  ModelResidual& out = residual_;
  out.header = last.header;
  out.header.frame_id = stator_frame;
  out.run = run_;
  out.model_hash = hash_;
  out.from_time = static_cast<double>(block.first) / options_.rate_hz;
  out.to_time = static_cast<double>(block.first + block.samples - 1) / options_.rate_hz;
  out.regime = block.regime;
  out.judged = block.judged;
  out.speed = block.speed_hz;
  out.error = block.error;
  std::copy(block.channel_error.begin(), block.channel_error.end(), out.channel_error.begin());
  out.offset = axisValues(block.offset_m.data());
  Sum& sum = regimes_[block.regime];
  if (block.judged) {
    sum.squares += block.error * block.error;
    ++sum.blocks;
  }
  out.blocks = sum.blocks;
  out.regime_error = sum.blocks > 0 ? std::sqrt(sum.squares / sum.blocks) : 0.0;
  const bool changed = out.left != block.left;
  out.left = block.left;
  out.gaps = static_cast<std::uint32_t>(live_->gaps());
  any_ = true;
  residual_publisher_.publish(out);
  draw(last);
  if (changed) updater_.force_update();
}

/// Both orbits of the block at the sensors, scaled as orbit_markers does.
void Validator::draw(const RotorState& last) {
  const LiveBlock& block = live_->block();
  const double scale = clearance_shown_ / model_.rig.auxiliary_bearing.clearance_m;
  visualization_msgs::MarkerArray out;
  for (int end = 0; end < 2; ++end) {
    Marker measured = orbit(last, "measured_orbit", end, 0.0F, 0.6F, 1.0F);
    Marker predicted = orbit(last, "predicted_orbit", end, 1.0F, 0.85F, 0.0F);
    for (long i = 0; i < block.samples; ++i) {
      const auto point = [&](const std::vector<double>& rows) {
        geometry_msgs::Point p;
        p.x = scale * rows[i * predicted_channels + 2 * end];
        p.y = scale * rows[i * predicted_channels + 2 * end + 1];
        p.z = model_.rig.planes.sensor[end];
        return p;
      };
      measured.points.push_back(point(block.measured));
      predicted.points.push_back(point(block.predicted));
    }
    out.markers.push_back(measured);
    out.markers.push_back(predicted);
  }
  Marker text = orbit(last, "validator_text", 0, block.left ? 1.0F : 0.9F, block.left ? 0.3F : 0.9F, block.left ? 0.0F : 0.9F);
  text.type = Marker::TEXT_VIEW_FACING;
  text.pose.position.y = -clearance_shown_ - 0.075;
  text.scale.x = 0.0;
  text.scale.z = 0.014;
  char words[160];
  std::snprintf(words, sizeof words, "measured blue, predicted yellow\n%s: residual %.2f of the noise%s",
                block.regime.c_str(), block.error, block.left ? "\nTHE MODEL HAS BEEN LEFT" : "");
  text.text = words;
  out.markers.push_back(text);
  marker_publisher_.publish(out);
}

void Validator::diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using Level = diagnostic_msgs::DiagnosticStatus;
  if (!any_) {
    status.summary(Level::OK, "no block of samples yet");
    return;
  }
  const ModelResidual& r = residual_;
  const auto worst = std::max_element(r.channel_error.begin(), r.channel_error.end()) - r.channel_error.begin();
  if (r.left)
    status.summaryf(Level::ERROR, "the model has been left: residual %.2f of the noise (%s, worst %s %.2f)", r.error,
                    r.regime.c_str(), channels[worst], r.channel_error[worst]);
  else if (!r.judged)
    status.summary(Level::OK, "settling");
  else
    status.summaryf(Level::OK, "the model holds: residual %.2f of the noise (%s)", r.error, r.regime.c_str());
  for (const auto& [regime, sum] : regimes_)
    if (sum.blocks > 0)
      status.addf("residual in " + regime, "%.3f over %u blocks", std::sqrt(sum.squares / sum.blocks), sum.blocks);
  status.addf("gaps", "%u", r.gaps);
  status.addf("time", "%.3f s", r.to_time);
}

}  // namespace amb_rotor
