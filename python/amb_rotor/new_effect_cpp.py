"""A new effect from the law that a diagnosis proposes, as C++ with its test to complete."""
from __future__ import annotations

import dataclasses
import textwrap

from amb_rotor.new_effect import BEARINGS, CURRENT_WIDTH, WIDTH, Place, number, parameters, reads, terms_of

# What the formulas call on beside the quantities; each is written where a term needs it.
_CPP_WHERE = {"radius": "squareRoot(p.dot(p))", "rate": "squareRoot(v.dot(v) + S(1e-24))",
              "side": "S(site.end == 0 ? -1.0 : 1.0)", "c2": "shaft.cosine * shaft.cosine - shaft.sine * shaft.sine",
              "s2": "S(2.0) * shaft.sine * shaft.cosine", "c3": "shaft.cosine * c2 - shaft.sine * s2",
              "s3": "shaft.sine * c2 + shaft.cosine * s2"}
_NO_NEUTRAL = 'std::nan("")'
_QUANTITIES = (("p", "position"), ("v", "velocity"), ("i", "current"))


def _cpp_needed(text: str) -> list[str]:
    """The local values that C++ formulas call on, with those that these call on, in the order of their definition."""
    needed = {name for name in _CPP_WHERE if reads(text, name)}
    for name in reversed(list(_CPP_WHERE)):
        if name in needed:
            needed |= {other for other in _CPP_WHERE if reads(_CPP_WHERE[name], other)}
    return [name for name in _CPP_WHERE if name in needed]


def class_name(name: str) -> str:
    return "".join(part.capitalize() for part in name.split("_"))


@dataclasses.dataclass(frozen=True)
class _Place:
    """How a law enters a machine: the words of its comment and what it says there, its port, where p, v and the shaft are from, where F
    goes to; the loop in which it does so."""
    said: str
    roles: str
    port: str
    quantity: str
    shaft: str
    applied: str
    members: str = ""
    made: str = ""
    include: str = "effect.hpp"
    law: str = "F = "
    each: str = ""


def _place(place: Place, plane: int) -> _Place:
    """plane: where z_m is among the parameters, if it is one."""
    if place == BEARINGS:
        return _Place("At each magnetic bearing, while it is on, with p the rotor's displacement there, v its\n"
                      "// velocity, i the current that makes the force and t the shaft's angle", "acts_on_bearing_force",
                      "void bearingForce(const BearingSite<S>& site, Vec2<S>& force) const override",
                      "const Vec2<S>& {short} = site.{full};", "      const Shaft<S>& shaft = *site.shaft;\n", "force += {force};")
    if place.kind == "tilt":
        return _Place("At magnetic bearing b, and its opposite at a, with p = (p_b - p_a)/2 of the displacements there, v its\n"
                      "// rate and t the shaft's angle", "acts_on_rotor | acts_on_rotor_force",
                      "void rotorForce(const Shaft<S>& {shaft}, RotorForces<S>& rotor) const override",
                      "const Vec2<S> {short} = tilt_.{full}(rotor);", "", "tilt_.push(rotor, {force});", "    TiltPlanes<S> tilt_;\n",
                      "    void rotor(const Rig<S>& rig, RotorPort<S>& port) override { tilt_ = TiltPlanes<S>(rig, port); }\n",
                      "tilt_planes.hpp")
    if place.kind == "sensors":
        return _Place("At each sensor pair, with p its signals so far, y what becomes of them and t the shaft's angle", "acts_on_sensor",
                      "void sense(const Shaft<S>& {shaft}, Vec2<S> signal[2]) const override", "const Vec2<S> {short} = signal[end];", "",
                      "signal[end] += {force};", law="y = p + ", each="for (int end = 0; end < 2; ++end)")
    return _Place("At the plane z_m of the rotor, with p its displacement there, v its velocity and t the shaft's\n// angle",
                  "acts_on_rotor | acts_on_rotor_force",
                  "void rotorForce(const Shaft<S>& {shaft}, RotorForces<S>& rotor) const override",
                  "const Vec2<S> {short} = rotor.{full}(plane_);", "", "rotor.push(plane_, {force});", "    int plane_ = 0;\n",
                  f"    void rotor(const Rig<S>&, RotorPort<S>& port) override {{ plane_ = port.addPlane(c_[{plane}]); }}\n")


def cpp_header(name: str, terms: list[dict], summary: str, frequency_hz: float | None = None, acts: Place = BEARINGS) -> str:
    """The effect as a header for include/amb_rotor/effects/."""
    chosen = terms_of(terms)
    own = parameters(terms, frequency_hz, acts)
    first = [row["name"] for row in own].index(chosen[0].name)  # the frequency comes before the coefficients
    place = _place(acts, len(own) - 1)
    law = " + ".join(f"{term.name} {term.meaning.split(': ')[-1].split(', rounded')[0]}" for term in chosen)
    rows = ",\n             ".join(
        f'parameter("{row["name"]}", "{row["unit"]}", {number(row["lower"])}, {number(row["upper"])}, '
        f'{number(row["typical"])}, {"0.0" if "neutral" in row else _NO_NEUTRAL},\n                       "{row["meaning"]}")'
        for row in own)
    force = {axis: " +\n                ".join(f"c_[{k + first}] * ({getattr(term, 'cpp_' + axis)})"
                                                 for k, term in enumerate(chosen))
             for axis in ("x", "y")}
    for width in (WIDTH, CURRENT_WIDTH):
        force = {axis: formula.replace(width, f"c_[{len(own) - 1}]") for axis, formula in force.items()}
    text = force["x"] + force["y"]
    needed = _cpp_needed(text)
    called = text + "".join(_CPP_WHERE[key] for key in needed)
    local = [f"      {place.quantity.format(short=v, full=full)}" for v, full in _QUANTITIES
             if any(f"{v}.{part}" in called for part in ("x", "y", "dot"))]
    turns = "shaft." in called or first > 0
    lines = "".join(f"{line}\n" for line in local) + (place.shaft if turns else "")
    lines += "".join(f"      const S {key} = {_CPP_WHERE[key]};\n" for key in needed)
    if first:
        lines += "      S hum_sine, hum_cosine;\n      sineCosine(S(two_pi * shaft.time) * c_[0], hum_sine, hum_cosine);\n"
    port = place.port.replace("{shaft}", "shaft" if turns else "")
    body = f"{lines}      " + place.applied.replace("{force}", f"{{{force['x']},\n                {force['y']}}}")
    if place.each:
        body = f"      {place.each} {{\n{textwrap.indent(body, '  ')}\n      }}"
    return f"""#pragma once
// {summary}. {place.said}:
//   {place.law}{law}
// TO COMPLETE: the mechanism, and after the words Valid, Source and Left out, each with a colon, the range in which the
// law holds, where it is from and what it leaves out.
#include "amb_rotor/effects/{place.include}"

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
    unsigned roles() const override {{ return {place.roles}; }}
{place.made}    {port} {{
{body}
    }}

   private:
    std::vector<S> c_;
{place.members}  }};
}};

}}  // namespace amb_rotor::effects
"""


_AT_THE_BEARINGS = """  const BearingSite<double> site{&rig, &shaft, 0, {2e-5, -3e-5}, {0.01, 0.02}, {0.3, -0.2}, 0.0};
  const auto force = [&](const std::vector<double>& values) {
    Vec2<double> sum;
    CLASS::Physics<double>(values).bearingForce(site, sum);
    return sum;
  };
"""
_ON_THE_ROTOR = """  const auto force = [&](const std::vector<double>& values) {
    CLASS::Physics<double> physics(values);
    MovedRotor rotor;
    physics.rotor(rig, rotor);
    physics.rotorForce(shaft, rotor);
    return rotor.force;
  };
"""
_IN_THE_SENSORS = """  const auto force = [&](const std::vector<double>& values) {
    Vec2<double> signal[2] = {{2e-5, -3e-5}, {1e-5, 4e-5}};
    CLASS::Physics<double>(values).sense(shaft, signal);
    return signal[0] - Vec2<double>{2e-5, -3e-5};
  };
"""
_MOVED_ROTOR = """
/// A rotor whose planes move each in its way; the force on the last.
struct MovedRotor : RotorPort<double>, RotorForces<double> {
  int planes = 0;
  int addPlane(const double&) override { return ++planes; }
  void addMode(const double&, const double&, const double&, const double[2], const double[2], const double[2],
               const double&) override {}
  Vec2<double> position(int plane) const override { return static_cast<double>(plane) * Vec2<double>{2e-5, -3e-5}; }
  Vec2<double> velocity(int plane) const override { return static_cast<double>(plane) * Vec2<double>{0.01, 0.02}; }
  void push(int plane, const Vec2<double>& f) override {
    if (plane == planes) force += f;
  }
  void load(int plane, const Vec2<double>& f) override { push(plane, f); }
  void twist(const double&) override {}
  Vec2<double> force;
};
"""


def cpp_test(name: str, terms: list[dict], frequency_hz: float | None = None, acts: Place = BEARINGS) -> str:
    """Its test for test/unit/: what the formulas give at one place; the closed form is for a person to add."""
    rows = parameters(terms, frequency_hz, acts)
    names = [row["name"] for row in rows]
    values = ", ".join(number(row["typical"]) for row in rows)
    first = names.index(terms_of(terms)[0].name)  # the frequency, which is no coefficient, comes first
    moved, force = {"magnetic_bearings": ("", _AT_THE_BEARINGS), "sensors": ("", _IN_THE_SENSORS)}.get(
        acts.kind, (_MOVED_ROTOR, _ON_THE_ROTOR))
    # signals are some 1e-5 m, with roundings of 1e-21 m
    same = "EXPECT_DOUBLE_EQ({0}, {1});" if acts.kind != "sensors" else "EXPECT_NEAR({0}, {1}, 1e-19);"
    doubled = "\n".join("  " + same.format(f"force(twice).{axis}", f"2.0 * force(typical).{axis}") for axis in ("x", "y"))
    return f"""// {class_name(name)}: the {"signal" if acts.kind == "sensors" else "force"} against its closed form.
#include <gtest/gtest.h>

#include "amb_rotor/effects/{name}.hpp"

namespace amb_rotor::effects {{
namespace {{
{moved}
TEST({class_name(name)}Test, VanishesAtItsNeutralValuesAndIsLinearInItsCoefficients) {{
  const std::vector<double> typical = {{{values}}};
  std::vector<double> twice = typical, none = typical;
  for (std::size_t i = {first}; i < {first + len(terms)}; ++i) {{
    twice[i] = 2.0 * typical[i];
    none[i] = 0.0;
  }}
  Shaft<double> shaft = Shaft<double>::at(0.7, 300.0, 0.0);
  shaft.time = 0.37;
  const Rig<double> rig;
{force.replace("CLASS", class_name(name))}  EXPECT_EQ(force(none).dot(force(none)), 0.0);
  EXPECT_GT(force(typical).dot(force(typical)), 0.0);
{doubled}
}}

TEST({class_name(name)}Test, IsTheClosedForm) {{
  FAIL() << "to complete: the force at one place, worked out by hand from the mechanism";
}}

}}  // namespace
}}  // namespace amb_rotor::effects
"""
