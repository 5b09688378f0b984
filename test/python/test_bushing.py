"""A plain bushing: friction slides to the end and stops the rotor as Coulomb's law says; a ring is brought up to speed."""
from __future__ import annotations

import pathlib

import numpy
import pytest

from amb_rotor import cli

pytest.importorskip("amb_rotor._core")
THESIS = pathlib.Path(__file__).resolve().parents[2] / "config" / "thesis"
MASS, GRAVITY, FRICTION, RADIUS, INERTIA, CLEARANCE = 3.36, 9.81, 0.15, 0.010, 0.001, 3e-4


def simulated(tmp_path, model):
    assert cli.main(["simulate", str(model), "--scenario", str(THESIS / "bushing.yaml"), "--out", str(tmp_path / "b.npz")]) == 0
    return numpy.load(tmp_path / "b.npz")


def test_a_lying_rotor_is_stopped_by_its_bushings(tmp_path):
    run = simulated(tmp_path, THESIS / "bushing_model.yaml")
    time, speed = run["t_s"], 2 * numpy.pi * run["speed_Hz"]
    lies = (time > 0.5) & (time < 2.0)
    assert (run["normal_a_N"][lies] > 0).all() and (run["normal_b_N"][lies] > 0).all()
    # m g = N sqrt(1 + mu^2): it leans until normal force and friction carry the weight together. About that it swings on
    # at the bottom, by the angle a, as sliding friction has one direction: N = m g cos + m v^2/r is 1 + a^2/4 of it in the mean
    swing = numpy.sqrt(2) * numpy.std(run["aux_ax_m"][lies]) / CLEARANCE
    assert 0.2 < swing < 0.4
    slope = -FRICTION * MASS * GRAVITY * RADIUS / (INERTIA * numpy.sqrt(1 + FRICTION ** 2)) * (1 + swing ** 2 / 4)
    assert numpy.polyfit(time[lies], speed[lies], 1)[0] == pytest.approx(slope, rel=5e-3)  # the fourth power of a, part swings
    assert numpy.mean(run["slip_a_m_s"][lies]) == pytest.approx(RADIUS * speed[lies].mean(), rel=1e-2)
    assert (run["ring_speed_a_rad_s"] == 0).all()


def test_a_ball_bearing_in_its_place_lets_it_turn_on(tmp_path):
    text = (THESIS / "bushing_model.yaml").read_text()
    model = tmp_path / "ball.yaml"
    ring = "effects:\n  - {effect: inner_ring_spin, parameters: {inertia_kg_m2: 1.0e-5, drag_torque_N_m: 0.002}}\n"
    model.write_text(text.replace("effects: []\n", ring))
    run = simulated(tmp_path, model)
    time, speed, ring_speed = run["t_s"], 2 * numpy.pi * run["speed_Hz"], run["ring_speed_a_rad_s"]
    lies = (time > 0.5) & (time < 2.0)
    assert ring_speed[lies].mean() == pytest.approx(speed[lies].mean() * RADIUS / (RADIUS + 3e-4), rel=2e-2)
    # only the drag of both rings brakes it
    assert numpy.polyfit(time[lies], speed[lies], 1)[0] == pytest.approx(-2 * 0.002 / (INERTIA + 2e-5), rel=0.05)
