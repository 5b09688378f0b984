"""`amb bench`: ours and the peers that are installed, on the same work, in one run."""
from __future__ import annotations

import json
import math
import os
import pathlib
import platform
import re
import shutil
import subprocess
import time

from amb_rotor.cli import common
from amb_rotor.errors import InputError

HELP = "speed and accuracy beside Octave, SciPy, Boost.odeint and SUNDIALS, as a table and a picture"
EXAMPLE = "amb bench --out out/bench"
TURNS, ETA, DAMPING, ECCENTRICITY, ALPHA, MU = 300, 1.05, 0.0347, 0.0973, 13.68, 0.015
END = (0.94156385, -0.37870998)  # of this run, by SciPy's DOP853 at 1e-13: what Octave and SciPy are held to
OURS = ("lanes", "event", "modal")
PARTS = ("lanes", "single", "drop", "flexible", "growth")
DROP = ("Drop of a rigid beam on compliant mounts with Hertz contact, 0.1 s; the peers have equations written by hand for "
        "this machine alone:")
RUB = ("Flexible rotor of 28 nodes, all 56 modes a plane, in rub on spring and damper bearings, 10 ms; the peers have the modal "
       "equations by hand:")
# what grows, what its cost is, and the exponent that it may have: linear, or the method's
GROWTH = {
    "machines": ("basic models in lanes, one turn of 200 steps", 1.0),
    "nodes": ("a shaft's elements to its modes, a dense eigenvalue problem", 3.0),
    "modes": ("modes a plane, 0.1 s levitated, no record", 1.0),
    "effects": ("effects of a rigid beam, 1000 calls of its rates", 1.0),
    "length": ("simulated seconds, levitated rigid beam", 1.0),
}

OCTAVE = f"""
1;
function r = f(t, q)
  radius = sqrt(q(1)^2 + q(2)^2); n = {ALPHA} * max(0, 1 - 1 / radius); w = {ETA};
  r = [q(3); q(4);
       w^2 * {ECCENTRICITY} * cos(w*t) - {DAMPING}*q(3) - q(1) - n*(q(1) - {MU}*q(2));
       w^2 * {ECCENTRICITY} * sin(w*t) - {DAMPING}*q(4) - q(2) - n*(q(2) + {MU}*q(1))];
end
o = odeset('RelTol', 1e-8, 'AbsTol', 1e-8);
c = cputime; [t, q] = ode45(@f, [0 {TURNS} * 2 * pi / {ETA}], [1; 0; 0; 0], o); s = cputime - c;
printf('%.6f %.15g %.15g\\n', s, q(end, 1), q(end, 2));
"""


def add_arguments(parser) -> None:
    common.add_out(parser, "bench")
    parser.add_argument("--programs", metavar="DIR", help="folder of the benchmark programs (default: built here)")
    parser.add_argument("--no-octave", action="store_true", help="leave out Octave, which takes a minute")
    parser.add_argument("--only", metavar="PARTS", help=f"of {','.join(PARTS)}; with commas between several")
    parser.add_argument("--min-time", type=float, default=0.3, metavar="S", help="shortest measurement of each [s]")
    parser.add_argument("--repetitions", type=int, default=3, metavar="N", help="of each; the median counts")


def build_environment() -> dict[str, str]:
    """Ours without the ROS that `amb` sets for running: what it sets while building (forget_other_workspaces)."""
    return {name: value for name, value in os.environ.items()
            if name == "ROS_LANG_DISABLE" or not (name.startswith(("ROS_", "CATKIN_", "AMENT_", "COLCON_"))
                                                  or name in ("CMAKE_PREFIX_PATH", "PYTHONPATH"))}


def _programs(args) -> pathlib.Path:
    if args.programs:
        return common.input_path(args.programs)
    root = pathlib.Path(__file__).resolve().parents[3]
    build = pathlib.Path(os.environ.get("AMB_ROTOR_BUILD_DIR", root / "build"))
    if not (root / "CMakeLists.txt").exists():
        raise InputError(f"the benchmarks are built from the sources, which are not beside {__file__}; "
                         "give --programs")
    for command in (["cmake", "-S", root, "-B", build, "-DAMB_ROTOR_WITH_BENCH=ON"],
                    ["cmake", "--build", build, "--target", "amb_rotor_bench"]):
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                              env=build_environment())
        if done.returncode:
            raise RuntimeError(done.stdout[-2000:])
    return build / "bench"


def _google_benchmark(program: pathlib.Path, args) -> list[dict]:
    repetitions = args.repetitions
    done = subprocess.run([program, "--benchmark_format=json", f"--benchmark_repetitions={repetitions}",
                           f"--benchmark_min_time={args.min_time}", "--benchmark_report_aggregates_only=true"],
                          capture_output=True, text=True, check=True)
    runs = json.loads(done.stdout)["benchmarks"]
    return runs if repetitions == 1 else [run for run in runs if run.get("aggregate_name", "median") == "median"]


def _rate(t, q):
    x, y, vx, vy = q
    n = ALPHA * max(0.0, 1.0 - 1.0 / math.hypot(x, y))
    force = ETA * ETA * ECCENTRICITY
    return (vx, vy, force * math.cos(ETA * t) - DAMPING * vx - x - n * (x - MU * y),
            force * math.sin(ETA * t) - DAMPING * vy - y - n * (y + MU * x))


def _scipy(repetitions: int):
    from scipy.integrate import solve_ivp
    end = TURNS * 2.0 * math.pi / ETA
    for method in ("RK45", "DOP853", "LSODA"):
        times = []
        for _ in range(repetitions):
            began = time.process_time()
            solution = solve_ivp(_rate, (0.0, end), (1.0, 0.0, 0.0, 0.0), method=method, rtol=1e-8, atol=1e-8)
            times.append(time.process_time() - began)
        yield f"SciPy {method}", sorted(times)[len(times) // 2], solution.y[:2, -1]


def _octave():
    done = subprocess.run(["octave-cli", "--no-init-file", "--quiet", "--eval", OCTAVE], capture_output=True, text=True,
                          check=True)
    seconds, x, y = (float(word) for word in done.stdout.split())
    return "Octave ode45", seconds, (x, y)


def _processor() -> str:
    for line in pathlib.Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return platform.processor()


def _runs(program: pathlib.Path, args) -> list[dict]:
    """name, seconds of one run, error of its end: of a program whose benchmarks are integrators."""
    rows = []
    for run in _google_benchmark(program, args):
        scale = {"ns": 1e-9, "us": 1e-6, "ms": 1e-3, "s": 1.0}[run["time_unit"]]
        name = re.sub(r"/(iterations|repeats):[0-9]+", "", run["run_name"])
        seconds = run["cpu_time"] * scale / run.get("machines", 1.0)
        rows.append({"name": name, "seconds": seconds, "error": run["error"], "calls": run["calls"],
                     "ours": name.startswith(OURS)})
    return rows


def seconds_at(rows: list[dict], error: float) -> float:
    """What an integrator takes for an error, between its own runs; inf: none of them is that good."""
    best = math.inf
    points = sorted((row["error"], row["seconds"]) for row in rows if row["error"] > 0.0)
    for (e0, s0), (e1, s1) in zip(points, points[1:]):
        if e0 <= error <= e1:
            share = math.log(error / e0) / math.log(e1 / e0) if e1 > e0 else 0.0
            best = min(best, s0 * (s1 / s0) ** share)
    return min([best] + [seconds for e, seconds in points if e <= error])


def at_equal_error(rows: list[dict], ours: str) -> list[str]:
    """How many times faster than the best of all peers each of our runs is, at its own error."""
    families: dict[str, list[dict]] = {}
    for row in rows:
        families.setdefault(row["name"].split("/")[0], []).append(row)
    lines = [f"| {ours} / tolerance digits | error | seconds | best peer at this error | its seconds | times faster |",
             "|---|---|---|---|---|---|"]
    for row in families[ours]:
        peers = {name: seconds_at(members, row["error"]) for name, members in families.items()
                 if not members[0]["ours"]}
        if not peers:
            continue
        best = min(peers, key=peers.get)
        reached = math.isfinite(peers[best])
        lines.append(f"| {row['name']} | {row['error']:.1e} | {row['seconds']:.3g} | " +
                     (f"{best} | {peers[best]:.3g} | {peers[best] / row['seconds']:.2g} |" if reached else
                      "none ran to it | | |"))
    return lines


def _single_runs(args, folder: pathlib.Path) -> list[dict]:
    rows = _runs(folder / "basic_single_run", args)
    fine = END
    peers = list(_scipy(args.repetitions))
    if not args.no_octave and shutil.which("octave-cli"):
        peers.append(_octave())
    for name, seconds, (x, y) in peers:
        rows.append({"name": name + "/8", "seconds": seconds, "error": math.hypot(x - fine[0], y - fine[1]),
                     "calls": math.nan, "ours": False})
    return rows


def _table(rows: list[dict]) -> list[str]:
    lane = next(row["seconds"] for row in rows if row["name"] == "lanes_rk4/steps:200")
    event = next(row["seconds"] for row in rows if row["name"] == "event_accurate/8")
    lines = ["| integrator / tolerance digits | seconds a run | error of the end | times lanes (200 steps) | "
             "times event_accurate/8 |", "|---|---|---|---|---|"]
    for row in sorted(rows, key=lambda row: row["seconds"]):
        lines.append(f"| {row['name']} | {row['seconds']:.3g} | {row['error']:.1e} | {row['seconds'] / lane:.3g} | "
                     f"{row['seconds'] / event:.3g} |")
    return lines


def _picture(problems: dict[str, list[dict]], folder: pathlib.Path) -> list[pathlib.Path]:
    from amb_rotor.sweeps import draw
    pyplot = draw._pyplot()
    figure, axes = pyplot.subplots(1, len(problems), figsize=(9.0 * len(problems), 5.5), squeeze=False)
    colours, markers = pyplot.get_cmap("tab20").colors, "sD^vP*"
    for axis, (title, rows) in zip(axes[0], problems.items()):
        families: dict[str, list] = {}
        for row in rows:
            if row["error"] < 0.1:  # what lost its way has no place here
                families.setdefault(row["name"].split("/")[0], []).append(row)
        for i, (family, members) in enumerate(families.items()):
            members.sort(key=lambda row: row["error"])
            ours = members[0]["ours"]
            axis.loglog([row["error"] for row in members], [row["seconds"] for row in members],
                        ("o-" if ours else markers[i % len(markers)] + "--"), color=colours[i % len(colours)],
                        linewidth=2.5 if ours else 1.0, markersize=5, label=family)
        axis.set(xlabel="error of the end position / clearance", ylabel="seconds a run", title=title)
        axis.grid(alpha=0.3, which="both")
        axis.legend(fontsize=8, loc="center left", bbox_to_anchor=(1.01, 0.5))
    figure.tight_layout()
    return draw.save(figure, folder, "work_precision")


def _growth(program: pathlib.Path, args) -> dict[str, list[tuple[float, float]]]:
    """Quantity -> (size, seconds), rising."""
    found: dict[str, list[tuple[float, float]]] = {}
    for run in _google_benchmark(program, args):
        scale = {"ns": 1e-9, "us": 1e-6, "ms": 1e-3, "s": 1.0}[run["time_unit"]]
        found.setdefault(run["run_name"].split("/")[1], []).append((run["size"], run["cpu_time"] * scale))
    return {name: sorted(points) for name, points in found.items()}


def exponent(points: list[tuple[float, float]]) -> float:
    """Slope of log cost over log size between the two largest sizes that are there; nan: fewer than two."""
    points = [point for point in points if point[0] > 0.0 and point[1] > 0.0][-2:]
    if len(points) < 2 or points[0][0] == points[1][0]:
        return math.nan
    (size0, cost0), (size1, cost1) = points
    return math.log(cost1 / cost0) / math.log(size1 / size0)


def _growth_lines(growth: dict[str, list[tuple[float, float]]]) -> list[str]:
    lines = ["", "Growth: cost against size, one core; the exponent is that of the two largest sizes:", "",
             "| what grows | cost of | sizes | seconds | exponent | at most |", "|---|---|---|---|---|---|"]
    for name, points in growth.items():
        what, expected = GROWTH[name]
        lines.append(f"| {name} | {what} | {', '.join(f'{size:g}' for size, _ in points)} | "
                     f"{', '.join(f'{cost:.3g}' for _, cost in points)} | {exponent(points):.2f} | {expected:g} |")
    return lines


def _growth_picture(growth: dict[str, list[tuple[float, float]]], folder: pathlib.Path) -> pathlib.Path:
    from amb_rotor.sweeps import draw
    pyplot = draw._pyplot()
    figure, axes = pyplot.subplots(1, len(growth), figsize=(4.2 * len(growth), 4.2), squeeze=False)
    for axis, (name, points) in zip(axes[0], growth.items()):
        seen = [(size, cost) for size, cost in points if size > 0.0]
        axis.loglog(*zip(*seen), "o-", linewidth=2.0, label="measured")
        size, cost = seen[-1]
        power = GROWTH[name][1]
        axis.loglog([x for x, _ in seen], [cost * (x / size) ** power for x, _ in seen], "--", color="0.5",
                    label=f"size^{power:g} through the largest")
        axis.set(xlabel=name, ylabel="seconds", title=f"{name}: exponent {exponent(points):.2f}")
        axis.grid(alpha=0.3, which="both")
        axis.legend(fontsize=8)
    figure.tight_layout()
    return draw.save(figure, folder, "growth")


def _lanes(programs: pathlib.Path, args) -> tuple[list[str], dict]:
    lanes = _google_benchmark(programs / "basic_lanes_avx512", args) + _google_benchmark(programs / "basic_lanes_avx2", args)
    lines = ["", "Lanes of the basic model (256 machines, 100 turns of 200 steps):", "",
             "| kernel | machine-steps/s | share of the hand-written kernel of its width |", "|---|---|---|"]
    rates = {run["run_name"].removesuffix("/real_time").removeprefix("basic_lanes/"): run["items_per_second"]
             for run in lanes if "items_per_second" in run}
    for name, rate in rates.items():
        hand = rates.get("hand_avx512/threads:1" if "avx512" in name else "hand_avx2/threads:1", math.nan)
        lines.append(f"| {name} | {rate:.3g} | {rate / hand:.2f} |")
    for run in _google_benchmark(programs / "rigid_lanes", args):
        lines += ["", f"Lanes of the rigid-beam machine (4 freedoms, 4 amplifiers, sampled PID, two contacts), {run['label']}, "
                  f"one core, {100 * run['touching']:.0f} % of the machines in contact: "
                  f"{run['items_per_second']:.3g} machine-steps/s."]
        rates["rigid_lanes"] = run["items_per_second"]
    return lines, rates


def _single_lines(rows: list[dict], args) -> list[str]:
    lines = []
    if args.no_octave or not shutil.which("octave-cli"):
        lines += ["", "Octave: " + ("left out." if args.no_octave else "not installed.")]
    lines += ["", f"One run of {TURNS} turns in rub (frequency ratio {ETA}), one core; lanes: time of one of 1024:", ""]
    return lines + _table(rows) + ["", "At equal error, basic model in rub:", ""] + at_equal_error(rows, "event_accurate")


def _contact_lines(title: str, rows: list[dict]) -> list[str]:
    lines = ["", title, "", "| integrator / tolerance digits | seconds | error | calls |", "|---|---|---|---|"]
    lines += [f"| {row['name']} | {row['seconds']:.3g} | {row['error']:.1e} | {row['calls']:.0f} |"
              for row in sorted(rows, key=lambda row: row["seconds"])]
    return lines + ["", "At equal error:", ""] + at_equal_error(rows, "modal")


def _flexible_lines(flexible: list[dict]) -> list[str]:
    lines = ["", "Flexible rotor on its sampled magnetic bearings, in modal coordinates:", "",
             "| case | modes | times real time | ns a step in contact, with all else | error / clearance |",
             "|---|---|---|---|---|"]
    for run in flexible:
        step = f"{1e9 / run['items_per_second']:.0f}" if run.get("items_per_second") else ""
        error = f"{run['error']:.1e}" if "error" in run else ""
        lines.append(f"| {run['run_name']} | {run['modes']:.0f} | {run['times_real_time']:.3g} | {step} | {error} |")
    return lines


def chosen_parts(text: str | None) -> tuple[str, ...]:
    if text is None:
        return PARTS
    parts = tuple(text.split(","))
    unknown = [part for part in parts if part not in PARTS]
    if unknown:
        raise InputError(f"--only {','.join(unknown)}: must be of {', '.join(PARTS)}")
    return parts


def run(args) -> int:
    if args.repetitions < 1:
        raise InputError("--repetitions: at least 1")
    parts = chosen_parts(args.only)
    folder = common.out_folder(args, "bench", "all")
    programs = _programs(args)
    lines = [f"Machine: {_processor()}, {os.cpu_count()} processors; load {os.getloadavg()[0]:.1f} at the start."]
    found, diagrams = {}, {}
    if "lanes" in parts:
        more, found["lanes"] = _lanes(programs, args)
        lines += more
    if "single" in parts:
        found["single_runs"] = _single_runs(args, programs)
        lines += _single_lines(found["single_runs"], args)
        diagrams[f"Basic model in rub, {TURNS} turns"] = found["single_runs"]
    if "drop" in parts:
        found["drop"] = _runs(programs / "rigid_drop", args)
        lines += _contact_lines(DROP, found["drop"])
        diagrams["Drop of a rigid beam, Hertz contact, mounts"] = found["drop"]
    if "flexible" in parts:
        found["flexible"] = _google_benchmark(programs / "flexible_rotor", args)
        lines += _flexible_lines(found["flexible"])
        found["flexible_rub"] = _runs(programs / "flexible_rub", args)
        lines += _contact_lines(RUB, found["flexible_rub"])
        diagrams["Flexible rotor of 28 nodes in rub"] = found["flexible_rub"]
    if "growth" in parts:
        found["growth"] = _growth(programs / "growth", args)
        lines += _growth_lines(found["growth"])
    print("\n".join(lines))
    common.write_json(args, found)
    common.atomic_write(folder / "performance.md", "\n".join(lines) + "\n")
    if diagrams:
        _picture(diagrams, folder)
    if "growth" in parts:
        _growth_picture(found["growth"], folder)
    common.report_line(folder / "performance.md")
    return 0
