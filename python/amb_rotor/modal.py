"""Modes, maps and margins of a machine linearised about its centre, with the sampled control loop closed exactly.

Over one period T of the controller the rotor, the amplifiers and the lags behind them are propagated by the matrix
exponential under the held commands, with the command changing where the delay ends inside the period; the controller is
its difference equation, whatever its kind. An eigenvalue z of that map is the continuous s = ln(z)/T + 2 pi j k/T: samples do
not tell which k, the rotor does (_unfolded), so that a bending mode above half the sample rate stands at its own frequency with
its own whirl; the loop's other motions do not exist there. A bearing without a controller (equivalent) has the eigenvalues of its state matrix.

Left out: contact, the limits of current and voltage, the steps of the converters, the static position under gravity.
"""
from __future__ import annotations

import dataclasses
import math

import numpy
import scipy.linalg

from amb_rotor.errors import InputError

AXES = ("ax", "ay", "bx", "by")
# Roots with more damping than this are no oscillation that a person would call a mode.
LARGEST_DAMPING_RATIO = 0.95
# Of bending modes that samples fold: their damping ratio without control, how far control moves them (relative), and the share of
# the misfit of displacements to velocities that unfolding leaves, some hundredths mostly.
LIGHT, MOVED, UNFOLDED = 0.2, 0.02, 0.5
# Eigenvalues closer than this (relative) are one, and their directions arbitrary.
EQUAL = 1e-5


@dataclasses.dataclass
class Mode:
    frequency_hz: float         # natural: |s|/(2 pi)
    damped_frequency_hz: float
    damping_ratio: float
    whirl: str                  # forward, backward, planar
    whirl_measure: float        # 1 forward circle, -1 backward circle, 0 a line
    shape: dict                 # plane -> complex x, y at ends a and b


@dataclasses.dataclass
class Loop:
    """z_(n+1) = a z_n + b e_n,  s_n = c z_n, with e added to the sensors' signals."""
    a: numpy.ndarray
    b: numpy.ndarray
    c: numpy.ndarray
    period_s: float
    states: int  # of the machine's mechanics, the first of z


def _held(parts) -> tuple[numpy.ndarray, numpy.ndarray, numpy.ndarray]:
    """Mechanics, currents and lags: x' = a x + b command, signal = c x."""
    if parts["coils"]:
        return numpy.asarray(parts["a"]), numpy.asarray(parts["b"]), numpy.asarray(parts["c"])
    mechanics = parts["a"].shape[0]
    rates, weights = list(parts["relaxation_rates"]), list(parts["relaxation_weights"])
    lags = len(rates)
    size = mechanics + 4 + 4 * lags
    a, b = numpy.zeros((size, size)), numpy.zeros((size, 4))
    a[:mechanics, :mechanics] = parts["a"]
    for axis in range(4):
        current = mechanics + axis
        a[current, current] = -parts["amplifier_rate"]
        b[current, axis] = parts["amplifier_rate"]
        if not lags:
            a[:mechanics, current] = parts["b"][:, axis]
        for lag in range(lags):
            place = mechanics + 4 + axis * lags + lag
            a[place, place] = -rates[lag]
            a[place, current] = rates[lag]
            a[:mechanics, place] = weights[lag] * parts["b"][:, axis]
    c = numpy.zeros((4, size))
    c[:, :mechanics] = parts["c"]
    return a, b, c


def _step(a, b, seconds):
    size, inputs = b.shape
    block = numpy.zeros((size + inputs, size + inputs))
    block[:size, :size], block[:size, size:] = a * seconds, b * seconds
    try:
        with numpy.errstate(all="ignore"):
            result = scipy.linalg.expm(block)
    except (ValueError, OverflowError, numpy.linalg.LinAlgError):
        result = numpy.array([[math.nan]])
    if not numpy.isfinite(result).all():
        raise InputError("the loop leaves all numbers within one sample: a mass, a rate or a stiffness of the model is out of range")
    return result[:size, :size], result[:size, size:]


def closed_loop(parts) -> Loop:
    a, b, c = _held(parts)
    period = 1.0 / parts["sample_rate_hz"]
    whole = int(math.floor(parts["delay_s"] / period + 1e-9))
    rest = max(parts["delay_s"] - whole * period, 0.0)
    before_a, before_b = _step(a, b, rest)
    after_a, after_b = _step(a, b, period - rest)
    law = {name: numpy.asarray(matrix) for name, matrix in parts["controller"].items()}
    size, memory = a.shape[0], law["a"].shape[0]
    # the state: plant, the controller's memory, commands u_(n-1) ... u_(n-1-whole)
    total = size + memory + 4 * (whole + 1)
    unit = numpy.eye(total)

    def wide(matrix):
        return numpy.hstack([matrix, numpy.zeros((matrix.shape[0], 4))])

    # The signal is c x + e: rows of [state, e].
    signal = numpy.hstack([c @ unit[:size], numpy.eye(4)])
    states = wide(unit[size:size + memory])
    commands = [law["c"] @ states + law["d"] @ signal]
    for sample in range(whole + 1):
        place = size + memory + 4 * sample
        commands.append(wide(unit[place:place + 4]))
    # until the delay ends the command of sample n - 1 - whole is held, then that of n - whole
    plant = after_a @ (before_a @ wide(unit[:size]) + before_b @ commands[whole + 1]) + after_b @ commands[whole]
    following = [plant, law["a"] @ states + law["b"] @ signal] + commands[:whole + 1]
    matrix = numpy.vstack(following)
    return Loop(matrix[:, :total], matrix[:, total:], signal[:, :total], period, parts["a"].shape[0])


def _eigen(parts):
    """Continuous eigenvalues, the mechanics of their vectors, and which are bending modes at half the sample rate or above."""
    if not parts["controlled"]:
        values, vectors = numpy.linalg.eig(parts["a"])
        return values, vectors, numpy.zeros(values.size, bool)
    loop = closed_loop(parts)
    values, vectors = numpy.linalg.eig(loop.a)
    keep = numpy.abs(values) > 1e-9
    values, vectors = numpy.log(values[keep].astype(complex)) / loop.period_s, vectors[:loop.states, keep]
    unfolded, above = _unfolded(values, vectors, parts, 2.0 * math.pi / loop.period_s)
    return unfolded, vectors, above


def _unfolded(values, vectors, parts, rate):
    """s + j k rate, rate in rad/s, of bending modes that the samples fold, and which they are.

    The loop hardly moves such a mode: k is one that brings s to a natural frequency of the rotor without control, and its
    displacements nearest to its velocities over s. Held commands stir the slow motions at the folded frequency, too, which
    leaves a misfit with any k; it is far smaller than without k."""
    free = numpy.linalg.eigvals(parts["a"])
    free = free[(numpy.abs(free.imag) > 0.45 * rate) & (numpy.abs(free.real) < LIGHT * numpy.abs(free))]
    unfolded, above = values.copy(), numpy.zeros(values.size, bool)
    if not free.size:
        return unfolded, above
    count = parts["coordinates"]
    weight = numpy.tile(numpy.asarray(parts["mass"]), 2)

    def misfit(index, s):
        place, velocity = vectors[:count, index], vectors[count:2 * count, index]
        return float(numpy.sum(weight * numpy.abs(place - velocity / s) ** 2))
    for index, value in enumerate(values):
        near = [s for s in value + 1j * rate * numpy.rint((free.imag - value.imag) / rate)
                if numpy.min(numpy.abs(s - free) / numpy.abs(free)) < MOVED]
        if not near:
            continue
        best = min(near, key=lambda s: misfit(index, s))
        above[index] = best == value or misfit(index, best) < UNFOLDED ** 2 * misfit(index, value)
        if above[index]:
            unfolded[index] = best
    return unfolded, above


def _whirl(vector, parts) -> float:
    count = parts["coordinates"] // 2
    weight = numpy.asarray(parts["mass"])
    x, y = vector[:count], vector[count:2 * count]
    # x = cos, y = sin is forward: with exp(st), x = 1 and y = -j
    forward = float(numpy.sum(weight * numpy.abs(x + 1j * y) ** 2))
    backward = float(numpy.sum(weight * numpy.abs(x - 1j * y) ** 2))
    return (forward - backward) / (forward + backward)


def modes(model, speed_hz: float) -> list[Mode]:
    """Oscillating modes of the closed loop, by rising natural frequency."""
    from amb_rotor import _core
    parts = _core.linear_parts(model, float(speed_hz))
    values, vectors, above = _eigen(parts)
    half_rate = 0.5 * parts["sample_rate_hz"] if parts["controlled"] else math.inf
    found = []
    for index, value in enumerate(values):
        natural = abs(value)
        if value.imag <= 1e-6 * max(natural, 1.0) or natural / (2 * math.pi) > 0.95 * half_rate and not above[index]:
            continue
        damping = -value.real / natural
        if abs(damping) > LARGEST_DAMPING_RATIO:
            continue
        twins = numpy.sum(numpy.abs(values - value) < EQUAL * natural) > 1
        vector = vectors[:, index]
        measure = 0.0 if twins else _whirl(vector, parts)
        shape = {}
        for plane in ("sensor", "amb", "aux"):
            place = parts[plane] @ vector
            shape[plane] = place
        largest = max(float(numpy.max(numpy.abs(place))) for place in shape.values()) or 1.0
        shape = {plane: place / largest for plane, place in shape.items()}
        whirl = "planar" if abs(measure) < 0.05 else "forward" if measure > 0 else "backward"
        found.append(Mode(natural / (2 * math.pi), value.imag / (2 * math.pi), float(damping), whirl,
                          float(measure), shape))
    return sorted(found, key=lambda mode: mode.frequency_hz)


def distinct(frequencies, count: int) -> list[float]:
    """The lowest frequencies, the two planes of one mode counted once."""
    found: list[float] = []
    for value in sorted(frequencies):
        if not found or value > found[-1] * (1.0 + 1e-4):
            found.append(value)
    return found[:count]


def largest_growth(model, speed_hz: float) -> float:
    """The largest real part of all eigenvalues [1/s]; above 0 the rotor does not levitate."""
    from amb_rotor import _core
    values, _, _ = _eigen(_core.linear_parts(model, float(speed_hz)))
    return float(numpy.max(values.real))


def critical_speeds(model, largest_hz: float, points: int = 60) -> list[dict]:
    """Speeds at which a mode's damped frequency is the speed: crossings of the map with the 1X line."""
    speeds = numpy.linspace(0.0, largest_hz, points)
    rows = [modes(model, speed) for speed in speeds]
    found = []
    for low, high, left, right in zip(speeds[:-1], speeds[1:], rows[:-1], rows[1:]):
        for mode in left:
            before = mode.damped_frequency_hz - low
            if before < 0:
                continue
            after = _follow(mode, right)
            if after is None or after.damped_frequency_hz - high >= 0:
                continue
            found.append(_cross(model, mode, low, high))
    merged: list[dict] = []
    for one in sorted(found, key=lambda entry: entry["speed_hz"]):
        if not merged or one["speed_hz"] > merged[-1]["speed_hz"] * (1 + 1e-4) or one["whirl"] != merged[-1]["whirl"]:
            merged.append(one)
    return merged


def _follow(mode: Mode, others: list[Mode]) -> Mode | None:
    """The same mode at a neighbouring speed: near in frequency and not turning the other way."""
    near = [other for other in others
            if "planar" in (mode.whirl, other.whirl) or other.whirl == mode.whirl]
    return min(near, key=lambda other: abs(other.damped_frequency_hz - mode.damped_frequency_hz)
               + 50 * abs(other.damping_ratio - mode.damping_ratio), default=None)


def _cross(model, mode: Mode, low: float, high: float) -> dict:
    for _ in range(30):
        middle = 0.5 * (low + high)
        there = _follow(mode, modes(model, middle))
        if there is None:
            break
        if there.damped_frequency_hz > middle:
            low, mode = middle, there
        else:
            high = middle
    last = _follow(mode, modes(model, high)) or mode
    return {"speed_hz": 0.5 * (low + high), "whirl": last.whirl, "damping_ratio": last.damping_ratio}


ZONES = (("A", 3.0), ("B", 4.0), ("C", 5.0), ("D", math.inf))


def zone(peak: float) -> str:
    """ISO 14839-3: A for new machines, B for unrestricted operation, C short-term, D may damage."""
    return next(name for name, limit in ZONES if peak < limit)


def sensitivity(model, speed_hz: float, frequencies) -> numpy.ndarray:
    """ISO 14839-3: |signal / disturbance added to it| of each axis with all loops closed. Rows: axes."""
    from amb_rotor import _core
    parts = _core.linear_parts(model, float(speed_hz))
    loop = closed_loop(parts)
    result = numpy.empty((4, len(frequencies)))
    identity = numpy.eye(loop.a.shape[0])
    for index, frequency in enumerate(frequencies):
        z = numpy.exp(2j * math.pi * frequency * loop.period_s)
        transfer = loop.c @ numpy.linalg.solve(z * identity - loop.a, loop.b) + numpy.eye(4)
        result[:, index] = numpy.abs(numpy.diag(transfer))
    return result
