"""`amb demo`: the whole path once. Node graph, faults, bag, pictures; then model against measurement until the error
falls, in one report."""
from __future__ import annotations

import argparse
import os
import pathlib
import time

from amb_rotor.cli import common

HELP = "the whole path once, headless, in a minute: rub, record, compare, diagnose, adopt, compare again"
EXAMPLE = "amb demo --out out/demo"
# What the demonstration tries, to keep to its time; `amb diagnose` tries the whole catalogue.
CANDIDATES = ["sensor_runout", "auxiliary_bearing_misalignment", "cross_coupled_stiffness", "internal_damping",
              "stiffness_anisotropy", "shaft_bow"]
# Parts of config/tutorial/demo.yaml, for the pictures.
PHASES = [("levitated", 0.0, 0.1), ("overload", 0.12, 0.4), ("power failure", 0.4, 0.6)]


def add_arguments(parser) -> None:
    parser.add_argument("--out", metavar="DIR", help="folder for what is written (default: out/demo)")
    parser.add_argument("--rviz", action="store_true", help="open rviz beside the node graph, in real time")
    parser.add_argument("--full", action="store_true", help="diagnose with the whole catalogue; takes minutes")


def say(text: str) -> None:
    print(text, flush=True)


def why_no_graph() -> str:
    """Why the node graph cannot be launched here; empty where it can."""
    try:
        import rosbag  # noqa: F401
        import rosgraph  # noqa: F401
        import roslaunch  # noqa: F401
        from amb_rotor import msg  # noqa: F401
    except ImportError as error:
        return f"{error} (built without ROS)"
    from amb_rotor.cli import available_commands
    return "" if "launch" in available_commands() else "there is no amb launch"


def record_graph(args, scenario: pathlib.Path, model: pathlib.Path, bag: pathlib.Path) -> dict:
    """Runs the node graph into a bag and reads it back."""
    from amb_rotor.cli import convert, launch
    from amb_rotor.ports import free_port
    os.environ["ROS_MASTER_URI"] = f"http://localhost:{free_port()}"
    os.environ.setdefault("ROS_HOSTNAME", "localhost")
    namespace = argparse.Namespace(scenario=str(scenario), model=str(model), nodelets=False, record=str(bag),
                                   rate=1.0 if args.rviz else 0.0, rviz=args.rviz, contact_step=1e-5, json=None)
    if launch.run(namespace) != 0:
        raise RuntimeError("the node graph did not reach the end of its scenario")
    return convert.read_table(bag)


def simulate(scenario: pathlib.Path, model: pathlib.Path) -> dict:
    """The same run in process."""
    from amb_rotor import _core
    return _core.simulate(_core.read_model(str(model)), _core.read_scenario(str(scenario)))["columns"]


def motion(args, out: pathlib.Path, share: pathlib.Path) -> tuple[list, list[str]]:
    """Pictures with captions, and sentences on the motion."""
    from amb_rotor import _core
    from amb_rotor.plots import motion as draw
    scenario, model = share / "config/tutorial/demo.yaml", share / "config/thesis/levitation_model.yaml"
    reason = why_no_graph()
    began = time.perf_counter()
    if reason:
        say(f"node graph: skipped: {reason}; the same run in process")
        table = simulate(scenario, model)
    else:
        table = record_graph(args, scenario, model, out / "demo.bag")
        say(f"node graph: {out / 'demo.bag'}")
    clearance = _core.read_model(str(model)).fields["rig.auxiliary_bearing.clearance_m"]
    sentences = []
    for title, begin, finish in PHASES:
        part = (table["t_s"] >= begin) & (table["t_s"] < finish)
        ends = []
        for end in "ab":
            x, y, touching = draw.end_motion(table, end, clearance)
            ends.append(f"end {end} up to {float(((x[part] ** 2 + y[part] ** 2) ** 0.5).max()):.2f} of the clearance, in "
                        f"contact {100 * float(touching[part].mean()):.0f} % of the time")
        sentences.append(f"{title}: " + "; ".join(ends))
        say("  " + sentences[-1])
    pictures = [(draw.orbit(out / "orbit.png", table, clearance, PHASES), "Orbit in the clearance of both auxiliary bearings"),
                (draw.poincare(out / "poincare.png", table, clearance, PHASES), "Poincare section at the tacho pulse"),
                (draw.spectrum(out / "spectrum.png", table, PHASES), "Full spectrum, forward and backward")]
    say(f"pictures: {', '.join(path.name for path, _ in pictures)} ({time.perf_counter() - began:.1f} s)")
    return pictures, sentences


def improve(args, out: pathlib.Path, share: pathlib.Path) -> tuple[list, dict]:
    """Compare, diagnose, adopt, compare: the stages for the report, and the diagnosis."""
    from amb_rotor import _core
    from amb_rotor.cli import adopt, compare, diagnose
    folder = share / "config/tutorial/measured"
    dataset = _core.read_dataset(str(folder))
    model = dataset.belief
    say("\namb compare - config/tutorial/measured")
    with compare.Bar("comparing") as bar:
        before = _core.compare(model, dataset, progress=bar)
    compare.print_errors(before)

    candidates = [] if args.full else CANDIDATES
    say("\namb diagnose config/tutorial/measured"
        + ("" if args.full else "".join(f" --effect {name}" for name in candidates)))
    asked = argparse.Namespace(candidates=candidates, threads=0, steps=1, time_limit=0.0, overrides=[])
    _, _, diagnosis, adopted, rivals, stages = diagnose.diagnose(folder, None, asked)
    diagnose.print_diagnosis(diagnosis)
    diagnose.save(out / "diagnosis", folder, dataset, model, diagnosis, adopted, stages, rivals)
    if not diagnosis["steps"] or adopted.faults:
        return [("as believed", before)], diagnosis
    with compare.Bar("comparing") as bar:
        after = _core.compare(adopted, dataset, progress=bar)
    stages = [("as believed", before), (diagnose.after_label(diagnosis), after)]

    say(f"\namb adopt {out / 'diagnosis'} --out {out / 'model.yaml'}")
    (out / adopt.LEDGER).unlink(missing_ok=True)
    adopt.run(argparse.Namespace(diagnosis=str(out / "diagnosis"), effect=[], out=str(out / "model.yaml"), json=None))
    say(f"\namb compare {out / 'model.yaml'} config/tutorial/measured")
    compare.print_errors(after)
    return stages, diagnosis


def run(args) -> int:
    from amb_rotor.cli import diagnose
    from amb_rotor.paths import share_folder
    from amb_rotor.report import data, write_report
    began = time.perf_counter()
    out = pathlib.Path(args.out) if args.out else pathlib.Path("out") / "demo"
    common.require_folder(out)
    out.mkdir(parents=True, exist_ok=True)
    diagnose.may_replace(out / "diagnosis")
    share = share_folder()
    pictures, sentences = motion(args, out, share)
    stages, diagnosis = improve(args, out, share)
    report = write_report(out / "report.html", "Demonstration",
                          "the thesis's rig overloaded and without power; then a model that lacks something, against "
                          "measurements", [data.stage(*stage) for stage in stages], diagnosis,
                          diagnose.revisions_of(diagnosis), pictures=pictures)
    first, last = (stage[1]["validation_errors"]["error"] for stage in (stages[0], stages[-1]))
    common.write_json(args, {"motion": sentences, "verdict": diagnosis["verdict"],
                             "steps": [step["added"] for step in diagnosis["steps"]],
                             "error_before": first, "error_after": last, "seconds": time.perf_counter() - began})
    say(f"\nerror on held-out runs over noise: {first:.2f} -> {last:.2f}; {time.perf_counter() - began:.0f} s in all")
    common.report_line(report)
    return 0
