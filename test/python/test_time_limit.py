"""A diagnosis that runs out of time gives what it has, and says what it has not looked at."""
from __future__ import annotations

import pathlib

import pytest

core = pytest.importorskip("amb_rotor._core")

from amb_rotor import cli  # noqa: E402

MEASURED = pathlib.Path(__file__).resolve().parents[2] / "config/tutorial/measured"
CANDIDATES = ["sensor_runout", "cross_coupled_stiffness"]


def diagnosed(time_limit_s: float) -> dict:
    dataset = core.read_dataset(str(MEASURED))
    diagnosis, adopted, rivals = core.diagnose(dataset.belief, dataset, candidates=CANDIDATES, time_limit_s=time_limit_s)
    assert not adopted.faults
    return diagnosis


def test_what_was_not_looked_at_is_said():
    diagnosis = diagnosed(1e-6)
    assert diagnosis["time_limit_reached"]
    assert any("time limit" in remark for remark in diagnosis["remarks"])
    assert diagnosis["steps"] == [] and diagnosis["verdict"] == "unknown"
    assert sorted(row["effect"] for row in diagnosis["ranking"]) == sorted(CANDIDATES)
    assert all("not looked at" in row["note"] and row["evidence"] == 0 for row in diagnosis["ranking"])
    assert diagnosis["baseline"]["validation_error"] > 2.0  # that much is always known


def test_a_limit_that_is_not_reached_changes_nothing():
    without, within = diagnosed(0.0), diagnosed(3600.0)
    assert not within["time_limit_reached"] and not without["time_limit_reached"]
    for diagnosis in (without, within):
        diagnosis.pop("seconds")
    assert within == without
    assert [step["added"] for step in within["steps"]] == ["cross_coupled_stiffness"]


@pytest.mark.parametrize("text", ["nan", "-1", "inf", "soon"])
def test_a_time_limit_is_a_time(text, capsys, tmp_path):
    assert cli.main(["diagnose", str(MEASURED), f"--time-limit={text}", "--out", str(tmp_path / "d")]) == 2
    assert "--time-limit" in capsys.readouterr().err
