"""`amb bench`: the comparison at equal error, which must not flatter."""
from __future__ import annotations

import math

import pytest

from amb_rotor.cli import bench


def row(name: str, error: float, seconds: float) -> dict:
    return {"name": name, "error": error, "seconds": seconds, "ours": name.startswith(bench.OURS)}


PEER = [row("odeint_dopri5/6", 1e-4, 1.0), row("odeint_dopri5/8", 1e-6, 4.0)]


def test_between_two_runs_the_time_is_interpolated_by_powers():
    assert bench.seconds_at(PEER, 1e-5) == pytest.approx(2.0)  # half way in both logarithms


def test_a_looser_error_costs_what_the_loosest_run_costs_and_a_finer_one_is_not_reached():
    assert bench.seconds_at(PEER, 1e-2) == 1.0
    assert bench.seconds_at(PEER, 1e-8) == math.inf


def test_a_finer_run_that_is_faster_counts_for_coarser_errors_too():
    assert bench.seconds_at(PEER + [row("odeint_dopri5/10", 1e-9, 0.5)], 1e-5) == 0.5


def test_the_best_of_all_peers_is_what_ours_is_held_to():
    rows = PEER + [row("cvode_adams_roots/6", 1e-5, 1.5), row("event_stepper/8", 1e-5, 0.1),
                   row("modal/8", 1e-5, 0.5), row("modal/9", 1e-5, 5.0)]
    lines = bench.at_equal_error(rows, "modal")
    assert "| cvode_adams_roots | 1.5 | 3 |" in lines[2]
    assert lines[3].endswith("| 1.5 | 0.3 |")  # slower, and says so


def test_where_no_peer_is_that_good_there_is_no_ratio():
    lines = bench.at_equal_error(PEER + [row("modal/12", 1e-12, 0.5)], "modal")
    assert lines[2].endswith("| none ran to it | | |")


def test_the_exponent_of_growth_is_that_of_the_largest_sizes():
    points = [(1.0, 5.0), (10.0, 6.0), (100.0, 60.0), (1000.0, 6000.0)]  # flat, linear, then quadratic
    assert bench.exponent(points) == pytest.approx(2.0)
    assert bench.exponent(points[:3]) == pytest.approx(1.0)
    assert math.isnan(bench.exponent([(0.0, 1.0), (10.0, 2.0)]))  # nothing has no logarithm
    line = bench._growth_lines({"machines": points})[-1]
    assert line.endswith("| 2.00 | 1 |")  # and it is printed beside what it should be


def test_a_part_that_is_not_there_is_refused_by_name():
    assert bench.chosen_parts("drop,growth") == ("drop", "growth")
    assert bench.chosen_parts(None) == bench.PARTS
    with pytest.raises(bench.InputError, match="dorp"):
        bench.chosen_parts("drop,dorp")
