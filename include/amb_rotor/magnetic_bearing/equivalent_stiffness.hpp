#pragma once
// Equivalent stiffness k1 and damping d1 of one bearing axis at a frequency, from the frequency response of everything
// between the rotor's position and the current that makes the force (thesis 3.22 to 3.30).
//
//   i = -G x (3.22),  F = Ki i + Ks x = -(k1 + j w d1) x  ->  k1(w) = Re(Ki G) - Ks,  d1(w) = Im(Ki G)/w    (3.26)
//   G(w) = H(w) C(exp(j w T)) exp(-j w t_d) (1 - exp(-j w T))/(j w T) A(w) E(w)                              (3.23)
// H    sensor, and what filters its signal before the sample     C  the sampled controller, command = -C signal
// t_d  delay [s]     (1 - exp(-j w T))/(j w T)  command held over the period T [s]
// A    = a/(a + j w), amplifier; with coils the rotor's motion adds j w g/(a + j w), g = Ki/(2 L) [A/m]
// E = sum of w_k r_k/(r_k + j w), lags between current and force
//
// Valid: 0 < w < pi/T. It is the response of the fundamental: the images of the held command at w + 2 pi n/T move a
// rotor by less than (w T/2 pi)^2 of it. At w = 0 the gain is C(1), infinite with an integrator (3.27, 3.28).
// Sign: the thesis prints m s^2 - Ks - Ki G in 3.24 and 3.25; with its own 3.22 the last sign is +, as 3.26 has it.
// Source: thesis 3.22 to 3.30; delay, hold and lags derived in doc/physics.md section 2.
// Left out: current, voltage and converter limits; sensor and magnet in different planes.
#include <complex>
#include <functional>
#include <vector>

namespace amb_rotor {

/// From a sensor's signal to the current that makes the force.
struct ControlPath {
  double sample_rate_hz = 0.0;
  double delay_s = 0.0;
  double amplifier_rate = 0.0;  ///< a [1/s]
  double motional_gain = 0.0;   ///< g [A/m]; 0 without coils
  std::vector<double> relaxation_weights, relaxation_rates;  ///< empty: no lag behind the current
  std::function<std::complex<double>(std::complex<double> z)> controller;  ///< C(z) [A/m]
  std::function<std::complex<double>(double w)> sensor;  ///< H(w); not set: 1
};

/// G at a frequency [A/m].
std::complex<double> pathResponse(const ControlPath& path, double frequency_hz);

struct EquivalentBearing {
  double stiffness_N_per_m = 0.0;
  double damping_N_s_per_m = 0.0;
};

/// k1 and d1 from G [A/m] at a frequency above 0; ki [N/A], ks [N/m].
EquivalentBearing equivalentBearing(std::complex<double> gain, double ki, double ks, double frequency_hz);

/// k1 at rest from the static gain of the path [A/m] (3.28).
double staticStiffness(double static_gain, double ki, double ks);

}  // namespace amb_rotor
