"""What is none of ours, given where something of ours belongs: one clear message, no traceback, nothing lost."""
from __future__ import annotations

import gzip
import json
import os
import pathlib

import pytest
from conftest import fewer_runs

core = pytest.importorskip("amb_rotor._core")

from amb_rotor import cli  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]
MEASURED = ROOT / "config/tutorial/measured"
MODEL = ROOT / "config/thesis/levitation_model.yaml"
SCENARIO = ROOT / "config/thesis/levitation.yaml"

FILES = {
    "empty.yaml": b"", "noise.yaml": bytes(range(256)), "latin.yaml": "format: amb-model/1\nname: Mühle\n".encode("latin-1"),
    "nul.yaml": b"format: amb-model/1\0\n", "deep.yaml": b"[" * 3000, "list.yaml": b"- 1\n", "date.yaml": b"format: 2020-13-45\n",
    "empty.csv": b"", "empty.npz": b"", "noise.bag": bytes(range(256)), "noise.csv.gz": bytes(range(256)),
    "semi.csv": b"t_s;ax_m\n0,1;0,2\n", "prüfung 模型.yaml": "format: x\nname: 模型\n".encode()}


def commands(path: str) -> list[list[str]]:
    measured, model = str(MEASURED), str(MODEL)
    return [["check", path], ["compare", path], ["compare", path, measured], ["compare", model, path], ["diagnose", path],
            ["diagnose", measured, "--model", path], ["diagnose", measured, "--effect-file", path], ["adopt", path, "--out", "m.yaml"],
            ["identify", "frf", path], ["analyse", path, "--clearance-m", "1e-4"], ["analyse", path, "--model", path],
            ["convert", path, "o.npz"], ["simulate", path, "--scenario", str(SCENARIO), "--out", "s.csv"],
            ["simulate", model, "--scenario", path, "--out", "s.csv"], ["simulate", path], ["modes", path], ["reduce", path],
            ["sweep", path], ["continue", path], ["new-effect", "name", "--from", path], ["bench-diagnosis", "--data", path]]


def told(capsys, *arguments: str) -> str:
    """The one message of a command that is refused."""
    assert cli.main(list(arguments)) == 2, arguments
    message = capsys.readouterr().err
    assert message.startswith(f"amb {arguments[0]}: ") and "Traceback" not in message
    return message


@pytest.mark.parametrize("name", [*FILES, "folder", "nothing", "loop", "zeros"])
def test_a_wrong_file_is_one_message_of_each_command(tmp_path, monkeypatch, capsys, name):
    monkeypatch.chdir(tmp_path)
    if name in FILES:
        pathlib.Path(name).write_bytes(FILES[name])
    if name == "folder":
        pathlib.Path(name).mkdir()
    if name == "loop":
        pathlib.Path(name).symlink_to(name)
    path = "/dev/zero" if name == "zeros" else name  # never ends
    for arguments in commands(path):
        message = told(capsys, *arguments)
        assert message.count("\n") <= 3, message
        assert path in message or arguments[0] in ("analyse", "new-effect"), message
    assert sorted(child.name for child in tmp_path.iterdir()) == ([] if name in ("nothing", "zeros") else [name])


def test_a_folder_that_is_no_data_set_says_what_is_one(tmp_path, capsys):
    (tmp_path / "inner").mkdir()
    (tmp_path / "inner" / "dataset.yaml").write_text("format: amb-dataset/1\n")
    (tmp_path / "table.csv").write_text("t_s\n0\n")
    for command in (["check"], ["compare"], ["diagnose"], ["identify", "frf"]):
        assert "no dataset.yaml in it; data sets in it: inner" in told(capsys, *command, str(tmp_path))
    assert "the data set that it belongs to" in told(capsys, "check", str(tmp_path / "table.csv"))
    assert "a data set is a folder with dataset.yaml" in told(capsys, "diagnose", str(tmp_path / "table.csv"))


@pytest.mark.parametrize("out", ["afile/sub", "/proc/no/where", "x" * 300])
def test_a_diagnosis_that_cannot_be_written_is_told_before_the_work(tmp_path, monkeypatch, capsys, out):
    monkeypatch.chdir(tmp_path)
    pathlib.Path("afile").write_text("mine")
    monkeypatch.setattr(core, "diagnose", lambda *_, **__: pytest.fail("worked in vain"))
    monkeypatch.setattr(core, "compare", lambda *_, **__: pytest.fail("worked in vain"))
    for command in ("diagnose", "compare"):
        assert out.split("/")[0] in told(capsys, command, str(MEASURED), "--out", out)
        assert "no such folder" in told(capsys, command, str(MEASURED), "--json", "nowhere/result.json")
    assert "a folder of its own" in told(capsys, "diagnose", str(MEASURED), "--out", ".")
    assert os.listdir() == ["afile"] and pathlib.Path("afile").read_text() == "mine"


def spoilt(tmp_path, change) -> pathlib.Path:
    """Two runs of the tutorial's set, the first one's table changed."""
    folder = fewer_runs(MEASURED, ("steady_2", "steady_4"), tmp_path / "set")
    tables = {path.name: path.read_bytes() for path in (folder / "runs").iterdir()}
    (folder / "runs").unlink()
    (folder / "runs").mkdir()
    for name in ("steady_2.csv.gz", "steady_4.csv.gz"):
        text = gzip.decompress(tables[name]).decode()
        (folder / "runs" / name).write_bytes(gzip.compress((change(text) if name == "steady_2.csv.gz" else text).encode(), 1))
    return folder


def spike(text: str) -> str:
    lines = text.splitlines()
    cells = lines[500].split(",")
    cells[lines[0].split(",").index("ax_um")] = "1e300"
    return "\n".join([*lines[:500], ",".join(cells), *lines[501:]])


@pytest.mark.parametrize("change, said", [
    (lambda text: text.replace("\n", "\r"), "the lines end with CR alone"),
    (lambda text: "\n".join([text.splitlines()[0], *text.splitlines()[:0:-1]]), "the time must rise; it nowhere does"),
    (lambda text: text[:5000] + "\0" + text[5000:], "?: the cell must be a finite number"),
    (lambda text: text.replace(",", ";"), "the cells are parted by semicolons")])
def test_a_table_that_is_spoilt_as_a_whole_is_one_line(tmp_path, capsys, change, said):
    message = told(capsys, "check", str(spoilt(tmp_path, change)))
    assert message.count("\n") == 1 and said in message


@pytest.mark.filterwarnings("error::RuntimeWarning")
def test_numbers_beyond_all_sense_are_remarks_and_short(tmp_path, capsys):
    folder = spoilt(tmp_path, spike)
    assert cli.main(["compare", str(folder), "--out", str(tmp_path / "out"), "--json", str(tmp_path / "c.json")]) == 0
    shown = capsys.readouterr()
    assert "beyond the air gap" in shown.out
    assert max(map(len, shown.out.splitlines())) < 400
    assert json.loads((tmp_path / "c.json").read_text())["error"] > 1e100


def test_a_model_that_diverges_is_named(tmp_path, capsys):
    few = fewer_runs(MEASURED, ("step_1", "steady_4"), tmp_path / "few")
    assert cli.main(["compare", "-", str(few), "--no-refit", "--set", "rig.amb.displacement_stiffness_N_per_m=1e7",
                     "--out", str(tmp_path / "out")]) == 0
    shown = capsys.readouterr().out
    assert "step_1, steady_4: the model's motion grows beyond all numbers" in shown and max(map(len, shown.splitlines())) < 400
