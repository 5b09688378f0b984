"""Pictures of a recorded motion: orbit in the clearance, Poincare section, full spectrum."""
from __future__ import annotations

import numpy

from amb_rotor.plots.maps import save

FREE, TOUCHING, POINTS = "#1f6fb4", "#c4442d", "#111111"


def end_motion(table: dict, end: str, clearance: float):
    """Place in the auxiliary bearing of an end in units of the clearance, and whether it is touched."""
    x = (table[f"aux_{end}x_m"] - table[f"centre_{end}x_m"]) / clearance
    y = (table[f"aux_{end}y_m"] - table[f"centre_{end}y_m"]) / clearance
    return x, y, table[f"normal_{end}_N"] > 0.0


def clearance_circle(axes, centre=(0.0, 0.0), label: str | None = None):
    angle = numpy.linspace(0.0, 2.0 * numpy.pi, 361)
    axes.plot(centre[0] + numpy.cos(angle), centre[1] + numpy.sin(angle), color="#666666", lw=1.1, label=label)
    axes.set_aspect("equal")


def coloured_orbit(axes, x, y, touching, text: str = "in contact"):
    """The orbit, red where it touches; the sample on either side of a contact belongs to it."""
    wide = touching.copy()
    wide[1:] |= touching[:-1]
    wide[:-1] |= touching[1:]
    axes.plot(x, y, color=FREE, lw=0.6, label="free")
    axes.plot(numpy.where(wide, x, numpy.nan), numpy.where(wide, y, numpy.nan), color=TOUCHING, lw=0.8, label=text)


def orbit(path, table: dict, clearance: float, phases: list):
    """phases: (title, from_s, to_s), a column each; rows: ends a and b."""
    import matplotlib.pyplot as plt
    figure, panes = plt.subplots(2, len(phases), figsize=(3.6 * len(phases), 7.0), constrained_layout=True,
                                 squeeze=False, sharex=True, sharey=True)
    for row, end in enumerate("ab"):
        x, y, touching = end_motion(table, end, clearance)
        for column, (title, begin, finish) in enumerate(phases):
            part = (table["t_s"] >= begin) & (table["t_s"] < finish)
            axes = panes[row][column]
            clearance_circle(axes)
            coloured_orbit(axes, x[part], y[part], touching[part])
            if row == 0:
                axes.set_title(f"{title}\n{begin:g} to {finish:g} s", fontsize=10)
            else:
                axes.set_xlabel("x / clearance [-]")
        panes[row][0].set_ylabel(f"end {end}: y / clearance [-]")
    panes[0][0].legend(loc="upper right", fontsize=8, frameon=False)
    return save(figure, path)


def poincare(path, table: dict, clearance: float, phases: list):
    """Places at the tacho pulse, end b, coloured by phase."""
    import matplotlib.pyplot as plt
    from amb_rotor import _core
    x, y, _ = end_motion(table, "b", clearance)
    times, px, py = _core.stroboscopic_section(table["t_s"], table["angle_rad"], x, y)
    figure, axes = plt.subplots(figsize=(5.4, 5.2), constrained_layout=True)
    clearance_circle(axes)
    for (title, begin, finish), colour in zip(phases, ("#1f6fb4", "#c4442d", "#2a7d4f", "#7350a8")):
        part = (times >= begin) & (times < finish)
        axes.plot(px[part], py[part], "o", ms=4, color=colour, label=f"{title} ({int(part.sum())} turns)")
    axes.set(xlabel="x / clearance [-]", ylabel="y / clearance [-]")
    axes.set_title("Poincare section at the tacho pulse, end b", fontsize=11)
    axes.legend(fontsize=8, frameon=False, loc="upper center", bbox_to_anchor=(0.5, -0.12), ncol=3)
    return save(figure, path)


def spectrum(path, table: dict, phases: list):
    """Full spectrum of end b: forward at positive, backward at negative frequencies, a row each phase."""
    import matplotlib.pyplot as plt
    from amb_rotor import _core
    rate = (len(table["t_s"]) - 1) / (table["t_s"][-1] - table["t_s"][0])
    figure, panes = plt.subplots(len(phases), 1, figsize=(7.2, 2.2 * len(phases)), constrained_layout=True, sharex=True,
                                 squeeze=False)
    for axes, (title, begin, finish) in zip(panes[:, 0], phases):
        part = (table["t_s"] >= begin) & (table["t_s"] < finish)
        frequency, amplitude = _core.full_spectrum(table["aux_bx_m"][part], table["aux_by_m"][part], rate)
        speed = float(numpy.mean(table["speed_Hz"][part]))
        shown = numpy.abs(frequency) <= 1000.0
        axes.semilogy(frequency[shown], 1e6 * numpy.maximum(amplitude[shown], 1e-12), color=FREE, lw=1.0)
        axes.axvline(speed, color="#999999", lw=0.8, ls="--")
        axes.axvline(-speed, color="#999999", lw=0.8, ls="--")
        axes.set_ylim(bottom=1e-3)
        axes.set_ylabel("amplitude [µm]")
        axes.set_title(f"{title}, end b; dashed: the speed, forward and backward", fontsize=10)
    panes[-1, 0].set_xlabel("frequency [Hz], negative: backward")
    return save(figure, path)
