"""`amb sweep`: bifurcation diagrams, regime maps, and the search for what a figure leaves out."""
from __future__ import annotations

import math
import pathlib
import time

from amb_rotor import yaml_file
from amb_rotor.cli import common
from amb_rotor.errors import InputError

HELP = "bifurcation diagram, regime map, or search for a figure's unstated values"
EXAMPLE = "amb sweep config/thesis/fig_6_2.yaml --out out/fig_6_2"
POINTS_AT_ONCE = 4096
LARGE = 100_000  # points from which on a table is binary (points.npz) instead of text
REGIMES = ("no_contact", "period", "quasi_periodic", "chaotic", "full_annular_rub", "dry_whirl", "diverged")


def add_arguments(parser) -> None:
    parser.add_argument("sweep", metavar="SWEEP", help="file of format amb-sweep/1, amb-search/1, amb-figure/1, "
                        "amb-basin/1, amb-probability/1, amb-drop-map/1 or amb-drop-probability/1")
    common.add_out(parser, "sweep")
    parser.add_argument("--engine", choices=("local", "dask"), default="local",
                        help="local: this machine's cores; dask: chunks of the grid on a Dask cluster")
    parser.add_argument("--scheduler", metavar="ADDRESS", help="of the Dask cluster; without it, one is started here")
    parser.add_argument("--resume", action="store_true", help="keep the points that an interrupted run has finished")


def _format(path: pathlib.Path) -> str:
    document = yaml_file.read(path)
    return document.get("format", "") if isinstance(document, dict) else ""


def run(args) -> int:
    path = common.input_path(args.sweep)
    if path.is_dir():
        raise InputError(f"{path}: is a folder")
    if args.scheduler and args.engine != "dask":
        raise InputError("--scheduler: needs --engine dask")
    if _format(path) == "amb-search/1":
        return _search(args, path)
    if _format(path) == "amb-probability/1":
        return _probability(args, path)
    if _format(path) == "amb-basin/1":
        from amb_rotor.sweeps import basin
        return basin.run_command(args, path)
    if _format(path) == "amb-drop-probability/1":
        from amb_rotor.sweeps import drop_probability
        return drop_probability.run_command(args, path)
    if _format(path) == "amb-figure/1":
        from amb_rotor.sweeps import figures
        return figures.run_figure(args, path)
    if _format(path) == "amb-drop-map/1":
        return _drops(args, path)
    return _sweep(args, path)


# ---- sweep
def run_chunk(path: str, first: int, count: int) -> dict:
    """One chunk of a sweep file's grid: what a worker does, here or on a cluster."""
    from amb_rotor import _core
    return _core.BasicSweep(path).run(first, count)


def _chunks(args, path: pathlib.Path, size: int, todo: list[int]):
    """(first, result) of every chunk that is to do."""
    def count(first):
        return min(POINTS_AT_ONCE, size - first)
    if args.engine == "local":
        for first in todo:
            yield first, run_chunk(str(path), first, count(first))
        return
    try:
        from distributed import Client, as_completed
    except ImportError as error:
        raise InputError(f"--engine dask: {error}; install python3-distributed") from error
    with Client(args.scheduler) if args.scheduler else Client() as client:
        futures = {client.submit(run_chunk, str(path.resolve()), first, count(first)): first for first in todo}
        for future in as_completed(futures):
            yield futures[future], future.result()


def _save_part(folder: pathlib.Path, first: int, result: dict) -> None:
    import numpy
    codes = numpy.array([REGIMES.index(name) for name in result["regime"]], numpy.uint8)
    with common.atomic_path(folder / f"part_{first:09d}.npz") as part:
        numpy.savez(part, **{key: codes if key == "regime" else numpy.asarray(value) for key, value in result.items()})


def _gather(args, path: pathlib.Path, sweep, parts: pathlib.Path) -> tuple[dict, float, float]:
    """All points, seconds of computing, machine-steps."""
    import numpy
    parts.mkdir(exist_ok=True)
    stamp = parts / "sweep.yaml"
    text = path.read_text()
    if not (args.resume and stamp.exists() and stamp.read_text() == text):
        for old in parts.glob("part_*.npz"):
            old.unlink()
        common.atomic_write(stamp, text)
    starts = range(0, sweep.size, POINTS_AT_ONCE)
    todo = [first for first in starts if not (parts / f"part_{first:09d}.npz").exists()]
    seconds = steps = 0.0
    began = time.perf_counter()
    with common.progress_bar(len(starts), "points") as bar:
        bar.update(len(starts) - len(todo))
        for first, result in _chunks(args, path, sweep.size, todo):
            seconds += time.perf_counter() - began
            steps += result["machine_steps"]
            if sweep.size > 10 * POINTS_AT_ONCE:
                del result["sections"]  # a map does not need them, and they are large
            _save_part(parts, first, result)
            bar.update(1)
            began = time.perf_counter()
    loaded = [numpy.load(parts / f"part_{first:09d}.npz") for first in starts]
    keys = ("period", "contact_fraction", "regime", "largest_lyapunov", "max_radius", "whirl", "end")
    points = {key: numpy.concatenate([part[key] for part in loaded]) for key in keys}
    points["regime"] = numpy.array(REGIMES)[points["regime"]]
    if all("sections" in part for part in loaded):
        points["sections"] = numpy.concatenate([part["sections"] for part in loaded])
    return points, seconds, steps


def _border(axes, fixed):
    """Friction at which the annular rub loses its stability, at each frequency of a map of friction over frequency with
    a centred bearing; else none. Not finite, or 0, where there is no such border."""
    names = [name for name, _ in axes]
    if sorted(names) != ["frequency_ratio", "friction"] or fixed.get("misalignment"):
        return None
    from amb_rotor import _core
    import numpy
    frequencies = numpy.asarray(dict(axes)["frequency_ratio"])
    return frequencies, numpy.array([_core.annular_rub_border({**fixed, "frequency_ratio": f}) for f in frequencies])


def _whirl_border(sweep) -> float:
    """Friction above which the backward whirl that a map starts with grows; NaN where it starts with none."""
    from amb_rotor import _core
    x, y, vx, vy = sweep.initial
    whirl = (y * vx - x * vy) / max(x * x + y * y, 1e-12)  # backward positive
    fixed = {key: value for key, value in sweep.parameters.items() if key != "friction"}
    if whirl <= 0.0 or fixed.get("misalignment") or "contact_stiffness" not in fixed or "damping" not in fixed:
        return float("nan")
    return _core.dry_whirl_friction(fixed, whirl)


def border_report(axes, regimes, border) -> list[str]:
    """How a map's dry whirl (held, or growing without limit) lies about a closed-form border: frequencies, frictions."""
    import numpy
    frequencies, frictions = border
    values = dict(axes)
    grid = numpy.isin(numpy.asarray(regimes), ("dry_whirl", "diverged")).reshape([len(v) for _, v in axes])
    if axes[0][0] == "frequency_ratio":
        grid = grid.T  # rows: friction
    known = numpy.isfinite(frictions) & (frictions > 0.0)
    above = (numpy.asarray(values["friction"])[:, None] > frictions[None, :]) & known
    below = ~above & known
    lines = [f"dry whirl or diverged: {100 * grid[above].mean():.1f} % of the points above the border, "
             f"{100 * grid[below].mean():.1f} % of those below"] if above.any() and below.any() else []
    # The map's own border: lowest friction from which on every point whirls.
    ratios = []
    for column in numpy.flatnonzero(known):
        calm = numpy.flatnonzero(~grid[:, column])
        if len(calm) and calm[-1] + 1 < len(grid):
            ratios.append(values["friction"][calm[-1] + 1] / frictions[column])
    if ratios:
        lines.append(f"lowest friction from which on all of the map whirls, over the border's: median "
                     f"{numpy.median(ratios):.3f}, {numpy.min(ratios):.3f} to {numpy.max(ratios):.3f} ({len(ratios)} frequencies)")
    return lines


def ranges(values, regimes, periods) -> list[str]:
    """The motion in words: runs of equal motion along one axis."""
    kinds = [f"period {period}" if regime == "period" else regime.replace("_", " ")
             for regime, period in zip(regimes, periods)]
    lines, begin = [], 0
    for index in range(1, len(kinds) + 1):
        if index == len(kinds) or kinds[index] != kinds[begin]:
            lines.append(f"  {values[begin]:9.4f} to {values[index - 1]:9.4f}  {index - begin:4d}  {kinds[begin]}")
            begin = index
    return lines


def _sweep(args, path: pathlib.Path) -> int:
    import collections
    from amb_rotor import _core
    from amb_rotor.sweeps import draw
    sweep = _core.BasicSweep(str(path))
    folder = common.out_folder(args, "sweep", sweep.name)
    points, seconds, steps = _gather(args, path, sweep, folder / "parts")
    axes = sweep.axes
    if len(axes) == 1:
        pictures = draw.bifurcation(sweep.title, axes[0][0], axes[0][1], points["sections"], points["regime"], folder)
        print("\n".join(ranges(axes[0][1], points["regime"], points["period"])))
    else:
        border = _border(axes, sweep.parameters)
        lines = []
        if border is not None:
            import numpy
            lines.append(("annular rub loses its stability (closed form)", "k-", border))
            whirl = _whirl_border(sweep)
            if math.isfinite(whirl):
                lines.append(("dry whirl of the start grows (closed form)", "k--",
                              (border[0], numpy.full(len(border[0]), whirl))))
            for text, _, line in lines:
                print("\n  ".join([f"{text}:", *border_report(axes, points["regime"], line)]))
            if axes[1][0] == "friction":
                lines = [(text, style, line[::-1]) for text, style, line in lines]
        pictures = draw.regime_map(sweep.title, axes, points["regime"], lines, folder)
    counts = collections.Counter(points["regime"].tolist())
    print(", ".join(f"{count} {regime}" for regime, count in counts.most_common()))
    if steps:
        print(f"{sweep.size} points of {sweep.turns} turns: {seconds:.2f} s of computing, "
              f"{steps / seconds:.3g} machine-steps/s")
    _write_points(args, sweep, points, folder)
    common.report_line(pictures[0])
    return 0


COLUMNS = ("period", "contact_fraction", "regime", "largest_lyapunov", "max_radius")


def _write_points(args, sweep, points: dict, folder: pathlib.Path) -> None:
    """points.csv with one row a point, or points.npz where there are very many; and --json."""
    import numpy
    names = [name for name, _ in sweep.axes]
    if sweep.size > LARGE:
        shape = [len(values) for _, values in sweep.axes]
        with common.atomic_path(folder / "points.npz") as part:
            numpy.savez_compressed(part, **{f"axis_{name}": values for name, values in sweep.axes},
                                   regimes=numpy.array(REGIMES),
                                   **{key: _code(points[key]).reshape(shape) for key in COLUMNS})
    if sweep.size > LARGE and not args.json:
        return
    table = [{"parameters": dict(zip(names, sweep.values_at(index))),
              **{key: points[key][index].item() for key in COLUMNS}} for index in range(sweep.size)]
    common.write_json(args, {"name": sweep.name, "points": table})
    if sweep.size > LARGE:
        return
    lines = [",".join(names + list(COLUMNS))]
    for row in table:
        lines.append(",".join([f"{row['parameters'][name]:.10g}" for name in names] +
                              [f"{row[key]:.8g}" if isinstance(row[key], float) else str(row[key]) for key in COLUMNS]))
    common.atomic_write(folder / "points.csv", "\n".join(lines) + "\n")


def _code(column):
    """Small types for very many points: a regime is its place in REGIMES."""
    import numpy
    if column.dtype.kind == "U":
        return numpy.array([REGIMES.index(name) for name in column], numpy.uint8)
    if column.dtype.kind == "i":
        return column.astype(numpy.uint8)
    return numpy.clip(column, -1e30, 1e30).astype(numpy.float32)  # what diverged is beyond float32


# ---- search
def _search(args, path: pathlib.Path) -> int:
    import numpy
    from amb_rotor.sweeps import draw
    from amb_rotor.sweeps import search as searching
    search = searching.read_search(path)
    folder = common.out_folder(args, "sweep", search.name)
    if search.sampling:
        return _sampled_search(args, search, folder)
    size = int(numpy.prod([len(values) for values in search.grid.values()]))
    began = time.perf_counter()
    with common.progress_bar(size, "grid points") as bar:
        points, hits = searching.run_search(search, bar.update)
    seconds = time.perf_counter() - began
    total = sum(motion is not None for motion in searching.published(search))
    order = numpy.argsort(-hits, kind="stable")
    print(f"{size} grid points, {total} swept values inside the published ranges, {seconds:.0f} s")
    print("  agree  " + "  ".join(search.grid))
    for index in order[:12]:
        print(f"  {hits[index]:5d}  " + "  ".join(f"{value:{len(name)}.4g}" for name, value in zip(search.grid, points[index])))
    print("best for each friction direction, and how many grid points come near it:")
    best = []
    for sign in sorted(set(points[:, list(search.grid).index("friction_sign")]), reverse=True) \
            if "friction_sign" in search.grid else [None]:
        chosen = order if sign is None else [i for i in order
                                             if points[i, list(search.grid).index("friction_sign")] == sign]
        top = hits[chosen[0]]
        near = int(sum(hits[i] >= top - 0.02 * total for i in chosen))
        where = ", ".join(f"{name} {value:g}" for name, value in zip(search.grid, points[chosen[0]]))
        print(f"  {top} of {total}: {where}; {near} of {len(chosen)} points are within 2 % of it")
        best.append({"agree": int(top), "of": total, "near": near,
                     "parameters": {name: float(value) for name, value in zip(search.grid, points[chosen[0]])}})
    common.write_json(args, {"name": search.name, "best": best})
    pictures = draw.score_map(search.title, search.grid, hits, total, folder)
    common.report_line(pictures[0])
    return 0


def _sampled_search(args, search, folder: pathlib.Path) -> int:
    import numpy
    from amb_rotor.sweeps import draw
    from amb_rotor.sweeps import search as searching
    size = searching.sampled_size(search)
    began = time.perf_counter()
    with common.progress_bar(size, "samples") as bar:
        points, hits, scores = searching.run_sampled(search, bar.update)
    seconds = time.perf_counter() - began
    total = sum(motion is not None for motion in searching.published(search))
    trivial = max(((float(searching.shares(search, numpy.full(len(search.values), period))), period)
                   for period in range(17)), key=lambda pair: (pair[0], -pair[1]))
    order = numpy.argsort(-scores, kind="stable")
    first = search.sampling["samples"]
    print(f"{size} samples, {total} swept values inside the published ranges, {seconds:.0f} s")
    print(f"score {trivial[0]:.3f}: one motion throughout ({'period ' + str(trivial[1]) if trivial[1] else 'aperiodic'})")
    print("  score  agree  " + "  ".join(search.grid))
    for index in order[:8]:
        print(f"  {scores[index]:.3f}  {hits[index]:5d}  " +
              "  ".join(f"{value:{len(name)}.4g}" for name, value in zip(search.grid, points[index])))
    top = float(scores[order[0]])
    near = scores >= top - 0.02
    print(f"within 0.02 of the best: {int(near.sum())} samples, {int(near[:first].sum())} of the {first} that were "
          "drawn over the whole ranges; their span:")
    spans = {}
    for index, name in enumerate(search.grid):
        spans[name] = [float(points[near, index].min()), float(points[near, index].max())]
        print(f"  {name:<24} {spans[name][0]:9.4g} to {spans[name][1]:9.4g}")
    best = points[order[:1]]
    periods = searching.run_points(search, best)[0]
    for low, high, motion in search.expected:
        inside = (search.values >= low) & (search.values <= high)
        right = int(searching.MOTIONS[motion](periods[inside]).sum())
        print(f"  best, {low:g} to {high:g}: {motion.replace('_', ' ')} at {right} of {int(inside.sum())}")
    common.write_json(args, {"name": search.name, "score": top, "agree": int(hits[order[0]]), "of": total, "near": spans,
                             "trivial": trivial[0], "best": dict(zip(search.grid, map(float, best[0])))})
    pictures = draw.score_cloud(search.title, list(search.grid), points, scores, folder)
    common.report_line(pictures[0])
    return 0


# ---- probability
def _probability(args, path: pathlib.Path) -> int:
    from amb_rotor.sweeps import draw
    from amb_rotor.sweeps import probability
    document = probability.read_probability(path)
    folder = common.out_folder(args, "sweep", document["name"])
    with common.progress_bar(1 + len(document["changes"]), "designs") as bar:
        outcomes, drawn = probability.run_probability(document, bar.update)
    rows = probability.tell(outcomes, "dry whirl")
    common.write_json(args, {"name": document["name"], "designs": rows})
    pictures = draw.outcomes(document["title"], "dry whirl", ("friction", drawn["friction"]), ("knock_speed", drawn["knock"]),
                             outcomes["as it is"], rows, folder)
    common.report_line(pictures[0])
    return 0


# ---- drops
def _drops(args, path: pathlib.Path) -> int:
    import collections
    from amb_rotor.sweeps import draw
    from amb_rotor.sweeps import drops
    document = drops.read_drops(path)
    folder = common.out_folder(args, "sweep", document["name"])
    began = time.perf_counter()
    with common.progress_bar(drops.size(document), "drops") as bar:
        points = drops.run_drops(document, bar.update)
    seconds = time.perf_counter() - began
    counts = collections.Counter(point["motion"].kind for point in points)
    kinds = ", ".join(f"{count} {kind.replace('_', ' ')}" for kind, count in counts.most_common())
    hits = sum(point["motion"].ended == "magnet_hit" for point in points)
    print(f"{len(points)} drops, {seconds:.0f} s: {kinds}" + (f"; in {hits} of them the rotor reaches a magnet" if hits else ""))
    matching = [drops.matches(document, point["motion"]) for point in points]
    print(f"{sum(matching)} of {len(points)} show {drops.wanted_text(document)}; of each value of the grid:")
    for key, values in document["grid"].items():
        shares = [(value, [match for match, point in zip(matching, points) if point["values"][key] == value])
                  for value in values]
        print(f"  {key}: " + ", ".join(f"{value:g}: {sum(hits)}/{len(hits)}" for value, hits in shares))
    common.write_json(args, {"name": document["name"], "matching": int(sum(matching)), "points": [
        {"parameters": point["values"], "motion": point["motion"].kind, "ended": point["motion"].ended, "whirl_hz": point["motion"].whirl_hz,
         "contact_share": point["motion"].contact_share, "matches": bool(match)}
        for point, match in zip(points, matching)]})
    pictures = draw.drop_map(document["title"], document["grid"], points, folder)
    common.report_line(pictures[0])
    return 0
