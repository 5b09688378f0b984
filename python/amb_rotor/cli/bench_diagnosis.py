"""`amb bench-diagnosis`: diagnoses blind sets of our own and counts how often it is right. doc/blind_sets.md."""
from __future__ import annotations

import json
import math
import os
import pathlib
import shutil
import signal
import sys
import tempfile
import threading

from amb_rotor import yaml_file
from amb_rotor.cli import common, diagnose
from amb_rotor.errors import InputError

HELP = "diagnose blind data sets, our own or others': hits, false alarms, parameter errors, time"
EXAMPLE = "amb bench-diagnosis --sets 30 --jobs 2 --keep out/bench"
TRUTH_FORMAT = "amb-truth/1"

CLEAN_SETS = 4   # in each round, beside every effect once, every hidden law once and
PAIR_SETS = 6    # pairs of effects
STRIDE = 100003  # between the seeds of two benches

_writing = threading.Lock()


def add_arguments(parser) -> None:
    parser.add_argument("--sets", type=int, default=100, metavar="N", help="how many sets (default: 100)")
    parser.add_argument("--seed", type=int, default=1, metavar="S", help="of all of them (default: 1)")
    parser.add_argument("--jobs", type=int, default=1, metavar="J", help="sets at a time (default: 1)")
    diagnose.add_time_limit(parser)
    parser.add_argument("--keep", metavar="DIR",
                        help="keep sets and diagnoses here; what is there already is not done again")
    parser.add_argument("--contact", action="store_true", help="with rubs and drops in every set, also where no effect needs them")
    parser.add_argument("--data", metavar="DIR",
                        help="instead of our own: the data sets in this folder's folders that have a truth.yaml")
    parser.add_argument("--out", metavar="DIR", help="folder for the table (default: out/bench-diagnosis)")


def seed_of(seed: int, index: int) -> int:
    return seed * STRIDE + index


def hidden_in(index: int, seed: int, core) -> list[str]:
    """What set `index` hides: every effect once, clean sets, hidden laws, pairs; then again with other rigs."""
    import random
    effects = [schema["id"] for schema in core.effect_catalogue() if not schema["only_by_name"]]
    laws = list(core.hidden_laws())
    place = index % (len(effects) + CLEAN_SETS + len(laws) + PAIR_SETS)
    if place < len(effects):
        return [effects[place]]
    place -= len(effects)
    if place < CLEAN_SETS:
        return ["none"]
    place -= CLEAN_SETS
    if place < len(laws):
        return [laws[place]]
    return random.Random(seed_of(seed, index)).sample(effects, 2)


def _wrapped(difference: float, period: float) -> float:
    return difference - period * round(difference / period)


def parameter_errors(true: dict, found: dict) -> dict[str, float]:
    """Errors over the stated standard deviations; phases round the turn."""
    errors = {}
    for name, value in true.items():
        entry = found.get(name)
        if entry is None or name == "reference_speed_hz":
            continue
        difference = entry["value"] - value
        if name.endswith("phase_rad"):
            difference = _wrapped(difference, math.pi if "_2x_" in name else 2.0 * math.pi)
        if entry["std"] > 0.0:
            errors[name] = difference / entry["std"]
        elif abs(difference) > 1e-9 * abs(value):
            errors[name] = math.inf  # claimed to be exact
    return errors


def _mirrored(effect: str, parameters: dict) -> dict:
    """The same machine said in the other way: a bow with its phase half a turn on, a mode with all its shapes turned round."""
    sign = {"shaft_bow": "bow_", "shaft_flexibility": "shape_"}.get(effect)
    if sign is None:
        return parameters
    turned = {name: -value if name.startswith(sign) else value for name, value in parameters.items()}
    if "phase_rad" in turned:
        turned["phase_rad"] += math.pi
    return turned


def _at_its_reference(true: dict, found: dict) -> dict:
    """The same cross-coupling q (W/W0)^n, stated at the reference speed W0 of the truth."""
    factor = (true["reference_speed_hz"] / found["reference_speed_hz"]["value"]) ** found["speed_exponent"]["value"]
    moved = {key: factor * found["stiffness_N_per_m"][key] for key in ("value", "std")}
    return {**found, "stiffness_N_per_m": {**found["stiffness_N_per_m"], **moved}}


def _errors_of(effect: str, true: dict, found: dict) -> dict[str, float]:
    if "reference_speed_hz" in true and "reference_speed_hz" in found:
        found = _at_its_reference(true, found)
    ways = [parameter_errors(said, found) for said in (true, _mirrored(effect, true))]
    return min(ways, key=lambda errors: sum(e * e for e in errors.values()))


def judge(made: dict, diagnosis: dict) -> dict:
    """One set's row of the table."""
    true = [effect["effect"] for effect in made["effects"]]
    ranking = [entry["effect"] for entry in diagnosis["ranking"]]
    steps = [step["added"] for step in diagnosis["steps"]]
    row = {"hidden": true or ([made["law"]] if made["law"] else ["none"]), "difference": made["difference"],
           "expected": made["verdict"], "verdict": diagnosis["verdict"], "steps": steps, "ranking": ranking[:5],
           "seconds": diagnosis["seconds"], "errors": {}}
    last = diagnosis["steps"][-1] if diagnosis["steps"] else diagnosis["baseline"]
    for key in ("validation_error", "validation_error_free", "validation_error_contact"):
        row[key] = last[key]
    row["baseline_error"] = diagnosis["baseline"]["validation_error"]
    floors = [floor for run, floor in made["floor"].items() if not run.startswith(("rub", "drop"))]
    row["floor"] = sum(floors) / len(floors) if floors else None
    if made["verdict"] == "effect":
        best = diagnosis["ranking"][0] if ranking else {"confounded_with": []}
        row["first"] = bool(steps) and steps[0] in true
        row["near"] = any(effect in ranking[:3] or effect in best["confounded_with"] for effect in true)
        row["all"] = diagnosis["verdict"] == "effect" and sorted(steps) == sorted(true)
        for effect in made["effects"]:
            places = [(step["added"], step["parameters"]) for step in diagnosis["steps"]]
            found = next((parameters for added, parameters in places if added == effect["effect"]), None)
            if found:
                errors = _errors_of(effect["effect"], effect["parameters"], found)
                row["errors"].update({f"{effect['effect']}.{name}": error for name, error in errors.items()})
    if made["verdict"] == "unknown":
        row["depends_on"] = diagnosis["unexplained"]["depends_on"]
        row["named"] = set(made["depends_on"]) <= set(row["depends_on"])
    return row


def _share(rows: list, test) -> dict:
    return {"count": len(rows), "share": sum(map(test, rows)) / len(rows) if rows else None}


def summary(rows: list[dict]) -> dict:
    done = [row for row in rows if "verdict" in row]
    of = lambda expected: [row for row in done if row["expected"] == expected]
    single = [row for row in of("effect") if len(row["hidden"]) == 1]
    plain = [row for row in single if row["difference"] is None or row["difference"] > 2.0]
    pairs = [row for row in of("effect") if len(row["hidden"]) == 2]
    errors = [error for row in done for error in row["errors"].values()]
    hits = [row for row in of("effect") if row["all"]]
    contact = [row for row in hits if row["validation_error_contact"] is not None]
    seconds = sorted(row["seconds"] for row in done)
    return {
        "sets": len(done),
        "single: first": _share(plain, lambda row: row["first"]),
        "single: within three or confounded": _share(plain, lambda row: row["near"]),
        "single: that effect and no other": _share(plain, lambda row: row["all"]),
        "pairs: both": _share(pairs, lambda row: row["all"]),
        "clean: no false alarm": _share(of("none"), lambda row: row["verdict"] == "none"),
        "unlisted: unknown": _share(of("unknown"), lambda row: row["verdict"] == "unknown"),
        "unlisted: right quantities": _share(of("unknown"), lambda row: row["named"]),
        "parameters within 3 std": _share(errors, lambda error: abs(error) <= 3.0),
        "validation error without contact under 1.15": _share(hits, lambda row: row["validation_error_free"] < 1.15),
        "validation error with contact under 1.5": _share(contact, lambda row: row["validation_error_contact"] < 1.5),
        "median seconds": seconds[len(seconds) // 2] if seconds else None,
        "most seconds": seconds[-1] if seconds else None,
    }


def _number(value, digits: int = 2) -> str:
    return "-" if value is None else f"{value:.{digits}f}"


def table(rows: list[dict]) -> str:
    """The result as markdown."""
    lines = ["| what | share | of |", "|---|---|---|"]
    for name, entry in summary(rows).items():
        if isinstance(entry, dict):
            lines.append(f"| {name} | {_number(entry['share'])} | {entry['count']} |")
        else:
            lines.append(f"| {name} | {_number(entry, 0)} | |")
    lines += ["", "| set | hidden | difference | verdict | steps | before | after | floor | largest error (std) | s |",
              "|---|---|---|---|---|---|---|---|---|---|"]
    for row in rows:
        if "verdict" not in row:
            lines.append(f"| {row['set']} | {', '.join(row['hidden'])} | - | {row['failure']} | | | | | | |")
            continue
        worst = max(row["errors"].items(), key=lambda item: abs(item[1]), default=None)
        lines.append(
            f"| {row['set']} | {', '.join(row['hidden'])} | {_number(row['difference'], 1)} | {row['verdict']} | "
            f"{', '.join(row['steps'])} | {row['baseline_error']:.2f} | {row['validation_error']:.3f} | "
            f"{_number(row['floor'], 3)} | {f'{worst[0]} {worst[1]:+.1f}' if worst else ''} | {row['seconds']:.0f} |")
    return "\n".join(lines) + "\n"


def _read(path: pathlib.Path):
    return json.loads(path.read_text()) if path.exists() else None


def _write(path: pathlib.Path, value) -> None:
    with _writing:
        common.atomic_write(path, json.dumps(common._plain(value), indent=1) + "\n")


def truth_of(path: pathlib.Path) -> dict:
    """What a truth.yaml says, as `judge` takes it. What the file leaves out: an effect or none, no difference."""
    truth = yaml_file.read(path)
    if not isinstance(truth, dict) or truth.get("format") != TRUTH_FORMAT:
        raise InputError(f"{path}: format must be {TRUTH_FORMAT}")
    try:
        effects = [{"effect": entry["effect"],
                    "parameters": {name: float(value["value"]) for name, value in entry["parameters"].items()}}
                   for entry in truth["effects"]]
        return {"effects": effects, "law": truth.get("law") or "", "difference": truth.get("difference"),
                "verdict": truth.get("verdict") or ("effect" if effects else "none"),
                "depends_on": list(truth.get("depends_on") or []),
                "floor": {str(run): float(value) for run, value in (truth.get("floor") or {}).items()}}
    except (KeyError, TypeError, AttributeError, ValueError) as error:
        raise InputError(f"{path}: not as {TRUTH_FORMAT} has it: {type(error).__name__}: {error}") from None


def sets_in(folder: pathlib.Path) -> list[pathlib.Path]:
    sets = sorted(path.parent for path in folder.glob("*/truth.yaml") if (path.parent / "dataset.yaml").exists())
    if not sets:
        raise InputError(f"{folder}: no folder in it holds a dataset.yaml and a truth.yaml")
    return sets


def known_set(source: pathlib.Path, folder: pathlib.Path, threads: int, limit_s: float, core) -> dict:
    """Diagnoses a set that is there, unless that is done; its truth is read after the diagnosis."""
    diagnosis = _read(folder / "diagnosis.json")
    row = {"set": source.name, "hidden": ["?"]}
    try:
        if diagnosis is None:
            dataset = core.read_dataset(str(source))
            diagnosis, *_ = core.diagnose(dataset.belief, dataset, threads=threads, time_limit_s=limit_s)
            folder.mkdir(parents=True, exist_ok=True)
            _write(folder / "diagnosis.json", diagnosis)
        return {**row, **judge(truth_of(source / "truth.yaml"), diagnosis)}
    except InputError as error:
        return {**row, "failure": str(error)}


def one_set(index: int, seed: int, contact: bool, folder: pathlib.Path, threads: int, limit_s: float, core) -> dict:
    """Makes and diagnoses a set, as far as that is not done yet."""
    hidden = hidden_in(index, seed, core)
    row = {"set": index, "hidden": hidden}
    try:
        made = _read(folder / "made.json")
        if made is None:
            made = core.make_dataset(seed_of(seed, index), hidden, contact=contact, out=str(folder))
            _write(folder / "made.json", made)
        diagnosis = _read(folder / "diagnosis.json")
        if diagnosis is None:
            dataset = core.read_dataset(str(folder))
            diagnosis, *_ = core.diagnose(dataset.belief, dataset, threads=threads, time_limit_s=limit_s)
            _write(folder / "diagnosis.json", diagnosis)
    except InputError as error:
        return {**row, "failure": str(error)}
    return {**row, **judge(made, diagnosis)}


def _report(args, rows: list[dict]) -> None:
    out = common.out_folder(args, "bench", "diagnosis")
    text = table(rows)
    print(text)
    common.atomic_write(out / "bench_diagnosis.md", text)
    _write(out / "bench_diagnosis.json", {"summary": summary(rows), "rows": rows})
    common.write_json(args, {"summary": summary(rows), "rows": rows})
    common.report_line(out / "bench_diagnosis.md")


def _end_at_once(stop: BaseException, args, jobs: list, keep: pathlib.Path) -> None:
    """Ends the process although sets are at work, in calls that hear nothing: what is finished is reported and kept, what is half
    made goes."""
    for job in jobs:
        job.cancel()
    done = [job for job in jobs if job.done() and not job.cancelled() and job.exception() is None]
    try:
        if done:
            _report(args, [job.result() for job in done])
        print(f"amb bench-diagnosis: interrupted; {len(done)} of {len(jobs)} sets are done", file=sys.stderr)
    finally:
        half_made = [path for path in keep.glob("set-*") if not (path / "made.json").exists()] if not args.data else []
        for path in half_made if args.keep else [keep]:
            shutil.rmtree(path, ignore_errors=True)
        _writing.acquire(timeout=5.0)  # no part of a file is left
        sys.stdout.flush()
        os._exit(stop.code if isinstance(stop, SystemExit) else 128 + signal.SIGINT)


def run(args) -> int:
    import concurrent.futures
    import contextlib
    from amb_rotor import _core
    if args.sets < 1 or args.jobs < 1 or args.seed < 0:
        raise InputError("--sets and --jobs must be from 1, --seed from 0")
    if args.data and args.contact:
        raise InputError("--contact is of our own sets: those of --data are as they are")
    common.out_path(args, "bench", "diagnosis")
    if args.keep:
        common.require_folder(pathlib.Path(args.keep))
    threads = max(1, (os.cpu_count() or 1) // args.jobs)
    source = common.input_path(args.data).resolve() if args.data else None
    given = sets_in(source) if source else []
    with contextlib.ExitStack() as stack:
        keep = pathlib.Path(args.keep or stack.enter_context(tempfile.TemporaryDirectory()))
        keep.mkdir(parents=True, exist_ok=True)
        own = {"seed": args.seed, **({"contact": True} if args.contact else {})}
        note, what = keep / "bench.json", {"data": str(source)} if source else own
        known = _read(note)
        if known is not None and known != what:
            raise InputError(f"{keep}: holds {' '.join(f'--{key}' if value is True else f'--{key} {value}' for key, value in known.items())}")
        _write(note, what)
        if source:
            work = [(known_set, path, keep / path.name) for path in given]
        else:
            work = [(one_set, i, args.seed, args.contact, keep / f"set-{i:04d}") for i in range(args.sets)]
        pool = stack.enter_context(concurrent.futures.ThreadPoolExecutor(args.jobs))
        jobs = [pool.submit(*call, threads, args.time_limit, _core) for call in work]
        try:
            for job in common.progress(concurrent.futures.as_completed(jobs), "sets", total=len(jobs)):
                job.result()
        except (KeyboardInterrupt, SystemExit) as stop:
            _end_at_once(stop, args, jobs, keep)
        except BaseException:
            for job in jobs:
                job.cancel()
            raise
        rows = [job.result() for job in jobs]
    _report(args, rows)
    return 0
