"""Model files as arguments of subcommands."""
from __future__ import annotations

import math
import pathlib

from amb_rotor.cli import common
from amb_rotor.errors import InputError


def add_model(parser, with_set: bool = True) -> None:
    parser.add_argument("model", metavar="MODEL", help="file of format amb-model/1")
    if with_set:
        add_set(parser)


def loaded(path: str | None, overrides: list[str], belief):
    """The model of a file with its overrides; none or -: the belief."""
    from amb_rotor import _core
    model = _core.read_model(str(common.input_path(path))) if path and path != "-" else belief
    return model.with_overrides(overrides) if overrides else model


def add_set(parser) -> None:
    parser.add_argument("--set", metavar="PATH=VALUE", action="append", default=[], dest="overrides",
                        help="change a number of the model, e.g. rig.rotor.mass_kg=3.5; may be repeated")


def load(args):
    """The model that the arguments name, with its overrides."""
    from amb_rotor import _core
    model = _core.read_model(str(common.input_path(args.model)))
    return model.with_overrides(args.overrides) if getattr(args, "overrides", None) else model


# Growth at standstill over the controller's sample rate from which on no uncertainty and no missing effect is what is wrong: the
# motion grows e times within ten samples. Loops with twice the delay or half the bandwidth are far below.
HOPELESS_GROWTH = 0.1


def _growth(model) -> float:
    """The largest growth at standstill [1/s]; below 0: it levitates."""
    from amb_rotor import modal
    try:
        return modal.largest_growth(model, 0.0)
    except InputError:  # some valid models have no modes
        return 0.0


def hopeless(model) -> str:
    """Why a model is so far from levitating that no fit leads from it to a rig that does; empty: it is not."""
    rate = model.fields.get("rig.controller.sample_rate_hz", math.inf) if model.amb_model == "linear" else math.inf
    growth = _growth(model)
    return "" if growth <= HOPELESS_GROWTH * rate else \
        f"cannot levitate: at standstill its motion grows e times in {1e6 / growth:.3g} us, {rate / growth:.2g} samples of its controller"


def oddities(model) -> list[str]:
    """What is no fault of a model but seldom meant: numbers of an unusual size, and that it cannot levitate."""
    growth = _growth(model)
    unstable = [f"NOT STABLE at standstill, grows with {growth:.3g} 1/s (amb modes says how)"] if growth > 1e-6 else []
    return [*model.remarks, *unstable]


def beside(scenario: pathlib.Path) -> pathlib.Path:
    """The model that belongs to a scenario by its name: of drop_150_hz.yaml it is drop_150_hz_model.yaml,
    drop_150_model.yaml or drop_model.yaml in the same folder, the first that there is."""
    words = stem(scenario).split("_")
    names = [scenario.parent / ("_".join(words[:count]) + "_model.yaml") for count in range(len(words), 0, -1)]
    for name in names:
        if name.is_file():
            return name
    raise InputError(f"{scenario}: is a scenario; name its model, or put it beside as {names[-1].name} "
                     "(amb simulate MODEL --scenario SCENARIO)")


def stem(path) -> str:
    """A name for an output folder: of the file, or of the folder."""
    name = pathlib.Path(path).resolve().name
    for suffix in (".yaml", ".yml", ".json", ".csv", ".npz"):
        name = name.removesuffix(suffix)
    return name or "model"
