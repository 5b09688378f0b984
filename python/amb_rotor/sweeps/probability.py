"""Probability of dry whirl after a knock: random machines and knocks in the lanes (format amb-probability/1).

The interval is Wilson's, 95 %: p in (k + z^2/2 +- z sqrt(k (n - k)/n + z^2/4)) / (n + z^2), z = 1.96
(Wilson, J. Am. Stat. Assoc. 22, 1927). A difference between two designs run on the same samples has the
standard error sqrt(a + b - (a - b)^2/n)/n, where a samples got better and b got worse.
"""
from __future__ import annotations

import math
import pathlib

import numpy

from amb_rotor.sweeps.document import Document

FORMAT = "amb-probability/1"
KEYS = {"format", "name", "title", "contact", "friction_law", "parameters", "knock", "samples", "seed", "run", "changes"}
Z = 1.959964


def wilson(hits: int, samples: int) -> tuple[float, float]:
    """95 % interval of a probability of which `hits` of `samples` were seen."""
    middle = (hits + Z * Z / 2) / (samples + Z * Z)
    half = Z * math.sqrt(hits * (samples - hits) / samples + Z * Z / 4) / (samples + Z * Z)
    # The ends are exactly 0 and 1 where nothing or everything was hit.
    return (0.0 if hits == 0 else middle - half), (1.0 if hits == samples else middle + half)


def paired_error(before: numpy.ndarray, after: numpy.ndarray) -> float:
    """Standard error of the difference of two probabilities seen on the same samples."""
    better, worse = int((before & ~after).sum()), int((~before & after).sum())
    n = len(before)
    return math.sqrt(max(better + worse - (better - worse) ** 2 / n, 0.0)) / n


def tell(outcomes: dict, what: str) -> list[dict]:
    """Prints and returns each design's probability, its interval, and its difference from the first design's."""
    first = next(iter(outcomes.values()))
    print(f"probability of {what}, 95 % interval, {len(first)} samples")
    rows = []
    for name, outcome in outcomes.items():
        hits = int(outcome.sum())
        low, high = wilson(hits, len(outcome))
        rows.append({"design": name, "probability": hits / len(outcome), "low": low, "high": high,
                     "change": float(outcome.mean() - first.mean()), "change_error": paired_error(first, outcome)})
        print(f"  {name:<30} {rows[-1]['probability']:.4f}  [{low:.4f}, {high:.4f}]  "
              f"change {rows[-1]['change']:+.4f} +- {rows[-1]['change_error']:.4f}")
    return rows


def check_drawn(document: Document, key: str) -> None:
    """A number, or {uniform: [least, largest]}."""
    spec = document.get(key)
    if not isinstance(spec, dict):
        document.number(key, "a number, or {uniform: [least, largest]}")
    elif document.keys(key, ("uniform",)):
        ends = document.axis(f"{key}/uniform")
        if len(ends) != 2 or not ends[0] <= ends[1]:
            document.fault(f"{key}/uniform", "must be [least, largest]")


def check_changes(document: Document, names) -> None:
    """Designs, each with factors above 0 on some of the names."""
    document.keys("changes", (), document.get("changes") or ())
    for design in document.get("changes") or ():
        if document.keys(f"changes/{design}", (), names):
            for name in document.get(f"changes/{design}"):
                document.number(f"changes/{design}/{name}", "a factor above 0", lambda factor: factor > 0.0)


def drawn(spec, random, samples: int) -> numpy.ndarray:
    return random.uniform(*map(float, spec["uniform"]), samples) if isinstance(spec, dict) else numpy.full(samples, float(spec))


def read_probability(path: pathlib.Path) -> dict:
    """@raise InputError: all faults of the file"""
    document = Document(path, FORMAT)
    document.keys("", KEYS)
    document.known("parameters", document.laws())
    parameters = document.get("parameters")
    for name in parameters if isinstance(parameters, dict) else ():
        check_drawn(document, f"parameters/{name}")
    check_drawn(document, "knock")
    check_changes(document, list(parameters) if isinstance(parameters, dict) else [])
    document.whole("samples", 1)
    document.whole("seed", 0)
    found = dict(document.data, run=document.run("steps_per_turn"))
    document.done()
    return found


def run_probability(document: dict, progress=None) -> tuple[dict, dict]:
    """Dry whirl or not for every sample: of the design as it is, and of each change. And what was drawn."""
    from amb_rotor import _core
    random = numpy.random.default_rng(document["seed"])
    samples, run = document["samples"], document["run"]
    columns = {key: drawn(spec, random, samples) for key, spec in document["parameters"].items()}
    knock = drawn(document["knock"], random, samples)
    direction = random.uniform(0.0, 2.0 * math.pi, samples)
    initial = numpy.stack([numpy.zeros(samples), numpy.zeros(samples), knock * numpy.cos(direction),
                           knock * numpy.sin(direction)], axis=1)
    outcomes = {}
    for name, factors in {"as it is": {}, **document["changes"]}.items():
        changed = {key: column * factors.get(key, 1.0) for key, column in columns.items()}
        result = _core.run_basic_lanes(changed, initial, contact=document["contact"], friction=document["friction_law"],
                                       steps_per_turn=run["steps_per_turn"],
                                       turns_skipped=run["turns"] - run["kept_turns"], turns_kept=run["kept_turns"])
        outcomes[name] = numpy.array([regime == "dry_whirl" for regime in result["regime"]])
        if progress:
            progress(1)
    return outcomes, {**columns, "knock": knock}
