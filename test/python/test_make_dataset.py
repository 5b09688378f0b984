"""`amb make-dataset`: a whole data set or nothing, and an end at once where it is interrupted."""
from __future__ import annotations

import functools
import os
import pathlib
import signal
import subprocess
import sys
import time

import pytest

core = pytest.importorskip("amb_rotor._core")

from amb_rotor import cli  # noqa: E402
from amb_rotor.errors import InputError  # noqa: E402

MADE = {"effects": [], "law": "hum", "difference": 3.0, "verdict": "unknown"}


def written(folder) -> dict:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.mark.parametrize("signum", [signal.SIGTERM, signal.SIGINT])
def test_an_interrupted_set_ends_at_once_and_leaves_nothing(signum, tmp_path):
    command = [sys.executable, "-P", "-m", "amb_rotor", "make-dataset", "--seed", "7", "--effect", "sensor_runout", "--contact",
               "--friction", "set_valued", "--out", str(tmp_path / "deep" / "set")]  # some ten seconds
    # a shell's background jobs ignore Ctrl-C, and their children would
    heeding = functools.partial(signal.signal, signal.SIGINT, signal.SIG_DFL)
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, preexec_fn=heeding) as process:
        until = time.monotonic() + 30.0
        while not (tmp_path / "deep").exists() and time.monotonic() < until:
            time.sleep(0.01)
        time.sleep(0.5)
        assert process.poll() is None
        process.send_signal(signum)
        began = time.monotonic()
        printed, message = process.communicate(timeout=60.0)
    assert time.monotonic() - began < 2.0  # half a second, or what a busy machine makes of it
    assert process.returncode == 128 + signum and "Traceback" not in message and not printed
    assert message == ("amb make-dataset: interrupted\n" if signum == signal.SIGINT else "")
    assert not list(tmp_path.iterdir())


def halves(monkeypatch, then=None) -> None:
    """In place of the generator: two runs, one of them before it fails."""
    def make(*arguments):
        folder = pathlib.Path(arguments[4])
        (folder / "runs").mkdir(parents=True)
        (folder / "runs" / "step_1.csv").write_text("new")
        if then:
            raise then(folder)
        (folder / "runs" / "step_2.csv").write_text("new")
        (folder / "dataset.yaml").write_text("new")
        return MADE

    monkeypatch.setattr(core, "make_dataset", make)


@pytest.mark.parametrize("then, status", [
    (lambda folder: InputError(f"{folder}/runs/step_2.csv: the file cannot be written"), 2), (lambda _: ValueError("a defect"), 3)])
@pytest.mark.parametrize("there", [False, True])
def test_a_set_that_fails_leaves_what_was_there(tmp_path, monkeypatch, capsys, then, status, there):
    if there:
        (tmp_path / "set" / "runs").mkdir(parents=True)
        (tmp_path / "set" / "runs" / "step_1.csv").write_text("mine")
    before = written(tmp_path)
    halves(monkeypatch, then)
    assert cli.main(["make-dataset", "--seed", "1", "--out", str(tmp_path / "set")]) == status
    if status == 2:  # told by the name that was given
        assert capsys.readouterr().err.endswith(f" {tmp_path}/set/runs/step_2.csv: the file cannot be written\n")
    assert written(tmp_path) == before and (tmp_path / "set").exists() == there


def test_a_set_joins_what_its_folder_holds_or_changes_nothing(tmp_path, monkeypatch):
    arguments = ["make-dataset", "--seed", "1", "--out", str(tmp_path)]
    (tmp_path / "notes.txt").write_text("mine")
    halves(monkeypatch)
    replace, calls = os.replace, []

    def full(source, target):
        calls.append(target)
        if len(calls) == 5:  # of the three files' two ways each
            raise OSError(28, "No space left on device")
        replace(source, target)

    monkeypatch.setattr(os, "replace", full)
    assert cli.main(arguments) == 2
    assert written(tmp_path) == {"notes.txt": b"mine"} and len(list(tmp_path.iterdir())) == 1
    monkeypatch.setattr(os, "replace", replace)
    assert cli.main(arguments) == 0
    new = {name: b"new" for name in ("dataset.yaml", "runs/step_1.csv", "runs/step_2.csv")}
    assert written(tmp_path) == {"notes.txt": b"mine", **new}
    assert cli.main(arguments) == 2  # there is one already


@pytest.mark.parametrize("out, said", [("afile", "afile: is a file; it must be a folder"), ("afile/set", "afile/set: cannot be written: afile is a file"), ("held", "held/runs: is a file"),
                                       ("/proc/no/where", "/proc/no/where: cannot be written: nothing can be made in /proc")])
def test_a_set_that_cannot_be_written_is_told_before_the_work(tmp_path, monkeypatch, capsys, out, said):
    monkeypatch.chdir(tmp_path)
    pathlib.Path("afile").write_text("mine")
    pathlib.Path("held").mkdir()
    pathlib.Path("held", "runs").write_text("mine")
    monkeypatch.setattr(core, "make_dataset", lambda *_: pytest.fail("worked in vain"))
    before = written(tmp_path)
    assert cli.main(["make-dataset", "--seed", "1", "--out", out]) == 2
    assert said in capsys.readouterr().err and written(tmp_path) == before
