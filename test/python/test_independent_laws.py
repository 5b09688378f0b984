"""Laws of no catalogue of the independent program (test/independent): against their own formulas, and against physics.

The rotor here is passive: the magnets are springs (Ks below 0, no controller), an excitation current of 1 A pushes
with 1 N. After a kick it moves alone. What it moves like tells of the forces on it: its accelerations, its energy, or
another law that must do the same.
"""
from __future__ import annotations

import pathlib
import shutil
import sys

import numpy as np
import pytest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "independent"))

import driver  # noqa: E402
import laws  # noqa: E402

pytestmark = pytest.mark.skipif(shutil.which("g++") is None, reason="no compiler")

MASS, TILT, POLAR, SPRING, SPIN, ANGLE, PHASE = 2.6, 0.025, 0.004, 3e5, 420.0, 0.7, -1.1
AMB, SENSOR, PLANE = (-0.11, 0.067), (-0.09, 0.044), 0.085
RATE = 1e5        # of the records [Hz]
KICK = 500        # of them a push lasts
ALONE = KICK + 50  # from then on the amplifiers' lag of 50 kHz has left 1e-60 of the push
EXACT = 1e-6      # of the largest: five-point differences of 100 Hz at 0.1 MHz leave 1e-9, rounding 1e-8

# name: parameters with which it shows beside the springs in the motion of `kicked`
LAWS = {
    "plane_quadratic_damping": {"law_z_m": PLANE, "law_plane_quadratic": 2e3},
    "plane_cubic_spring": {"law_z_m": PLANE, "law_plane_cubic": 3e13},
    "plane_speed_damping": {"law_z_m": PLANE, "law_plane_speed": 0.3},
    "plane_third_harmonic": {"law_z_m": PLANE, "law_plane_third": 12.0, "law_plane_third_phase": PHASE},
    "tilt_cubic": {"law_tilt_cubic": 5e9},
    "tilt_drag": {"law_tilt_drag": 5.0},
    "swirl_square": {"law_swirl": 1e5},
    "current_stiffening": {"law_current": 300.0},
}


@pytest.fixture(scope="module")
def simulator(tmp_path_factory) -> driver.Simulator:
    return driver.Simulator(tmp_path_factory.mktemp("independent"))


def pushes(kick=(30, -18, -9, 24), hold=(0, 0, 0, 0), records=12000) -> np.ndarray:
    """Excitation [A], by bearing and axis: a kick, then what holds on."""
    rows = np.tile(np.array(hold, float), (records, 1))
    rows[:KICK] += kick
    return rows


def moved(simulator, law, excitation, spin=SPIN, events=(), **other) -> np.ndarray:
    """Channels of the passive rotor with a law."""
    parameters = {"mass": MASS, "transverse_inertia": TILT, "polar_inertia": POLAR, "z_amb_a": AMB[0],
                  "z_amb_b": AMB[1], "z_sensor_a": SENSOR[0], "z_sensor_b": SENSOR[1], "clearance": 1.0,
                  "ki_force": 1.0, "ks": -SPRING,
                  "gain_ax": 1, "gain_ay": 1, "gain_bx": 1, "gain_by": 1, "control_hz": 1e4, "filter_hz": 1e3,
                  "amplifier_hz": 5e4, "bias_current": 1e6, "max_current": 2e6, **other, **law}
    return simulator.run(parameters, [], [[0.0, spin]], ANGLE, RATE, excitation, events=events, settle=0.0, step=1e-5)


def coordinates(channels) -> np.ndarray:
    """x, y of the centre of gravity, rotations alpha, beta: y(z) = y - z alpha, x(z) = x + z beta."""
    ax, ay, bx, by = channels[:, :4].T
    beta, alpha = (bx - ax) / (SENSOR[1] - SENSOR[0]), -(by - ay) / (SENSOR[1] - SENSOR[0])
    return np.array([ax - SENSOR[0] * beta, ay + SENSOR[0] * alpha, alpha, beta])


def rates(q) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Coordinates with their first and second derivatives, two records less at either end."""
    m2, m1, at, p1, p2 = (q[:, n:q.shape[1] - 4 + n] for n in range(5))
    return at, (m2 - 8 * m1 + 8 * p1 - p2) * RATE / 12, (-m2 + 16 * m1 - 30 * at + 16 * p1 - p2) * RATE ** 2 / 12


def alone(channels) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Times, coordinates, their rates and accelerations after the kick."""
    q, v, a = rates(coordinates(channels)[:, ALONE:])
    return (np.arange(q.shape[1]) + ALONE + 2) / RATE, q, v, a


def at(q, z) -> np.ndarray:
    """x, y at a plane; of rates too."""
    return np.array([q[0] + z * q[3], q[1] - z * q[2]])


def on_rotor(z, force) -> np.ndarray:
    """What a force at a plane is in x, y, alpha, beta."""
    return np.array([force[0], force[1], -z * force[1], z * force[0]])


def turned(p) -> np.ndarray:
    return np.array([-p[1], p[0]])


def size(p) -> np.ndarray:
    return np.hypot(p[0], p[1])


def stated(name, t, q, v, current) -> np.ndarray:
    """Forces in x, y, alpha, beta as doc/blind_sets.md states them."""
    (c,) = [value for key, value in LAWS[name].items() if key != "law_z_m" and not key.endswith("_phase")]
    p, u = at(q, PLANE), at(v, PLANE)
    third = 3 * (ANGLE + SPIN * t) + PHASE
    none = np.zeros_like(q[:2])
    bearings = [(z, at(q, z), current[2 * b:2 * b + 2]) for b, z in enumerate(AMB)]
    return {
        "plane_quadratic_damping": lambda: on_rotor(PLANE, -c * size(u) * u),
        "plane_cubic_spring": lambda: on_rotor(PLANE, -c * size(p) ** 2 * p),
        "plane_speed_damping": lambda: on_rotor(PLANE, -c * abs(SPIN) * u),
        "plane_third_harmonic": lambda: on_rotor(PLANE, c * np.array([np.cos(third), np.sin(third)])),
        "tilt_cubic": lambda: np.concatenate([none, -c * size(q[2:]) ** 2 * q[2:]]),
        "tilt_drag": lambda: np.concatenate([none, -c * size(v[2:]) * v[2:]]),
        "swirl_square": lambda: sum(on_rotor(z, c * SPIN * size(p) * turned(p)) for z, p, _ in bearings),
        "current_stiffening": lambda: sum(on_rotor(z, -c * size(i) ** 2 * p) for z, p, i in bearings),
    }[name]()


def acting(q, v, a, current) -> np.ndarray:
    """Forces that the motion tells of, less those of springs and currents and the gyroscopic moment."""
    inertia = np.array([MASS, MASS, TILT, TILT])[:, None] * a
    inertia[2] += POLAR * SPIN * v[3]
    inertia[3] -= POLAR * SPIN * v[2]
    return inertia - sum(on_rotor(z, current[2 * b:2 * b + 2] - SPRING * at(q, z)) for b, z in enumerate(AMB))


def kicked(simulator, name) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Times, coordinates, rates, and forces that act beside the known ones, with a law."""
    hold = (12, -7, 5, 9) if name == "current_stiffening" else (0, 0, 0, 0)
    channels = moved(simulator, LAWS[name], pushes(hold=hold))
    t, q, v, a = alone(channels)
    current = channels[ALONE + 2:-2, 4:].T
    assert np.allclose(current, np.array(hold)[:, None], atol=1e-9)
    return t, q, v, current, acting(q, v, a, current)


@pytest.mark.parametrize("name", LAWS)
def test_the_motion_tells_of_the_law_as_it_is_stated(simulator, name):
    t, q, v, current, force = kicked(simulator, name)
    law = stated(name, t, q, v, current)
    for rows in (slice(0, 2), slice(2, 4)):
        largest = np.abs(law[rows]).max()
        springs = np.abs(sum(on_rotor(z, SPRING * at(q, z)) for z in AMB)[rows]).max()
        assert largest > 0.01 * springs or largest == 0.0, "the law shows nothing"
        assert np.abs(force[rows] - law[rows]).max() < EXACT * max(largest, springs)


def test_a_law_that_is_a_little_another_is_seen(simulator):
    t, q, v, current, force = kicked(simulator, "plane_speed_damping")
    aside = on_rotor(PLANE + 0.001, -LAWS["plane_speed_damping"]["law_plane_speed"] * SPIN * at(v, PLANE + 0.001))
    assert np.abs(force - aside).max() > 100 * EXACT * np.abs(force).max()


@pytest.mark.parametrize("plane, both", [
    ({"law_plane_quadratic": 2e3}, {"law_quadratic": 1e3}), ({"law_plane_cubic": 3e12}, {"law_cubic": 1.5e12}),
    ({"law_plane_third": 8.0, "law_plane_third_phase": PHASE}, {"law_third": 4.0, "law_third_phase": PHASE})])
def test_a_law_at_a_plane_does_what_both_bearings_do_there(simulator, plane, both):
    there = {"z_amb_a": 0.05, "z_amb_b": 0.05}
    one, other = (moved(simulator, law, pushes(), **there) for law in ({"law_z_m": 0.05, **plane}, both))
    without = moved(simulator, {}, pushes(), **there)
    assert np.abs(without - other)[:, :4].max() > 0.01 * np.abs(without[:, :4]).max()
    assert np.abs(one - other).max() < 1e-9 * np.abs(other[:, :4]).max()


def test_at_currents_that_hold_the_law_of_the_current_is_a_spring(simulator):
    """From the start on, before anything has moved: |i|^2 is the same at both bearings."""
    excitation, hold = pushes(kick=(0, 0, 0, 0), hold=(12, -5, -5, 12)), 169.0
    law = moved(simulator, LAWS["current_stiffening"], excitation)
    springs = moved(simulator, {}, excitation, ks=-SPRING - LAWS["current_stiffening"]["law_current"] * hold)
    assert np.abs(law - springs)[:, :4].max() < 1e-6 * np.abs(springs[:, :4]).max()


def test_a_free_rotor_slows_down_as_the_square_drag_says(simulator):
    """v = v0/(1 + c v0 t/m) of the centre of gravity."""
    kick = np.array([AMB[1], 0, -AMB[0], 0]) * 300
    t, q, v, _ = alone(moved(simulator, {"law_plane_quadratic": 40.0}, pushes(kick=kick), ks=0.0))
    v0 = v[0, 0]
    expected = v0 / (1 + 40.0 * v0 * (t - t[0]) / MASS)
    assert expected[-1] < 0.95 * v0
    assert np.abs(v[0] - expected).max() < EXACT * v0


@pytest.mark.parametrize("spin", [SPIN, -SPIN, 0.0])
def test_damping_with_the_speed_brakes_its_plane_and_leaves_the_centre_of_percussion(simulator, spin):
    """Without springs v there falls by exp(-c |W| t (1/m + z^2/It)), v at -It/(m z) stays."""
    law = LAWS["plane_speed_damping"]
    t, _, v, _ = alone(moved(simulator, law, pushes(), spin=spin, ks=0.0, polar_inertia=0.0))
    decay = law["law_plane_speed"] * abs(spin) * (1 / MASS + PLANE ** 2 / TILT)
    braked, still = at(v, PLANE), at(v, -TILT / (MASS * PLANE))
    expected = braked[:, :1] * np.exp(-decay * (t - t[0]))
    assert np.abs(braked - expected).max() < EXACT * np.abs(braked).max()
    assert np.abs(still - still[:, :1]).max() < EXACT * np.abs(still).max()


def energy(q, v) -> np.ndarray:
    springs = sum(SPRING / 2 * size(at(q, z)) ** 2 for z in AMB)
    return MASS / 2 * size(v) ** 2 + TILT / 2 * size(v[2:]) ** 2 + springs


@pytest.mark.parametrize("name, stored", [
    ("plane_cubic_spring", lambda q: LAWS["plane_cubic_spring"]["law_plane_cubic"] / 4 * size(at(q, PLANE)) ** 4),
    ("tilt_cubic", lambda q: LAWS["tilt_cubic"]["law_tilt_cubic"] / 4 * size(q[2:]) ** 4)])
def test_springs_keep_the_energy(simulator, name, stored):
    _, q, v, _ = alone(moved(simulator, LAWS[name], pushes()))
    total = energy(q, v) + stored(q)
    assert np.ptp(stored(q)) > 0.01 * total[0]
    assert np.ptp(total) < EXACT * total[0]


@pytest.mark.parametrize("name", ["plane_quadratic_damping", "plane_speed_damping", "tilt_drag"])
def test_damping_takes_energy_all_the_time(simulator, name):
    _, q, v, _ = alone(moved(simulator, LAWS[name], pushes()))
    total = energy(q, v)
    power = {"plane_quadratic_damping": lambda c: c * size(at(v, PLANE)) ** 3,
             "plane_speed_damping": lambda c: c * SPIN * size(at(v, PLANE)) ** 2,
             "tilt_drag": lambda c: c * size(v[2:]) ** 3}[name](list(LAWS[name].values())[-1])
    lost = np.concatenate([[0.0], np.cumsum((power[1:] + power[:-1]) / 2 / RATE)])
    assert lost[-1] > 0.1 * total[0]
    assert np.diff(total).max() <= 1e-12 * total[0]
    assert np.abs(total[0] - total - lost).max() < EXACT * total[0]


@pytest.mark.parametrize("sense", [1, -1])
def test_a_swirl_drives_forward_whirl_and_brakes_the_backward_one(simulator, sense):
    """A push that turns at the rotor's own 76 Hz, with the spin or against it; and nothing at standstill."""
    turn = 2 * np.pi * 76 * np.arange(12000) / RATE
    wave = np.array([np.cos(turn), sense * np.sin(turn)]).T * (np.arange(12000) < KICK)[:, None] * 30
    excitation = np.hstack([AMB[1] * wave, -AMB[0] * wave]) / (AMB[1] - AMB[0])
    law = {"law_swirl": LAWS["swirl_square"]["law_swirl"]}
    _, q, v, _ = alone(moved(simulator, law, excitation))
    change = energy(q, v)[-1] / energy(q, v)[0] - 1
    assert change > 0.05 if sense > 0 else change < -0.05
    _, q, v, _ = alone(moved(simulator, law, excitation, spin=0.0))
    assert abs(energy(q, v)[-1] / energy(q, v)[0] - 1) < EXACT


@pytest.mark.parametrize("name", LAWS)
def test_laws_of_the_bearings_end_with_the_bearings(simulator, name):
    off = ALONE + 2000
    channels = moved(simulator, LAWS[name], pushes(hold=(12, -7, 5, 9)), events=[[off / RATE, 0.0]], polar_inertia=0.0)
    _, _, acceleration = rates(coordinates(channels)[:, off + 50:])
    _, _, before = rates(coordinates(channels)[:, ALONE:off])
    free = np.abs(acceleration).max() < 1e-6 * np.abs(before).max()
    assert free == (name in ("swirl_square", "current_stiffening"))


# Laws of what sensors read, name: parameters, what a displacement s at a spin speed W reads
PLAY, CUBIC, LIMIT, GAIN = 2.5e-6, 3e8, 40e-6, 2e-4
SENSED = {
    "sensor_dead_zone": ({"law_sensor_play": PLAY}, lambda s, w: np.where(np.abs(s) < PLAY, 0.0, s - np.sign(s) * PLAY)),
    "sensor_cubic": ({"law_sensor_cubic": CUBIC}, lambda s, w: s + CUBIC * s ** 3),
    "sensor_saturating": ({"law_sensor_limit": LIMIT}, lambda s, w: LIMIT * np.tanh(s / LIMIT)),
    "sensor_speed_gain": ({"law_sensor_speed": GAIN}, lambda s, w: s * (1 + GAIN * abs(w))),
}
NOTHING = {"law_sensor_play": 0.0, "law_sensor_cubic": 0.0, "law_sensor_limit": 0.0, "law_sensor_speed": 0.0}


def test_every_law_of_sensors_is_held_to_something():
    assert set(SENSED) == set(laws.OF_SENSORS) and set(LAWS) == set(laws.APART) - set(SENSED)


@pytest.mark.parametrize("spin", [SPIN, -SPIN, 0.0])
@pytest.mark.parametrize("name", SENSED)
def test_each_sensor_reads_what_the_law_makes_of_its_own_displacement(simulator, name, spin):
    """The passive rotor does not act on what is read: it moves as without the law."""
    law, read = SENSED[name]
    without = moved(simulator, {}, pushes(), spin=spin)
    s = without[:, :4]
    shown = moved(simulator, law, pushes(), spin=spin)
    assert np.abs(shown[:, :4] - read(s, spin)).max() < 1e-12 * np.abs(s).max()
    assert np.array_equal(shown[:, 4:], without[:, 4:])
    change = np.abs(shown[:, :4] - s).max(axis=0)
    assert (change > 0.01 * np.abs(s).max(axis=0)).all() or (name == "sensor_speed_gain" and spin == 0.0 == change.max())


def test_play_shows_nothing_at_all_of_what_is_within_it(simulator):
    s = moved(simulator, {}, pushes())[:, :4]
    shown = moved(simulator, {"law_sensor_play": 1.001 * np.abs(s).max()}, pushes())[:, :4]
    assert np.abs(shown).max() < 1e-12 * np.abs(s).max()


def test_what_a_sensor_does_otherwise_comes_on_top(simulator):
    """Read, then turned, then with runout, then amplified."""
    law, read = SENSED["sensor_cubic"]
    s = read(moved(simulator, {}, pushes())[:, :4], SPIN)
    other = {"angle_b": 0.3, "runout_b1": 4e-6, "runout_b1_phase": 0.2, "gain_bx": 1.1, "gain_by": 0.8}
    shown = moved(simulator, law, pushes(), **other)
    turn = ANGLE + SPIN * np.arange(len(s)) / RATE + 0.2
    bx = 1.1 * (s[:, 2] * np.cos(0.3) + s[:, 3] * np.sin(0.3) + 4e-6 * np.cos(turn))
    by = 0.8 * (s[:, 3] * np.cos(0.3) - s[:, 2] * np.sin(0.3) + 4e-6 * np.sin(turn))
    assert np.abs(shown[:, :4] - np.column_stack([s[:, 0], s[:, 1], bx, by])).max() < 1e-11 * np.abs(s).max()


@pytest.mark.parametrize("name", SENSED)
def test_what_was_sensed_is_got_back_from_what_is_read(simulator, name):
    law, read = SENSED[name]
    s = moved(simulator, {}, pushes())[::10, :4]
    back = laws.displacements(read(s, SPIN), law, np.full(len(s), SPIN))
    seen = read(s, SPIN) != 0
    assert np.abs(back - s)[seen].max() < 1e-9 * np.abs(s).max()
    assert np.abs(back - s).max() <= law.get("law_sensor_play", 1e-12)


# Levitated: springs that push outwards, as magnets do, held by currents from the sensors
KI, KS, KP, KD, LOAD = 137.0, 6e5, 7500.0, 12.0, (4.0, -7.0)


def levitated(simulator, law, excitation=None, records=400, spin=0.0, disturbance=None, offsets=None, **other) -> np.ndarray:
    parameters = {"mass": MASS, "transverse_inertia": TILT, "z_amb_a": -0.09, "z_amb_b": 0.09, "z_sensor_a": -0.09,
                  "z_sensor_b": 0.09, "clearance": 1.0, "ki_force": KI, "ks": KS, "kp": KP, "kd": KD, "load_x": LOAD[0],
                  "load_y": LOAD[1], "gain_ax": 1, "gain_ay": 1, "gain_bx": 1, "gain_by": 1, "control_hz": 2e4,
                  "filter_hz": 3e3, "amplifier_hz": 3e3, "bias_current": 1e3, "max_current": 2e3, "delay": 3e-5,
                  **other, **law}
    return simulator.run(parameters, [], [[0.0, spin]], ANGLE, 1e4, excitation, None if excitation is not None else records,
                         settle=1.0, step=2e-5, disturbance=disturbance, offsets=offsets)


@pytest.mark.parametrize("spin", [0.0, 300.0])
@pytest.mark.parametrize("name", SENSED)
def test_the_controller_holds_a_load_by_what_it_reads(simulator, name, spin):
    """At rest Ki i + Ks s + F/2 = 0 at each end, where i = -kp read(s): of s there is one, beyond the play."""
    law, read = SENSED[name]
    channels = levitated(simulator, law, spin=spin)
    assert np.ptp(channels, axis=0).max() < 1e-9, "it has not come to rest"
    shown, current = channels[-1, :4], channels[-1, 4:]
    assert np.allclose(current, -KP * shown, rtol=1e-9)
    s = -(KI * current + np.tile(LOAD, 2) / 2) / KS
    assert np.allclose(shown, read(s, spin), rtol=1e-8)
    linear = np.tile(LOAD, 2) / 2 / (KI * KP - KS)
    if name == "sensor_dead_zone":
        assert np.allclose(s, linear + np.sign(linear) * KI * KP * PLAY / (KI * KP - KS), rtol=1e-8)
    elif name == "sensor_speed_gain":
        assert np.allclose(s, np.tile(LOAD, 2) / 2 / (KI * KP * (1 + GAIN * spin) - KS), rtol=1e-8)
    else:
        assert (np.abs(s) < np.abs(linear)).all() if name == "sensor_cubic" else (np.abs(s) > np.abs(linear)).all()


def shaken(size_A, records=4000):
    """Excitation [A] along x at 40 Hz."""
    return size_A * np.outer(np.sin(2 * np.pi * 40 * np.arange(records) / 1e4), [1, 0, 1, 0])


@pytest.mark.parametrize("name, slope", [
    ("sensor_dead_zone", lambda s: 1.0), ("sensor_cubic", lambda s: 1 + 3 * CUBIC * s ** 2),
    ("sensor_saturating", lambda s: 1 - np.tanh(s / LIMIT) ** 2), ("sensor_speed_gain", lambda s: 1 + GAIN * 300.0)])
def test_about_its_rest_the_levitated_loop_answers_as_one_of_that_gain(simulator, name, slope):
    """A little shaking on top of the load, against sensors of the gain that the law has there."""
    law, _ = SENSED[name]
    rest = levitated(simulator, law, spin=300.0)[-1]
    s = -(KI * rest[4] + LOAD[0] / 2) / KS
    gain = slope(s)
    answer = levitated(simulator, law, shaken(1e-4), spin=300.0) - rest
    alike = {f"gain_{axis}": gain for axis in driver.AXES}
    still = levitated(simulator, {}, spin=300.0, **alike)[-1]
    expected = levitated(simulator, {}, shaken(1e-4), spin=300.0, **alike) - still
    plain = levitated(simulator, {}, shaken(1e-4), spin=300.0) - levitated(simulator, {}, spin=300.0)[-1]
    for columns in ([0, 2], [4, 6]):
        largest = np.abs(expected[:, columns]).max()
        assert np.abs(answer - expected)[:, columns].max() < 1e-3 * largest
        assert (np.abs(plain - expected)[:, columns].max() > 0.01 * largest) == (name != "sensor_dead_zone")


def test_a_sensor_that_saturates_is_first_one_with_a_cube(simulator):
    """L tanh(s/L) = s - s^3/(3 L^2) + 2 s^5/(15 L^4), s up to L/6."""
    little = {"load_x": 0.0, "load_y": 0.0}
    plain, saturating, cubic = (levitated(simulator, law, shaken(0.02), **little) for law in (
        {}, {"law_sensor_limit": LIMIT}, {"law_sensor_cubic": -1 / (3 * LIMIT ** 2)}))
    assert LIMIT / 10 < np.abs(saturating[:, :4]).max() < LIMIT / 6
    for columns in ([0, 2], [4, 6]):
        law = np.abs(saturating - plain)[:, columns].max()
        assert law > 3e-3 * np.abs(plain[:, columns]).max()
        assert np.abs(saturating - cubic)[:, columns].max() < 0.05 * law


def test_beyond_the_play_the_sensor_is_off_by_it(simulator):
    """What the controller gets moves the same as with offsets of that size, which the recorder does not show."""
    side = np.sign(LOAD * 2)
    play = levitated(simulator, {"law_sensor_play": PLAY}, shaken(0.002))
    off = levitated(simulator, {}, shaken(0.002), offsets=[-PLAY * side, np.zeros(4)])
    assert (np.abs(play[:, :4]) > 0).all() and np.ptp(play[:, 0]) > 0.1 * PLAY
    assert np.allclose(play[:, :4], off[:, :4] - PLAY * side, rtol=0, atol=1e-13)
    assert np.allclose(play[:, 4:], off[:, 4:], rtol=0, atol=1e-8)


@pytest.mark.parametrize("none", [NOTHING, *({key: value} for key, value in NOTHING.items())])
def test_a_law_of_no_size_is_none(simulator, none):
    assert np.array_equal(levitated(simulator, none, shaken(0.5)), levitated(simulator, {}, shaken(0.5)))
    assert np.array_equal(moved(simulator, none, pushes()), moved(simulator, {}, pushes()))


def test_play_is_of_the_rotor_and_not_of_the_noise(simulator):
    """Within the play the currents are those of the noise alone, in full, whatever the rotor does."""
    noise = 1e-8 * np.random.default_rng(3).normal(size=(400, 4))
    held = {"ks": -KS, "load_x": 0.0, "load_y": 0.0, "disturbance": noise}
    hanging = levitated(simulator, {"law_sensor_play": 1e-5}, **held)
    deaf = levitated(simulator, {}, **{**held, "ki_force": 0.0})
    assert np.abs(hanging[:, :4]).max() < 1e-18 and np.abs(deaf[:, 4:]).max() > KP * 1e-8
    assert np.abs(hanging - deaf)[:, 4:].max() < 1e-9 * np.abs(deaf[:, 4:]).max()
