"""Pictures of any motion (amb_rotor/motion.py): one function a kind, each returns a figure of matplotlib."""
from __future__ import annotations

import numpy

from amb_rotor.motion import Motion
from amb_rotor.plots.motion import FREE, POINTS, TOUCHING, clearance_circle, coloured_orbit

LINES, OVERLAP = 24, 0.75   # of a waterfall
HIGHEST_ORDER = 4.0     # of the shaft's speed that spectra are drawn to
LEAST_POINTS = 8        # of a section


def _figure(size, **options):
    import matplotlib.pyplot as plt
    return plt.subplots(figsize=size, constrained_layout=True, **options)


def _length(motion: Motion, axis: str) -> str:
    return f"{axis} [µm]" if motion.units.si else f"{axis} / {motion.units.length}"


def _highest(motions: list[Motion]) -> float:
    """Frequency that spectra are drawn to; where the shaft stands, all."""
    top = max(abs(motion.mean_speed) for motion in motions)
    all_of_it = min(0.5 * motion.rate * 2.0 * numpy.pi * motion.units.speed_factor for motion in motions)
    return min(HIGHEST_ORDER * top, all_of_it) if top > 0.0 else all_of_it


def _frequency(motion: Motion, cycles):
    """From cycles per unit of time to the unit of the axis."""
    return 2.0 * numpy.pi * motion.units.speed_factor * numpy.asarray(cycles)


def history(motion: Motion):
    """x, y and the distance from the bearing's centre over the time; red: beyond the clearance or in contact."""
    figure, (above, below) = _figure((9.0, 5.0), nrows=2, sharex=True)
    factor = motion.units.length_factor
    above.plot(motion.time, factor * motion.x, color=FREE, lw=0.7, label="x")
    above.plot(motion.time, factor * motion.y, color="#2a7d4f", lw=0.7, label="y")
    above.set(ylabel=_length(motion, "x, y"), title=motion.name)
    above.legend(fontsize=8, loc="upper right", ncol=2)
    radius = numpy.hypot(motion.sx, motion.sy) / motion.clearance
    below.plot(motion.time, radius, color=FREE, lw=0.7)
    below.plot(motion.time, numpy.where(motion.touching, radius, numpy.nan), color=TOUCHING, lw=0.9, label=_touching(motion))
    below.axhline(1.0, color="#777777", lw=0.8, ls="--", label="clearance")
    below.set(xlabel=motion.units.time, ylabel="distance / clearance")
    below.legend(fontsize=8, loc="upper right", ncol=2)
    for axes in (above, below):
        axes.grid(alpha=0.3)
        axes.margins(x=0.0)
    return figure


def _touching(motion: Motion) -> str:
    return "in contact" if motion.normal is not None else "beyond the clearance"


def orbit(motion: Motion):
    """About the auxiliary bearing's centre."""
    figure, axes = _figure((5.4, 5.4))
    clearance_circle(axes)
    coloured_orbit(axes, motion.sx / motion.clearance, motion.sy / motion.clearance, motion.touching, _touching(motion))
    axes.set(xlabel="x / clearance", ylabel="y / clearance", title=f"{motion.name}\n{motion.plane}".strip())
    axes.legend(fontsize=8, loc="upper right")
    return figure


def section_points(motion: Motion, phase: float = 0.0):
    """Times, x, y about the bearing's centre, over the clearance, once a turn."""
    from amb_rotor import _core
    time, x, y = _core.stroboscopic_section(motion.time, motion.angle, motion.sx, motion.sy, phase)
    return time, x / motion.clearance, y / motion.clearance


def section(motion: Motion, phase: float = 0.0):
    time, x, y = section_points(motion, phase)
    if len(time) < LEAST_POINTS:
        return None
    return _points(motion, time, x, y, f"once a turn, at {numpy.degrees(phase):g} deg of the shaft; {len(time)} turns")


SURFACES = {
    "radial": ("turning points outwards (radial velocity falls through 0)", "falling"),
    "x": ("x of the bearing's centre, to the right", "rising"),
    "y": ("y of the bearing's centre, upwards", "rising"),
}


def surface_points(motion: Motion, surface: str):
    """Times, x, y, vx, vy about the centre, over the clearance, where the motion passes the surface."""
    from amb_rotor import _core
    values = {"x": motion.sx, "y": motion.sy,
              "radial": numpy.gradient(numpy.hypot(motion.sx, motion.sy), motion.time)}[surface]
    found = _core.surface_section(motion.time, values, motion.sx, motion.sy, SURFACES[surface][1])
    return (found[0], *(numpy.asarray(column) / motion.clearance for column in found[1:]))


def surface(motion: Motion, kind: str = "radial"):
    """Poincare section by a surface: in the plane for turning points, else the other place and its velocity."""
    time, x, y, vx, vy = surface_points(motion, kind)
    if len(time) < LEAST_POINTS:
        return None
    text = f"{SURFACES[kind][0]}; {len(time)} points"
    if kind == "radial":
        return _points(motion, time, x, y, text)
    figure, axes = _figure((5.8, 5.0))
    other, place, velocity = ("y", y, vy) if kind == "x" else ("x", x, vx)
    shown = axes.scatter(place, velocity, c=time, s=6, cmap="viridis")
    figure.colorbar(shown, label=motion.units.time)
    rate = "[clearances / s]" if motion.units.si else "/ (clearance $\\omega_n$)"
    axes.set(xlabel=f"{other} / clearance", ylabel=f"velocity of {other} {rate}", title=f"{motion.name}\n{text}")
    axes.grid(alpha=0.3)
    return figure


def _points(motion: Motion, time, x, y, text: str):
    """Points in the clearance circle and, beside it, near to."""
    figure, (whole, near) = _figure((10.0, 4.9), ncols=2)
    clearance_circle(whole)
    span = max(numpy.ptp(x), numpy.ptp(y), 0.02)
    for axes in (whole, near):
        shown = axes.scatter(x, y, c=time, s=6, cmap="viridis")
        axes.set(xlabel="x / clearance", ylabel="y / clearance")
        axes.set_aspect("equal")
        axes.grid(alpha=0.3)
    for limits, column in ((near.set_xlim, x), (near.set_ylim, y)):
        middle = 0.5 * (column.max() + column.min())
        limits(middle - 0.6 * span, middle + 0.6 * span)
    figure.colorbar(shown, ax=near, label=motion.units.time)
    figure.suptitle(f"{motion.name}: {text}")
    return figure


def spectrum(motion: Motion):
    """Amplitude spectra of x and y (Hann window)."""
    from amb_rotor import _core
    figure, panes = _figure((8.5, 4.8), nrows=2, sharex=True, sharey=True)
    highest = _highest([motion])
    for axes, axis in zip(panes, "xy"):
        cycles, amplitude = _core.amplitude_spectrum(getattr(motion, axis), motion.rate)
        _line(axes, motion, _frequency(motion, cycles), amplitude, (0.0, highest))
        axes.set_ylabel(_length(motion, f"amplitude of {axis}"))
        for order in (0.5, 1.0, 1.5, 2.0, 3.0):
            axes.axvline(order * abs(motion.mean_speed), color="#999999", lw=0.7, ls="--" if order == 1.0 else ":")
    panes[0].set_title(f"{motion.name}: spectrum; dashed 1X, dotted 1/2, 3/2, 2 and 3X")
    panes[1].set_xlabel(f"frequency {motion.units.frequency}")
    return figure


def full_spectrum(motion: Motion):
    """Forward at positive, backward at negative frequencies."""
    from amb_rotor import _core
    figure, axes = _figure((8.5, 3.4))
    cycles, amplitude = _core.full_spectrum(motion.x, motion.y, motion.rate)
    highest = _highest([motion])
    _line(axes, motion, _frequency(motion, cycles), amplitude, (-highest, highest))
    for sense in (-1.0, 1.0):
        axes.axvline(sense * motion.mean_speed, color="#999999", lw=0.7, ls="--")
    axes.set(xlabel=f"frequency {motion.units.frequency}, negative: backward whirl", ylabel=_length(motion, "amplitude"),
             title=f"{motion.name}: full spectrum; dashed: the speed, forward and backward")
    return figure


def _line(axes, motion: Motion, frequency, amplitude, limits):
    shown = (frequency >= limits[0]) & (frequency <= limits[1])
    values = motion.units.length_factor * numpy.asarray(amplitude)[shown]
    axes.semilogy(frequency[shown], numpy.maximum(values, 1e-6 * values.max(initial=1e-30)), color=FREE, lw=0.9)
    axes.set_xlim(*limits)
    axes.grid(alpha=0.3)


def waterfall(motion: Motion):
    """Short-time spectra of x, one behind the other: over the speed where it varies, else over the time."""
    from amb_rotor import _core
    length = int(len(motion.time) / (1.0 + (LINES - 1) * (1.0 - OVERLAP)))
    if length < 32:
        return None
    found = _core.waterfall(motion.x, [], motion.rate, length, OVERLAP, motion.speed, motion.time[0])
    if motion.speed_varies():
        order = numpy.argsort(found["speed"])
        heights = motion.units.speed_factor * found["speed"][order]
        return stacked(motion, [(height, _frequency(motion, found["frequency"]), found["amplitude"][line])
                                for height, line in zip(heights, order)], motion.units.speed, f"{motion.name}: waterfall")
    lines = [(time, _frequency(motion, found["frequency"]), row) for time, row in zip(found["time"], found["amplitude"])]
    return stacked(motion, lines, motion.units.time, f"{motion.name}: waterfall", orders=False)


def cascade(motions: list[Motion], heights=None, text: str = ""):
    """Spectra of x of several motions, one behind the other over their speeds, or over `heights`."""
    from amb_rotor import _core
    of_speed = heights is None
    heights = [motion.mean_speed for motion in motions] if of_speed else heights
    lines = []
    for height, motion in sorted(zip(heights, motions), key=lambda pair: pair[0]):
        cycles, amplitude = _core.amplitude_spectrum(motion.x, motion.rate)
        lines.append((height, _frequency(motion, cycles), numpy.asarray(amplitude)))
    return stacked(motions[0], lines, text or motions[0].units.speed, "cascade", orders=of_speed, highest=_highest(motions))


def stacked(motion: Motion, lines: list, ylabel: str, title: str, orders: bool = True, highest: float = 0.0):
    """lines: (height, frequencies, amplitudes), rising heights; `orders`: heights are speeds, and 1/2, 1, 3/2, 2X are drawn."""
    figure, axes = _figure((8.5, 6.2))
    heights = numpy.array([line[0] for line in lines])
    spread = max(numpy.ptp(heights), 1e-12)
    tops = [line[2][1:].max(initial=0.0) for line in lines]
    largest = max(max(tops), 1e-300)
    highest = highest or _highest([motion])
    for index in range(len(lines) - 1, -1, -1):
        height, frequency, amplitude = lines[index]
        shown = (frequency <= highest) & (frequency > 0.0)
        y = height + 0.14 * spread * amplitude[shown] / largest
        layer = 2 * (len(lines) - index)
        axes.fill_between(frequency[shown], height, y, color="white", zorder=layer)
        axes.plot(frequency[shown], y, color=FREE, lw=0.6, zorder=layer + 1)
    if orders:
        for order, text in ((0.5, "1/2X"), (1.0, "1X"), (1.5, "3/2X"), (2.0, "2X")):
            if order * heights[-1] <= highest:
                axes.plot(order * heights, heights, ":", color="#aaaaaa", lw=0.8, zorder=1)
                axes.text(order * heights[-1], heights[-1] + 0.17 * spread, text, ha="center", fontsize=8, color="#555555")
    scale = motion.units.length_factor * largest
    axes.set(xlabel=f"frequency {motion.units.frequency}", xlim=(0.0, highest), ylim=(heights[0] - 0.02 * spread, heights[-1] + 0.22 * spread),
             ylabel=ylabel, title=f"{title}; height of a line: amplitude of x, highest {scale:.3g} {motion.units.plain[0]}")
    return figure


def contact_force(motion: Motion):
    if motion.normal is None:
        return None
    figure, axes = _figure((9.0, 3.4))
    axes.plot(motion.time, motion.normal, color=TOUCHING, lw=0.8)
    axes.set(xlabel=motion.units.time, ylabel=f"normal force {motion.units.force}", title=f"{motion.name}: contact force")
    axes.grid(alpha=0.3)
    axes.margins(x=0.0)
    return figure


def contacts(motion: Motion) -> list[slice]:
    """The contacts as runs of samples, those cut off by the ends of the record left out."""
    change = numpy.diff(motion.touching.astype(int))
    begins, ends = numpy.flatnonzero(change == 1) + 1, numpy.flatnonzero(change == -1) + 1
    ends = ends[ends > begins[0]] if len(begins) else ends[:0]
    return [slice(begin, end) for begin, end in zip(begins, ends)]


def hysteresis(motion: Motion):
    """Force over penetration, a loop a contact, and what each loop takes out of the motion."""
    spans = contacts(motion) if motion.normal is not None else []
    if not spans:
        return None
    figure, (left, right) = _figure((10.0, 4.2), ncols=2)
    factor = motion.units.length_factor
    lost = []
    for span in spans:
        wide = slice(max(span.start - 1, 0), span.stop + 1)
        depth, force = numpy.maximum(motion.depth[wide], 0.0), motion.normal[wide]
        left.plot(factor * depth, force, color=TOUCHING, lw=0.6, alpha=max(0.15, min(1.0, 20.0 / len(spans))))
        lost.append(float(numpy.sum(0.5 * (force[1:] + force[:-1]) * numpy.diff(depth))))
    left.set(xlabel=_length(motion, "penetration"), ylabel=f"normal force {motion.units.force}",
             title=f"{len(spans)} contacts, {numpy.mean([s.stop - s.start for s in spans]):.0f} samples each")
    unit = "[J]" if motion.units.si else "/ (clearance² $k_1$)"
    right.plot(motion.time[[span.start for span in spans]], lost, ".", color=POINTS, ms=4)
    right.set(xlabel=motion.units.time, ylabel=f"work lost {unit}", title="of each contact: the loop's area")
    for axes in (left, right):
        axes.grid(alpha=0.3)
    figure.suptitle(f"{motion.name}: hysteresis of the contact")
    return figure


def response(rows: dict, motion: Motion, xlabel: str):
    """Synchronous amplitude and phase of x; rows: name -> (values, complex amplitudes in the motion's length)."""
    figure, (above, below) = _figure((8.5, 6.0), nrows=2, sharex=True, height_ratios=(2, 1))
    for (name, (values, amplitude)), colour, style in zip(rows.items(), (TOUCHING, FREE, "#2a7d4f"), ("-", "--", "-.")):
        above.plot(values, motion.units.length_factor * numpy.abs(amplitude), style, color=colour, lw=1.4, label=name)
        below.plot(values, numpy.degrees(numpy.angle(amplitude)), ".", color=colour, ms=3)
    above.set(ylabel=_length(motion, "synchronous amplitude of x"), title=motion.name)
    above.set_ylim(bottom=0.0)
    above.legend(fontsize=8)
    below.set(xlabel=xlabel, ylabel="phase [deg]", ylim=(-185.0, 185.0), yticks=(-180, -90, 0, 90, 180))
    for axes in (above, below):
        axes.grid(alpha=0.3)
    return figure


def bifurcation(values, points, motion: Motion, xlabel: str):
    """Section points x over a parameter; `values` and `points` of one length."""
    figure, axes = _figure((9.0, 4.6))
    axes.plot(values, points, ".", ms=1.8, color=POINTS, rasterized=True)
    axes.set(xlabel=xlabel, ylabel="x once a turn / clearance", title=f"{motion.name}: bifurcation diagram")
    axes.grid(alpha=0.3)
    return figure
