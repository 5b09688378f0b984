"""The runner of `amb test`: a failure, a crash or a hang is never lost in the sum."""
from __future__ import annotations

import functools
import pathlib
import stat
import sys

import pytest

from amb_rotor.testing import programs, results, runner

GOOGLE = """<testsuites><testsuite name="A">
<testcase name="Good" status="run" result="completed" time="0.1" classname="A"/>
<testcase name="Bad" status="run" result="completed" time="0" classname="A"><failure message="1 is not 2"/></testcase>
<testcase name="Skips" status="run" result="skipped" time="0" classname="A"><skipped message="a.cpp:4&#x0A;no data"/></testcase>
<testcase name="Filtered" status="notrun" result="suppressed" time="0" classname="A"/>
</testsuite></testsuites>"""
ROSTEST_DEAD = """<testsuite><testcase classname="rostest" name="testthing">
<failure type="Exception">test [thing] did not generate test results</failure></testcase></testsuite>"""


def outcomes(found: list[results.Result]) -> list[str]:
    return sorted(f"{result.name} {result.outcome}" for result in found)


def test_junit(tmp_path):
    xml = tmp_path / "r.xml"
    xml.write_text(GOOGLE)
    found = results.read_junit(xml, "test_unit")
    assert outcomes(found) == ["A.Bad failed", "A.Good passed", "A.Skips skipped"]
    assert {result.message for result in found} == {"", "1 is not 2", "no data"}
    assert results.Summary(found).last_line() == "1 passed, 1 failed, 1 skipped"


def test_a_crash_is_a_failure_of_the_test_that_ran(tmp_path):
    found = programs._read_whole(tmp_path / "none.xml", "test_unit", -11, "[ RUN      ] A.Crashes\n")
    assert outcomes(found) == ["A.Crashes failed"]


def test_a_rostest_that_died_is_a_failure(tmp_path):
    (tmp_path / "rostest-a.xml").write_text(ROSTEST_DEAD)
    assert [result.outcome for result in programs._read_rostest(tmp_path, "a.test", 1, "")] == ["failed"]


def test_a_rostest_without_results_is_a_failure(tmp_path):
    assert [result.outcome for result in programs._read_rostest(tmp_path, "a.test", 0, "")] == ["failed"]


@pytest.fixture
def tree(tmp_path, monkeypatch):
    """A source tree and a build folder with a made-up GoogleTest program."""
    root, build = tmp_path / "root", tmp_path / "build"
    (root / "test" / "ros").mkdir(parents=True)
    (build / "test").mkdir(parents=True)
    monkeypatch.setenv("AMB_ROTOR_ROOT", str(root))
    monkeypatch.setenv("AMB_ROTOR_BUILD", str(build))
    return tmp_path


def google_program(tree: pathlib.Path, body: str, name: str = "test_unit") -> None:
    path = tree / "build" / "test" / name
    path.write_text(f"#!{sys.executable}\nimport os, sys, time\n{body}\n")
    path.chmod(path.stat().st_mode | stat.S_IXUSR)


def run(kinds=("unit", "ros")) -> results.Summary:
    return runner.run_all(programs.Selection(kinds=kinds, jobs=1))


def test_all_is_summed_up(tree, capsys):
    google_program(tree, f"""
xml = [a for a in sys.argv if a.startswith('--gtest_output=xml:')][0].split(':', 1)[1]
open(xml, 'w').write('''{GOOGLE}''')
sys.exit(1)""")
    (tree / "root" / "test" / "ros" / "drop.test").write_text("<launch/>")
    summary = run()
    assert summary.last_line() == "1 passed, 1 failed, 2 skipped"
    shown = capsys.readouterr().out
    assert "1 is not 2" in shown and "built without ROS" in shown


def test_the_longest_programs_begin_first_and_every_shard_is_run(tree):
    for name in ("test_convergence", "test_unit", "test_validation"):
        google_program(tree, "", name)
    found = programs.google_tests(tree / "build", tree, programs.Selection(), jobs=2)
    assert [(one.name, one.environment["GTEST_SHARD_INDEX"]) for one in found] == [
        *(("test_validation", shard) for shard in "0123"),
        *((name, shard) for name in ("test_unit", "test_convergence") for shard in "01")]
    assert {(one.name, one.environment["GTEST_TOTAL_SHARDS"]) for one in found} == {
        ("test_validation", "4"), ("test_unit", "2"), ("test_convergence", "2")}


def test_a_hang_is_a_failure(tree, monkeypatch):
    monkeypatch.setitem(programs.TIME_LIMIT, "unit", 0.5)
    monkeypatch.setattr(runner, "child", functools.partial(runner.child, patience=0.2))
    google_program(tree, "time.sleep(100)")
    summary = run()
    assert summary.failed == 1 and "ended after 0.5 s" in summary.results[0].message
