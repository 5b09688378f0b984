"""The generator of the independent program (test/independent/blind.py) with laws of no catalogue."""
from __future__ import annotations

import pathlib
import shutil
import sys

import numpy as np
import pytest
import yaml

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "independent"))

import blind  # noqa: E402
import driver  # noqa: E402
import laws  # noqa: E402
import sets  # noqa: E402

needs_compiler = pytest.mark.skipif(shutil.which("g++") is None, reason="no compiler")
QUANTITIES = {"position", "velocity", "spin speed", "shaft angle", "control current", "time"}  # of the format


class Witness:
    """In the simulator's place: notes what it is given and records nothing."""

    def __init__(self):
        self.given: list[dict] = []

    def run(self, parameters: dict, *_, **__):
        self.given.append(parameters)
        raise ArithmeticError("not run")


@pytest.mark.parametrize("seed, index, rig, law, value", [
    (12, 30, 0, "law_cubic", 415320481589248.8), (13, 32, 1, "law_dry", 2.692010209499582)])
def test_the_sets_of_a_round_stay_what_they_were(seed, index, rig, law, value, tmp_path):
    """Other tests diagnose these two. The last run that is asked for is of the rig that carries the law."""
    witness = Witness()
    blind.make_set(seed, index, witness, tmp_path / "set", attempts=rig + 1)
    assert witness.given[-1][law] == pytest.approx(value, rel=1e-12)


def test_a_round_of_laws_hides_each_once_and_nothing_else():
    chosen = list(laws.ALL)
    hidden = [blind.hidden_in(index, 1, chosen) for index in range(2 * len(chosen))]
    assert hidden == 2 * [("unknown", [name]) for name in chosen]
    assert set().union(*laws.ALL.values()) <= QUANTITIES


def test_rounds_of_laws_are_on_rigs_of_their_own(tmp_path):
    round_of_all, round_of_laws = Witness(), Witness()
    index = blind.ROUND - blind.PAIRS - 1  # a law in both
    blind.make_set(1, index, round_of_all, tmp_path / "set", attempts=1)
    blind.make_set(1, index, round_of_laws, tmp_path / "set", attempts=1, chosen=["dry_friction_levitated"])
    assert round_of_all.given[0]["mass"] != round_of_laws.given[0]["mass"]


@needs_compiler
@pytest.mark.parametrize("name", laws.APART)
def test_a_law_has_parameters_that_the_simulator_knows_and_a_plane_near_the_rotor(name, tmp_path_factory):
    known = driver.Simulator(tmp_path_factory.getbasetemp()).names
    for seed in range(20):
        dice = np.random.default_rng(seed)
        rig = blind.draw_rig(dice)
        parameters, aim, least = laws.drawn_apart(dice, name, rig)
        assert set(parameters) <= set(known)
        a, b = (rig["planes"]["amb"][end] for end in "ab")
        assert a - 0.3 * (b - a) <= parameters.get("law_z_m", 0.0) <= b + 0.3 * (b - a)
        assert laws.DIFFERENCE[0] < least <= aim < laws.DIFFERENCE[1]
        half = laws.scaled(parameters, 0.5)
        (changed,) = [key for key in parameters if half[key] != parameters[key]]
        times = 2 ** 0.5 if changed == "law_sensor_limit" else 0.5  # of L tanh(s/L), first of all s - s^3/(3 L^2)
        assert half[changed] == pytest.approx(times * parameters[changed], rel=1e-15)
        assert changed != "law_z_m" and "phase" not in changed


def test_a_round_of_all_laws_has_those_of_sensors_last():
    """The sets before them stay what they were."""
    assert list(laws.ALL)[-len(laws.OF_SENSORS):] == list(laws.OF_SENSORS)
    assert not set(laws.OF_SENSORS) & set(blind.LAWS)


def test_play_needs_offsets_that_the_controller_acts_on(tmp_path, capsys):
    witness = Witness()
    for offsets in ("recording", "loop"):
        blind.make_set(1, 0, witness, tmp_path / "set", blind.Reading(offsets), attempts=1, chosen=["sensor_dead_zone"])
        assert bool(witness.given) == (offsets == "loop")
    assert "from its very middle noise decides" in capsys.readouterr().err


class Swayed(Witness):
    """Records a rest at one side of the play with noise in the loop, at the other one without."""

    def __init__(self, apart):
        super().__init__()
        self.apart = apart

    def run(self, parameters, unbalances, knots, angle, record_hz, excitation, records, *_, disturbance=None, **__):
        return np.full((records, 8), self.apart if disturbance is None else 0.0)


def test_what_noise_decides_makes_no_set():
    dice = np.random.default_rng(1)
    rig = blind.draw_rig(dice)
    runs = [run for run in sets.plan(rig, duration=0.01) if run["id"] in ("chirp_1", "steady_1")]
    for apart in (0.9e-6, 1.1e-6):
        recorder = blind.Recorder(dice, Swayed(apart), rig, {"law_sensor_play": 2e-6}, blind.Reading("loop"))
        recorder.all([], runs[-1:])
        recorder.most_swayed = np.full(8, 1e-6)
        if apart < 1e-6:
            recorder.all([], runs)
        else:
            with pytest.raises(blind.Unfit, match="rests in chirp_1"):
                recorder.all([], runs)


@pytest.mark.parametrize("law, reading", [
    ({}, 0.7), ({"law_sensor_limit": 0.4}, 0.4 * np.tanh(0.7 / 0.4)), ({"law_sensor_play": 0.2}, 0.5),
    ({"law_sensor_speed": 1e-3}, 0.7 * (1 + 0.2 * np.pi))])
def test_how_far_the_rotor_reaches_is_told_by_where_it_is(law, reading):
    """In clearances; 0.7 is too far for a run without contact, whatever the sensors say."""
    dice = np.random.default_rng(1)
    rig = blind.draw_rig(dice)
    c = rig["auxiliary_bearing"]["clearance_m"]
    law = {key: value if key == "law_sensor_speed" else value * c for key, value in law.items()}
    recorder = blind.Recorder(dice, None, rig, law, blind.Reading())
    with pytest.raises(blind.Unfit, match="reaches 0.70 "):
        recorder.check_reach({"id": "x", "kind": "steady", "hz": 100.0, "record_hz": 1e4, "records": 5},
                             np.array([[0, 0, -reading * c, 0, 9, 9, 9, 9]] * 5))


@pytest.mark.slow
@needs_compiler
def test_a_set_of_a_sensors_law_reads_as_it_says(tmp_path):
    blind.make_set(5, 2, driver.Simulator(tmp_path), tmp_path / "set", blind.Reading("loop"), chosen=["sensor_speed_gain"])
    truth = yaml.safe_load((tmp_path / "set/truth.yaml").read_text())
    assert (truth["law"], truth["depends_on"]) == ("sensor_speed_gain", ["position", "spin speed"])
    assert set(truth["law_parameters"]) == {"law_sensor_speed"} and truth["effects"] == []
    assert laws.DIFFERENCE[0] <= truth["difference"] <= laws.DIFFERENCE[1]


@pytest.mark.slow
@needs_compiler
def test_a_law_shows_as_much_as_was_drawn_and_only_the_truth_names_it(tmp_path):
    blind.make_set(1, 0, driver.Simulator(tmp_path), tmp_path / "set", chosen=["plane_third_harmonic"])
    truth = yaml.safe_load((tmp_path / "set/truth.yaml").read_text())
    assert (truth["law"], truth["depends_on"], truth["verdict"]) == ("plane_third_harmonic", ["shaft angle"], "unknown")
    assert set(truth["law_parameters"]) == {"law_z_m", "law_plane_third", "law_plane_third_phase"}
    assert laws.DIFFERENCE[0] <= truth["difference"] <= laws.DIFFERENCE[1]
    assert "law" not in (tmp_path / "set/dataset.yaml").read_text()


def test_damping_that_hardly_tells_any_more_is_left_where_it_is():
    """An aim out of reach: what the law has come to does, or the rig carries none."""
    class Saturating:
        sensor_noise, amplifier_noise = np.full(4, 1e-6), np.full(4, 1e-2)

        def quiet(self, effects, run, angle, disturbance=None, law=None):
            strength = law["law_tilt_drag"] / (1 + law["law_tilt_drag"]) if law else 0.0
            return np.repeat([self.most * 1e-6 * strength, self.most * 1e-2 * strength], 4) * np.ones((10, 1)), None

    recorder, runs = Saturating(), [{"kind": "steady", "records": 10}]
    recorder.most = 20.0
    weak = {"law_tilt_drag": 0.1}
    sized, noise = blind.sized_law(recorder, weak, runs, 5.0, 3.5)
    assert sized["law_tilt_drag"] == pytest.approx(1 / 3, rel=0.2)
    assert noise == pytest.approx([1e-6] * 4 + [1e-2] * 4)
    recorder.most = 6.0
    assert blind.sized_law(recorder, weak, runs, 13.0, 3.5)[0]["law_tilt_drag"] < 100.0
    with pytest.raises(blind.Unfit, match="not to 13.0"):
        blind.sized_law(recorder, weak, runs, 13.0, 9.0)
    recorder.most = 3.0
    with pytest.raises(blind.Unfit, match="not to 13.0"):
        blind.sized_law(recorder, weak, runs, 13.0, 3.5)
