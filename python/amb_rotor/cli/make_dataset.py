"""`amb make-dataset`: a blind data set of our own, with its truth beside it."""
from __future__ import annotations

import os
import pathlib

from amb_rotor.cli import common
from amb_rotor.errors import InputError

HELP = "make a data set with a hidden effect on a rig drawn at random, and its truth"
EXAMPLE = "amb make-dataset --seed 7 --effect sensor_runout --strength 5 --out out/blind-7"


def add_arguments(parser) -> None:
    parser.add_argument("--seed", type=int, required=True, metavar="N", help="the same seed gives the same set")
    parser.add_argument("--effect", nargs="+", default=[], metavar="ID",
                        help="effects of the catalogue to hide, a law of no catalogue (quadratic_damping, "
                             "cubic_stiffness, sensor_dead_zone, hum, third_harmonic_force, speed_stiffness, "
                             "current_dead_zone), or none (default: drawn)")
    parser.add_argument("--effect-file", metavar="FILE", action="append", default=[], dest="effect_files",
                        help="an effect of one's own (format amb-effect/1) that --effect may name; may be repeated")
    parser.add_argument("--strength", type=float, default=0.0, metavar="S",
                        help="what the effect changes, over the noise, rms (default: drawn from 2 to 20)")
    parser.add_argument("--contact", action="store_true", help="with rubs and drops, also where no effect needs them")
    parser.add_argument("--friction", choices=["regularised", "set_valued"], default="regularised",
                        help="law of the rig and its truth (default: regularised; set_valued can stick)")
    parser.add_argument("--out", metavar="DIR", required=True, help="folder to write; must not hold a data set yet")


def run(args) -> int:
    from amb_rotor import _core
    folder = pathlib.Path(args.out)
    if os.path.exists(folder / "dataset.yaml"):
        raise InputError(f"{folder}: there is a data set already")
    if args.seed < 0:
        raise InputError("--seed: must be from 0")
    if args.strength < 0.0:
        raise InputError("--strength: must be from 0")
    for file in args.effect_files:
        _core.load_effect(str(common.input_path(file)))
    common.require_folder(folder)
    common.require_folder(folder / "runs")
    try:
        with common.atomic_folder(folder) as part:
            made = common.on_thread(lambda: _core.make_dataset(
                args.seed, args.effect, args.strength, args.contact, str(part), args.friction == "set_valued"))
    except (KeyboardInterrupt, SystemExit) as stop:
        common.end_at_once("make-dataset", stop)
    hidden = ", ".join(effect["effect"] for effect in made["effects"]) or made["law"] or "nothing"
    print(f"hidden: {hidden}; changes the runs by {made['difference']:.1f} times their noise; "
          f"a diagnosis should say {made['verdict']}")
    common.write_json(args, made)
    common.report_line(folder / "dataset.yaml")
    return 0
