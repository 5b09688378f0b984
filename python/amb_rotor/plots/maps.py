"""Campbell diagram, sensitivity, equivalent stiffness and damping as PNG and SVG."""
from __future__ import annotations

from amb_rotor.cli import common

COLOURS = {"forward": "#1f6fb4", "backward": "#c4442d", "planar": "#555555"}


def save(figure, path, *more):
    """Writes a figure whole or not at all, as the ending of `path` says, and beside it with the endings of `more`."""
    import matplotlib.pyplot as plt
    for target in (path, *(path.with_suffix(suffix) for suffix in more)):
        with common.atomic_path(target) as part:
            figure.savefig(part, dpi=130)
    plt.close(figure)
    return path


def campbell(path, title, speeds, rows):
    """Frequencies and damping ratios of every mode over the speed, with the 1X line."""
    import matplotlib.pyplot as plt
    figure, (top, bottom) = plt.subplots(2, 1, figsize=(7.5, 8.0), sharex=True, constrained_layout=True,
                                         height_ratios=(2, 1))
    for whirl, colour in COLOURS.items():
        points = [(speed, mode) for speed, row in zip(speeds, rows) for mode in row if mode.whirl == whirl]
        if not points:
            continue
        top.plot([speed for speed, _ in points], [mode.damped_frequency_hz for _, mode in points], ".", ms=4,
                 color=colour, label=whirl)
        bottom.plot([speed for speed, _ in points], [mode.damping_ratio for _, mode in points], ".", ms=4, color=colour)
    top.plot(speeds, speeds, "--", lw=1, color="#999999", label="1X")
    # modes far above all speeds would press the others together
    near = [mode.damped_frequency_hz for row in rows for mode in row if mode.damped_frequency_hz < 4.0 * max(speeds)]
    top.set_ylim(0.0, 1.1 * max(near + [max(speeds)]))
    top.set_ylabel("damped frequency [Hz]")
    top.set_title(title)
    top.legend(loc="upper left", frameon=False)
    bottom.axhline(0.0, lw=0.8, color="#999999")
    bottom.set_ylabel("damping ratio [-]")
    bottom.set_xlabel("speed [Hz]")
    return save(figure, path, ".svg")


def sensitivity(path, title, frequencies, rows):
    """Sensitivity of the four loops with the zones of ISO 14839-3."""
    import matplotlib.pyplot as plt
    import numpy
    figure, axes = plt.subplots(figsize=(7.5, 4.5), constrained_layout=True)
    for name, row in zip(("ax", "ay", "bx", "by"), rows):
        axes.semilogx(frequencies, 20 * numpy.log10(row), lw=1.4, label=name)
    for limit, label in ((3.0, "A | B"), (4.0, "B | C"), (5.0, "C | D")):
        axes.axhline(20 * numpy.log10(limit), lw=0.8, ls="--", color="#999999")
        axes.text(frequencies[0] * 1.05, 20 * numpy.log10(limit) + 0.15, label, color="#666666", fontsize=8)
    axes.set_xlabel("frequency [Hz]")
    axes.set_ylabel("sensitivity [dB]")
    axes.set_title(f"{title}: ISO 14839-3")
    axes.legend(frameon=False, ncol=4)
    return save(figure, path, ".svg")


def equivalent(path, title, bearings):
    """Equivalent stiffness and damping of the bearings over the frequency."""
    import matplotlib.pyplot as plt
    figure, panels = plt.subplots(2, 1, figsize=(7.5, 6.5), sharex=True, constrained_layout=True)
    for axes, key, label in zip(panels, ("stiffness_N_per_m", "damping_N_s_per_m"),
                                ("stiffness $k_1$ [N/m]", "damping $d_1$ [N s/m]")):
        for name, row in bearings[key].items():
            axes.semilogx(bearings["frequency_hz"], row, lw=1.4, label=name)
        axes.axhline(0.0, lw=0.8, color="#999999")
        axes.set_ylabel(label)
    panels[0].set_title(f"{title}: each bearing, by the response of its control")
    panels[0].legend(frameon=False, ncol=4)
    panels[1].set_xlabel("frequency [Hz]")
    return save(figure, path, ".svg")
