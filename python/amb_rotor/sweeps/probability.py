"""Probability of dry whirl after a knock: random machines and knocks in the lanes (format amb-probability/1).

The interval is Wilson's, 95 %: p in (k + z^2/2 +- z sqrt(k (n - k)/n + z^2/4)) / (n + z^2), z = 1.96
(Wilson, J. Am. Stat. Assoc. 22, 1927). A difference between two designs run on the same samples has the
standard error sqrt(a + b - (a - b)^2/n)/n, where a samples got better and b got worse.
"""
from __future__ import annotations

import math
import pathlib

import numpy
import yaml

from amb_rotor.errors import InputError

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


def read_probability(path: pathlib.Path) -> dict:
    """@raise InputError"""
    document = yaml.safe_load(path.read_text())
    faults = [f"{path}: {key}: the key is missing" for key in sorted(KEYS - document.keys())]
    faults += [f"{path}: {key}: the key is not known here" for key in sorted(document.keys() - KEYS)]
    if faults:
        raise InputError(faults)
    if not isinstance(document["samples"], int) or document["samples"] < 1:
        raise InputError(f"{path}: samples: must be a whole number of at least 1")
    return document


def _drawn(spec, random, samples: int, key: str) -> numpy.ndarray:
    if isinstance(spec, (int, float)):
        return numpy.full(samples, float(spec))
    if isinstance(spec, dict) and set(spec) == {"uniform"} and len(spec["uniform"]) == 2:
        return random.uniform(*map(float, spec["uniform"]), samples)
    raise InputError(f"{key}: a number, or {{uniform: [least, largest]}}")


def run_probability(document: dict, progress=None) -> tuple[dict, dict]:
    """Dry whirl or not for every sample: of the design as it is, and of each change. And what was drawn."""
    from amb_rotor import _core
    random = numpy.random.default_rng(document["seed"])
    samples, run = document["samples"], document["run"]
    columns = {key: _drawn(spec, random, samples, f"parameters.{key}") for key, spec in document["parameters"].items()}
    knock = _drawn(document["knock"], random, samples, "knock")
    direction = random.uniform(0.0, 2.0 * math.pi, samples)
    initial = numpy.stack([numpy.zeros(samples), numpy.zeros(samples), knock * numpy.cos(direction),
                           knock * numpy.sin(direction)], axis=1)
    outcomes = {}
    for name, factors in {"as it is": {}, **document["changes"]}.items():
        changed = {key: column * factors.get(key, 1.0) for key, column in columns.items()}
        unknown = set(factors) - set(columns)
        if unknown:
            raise InputError(f"changes.{name}: {', '.join(sorted(unknown))}: no parameter of this file")
        result = _core.run_basic_lanes(changed, initial, contact=document["contact"], friction=document["friction_law"],
                                       steps_per_turn=run["steps_per_turn"],
                                       turns_skipped=run["turns"] - run["kept_turns"], turns_kept=run["kept_turns"])
        outcomes[name] = numpy.array([regime == "dry_whirl" for regime in result["regime"]])
        if progress:
            progress(1)
    return outcomes, {**columns, "knock": knock}
