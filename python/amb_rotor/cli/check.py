"""`amb check`: whether a file is valid, and every fault in it."""
from __future__ import annotations

import pathlib

from amb_rotor import yaml_file
from amb_rotor.cli import common
from amb_rotor.errors import InputError

HELP = "say whether a model, scenario, sweep or data set is valid, and every fault in it"
EXAMPLE = "amb check config/thesis/levitation_model.yaml"


def add_arguments(parser) -> None:
    parser.add_argument("file", metavar="FILE", help="model, scenario, sweep, or the folder of a data set")


def format_of(path: pathlib.Path) -> str:
    if path.name.endswith((".csv", ".csv.gz", ".npz", ".bag")):
        raise InputError(f"{path}: is a table of numbers; the data set that it belongs to can be checked: the folder with "
                         "dataset.yaml, which says what its tables hold")
    document = yaml_file.read(path)
    name = document.get("format") if isinstance(document, dict) else None
    if not isinstance(name, str):
        raise InputError(f"{path}: no key `format`: amb-model/1, amb-scenario/1, amb-sweep/1, amb-dataset/1 ...")
    return name


def _check_dataset(folder: pathlib.Path) -> str:
    from amb_rotor import _core, models
    if _core.is_modes_dataset(str(folder)):
        dataset = _core.read_modes_dataset(str(folder))
        return f"data set of modes {dataset.name}: {len(dataset.points)} measurements of {dataset.mode_count} modes"
    dataset = _core.read_dataset(str(folder))
    faults, samples = [], 0
    for run in common.progress(dataset.runs, "tables"):
        try:
            samples += dataset.table(run["id"])["t_s"].size
        except InputError as error:
            faults += error.faults
    if faults:
        raise InputError(faults)
    found = f"data set {dataset.name}: {len(dataset.runs)} runs, {samples} samples"
    lacking = [f"amb diagnose will refuse it: {rule}" for rule in dataset.lacking_uses]
    return "\nremark: ".join([found, *lacking, *models.oddities(dataset.belief)])


def _check_model(path: pathlib.Path) -> str:
    """What it is, and, because it is no fault of the file but seldom meant, what is odd in it and whether it cannot levitate."""
    from amb_rotor import _core, models
    model = _core.read_model(str(path))
    effects = ", ".join(effect["effect"] for effect in model.effects) or "none"
    found = f"model {model.name}: {model.rotor_model}, AMB {model.amb_model}, effects: {effects}; hash {model.hash}"
    return "\nremark: ".join([found, *models.oddities(model)])


def _check_file(path: pathlib.Path, kind: str) -> str:
    from amb_rotor import _core
    if kind == "amb-model/1":
        return _check_model(path)
    if kind == "amb-scenario/1":
        scenario = _core.read_scenario(str(path))
        return "\nremark: ".join([f"scenario {scenario.name}: {scenario.duration_s:g} s", *scenario.remarks])
    if kind == "amb-sweep/1":
        sweep = _core.BasicSweep(str(path))
        return f"sweep {sweep.name}: {sweep.size} points"
    if kind == "amb-rotor-geometry/1":
        shaft = _core.read_rotor_geometry(str(path))
        return f"shaft {shaft['name']}: {shaft['length_m']:.4g} m, {shaft['mass_kg']:.4g} kg"
    if kind == "amb-search/1":
        from amb_rotor.sweeps import search
        return f"search {search.read_search(path).name}"
    if kind == "amb-drop-map/1":
        from amb_rotor.sweeps import drops
        document = drops.read_drops(path)
        return f"map of drops {document['name']}: {drops.size(document)} drops"
    if kind == "amb-figure/1":
        from amb_rotor.sweeps import figures
        return f"figure {figures.read_figure(path)['name']}"
    if kind == "amb-basin/1":
        from amb_rotor.sweeps import basin
        document = basin.read_basin(path)
        return f"basin {document['name']}: {len(document['speed']) * len(document['direction_deg'])} knocks"
    if kind in ("amb-probability/1", "amb-drop-probability/1"):
        from amb_rotor.sweeps import drop_probability, probability
        document = (probability.read_probability if kind == "amb-probability/1" else drop_probability.read)(path)
        return f"probability {document['name']}: {document['samples']} samples of {1 + len(document['changes'])} designs"
    if kind == "amb-effect/1":
        effect = _core.read_effect(str(path))
        return f"effect {effect['id']}: {', '.join(p['name'] for p in effect['parameters'])}"
    if kind == "amb-diagnosis/1":
        return "diagnosis"
    raise InputError(f"{path}: format {kind!r} is not known; amb-model/1, amb-scenario/1, amb-sweep/1, amb-search/1, "
                     "amb-figure/1, amb-basin/1, amb-probability/1, amb-drop-map/1, amb-drop-probability/1, amb-effect/1, "
                     "amb-rotor-geometry/1, amb-dataset/1 are")


def run(args) -> int:
    path = common.input_path(args.file)
    is_dataset = path.is_dir() or path.name == "dataset.yaml"
    kind = "amb-dataset/1" if is_dataset else format_of(path)
    try:
        if kind == "amb-dataset/1":
            text = _check_dataset(common.dataset_folder(path))
        else:
            text = _check_file(path, kind)
    except InputError as error:
        common.write_json(args, {"valid": False, "format": kind, "faults": error.faults})
        raise
    common.write_json(args, {"valid": True, "format": kind, "faults": []})
    print(f"{path}: valid {kind}: {text}")
    return 0
