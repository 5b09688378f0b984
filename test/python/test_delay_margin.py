"""A delay takes omega_c times its length off the phase margin: by the bearing's response, the sampled loop and the run."""
from __future__ import annotations

import math
import pathlib

import numpy
import pytest
import scipy.optimize

core = pytest.importorskip("amb_rotor._core")
from amb_rotor import modal  # noqa: E402

MODEL = pathlib.Path(__file__).resolve().parents[2] / "config" / "thesis" / "levitation_model.yaml"
DELAY_S = 1e-4
# The images of the held command at w + 2 pi n/T move the rotor by (w T/2 pi)^2 (equivalent_stiffness.hpp): 0.14 % at the
# crossovers here, with some room.
IMAGES = 2e-3


def levitated(delay_s: float):
    """No gravity, unbalance nor gyroscopics: translation and tilt of the symmetric rig are two loops each on its own."""
    model = core.read_model(str(MODEL)).with_overrides([
        "rig.gravity_m_s2=0", "rig.unbalance.0.moment_kg_m=0", "rig.rotor.polar_inertia_kg_m2=0"])
    return model.with_effect("control_delay", {"delay_s": delay_s})  # in place of the rig's


def open_loop(model, motion: str, omega: float) -> complex:
    """L of 1 + L = 0: m s^2 - 2 Ks + 2 Ki G = 0, and It s^2 - 2 Ks z_a^2 + 2 Ki G z_a z_s = 0 for the tilt, with
    Ki G = k1 + Ks + j w d1 of `amb margins` (3.26)."""
    field = model.fields
    stiffness, damping = core.equivalent_bearings(model, 0.0, [omega / (2.0 * math.pi)])
    ks, magnet, sensor = (field[f"rig.{name}"] for name in ("amb.displacement_stiffness_N_per_m", "planes.amb.b", "planes.sensor.b"))
    loop = 2.0 * (stiffness[0, 0] + ks + 1j * omega * damping[0, 0])
    if motion == "translation":
        return loop / (-field["rig.rotor.mass_kg"] * omega ** 2 - 2.0 * ks)
    return loop * magnet * sensor / (-field["rig.rotor.transverse_inertia_kg_m2"] * omega ** 2 - 2.0 * ks * magnet ** 2)


def crossover(model, motion: str) -> tuple[float, float]:
    """The frequency at which the loop's gain is 1 [rad/s], and the phase that is left there [rad]."""
    omega = scipy.optimize.brentq(lambda w: math.log(abs(open_loop(model, motion, w))), 50.0, 6000.0, xtol=1e-9, rtol=1e-14)
    return omega, float(numpy.angle(-open_loop(model, motion, omega)))


@pytest.mark.parametrize("motion", ["translation", "tilt"])
@pytest.mark.parametrize("longer_s", [5e-5, 2e-4, 3.3e-4])
def test_a_longer_delay_costs_its_length_times_the_crossover(motion, longer_s):
    omega, margin = crossover(levitated(DELAY_S), motion)
    later, less = crossover(levitated(DELAY_S + longer_s), motion)
    assert 0.2 < margin < 1.5, "a loop with a margin to lose"
    assert later == pytest.approx(omega, rel=1e-9)  # a delay has the gain 1
    assert margin - less == pytest.approx(omega * longer_s, rel=1e-8)


def limit() -> tuple[float, float, str]:
    """The delay that the margin of the first of both loops allows [s], and where it is lost [rad/s]."""
    loops = {motion: crossover(levitated(DELAY_S), motion) for motion in ("translation", "tilt")}
    motion = min(loops, key=lambda name: loops[name][1] / loops[name][0])
    omega, margin = loops[motion]
    return DELAY_S + margin / omega, omega, motion


def test_the_sampled_loop_is_unstable_from_the_delay_on_that_has_no_margin_left():
    delay, omega, _ = limit()
    assert modal.largest_growth(levitated(delay * (1.0 - IMAGES)), 0.0) < 0.0
    assert modal.largest_growth(levitated(delay * (1.0 + IMAGES)), 0.0) > 0.0
    border = scipy.optimize.brentq(lambda d: modal.largest_growth(levitated(d), 0.0), 0.5 * delay, 1.5 * delay, xtol=1e-9)
    assert border == pytest.approx(delay, rel=IMAGES)
    mode = min(modal.modes(levitated(border), 0.0), key=lambda mode: abs(mode.damping_ratio))
    assert 2.0 * math.pi * mode.frequency_hz == pytest.approx(omega, rel=IMAGES)


@pytest.mark.parametrize("share, grows", [(0.99, False), (1.01, True)])
def test_a_run_dies_out_or_grows_on_either_side_of_it(share, grows):
    delay, _, motion = limit()
    start = [2e-6, 0.0, 0.0, 0.0] if motion == "translation" else [0.0, 0.0, 2e-5, 0.0]
    columns = core.simulate(levitated(share * delay), core.parse_scenario(
        "{format: amb-scenario/1, name: push, duration_s: 0.4, record_rate_hz: 5000.0, excitations: [], faults: [], "
        "speed: {type: constant, start_hz: 0.0, initial_angle_rad: 0.0}, "
        f"start: {{displacement: {start}, velocity: [0.0, 0.0, 0.0, 0.0]}}}}", "push"))["columns"]
    t, x = columns["t_s"], numpy.abs(columns["position_bx_m"])
    early, late = x[(t > 0.1) & (t < 0.2)].max(), x[t > 0.3].max()
    assert (late > early) == grows
    assert max(early, late) < 2e-4, "without contact"
