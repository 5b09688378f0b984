"""amb identify: modes, k1, d1, Ki and Ks of simulated runs against the machine's own, and on the tutorial's set."""
from __future__ import annotations

import json
import math
import pathlib

import pytest

numpy = pytest.importorskip("numpy")
core = pytest.importorskip("amb_rotor._core")

from amb_rotor import cli, identify, modal  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]
START, LENGTH, AMPLITUDE = 0.05, 1.5, 0.2


@pytest.fixture(scope="module")
def model():
    return core.read_model(str(ROOT / "config/thesis/levitation_model.yaml")).with_overrides(
        ["rig.gravity_m_s2=0", "rig.unbalance.0.moment_kg_m=0"])


def table(model, kind, folder):
    """A run of the machine as a measured table, with the excitation as its controller holds it."""
    waveform = f"duration_s: {LENGTH}, start_hz: 5.0, end_hz: 500.0" if kind == "chirp" else "duration_s: 0.0"
    path = folder / f"{kind}.yaml"
    path.write_text(f"format: amb-scenario/1\nname: {kind}\nduration_s: {1.8 if kind == 'chirp' else 0.5}\n"
                    "record_rate_hz: 10000.0\nspeed: {type: constant, start_hz: 0.0, initial_angle_rad: 0.0}\nexcitations:\n"
                    f"  - {{type: current, waveform: {kind}, end: a, axis: x, amplitude_A: {AMPLITUDE}, start_s: {START}, "
                    f"{waveform}}}\nfaults: []\nstart: settled\n")
    result = core.simulate(model, core.read_scenario(str(path)))
    assert result["status"] == "ok" and not any(numpy.any(result["columns"][f"normal_{end}_N"]) for end in "ab")
    columns = {name: numpy.asarray(column) for name, column in result["columns"].items()}
    t = columns["t_s"]
    u = numpy.floor(t * 5000.0 + 1e-6) / 5000.0 - START
    on = (t >= START - 1e-9) & ((t < START + LENGTH - 1e-9) | (kind == "step"))
    wave = numpy.sin(2 * math.pi * (5.0 * u + 0.5 * 495.0 * u ** 2 / LENGTH)) if kind == "chirp" else 1.0
    columns["exc_ax_A"], columns["exc_bx_A"] = numpy.where(on, AMPLITUDE * wave, 0.0), numpy.zeros_like(t)
    return columns


@pytest.mark.parametrize("kind", ["chirp", "step"])
def test_a_run_without_noise_has_the_machines_modes_and_magnets(model, kind, tmp_path):
    rig = identify.rig_of(model.fields)
    found, magnet = identify.axis_of(table(model, kind, tmp_path), rig, "x", kind == "step")
    wanted = modal.modes(model, 0.0)[::2]  # x and y are alike
    assert [mode.together for mode in found] == [True, False]
    for mode, one in zip(found, wanted):
        # a rational function of order 6 for a delay and a hold: 1e-4 in the band
        assert mode.frequency_hz == pytest.approx(one.frequency_hz, rel=5e-4)
        assert mode.damping_ratio == pytest.approx(one.damping_ratio, rel=2e-3)
    # currents between two samples of the record are no straight lines: 1e-3
    assert magnet.current_stiffness_N_per_A == pytest.approx(19.0, rel=2e-3)
    assert magnet.displacement_stiffness_N_per_m == pytest.approx(39700.0, rel=3e-3)
    # nothing of this was read off the belief: other magnets are found as other magnets
    strong = model.with_overrides(["rig.amb.current_stiffness_N_per_A=21.0", "rig.amb.displacement_stiffness_N_per_m=45000"])
    other = identify.axis_of(table(strong, kind, tmp_path), rig, "x", kind == "step")[1]
    assert other.current_stiffness_N_per_A == pytest.approx(21.0, rel=2e-3)
    assert other.displacement_stiffness_N_per_m == pytest.approx(45000.0, rel=3e-3)


def test_noise_is_within_what_is_told(model, tmp_path):
    clean, random = table(model, "chirp", tmp_path), numpy.random.default_rng(0)
    rig, wanted, errors, told = identify.rig_of(model.fields), modal.modes(model, 0.0)[::2], [], []
    for _ in range(6):
        noisy = dict(clean)
        for end in "ab":
            noisy[f"{end}x_m"] = clean[f"{end}x_m"] + 3e-7 * random.standard_normal(len(clean["t_s"]))
            noisy[f"i{end}x_A"] = clean[f"i{end}x_A"] + 3e-3 * random.standard_normal(len(clean["t_s"]))
        modes, magnet = identify.axis_of(noisy, rig, "x", False)
        assert [mode.together for mode in modes] == [True, False]
        for mode, one in zip(modes, wanted):
            errors += [mode.frequency_hz - one.frequency_hz, mode.damping_ratio - one.damping_ratio]
            told += [mode.frequency_std_hz, mode.damping_ratio_std]
        errors += [magnet.current_stiffness_N_per_A - 19.0, magnet.displacement_stiffness_N_per_m - 39700.0]
        told += [magnet.current_stiffness_std, magnet.displacement_stiffness_std]
        assert magnet.current_stiffness_std < 0.02 * 19.0 and magnet.displacement_stiffness_std < 0.05 * 39700.0
    shares = numpy.abs(errors) / numpy.array(told)
    assert shares.max() < 4.0 and 0.1 < numpy.sqrt(numpy.mean(shares ** 2)) < 2.0


def test_chirps_and_steps_of_the_tutorial_agree(tmp_path, capsys):
    found = {}
    for method in ("frf", "step"):
        out = tmp_path / f"{method}.json"
        assert cli.main(["identify", method, str(ROOT / "config/tutorial/measured"), "--json", str(out)]) == 0
        found[method] = json.loads(out.read_text())
    for one, two in zip(found["frf"]["modes"], found["step"]["modes"]):
        for key in ("frequency_hz", "damping_ratio"):
            deviation = math.hypot(one[key.replace("_hz", "_std_hz") if "hz" in key else key + "_std"],
                                   two[key.replace("_hz", "_std_hz") if "hz" in key else key + "_std"])
            assert abs(one[key] - two[key]) < 4.0 * deviation, key
    first = found["frf"]["modes"][0]
    w = 2 * math.pi * first["frequency_hz"]
    assert found["frf"]["k1_N_per_m"] == pytest.approx(0.5 * 2.486 * w ** 2)
    assert found["frf"]["d1_N_s_per_m"] == pytest.approx(2.486 * first["damping_ratio"] * w)
    assert "believed 139.3" in capsys.readouterr().out


def test_a_set_without_such_runs_or_channels_is_named(capsys):
    assert cli.main(["identify", "frf", str(ROOT / "test/data/dataset_tiny")]) == 2
    assert "no chirp at standstill" in capsys.readouterr().err
    assert cli.main(["identify", "step", str(ROOT / "test/data/dataset_tiny")]) == 2
    assert "the run has no bx_m, ibx_A" in capsys.readouterr().err
