"""Set-valued friction at every command that takes a model."""
from __future__ import annotations

import json
import pathlib
import shutil

import numpy
import pytest

from amb_rotor import cli

pytest.importorskip("amb_rotor._core")
ROOT = pathlib.Path(__file__).resolve().parents[2]
THESIS = ROOT / "config" / "thesis"


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


def test_compare_takes_it(model, tmp_path):
    # runs without contact do not feel it; windows through contact: test/validation/set_valued_windows.cpp
    result = []
    for given in (model, THESIS / "bushing_model.yaml"):
        path = tmp_path / f"{given.stem}.json"
        words = ["compare", str(given), str(ROOT / "config" / "tutorial" / "measured"), "--json", str(path)]
        assert cli.main([*words, "--out", str(tmp_path / given.stem)]) == 0
        result.append(json.loads(path.read_text())["error"])
    assert result[0] == pytest.approx(result[1], rel=1e-9)


def test_what_has_no_contact_does_not_ask(model):
    assert cli.main(["check", str(model)]) == 0
    assert cli.main(["modes", str(model)]) == 0
