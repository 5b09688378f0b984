"""`amb adopt`: the model with a diagnosed effect added, fitted, and its history."""
from __future__ import annotations

import datetime
import json
import os
import pathlib
import shutil

from amb_rotor import yaml_file
from amb_rotor.cli import common
from amb_rotor.errors import InputError

HELP = "add a diagnosed effect to the model, fitted, with the history of its error"
EXAMPLE = "amb adopt out/diagnosis --out model_2.yaml"
LEDGER = "revisions.yaml"
ERROR_KEYS = ("validation_error", "validation_error_free", "validation_error_contact")


def add_arguments(parser) -> None:
    parser.add_argument("diagnosis", metavar="DIAGNOSIS", help="the folder that `amb diagnose` wrote")
    parser.add_argument("--effect", metavar="ID", action="append", default=[],
                        help="an effect of the ranking (default: the steps that the diagnosis took)")
    parser.add_argument("--out", metavar="MODEL", required=True, help="model file to write; revisions.yaml goes beside it")


def read_diagnosis(text: str) -> tuple[pathlib.Path, dict]:
    folder = common.input_path(text)
    folder = folder.parent if folder.name == "diagnosis.json" else folder
    path = folder / "diagnosis.json"
    if not path.is_file():
        raise InputError(f"{folder}: there is no diagnosis.json; DIAGNOSIS is the folder that `amb diagnose` wrote")
    try:
        diagnosis = json.loads(path.read_text())
    except ValueError as error:
        raise InputError(f"{path}: {error}") from error
    if not isinstance(diagnosis, dict) or diagnosis.get("format") != "amb-diagnosis/1":
        raise InputError(f"{path}: format must be amb-diagnosis/1")
    for name in ("model.yaml", "adopted.yaml"):
        if not (folder / name).is_file() and not (name == "adopted.yaml" and "adopted_faults" in diagnosis):
            raise InputError(f"{folder / name}: is missing; run `amb diagnose` again")
    return folder, diagnosis


def _steps_as_diagnosed(folder: pathlib.Path, diagnosis: dict):
    """Model and history entries of the steps that the diagnosis took."""
    from amb_rotor import _core
    if not diagnosis["steps"]:
        raise InputError(f"{folder}: the verdict is {diagnosis['verdict']}: there is nothing to adopt "
                         "(--effect ID takes one of the ranking all the same)")
    if "adopted_faults" in diagnosis:
        raise InputError(f"{folder}: the model as fitted cannot be run: " + "; ".join(diagnosis["adopted_faults"]))
    adopted = _core.read_model(str(folder / "adopted.yaml"))
    return adopted, [(step["added"], step) for step in diagnosis["steps"]]


def _chosen(folder: pathlib.Path, diagnosis: dict, effects: list[str], dataset):
    """Model and history entries of effects that the person chose."""
    from amb_rotor import _core
    from amb_rotor.cli.compare import Bar
    ranking = {row["effect"]: row for row in diagnosis["ranking"]}
    for effect in effects:
        if effect not in ranking:
            raise InputError(f"--effect {effect}: is not in the ranking; there are: {', '.join(ranking) or 'none'}")
    if len(effects) == 1:
        # the nuisance is refitted beside the candidate's own values
        row = ranking[effects[0]]
        model = _core.read_model(str(folder / "model.yaml"))
        model = model.with_effect(effects[0], {name: value["value"] for name, value in row["parameters"].items()})
        with Bar("refitting") as bar:
            model = _core.compare(model, dataset, progress=bar)["model"]
        return model, [(effects[0], row)]
    # several: each fitted on top of the ones before
    belief = _core.read_model(str(folder / "model.yaml"))
    steps = []
    for effect in effects:
        with Bar(f"fitting {effect}") as bar:
            found, adopted, _ = _core.diagnose(belief, dataset, candidates=[effect], most_steps=1, progress=bar)
        if not found["steps"]:
            raise InputError(f"--effect {effect}: earns nothing on the held-out runs beside the others")
        belief = adopted
        steps.append((effect, found["steps"][0]))
    return belief, steps


def _dataset_of(diagnosis: dict):
    from amb_rotor import _core
    folder = diagnosis.get("dataset", {}).get("folder", "")
    if not pathlib.Path(folder).is_dir():
        raise InputError(f"{folder}: the data set of the diagnosis is not there any more")
    return _core.read_dataset(folder)


def read_ledger(path: pathlib.Path) -> list[dict]:
    if not path.is_file():
        return []
    document = yaml_file.read(path)
    if not isinstance(document, dict) or document.get("format") != "amb-revisions/1" \
            or not isinstance(document.get("revisions"), list) \
            or not all(isinstance(entry, dict) and "revision" in entry for entry in document["revisions"]):
        raise InputError(f"{path}: must be of format amb-revisions/1")
    return document["revisions"]


def _tidy(value):
    """Numbers with the digits that mean something, for people."""
    if isinstance(value, float):
        return float(f"{value:.6g}")
    if isinstance(value, dict):
        return {key: _tidy(item) for key, item in value.items()}
    return [_tidy(item) for item in value] if isinstance(value, list) else value


def yaml_text(value) -> str:
    """YAML for people: in the order given, without anchors."""
    import yaml

    class Dumper(yaml.SafeDumper):
        def ignore_aliases(self, data):
            return True

    return yaml.dump(value, Dumper=Dumper, sort_keys=False)


def _free_name(out: pathlib.Path, word: str, taken: pathlib.Path | None = None) -> pathlib.Path:
    """A name beside `out` that is free: model_r0.yaml."""
    path = out.with_name(f"{out.stem}_{word}{out.suffix}")
    count = 1
    while path.exists() or path == taken:
        count += 1
        path = out.with_name(f"{out.stem}_{word}_{count}{out.suffix}")
    return path


def _check_out(out: pathlib.Path) -> None:
    """Only a model is replaced, and before any work."""
    if os.path.isdir(out):
        raise InputError(f"{out}: is a folder; --out is the model file to write")
    if out.name == LEDGER:
        raise InputError(f"{out}: is the name of the ledger beside the model; --out is the model file to write")
    if not os.path.exists(out):
        return
    if not out.is_file():
        raise InputError(f"{out}: is no file; --out is the model file to write")
    from amb_rotor.cli.check import format_of
    try:
        is_model = format_of(out) == "amb-model/1"
    except InputError:
        is_model = False
    if not is_model:
        raise InputError(f"{out}: is there already, and is no model; --out is the model file to write")


def _kept_earlier(out: pathlib.Path, ledger: list[dict], begin: pathlib.Path | None) -> pathlib.Path | None:
    """Where what stands in `out` goes: each revision can be taken up again, and no one's own file is lost. Its lines in the ledger
    follow."""
    if not out.is_file():
        return None
    entries = [entry for entry in ledger if entry.get("file") == out.name]
    kept = _free_name(out, f"r{entries[0]['revision']}" if entries else "before", begin)
    for entry in entries:
        entry["file"] = kept.name
    return kept


def _write_all(out: pathlib.Path, model, parent, ledger: list[dict], revision: dict) -> None:
    """Model, ledger and what stood in their way: all of them, or none."""
    begin = None if ledger else _free_name(out, "r0")
    kept = _kept_earlier(out, ledger, begin)
    if begin:
        ledger.append({"revision": 0, "hash": parent.hash, "model": parent.name, "file": begin.name, "after": revision["before"]})
    ledger.append({"revision": len(ledger), "file": out.name, **revision})
    with common.atomic_paths() as part_of:
        if begin:
            parent.write(str(part_of(begin)))
        if kept:
            shutil.copy2(out, part_of(kept))
        model.write(str(part_of(out)))
        part_of(out.with_name(LEDGER)).write_text(yaml_text({"format": "amb-revisions/1", "revisions": ledger}))
    if kept:
        print(f"what was in {out.name} is now in {kept.name}")


def run(args) -> int:
    from amb_rotor import _core
    from amb_rotor.cli.diagnose import parameter_text
    folder, diagnosis = read_diagnosis(args.diagnosis)
    out = pathlib.Path(args.out)
    _check_out(out)
    ledger_path = out.parent / LEDGER
    for file in (out, ledger_path):
        common.require_file(file)
    ledger = read_ledger(ledger_path)
    parent = _core.read_model(str(folder / "model.yaml"))
    if args.effect:
        model, steps = _chosen(folder, diagnosis, args.effect, _dataset_of(diagnosis))
    else:
        model, steps = _steps_as_diagnosed(folder, diagnosis)
    errors = json.loads((folder / "errors.json").read_text()) if (folder / "errors.json").is_file() else {}
    revision = {
        "parent": parent.hash,
        "hash": model.hash,
        "date": datetime.date.today().isoformat(),
        "dataset": diagnosis.get("dataset", {}).get("name", ""),
        "effects": [{"effect": name, "parameters": step["parameters"],
                     **{key: step.get(key) for key in ERROR_KEYS}} for name, step in steps],
        "before": {key: diagnosis["baseline"].get(key) for key in ERROR_KEYS},
        "after": {key: steps[-1][1].get(key) for key in ERROR_KEYS},
    }
    if not args.effect and "after" in errors:
        revision["errors_by_run"] = {"before": errors["before"]["errors"]["by_run"],
                                     "after": errors["after"]["errors"]["by_run"]}
    revision = _tidy(revision)
    model.revision = yaml_text(revision)
    out.parent.mkdir(parents=True, exist_ok=True)
    _write_all(out, model, parent, ledger, revision)
    for name, step in steps:
        print(f"added {name}:")
        for parameter, value in step["parameters"].items():
            print(f"  {parameter_text(parameter, value)}")
    before, after = revision["before"]["validation_error"], revision["after"]["validation_error"]
    print(f"error on held-out runs over noise: {before:.3f} -> {after:.3f}; model {parent.hash} -> {model.hash}")
    common.write_json(args, {"model": str(out), "ledger": str(ledger_path), **revision})
    common.report_line(out)
    return 0
