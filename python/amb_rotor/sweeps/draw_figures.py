"""Pictures of single motions: section with orbit and time history, contact force, waterfall, response, impact."""
from __future__ import annotations

import pathlib

import numpy

from amb_rotor.plots.motion import FREE, POINTS, TOUCHING, clearance_circle, coloured_orbit
from amb_rotor.sweeps.draw import _pyplot, save


def motion(title: str, found: dict, folder: pathlib.Path, shown_turns: int, per_turn: int):
    """Left Poincare section, right orbit in the clearance circle, below the time history of x."""
    pyplot = _pyplot()
    figure = pyplot.figure(figsize=(9, 7.2), constrained_layout=True)
    grid = figure.add_gridspec(2, 2, height_ratios=[2, 1])
    section, orbit, history = (figure.add_subplot(grid[0, 0]), figure.add_subplot(grid[0, 1]),
                               figure.add_subplot(grid[1, :]))
    section.plot(found["section"][:, 0], found["section"][:, 1], ".", ms=4, color=POINTS)
    span = max(numpy.ptp(found["section"], axis=0).max(), 0.02)
    for limits, column in ((section.set_xlim, 0), (section.set_ylim, 1)):
        middle = 0.5 * (found["section"][:, column].max() + found["section"][:, column].min())
        limits(middle - 0.65 * span, middle + 0.65 * span)
    section.set(xlabel="x / clearance", ylabel="y / clearance", title="once a turn")
    section.set_aspect("equal")
    section.grid(alpha=0.3)
    last = slice(-shown_turns * per_turn, None)
    touching = found["normal_force"][last] > 0.0
    clearance_circle(orbit, found["misalignment"])
    coloured_orbit(orbit, found["x"][last], found["y"][last], touching)
    orbit.set(xlabel="x / clearance", ylabel="y / clearance", title=f"orbit of {shown_turns} turns, clearance circle")
    orbit.legend(fontsize=8, loc="upper right")
    history.plot(found["time"][last], found["x"][last], color=FREE, lw=0.8)
    history.set(xlabel="time times natural frequency  $\\tau$", ylabel="x / clearance")
    history.grid(alpha=0.3)
    figure.suptitle(title)
    return save(figure, folder, "motion")


def contact_force(title: str, found: dict, folder: pathlib.Path):
    """Normal force over the time."""
    pyplot = _pyplot()
    figure, axis = pyplot.subplots(figsize=(9, 3.4), constrained_layout=True)
    axis.plot(found["time"], found["normal_force"], color=TOUCHING, lw=0.8)
    axis.set(xlabel="time times natural frequency  $\\tau$", ylabel="normal force / (clearance $k_1$)", title=title)
    axis.grid(alpha=0.3)
    return save(figure, folder, "contact_force")


def waterfall(title: str, found: dict, folder: pathlib.Path, highest: float = 3.0):
    """Spectra one behind the other; abscissa: frequency over the natural frequency."""
    pyplot = _pyplot()
    figure, axis = pyplot.subplots(figsize=(8, 6.4), constrained_layout=True)
    driving, amplitude = found["driving"], found["amplitude"]
    raise_by = 0.14 * (driving[-1] - driving[0]) / max(amplitude.max(), 1e-12)
    for index in range(len(driving) - 1, -1, -1):
        x = found["order"] * driving[index]
        shown = x <= highest
        y = driving[index] + raise_by * amplitude[index, shown]
        axis.fill_between(x[shown], driving[index], y, color="white", zorder=2 * (len(driving) - index))
        axis.plot(x[shown], y, color=FREE, lw=0.6, zorder=2 * (len(driving) - index) + 1)
    for order, text in ((0.5, "1/2$\\times$"), (1.0, "1$\\times$"), (1.5, "3/2$\\times$"), (2.0, "2$\\times$")):
        axis.text(order * driving[-1], driving[-1] * 1.1, text, ha="center", fontsize=9, color="#555555")
    axis.set(xlabel="frequency / natural frequency", title=f"{title}\n",
             ylabel=f"driving frequency $\\eta$ (height of a line: amplitude of x, highest {amplitude.max():.3g} clearances)",
             ylim=(driving[0] - 0.02, driving[-1] * 1.15))
    return save(figure, folder, "waterfall")


def response(title: str, found: dict, folder: pathlib.Path):
    """Amplitude over the speed, up and down, over the closed forms."""
    pyplot = _pyplot()
    figure, axis = pyplot.subplots(figsize=(8.5, 5), constrained_layout=True)
    driving = found["driving"]
    axis.plot(driving, numpy.minimum(found["free"], 3.0), color="#999999", lw=1.0, label="without auxiliary bearing (5.8)")
    for stable, style, text in ((True, "-", "full annular rub, stable (closed form)"), (False, ":", "unstable")):
        points = [(eta, radius) for eta, rubs in zip(driving, found["rub"]) for radius, holds in rubs if holds == stable]
        if points:
            axis.plot(*numpy.array(points).T, ".", ms=2.5 if stable else 1.2, color="#31a354", label=text)
    axis.plot(driving, found["up"], color=TOUCHING, lw=1.6, label="run-up")
    axis.plot(driving, found["down"], "--", color=FREE, lw=1.6, label="run-down")
    axis.set(xlabel="driving frequency over natural frequency  $\\eta$", ylabel="synchronous amplitude of x / clearance",
             title=title, ylim=(0.0, None))
    axis.legend(fontsize=8)
    axis.grid(alpha=0.3)
    return save(figure, folder, "response")


def impact(title: str, found: dict, folder: pathlib.Path):
    """Force over penetration, and over the time."""
    pyplot = _pyplot()
    figure, (left, right) = pyplot.subplots(1, 2, figsize=(9, 3.8), constrained_layout=True)
    left.plot(1e6 * found["depth_m"], found["force_N"], color=TOUCHING)
    left.set(xlabel="penetration [µm]", ylabel="normal force [N]", title="hysteresis loop")
    right.plot(1e3 * found["time_s"], found["force_N"], color=TOUCHING)
    right.set(xlabel="time [ms]", ylabel="normal force [N]", title="over the time")
    for axis in (left, right):
        axis.grid(alpha=0.3)
    figure.suptitle(title)
    return save(figure, folder, "impact")
