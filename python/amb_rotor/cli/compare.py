"""`amb compare`: where a model holds against measurements, and where it fails."""
from __future__ import annotations

import pathlib

from amb_rotor import models
from amb_rotor.cli import common
from amb_rotor.errors import InputError

HELP = "a model against measurements: where it holds and where it fails"
EXAMPLE = "amb compare - config/tutorial/measured --limit 1.5"


def add_arguments(parser) -> None:
    parser.add_argument("paths", metavar="[MODEL] DATASET", nargs="+",
                        help="file of format amb-model/1 (left out or -: the rig as the data set's owner believes it to "
                             "be), folder of format amb-dataset/1")
    models.add_set(parser)
    parser.add_argument("--limit", metavar="E", type=float,
                        help="exit status 1 where the error on the held-out runs is above it")
    parser.add_argument("--no-refit", action="store_true", help="take the model's numbers as they are")
    parser.add_argument("--threads", type=int, default=0, help="default: all cores")
    common.add_out(parser, "compare")


class Bar:
    """Progress of a long call of the core, as a bar; Ctrl-C is heard while it runs."""

    def __init__(self, description: str):
        self._bar = common.progress_bar(100, description)

    def __call__(self, share: float, text: str) -> None:
        self._bar.set_postfix_str(text, refresh=False)
        self._bar.update(100.0 * share - self._bar.n)

    def __enter__(self):
        self._bar.__enter__()
        return self

    def __exit__(self, *error):
        return self._bar.__exit__(*error)


def paths_of(args) -> tuple[str | None, pathlib.Path]:
    """The model's path, or None for the data set's own rig, and the data set's folder."""
    if len(args.paths) > 2:
        raise InputError("at most a MODEL and a DATASET")
    model = args.paths[0] if len(args.paths) == 2 and args.paths[0] != "-" else None
    return model, common.dataset_folder(args.paths[-1])


def comparison_json(comparison: dict, dataset_name: str) -> dict:
    """What --json and comparison.json hold: the errors over all runs, and those over the held-out runs."""
    model = comparison["model"]
    return {**comparison["errors"], "validation": comparison["validation_errors"], "nuisance": comparison["nuisance"],
            "dataset": dataset_name, "model": model.name, "model_hash": model.hash, "remarks": comparison["remarks"],
            "effects": model.effects}


def print_errors(comparison: dict) -> None:
    def text(value):
        return "-" if value is None else f"{value:.3f}" if value < 1e6 else f"{value:.3g}"
    print("error over noise    all    no contact  contact")
    for label, key in (("all runs", "errors"), ("held-out runs", "validation_errors")):
        errors = comparison[key]
        print(f"  {label:<14} {text(errors['error']):>7} {text(errors['error_free']):>11} "
              f"{text(errors['error_contact']):>8}")
    print("  by run: " + ", ".join(f"{run} {error:{'.2f' if error < 1e6 else '.3g'}}" for run, error in comparison["errors"]["by_run"].items()))
    if comparison["errors"]["worst"]:
        print(comparison["errors"]["worst"])
    for remark in comparison["remarks"]:
        print(f"remark: {remark}")


def run(args) -> int:
    from amb_rotor import _core
    path, folder = paths_of(args)
    if _core.is_modes_dataset(str(folder)):
        from amb_rotor.modes_comparison import run_modes
        return run_modes(args, path, folder)
    from amb_rotor.report import data, write_report
    dataset = _core.read_dataset(str(folder))
    model = models.loaded(path, args.overrides, dataset.belief)
    out = common.out_path(args, "compare", models.stem(folder))
    odd = models.oddities(model)
    for remark in odd:  # before the work: with such a model it may take long
        print(f"remark: {remark}", flush=True)
    if hopeless := models.hopeless(model):
        odd.append(f"the model {hopeless}; its numbers are taken as they are")
        print(f"remark: {odd[-1]}", flush=True)
    with Bar("comparing") as bar:
        comparison = _core.compare(model, dataset, refit=not args.no_refit and not hopeless, threads=args.threads, progress=bar)
    effects = ", ".join(effect["effect"] for effect in model.effects) or "none"
    print(f"model {model.name} ({model.hash}; effects: {effects}) against {dataset.name}, {len(dataset.runs)} runs")
    print_errors(comparison)
    comparison["remarks"] = [*odd, *comparison["remarks"]]
    result = comparison_json(comparison, dataset.name)
    common.write_json(args, result)
    out.mkdir(parents=True, exist_ok=True)
    import json
    common.atomic_write(out / "comparison.json", json.dumps(common._plain(result), indent=2) + "\n")
    name = model.name if path else "The rig as believed"
    report = write_report(out / "report.html", f"{name} against {dataset.name}",
                          f"model {comparison['model'].hash}, effects: {effects}", [data.stage(name, comparison)])
    common.report_line(report)
    error = comparison["validation_errors"]["error"] or comparison["errors"]["error"]
    return 1 if args.limit is not None and error > args.limit else 0
