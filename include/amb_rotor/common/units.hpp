#pragma once
// Everything inside is SI (m, kg, s, rad, A, N, T); conversion happens at the borders, here and in its
// Python twin (python/amb_rotor/units.py).
#include <optional>
#include <string>

namespace amb_rotor {

constexpr double pi = 3.14159265358979323846;
constexpr double two_pi = 2.0 * pi;
constexpr double standard_gravity_m_s2 = 9.81;

inline constexpr double radPerSecond(double hertz) { return two_pi * hertz; }

/// Factor to SI of a unit as written behind a column's or key's name (ax_um -> 1e-6); empty: not known.
/// Frequencies and speeds: Hz and rpm become hertz. Angles: deg becomes rad.
std::optional<double> unitFactor(const std::string& unit);

}  // namespace amb_rotor
