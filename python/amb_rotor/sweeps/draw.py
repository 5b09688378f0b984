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
    "misalignment": "displacement of the auxiliary bearing / clearance",
    "misalignment_angle_deg": "direction of the displacement [deg]",
    "eccentricity": "eccentricity / clearance",
    "damping": "damping  $d_1 / (m \\omega_n)$",
    "friction_sign": "friction direction",
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


def regime_map(title: str, axes, regimes, border, folder: pathlib.Path) -> list[pathlib.Path]:
    """Regime over two parameters (first axis up, last axis to the right), with an analytic border if given."""
    pyplot = _pyplot()
    from matplotlib.colors import ListedColormap
    from matplotlib.patches import Patch
    names = list(REGIME_COLOURS)
    (up, up_values), (right, right_values) = axes
    grid = numpy.array([names.index(regime) for regime in regimes]).reshape(len(up_values), len(right_values))
    figure, axis = pyplot.subplots(figsize=(8, 5.6))
    axis.pcolormesh(right_values, up_values, grid, cmap=ListedColormap(list(REGIME_COLOURS.values())), vmin=-0.5,
                    vmax=len(names) - 0.5, shading="nearest", rasterized=True)
    handles = [Patch(color=REGIME_COLOURS[name], label=name.replace("_", " "))
               for index, name in enumerate(names) if (grid == index).any()]
    if border is not None:
        axis.plot(*border, "k-", linewidth=1.5)
        handles.append(pyplot.Line2D([], [], color="k", label="annular rub: border of stability (closed form)"))
        axis.set_ylim(min(up_values), max(up_values))
    axis.legend(handles=handles, fontsize=8, loc="upper center", bbox_to_anchor=(0.5, -0.12), ncol=4)
    axis.set(title=title, xlabel=label(right), ylabel=label(up))
    return save(figure, folder, "regime_map")


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
