"""`amb continue`: branches of periodic motion, stable and unstable, with their bifurcations."""
from __future__ import annotations

import time

from amb_rotor.cli import common

HELP = "branches of periodic motion, stable and unstable, with their bifurcations"
EXAMPLE = "amb continue config/thesis/fig_6_2.yaml --out out/branches"


def add_arguments(parser) -> None:
    parser.add_argument("sweep", metavar="SWEEP", help="file of format amb-sweep/1 with a `continuation`")
    common.add_out(parser, "continue")
    parser.add_argument("--check", action="store_true", help="harmonic balance at points of every branch, and how far it is off")


def _plain(point: dict) -> dict:
    plain = {key: value for key, value in point.items() if key != "multipliers"}
    plain["multipliers"] = [[value.real, value.imag] for value in point["multipliers"]]
    return plain


def critical(mark: dict) -> complex:
    """The multiplier that a bifurcation is about: at +1, at -1, on the unit circle; at grazing, which has none, the largest."""
    multipliers = mark["multipliers"]
    if mark["kind"] in ("fold", "flip"):
        return min(multipliers, key=lambda value: abs(value - (1.0 if mark["kind"] == "fold" else -1.0)))
    if mark["kind"] == "neimark_sacker":
        return min((value for value in multipliers if value.imag > 0.0), key=lambda value: abs(abs(value) - 1.0),
                   default=multipliers[0])
    return multipliers[0]


CHECKED = 12  # points of a branch that harmonic balance is run at
HARMONICS = 64  # a turn


def balance_check(sweep, branch: dict) -> dict:
    """Harmonic balance at points spread over a branch: how far its state is from that of shooting, at most."""
    from amb_rotor import _core
    points = branch["points"]
    chosen = sorted({round(index * (len(points) - 1) / (CHECKED - 1)) for index in range(CHECKED)})
    worst = {"points": len(chosen), "converged": 0, "largest_difference": 0.0, "at": None}
    for index in chosen:
        point = points[index]
        found = _core.harmonic_balance_at(sweep, point["parameter"], point["state"], branch["turns"], HARMONICS)
        if not found["converged"]:
            continue
        worst["converged"] += 1
        apart = max(abs(a - b) for a, b in zip(found["state"], point["state"]))
        if apart >= worst["largest_difference"]:
            worst["largest_difference"], worst["at"] = apart, point["parameter"]
    return worst


def run(args) -> int:
    from amb_rotor import _core
    from amb_rotor.sweeps import draw
    path = common.input_path(args.sweep)
    began = time.perf_counter()
    sweep = _core.BasicSweep(str(path))
    folder = common.out_path(args, "continue", sweep.name)
    found = sweep.run_continuation()
    seconds = time.perf_counter() - began
    folder.mkdir(parents=True, exist_ok=True)
    for branch in found:
        low = min(point["parameter"] for point in branch["points"])
        high = max(point["parameter"] for point in branch["points"])
        stable = sum(point["stable"] for point in branch["points"])
        print(f"period {branch['turns']}: {len(branch['points'])} points, {sweep.continued_parameter} {low:.5g} to "
              f"{high:.5g}, {stable} stable; {branch['ended'].rstrip('; ')}")
        for mark in branch["bifurcations"]:
            multiplier = critical(mark)
            print(f"    {mark['kind']:<15} at {mark['parameter']:.6f}  multiplier {multiplier.real:+.5f} "
                  f"{multiplier.imag:+.5f}j  x {mark['state'][0]:+.5f}  touch-downs {mark['touch_downs']}")
    print(f"{len(found)} branches, {seconds:.1f} s")
    for branch in found if args.check else []:
        branch["harmonic_balance"] = check = balance_check(sweep, branch)
        print(f"harmonic balance with {HARMONICS} harmonics a turn, period {branch['turns']}: converged at {check['converged']} "
              f"of {check['points']} points, state within {check['largest_difference']:.2g} of shooting's")
    result = {"name": sweep.name, "parameter": sweep.continued_parameter,
              "branches": [{**branch, "points": [_plain(point) for point in branch["points"]],
                            "bifurcations": [_plain(mark) for mark in branch["bifurcations"]]} for branch in found]}
    common.write_json(args, result)
    pictures = draw.branches(sweep.title, sweep.continued_parameter, found, folder)
    common.report_line(pictures[0])
    return 0
