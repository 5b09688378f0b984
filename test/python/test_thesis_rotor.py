"""How near a shaft can come to figure 4.3 of the thesis: config/thesis/rotor.yaml by elements of its own, and a search.

The search has a shaft of 27 sections of any diameter from 19.4 mm (journals of the SKF 6004) to 49 mm (section 4.1), each
with a ring of steel on it of any mass that carries no load (laminations, discs). It pulls the first fixed-fixed frequency
towards 2557 Hz while mass, centre of gravity and inertias hold to 1 %, all other frequencies to 2 %: linear programmes of
the exact derivatives within a trust region, from a random start. A search finds no proof: another start may end nearer.
"""
from __future__ import annotations

import pathlib

import numpy
import pytest
import yaml

linalg = pytest.importorskip("scipy.linalg")
optimize = pytest.importorskip("scipy.optimize")

FILE = pathlib.Path(__file__).resolve().parents[2] / "config/thesis/rotor.yaml"
LENGTH, STEEL, MODULUS, STIFFNESS = 0.323, 7850.0, 206e9, 5.96e5
PLANES = (0.1604 - 0.096, 0.1604 + 0.096)
FIXED = 2557.0
WANTED = {"mass": (3.36, 0.01), "centre": (0.1604, 0.01), "polar": (0.001, 0.01), "transverse": (0.017, 0.01),
          "free": (2971.0, 0.02), "k1_0": (94.0, 0.02), "k1_1": (128.0, 0.02), "k1_2": (2973.0, 0.02),
          "fixed_1": (4819.0, 0.02), "fixed_2": (5763.0, 0.02)}


class Beam:
    """Euler-Bernoulli with rotary inertia on a mesh; steel of a diameter, and what carries mass alone on an element:
    mass and polar inertia by length. Frequencies [Hz] with their derivatives by (diameter, mass, polar inertia)."""

    def __init__(self, lengths, planes=PLANES):
        self.h = numpy.asarray(lengths)
        self.count, self.nodes = len(self.h), numpy.concatenate([[0.0], numpy.cumsum(self.h)])
        self.middle = 0.5 * (self.nodes[1:] + self.nodes[:-1])
        self.bending, self.carrying, self.turning = zip(*(self._element(h) for h in self.h))
        self.at = numpy.array([self._shape(z) for z in planes])
        self.free_of = numpy.linalg.svd(self.at)[2][len(planes):].T  # motions with the planes held

    @staticmethod
    def _element(h):
        k = numpy.array([[12, 6 * h, -12, 6 * h], [6 * h, 4 * h * h, -6 * h, 2 * h * h], [-12, -6 * h, 12, -6 * h],
                         [6 * h, 2 * h * h, -6 * h, 4 * h * h]]) / h ** 3
        m = numpy.array([[156, 22 * h, 54, -13 * h], [22 * h, 4 * h * h, 13 * h, -3 * h * h], [54, 13 * h, 156, -22 * h],
                         [-13 * h, -3 * h * h, -22 * h, 4 * h * h]]) * h / 420
        r = numpy.array([[36, 3 * h, -36, 3 * h], [3 * h, 4 * h * h, -3 * h, -h * h], [-36, -3 * h, 36, -3 * h],
                         [3 * h, -h * h, -3 * h, 4 * h * h]]) / (30 * h)
        return k, m, r

    def _shape(self, z):
        e = min(int(numpy.searchsorted(self.nodes, z, "right")) - 1, self.count - 1)
        h, s = self.h[e], (z - self.nodes[e]) / self.h[e]
        row = numpy.zeros(2 * self.count + 2)
        row[2 * e:2 * e + 4] = [1 - 3 * s ** 2 + 2 * s ** 3, h * (s - 2 * s ** 2 + s ** 3), 3 * s ** 2 - 2 * s ** 3,
                                h * (s ** 3 - s ** 2)]
        return row

    def seated(self, d, m):
        """The same by (diameter, mass) for rings of steel that sit on the shaft: p = m (inner^2 + outer^2)/8."""
        by_d, by_m = m * d / 2, (2 * d ** 2 + 8 * m / (STEEL * numpy.pi)) / 8
        found = self.figures(d, m, m * (2 * d ** 2 + 4 * m / (STEEL * numpy.pi)) / 8)
        return {name: (value, numpy.concatenate([on_d + on_p * by_d, on_m + on_p * by_m]))
                for name, (value, slope) in found.items() for on_d, on_m, on_p in [numpy.split(slope, 3)]}

    def figures(self, d, m, p):
        """Value and derivative of all that is published, by name."""
        zero, pi = numpy.zeros(self.count), numpy.pi
        mu, polar = STEEL * pi * d ** 2 / 4 + m, STEEL * pi * d ** 4 / 32 + p
        dmu, dpolar = STEEL * pi * d / 2, STEEL * pi * d ** 3 / 8
        h, mass = self.h, float(mu @ self.h)
        centre = float(mu * h @ self.middle) / mass
        arm = (self.middle - centre) ** 2 + h ** 2 / 12
        found = {"mass": (mass, numpy.concatenate([dmu * h, h, zero])),
                 "centre": (centre, numpy.concatenate([dmu * h * (self.middle - centre), h * (self.middle - centre),
                                                       zero]) / mass),
                 "polar": (float(polar @ h), numpy.concatenate([dpolar * h, zero, h])),
                 "transverse": (float(mu * h @ arm + polar @ h / 2),
                                numpy.concatenate([dmu * h * arm + dpolar * h / 2, h * arm, h / 2]))}
        size = 2 * self.count + 2
        stiff, inert = numpy.zeros((size, size)), numpy.zeros((size, size))
        for e in range(self.count):
            part = slice(2 * e, 2 * e + 4)
            stiff[part, part] += MODULUS * pi * d[e] ** 4 / 64 * self.bending[e]
            inert[part, part] += mu[e] * self.carrying[e] + polar[e] / 2 * self.turning[e]
        held = self.free_of

        def modes(k, mm, back, first, names):
            squares, shapes = linalg.eigh(k, mm, subset_by_index=[0, first + len(names) - 1])
            for index, name in enumerate(names):
                w2, shape = squares[first + index], back @ shapes[:, first + index]
                slope = numpy.zeros(3 * self.count)
                for e in range(self.count):
                    v = shape[2 * e:2 * e + 4]
                    k_e, m_e, r_e = (v @ matrix @ v for matrix in (self.bending[e], self.carrying[e], self.turning[e]))
                    slope[e] = MODULUS * pi * d[e] ** 3 / 16 * k_e - w2 * (dmu[e] * m_e + dpolar[e] / 2 * r_e)
                    slope[self.count + e], slope[2 * self.count + e] = -w2 * m_e, -w2 * r_e / 2
                hertz = numpy.sqrt(max(w2, 0.0)) / (2 * pi)
                found[name] = (float(hertz), slope / (8 * pi ** 2 * hertz))

        modes(stiff, inert, numpy.eye(size), 2, ["free"])
        modes(stiff + STIFFNESS * self.at.T @ self.at, inert, numpy.eye(size), 0, ["k1_0", "k1_1", "k1_2"])
        modes(held.T @ stiff @ held, held.T @ inert @ held, held, 0, ["fixed_0", "fixed_1", "fixed_2"])
        return found


def violation(found) -> float:
    return sum(max(0.0, abs(found[name][0] / wanted - 1.0) - share) for name, (wanted, share) in WANTED.items())


def search(seed: int, passes: int, count: int = 27):
    """The figures of the shaft that is found."""
    beam, random = Beam(numpy.full(count, LENGTH / count)), numpy.random.default_rng(seed)
    x = numpy.concatenate([random.uniform(0.025, 0.049, count), random.uniform(0, 4, count) * (random.random(count) < 0.4)])
    low = numpy.concatenate([numpy.full(count, 0.0194), numpy.zeros(count)])
    high = numpy.concatenate([numpy.full(count, 0.049), numpy.full(count, 40.0)])
    for e in (0, 1, count - 2, count - 1):  # journals
        high[e], high[count + e] = 0.0194, 0.0
    x = numpy.clip(x, low, high)
    scale = numpy.concatenate([numpy.full(count, 0.003), numpy.full(count, 1.5)])
    found = beam.seated(*numpy.split(x, 2))
    reach, price = 1.0, 50.0
    merit = (FIXED - found["fixed_0"][0]) / FIXED + price * violation(found)
    for _ in range(passes):
        rows, limits, wanted = [], [], list(WANTED)
        for index, name in enumerate(wanted):
            aim, share = WANTED[name]
            for sign in (1.0, -1.0):
                row = numpy.zeros(2 * count + len(wanted))
                row[:2 * count], row[2 * count + index] = sign * found[name][1] * scale / aim, -1.0
                rows.append(row)
                limits.append(share - sign * (found[name][0] / aim - 1.0))
        bounds = [(min(0.0, max(-reach, (a - v) / s)), max(0.0, min(reach, (b - v) / s)))
                  for a, b, v, s in zip(low, high, x, scale)] + [(0.0, None)] * len(wanted)
        cost = numpy.concatenate([-found["fixed_0"][1] * scale / FIXED, numpy.full(len(wanted), price)])
        step = optimize.linprog(cost, A_ub=numpy.array(rows), b_ub=limits, bounds=bounds, method="highs")
        if step.status != 0:
            reach *= 1.5
            continue
        there = x + scale * step.x[:2 * count]
        tried = beam.seated(*numpy.split(there, 2))
        better = (FIXED - tried["fixed_0"][0]) / FIXED + price * violation(tried)
        if better < merit - 1e-9:
            x, found, merit, reach = there, tried, better, min(1.5 * reach, 4.0)
        else:
            reach *= 0.4
        if reach < 1e-4:
            break
    return found


def reconstruction():
    """The figures of rotor.yaml, by this file's elements."""
    file = yaml.safe_load(FILE.read_text())
    ends = numpy.cumsum([0.0] + [section["length_m"] for section in file["sections"]])
    marks = sorted({round(float(z), 9) for z in ends} | {round(ring[key], 9) for ring in file["rings"] for key in ("from_m", "to_m")})
    nodes = numpy.unique(numpy.concatenate([numpy.linspace(a, b, int(numpy.ceil((b - a) / 0.006)) + 1)
                                            for a, b in zip(marks, marks[1:])]).round(9))
    middle = 0.5 * (nodes[1:] + nodes[:-1])
    d = numpy.array([file["sections"][int(numpy.searchsorted(ends, z, "right")) - 1]["outer_diameter_m"] for z in middle])
    m, p = numpy.zeros_like(d), numpy.zeros_like(d)
    for ring in file["rings"]:
        inside = (middle > ring["from_m"]) & (middle < ring["to_m"])
        density, a, b = file["materials"][ring["material"]]["density_kg_per_m3"], ring["inner_diameter_m"], ring["outer_diameter_m"]
        m[inside] += density * numpy.pi * (b ** 2 - a ** 2) / 4
        p[inside] += density * numpy.pi * (b ** 4 - a ** 4) / 32
    bare = Beam(numpy.diff(nodes)).figures(d, m, p)
    centre = bare["centre"][0]
    return Beam(numpy.diff(nodes), (centre - 0.096, centre + 0.096)).figures(d, m, p)


def test_the_file_states_its_own_figures():
    found = reconstruction()
    # as printed in the file's head, to its digits
    for name, stated in {"mass": 3.3583, "centre": 0.1614, "polar": 0.000995, "transverse": 0.01710, "free": 3013.0,
                         "k1_0": 94.8, "k1_1": 127.6, "k1_2": 3014.0, "fixed_0": 2369.0, "fixed_1": 4788.0,
                         "fixed_2": 5751.0}.items():
        assert found[name][0] == pytest.approx(stated, rel=1e-3), name
    assert violation(found) == 0.0


def test_derivatives_are_those_of_differences():
    beam, random = Beam(numpy.full(27, LENGTH / 27)), numpy.random.default_rng(1)
    x = numpy.concatenate([random.uniform(0.025, 0.049, 27), random.uniform(0, 4, 27), random.uniform(0, 0.002, 27)])
    found = beam.figures(*numpy.split(x, 3))
    for index, h in ((5, 1e-6), (14, 1e-6), (27 + 9, 1e-4), (54 + 20, 1e-7)):
        ahead, behind = x.copy(), x.copy()
        ahead[index] += h
        behind[index] -= h
        one, two = beam.figures(*numpy.split(ahead, 3)), beam.figures(*numpy.split(behind, 3))
        for name, (value, slope) in found.items():  # differences of round-off 1e-10 of the value
            assert slope[index] == pytest.approx((one[name][0] - two[name][0]) / (2 * h), rel=1e-3, abs=1e-7 * abs(value) / h)
    d, m = x[:27], x[27:54] + 1.0
    for index, part in ((5, (1e-6, 0.0)), (9, (0.0, 1e-4))):
        step = numpy.zeros(27)
        step[index] = 1.0
        one, two = (beam.seated(d + s * part[0] * step, m + s * part[1] * step) for s in (1.0, -1.0))
        for name, (value, slope) in beam.seated(d, m).items():
            difference = (one[name][0] - two[name][0]) / (2 * sum(part))
            assert slope[index if part[0] else 27 + index] == pytest.approx(difference, rel=1e-3, abs=1e-7 * abs(value) / sum(part))


@pytest.mark.slow
def test_no_shaft_comes_much_nearer_to_the_fixed_frequency():
    found = search(seed=2, passes=300)
    off = found["fixed_0"][0] / FIXED - 1.0
    print(f"first fixed-fixed frequency {found['fixed_0'][0]:.0f} Hz, {100 * off:+.1f} %; free {found['free'][0]:.0f}, "
          f"fixed {found['fixed_1'][0]:.0f} and {found['fixed_2'][0]:.0f} Hz")
    assert violation(found) < 1e-6
    # seven starts of 400 passes ended between -6.4 and -5.3 %, this one at -5.3 %
    assert reconstruction()["fixed_0"][0] / FIXED - 1.0 < off < -0.045
