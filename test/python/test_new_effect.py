"""`amb new-effect`: what a diagnosis proposes becomes an effect, as a file and as C++, and takes part like any other."""
from __future__ import annotations

import json
import math
import pathlib
import subprocess

import pytest
import yaml
from conftest import fewer_runs

core = pytest.importorskip("amb_rotor._core")

from amb_rotor import cli, new_effect, new_effect_cpp  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]
LAW = [p for e in core.effect_catalogue() if e["id"] == "force_law" for p in e["parameters"]]
HYPOTHESIS = {p["name"]: p for p in LAW if not p["fixed"] and p["name"] != "step_width_A"}
WIDTH_A = LAW[-1]["typical"]
SIGNALS = {p["name"]: p for e in core.effect_catalogue() if e["id"] == "signal_law" for p in e["parameters"]}
WIDTH_M = SIGNALS["step_width_m"]["typical"]
FREQUENCY_HZ = 37.0
# position [m], velocity [m/s], current [A], angle [rad], speed [rad/s], time [s]
PLACES = [((3e-5, -2e-5), (0.02, 0.01), (0.4, -0.1), 0.7, 300.0, 0.37),
          ((-1e-5, 4e-5), (-0.001, 0.03), (-1.2, 0.6), 2.9, -150.0, 1.21)]
THREE = [{"term": "position_cube_N_per_m3", "coefficient": -3.2e12, "std": 1e10},
         {"term": "velocity_sign_N", "coefficient": -0.3, "std": 0.01},
         {"term": "twice_sine_N", "coefficient": 0.8, "std": 0.02}]


def write_diagnosis(folder: pathlib.Path, terms: list[dict], plane_z_m: float | None = None,
                    place: str = "magnetic_bearings", **width: float) -> pathlib.Path:
    folder.mkdir()
    unexplained = {"depends_on": ["position"], "shape": "", "terms": terms, "held_out_gain": 0.93, "frequency_hz": FREQUENCY_HZ,
                   "place": place if plane_z_m is None else "rotor", "step_width_m": None, "step_width_A": None,
                   "plane_z_m": None if plane_z_m is None else {"value": plane_z_m, "std": 2e-4}} | width
    (folder / "diagnosis.json").write_text(json.dumps(
        {"format": "amb-diagnosis/1", "verdict": "unknown", "unexplained": unexplained, "dataset": {"name": "rig-07"}}))
    for name in ("model.yaml", "adopted.yaml"):
        (folder / name).write_text("")
    return folder


def force(effect: str, values: list[float], place) -> tuple[float, float]:
    return core.bearing_force(effect, values, *place)


def hypothesis_force(terms: list[dict], place) -> tuple[float, float]:
    values = dict.fromkeys(HYPOTHESIS, 0.0) | {row["term"]: row["coefficient"] for row in terms}
    return force("force_law", [*values.values(), FREQUENCY_HZ, WIDTH_A], place)


def test_every_term_of_the_hypothesis_is_known():
    assert {name: term.unit for name, term in new_effect.TERMS.items()} \
        == {name: p["unit"] for name, p in HYPOTHESIS.items()}
    assert {name: term.unit for name, term in new_effect.SIGNAL_TERMS.items()} \
        == {name: p["unit"] for name, p in SIGNALS.items() if name != "step_width_m"}


def signal(effect: str, values: list[float], place) -> tuple[float, float]:
    position, _, _, angle, speed, time = place
    return core.sensor_signal(effect, values, position, angle, speed, time)


def hypothesis_signal(terms: list[dict], place) -> tuple[float, float]:
    values = dict.fromkeys(SIGNALS, 0.0) | {"step_width_m": WIDTH_M} | {row["term"]: row["coefficient"] for row in terms}
    return signal("signal_law", list(values.values()), place)


@pytest.mark.parametrize("term", new_effect.SIGNAL_TERMS)
def test_a_term_of_the_signals_as_formula_is_that_of_the_hypothesis(term, tmp_path):
    terms = [{"term": term, "coefficient": SIGNALS[term]["typical"]}]
    path, acts = tmp_path / "effect.yaml", new_effect.Place("sensors", None, WIDTH_M)
    path.write_text(new_effect.yaml_file(f"proposed_{term}", terms, "of a test", [], None, acts))
    assert core.load_effect(str(path))["id"] == f"proposed_{term}"
    values = [row["typical"] for row in new_effect.parameters(terms, None, acts)]
    for place in PLACES:
        exact = hypothesis_signal(terms, place)
        assert exact != place[0]
        # signals of some 1e-5 m with roundings of 1e-21 m
        assert signal(f"proposed_{term}", values, place) == pytest.approx(exact, rel=0, abs=1e-19)

@pytest.mark.parametrize("term", new_effect.TERMS)
def test_a_term_as_formula_is_the_force_of_the_hypothesis(term, tmp_path):
    terms = [{"term": term, "coefficient": HYPOTHESIS[term]["typical"]}]
    path = tmp_path / "effect.yaml"
    path.write_text(new_effect.yaml_file(f"proposed_{term}", terms, "of a test", [], FREQUENCY_HZ))
    assert core.load_effect(str(path))["id"] == f"proposed_{term}"
    for place in PLACES:
        exact = hypothesis_force(terms, place)
        assert max(map(abs, exact)) > 0.0
        # roundings of some ten operations; the 1e-24 under the root of force_law's |p| is 1e-15 of it here
        values = [row["typical"] for row in new_effect.parameters(terms, FREQUENCY_HZ)]
        assert force(f"proposed_{term}", values, place) == pytest.approx(exact, rel=1e-12, abs=1e-15)


def test_new_effect_writes_what_can_be_read(tmp_path, capsys):
    folder = write_diagnosis(tmp_path / "diagnosis", THREE)
    assert cli.main(["new-effect", "grease", "--from", str(folder), "--out", str(tmp_path)]) == 0
    assert str(tmp_path / "grease.yaml") in capsys.readouterr().out
    text = (tmp_path / "grease.yaml").read_text()
    assert "rig-07" in text and "93 %" in text
    effect = yaml.safe_load(text)
    assert [p["name"] for p in effect["parameters"]] == [row["term"] for row in THREE]
    assert [p["typical"] for p in effect["parameters"]] == [row["coefficient"] for row in THREE]
    assert all(p["lower"] < p["typical"] < p["upper"] and p["unit"] for p in effect["parameters"])
    assert cli.main(["check", str(tmp_path / "grease.yaml")]) == 0
    assert not (tmp_path / "grease.hpp").exists()


def test_a_law_at_one_plane_becomes_an_effect_there(tmp_path):
    folder = write_diagnosis(tmp_path / "diagnosis", THREE, -0.0213)
    assert cli.main(["new-effect", "seal_grease", "--from", str(folder), "--out", str(tmp_path)]) == 0
    text = (tmp_path / "seal_grease.yaml").read_text()
    assert "z_m = -0.0213 +- 0.0002" in text
    effect = yaml.safe_load(text)
    assert effect["place"] == "rotor"
    assert [p["name"] for p in effect["parameters"]] == [*(row["term"] for row in THREE), "z_m"]
    assert effect["parameters"][-1]["typical"] == -0.0213 and "neutral" not in effect["parameters"][-1]
    assert cli.main(["check", str(tmp_path / "seal_grease.yaml")]) == 0


def test_a_law_of_the_tilt_becomes_an_effect_of_it(tmp_path):
    folder = write_diagnosis(tmp_path / "diagnosis", THREE, place="tilt")
    assert cli.main(["new-effect", "coupling", "--from", str(folder), "--out", str(tmp_path)]) == 0
    effect = yaml.safe_load((tmp_path / "coupling.yaml").read_text())
    assert effect["place"] == "tilt" and "couple" in effect["summary"]
    assert [p["name"] for p in effect["parameters"]] == [row["term"] for row in THREE]
    assert cli.main(["check", str(tmp_path / "coupling.yaml")]) == 0


STEP = [{"term": "signal_step_m", "coefficient": -2.6e-6, "std": 5e-9}, {"term": "signal_turn_s", "coefficient": 3e-5, "std": 1e-6}]


def test_a_law_of_the_signals_becomes_an_effect_of_the_sensors(tmp_path):
    folder = write_diagnosis(tmp_path / "diagnosis", STEP, place="sensors", step_width_m=8.7e-6)
    assert cli.main(["new-effect", "sticky_probe", "--from", str(folder), "--out", str(tmp_path)]) == 0
    effect = yaml.safe_load((tmp_path / "sticky_probe.yaml").read_text())
    assert effect["place"] == "sensors" and "signal" in effect["summary"] and set(effect["law"]) == {"signal_x_m", "signal_y_m"}
    assert [p["name"] for p in effect["parameters"]] == [*(row["term"] for row in STEP), "step_width_m"]
    assert effect["parameters"][-1]["typical"] == 8.7e-6 and "neutral" not in effect["parameters"][-1]
    assert cli.main(["check", str(tmp_path / "sticky_probe.yaml")]) == 0


def test_a_step_of_the_current_keeps_its_width(tmp_path):
    step = [{"term": "current_axes_sign_N", "coefficient": -0.127, "std": 1e-3}]
    folder = write_diagnosis(tmp_path / "diagnosis", step, step_width_A=0.107)
    assert cli.main(["new-effect", "dead_current", "--from", str(folder), "--out", str(tmp_path)]) == 0
    effect = yaml.safe_load((tmp_path / "dead_current.yaml").read_text())
    assert effect["place"] == "magnetic_bearings"
    assert [(p["name"], p["unit"], p["typical"]) for p in effect["parameters"]] == [("current_axes_sign_N", "N", -0.127), ("step_width_A", "A", 0.107)]
    assert core.load_effect(str(tmp_path / "dead_current.yaml"))["id"] == "dead_current"
    made, _ = force("dead_current", [-0.127, 0.107], PLACES[0])
    assert made == pytest.approx(-0.127 * math.tanh(0.4 / 0.107))


@pytest.mark.parametrize("name, complaint", [
    ("sensor_runout", "has an effect of this name"), ("Bad-Name", "lower case"), ("../x", "lower case")])
def test_bad_names_are_refused(name, complaint, tmp_path, capsys):
    folder = write_diagnosis(tmp_path / "diagnosis", THREE)
    assert cli.main(["new-effect", name, "--from", str(folder), "--out", str(tmp_path / "out")]) == 2
    assert complaint in capsys.readouterr().err and not (tmp_path / "out").exists()


def test_nothing_proposed_is_said_and_nothing_overwritten(tmp_path, capsys):
    assert cli.main(["new-effect", "grease", "--from", str(write_diagnosis(tmp_path / "none", []))]) == 2
    assert "nothing to make an effect of" in capsys.readouterr().err
    folder = write_diagnosis(tmp_path / "diagnosis", THREE)
    (tmp_path / "grease.yaml").write_text("mine")
    assert cli.main(["new-effect", "grease", "--from", str(folder), "--out", str(tmp_path)]) == 2
    assert "is there already" in capsys.readouterr().err and (tmp_path / "grease.yaml").read_text() == "mine"


MAIN = """
#include <cstdio>
#include "grease.hpp"
using namespace amb_rotor;
int main() {
  const Rig<double> rig;
  Shaft<double> shaft = Shaft<double>::at(0.7, 300.0, 0.0);
  shaft.time = 0.37;
  std::vector<double> values;
  for (const auto& p : effects::Grease::schema().parameters) values.push_back(p.typical);
  Vec2<double> force;
  const BearingSite<double> site{&rig, &shaft, 0, {3e-5, -2e-5}, {0.02, 0.01}, {0.4, -0.1}, 0.0};
  effects::Grease::Physics<double>(values).bearingForce(site, force);
  std::printf("%.17g %.17g", force.x, force.y);
}
"""


def flags_of(folder: pathlib.Path) -> list[str]:
    """As the program is compiled, with all warnings as errors."""
    return ["g++", "-std=c++17", "-Wall", "-Wextra", "-Werror", f"-I{ROOT / 'include'}", f"-I{folder}",
            "-I/usr/include/eigen3", "-DEIGEN_MAX_ALIGN_BYTES=16"]


def compiled_force(folder: pathlib.Path) -> list[float]:
    subprocess.run([*flags_of(folder), str(folder / "main.cpp"), "-o", str(folder / "main")], check=True)
    printed = subprocess.run([folder / "main"], check=True, capture_output=True, text=True).stdout
    return [float(x) for x in printed.split()]


@pytest.mark.slow
def test_the_cpp_is_the_same_force(tmp_path):
    folder = write_diagnosis(tmp_path / "diagnosis", THREE)
    assert cli.main(["new-effect", "grease", "--from", str(folder), "--out", str(tmp_path), "--cpp"]) == 0
    (tmp_path / "main.cpp").write_text(MAIN)
    assert compiled_force(tmp_path) == pytest.approx(hypothesis_force(THREE, PLACES[0]), rel=1e-12)
    test = (tmp_path / "effect_grease.cpp").read_text().replace("amb_rotor/effects/grease.hpp", "grease.hpp")
    (tmp_path / "effect_grease.cpp").write_text(test)
    subprocess.run([*flags_of(tmp_path), "-fsyntax-only", str(tmp_path / "effect_grease.cpp")], check=True)


def tilted(place):
    """With minus half of the displacement and velocity."""
    return (*(tuple(-0.5 * x for x in vector) for vector in place[:2]), *place[2:])


MAIN_AT_A_PLANE = """
#include <cstdio>
#include "grease.hpp"
using namespace amb_rotor;
struct Rotor : RotorPort<double>, RotorForces<double> {
  double z = 0.0;
  int planes = 6;
  int addPlane(const double& at) override { z = at; return ++planes; }
  void addMode(const double&, const double&, const double&, const double[2], const double[2], const double[2],
               const double&) override {}
  Vec2<double> position(int plane) const override { return plane == 7 ? Vec2<double>{3e-5, -2e-5} : Vec2<double>{}; }
  Vec2<double> velocity(int plane) const override { return plane == 7 ? Vec2<double>{0.02, 0.01} : Vec2<double>{}; }
  void push(int plane, const Vec2<double>& f) override {
    if (plane == planes) force += f;
    sum += f;
  }
  void load(int, const Vec2<double>&) override {}
  void twist(const double&) override {}
  Vec2<double> force, sum;
};
int main() {
  Shaft<double> shaft = Shaft<double>::at(0.7, 300.0, 0.0);
  shaft.time = 0.37;
  std::vector<double> values;
  for (const auto& p : effects::Grease::schema().parameters) values.push_back(p.typical);
  effects::Grease::Physics<double> physics(values);
  Rotor rotor;
  Rig<double> rig;
  rig.planes.amb[1] = 0.12;
  physics.rotor(rig, rotor);
  physics.rotorForce(shaft, rotor);
  std::printf("%.17g %.17g %.17g %.17g %.17g", rotor.force.x, rotor.force.y, rotor.z, rotor.sum.x, rotor.sum.y);
}
"""


@pytest.mark.slow
@pytest.mark.parametrize("terms", [THREE, [{"term": "hum_y_sine_N", "coefficient": 2.0, "std": 0.1}, *THREE[:1]]])
@pytest.mark.parametrize("place", ["rotor", "tilt"])
def test_the_cpp_of_a_law_elsewhere_is_its_force_there(terms, place, tmp_path):
    folder = write_diagnosis(tmp_path / "diagnosis", terms, 0.031 if place == "rotor" else None, place)
    assert cli.main(["new-effect", "grease", "--from", str(folder), "--out", str(tmp_path), "--cpp"]) == 0
    (tmp_path / "main.cpp").write_text(MAIN_AT_A_PLANE)
    # the first plane moves and the second, of bearing b, stands still: the tilt is half of it, turned round
    where, z_m = (PLACES[0], 0.031) if place == "rotor" else (tilted(PLACES[0]), 0.12)
    exact = hypothesis_force(terms, where)
    total = exact if place == "rotor" else (0.0, 0.0)
    assert compiled_force(tmp_path) == pytest.approx([*exact, z_m, *total], rel=1e-12)
    test = (tmp_path / "effect_grease.cpp").read_text().replace("amb_rotor/effects/grease.hpp", "grease.hpp")
    (tmp_path / "effect_grease.cpp").write_text(test)
    subprocess.run([*flags_of(tmp_path), "-fsyntax-only", str(tmp_path / "effect_grease.cpp")], check=True)


MAIN_IN_THE_SENSORS = """
#include <cstdio>
#include "grease.hpp"
using namespace amb_rotor;
int main() {
  Shaft<double> shaft = Shaft<double>::at(0.7, 300.0, 0.0);
  shaft.time = 0.37;
  std::vector<double> values;
  for (const auto& p : effects::Grease::schema().parameters) values.push_back(p.typical);
  Vec2<double> signal[2] = {{0.0, 0.0}, {3e-5, -2e-5}};
  const effects::Grease::Physics<double> physics(values);
  if (physics.roles() != acts_on_sensor) return 1;
  physics.sense(shaft, signal);
  std::printf("%.17g %.17g", signal[1].x, signal[1].y);
}
"""


@pytest.mark.slow
def test_every_term_of_the_signals_is_the_same_in_cpp(tmp_path):
    every = [{"term": name, "coefficient": SIGNALS[name]["typical"], "std": 0.0} for name in new_effect.SIGNAL_TERMS]
    folder = write_diagnosis(tmp_path / "diagnosis", every, place="sensors", step_width_m=WIDTH_M)
    assert cli.main(["new-effect", "grease", "--from", str(folder), "--out", str(tmp_path), "--cpp"]) == 0
    (tmp_path / "main.cpp").write_text(MAIN_IN_THE_SENSORS)
    assert compiled_force(tmp_path) == pytest.approx(hypothesis_signal(every, PLACES[0]), rel=0, abs=1e-18)
    test = (tmp_path / "effect_grease.cpp").read_text().replace("amb_rotor/effects/grease.hpp", "grease.hpp")
    (tmp_path / "effect_grease.cpp").write_text(test)
    subprocess.run([*flags_of(tmp_path), "-fsyntax-only", str(tmp_path / "effect_grease.cpp")], check=True)


@pytest.mark.slow
def test_every_term_is_the_same_force_in_cpp(tmp_path):
    # the least of them is 1e-5 of the sum, roundings are 1e-15 of it
    every = [{"term": name, "coefficient": p["typical"]} for name, p in HYPOTHESIS.items()]
    (tmp_path / "grease.hpp").write_text(new_effect_cpp.cpp_header("grease", every, "of a test", FREQUENCY_HZ))
    (tmp_path / "main.cpp").write_text(MAIN)
    assert compiled_force(tmp_path) == pytest.approx(hypothesis_force(every, PLACES[0]), rel=1e-12)
    for row in every:
        assert max(map(abs, hypothesis_force([row], PLACES[0]))) > 1e-6 * max(map(abs, hypothesis_force(every, PLACES[0])))


@pytest.mark.slow
def test_from_an_unknown_residual_to_an_adopted_effect_of_ones_own(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    def amb(*arguments):
        assert cli.main([str(a) for a in arguments]) == 0, arguments

    amb("make-dataset", "--seed", 3, "--effect", "cubic_stiffness", "--strength", 6, "--out", "made")
    truth = yaml.safe_load(pathlib.Path("made/truth.yaml").read_text())["law"]
    fewer_runs(tmp_path / "made", ("chirp_1", "chirp_3", "steady_1", "steady_3", "chirp_4", "steady_4"), tmp_path / "rig")
    # a catalogue without a name for it
    amb("diagnose", "rig", "--effect", "static_load", "--steps", 1, "--out", "unknown")
    unknown = json.loads(pathlib.Path("unknown/diagnosis.json").read_text())
    assert unknown["verdict"] == "unknown" and unknown["unexplained"]["depends_on"] == ["position"]
    assert unknown["baseline"]["validation_error"] > 2.0
    terms = {row["term"]: row["coefficient"] for row in unknown["unexplained"]["terms"]}
    assert terms["position_cube_N_per_m3"] < 0.0, "it pulls back"
    if len(terms) == 1:
        assert terms["position_cube_N_per_m3"] == pytest.approx(-truth["amount"], rel=0.3)  # of one linear step
    # one linear step in the coefficients, not a refit, so not all of the error
    assert unknown["unexplained"]["held_out_gain"] > 0.7
    amb("new-effect", "hardening", "--from", "unknown")
    amb("diagnose", "rig", "--effect-file", "hardening.yaml", "--effect", "static_load", "--effect", "hardening",
        "--steps", 1, "--out", "found")
    found = json.loads(pathlib.Path("found/diagnosis.json").read_text())
    assert found["verdict"] == "effect"
    assert [step["added"] for step in found["steps"]] == ["hardening"]
    assert found["ranking"][0]["effect"] == "hardening"
    # the goal of the project for runs without contact
    assert found["steps"][0]["validation_error"] < 1.15
    sizes = found["steps"][0]["parameters"].values()
    assert any(size["value"] < 0.0 and 0.0 < size["std"] < 0.1 * abs(size["value"]) for size in sizes), "the runs tell it"
    amb("adopt", "found", "--out", "model.yaml")
    pathlib.Path("hardening.yaml").unlink()  # the model holds the definition
    amb("compare", "model.yaml", "rig", "--limit", 1.15)
