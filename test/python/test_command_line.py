"""The skeleton of the command line: statuses, messages, files that appear whole, children that end."""
from __future__ import annotations

import argparse
import ast
import importlib
import json
import os
import pathlib
import signal
import subprocess
import sys
import time
import types

import pytest

from amb_rotor import cli
from amb_rotor.cli import common
from amb_rotor.errors import InputError

ROOT = pathlib.Path(__file__).resolve().parents[2]
LIGHT = {"argparse", "json", "math", "os", "pathlib", "re", "sys", "dataclasses", "typing", "amb_rotor",
         "__future__"}


def amb(*arguments: str) -> subprocess.CompletedProcess:
    return subprocess.run([sys.executable, "-P", "-m", "amb_rotor", *arguments], capture_output=True,
                          text=True, check=False,
                          env={**os.environ, "PYTHONPATH": f"{ROOT}/python:{os.environ.get('PYTHONPATH', '')}"})


def test_help_lists_the_subcommands_that_are_there():
    run = amb("--help")
    assert run.returncode == 0
    for command in cli.available_commands():
        assert f"\n  {command} " in run.stdout


def test_unknown_subcommand_is_bad_input():
    run = amb("nonsense")
    assert run.returncode == 2
    assert "nonsense" in run.stderr and "Traceback" not in run.stderr


def test_no_subcommand_shows_the_help():
    run = amb()
    assert run.returncode == 2 and "subcommands:" in run.stderr


def test_a_mistyped_subcommand_is_told_before_anything_is_built():
    run = subprocess.run([str(ROOT / "amb"), "diagnos"], capture_output=True, text=True, check=False,
                         env={**os.environ, "AMB_ROTOR_BUILD_DIR": "/proc/amb_rotor_build"})
    assert run.returncode == 2 and "diagnos" in run.stderr and "cannot write" not in run.stderr


@pytest.mark.parametrize("command", ["demo", "test"])  # with the tests built, and without
def test_a_build_folder_that_cannot_be_written_is_named(command):
    run = subprocess.run([str(ROOT / "amb"), command], capture_output=True, text=True, check=False,
                         env={**os.environ, "AMB_ROTOR_BUILD_DIR": "/proc/amb_rotor_build"})
    assert run.returncode == 1
    assert "cannot write to /proc/amb_rotor_build; AMB_ROTOR_BUILD_DIR" in run.stderr


# What a shell has after `source devel/setup.bash` of some other workspace.
SOURCED = {"ROS_DISTRO": "noetic", "ROS_ETC_DIR": "/opt/other/etc/ros", "CATKIN_SHELL": "bash",
           "AMENT_PREFIX_PATH": "/opt/other", "CMAKE_PREFIX_PATH": "/opt/other", "PYTHONPATH": "/opt/other/python"}


def test_a_shell_that_has_sourced_a_workspace_builds_as_any_other(tmp_path):
    """Configuring ends at once, after cmake has said what it sees."""
    shown = "".join(f'message(NOTICE "{name} is [$ENV{{{name}}}]")\n' for name in [*SOURCED, "ROS_LANG_DISABLE"])
    (tmp_path / "show.cmake").write_text(shown + 'message(FATAL_ERROR "seen")\n')
    run = subprocess.run([str(ROOT / "amb"), "modes"], capture_output=True, text=True, check=False,
                         env={**os.environ, **SOURCED, "ROS_LANG_DISABLE": "geneus",
                              "AMB_ROTOR_BUILD_DIR": str(tmp_path / "build"),
                              "AMB_ROTOR_CMAKE_ARGS": f"-C {tmp_path}/show.cmake"})
    assert run.returncode == 1 and "cmake failed" in run.stderr, run.stderr
    assert all(f"{name} is []" in run.stderr for name in SOURCED), run.stderr
    assert "ROS_LANG_DISABLE is [geneus]" in run.stderr  # a setting of the build, and the user's


def test_benchmarks_are_built_as_amb_builds(monkeypatch):
    from amb_rotor.cli import bench
    for name, value in {**SOURCED, "ROS_LANG_DISABLE": "geneus"}.items():
        monkeypatch.setenv(name, value)
    environment = bench.build_environment()
    assert not environment.keys() & SOURCED.keys()
    assert environment["ROS_LANG_DISABLE"] == "geneus" and environment["PATH"] == os.environ["PATH"]


@pytest.mark.parametrize("command", sorted(cli.available_commands()))
def test_each_subcommand_has_help_with_an_example(command, capsys):
    assert cli.main([command, "--help"]) == 0
    printed = capsys.readouterr().out
    assert "--json" in printed and f"example:\n  amb {command}" in printed


@pytest.mark.parametrize("command", sorted(cli.available_commands()))
def test_a_bad_argument_is_bad_input(command, capsys):
    assert cli.main([command, "--no-such-argument"]) == 2
    assert "Traceback" not in capsys.readouterr().err


@pytest.mark.parametrize("module", sorted(cli.available_commands().values()))
def test_help_needs_no_heavy_module(module):
    tree = ast.parse(pathlib.Path(importlib.util.find_spec(module).origin).read_text())
    heads = {alias.name.split(".")[0] for node in tree.body if isinstance(node, ast.Import)
             for alias in node.names}
    heads |= {node.module.split(".")[0] for node in tree.body if isinstance(node, ast.ImportFrom)}
    assert heads <= set(sys.stdlib_module_names) | LIGHT


def status_of(monkeypatch, error: BaseException | int) -> int:
    def run(_args):
        if isinstance(error, int):
            return error
        raise error

    module = types.SimpleNamespace(run=run)
    return cli._run("thing", module, argparse.Namespace(json=None))


@pytest.mark.parametrize("error, status", [
    (0, 0), (1, 1), (InputError("mass_kg: -1: must be > 0 [kg]"), 2), (InputError(["a", "b"]), 2),
    (FileNotFoundError(2, "No such file", "x.yaml"), 2), (KeyboardInterrupt(), 130), (ValueError("x"), 3)])
def test_exit_status(monkeypatch, capsys, error, status):
    assert status_of(monkeypatch, error) == status
    shown = capsys.readouterr().err
    assert ("Traceback" in shown) == (status == 3)
    if status == 2:
        assert all(line in shown for line in getattr(error, "faults", ["x.yaml"]))


def test_a_file_is_there_whole_or_not_at_all(tmp_path):
    target = tmp_path / "a.txt"
    common.atomic_write(target, "one")
    with pytest.raises(RuntimeError), common.atomic_path(target) as part:
        part.write_text("half")
        raise RuntimeError
    assert target.read_text() == "one"
    assert [path.name for path in tmp_path.iterdir()] == ["a.txt"]


def test_json_has_no_nan(tmp_path):
    numpy = pytest.importorskip("numpy")
    path = tmp_path / "r.json"
    common.write_json(argparse.Namespace(json=str(path)),
                      {"a": float("nan"), "b": numpy.array([1.0, numpy.inf]), 1: numpy.int64(3)})
    assert json.loads(path.read_text()) == {"a": None, "b": [1.0, None], "1": 3}


def alive(pid: int) -> bool:
    try:
        state = pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0]
    except FileNotFoundError:
        return False
    return state != "Z"


def test_a_child_and_its_children_end(tmp_path):
    note = tmp_path / "pid"
    # A grandchild that ignores Ctrl-C, as rviz or a node under load may.
    script = f"trap '' INT TERM; (trap '' INT TERM; sleep 100) & echo $! > {note}; wait"
    with common.child(["bash", "-c", script], patience=0.2) as process:
        deadline = time.monotonic() + 10
        while not (note.exists() and note.read_text().strip()) and time.monotonic() < deadline:
            time.sleep(0.01)
    grandchild = int(note.read_text())
    deadline = time.monotonic() + 10
    while alive(grandchild) and time.monotonic() < deadline:
        time.sleep(0.01)
    assert process.returncode == -signal.SIGKILL
    assert not alive(grandchild)


@pytest.mark.parametrize("signum", [signal.SIGTERM, signal.SIGINT])
def test_a_long_run_ends_when_it_is_told_to(signum, tmp_path):
    root = pathlib.Path(__file__).resolve().parents[2]
    text = (root / "config/thesis/drop_40_hz.yaml").read_text()
    (tmp_path / "long.yaml").write_text(text.replace("duration_s: 0.8", "duration_s: 5000.0").replace("5000.0  ", "100.0  "))
    command = [sys.executable, "-P", "-m", "amb_rotor", "simulate", str(root / "config/thesis/drop_model.yaml"),
               "--scenario", str(tmp_path / "long.yaml"), "--out", str(tmp_path / "run.csv")]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
        time.sleep(2.0)  # 5000 s in contact take minutes
        assert process.poll() is None
        process.send_signal(signum)
        assert process.wait(timeout=10.0) != 0
