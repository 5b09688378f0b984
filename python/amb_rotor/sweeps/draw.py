"""Pictures of sweeps: bifurcation diagram of one parameter, regime map of two, branches of a continuation."""
from __future__ import annotations

import pathlib

import numpy

from amb_rotor.cli.common import atomic_path

REGIME_COLOURS = {
    "no_contact": "#9ecae1", "period": "#3182bd", "quasi_periodic": "#fdae6b", "chaotic": "#e6550d",
    "full_annular_rub": "#31a354", "dry_whirl": "#756bb1", "diverged": "#636363",
}
LABELS = {
    "frequency_ratio": "driving frequency over natural frequency  $\\eta$",
    "contact_stiffness": "contact stiffness over support stiffness  $\\alpha$",
    "support_stiffness": "support stiffness over its original value",
    "friction": "friction coefficient  $\\mu$",
    "clearance": "clearance over its original value",
    "misalignment": "displacement of the auxiliary bearing / clearance",
    "misalignment_angle_deg": "direction of the displacement [deg]",
    "eccentricity": "eccentricity / clearance",
    "damping": "damping  $d_1 / (m \\omega_n)$",
    "friction_sign": "friction direction",
    "hertz_stiffness": "Hertz stiffness  $\\kappa \\sqrt{C_s} / k_1$",
    "scenario.speed.start_hz": "speed at the failure [Hz]",
    "rig.auxiliary_bearing.friction_coefficient": "friction coefficient  $\\mu$",
    "rig.unbalance.0.phase_rad": "phase of the unbalance [rad]",
    "effects.compliant_mount.damping_N_s_per_m": "damping of the mount [N s/m]",
    "knock_speed": "speed of the knock / (clearance $\\omega_n$)",
    "knock_direction_deg": "direction of the knock from the unbalance [deg]",
}


def label(parameter: str) -> str:
    return LABELS.get(parameter, parameter.replace("_", " "))


def _pyplot():
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as pyplot
    return pyplot


def save(figure, folder: pathlib.Path, stem: str) -> list[pathlib.Path]:
    """The figure as PNG and SVG."""
    paths = []
    for suffix in (".png", ".svg"):
        with atomic_path(folder / (stem + suffix)) as part:
            figure.savefig(part, dpi=120, bbox_inches="tight")
        paths.append(folder / (stem + suffix))
    _pyplot().close(figure)
    return paths


def bifurcation(title: str, parameter: str, values, sections, regimes, folder: pathlib.Path) -> list[pathlib.Path]:
    """Section points x (once a turn) against the swept parameter, coloured by regime."""
    pyplot = _pyplot()
    figure, (above, below) = pyplot.subplots(
        2, 1, figsize=(9, 5.6), sharex=True, gridspec_kw={"height_ratios": [12, 1], "hspace": 0.05})
    regimes = numpy.asarray(regimes)
    for regime, colour in REGIME_COLOURS.items():
        chosen = numpy.flatnonzero(regimes == regime)
        if regime == "diverged" or not len(chosen):
            continue
        x = numpy.repeat(numpy.asarray(values)[chosen], sections.shape[1])
        above.plot(x, sections[chosen, :, 0].ravel(), ".", markersize=1.6, color=colour, rasterized=True)
        above.plot([], [], ".", markersize=7, color=colour, label=regime.replace("_", " "))
    above.set_ylabel("x once a turn / clearance")
    above.set_title(title)
    above.legend(fontsize=8, loc="best")
    above.grid(alpha=0.3)
    step = numpy.median(numpy.diff(values)) if len(values) > 1 else 1.0
    below.bar(values, 1.0, width=step, color=[REGIME_COLOURS[regime] for regime in regimes])
    below.set_yticks([])
    below.set_xlabel(label(parameter))
    return save(figure, folder, "bifurcation")


def regime_map(title: str, axes, regimes, borders: list, folder: pathlib.Path,
               stem: str = "regime_map") -> list[pathlib.Path]:
    """Regime over two parameters (first axis up, last axis to the right), with borders in closed form: text, style, (x, y)."""
    pyplot = _pyplot()
    from matplotlib.colors import ListedColormap
    from matplotlib.patches import Patch
    names = list(REGIME_COLOURS)
    (up, up_values), (right, right_values) = axes
    regimes = numpy.asarray(regimes)
    grid = sum(index * (regimes == name) for index, name in enumerate(names)).reshape(len(up_values), len(right_values))
    figure, axis = pyplot.subplots(figsize=(8, 5.6))
    axis.pcolormesh(right_values, up_values, grid, cmap=ListedColormap(list(REGIME_COLOURS.values())), vmin=-0.5,
                    vmax=len(names) - 0.5, shading="nearest", rasterized=True)
    handles = [Patch(color=REGIME_COLOURS[name], label=name.replace("_", " "))
               for index, name in enumerate(names) if (grid == index).any()]
    for text, style, border in borders:
        x, y = (numpy.where(numpy.isfinite(column) & (column > 0.0), column, numpy.nan) for column in border)
        axis.plot(x, y, style, linewidth=1.5)
        handles.append(pyplot.Line2D([], [], color=style[0], linestyle=style[1:], label=text))
    axis.set_xlim(min(right_values), max(right_values))
    axis.set_ylim(min(up_values), max(up_values))
    axis.legend(handles=handles, fontsize=8, loc="upper center", bbox_to_anchor=(0.5, -0.12), ncol=4)
    axis.set(title=title, xlabel=label(right), ylabel=label(up))
    return save(figure, folder, stem)


def score_map(title: str, grid: dict, hits, total: int, folder: pathlib.Path) -> list[pathlib.Path]:
    """Best score over two of a search's axes (the two with the most values), best over all others."""
    pyplot = _pyplot()
    names = sorted(grid, key=lambda name: -len(grid[name]))[:2]
    order = list(grid)
    table = numpy.asarray(hits).reshape([len(grid[name]) for name in order])
    others = tuple(index for index, name in enumerate(order) if name not in names)
    table = table.max(axis=others)
    up, right = [name for name in order if name in names]
    figure, axis = pyplot.subplots(figsize=(8, 4.6))
    mesh = axis.pcolormesh(grid[right], grid[up], 100.0 * table / total, shading="nearest", cmap="viridis",
                           rasterized=True)
    figure.colorbar(mesh, label="best agreement over the other axes [%]")
    axis.set(title=title, xlabel=label(right), ylabel=label(up))
    return save(figure, folder, "search")


def score_cloud(title: str, names: list[str], points, scores, folder: pathlib.Path) -> list[pathlib.Path]:
    """Score of every sample over each unstated value: a peak says that the figure determines the value."""
    pyplot = _pyplot()
    columns = 4
    rows = -(-len(names) // columns)
    figure, axes = pyplot.subplots(rows, columns, figsize=(12, 2.6 * rows), sharey=True, squeeze=False,
                                   constrained_layout=True)
    for axis in axes.flat[len(names):]:
        axis.remove()
    for index, (name, axis) in enumerate(zip(names, axes.flat)):
        axis.plot(points[:, index], scores, ".", markersize=1.2, color="#3182bd", rasterized=True)
        axis.set_xlabel(label(name), fontsize=8)
        axis.grid(alpha=0.3)
    for row in axes[:, 0]:
        row.set_ylabel("mean share right")
    figure.suptitle(title)
    return save(figure, folder, "search")


BIFURCATION_MARKS = {"fold": ("s", "fold"), "flip": ("^", "flip (period doubling)"),
                     "neimark_sacker": ("D", "Neimark-Sacker"), "grazing": ("o", "grazing")}


def branches(title: str, parameter: str, found: list[dict], folder: pathlib.Path) -> list[pathlib.Path]:
    """Branches of periodic motion: stable solid, unstable dotted, bifurcations marked."""
    pyplot = _pyplot()
    figure, axes = pyplot.subplots(2, 1, figsize=(9, 7), sharex=True, gridspec_kw={"hspace": 0.08})
    colours = {1: "#08519c", 2: "#a63603", 4: "#006d2c", 8: "#54278f"}
    quantities = ((lambda point: point["state"][0], "x once a period / clearance"),
                  (lambda point: point["max_radius"], "largest radius / clearance"))
    drawn = set()
    for axis, (quantity, text) in zip(axes, quantities):
        for branch in found:
            colour = colours.get(branch["turns"], "#636363")
            x = numpy.array([point["parameter"] for point in branch["points"]])
            y = numpy.array([quantity(point) for point in branch["points"]])
            stable = numpy.array([point["stable"] for point in branch["points"]])
            begin = 0
            for index in range(1, len(x) + 1):
                if index == len(x) or stable[index] != stable[begin]:
                    part = slice(begin, min(index + 1, len(x)))
                    axis.plot(x[part], y[part], "-" if stable[begin] else ":", color=colour,
                              linewidth=1.8 if stable[begin] else 1.1)
                    begin = index
            for mark in branch["bifurcations"]:
                shape, _ = BIFURCATION_MARKS[mark["kind"]]
                axis.plot(mark["parameter"], quantity(mark), shape, color=colour, markersize=4, markerfacecolor="white")
                drawn.add(mark["kind"])
        axis.set_ylabel(text)
        axis.grid(alpha=0.3)
    handles = [pyplot.Line2D([], [], color=colours.get(turns, "#636363"), label=f"period {turns}")
               for turns in sorted({branch["turns"] for branch in found})]
    handles += [pyplot.Line2D([], [], color="k", linestyle=style, label=text)
                for style, text in (("-", "stable"), (":", "unstable"))]
    handles += [pyplot.Line2D([], [], color="k", marker=BIFURCATION_MARKS[kind][0], linestyle="", label=text,
                              markerfacecolor="white", markersize=4)
                for kind, text in ((kind, BIFURCATION_MARKS[kind][1]) for kind in BIFURCATION_MARKS if kind in drawn)]
    axes[0].set_title(title)
    axes[0].legend(handles=handles, fontsize=8, ncol=2)
    axes[1].set_xlabel(label(parameter))
    return save(figure, folder, "branches")


def outcomes(title: str, what: str, right_axis: tuple, up_axis: tuple, hit, rows: list[dict],
             folder: pathlib.Path) -> list[pathlib.Path]:
    """Which samples ended so, over two drawn values (name, values), and the probability of each design with its interval."""
    pyplot = _pyplot()
    figure, (left, right) = pyplot.subplots(1, 2, figsize=(10, 4.2), gridspec_kw={"width_ratios": [1.3, 1]})
    for chosen, colour, text in ((~hit, REGIME_COLOURS["no_contact"], "other"), (hit, REGIME_COLOURS["dry_whirl"], what)):
        left.plot(right_axis[1][chosen], up_axis[1][chosen], ".", markersize=2.5, color=colour, label=text, rasterized=True)
    left.set(xlabel=label(right_axis[0]), ylabel=label(up_axis[0]), title=title)
    left.legend(fontsize=8, loc="upper left")
    values = numpy.array([row["probability"] for row in rows])
    spread = numpy.array([[row["probability"] - row["low"], row["high"] - row["probability"]] for row in rows]).T
    right.errorbar(values, range(len(rows)), xerr=spread, fmt="o", color=REGIME_COLOURS["dry_whirl"], capsize=3)
    right.set_yticks(range(len(rows)), [row["design"] for row in rows], fontsize=8)
    right.invert_yaxis()
    right.set(xlabel=f"probability of {what}, 95 % interval")
    right.grid(alpha=0.3)
    figure.tight_layout()
    return save(figure, folder, "probability")


DROP_COLOURS = {"free": "#c6dbef", "rest": "#9ecae1", "oscillation": "#4292c6", "spring": "#fdae6b",
                "forward_whirl": "#74c476", "backward_whirl": "#de2d26", "magnet_hit": "#6a51a3",
                "diverged": "#252525"}


def drop_map(title: str, grid: dict, points: list[dict], folder: pathlib.Path) -> list[pathlib.Path]:
    """Motions over two of a grid's axes (the two with the most values): the share of each motion as a pie a place."""
    pyplot = _pyplot()
    names = sorted(grid, key=lambda name: -len(grid[name]))[:2]
    up, right = (names + names)[:2] if len(names) > 1 else (names[0], names[0])
    figure, axis = pyplot.subplots(figsize=(8, 5.6))
    drawn = set()
    for row, up_value in enumerate(grid[up]):
        for column, right_value in enumerate(grid[right]):
            here = [point["motion"].kind for point in points
                    if point["values"][up] == up_value and point["values"][right] == right_value]
            if not here:
                continue
            shares = [(kind, here.count(kind) / len(here)) for kind in DROP_COLOURS if kind in here]
            drawn.update(kind for kind, _ in shares)
            axis.pie([share for _, share in shares], colors=[DROP_COLOURS[kind] for kind, _ in shares], radius=0.42,
                     center=(column, row), frame=True, normalize=True)
    axis.set_aspect("equal")
    axis.set_xticks(range(len(grid[right])), [f"{value:g}" for value in grid[right]], fontsize=8, rotation=45)
    axis.set_yticks(range(len(grid[up])), [f"{value:g}" for value in grid[up]], fontsize=8)
    axis.set_xlim(-0.6, len(grid[right]) - 0.4)
    axis.set_ylim(-0.6, len(grid[up]) - 0.4)
    handles = [pyplot.Line2D([], [], marker="o", linestyle="", color=DROP_COLOURS[kind], label=kind.replace("_", " "))
               for kind in DROP_COLOURS if kind in drawn]
    axis.legend(handles=handles, fontsize=8, loc="upper center", bbox_to_anchor=(0.5, -0.16), ncol=4)
    axis.set(title=title, xlabel=right.rsplit(".", 1)[-1], ylabel=up.rsplit(".", 1)[-1])
    figure.tight_layout()
    return save(figure, folder, "drop_map")
