"""The commands of doc/tutorial.md, run once for all tests that look at what they do; and which tests are left for `--long`."""
from __future__ import annotations

import contextlib
import io
import json
import os
import pathlib
import re
import shlex
import types

import pytest
import yaml

ROOT = pathlib.Path(__file__).resolve().parents[2]


def tutorial_steps() -> list[tuple[str, list[str]]]:
    """Each command of the tutorial with the lines that the text says it prints."""
    text = (ROOT / "doc" / "tutorial.md").read_text()
    steps: list[tuple[str, list[str]]] = []
    for language, body in re.findall(r"^```(sh|text)\n(.*?)^```", text, re.MULTILINE | re.DOTALL):
        if language == "sh":
            steps += [(line, []) for line in body.splitlines()]
        else:
            steps[-1][1].extend(body.splitlines())
    return steps


def fewer_runs(folder: pathlib.Path, kept: tuple[str, ...], to: pathlib.Path) -> pathlib.Path:
    """The data set with these of its runs only."""
    to.mkdir(parents=True)
    (to / "runs").symlink_to(folder / "runs")
    head, runs = (folder / "dataset.yaml").read_text().split("\nruns:\n")
    every = yaml.safe_load(runs)
    assert set(kept) <= {run["id"] for run in every}
    few = [run for run in every if run["id"] in kept]
    (to / "dataset.yaml").write_text(f"{head}\nruns:\n{yaml.safe_dump(few, sort_keys=False)}")
    return to


@pytest.fixture(scope="session")
def chain(tmp_path_factory):
    """What the tutorial's commands printed and wrote, by subcommand and turn: chain.json["compare", 1]."""
    pytest.importorskip("amb_rotor._core")
    from amb_rotor import cli
    folder = tmp_path_factory.mktemp("tutorial")
    (folder / "config").symlink_to(ROOT / "config")
    result = types.SimpleNamespace(folder=folder, json={}, status={}, printed={})
    before = os.getcwd()
    os.chdir(folder)
    try:
        for index, (command, _) in enumerate(tutorial_steps()):
            words = shlex.split(command)
            assert words[0] == "./amb", command
            path, printed = folder / f"{index}.json", io.StringIO()
            with contextlib.redirect_stdout(printed):
                status = cli.main([*words[1:], "--json", str(path)])
            turn = sum(name == words[1] for name, _ in result.json) + 1
            result.json[words[1], turn] = json.loads(path.read_text()) if path.exists() else None
            result.status[command], result.printed[command] = status, printed.getvalue()
    finally:
        os.chdir(before)
    result.before, result.after = result.json["compare", 1], result.json["compare", 2]
    result.diagnosis, result.adopted = result.json["diagnose", 1], result.json["adopt", 1]
    return result


def pytest_collection_modifyitems(items):
    """Tests of minutes are skipped where nobody asked for them."""
    if os.environ.get("AMB_ROTOR_LONG"):
        return
    for item in items:
        if item.get_closest_marker("long"):
            item.add_marker(pytest.mark.skip(reason="takes minutes: amb test --long"))
