"""Set-valued friction at every command that takes a model: it runs, or one message says what else there is."""
from __future__ import annotations

import pathlib
import shutil

import numpy
import pytest

from amb_rotor import cli

pytest.importorskip("amb_rotor._core")
ROOT = pathlib.Path(__file__).resolve().parents[2]
THESIS = ROOT / "config" / "thesis"
KEY = "rig.auxiliary_bearing.friction_law"


@pytest.fixture
def model(tmp_path):
    path = tmp_path / "stick_model.yaml"
    text = (THESIS / "bushing_model.yaml").read_text()
    path.write_text(text.replace("    mount: rigid\n", "    friction_law: set_valued\n    mount: rigid\n"))
    return path


def test_simulate_takes_it(model, tmp_path):
    out = tmp_path / "run.npz"
    assert cli.main(["simulate", str(model), "--scenario", str(THESIS / "bushing.yaml"), "--out", str(out)]) == 0
    run = numpy.load(out)
    late = run["t_s"] > 2.75
    # stopped for good: regularised friction would creep on
    assert (run["normal_a_N"][late] > 0).all() and numpy.abs(run["slip_a_m_s"][late]).max() < 1e-6


def test_drop_maps_take_it(model, tmp_path, capsys):
    text = (THESIS / "drop_map_40_hz.yaml").read_text()
    sweep = tmp_path / "map.yaml"
    shutil.copy(THESIS / "drop_40_hz.yaml", tmp_path)
    sweep.write_text(text[:text.index("grid:")].replace("drop_model.yaml", model.name)
                     + "grid:\n  rig.auxiliary_bearing.friction_coefficient: [0.01]\n"
                       "  rig.auxiliary_bearing.contact.damping_N_s_per_m: [1000.0, 3000.0]\n")
    assert cli.main(["sweep", str(sweep), "--out", str(tmp_path / "map")]) == 0, capsys.readouterr().err


@pytest.mark.parametrize("command", ["compare", "diagnose"])
def test_what_predicts_in_lanes_refuses_it_and_names_the_alternative(command, model, tmp_path, capsys):
    data = str(ROOT / "config" / "tutorial" / "measured")
    words = ["compare", str(model), data] if command == "compare" else ["diagnose", data, "--model", str(model)]
    assert cli.main([*words, "--out", str(tmp_path / "out")]) == 2
    said = capsys.readouterr().err
    assert said.count(KEY) == 1 and "must be regularised" in said and "0.01 m/s" in said and "amb simulate" in said
    assert not (tmp_path / "out").exists()


def test_a_data_sets_own_rig_is_refused_alike(tmp_path, capsys):
    folder = tmp_path / "set"
    shutil.copytree(ROOT / "test" / "data" / "dataset_tiny", folder)
    text = (folder / "dataset.yaml").read_text()
    (folder / "dataset.yaml").write_text(text.replace("mount: rigid}", "mount: rigid, friction_law: set_valued}"))
    assert cli.main(["diagnose", str(folder), "--out", str(tmp_path / "out")]) == 2
    assert KEY in capsys.readouterr().err


def test_what_has_no_contact_does_not_ask(model):
    assert cli.main(["check", str(model)]) == 0
    assert cli.main(["modes", str(model)]) == 0
