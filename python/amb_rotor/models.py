"""Model files as arguments of subcommands."""
from __future__ import annotations

import pathlib

from amb_rotor.cli import common
from amb_rotor.errors import InputError


def add_model(parser, with_set: bool = True) -> None:
    parser.add_argument("model", metavar="MODEL", help="file of format amb-model/1")
    if with_set:
        add_set(parser)


def add_set(parser) -> None:
    parser.add_argument("--set", metavar="PATH=VALUE", action="append", default=[], dest="overrides",
                        help="change a number of the model, e.g. rig.rotor.mass_kg=3.5; may be repeated")


def load(args):
    """The model that the arguments name, with its overrides."""
    from amb_rotor import _core
    model = _core.read_model(str(common.input_path(args.model)))
    return model.with_overrides(args.overrides) if getattr(args, "overrides", None) else model


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
