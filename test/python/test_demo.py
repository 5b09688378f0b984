"""The demonstration, without the node graph (that has its tests in test/ros)."""
from __future__ import annotations

import json
import pathlib

import pytest
from conftest import fewer_runs

numpy = pytest.importorskip("numpy")
pytest.importorskip("amb_rotor._core")

from amb_rotor import cli  # noqa: E402
from amb_rotor.cli import demo  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]


def test_the_demonstration_without_ros_says_so_and_goes_through(tmp_path, monkeypatch, capsys):
    share = tmp_path / "share" / "config"
    fewer_runs(ROOT / "config/tutorial/measured", ("chirp_1", "steady_2", "steady_3", "chirp_4", "steady_4", "coast_down_2"),
               share / "tutorial/measured")
    (share / "thesis").symlink_to(ROOT / "config/thesis")
    (share / "tutorial/demo.yaml").symlink_to(ROOT / "config/tutorial/demo.yaml")
    monkeypatch.setattr("amb_rotor.paths.share_folder", lambda: share.parent)
    monkeypatch.setattr(demo, "why_no_graph", lambda: "no ROS here")
    monkeypatch.setattr(demo, "CANDIDATES", ["cross_coupled_stiffness"])
    out = tmp_path / "demo"
    assert cli.main(["demo", "--out", str(out), "--json", str(tmp_path / "d.json")]) == 0
    printed = capsys.readouterr().out
    assert "skipped: no ROS here" in printed and printed.splitlines()[-1] == f"report: {out / 'report.html'}"
    result = json.loads((tmp_path / "d.json").read_text())
    assert result["steps"] == ["cross_coupled_stiffness"]
    assert result["error_before"] > 2.0 and result["error_after"] < 1.05
    for name in ("orbit.png", "poincare.png", "spectrum.png", "model.yaml", "revisions.yaml", "report.html",
                 "diagnosis/diagnosis.json"):
        assert (out / name).stat().st_size > 0
    assert (out / "report.html").read_text().count("<figure><img alt=") == 3


def test_the_pictures_show_what_they_say(tmp_path):
    """The orbit's colours: red where the rotor touches, and only then."""
    image = pytest.importorskip("PIL.Image")
    from amb_rotor.plots import motion
    table = demo.simulate(ROOT / "config/tutorial/demo.yaml", ROOT / "config/thesis/levitation_model.yaml")

    def red(begin, end):
        path = motion.orbit(tmp_path / "orbit.png", table, 3e-4, [("part", begin, end)])
        pixels = numpy.asarray(image.open(path).convert("RGB")).astype(int)
        return int(numpy.sum(numpy.abs(pixels - [196, 68, 45]).sum(axis=2) < 30))

    key = red(0.0, 0.1)  # only the legend's line
    assert red(0.45, 0.6) > 20 * max(key, 1)
