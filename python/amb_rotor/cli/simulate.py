"""`amb simulate`: one run of one machine, in process."""
from __future__ import annotations

import pathlib

from amb_rotor import models, yaml_file
from amb_rotor.cli import common
from amb_rotor.errors import InputError

HELP = "run a model through a scenario, in process"
EXAMPLE = "amb simulate config/thesis/levitation_model.yaml --scenario config/thesis/overload.yaml --out overload.csv"


def add_arguments(parser) -> None:
    models.add_model(parser)
    parser.add_argument("--scenario", metavar="S", help="file of format amb-scenario/1; without it MODEL is the scenario, "
                        "and the model the file beside it that its name begins with (drop_40_hz.yaml: drop_model.yaml)")
    parser.add_argument("--out", metavar="F", help="table to write: .csv, .csv.gz, .npz or .bag "
                                                   "(default: out/simulate-NAME/run.csv)")
    parser.add_argument("--motion-from", metavar="S", type=float,
                        help="say what the rotor does in its auxiliary bearings from this instant on (default: in the "
                        "second half of a failure of all magnetic bearings, where the scenario has one)")
    parser.add_argument("--picture", metavar="FILE", help="orbit, spectrum and time history of that, .png or .svg")


def write_csv(path: pathlib.Path, columns: dict) -> None:
    """A table with one header line; numbers to 12 digits."""
    import gzip
    import numpy
    with common.atomic_path(path) as part:
        opened = gzip.open(part, "wt", newline="") if path.name.endswith(".gz") else open(part, "w", newline="")
        with opened as file:
            file.write(",".join(columns) + "\n")
            numpy.savetxt(file, numpy.column_stack(list(columns.values())), fmt="%.12g", delimiter=",")


def write_npz(path: pathlib.Path, columns: dict, model, scenario) -> None:
    import numpy
    with common.atomic_path(path) as part:
        numpy.savez(part, **columns, model=numpy.array(model.text), model_hash=numpy.array(model.hash),
                    scenario=numpy.array(scenario.text))


def write_bag(path: pathlib.Path, columns: dict) -> None:
    """The table as a bag, as `amb convert` makes it."""
    from amb_rotor.cli import convert
    try:
        convert.write_table(path, columns)
    except ImportError as error:
        raise InputError(f"{path}: a bag needs ROS ({error}); a table (.csv, .npz) does not") from error


def run(args) -> int:
    import time
    from amb_rotor import _core
    if args.scenario is None:
        args.scenario, args.model = args.model, _model_of(args.model)
        print(f"model {args.model}, by the name of the scenario")
    model = models.load(args)
    scenario = _core.read_scenario(str(common.input_path(args.scenario)))
    path = pathlib.Path(args.out) if args.out else \
        pathlib.Path("out") / f"simulate-{models.stem(args.scenario)}" / "run.csv"
    if not path.name.endswith((".csv", ".csv.gz", ".npz", ".bag")):
        raise InputError(f"{path}: must end in .csv, .csv.gz, .npz or .bag")
    if args.picture and not args.picture.endswith((".png", ".svg")):
        raise InputError(f"--picture {args.picture}: must end in .png or .svg")
    if args.motion_from is not None and not 0.0 <= args.motion_from < scenario.duration_s:
        raise InputError(f"--motion-from {args.motion_from:g}: must be within the run of {scenario.duration_s:g} s")
    window = _motion_window(args, scenario)
    if args.picture and window is None:
        raise InputError("--picture: needs --motion-from, as this scenario has no failure of all magnetic bearings")
    for file in (path, *([] if path.suffix == ".npz" else [pathlib.Path(f"{path}.model.yaml")]),
                 *([pathlib.Path(args.picture)] if args.picture else [])):
        common.require_file(file)
    for remark in [*model.remarks, *scenario.remarks, *_core.remarks(model, scenario)]:
        print(f"remark: {remark}")
    path.parent.mkdir(parents=True, exist_ok=True)
    began = time.perf_counter()
    result = _core.simulate(model, scenario)
    seconds = time.perf_counter() - began
    if path.suffix == ".npz":
        write_npz(path, result["columns"], model, scenario)
    else:
        (write_bag if path.suffix == ".bag" else write_csv)(path, result["columns"])
        model.write(str(path) + ".model.yaml")
    summary = _summary(model, scenario, result, seconds)
    print(f"model {model.name} ({model.hash}), scenario {scenario.name}: {summary['duration_s']:g} s in {seconds:.2f} s"
          f" of computing, {result['steps']} steps, {result['events']} events; by {result['path']}")
    print(f"largest radius in the auxiliary bearings: {summary['max_radius']:.3f} of the clearance; "
          f"{summary['contacts']} contacts, {100 * summary['contact_fraction']:.1f} % of the time; "
          f"largest contact force {summary['max_contact_force_N']:.4g} N")
    if window is not None and result["time_s"] > (args.motion_from if args.motion_from is not None else window[1] - 1e-9):
        summary["motion"] = _motion(args, scenario, result, window)
    common.write_json(args, summary)
    if result["status"] != "ok":
        print(f"the run ended at {result['time_s']:.6g} s: {result['reason']}")
    common.report_line(path)
    return 0 if result["status"] == "ok" else 1


def _model_of(scenario: str) -> str:
    path = common.input_path(scenario)
    document = yaml_file.read(path) if path.is_file() else None
    if not isinstance(document, dict) or document.get("format") != "amb-scenario/1":
        raise InputError(f"{path}: is no scenario (format amb-scenario/1); name one with --scenario")
    return str(models.beside(path))


def _motion_window(args, scenario) -> tuple[float, float] | None:
    """The time of which the motion is told; None: of none."""
    import yaml
    from amb_rotor import drop
    if args.motion_from is not None:
        return args.motion_from, float("inf")
    failure = drop.power_failure(yaml.safe_load(scenario.text))
    return failure and (0.5 * sum(failure), failure[1])


def _motion(args, scenario, result: dict, window: tuple[float, float]) -> dict:
    import dataclasses
    from amb_rotor import drop
    begin, end = window
    until = result["columns"]["t_s"] < end
    columns = {name: column[until] for name, column in result["columns"].items()}
    found = drop.motion(columns, result["clearance_m"], begin)
    print((f"from {begin:g} s on" if args.motion_from is not None else f"without power, {begin:g} to {end:g} s") + f": {found.text()}")
    if args.picture:
        from amb_rotor.plots import drop as picture
        title = f"{found.kind.replace('_', ' ')}, {scenario.speed_hz:g} Hz"
        pathlib.Path(args.picture).parent.mkdir(parents=True, exist_ok=True)
        picture.drop(pathlib.Path(args.picture), columns, result["clearance_m"], begin, title)
        print(f"picture: {args.picture}")
    return {**dataclasses.asdict(found), "from_s": begin, "to_s": min(end, result["time_s"])}


def _summary(model, scenario, result: dict, seconds: float) -> dict:
    import numpy
    columns = result["columns"]
    radius, fraction, force = 0.0, 0.0, 0.0
    for end in "ab":
        place = numpy.hypot(columns[f"aux_{end}x_m"], columns[f"aux_{end}y_m"])
        radius = max(radius, float(numpy.max(place, initial=0.0)) / result["clearance_m"])
        force = max(force, float(numpy.max(columns[f"normal_{end}_N"], initial=0.0)))
    touching = (columns["normal_a_N"] > 0) | (columns["normal_b_N"] > 0)
    if touching.size:
        fraction = float(numpy.mean(touching))
    return {"model": model.name, "model_hash": model.hash, "scenario": scenario.name, "status": result["status"],
            "reason": result["reason"], "magnet_hit": result["magnet_hit"], "duration_s": scenario.duration_s,
            "time_s": result["time_s"],
            "samples": int(columns["t_s"].size), "max_radius": radius, "contact_fraction": fraction,
            "contacts": len(result["contacts"]), "max_contact_force_N": force, "steps": result["steps"],
            "events": result["events"], "path": result["path"], "seconds": seconds}
