"""What a run at standstill with an excitation current says of a rigid rotor on its magnetic bearings.

One axis (x or y); s displacements at the sensors, i control currents, e excitation currents, Z axial positions:
  tilt b = (s_b - s_a)/(Z_sb - Z_sa), centre x = s_a - Z_sa b, at a magnet x + Z b
Modes: both motions answer e with one denominator,  x = N_x(s)/D(s) e,  b = N_b(s)/D(s) e,  D of order 4 or 6 (two
rigid modes, and what lags), N of two less; least squares of the outputs, begun from the linear equations N e = D x
weighted by 1/|D| of the pass before (Sanathanan and Koerner 1963). A mode is a pair of roots of D: w = |root|, damping
ratio -Re/w. Of the mode in which both ends move together, k1 = m w^2/2 and d1 = m zeta w are a bearing's equivalent
stiffness and damping (thesis 3.26 at that frequency).
Ki, Ks by measurement: Newton's law of both motions over the band, linear in the two,
  -m w^2 x = Ki (i_a + i_b) + Ks (x_a + x_b),  -It w^2 b = Ki (Z_a i_a + Z_b i_b) + Ks (Z_a x_a + Z_b x_b)
with mass and inertia as stated. Both sides carry noise, so the equations are taken along the fitted motions and their
accelerations, N e/D and s^2 N e/D, which do not (instrumental variables; the force is in phase with them). Standard
deviations from the residuals. A step goes in by its differences, which have an end, and is taken back to what it was in
the spectra. Left out: spin (gyroscopic coupling, unbalance), bending modes in the band, currents that lag their channel.
"""
from __future__ import annotations

import dataclasses
import math

import numpy
import scipy.optimize

from amb_rotor.errors import InputError

ORDERS, PASSES = (4, 6), 30
TOLERANCE = 1e-12   # of the least squares, relative: far below the noise, above round-off
WELL_DAMPED = 0.95  # from here on a pair of roots is no mode that rings
EXCITED = 0.05      # share of the largest excitation below which a frequency counts as not excited


@dataclasses.dataclass
class Mode:
    frequency_hz: float
    frequency_std_hz: float
    damping_ratio: float
    damping_ratio_std: float
    together: bool  # both ends move the same way


@dataclasses.dataclass
class Magnet:
    current_stiffness_N_per_A: float
    current_stiffness_std: float
    displacement_stiffness_N_per_m: float
    displacement_stiffness_std: float


def spectra(table: dict, rig: dict, axis: str, differences: bool, band: tuple[float, float]):
    """Angular frequencies that are excited, and the spectra there: x, b, e, and of the ends current and place."""
    names = [f"{end}{axis}" for end in "ab"]

    dt = (table["t_s"][-1] - table["t_s"][0]) / (len(table["t_s"]) - 1)
    w = 2.0 * math.pi * numpy.fft.rfftfreq(len(table["t_s"]) - bool(differences), dt)
    w[0] = w[1]  # not a frequency that is kept
    back = 1.0 / (1.0 - numpy.exp(-1j * w * dt)) if differences else 1.0

    def spectrum(signal):
        return numpy.fft.rfft(numpy.diff(signal) if differences else signal - signal[0])
    s = [back * spectrum(table[f"{name}_m"]) for name in names]
    i = [back * spectrum(table[f"i{name}_A"]) for name in names]
    e = [spectrum(table.get(f"exc_{name}_A", numpy.zeros_like(table["t_s"]))) for name in names]
    b = (s[1] - s[0]) / (rig["sensor"][1] - rig["sensor"][0])
    x = s[0] - rig["sensor"][0] * b
    push = e[0] if numpy.abs(e[0]).max() >= numpy.abs(e[1]).max() else e[1]
    kept = (w >= 2 * math.pi * band[0]) & (w <= 2 * math.pi * band[1])
    kept &= numpy.abs(push) > EXCITED * numpy.abs(push).max()
    places = [(x + z * b)[kept] for z in rig["amb"]]
    return w[kept], x[kept], b[kept], (back * push)[kept], [part[kept] for part in i], places


class Fit:
    """outputs = N/D push, D of `order`, N of two less: the coefficients of D (its highest is 1), then of each N, rising."""

    def __init__(self, w, outputs, push, order: int):
        self.order, self.size, self.push = order, order - 1, push
        self.outputs = [output / numpy.sqrt(numpy.mean(numpy.abs(output) ** 2)) for output in outputs]
        self.scales = [numpy.sqrt(numpy.mean(numpy.abs(output) ** 2)) for output in outputs]
        self.powers = (1j * w / w.max())[:, None] ** numpy.arange(order + 1)
        self.found = self._linear()
        self._refine()

    def _denominator(self, found):
        return self.powers[:, :self.order] @ found[:self.order] + self.powers[:, self.order]

    def _part(self, index):
        return slice(self.order + index * self.size, self.order + (index + 1) * self.size)

    def _linear(self):
        """N push - D output = 0, weighted by 1/D of the pass before: a start, biased by noise."""
        weight = numpy.ones(len(self.push))
        for _ in range(PASSES):
            rows, right = [], []
            for index, output in enumerate(self.outputs):
                row = numpy.zeros((len(output), self.order + self.size * len(self.outputs)), complex)
                row[:, :self.order] = -self.powers[:, :self.order] * output[:, None]
                row[:, self._part(index)] = self.powers[:, :self.size] * self.push[:, None]
                rows.append(row * weight[:, None])
                right.append(self.powers[:, self.order] * output * weight)
            a, y = numpy.vstack(rows), numpy.concatenate(right)
            a, y = numpy.vstack([a.real, a.imag]), numpy.concatenate([y.real, y.imag])
            norms = numpy.linalg.norm(a, axis=0)
            found = numpy.linalg.lstsq(a / norms, y, rcond=None)[0] / norms
            weight = 1.0 / numpy.abs(self._denominator(found))
        return found

    def _misfit(self, found):
        """Output less N/D push, and its derivatives; real parts above imaginary ones."""
        d, rows, errors = self._denominator(found), [], []
        for index, output in enumerate(self.outputs):
            answer = self.powers[:, :self.size] @ found[self._part(index)] * self.push / d
            row = numpy.zeros((len(output), len(found)), complex)
            row[:, :self.order] = -self.powers[:, :self.order] * (answer / d)[:, None]
            row[:, self._part(index)] = self.powers[:, :self.size] * (self.push / d)[:, None]
            rows.append(row)
            errors.append(output - answer)
        a, y = numpy.vstack(rows), numpy.concatenate(errors)
        return numpy.vstack([a.real, a.imag]), numpy.concatenate([y.real, y.imag])

    def _refine(self):
        """Least squares of the outputs themselves."""
        solution = scipy.optimize.least_squares(lambda found: self._misfit(found)[1], self.found,
                                                jac=lambda found: -self._misfit(found)[0], method="lm", x_scale="jac",
                                                xtol=TOLERANCE, ftol=TOLERANCE, gtol=TOLERANCE)
        self.found = solution.x
        slopes, error = self._misfit(self.found)
        norms = numpy.linalg.norm(slopes, axis=0)
        spread = error @ error / max(1, len(error) - len(norms))
        self.covariance = spread * numpy.linalg.pinv((slopes / norms).T @ (slopes / norms)) / numpy.outer(norms, norms)
        self.information = len(error) * math.log(error @ error / len(error)) + len(norms) * math.log(len(error))

    def roots(self, found=None):
        found = self.found if found is None else found
        return numpy.roots(numpy.concatenate([[1.0], found[:self.order][::-1]]))

    def deviations(self, root):
        """Standard deviations of the size of a root and of its damping ratio."""
        slopes = numpy.zeros((self.order, 2))
        for k in range(self.order):
            moved, step = self.found.copy(), 1e-6 * max(abs(self.found[k]), 1e-6)
            moved[k] += step
            near = min(self.roots(moved), key=lambda other: abs(other - root))
            slopes[k] = (abs(near) - abs(root)) / step, (root.real / abs(root) - near.real / abs(near)) / step
        return numpy.sqrt(numpy.maximum(numpy.diag(slopes.T @ self.covariance[:self.order, :self.order] @ slopes), 0.0))

    def answers(self):
        """N/D push of each output: the motion without its noise."""
        d = self._denominator(self.found)
        return [scale * (self.powers[:, :self.size] @ self.found[self._part(index)]) * self.push / d
                for index, scale in enumerate(self.scales)]

    def shape(self, root):
        """The outputs in the motion of a root."""
        return [scale * numpy.polyval(self.found[self._part(index)][::-1], root) for index, scale in enumerate(self.scales)]


def best_fit(w, outputs, push) -> Fit:
    """Of the orders tried the one with the least Bayesian information: what noise alone would fit is no mode."""
    return min((Fit(w, outputs, push, order) for order in ORDERS), key=lambda tried: tried.information)


def modes(w, fit: Fit, ends) -> list[Mode]:
    """Modes in the band; x + ends b is the motion at the ends."""
    hertz, result = w.max() / (2.0 * math.pi), []
    for root in fit.roots():
        ratio = -root.real / abs(root)
        if root.imag <= 0.0 or ratio > WELL_DAMPED or not w.min() <= abs(root) * w.max() <= w.max():
            continue
        x, b = fit.shape(root)
        deviation = fit.deviations(root)
        result.append(Mode(abs(root) * hertz, deviation[0] * hertz, ratio, deviation[1],
                           ((x + ends[0] * b) / (x + ends[1] * b)).real > 0.0))
    return sorted(result, key=lambda mode: mode.frequency_hz)


def magnet(w, x, b, currents, places, clean, rig: dict) -> Magnet:
    """Ki and Ks from Newton's law of both motions, each equation in metres at the magnets; `clean`: x, b without noise."""
    z, mass, inertia, ks = rig["amb"], rig["mass_kg"], rig["transverse_inertia_kg_m2"], rig["displacement_stiffness"]
    arm = 0.5 * (abs(z[0]) + abs(z[1]))
    rows, right, along = [], [], []
    for inertial, motion, (first, second) in ((-mass * w ** 2 * x, clean[0], (1.0, 1.0)),
                                              (-inertia * w ** 2 * b / arm, arm * clean[1], (z[0] / arm, z[1] / arm))):
        share = 1.0 / (mass * w ** 2 + 2.0 * ks)
        rows.append(numpy.stack([(first * currents[0] + second * currents[1]) * share,
                                 (first * places[0] + second * places[1]) * share], axis=1))
        right.append(inertial * share)
        along.append(numpy.stack([motion * share, (w / w.max()) ** 2 * motion * share], axis=1))
    a, y, v = numpy.vstack(rows), numpy.concatenate(right), numpy.vstack(along)
    a, y, v = numpy.vstack([a.real, a.imag]), numpy.concatenate([y.real, y.imag]), numpy.vstack([v.real, v.imag])
    norms, lengths = numpy.linalg.norm(a, axis=0), numpy.linalg.norm(v, axis=0)
    inverse = numpy.linalg.inv((v / lengths).T @ (a / norms))
    found = inverse @ (v / lengths).T @ y / norms
    spread = numpy.sum((a @ found - y) ** 2) / max(1, len(y) - 2)
    deviation = numpy.sqrt(spread * numpy.diag(inverse @ (v / lengths).T @ (v / lengths) @ inverse.T)) / norms
    return Magnet(float(found[0]), float(deviation[0]), float(found[1]), float(deviation[1]))


def rig_of(fields: dict) -> dict:
    """What is used of a model's fields."""
    return {"mass_kg": fields["rig.rotor.mass_kg"], "transverse_inertia_kg_m2": fields["rig.rotor.transverse_inertia_kg_m2"],
            "displacement_stiffness": fields["rig.amb.displacement_stiffness_N_per_m"],
            **{plane: tuple(fields[f"rig.planes.{plane}.{end}"] for end in "ab") for plane in ("amb", "sensor")}}


def axis_of(table: dict, rig: dict, axis: str, step: bool, band=(5.0, 400.0)):
    """(modes, magnet) of one axis of a run; nothing where it is not excited."""
    excited = max(numpy.abs(table.get(f"exc_{end}{axis}_A", numpy.zeros(1))).max() for end in "ab")
    if excited == 0.0:
        return None
    missing = [f"{p}{end}{axis}_{unit}" for p, unit in (("", "m"), ("i", "A")) for end in "ab"
               if f"{p}{end}{axis}_{unit}" not in table]
    if missing:
        raise InputError(f"the run has no {', '.join(missing)}")
    w, x, b, push, currents, places = spectra(table, rig, axis, step, band)
    if len(w) < 3 * max(ORDERS):
        raise InputError(f"only {len(w)} frequencies are excited between {band[0]:g} and {band[1]:g} Hz: a longer run is needed")
    arm = 0.5 * (rig["sensor"][1] - rig["sensor"][0])
    fit = best_fit(w, (x, arm * b), push)
    centre, tilt = fit.answers()
    return modes(w, fit, (rig["sensor"][0] / arm, rig["sensor"][1] / arm)), \
        magnet(w, x, b, currents, places, (centre, tilt / arm), rig)
