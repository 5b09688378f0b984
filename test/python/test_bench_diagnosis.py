"""The judge of `amb bench-diagnosis`, and the blind sets of the independent program that it can be given."""
from __future__ import annotations

import functools
import json
import math
import pathlib
import shutil
import signal
import subprocess
import sys
import time

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "test/independent"))

import blind  # noqa: E402
import driver  # noqa: E402

_core = pytest.importorskip("amb_rotor._core")
from amb_rotor import yaml_file  # noqa: E402
from amb_rotor.cli import main  # noqa: E402
from amb_rotor.cli import bench_diagnosis  # noqa: E402
from amb_rotor.errors import InputError  # noqa: E402

TRUTH = """format: amb-truth/1
effects: [{effect: shaft_crack, parameters: {relative_depth: {value: 0.1, unit: '1'}, phase_rad: {value: 3.1, unit: rad}}}]
nuisance: {}
floor: {steady_1: 1.02, drop_1: 70.0}
"""


def diagnosis(added="shaft_crack", phase=-3.1):
    errors = {"validation_error": 1.0, "validation_error_free": 1.0, "validation_error_contact": None}
    parameters = {"relative_depth": {"value": 0.11, "std": 0.005}, "phase_rad": {"value": phase, "std": 0.05}}
    return {"verdict": "effect", "ranking": [{"effect": added, "confounded_with": []}], "seconds": 1.0,
            "steps": [{"added": added, "parameters": parameters, **errors}], "baseline": errors,
            "unexplained": {"depends_on": []}}


def test_a_hit_is_counted_with_its_errors_over_the_stated_deviation(tmp_path):
    (tmp_path / "truth.yaml").write_text(TRUTH)
    row = bench_diagnosis.judge(bench_diagnosis.truth_of(tmp_path / "truth.yaml"), diagnosis())
    assert row["first"] and row["all"] and row["near"]
    assert row["errors"]["shaft_crack.relative_depth"] == pytest.approx(2.0)
    assert row["errors"]["shaft_crack.phase_rad"] == pytest.approx((2 * math.pi - 6.2) / 0.05)  # round the turn
    assert row["floor"] == 1.02  # of runs without contact
    table = bench_diagnosis.summary([{"set": 0, **row}])
    assert table["single: first"] == {"count": 1, "share": 1.0}  # without a stated difference it counts


def test_right_effects_that_leave_structure_are_no_hit(tmp_path):
    (tmp_path / "truth.yaml").write_text(TRUTH)
    row = bench_diagnosis.judge(bench_diagnosis.truth_of(tmp_path / "truth.yaml"), {**diagnosis(), "verdict": "unknown"})
    assert row["first"] and not row["all"]


def test_cross_coupling_is_compared_at_one_speed():
    true = {"stiffness_N_per_m": 1000.0, "reference_speed_hz": 80.0, "speed_exponent": 1.5}
    stated = 1000.0 * (100.0 / 80.0) ** 1.5
    found = {"stiffness_N_per_m": {"value": stated, "std": 0.01 * stated}, "reference_speed_hz": {"value": 100.0, "std": 0.0},
             "speed_exponent": {"value": 1.5, "std": 0.1}}
    assert bench_diagnosis._errors_of("cross_coupled_stiffness", true, found)["stiffness_N_per_m"] == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("effect, true, other", [
    ("shaft_bow", {"bow_a_m": 2e-6, "bow_b_m": -1e-6, "phase_rad": 0.4}, {"bow_a_m": -2e-6, "bow_b_m": 1e-6, "phase_rad": 0.4 - math.pi}),
    ("shaft_flexibility", {"frequency_hz": 200.0, "shape_amb_a": 0.5, "shape_unbalance": -0.4},
     {"frequency_hz": 200.0, "shape_amb_a": -0.5, "shape_unbalance": 0.4})])
def test_one_machine_said_in_two_ways_is_one(effect, true, other):
    deviation = {name: 0.01 * abs(value) for name, value in true.items()}
    for said in (true, other):
        found = {name: {"value": value, "std": deviation[name]} for name, value in said.items()}
        assert max(map(abs, bench_diagnosis._errors_of(effect, true, found).values())) < 1e-9
    half = {name: {"value": (true if name == "shape_amb_a" or name == "bow_a_m" else other)[name], "std": deviation[name]} for name in true}
    assert max(map(abs, bench_diagnosis._errors_of(effect, true, half).values())) > 100.0


def test_a_miss_is_counted(tmp_path):
    (tmp_path / "truth.yaml").write_text(TRUTH)
    row = bench_diagnosis.judge(bench_diagnosis.truth_of(tmp_path / "truth.yaml"), diagnosis("shaft_bow"))
    assert not (row["first"] or row["all"] or row["near"] or row["errors"])


@pytest.mark.parametrize("text, word", [
    ("format: amb-truth/2\n", "amb-truth/1"), ("format: [\n", "truth.yaml"), ("[]\n", "amb-truth/1"),
    ("format: amb-truth/1\n", "effects"), ("format: amb-truth/1\neffects: [{effect: a, parameters: {b: 1}}]\n", "truth.yaml")])
def test_a_bad_truth_is_named(text, word, tmp_path):
    (tmp_path / "truth.yaml").write_text(text)
    with pytest.raises(InputError, match=word):
        bench_diagnosis.truth_of(tmp_path / "truth.yaml")


def test_a_folder_without_sets_is_refused_and_nothing_kept(tmp_path, capsys):
    assert main(["bench-diagnosis", "--data", str(tmp_path), "--keep", str(tmp_path / "kept")]) != 0
    assert "truth.yaml" in capsys.readouterr().err
    assert not (tmp_path / "kept").exists()


def test_with_contact_every_set_has_rubs_and_drops(tmp_path, capsys):
    folder = tmp_path / "set-0000"
    folder.mkdir()
    (folder / "diagnosis.json").write_text(json.dumps(diagnosis()))  # only the set is made
    hidden = bench_diagnosis.hidden_in(0, 1, _core)
    row = bench_diagnosis.one_set(0, 1, True, folder, 1, 1.0, _core)
    assert row["hidden"] == hidden and "failure" not in row
    kinds = {run["kind"] for run in yaml_file.read(folder / "dataset.yaml")["runs"]}
    assert {"rub", "drop"} <= kinds
    assert not {schema["id"] for schema in _core.effect_catalogue() if schema["needs_contact"]} & set(hidden), "it has them anyway"
    assert main(["bench-diagnosis", "--data", str(tmp_path), "--contact"]) != 0
    assert "--contact" in capsys.readouterr().err


@pytest.mark.parametrize("signum", [signal.SIGTERM, signal.SIGINT])
def test_an_interrupted_bench_ends_at_once_and_keeps_what_is_finished(signum, tmp_path):
    data, keep, out = (tmp_path / name for name in ("data", "kept", "out"))
    for name in ("done", "endless"):
        shutil.copytree(ROOT / "config/tutorial/measured", data / name)
        (data / name / "truth.yaml").write_text(TRUTH)
    (keep / "done").mkdir(parents=True)
    (keep / "done" / "diagnosis.json").write_text(json.dumps(diagnosis()))
    command = [sys.executable, "-P", "-m", "amb_rotor", "bench-diagnosis", "--data", str(data), "--keep", str(keep),
               "--out", str(out)]
    # a shell's background jobs ignore Ctrl-C, and their children would
    heeding = functools.partial(signal.signal, signal.SIGINT, signal.SIG_DFL)
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, preexec_fn=heeding) as process:
        time.sleep(4.0)  # a whole diagnosis takes longer
        assert process.poll() is None
        process.send_signal(signum)
        message = process.communicate(timeout=60.0)[1]  # left alone both sets would be done
    assert process.returncode == 128 + signum and "1 of 2 sets are done" in message and "Traceback" not in message
    assert [row["set"] for row in json.loads((out / "bench_diagnosis.json").read_text())["rows"]] == ["done"]
    left = sorted(str(path.relative_to(keep)) for path in keep.rglob("*") if path.is_file())
    assert left == ["bench.json", "done/diagnosis.json"]


def test_a_round_of_the_independent_program_hides_everything_once():
    hidden = [blind.hidden_in(index, 1) for index in range(blind.ROUND)]
    effects = sorted(name for kind, names in hidden if kind == "effect" for name in names)
    assert effects == sorted(schema["id"] for schema in _core.effect_catalogue() if not schema["only_by_name"])
    assert [kind for kind, _ in hidden].count("none") == blind.CLEAN
    assert sorted(names[0] for kind, names in hidden if kind == "unknown") == sorted(blind.LAWS)
    assert all(len(set(names)) == 2 for kind, names in hidden if kind == "pair")


@pytest.mark.skipif(shutil.which("g++") is None, reason="no compiler")
def test_a_blind_set_of_the_independent_program_is_diagnosed_and_judged(tmp_path, capsys):
    index = blind.FREE.index("sensor_runout")
    data = tmp_path / "data"
    data.mkdir()
    blind.make_set(3, index, driver.Simulator(tmp_path), data / "set")
    assert "runout" not in (data / "set" / "dataset.yaml").read_text()
    keep, out = tmp_path / "kept", tmp_path / "out"
    command = ["bench-diagnosis", "--data", str(data), "--keep", str(keep), "--out", str(out)]
    assert main(command) == 0
    row = json.loads((out / "bench_diagnosis.json").read_text())["rows"][0]
    assert row["hidden"] == ["sensor_runout"] and row["first"] and row["all"]
    assert row["validation_error_free"] < 1.15
    assert max(abs(error) for error in row["errors"].values()) < 5.0  # eight of them
    before = (keep / "set" / "diagnosis.json").stat().st_mtime
    assert main(command) == 0
    assert (keep / "set" / "diagnosis.json").stat().st_mtime == before  # not done again
