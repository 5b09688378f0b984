"""Sweeps: scores, intervals and summaries on cases with a known answer."""
from __future__ import annotations

import pathlib

import numpy
import pytest

from amb_rotor.cli import sweep as command
from amb_rotor.errors import InputError
from amb_rotor.sweeps import probability, search

ROOT = pathlib.Path(__file__).resolve().parents[2]
FILES = sorted((ROOT / "config" / "thesis").glob("search_*.yaml"))


def test_wilson_interval_against_published_values():
    # Newcombe, Statistics in Medicine 17 (1998), table I: 81/263, 15/148, 0/20, 1/29, to four digits.
    for hits, samples, low, high in ((81, 263, 0.2553, 0.3662), (15, 148, 0.0624, 0.1605), (0, 20, 0.0, 0.1611),
                                     (1, 29, 0.0061, 0.1718)):
        assert probability.wilson(hits, samples) == pytest.approx((low, high), abs=5e-5)


def test_paired_error_counts_only_what_changed():
    before = numpy.array([True] * 50 + [False] * 50)
    assert probability.paired_error(before, before) == 0.0
    after = before.copy()
    after[:10] = False  # 10 of 100 better, none worse: sqrt(10 - 100/100)/100
    assert probability.paired_error(before, after) == pytest.approx(0.03)


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_the_files_of_searches_are_valid(path):
    assert any(motion is not None for motion in search.published(search.read_search(path)))


def test_agreement_counts_the_published_motion_only_inside_its_ranges():
    found = search.read_search(ROOT / "config" / "thesis" / "search_6_2.yaml")
    motions = search.published(found)
    right = numpy.array([{"period_1": 1, "period_2": 2, "aperiodic": 0, None: 7}[motion] for motion in motions])
    total = sum(motion is not None for motion in motions)
    assert search.agreement(found, right) == total
    right[0] = 3
    assert search.agreement(found, right) == total - 1


def test_a_search_file_with_a_wrong_motion_is_refused(tmp_path):
    text = FILES[0].read_text().replace("motion: period_1}", "motion: period_77}", 1)
    (tmp_path / "a.yaml").write_text(text)
    with pytest.raises(InputError, match="period_77"):
        search.read_search(tmp_path / "a.yaml")


def test_ranges_join_equal_motions():
    lines = command.ranges([1.0, 2.0, 3.0], ["period", "period", "chaotic"], [2, 2, 0])
    assert [line.split()[-2:] for line in lines] == [["period", "2"], ["1", "chaotic"]]
