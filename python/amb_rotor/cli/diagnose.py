"""`amb diagnose`: which physical effect a model lacks."""
from __future__ import annotations

import argparse
import json
import math
import os
import pathlib
import secrets
import shutil

from amb_rotor import models
from amb_rotor.cli import common
from amb_rotor.errors import InputError

HELP = "find the physical effect that a model lacks"
EXAMPLE = "amb diagnose config/tutorial/measured --out out/diagnosis"
TIME_LIMIT_S = 240.0


def add_arguments(parser) -> None:
    parser.add_argument("dataset", metavar="DATASET", help="folder of format amb-dataset/1")
    parser.add_argument("--model", metavar="MODEL",
                        help="file of format amb-model/1 (default: the rig as the data set's owner believes it to be)")
    models.add_set(parser)
    parser.add_argument("--effect", metavar="ID", action="append", default=[], dest="candidates",
                        help="only this candidate; may be repeated (default: the whole catalogue)")
    parser.add_argument("--effect-file", metavar="FILE", action="append", default=[], dest="effect_files",
                        help="an effect of one's own (format amb-effect/1) joins the candidates; may be repeated")
    parser.add_argument("--steps", type=int, default=3, help="effects adopted at most (default: 3)")
    parser.add_argument("--threads", type=int, default=0, help="default: all cores")
    add_time_limit(parser)
    common.add_out(parser, "diagnose")


def time_limit(text: str) -> float:
    try:
        seconds = float(text)
    except ValueError:
        seconds = math.nan
    if not 0.0 <= seconds < math.inf:
        raise argparse.ArgumentTypeError(f"{text}: a time of 0 s or more")
    return seconds


def add_time_limit(parser) -> None:
    parser.add_argument("--time-limit", type=time_limit, metavar="SECONDS", default=TIME_LIMIT_S,
                        help="after which nothing new is begun: what is known by then is the result, and it says so "
                             f"(default: {TIME_LIMIT_S:g}; 0: none)")


def revisions_of(diagnosis: dict) -> list[dict]:
    """The error before, and after each step: what the chart of the falling error draws."""
    keys = ("fit_error", "validation_error", "validation_error_free", "validation_error_contact")
    rows = [{"label": "believed", **{key: diagnosis["baseline"].get(key) for key in keys}}]
    return rows + [{"label": f"+ {step['added']}", **{key: step.get(key) for key in keys}} for step in diagnosis["steps"]]


def parameter_text(name: str, value: dict) -> str:
    """name = value +- std unit; what stays fixed in a fit has no standard deviation."""
    spread = f" +- {value['std']:.2g}" if value["std"] else " (not fitted)"
    return f"{name} = {value['value']:.5g}{spread}{'' if value['unit'] == '1' else ' ' + value['unit']}"


def print_diagnosis(diagnosis: dict, told: list[str] | tuple = ()) -> None:
    """For people. told: remarks that stand there already."""
    baseline = diagnosis["baseline"]
    print(f"verdict: {diagnosis['verdict']}")
    for sentence in diagnosis["sentences"]:
        print(f"  {sentence}")
    print(f"error on held-out runs over noise: {baseline['validation_error']:.3f} as believed")
    for step in diagnosis["steps"]:
        print(f"  + {step['added']}: {step['validation_error']:.3f}")
        for name, value in step["parameters"].items():
            print(f"      {parameter_text(name, value)}")
    print("ranking                             evidence  held-out error")
    for row in diagnosis["ranking"][:8]:
        remarks = []
        if not row["excited"]:
            remarks.append("not excited by these runs")
        elif baseline.get("validation_error_contact") is not None and row.get("validation_error_contact") is None:
            remarks.append("error without contact alone")
        if row["beside"]:
            remarks.append("beside " + row["beside"])
        if row["confounded_with"]:
            remarks.append("hardly parted from " + ", ".join(row["confounded_with"]))
        figures = f"{row['evidence']:9.1f} {row['validation_error']:9.3f}" if row["excited"] else f"{'-':>9} {'-':>9}"
        print(f"  {row['effect']:<32} {figures}  {'; '.join(remarks)}".rstrip())
    for experiment in diagnosis.get("experiments", [])[:3]:
        print(f"to part {experiment['effect']} from {experiment['against']}: {experiment['what']} "
              f"(the wrong one leaves {experiment['separation']:.2g} times the noise)")
    unexplained = diagnosis["unexplained"]
    if unexplained["depends_on"]:
        gain = unexplained["held_out_gain"]
        takes = f" (takes {100 * gain:.3g} % of what is left on runs that it was not fitted to)" if gain > 0 else ""
        print(f"unexplained: depends on {', '.join(unexplained['depends_on'])}: {unexplained['shape']}{takes}")
    for remark in diagnosis["remarks"]:
        if remark not in told:
            print(f"remark: {remark}")


def write_folder(folder: pathlib.Path, fill) -> None:
    """Fills a folder beside and moves it into place, so that it is there whole or not at all."""
    part = folder.with_name(f".{secrets.token_hex(4)}.part.{folder.name}")
    part.mkdir(parents=True)
    try:
        fill(part)
        if folder.exists():
            old = folder.with_name(f".{secrets.token_hex(4)}.old.{folder.name}")
            os.replace(folder, old)
            os.replace(part, folder)
            shutil.rmtree(old)
        else:
            os.replace(part, folder)
    finally:
        shutil.rmtree(part, ignore_errors=True)


def may_replace(folder: pathlib.Path) -> None:
    """A folder of ours, or an empty or absent one: nothing else is overwritten."""
    if folder.name in ("", ".."):
        raise InputError(f"{folder}: the diagnosis is a folder of its own; name it")
    if os.path.exists(folder) and not folder.is_dir():
        raise InputError(f"{folder}: is a file; the diagnosis is a folder")
    if os.path.isdir(folder) and any(folder.iterdir()) and not (folder / "diagnosis.json").is_file():
        raise InputError(f"{folder}: holds other things than a diagnosis; name another folder")


def single_model(model, effect: str, row: dict):
    """The model with one candidate alone, as fitted."""
    return model.with_effect(effect, {name: value["value"] for name, value in row["parameters"].items()})


def diagnose(folder: pathlib.Path, model_path: str | None, args) -> tuple:
    """Dataset, model, diagnosis, adopted model, the models of the experiments that it proposes, and stages: (label, comparison) before,
    and after where an effect was found."""
    from amb_rotor import _core
    from amb_rotor.cli.compare import Bar
    if _core.is_modes_dataset(str(folder)):
        raise InputError(f"{folder}: a data set of modes; `amb compare` says where the model fails on it")
    loaded = [_core.load_effect(str(common.input_path(file)))["id"] for file in getattr(args, "effect_files", [])]
    if args.candidates:  # one's own join those that are asked for
        args.candidates += [name for name in loaded if name not in args.candidates]
    known = [effect["id"] for effect in _core.effect_catalogue()]
    for name in args.candidates:
        if name not in known:
            raise InputError(f"--effect {name}: there is no such effect; there are: {', '.join(known)}")
    dataset = _core.read_dataset(str(folder))
    model = models.loaded(model_path, args.overrides, dataset.belief)
    odd = models.oddities(model)
    if hopeless := models.hopeless(model):
        raise InputError([f"{folder}: the rig as believed {hopeless}; no missing effect is what is wrong with it", *odd[:-1]])
    for remark in odd:  # before the work: with such a model it may take long
        print(f"remark: {remark}", flush=True)
    comparisons: list = []
    with Bar("diagnosing") as bar:
        diagnosis, adopted, rivals = _core.diagnose(model, dataset, candidates=args.candidates,
                                                    threads=args.threads, most_steps=args.steps,
                                                    time_limit_s=args.time_limit, progress=bar, comparisons=comparisons)
    diagnosis["remarks"] = [*odd, *diagnosis["remarks"]]
    keep_faults(diagnosis, adopted)
    labels = ["as believed"] + [after_label(diagnosis) for _ in comparisons[1:]]
    return dataset, model, diagnosis, adopted, rivals, list(zip(labels, comparisons))


def keep_faults(diagnosis: dict, adopted) -> None:
    """A fit holds each parameter to its range, not the rules between them: a model that breaks one stays a finding, but is
    none to be written, run or compared."""
    if adopted.faults:
        diagnosis["adopted_faults"] = adopted.faults
        diagnosis["remarks"].append("the model as fitted breaks a rule of models, so that it cannot be run and adopted.yaml "
                                    "is left out: " + "; ".join(adopted.faults))


def save(out: pathlib.Path, folder: pathlib.Path, dataset, model, diagnosis: dict, adopted, stages: list, rivals: dict) -> None:
    """Writes the folder of a diagnosis, with stages as diagnose() returns them."""
    from amb_rotor import experiments
    from amb_rotor.report import data, law, write_report
    diagnosis["dataset"] = {"name": dataset.name, "folder": str(folder.resolve())}
    diagnosis["model"] = {"name": model.name, "hash": model.hash}

    def fill(part: pathlib.Path) -> None:
        experiments.write(part, out, diagnosis, rivals)
        text = json.dumps(common._plain(diagnosis), indent=2, allow_nan=False) + "\n"
        common.atomic_write(part / "diagnosis.json", text)
        model.write(str(part / "model.yaml"))
        if "adopted_faults" not in diagnosis:
            adopted.write(str(part / "adopted.yaml"))
        comparisons = {label: {key: comparison[key] for key in ("errors", "validation_errors")}
                       for label, comparison in zip(("before", "after"), (stage[1] for stage in stages))}
        common.atomic_write(part / "errors.json", json.dumps(common._plain(comparisons), indent=2) + "\n")
        write_report(part / "report.html", f"What does the model of {dataset.name} lack?",
                     f"{len(dataset.runs)} runs; model {model.name}, {model.hash}",
                     [data.stage(*stage) for stage in stages], diagnosis, revisions_of(diagnosis),
                     law=law.law_curves(diagnosis["unexplained"], stages[0][1]["runs"],
                                        *(tuple(model.fields[f"rig.planes.{kind}.{end}"] for end in "ab") for kind in ("sensor", "amb"))))

    out.parent.mkdir(parents=True, exist_ok=True)
    write_folder(out, fill)


def after_label(diagnosis: dict) -> str:
    return "with " + ", ".join(step["added"] for step in diagnosis["steps"])


def run(args) -> int:
    folder = common.dataset_folder(args.dataset)
    out = pathlib.Path(args.out) if args.out else pathlib.Path("out") / f"diagnose-{models.stem(folder)}"
    may_replace(out)
    common.require_writable(out)
    dataset, model, diagnosis, adopted, rivals, stages = diagnose(folder, args.model, args)
    print_diagnosis(diagnosis, models.oddities(model))
    try:
        save(out, folder, dataset, model, diagnosis, adopted, stages, rivals)
    finally:  # a folder that cannot be written takes the result with it, this not
        common.write_json(args, diagnosis)
    common.report_line(out / "report.html")
    return 0
