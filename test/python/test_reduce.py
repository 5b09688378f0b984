"""`amb reduce`: what it prints against a closed form, the error against its bound, and what it refuses."""
from __future__ import annotations

import json
import pathlib

import numpy
import pytest

from amb_rotor import cli
from amb_rotor.cli import reduce as command

pytest.importorskip("amb_rotor._core")
THESIS = pathlib.Path(__file__).resolve().parents[2] / "config" / "thesis"
MODEL = THESIS / "flexible_model.yaml"


def reduced(tmp_path, *words, model=MODEL):
    path = tmp_path / "a.json"
    status = cli.main(["reduce", str(model), "--out", str(tmp_path), "--json", str(path), *words])
    return status, json.loads(path.read_text()) if path.exists() else None


def test_balanced_keeps_its_bound(tmp_path, capsys):
    status, result = reduced(tmp_path, "--order", "8")
    assert status == 0 and result["order"] == 8 < result["states"]
    hankel = numpy.array(result["hankel_m_per_N"])
    assert len(hankel) == result["states"] and (numpy.diff(hankel) <= 0).all()
    assert result["error_bound_m_per_N"] == pytest.approx(2.0 * hankel[8:].sum(), rel=1e-9)
    assert 0.0 < result["largest_error_m_per_N"] <= result["error_bound_m_per_N"]
    assert (tmp_path / "reduction.png").stat().st_size > 10000
    assert capsys.readouterr().out.splitlines()[-1] == f"report: {tmp_path / 'reduction.png'}"


def test_before_at_low_frequency_is_the_rigid_body_on_two_springs(tmp_path):
    # force at a bearing (z = -l), displacement at a sensor z: (1 - z/l)/(2 k) for a rigid beam on springs k at +-l
    _, result = reduced(tmp_path, "--order", "8")
    k, l, z = 19.0 * 33458.0 - 39700.0, 0.096, (-0.118, 0.118)
    lowest = numpy.array(result["before_m_per_N"])[0]
    for sensor in range(2):
        # 1 Hz is 1e-4 of the square of the first mode's 94 Hz; the shaft itself bends under 1 % of the springs
        assert lowest[sensor][0] == pytest.approx(abs(1.0 - z[sensor] / l) / (2.0 * k), abs=0.01 / k)


def test_without_an_order_it_takes_the_fewest_states_within_the_error(tmp_path):
    _, result = reduced(tmp_path, "--error", "0.05")
    gain = numpy.max(result["before_m_per_N"])
    hankel = numpy.array(result["hankel_m_per_N"])
    order = result["order"]
    assert 2.0 * hankel[order:].sum() <= 0.05 * gain < 2.0 * hankel[order - 1:].sum()
    assert result["largest_error_share"] <= 0.05


def test_fewest_states_are_counted_in_steps():
    hankel = numpy.array([4.0, 2.0, 1.0, 0.5])
    assert command.fewest_states(hankel, 10.0, 0.31, 1) == 2  # 2 (1 + 0.5) = 3 of 10
    assert command.fewest_states(hankel, 10.0, 0.29, 1) == 3
    assert command.fewest_states(hankel, 10.0, 0.29, 2) == 4


def test_modal_keeps_the_lowest_modes(tmp_path):
    status, result = reduced(tmp_path, "--method", "modal", "--order", "6")
    assert status == 0 and result["order"] == 6 and result["error_bound_m_per_N"] is None
    before, after = numpy.array(result["before_m_per_N"]), numpy.array(result["after_m_per_N"])
    low = numpy.array(result["frequency_hz"]) < 200.0
    # two rigid modes and the first bending mode: what the others add is their static flexibility
    assert numpy.abs(after[low] - before[low]).max() < 0.01 * before.max()


def test_balanced_rotor_is_what_runs_take(tmp_path, capsys):
    status, result = reduced(tmp_path, "--method", "balanced_rotor", "--order", "12")
    assert status == 0 and result["order"] == 12 and result["error_bound_m_per_N"] is None
    said = capsys.readouterr().out
    assert "rotor.reduction: {method: balanced, modes: 6}" in said
    position = numpy.array(result["position_m_per_N"])
    assert (numpy.diff(position) <= 0).all() and (position > 0).all()
    # what is cut first rings at most twice its singular value on the free rotor; the bearings add damping
    assert result["largest_error_m_per_N"] < 3.0 * position[4:].sum()


@pytest.mark.parametrize("words", [("--order", "0"), ("--order", "7", "--method", "balanced_rotor"), ("--order", "7", "--method", "modal"), ("--order", "100000"),
                                   ("--error", "-1"), ("--to", "0.5")])
def test_bad_arguments_are_refused(tmp_path, words, capsys):
    assert reduced(tmp_path, *words)[0] == 2
    assert words[0] in capsys.readouterr().err


def test_a_rigid_rotor_is_refused(tmp_path, capsys):
    assert reduced(tmp_path, "--order", "4", model=THESIS / "levitation_model.yaml")[0] == 2
    assert "rotor.model" in capsys.readouterr().err


def test_a_reduction_that_the_model_states_is_not_applied_and_that_is_said(tmp_path, capsys):
    plain, words = reduced(tmp_path, "--order", "8")[1], "rotor.reduction of the model (craig_bampton, 6 modes) is not applied"
    assert words not in capsys.readouterr().out and plain["model_reduction"] is None
    stated = f"geometry: {THESIS / 'rotor.yaml'}, reduction: {{method: craig_bampton, modes: 6}}"
    own = tmp_path / "own.yaml"
    own.write_text(MODEL.read_text().replace("geometry: rotor.yaml", stated))
    status, result = reduced(tmp_path, "--order", "8", model=own)
    assert status == 0 and words in capsys.readouterr().out and result["model_reduction"] == "craig_bampton, 6 modes"
    assert result["states"] == plain["states"] and result["hankel_m_per_N"] == plain["hankel_m_per_N"]
