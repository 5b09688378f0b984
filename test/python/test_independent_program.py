"""Every effect against an independent program: test/independent, written from the words of the format alone.

The program records a rig without noise, with an effect of known parameters; `compare` predicts the same rig with the
same parameters, refitting nothing. What is left of the difference, over a sensor's noise of 0.4 um and a current's of
5 mA:

- free runs: what the run-in has not settled (0.05 of the noise at most, validation/stretches.hpp), the angle and speed
  that are read from the tacho (its pulse is written to 1e-6; 0.05 rad/s of a ramp's speed between two pulses), the step
  of 10 to 50 us of the lanes (1e-6 of the motion), and 0.8 % of an eddy current's lag: below 0.1;
- windows through contact: touch-down met to 2.5 us by one program and 1 us by the other moves the normal force of a
  1 m/s impact by 1e-5 of its peak; over 10 ms of repeated impacts below 0.1.

Each effect moves the same runs by one noise or more, or the agreement would say nothing.
"""
from __future__ import annotations

import copy
import functools
import pathlib
import shutil
import sys

import numpy
import pytest

FOLDER = pathlib.Path(__file__).resolve().parents[1] / "independent"
sys.path.insert(0, str(FOLDER))

import cases  # noqa: E402
import driver  # noqa: E402
import sets  # noqa: E402

_core = pytest.importorskip("amb_rotor._core")
pytestmark = pytest.mark.skipif(shutil.which("g++") is None, reason="no compiler")

NOISE = numpy.array([0.4e-6] * 4 + [0.005] * 4)
ALLOWED = 0.1  # of the noise, see above
RUNS = ("chirp_1", "chirp_3", "steady_3", "coast_down_1")
# controller and recorder at different rates, a delay over one period, gravity, gyroscopic moment, two unbalances
RIG = "slow"
# the format names the shape at one unbalance's plane only; a limit that shows lets go of the heavy rotor under gravity
OTHER_RIG = {"shaft_flexibility": "plain", "current_saturation": "plain"}
EFFECTS = list(cases.effects_of(sets.RIGS[RIG]))


@functools.cache
def simulator():
    import tempfile
    return driver.Simulator(tempfile.mkdtemp(prefix="independent_"))


def runs_of(block, contact):
    if contact:
        return [{**run, "records": 1050} for run in sets.plan(block, duration=0.5, contact=True) if run["id"] == "drop_1"]
    return [{**run, "settle": 2.0} for run in sets.plan(block, duration=0.25) if run["id"] in RUNS]


def recorded(block, effects, runs):
    return [sets.record(simulator(), block, effects, run, 0.7 + 1.3 * n, free_step=2e-5) for n, run in enumerate(runs)]


@functools.cache
def without_effect(contact, rig):
    block = sets.RIGS[rig]
    return recorded(block, [], runs_of(block, contact))


def case(name):
    rig = OTHER_RIG.get(name, RIG)
    block = sets.RIGS[rig]
    effects = copy.deepcopy(cases.effects_of(block)[name])
    contact = name in cases.CONTACT
    runs = runs_of(block, contact)
    if name == "current_saturation":
        largest = max(numpy.abs(rows[:, 4:]).max() for rows, _ in without_effect(False, rig))
        effects[0]["parameters"]["max_current_A"] = float(block["amb"]["bias_current_A"] + 0.85 * largest)
    return rig, block, effects, runs, contact


def compared(folder, block, effects, runs, recordings):
    """Errors of the project's prediction over the noise, by run."""
    sets.write(folder, "independent", block, [], {}, recordings, runs)
    sets.write_model(folder / "model.yaml", block, effects)
    comparison = _core.compare(_core.read_model(str(folder / "model.yaml")), _core.read_dataset(str(folder)), refit=False)
    return comparison["errors"]["by_run"]


@pytest.mark.parametrize("name", EFFECTS)
def test_prediction_is_that_of_the_independent_program(name, tmp_path):
    rig, block, effects, runs, contact = case(name)
    recordings = recorded(block, effects, runs)
    if effects:
        moved = [numpy.sqrt(numpy.mean(((a[0] - b[0]) / NOISE) ** 2))
                 for a, b in zip(recordings, without_effect(contact, rig))]
        assert max(moved) > 1.0, "the case shows nothing"
    errors = compared(tmp_path, block, effects, runs, recordings)
    assert set(errors) == {run["id"] for run in runs}
    assert max(errors.values()) < ALLOWED, errors


@pytest.mark.parametrize("name, parameter, wrong", [
    ("cross_coupled_stiffness", "stiffness_N_per_m", lambda v: -v),
    ("sensor_runout", "a_2x_phase_rad", lambda v: 2 * v),
    ("control_delay", "delay_s", lambda v: v + 1e-5),
    ("eddy_current_lag", "corner_hz", lambda v: 1.2 * v),
    ("hertzian_contact", "damping_s_per_m", lambda v: 1.5 * v),
])
def test_a_wrong_number_is_seen(name, parameter, wrong, tmp_path):
    _, block, effects, runs, _ = case(name)
    recordings = recorded(block, effects, runs)
    effects[0]["parameters"][parameter] = wrong(effects[0]["parameters"][parameter])
    assert max(compared(tmp_path, block, effects, runs, recordings).values()) > 2 * ALLOWED
