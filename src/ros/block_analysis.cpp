#include "amb_rotor/ros/block_analysis.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "amb_rotor/analysis/contact.hpp"
#include "amb_rotor/analysis/harmonics.hpp"
#include "amb_rotor/analysis/orbit.hpp"
#include "amb_rotor/analysis/regime.hpp"
#include "amb_rotor/analysis/spectrum.hpp"
#include "amb_rotor/analysis/whirl.hpp"
#include "amb_rotor/common/units.hpp"
#include "amb_rotor/ros/conversions.hpp"

namespace amb_rotor {
namespace {

/// Fewer samples than this make no block.
constexpr std::size_t least_samples = 16;
/// Orders are multiples of 1/2.
constexpr int order_subdivision = 2;
/// Nearer to the centre than this share of the clearance the rotor has no direction.
constexpr double least_radius_share = 1e-4;

static_assert(OrbitAnalysis::UNDECIDED == static_cast<int>(Regime::undecided), "order of regimes");
static_assert(OrbitAnalysis::WHIRL_PLANAR == static_cast<int>(WhirlDirection::planar), "order of directions");

double mean(const std::vector<double>& values) {
  return values.empty()
             ? 0.0
             : std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

OrderAmplitude orderMessage(const OrderComponent& component) {
  OrderAmplitude message;
  message.order = component.order;
  message.forward = std::abs(component.forward);
  message.forward_phase = std::arg(component.forward);
  message.backward = std::abs(component.backward);
  message.backward_phase = std::arg(component.backward);
  message.x_amplitude = std::abs(component.x);
  message.x_phase = std::arg(component.x);
  message.y_amplitude = std::abs(component.y);
  message.y_phase = std::arg(component.y);
  return message;
}

}  // namespace

BlockAnalysis::BlockAnalysis(int end, const ModelInfo& info, const BlockOptions& options)
    : end_(end), info_(info), options_(options) {}

void BlockAnalysis::add(const RotorState& state, const ContactForces& contact, Output& out) {
  const EndContact& bearing = contact.ends[end_];
  const int axis = 2 * end_;
  MotionSample sample;
  sample.time = state.time;
  sample.angle = state.shaft.angle;
  sample.x = axisOf(state.aux_position, axis) - bearing.centre_x;
  sample.y = axisOf(state.aux_position, axis + 1) - bearing.centre_y;
  sample.vx = axisOf(state.aux_velocity, axis) - bearing.centre_velocity_x;
  sample.vy = axisOf(state.aux_velocity, axis + 1) - bearing.centre_velocity_y;
  header_ = state.header;
  header_.frame_id = end_ == 0 ? "aux_a" : "aux_b";
  for (const PoincarePoint& point : section_.add(sample)) {
    points_.push_back(point);
    if (static_cast<int>(points_.size()) > options_.points) points_.pop_front();
    SectionPoint message;
    message.header = header_;
    message.run = state.run;
    message.end = static_cast<std::uint8_t>(end_);
    message.turn = point.index;
    message.time = point.time;
    message.x = point.x;
    message.y = point.y;
    message.velocity_x = point.vx;
    message.velocity_y = point.vy;
    message.in_contact = in_contact_;
    out.points.push_back(message);
  }
  in_contact_ = bearing.normal_force > 0.0;
  time_.push_back(sample.time);
  angle_.push_back(sample.angle);
  x_.push_back(sample.x);
  y_.push_back(sample.y);
  force_.push_back(bearing.normal_force);
  centre_x_.push_back(bearing.centre_x);
  centre_y_.push_back(bearing.centre_y);
  const double from_turn = std::ceil(angle_.front() / two_pi - 1e-9);
  const bool turned = angle_.back() / two_pi >= from_turn + options_.turns;
  if (turned || time_.back() - time_.front() >= options_.longest) close(false, out);
}

void BlockAnalysis::finish(Output& out) { close(true, out); }

void BlockAnalysis::close(bool last, Output& out) {
  if (time_.size() >= least_samples) {
    OrbitAnalysis result;
    result.header = header_;
    result.run = info_.run;
    result.block = block_;
    result.end = static_cast<std::uint8_t>(end_);
    result.last = last;
    result.from_time = time_.front();
    result.to_time = time_.back();
    result.turns = (angle_.back() - angle_.front()) / two_pi;
    result.speed = (angle_.back() - angle_.front()) / (time_.back() - time_.front());

    const OrbitStatistics orbit = orbitStatistics(x_, y_, info_.clearance);
    result.mean_x = orbit.mean_x + mean(centre_x_);
    result.mean_y = orbit.mean_y + mean(centre_y_);
    result.max_radius = orbit.max_radius;
    result.mean_radius = orbit.mean_radius;
    result.max_radius_over_clearance = orbit.max_radius_over_clearance;

    OrderOptions order_options;
    order_options.max_order = options_.max_order;
    order_options.subdivision = result.turns >= 2.0 * order_subdivision ? order_subdivision : 1;
    if (result.turns >= 2.0) {
      const OrderAnalysis orders = orderAnalysis(angle_, x_, y_, order_options);
      if (orders.valid)
        for (const auto& component : orders.components) result.orders.push_back(orderMessage(component));
    }
    const Spectrum spectrum = fullSpectrum(x_, y_, info_.record_rate);
    FullSpectrum message;
    message.header = header_;
    message.run = info_.run;
    message.block = block_;
    message.end = result.end;
    message.frequency = spectrum.frequency;
    message.amplitude = spectrum.amplitude;
    out.spectra.push_back(message);
    const SpectralWhirl peak = whirlFromSpectrum(spectrum);
    result.spectral_peak_frequency = peak.frequency / two_pi;
    result.spectral_peak_amplitude = peak.amplitude;
    decide(x_, y_, result);
    out.blocks.push_back(result);
    ++block_;
  }
  for (auto* values : {&time_, &angle_, &x_, &y_, &force_, &centre_x_, &centre_y_}) values->clear();
}

void BlockAnalysis::decide(const std::vector<double>& x, const std::vector<double>& y,
                           OrbitAnalysis& result) const {
  RegimeInput input;
  input.points.assign(points_.begin(), points_.end());
  input.clearance = info_.clearance;
  input.max_radius = result.max_radius;
  input.spin = result.speed;
  input.rotor_radius = info_.rotor_radius;
  input.contact = contactStatistics(time_, force_, x, y);
  input.whirl = whirlFromOrbit(time_, x, y, 0.0, 0.0, least_radius_share * info_.clearance);
  const RegimeResult regime = decideRegime(input, options_.tolerance);

  result.whirl = static_cast<std::uint8_t>(input.whirl.direction);
  result.whirl_frequency = input.whirl.frequency;
  result.forward_share = input.whirl.forward_share;
  result.contact_fraction = input.contact.contact_fraction;
  result.impacts = input.contact.impacts;
  result.max_force = input.contact.max_force;
  result.rms_force = input.contact.rms_force;
  result.mean_direction = input.contact.mean_direction;
  result.rub_arc = input.contact.rub_arc;
  result.regime = static_cast<std::uint8_t>(regime.regime);
  result.period = regime.period;
  result.certain = regime.certain;
  result.reason = regime.reason;
}

}  // namespace amb_rotor
