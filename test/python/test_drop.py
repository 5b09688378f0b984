"""The motion after a drop: named rightly on motions made by hand, and the three of figures 4.16 to 4.18 by the machine."""
from __future__ import annotations

import json
import pathlib

import numpy
import pytest

from amb_rotor import cli, drop
from amb_rotor.errors import InputError
from amb_rotor.sweeps import drops

ROOT = pathlib.Path(__file__).resolve().parents[2]
THESIS = ROOT / "config" / "thesis"
CLEARANCE = 3e-4


def table(z, touching, rate_hz=5000.0):
    """A table of `amb simulate` with the same motion z (complex, in clearances) at both ends."""
    columns = {"t_s": numpy.arange(len(z)) / rate_hz}
    for end in "ab":
        columns[f"aux_{end}x_m"], columns[f"aux_{end}y_m"] = CLEARANCE * z.real, CLEARANCE * z.imag
        columns[f"centre_{end}x_m"] = columns[f"centre_{end}y_m"] = numpy.zeros(len(z))
        columns[f"normal_{end}_N"] = numpy.where(touching, 50.0, 0.0)
    return columns


TIME = numpy.arange(5000) / 5000.0
BOTTOM = numpy.exp(1j * (-numpy.pi / 2 + 0.5 * numpy.sin(2 * numpy.pi * 20.0 * TIME)))
MADE = {
    "backward_whirl": (numpy.exp(-2j * numpy.pi * 75.0 * TIME), numpy.ones(5000, bool)),
    "forward_whirl": (numpy.exp(2j * numpy.pi * 75.0 * TIME), numpy.ones(5000, bool)),
    "oscillation": (BOTTOM, numpy.ones(5000, bool)),
    "rest": (numpy.full(5000, -1j), numpy.ones(5000, bool)),
    "spring": (BOTTOM * (1 - 0.3 * numpy.abs(numpy.sin(40.0 * TIME))), TIME % 0.05 < 0.01),
    "spring ": (0.9 * numpy.cos(2 * numpy.pi * 40.0 * TIME) * numpy.exp(2j * numpy.pi * 12.0 * TIME), TIME % 0.05 < 0.01),
    "free": (0.5 * numpy.exp(2j * numpy.pi * 5.0 * TIME), numpy.zeros(5000, bool)),
}


@pytest.mark.parametrize("kind", MADE)
def test_a_motion_made_by_hand_has_its_name(kind):
    z, touching = MADE[kind]
    assert drop.motion(table(z, touching), CLEARANCE, 0.0).kind == kind.strip()


def test_the_rate_and_the_spectrum_of_a_whirl():
    found = drop.motion(table(*MADE["backward_whirl"]), CLEARANCE, 0.0)
    assert found.whirl_hz == pytest.approx(-75.0, rel=1e-9)
    frequency, amplitude = found.peaks[0]
    assert frequency == pytest.approx(75.0, abs=1.0)  # resolution of 1 s
    assert amplitude == pytest.approx(CLEARANCE, rel=1e-3)


RUNS = {
    "spring": ("drop_150_hz.yaml", ["rig.auxiliary_bearing.friction_coefficient=0.015"]),
    "oscillation": ("drop_40_hz.yaml", []),
    "backward_whirl": ("drop_150_hz.yaml", []),
}


@pytest.mark.parametrize("kind", RUNS)
def test_the_thesiss_motions_appear_for_the_conditions_of_doc_thesis(kind, tmp_path):
    pytest.importorskip("amb_rotor._core")
    scenario, overrides = RUNS[kind]
    words = ["simulate", str(THESIS / "drop_model.yaml"), "--scenario", str(THESIS / scenario), "--out",
             str(tmp_path / "run.npz"), "--motion-from", "0.4", "--picture", str(tmp_path / "drop.png"), "--json",
             str(tmp_path / "drop.json")]
    for override in overrides:
        words += ["--set", override]
    assert cli.main(words) == 0
    motion = json.loads((tmp_path / "drop.json").read_text())["motion"]
    assert motion["kind"] == kind
    assert motion["contacts"] > 0 or motion["contact_share"] == 1.0, "contact must occur"
    assert (tmp_path / "drop.png").stat().st_size > 10000
    if kind == "backward_whirl":
        # figure 4.18: half the driving frequency far above the driving frequency, 3/2 of it small but there
        assert motion["whirl_hz"] == pytest.approx(-75.0, abs=10.0)
        assert 1.0 < motion["radius"] < 1.4
        found = dict((round(frequency / 37.5), amplitude) for frequency, amplitude in reversed(motion["peaks"]))
        assert found[2] > 2.0 * found[4] > 2.0 * found.get(6, 0.0) > 0.0


@pytest.mark.parametrize("scenario, kind", [("drop.yaml", "spring"), ("drop_40_hz.yaml", "oscillation"),
                                            ("drop_150_hz.yaml", "backward_whirl")])
def test_each_scenario_shows_a_motion_of_the_thesis_as_it_stands(scenario, kind, tmp_path, capsys):
    pytest.importorskip("amb_rotor._core")
    assert cli.main(["simulate", str(THESIS / scenario), "--out", str(tmp_path / "run.npz"), "--json", str(tmp_path / "a.json"),
                     "--picture", str(tmp_path / "drop.png")]) == 0
    assert json.loads((tmp_path / "a.json").read_text())["motion"]["kind"] == kind
    assert f": {kind.replace('_', ' ')}: whirl" in capsys.readouterr().out
    assert (tmp_path / "drop.png").stat().st_size > 10000


def off(start, duration, end="both", axis="both"):
    return {"type": "amb_off", "start_s": start, "duration_s": duration, "end": end, "axis": axis}


@pytest.mark.parametrize("faults, expected", [
    ([], None),
    ([off(0.1, 0.0)], (0.1, 1.0)),
    ([off(0.1, 5.0)], (0.1, 1.0)),
    ([off(0.1, 0.2), off(0.4, 0.3)], (0.4, pytest.approx(0.7))),
    ([off(0.1, 0.0), {"type": "amb_on", "start_s": 0.6, "end": "a", "axis": "x"}], (0.1, 0.6)),
    ([off(0.1, 0.0, end="a")], None),
    ([off(0.1, 0.0, axis="y")], None),
    ([off(0.1, 0.05)], None),
])
def test_the_time_without_power(faults, expected):
    assert drop.power_failure({"duration_s": 1.0, "faults": faults}) == expected


def test_a_run_that_ends_at_a_magnet_is_named_so():
    whirling = {"status": "magnet_hit", "columns": table(*MADE["backward_whirl"]), "clearance_m": CLEARANCE, "time_s": 1.0}
    found = drop.motion_of_run(whirling, 5.0)  # it did not come to the instant that was asked for
    assert (found.kind, found.ended) == ("backward_whirl", "magnet_hit")
    early = drop.motion_of_run({**whirling, "time_s": 0.01}, 0.0)
    assert (early.kind, early.ended) == ("magnet_hit", "magnet_hit")
    failed = drop.motion_of_run({**whirling, "status": "failed"}, 0.0)
    assert (failed.kind, failed.ended) == ("diverged", "diverged")
    for wanted in ("backward_whirl", "magnet_hit"):
        assert drops.matches({"wanted": {"motion": wanted}}, found)
    assert not drops.matches({"wanted": {"motion": "spring"}}, found)


def test_a_picture_of_an_unknown_kind_is_refused_before_the_run(tmp_path, capsys):
    words = ["simulate", str(THESIS / "drop_150_hz.yaml"), "--motion-from", "0.4", "--out", str(tmp_path / "r.npz")]
    assert cli.main([*words, "--picture", str(tmp_path / "drop.xyz")]) == 2
    assert "must end in .png or .svg" in capsys.readouterr().err and not (tmp_path / "r.npz").exists()


@pytest.mark.parametrize("path", sorted(THESIS.glob("drop_map_*.yaml")), ids=lambda path: path.stem)
def test_the_maps_are_valid(path):
    assert drops.size(drops.read_drops(path)) > 100


def test_a_map_of_few_drops(tmp_path, capsys):
    pytest.importorskip("amb_rotor._core")
    text = (THESIS / "drop_map_40_hz.yaml").read_text()
    head, _ = text.split("grid:\n")
    for name in ("drop_model.yaml", "drop_40_hz.yaml"):
        head = head.replace(f" {name}", f" {THESIS / name}")
    (tmp_path / "map.yaml").write_text(head + "grid:\n  rig.auxiliary_bearing.friction_coefficient: [0.03, 0.06]\n")
    assert cli.main(["sweep", str(tmp_path / "map.yaml"), "--out", str(tmp_path), "--json", str(tmp_path / "a.json")]) == 0
    points = json.loads((tmp_path / "a.json").read_text())["points"]
    assert [point["parameters"]["rig.auxiliary_bearing.friction_coefficient"] for point in points] == [0.03, 0.06]
    assert "2 drops" in capsys.readouterr().out
    assert (tmp_path / "drop_map.png").exists()


def test_a_wrong_map_is_refused_by_name(tmp_path):
    text = (THESIS / "drop_map_40_hz.yaml").read_text()
    (tmp_path / "a.yaml").write_text(text.replace("motion: oscillation", "motion: swinging"))
    with pytest.raises(InputError, match="wanted"):
        drops.read_drops(tmp_path / "a.yaml")
    (tmp_path / "a.yaml").write_text(text.replace("grid:", "grit:"))
    with pytest.raises(InputError, match="grit"):
        drops.read_drops(tmp_path / "a.yaml")
