"""A new effect from the law that a diagnosis proposes: as a file of format amb-effect/1, and as C++.

Each term of the law (the hypothesis effect `force_law`) is known here as a force, in the formulas of effect files and in
C++. p = (x, y) is the rotor's displacement at a magnetic bearing, v its velocity, i the current, t the shaft's angle.
"""
from __future__ import annotations

import dataclasses

# Below this speed v/|v| is rounded off [m/s], as in force_law.
_ROUNDED = "1e3"


@dataclasses.dataclass(frozen=True)
class Term:
    """One term of a law: its name and unit, what it is, and its force per unit of the coefficient."""
    name: str
    unit: str
    meaning: str
    excited_by: str
    x: str
    y: str
    cpp_x: str
    cpp_y: str
    role: str = "plain"


def _along(name, unit, meaning, excited_by, factor, cpp_factor, vector=("x", "y"), cpp="p"):
    """A term along a vector: factor times it."""
    times, cpp_times = (f" * {factor}" if factor else ""), (f"{cpp_factor} * " if cpp_factor else "")
    return Term(name, unit, meaning, excited_by, f"{vector[0]}{times}", f"{vector[1]}{times}",
                f"{cpp_times}{cpp}.x", f"{cpp_times}{cpp}.y")


_MOTION = "large and small amplitudes: steps, chirps, rotation near a critical speed"
_VELOCITY = ("vx", "vy")
_SPEED = "runs at two or more speeds"

TERMS = {term.name: term for term in (
    _along("position_N_per_m", "N/m", "stiffness: p", "any motion", "", ""),
    _along("position_square_N_per_m2", "N/m2", "|p| p", _MOTION, "radius", "radius"),
    _along("position_cube_N_per_m3", "N/m3", "|p|^2 p", _MOTION, "radius^2", "radius * radius"),
    _along("velocity_N_s_per_m", "N s/m", "damping: v", "any motion", "", "", _VELOCITY, "v"),
    _along("velocity_square_N_s2_per_m2", "N s2/m2", "|v| v", _MOTION, "rate", "rate", _VELOCITY, "v"),
    _along("velocity_sign_N", "N", "v/|v|, rounded off below 1 mm/s", _MOTION, f"tanh({_ROUNDED} * rate) / rate",
           f"hyperbolicTangent(S({_ROUNDED}) * rate) / rate", _VELOCITY, "v"),
    Term("cross_N_per_m", "N/m", "(-y, x)", "excitation in one direction", "-y", "x", "-p.y", "p.x"),
    Term("cross_speed_N_s_per_m", "N s/m", "speed (-y, x)", _SPEED, "-y * speed", "x * speed", "-shaft.speed * p.y",
         "shaft.speed * p.x"),
    _along("position_speed_N_s2_per_m", "N s2/m", "speed^2 p", _SPEED, "speed^2", "shaft.speed * shaft.speed"),
    _along("velocity_speed_N_s2_per_m", "N s2/m", "|speed| v", _SPEED, "abs(speed)", "magnitude(shaft.speed)", _VELOCITY,
           "v"),
    Term("turning_cosine_N", "N", "(cos t, sin t)", "rotation", "cos(angle)", "sin(angle)", "shaft.cosine", "shaft.sine"),
    Term("turning_sine_N", "N", "(-sin t, cos t)", "rotation", "-sin(angle)", "cos(angle)", "-shaft.sine",
         "shaft.cosine"),
    Term("twice_cosine_N", "N", "(cos 2t, sin 2t)", "rotation", "cos(2 * angle)", "sin(2 * angle)",
         "(shaft.cosine * shaft.cosine - shaft.sine * shaft.sine)", "S(2.0) * shaft.sine * shaft.cosine"),
    Term("twice_sine_N", "N", "(-sin 2t, cos 2t)", "rotation", "-sin(2 * angle)", "cos(2 * angle)",
         "-S(2.0) * shaft.sine * shaft.cosine", "(shaft.cosine * shaft.cosine - shaft.sine * shaft.sine)"),
    _along("current_N_per_A", "N/A", "i", "excitation", "", "", ("ix", "iy"), "i"),
    _along("current_cube_N_per_A3", "N/A3", "|i|^2 i", "large excitation", "(ix^2 + iy^2)", "i.dot(i)", ("ix", "iy"), "i"),
)}

# What the formulas call on beside the quantities; each is written where a term needs it.
_WHERE = {"radius": "hypot(x, y)", "rate": "sqrt(vx^2 + vy^2 + 1e-24)"}
_CPP_WHERE = {"radius": "squareRoot(p.dot(p))", "rate": "squareRoot(v.dot(v) + S(1e-24))"}
# A fit may move a coefficient this many times its first value, either way.
_REACH = 1e3


def _needed(terms: list[Term]) -> list[str]:
    return [name for name in _WHERE if any(name in term.x for term in terms)]


def parameters(terms: list[dict]) -> list[dict]:
    """The parameters of an effect with these terms, as in its file. term: a name of TERMS and a coefficient."""
    rows = []
    for row in terms:
        term, value = TERMS[row["term"]], float(f"{row['coefficient']:.6g}")
        reach = _REACH * abs(value) if value else 1.0
        rows.append({"name": term.name, "unit": term.unit, "lower": -reach, "upper": reach, "typical": value,
                     "neutral": 0.0, "meaning": f"force per {term.meaning}"})
    return rows


def _number(value: float) -> str:
    """As a YAML float: with a point."""
    text = repr(float(value))
    return text if "." in text or "e" not in text else text.replace("e", ".0e")


def yaml_file(name: str, terms: list[dict], summary: str, remarks: list[str]) -> str:
    """The effect file."""
    chosen = [TERMS[row["term"]] for row in terms]
    lines = [f"# {remark}" for remark in remarks]
    lines += ["format: amb-effect/1", f"effect: {name}", f'summary: "{summary}"',
              f'excited_by: "{"; ".join(dict.fromkeys(term.excited_by for term in chosen))}"',
              "place: magnetic_bearings              # or: rotor (at a parameter z_m), sensors", "parameters:"]
    for row in parameters(terms):
        numbers = ", ".join(f"{key}: {_number(row[key])}" for key in ("lower", "upper", "typical", "neutral"))
        lines.append(f'  - {{name: {row["name"]}, unit: "{row["unit"]}", {numbers},\n     meaning: "{row["meaning"]}"}}')
    needed = _needed(chosen)
    if needed:
        lines += ["where:"] + [f'  {key}: "{_WHERE[key]}"' for key in needed]
    lines.append("law:                                  # of x y vx vy ix iy angle speed time end, and the names above")
    for axis in ("x", "y"):
        formula = " + ".join(f"{term.name} * ({getattr(term, axis)})" for term in chosen)
        lines.append(f'  force_{axis}_N: "{formula}"')
    return "\n".join(lines) + "\n"


def class_name(name: str) -> str:
    return "".join(part.capitalize() for part in name.split("_"))


def cpp_header(name: str, terms: list[dict], summary: str) -> str:
    """The effect as a header for include/amb_rotor/effects/."""
    chosen = [TERMS[row["term"]] for row in terms]
    law = " + ".join(f"{term.name} {term.meaning.split(': ')[-1].split(',')[0]}" for term in chosen)
    rows = ",\n             ".join(
        f'parameter("{row["name"]}", "{row["unit"]}", {_number(row["lower"])}, {_number(row["upper"])}, '
        f'{_number(row["typical"])}, 0.0,\n                       "{row["meaning"]}")' for row in parameters(terms))
    force = {axis: " +\n                ".join(f"c_[{k}] * ({getattr(term, 'cpp_' + axis)})" for k, term in enumerate(chosen))
             for axis in ("x", "y")}
    text = force["x"] + force["y"]
    local = [f"      const Vec2<S>& {v} = site.{full};" for v, full in
             (("p", "position"), ("v", "velocity"), ("i", "current"))
             if f"{v}.x" in text or f"{v}.y" in text or f"{v}.dot" in text]
    if "shaft." in text:
        local.append("      const Shaft<S>& shaft = *site.shaft;")
    local += [f"      const S {key} = {_CPP_WHERE[key]};" for key in _needed(chosen)]
    body = "\n".join(local)
    return f"""#pragma once
// {summary}. At each magnetic bearing, while it is on, with p the rotor's displacement there, v its
// velocity, i the current that makes the force and t the shaft's angle:
//   F = {law}
// TO COMPLETE: the mechanism, its source, the range in which the law holds, what is left out.
#include "amb_rotor/effects/effect.hpp"

namespace amb_rotor::effects {{

struct {class_name(name)} {{
  static EffectSchema schema() {{
    return {{"{name}",
            "{summary}",
            "{'; '.join(dict.fromkeys(term.excited_by for term in chosen))}",
            {{{rows}}},
            false}};
  }}

  template <class S>
  class Physics final : public EffectPhysics<S> {{
   public:
    explicit Physics(const std::vector<S>& p) : c_(p) {{}}
    unsigned roles() const override {{ return acts_on_bearing_force; }}
    void bearingForce(const BearingSite<S>& site, Vec2<S>& force) const override {{
{body}
      force += {{{force["x"]},
                {force["y"]}}};
    }}

   private:
    std::vector<S> c_;
  }};
}};

}}  // namespace amb_rotor::effects
"""


def cpp_test(name: str, terms: list[dict]) -> str:
    """Its test for test/unit/: what the formulas give at one place; the closed form is for a person to add."""
    values = ", ".join(_number(row["typical"]) for row in parameters(terms))
    return f"""// {class_name(name)}: the force against its closed form.
#include <gtest/gtest.h>

#include "amb_rotor/effects/{name}.hpp"

namespace amb_rotor::effects {{
namespace {{

TEST({class_name(name)}Test, VanishesAtItsNeutralValuesAndIsLinearInItsCoefficients) {{
  const std::vector<double> typical = {{{values}}};
  std::vector<double> twice, none(typical.size(), 0.0);
  for (double value : typical) twice.push_back(2.0 * value);
  const Shaft<double> shaft = Shaft<double>::at(0.7, 300.0, 0.0);
  const Rig<double> rig;
  const BearingSite<double> site{{&rig, &shaft, 0, {{2e-5, -3e-5}}, {{0.01, 0.02}}, {{0.3, -0.2}}, 0.0}};
  const auto force = [&](const std::vector<double>& values) {{
    Vec2<double> sum;
    {class_name(name)}::Physics<double>(values).bearingForce(site, sum);
    return sum;
  }};
  EXPECT_EQ(force(none).dot(force(none)), 0.0);
  EXPECT_GT(force(typical).dot(force(typical)), 0.0);
  EXPECT_DOUBLE_EQ(force(twice).x, 2.0 * force(typical).x);
  EXPECT_DOUBLE_EQ(force(twice).y, 2.0 * force(typical).y);
}}

TEST({class_name(name)}Test, IsTheClosedForm) {{
  FAIL() << "to complete: the force at one place, worked out by hand from the mechanism";
}}

}}  // namespace
}}  // namespace amb_rotor::effects
"""
