#include "amb_rotor/machine/basic_record.hpp"

#include <algorithm>
#include <cmath>

#include "amb_rotor/common/units.hpp"

namespace amb_rotor {
namespace {

struct Radial {
  double radius, rate;
};

Radial radial(const BasicParameters<double>& p, const BasicState<double>& s) {
  const double u = s.x - p.misalignment_x, v = s.y - p.misalignment_y;
  const double radius = std::hypot(u, v);
  return {radius, radius > 0.0 ? (u * s.vx + v * s.vy) / radius : 0.0};
}

template <class Contact>
double normalForce(const BasicParameters<double>& p, const Radial& at) {
  const auto c = basicCoefficients<Contact>(p, 1.0);
  const double inverse = 1.0 / at.radius;
  const double rate = Contact::needs_rate ? at.rate : inverse;
  return at.radius * Contact::forceOverRadius(c, at.radius, inverse, rate);
}

/// Cubic Hermite polynomial of one coordinate over a step of length h at share s: value and slope.
struct Value {
  double at, slope;
};
Value hermite(double a, double b, double slope_a, double slope_b, double h, double s) {
  const double va = h * slope_a, vb = h * slope_b, d = b - a;
  const double two = 3.0 * d - 2.0 * va - vb, three = va + vb - 2.0 * d;
  return {a + s * (va + s * (two + s * three)), (va + s * (2.0 * two + s * 3.0 * three)) / h};
}

}  // namespace

double basicNormalForce(const BasicParameters<double>& p, const BasicState<double>& state,
                        BasicContact contact) {
  const Radial at = radial(p, state);
  if (!(at.radius > 1.0)) return 0.0;
  return contact == BasicContact::linear ? normalForce<LinearContact>(p, at)
                                         : normalForce<HertzContact>(p, at);
}

BasicRecord recordBasic(const BasicParameters<double>& p, const BasicState<double>& initial,
                        int turns_skipped, int turns_kept, int samples_per_turn,
                        const BasicOrbitOptions& options) {
  if (turns_skipped < 0 || turns_kept < 1 || samples_per_turn < 1) {
    throw InputError(
        {{"", 0, "turns", std::to_string(turns_kept), "at least one kept turn and one sample a turn"}});
  }
  BasicRecord record;
  BasicState<double> start = initial;
  if (turns_skipped > 0) {
    const BasicOrbit before = advanceBasic(p, initial, turns_skipped, options);
    record.finite = before.finite;
    start = before.end;
    if (!before.finite) return record;
  }
  const double spacing = two_pi / samples_per_turn, eta = p.frequency_ratio;
  const std::size_t samples =
      static_cast<std::size_t>(turns_kept) * static_cast<std::size_t>(samples_per_turn);
  bool begun = false;
  double last_phase = 0.0;
  BasicState<double> last = start;
  const auto observer = [&](double phase, const BasicState<double>& s, bool) {
    const double h = (phase - last_phase) / eta;  // dimensionless time
    while (begun && record.phase.size() < samples &&
           static_cast<double>(record.phase.size()) * spacing <= phase) {
      const double at = static_cast<double>(record.phase.size()) * spacing;
      const double share = phase > last_phase ? (at - last_phase) / (phase - last_phase) : 1.0;
      const Value x = hermite(last.x, s.x, last.vx, s.vx, h, share),
                  y = hermite(last.y, s.y, last.vy, s.vy, h, share);
      const BasicState<double> state{x.at, y.at, x.slope, y.slope};
      record.phase.push_back(at);
      record.state.push_back(state);
      record.normal_force.push_back(basicNormalForce(p, state, options.contact));
      record.depth_rate.push_back(radial(p, state).rate);
    }
    begun = true;
    last_phase = phase;
    last = s;
  };
  const BasicOrbit kept = advanceBasic(p, start, turns_kept, options, observer);
  record.finite = kept.finite;
  record.end = kept.end;
  record.contact_fraction = kept.contact_fraction;
  record.touch_downs = kept.touch_downs;
  return record;
}

}  // namespace amb_rotor
