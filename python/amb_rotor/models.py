"""Model files as arguments of subcommands."""
from __future__ import annotations

import pathlib

from amb_rotor.cli import common


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


def stem(path) -> str:
    """A name for an output folder: of the file, or of the folder."""
    name = pathlib.Path(path).resolve().name
    for suffix in (".yaml", ".yml", ".json", ".csv", ".npz"):
        name = name.removesuffix(suffix)
    return name or "model"
