#include "amb_rotor/magnetic_bearing/equivalent_stiffness.hpp"

#include "amb_rotor/common/check.hpp"
#include "amb_rotor/common/units.hpp"

namespace amb_rotor {

using Complex = std::complex<double>;

Complex pathResponse(const ControlPath& path, double frequency_hz) {
  AMB_ROTOR_CHECK(frequency_hz > 0.0 && frequency_hz < 0.5 * path.sample_rate_hz,
                  "a frequency between 0 and half the sample rate");
  const double w = two_pi * frequency_hz, period = 1.0 / path.sample_rate_hz;
  const Complex jw(0.0, w), delayed = std::exp(-jw * period);
  Complex gain = path.controller(std::exp(jw * period));
  if (path.sensor) gain *= path.sensor(w);
  gain *= std::exp(-jw * path.delay_s) * (1.0 - delayed) / (jw * period);
  gain = (path.amplifier_rate * gain + jw * path.motional_gain) / (path.amplifier_rate + jw);
  if (path.relaxation_rates.empty()) return gain;
  Complex lag = 0.0;
  for (std::size_t k = 0; k < path.relaxation_rates.size(); ++k)
    lag += path.relaxation_weights[k] * path.relaxation_rates[k] / (path.relaxation_rates[k] + jw);
  return gain * lag;
}

EquivalentBearing equivalentBearing(Complex gain, double ki, double ks, double frequency_hz) {
  AMB_ROTOR_CHECK(frequency_hz > 0.0, "a frequency above 0");
  return {ki * gain.real() - ks, ki * gain.imag() / (two_pi * frequency_hz)};
}

double staticStiffness(double static_gain, double ki, double ks) { return ki * static_gain - ks; }

}  // namespace amb_rotor
