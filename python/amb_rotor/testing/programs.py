"""Which programs hold our tests, how each is called, and how its results are read."""
from __future__ import annotations

import dataclasses
import importlib.util
import os
import pathlib
import re
import sys
from typing import Callable

from amb_rotor.testing.results import FAILED, SKIPPED, Result, read_junit

KINDS = ("unit", "python", "ros")

# Seconds after which a program is ended and counts as failed.
TIME_LIMIT = {"unit": 900, "python": 1200, "ros": 240}

# Begun first: what takes long and begins last leaves the other cores idle at the end.
LONGEST = ("test_validation", "test_unit", "test_reference")

# Shards for each job: made sets are shared within a shard only, but one that ends late leaves the other cores idle.
SHARDS_PER_JOB = {"test_validation": 2}


@dataclasses.dataclass(frozen=True)
class Selection:
    """Which tests to run."""

    keyword: str | None = None
    quick: bool = False
    long: bool = False
    kinds: tuple[str, ...] = KINDS
    jobs: int | None = None


@dataclasses.dataclass
class Program:
    """One process that runs tests. `read` turns its exit status and output into results."""

    name: str
    kind: str
    command: list[str]
    environment: dict[str, str]
    folder: pathlib.Path  # its own, for results and temporary files
    read: Callable[[int, str], list[Result]]
    alone: bool = False  # timing matters: nothing beside it


def tail(output: str, lines: int = 40) -> str:
    return "\n".join(output.strip().splitlines()[-lines:])


def _read_whole(xml: pathlib.Path, program: str, status: int, output: str,
                good: tuple[int, ...] = (0,)) -> list[Result]:
    """Results from one XML file; a program that died is one failed test more."""
    results = read_junit(xml, program) if xml.exists() else []
    if status not in good and not any(result.outcome == FAILED for result in results):
        running = re.findall(r"^\[ RUN      \] (\S+)", output, re.MULTILINE)
        name = running[-1] if running else "(the program)"
        results.append(Result(program, name, FAILED, 0.0, f"exit status {status}\n{tail(output)}"))
    return results


def google_tests(build: pathlib.Path, results: pathlib.Path, selection: Selection,
                 jobs: int) -> list[Program]:
    """The executables in BUILD/test, the longest first, each in as many shards as there are jobs or more."""
    pattern = f"*{selection.keyword}*" if selection.keyword else "*"
    if selection.quick:
        pattern += "-*Slow*:*slow*"
    programs = []
    rank = {name: place for place, name in enumerate(LONGEST)}
    executables = (build / "test").glob("test_*")
    for executable in sorted(executables, key=lambda path: (rank.get(path.name, len(rank)), path.name)):
        if not (executable.is_file() and os.access(executable, os.X_OK)):
            continue
        shards = jobs * SHARDS_PER_JOB.get(executable.name, 1)
        for shard in range(shards):
            folder = results / f"{executable.name}-{shard}"
            xml = folder / "results.xml"
            name = executable.name
            programs.append(Program(
                name, "unit",
                [str(executable), f"--gtest_filter={pattern}", f"--gtest_output=xml:{xml}"],
                {"GTEST_TOTAL_SHARDS": str(shards), "GTEST_SHARD_INDEX": str(shard),
                 "TEST_TMPDIR": f"{folder}/", "AMB_ROTOR_LONG": "1" if selection.long else ""},
                folder,
                lambda status, output, xml=xml, name=name: _read_whole(xml, name, status, output)))
    return programs


def python_tests(root: pathlib.Path, results: pathlib.Path, selection: Selection) -> list[Program]:
    """pytest over test/python, as one program."""
    if not any((root / "test" / "python").glob("test_*.py")):
        return []
    folder = results / "pytest"
    xml = folder / "results.xml"
    command = [sys.executable, "-P", "-m", "pytest", "test/python", "-q", "--color=no", "--tb=short",
               "-p", "no:cacheprovider", f"--junitxml={xml}", f"--basetemp={folder}/tmp"]
    if importlib.util.find_spec("pytest_timeout") is None:
        command += ["-W", "ignore::pytest.PytestConfigWarning"]
    if selection.keyword:
        command += ["-k", selection.keyword]
    if selection.quick:
        command += ["-m", "not slow"]
    no_tests_collected = 5
    return [Program("pytest", "python", command, {"AMB_ROTOR_LONG": "1" if selection.long else ""}, folder,
                    lambda status, output: _read_whole(xml, "pytest", status, output,
                                                       good=(0, no_tests_collected)))]


def _read_rostest(folder: pathlib.Path, name: str, status: int, output: str) -> list[Result]:
    """The test programs' own files, and from rostest's what they cannot tell: that one of them died."""
    results, dead = [], []
    for xml in sorted(folder.rglob("*.xml")):
        if xml.name.startswith("rosunit-"):
            results += read_junit(xml, name)
        else:
            dead += [result for result in read_junit(xml, name) if result.outcome == FAILED]
    if not any(result.outcome == FAILED for result in results):
        results += [dataclasses.replace(result, message=f"{result.message}\n{tail(output)}")
                    for result in dead]
    failed = any(result.outcome == FAILED for result in results)
    if (status != 0 and not failed) or not results:
        results.append(Result(name, "(the launch)", FAILED, 0.0, f"exit status {status}\n{tail(output)}"))
    return results


def ros_tests(root: pathlib.Path, build: pathlib.Path, results: pathlib.Path,
              selection: Selection) -> tuple[list[Program], list[Result]]:
    """One rostest a file, one after the other; or the reason why they are skipped."""
    files = [file for file in sorted((root / "test" / "ros").glob("*.test"))
             if not selection.keyword or selection.keyword in file.name]
    if selection.quick:
        files = [file for file in files if not file.stem.endswith("_slow")]
    reason = None
    if not (build / "devel" / "share" / "amb_rotor").is_dir():
        reason = "built without ROS"
    elif importlib.util.find_spec("rostest") is None:
        reason = "rostest is not installed"
    if reason:
        return [], [Result(f"test/ros/{file.name}", file.stem, SKIPPED, 0.0, reason) for file in files]

    programs = []
    for file in files:
        folder = results / f"rostest-{file.stem}"
        name = f"test/ros/{file.name}"
        programs.append(Program(
            name, "ros", [sys.executable, "-P", "/usr/bin/rostest", str(file)],
            {"ROS_TEST_RESULTS_DIR": str(folder), "ROS_HOME": str(folder / "home"),
             "ROS_LOG_DIR": str(folder / "log")},
            folder,
            lambda status, output, folder=folder, name=name: _read_rostest(folder, name, status, output),
            alone=True))
    return programs, []
