"""`amb new-effect`: an effect of one's own from the law that a diagnosis proposes."""
from __future__ import annotations

import pathlib
import re

from amb_rotor.cli import common
from amb_rotor.errors import InputError

HELP = "write a new effect from the law that a diagnosis proposes"
EXAMPLE = "amb new-effect cubic_spring --from out/diagnosis"


def add_arguments(parser) -> None:
    parser.add_argument("name", metavar="NAME", help="of the effect: lower case letters, digits and _")
    parser.add_argument("--from", metavar="DIAGNOSIS", required=True, dest="diagnosis",
                        help="folder that `amb diagnose` wrote, with a proposed law")
    parser.add_argument("--cpp", action="store_true", help="also as C++ header with its test, both to complete")
    parser.add_argument("--out", metavar="DIR", default=".", help="folder to write to (default: this one)")


def check_name(name: str) -> None:
    from amb_rotor import _core
    if not re.fullmatch(r"[a-z][a-z0-9_]{0,59}", name):
        raise InputError(f"{name}: a name has lower case letters, digits and _, at most 60, and begins with a letter")
    if name in [effect["id"] for effect in _core.effect_catalogue()]:
        raise InputError(f"{name}: the catalogue has an effect of this name")


def remarks_of(folder: pathlib.Path, diagnosis: dict) -> list[str]:
    unexplained = diagnosis["unexplained"]
    remarks = [f"A hypothesis from the diagnosis of {diagnosis.get('dataset', {}).get('name', folder.name)}, not a finding:",
               f"depends on {', '.join(unexplained['depends_on'])}; takes {100 * unexplained['held_out_gain']:.0f} % of what "
               "is left unexplained on held-out runs."]
    plane = unexplained.get("plane_z_m")
    remarks += [f"z_m = {plane['value']:.4g} +- {plane['std']:.2g}"] if plane else []
    return remarks + [f"{row['term']} = {row['coefficient']:.4g} +- {row['std']:.2g}" for row in unexplained["terms"]]


def write_new(path: pathlib.Path, text: str) -> None:
    if path.exists():
        raise InputError(f"{path}: is there already")
    common.atomic_write(path, text)


def run(args) -> int:
    from amb_rotor import _core, new_effect, new_effect_cpp
    from amb_rotor.cli.adopt import read_diagnosis
    check_name(args.name)
    folder, diagnosis = read_diagnosis(args.diagnosis)
    unexplained = diagnosis["unexplained"]
    terms, acts = unexplained["terms"], new_effect.Place.of(unexplained)
    place = (unexplained.get("frequency_hz"), acts)
    if not terms:
        raise InputError(f"{folder}: the verdict is {diagnosis['verdict']}, and no law is proposed; there is nothing to "
                         "make an effect of")
    for row in terms:
        if row["term"] not in new_effect.TERMS | new_effect.SIGNAL_TERMS:
            raise InputError(f"{folder}: the term {row['term']!r} is not known to this version")
    out = pathlib.Path(args.out)
    common.require_folder(out)
    out.mkdir(parents=True, exist_ok=True)
    summary = f"{new_effect.said(acts)} from {', '.join(unexplained['depends_on'])}, proposed by a diagnosis"
    path = out / f"{args.name}.yaml"
    write_new(path, new_effect.yaml_file(args.name, terms, summary, remarks_of(folder, diagnosis), *place))
    _core.read_effect(str(path))  # what is written can be read
    written = [path]
    if args.cpp:
        for name, text in ((f"{args.name}.hpp", new_effect_cpp.cpp_header(args.name, terms, summary, *place)),
                           (f"effect_{args.name}.cpp", new_effect_cpp.cpp_test(args.name, terms, *place))):
            write_new(out / name, text)
            written.append(out / name)
        print(f"C++: {args.name}.hpp goes to include/amb_rotor/effects/ with its line in all.hpp, effect_{args.name}.cpp to "
              "test/unit/; complete both")
    print(f"next: amb diagnose DATASET --effect-file {path}")
    common.write_json(args, {"effect": args.name, "files": written})
    common.report_line(path)
    return 0
