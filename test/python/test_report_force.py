"""The missing force out of a residual: against laws that are put into it."""
from __future__ import annotations

import types

import numpy
import pytest

from amb_rotor.report import force

RATE, SECONDS = 10000.0, 1.0
M, I, P, KI, KS, ZA, ZB = 4.0, 0.03, 0.002, 80.0, 2e5, -0.09, 0.11
SENSORS = (-0.1, 0.13)
TIME = numpy.arange(int(RATE * SECONDS)) / RATE
FIELDS = {"rig.rotor.mass_kg": M, "rig.rotor.transverse_inertia_kg_m2": I, "rig.rotor.polar_inertia_kg_m2": P,
          "rig.amb.current_stiffness_N_per_A": KI, "rig.amb.displacement_stiffness_N_per_m": KS,
          "rig.planes.amb.a": ZA, "rig.planes.amb.b": ZB, "rig.planes.sensor.a": SENSORS[0], "rig.planes.sensor.b": SENSORS[1]}
MODEL = types.SimpleNamespace(amb_model="linear", fields=FIELDS)
# Parabolas over 2.5 ms flatten second derivatives of a sine of 60 Hz by (2 pi 60 * 2.5e-3)^2/56 = 1.6 %, of one of
# 120 Hz by 6 %; the stiffness part is flattened less.
FLATTENED = 0.04


def run_of(centre, tilt, currents, speed=300.0, kind="steady"):
    """A run whose prediction is 0: the residual is all there is. centre, tilt: (x, y); currents: four."""
    measured = numpy.zeros((len(TIME), 8))
    for end, z in enumerate(SENSORS):
        for axis in (0, 1):
            measured[:, 2 * end + axis] = centre[axis] + z * tilt[axis]
            measured[:, 4 + 2 * end + axis] = currents[2 * end + axis]
    return {"measured": measured, "predicted": numpy.zeros_like(measured), "noise": [1e-6] * 4 + [1e-3] * 4, "kind": kind,
            "sample_rate_hz": RATE, "angle_rad": speed * TIME, "speed_rad_s": numpy.full(len(TIME), speed)}


def spring_run(stiffness, kind="steady"):
    """A rotor that turns in circles about its bearings under -stiffness p at each end and what the bearings do."""
    w = 2 * numpy.pi * 60.0
    centre = 2e-5 * numpy.array([numpy.cos(w * TIME), numpy.sin(w * TIME)])
    # Ki d = m z''/2 - Ks z - f with f = -stiffness z, at each end alike where the ends are alike
    current = (-0.5 * M * w * w - KS + stiffness) * centre / KI
    return run_of(centre, (0.0 * TIME, 0.0 * TIME), [current[0], current[1], current[0], current[1]], kind=kind)


@pytest.fixture
def symmetric(monkeypatch):
    monkeypatch.setitem(FIELDS, "rig.planes.amb.a", -ZB)


def test_a_spring_is_a_force_along_the_position(symmetric):
    found = force.missing_force(spring_run(3e5), MODEL)
    for end in (0, 1):
        along, across = force.parts_along(found["force"][end], found["position"][end])
        assert along == pytest.approx(-3e5 * 2e-5, rel=FLATTENED)
        assert abs(across).max() < 1e-6
    assert found["angle"] is not None


def test_no_force_is_missing_where_the_equations_hold(symmetric):
    found = force.missing_force(spring_run(0.0), MODEL)
    assert abs(found["force"]).max() < FLATTENED * M * (2 * numpy.pi * 60.0) ** 2 * 2e-5


def test_both_ends_and_the_gyroscopic_moment_are_told_apart():
    """f_a along x alone on a free rotor: the centre by f/m, the tilt by f z_a/I, with the gyroscopic moment beside it."""
    w, speed = 2 * numpy.pi * 30.0, 300.0
    f = 5.0 * numpy.cos(w * TIME)
    # steady state of I t_x'' + P W t_y' = z_a f, I t_y'' - P W t_x' = 0
    matrix = numpy.array([[-I * w * w, 1j * w * P * speed], [-1j * w * P * speed, -I * w * w]])
    tilt = numpy.linalg.solve(matrix, [ZA * 5.0, 0.0])
    wave = numpy.exp(1j * w * TIME)
    centre_x = -f / (M * w * w)
    tilts = [(part * wave).real for part in tilt]
    # the bearings' own forces are balanced by the currents
    currents = [-KS * value / KI for z in (ZA, ZB) for value in (centre_x + z * tilts[0], z * tilts[1])]
    found = force.missing_force(run_of((centre_x, 0.0 * TIME), tilts, currents, speed), MODEL)
    half = (len(TIME) - found["force"].shape[2]) // 2
    inner = slice(half, len(TIME) - half)
    assert numpy.abs(found["force"][0, 0] - f[inner]).max() < FLATTENED * 5.0
    for end, axis in ((0, 1), (1, 0), (1, 1)):
        assert numpy.abs(found["force"][end, axis]).max() < FLATTENED * 5.0


def test_the_maps_show_the_law(symmetric):
    maps = force.force_maps([spring_run(3e5), spring_run(9e5, kind="rub")], MODEL)  # contact does not count
    for end in maps:
        values = [v for row in end["position"]["along"] for v in row if v is not None]
        assert values and numpy.mean(values) == pytest.approx(-6.0, rel=FLATTENED)
        assert all(abs(v) < 1e-3 for row in end["position"]["across"] for v in row if v is not None)
        # on a circle the velocity is a quarter turn ahead of the position: the force across it, backwards
        values = [v for row in end["velocity"]["across"] for v in row if v is not None]
        assert numpy.mean(values) == pytest.approx(6.0, rel=FLATTENED)
        assert len(end["angle"]["x"]) == force.ANGLE_BINS


def test_what_cannot_be_told_is_left_out():
    run = spring_run(1e5)
    assert force.missing_force(run, types.SimpleNamespace(amb_model="equivalent", fields=FIELDS)) is None
    run["noise"][5] = 0.0
    assert force.missing_force(run, MODEL) is None
    assert force.force_maps([run], MODEL) == [None, None]
