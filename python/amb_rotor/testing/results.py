"""Results of tests, read from JUnit XML as GoogleTest, pytest and rostest write it."""
from __future__ import annotations

import dataclasses
import pathlib
import re
import xml.etree.ElementTree as ElementTree

PASSED, FAILED, SKIPPED = "passed", "failed", "skipped"


@dataclasses.dataclass(frozen=True)
class Result:
    """One test."""

    program: str  # test_unit, pytest, test/ros/levitation.test
    name: str
    outcome: str
    seconds: float = 0.0
    message: str = ""  # why it failed or was skipped


@dataclasses.dataclass
class Summary:
    """All tests of a run."""

    results: list[Result] = dataclasses.field(default_factory=list)

    def count(self, outcome: str) -> int:
        return sum(result.outcome == outcome for result in self.results)

    @property
    def failed(self) -> int:
        return self.count(FAILED)

    def last_line(self) -> str:
        return ", ".join(f"{self.count(outcome)} {outcome}" for outcome in (PASSED, FAILED, SKIPPED))

    def as_dict(self) -> dict:
        counts = {outcome: self.count(outcome) for outcome in (PASSED, FAILED, SKIPPED)}
        return {**counts, "tests": [dataclasses.asdict(result) for result in self.results]}


def _text(element: ElementTree.Element) -> str:
    """pytest keeps the short story in the attribute, GoogleTest the same in both: take each once."""
    short = (element.get("message") or "").strip()
    long = (element.text or "").strip()
    return long if short in long else f"{short}\n{long}".strip()


def read_junit(path: pathlib.Path, program: str) -> list[Result]:
    """The test cases of one XML file. A case that did not run (filtered out) is left out."""
    results = []
    for case in ElementTree.parse(path).getroot().iter("testcase"):
        if case.get("status") == "notrun":
            continue
        name = ".".join(part for part in (case.get("classname"), case.get("name")) if part)
        bad = [element for tag in ("failure", "error") for element in case.findall(tag)]
        skip = case.find("skipped")
        outcome = FAILED if bad else SKIPPED if skip is not None else PASSED
        message = "\n".join(_text(element) for element in bad)
        if outcome == SKIPPED:
            # pytest: the reason is in the attribute. GoogleTest: the place, then the reason.
            message = re.sub(r"^\S+:\d+\n", "", (skip.get("message") or skip.text or "").strip())
        results.append(Result(program, name, outcome, float(case.get("time") or 0), message))
    return results
