"""`amb launch`: the node graph for a scenario."""
from __future__ import annotations

import argparse
import os
import pathlib
import re
import subprocess
import sys

HELP = "run the node graph for a scenario (roslaunch)"
EXAMPLE = "amb launch overload --rate 0 --record overload.bag"

# What the plant says at its end (src/ros/rotor_plant.cpp).
_FINISHED = re.compile(r"rotor_plant: ([\d.e+-]+) s simulated in (\d+) steps and ([\d.e+-]+) s")
_ENDED = re.compile(r"rotor_plant: ended at ([\d.e+-]+) s: (.*)")
# Seconds that roslaunch has to end its nodes.
_PATIENCE = 30.0


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("scenario", metavar="SCENARIO",
                        help="drop, overload, levitation, or the path of an amb-scenario/1 file")
    parser.add_argument("--model", metavar="MODEL",
                        help="amb-model/1 file (default: that beside the scenario which its name begins with, as of amb "
                        "simulate; without one the thesis's rig, config/thesis/levitation_model.yaml)")
    parser.add_argument("--nodelets", action="store_true", help="all in one process, without copies of messages")
    parser.add_argument("--record", metavar="BAG", help="write all topics into a bag at simulated time")
    parser.add_argument("--rate", type=float, default=1.0, metavar="R",
                        help="of real time (default: 1); 0: as fast as it goes")
    parser.add_argument("--rviz", action="store_true", help="open rviz beside it")
    parser.add_argument("--contact-step", type=float, default=1e-5, metavar="S",
                        help="step in seconds where a contact law is not linear (default: 1e-5)")


def scenario_path(text: str, folder: pathlib.Path) -> pathlib.Path:
    """A file of the caller's, or one of ours by its name."""
    from amb_rotor.errors import InputError

    path = pathlib.Path(text)
    if path.is_file():
        return path.resolve()
    ours = folder / f"{text}.yaml"
    if re.fullmatch(r"[\w-]+", text) and ours.is_file():
        return ours
    known = sorted(file.stem for file in folder.glob("*.yaml") if "amb-scenario/1" in file.read_text())
    raise InputError(f"{text}: there is no such file, and no scenario of that name (there are: {', '.join(known)})")


def model_path(scenario: pathlib.Path, folder: pathlib.Path) -> pathlib.Path:
    """The model that belongs to a scenario by its name, or the thesis's rig."""
    from amb_rotor import models
    from amb_rotor.errors import InputError

    try:
        return models.beside(scenario)
    except InputError:
        return folder / "levitation_model.yaml"


def plant_is_running() -> bool:
    """Whether a plant runs at our master already: a second one would take its names away."""
    import rosgraph

    try:
        nodes = rosgraph.Master("/amb_launch").getSystemState()
    except Exception:
        return False  # no master there: roslaunch starts one
    return any("/rotor_plant" in users for group in nodes for _, users in group)


def roslaunch_command(args: argparse.Namespace) -> list[str]:
    from amb_rotor.cli import common
    from amb_rotor.errors import InputError
    from amb_rotor.paths import share_folder

    thesis = share_folder() / "config" / "thesis"
    scenario = scenario_path(args.scenario, thesis)
    model = common.input_path(args.model).resolve() if args.model else model_path(scenario, thesis)
    if args.rate < 0.0 or not args.contact_step > 0.0:
        raise InputError("--rate must be from 0, --contact-step above 0")
    record = ""
    if args.record:
        record = pathlib.Path(args.record).absolute()
        common.require_file(pathlib.Path(args.record))
        if not record.parent.is_dir():
            raise InputError(f"{record.parent}: there is no such folder")
    return [sys.executable, "-P", "/usr/bin/roslaunch", "--sigint-timeout=8", "--sigterm-timeout=2",
            str(share_folder() / "launch" / "graph.launch"), f"model:={model}",
            f"scenario:={scenario}", f"rate:={args.rate!r}",
            f"nodelets:={str(args.nodelets).lower()}", f"rviz:={str(args.rviz).lower()}", f"record:={record}",
            f"contact_step:={args.contact_step!r}"]


def follow(process: subprocess.Popen) -> dict:
    """Passes on what the nodes say, and picks out how the run ended."""
    result = {"state": "unknown"}
    for line in process.stdout:
        text = re.sub(r"\x1b\[[\d;]*m", "", line).rstrip()
        if match := _FINISHED.search(text):
            result = {"state": "finished", "time_s": float(match[1]), "steps": int(match[2]),
                      "wall_s": float(match[3])}
        elif match := _ENDED.search(text):
            result = {"state": "failed", "time_s": float(match[1]), "reason": match[2]}
        if re.match(r"\[ ?(INFO|WARN|ERROR|FATAL)\]|RLException|.*process has (died|finished)", text):
            print(text, file=sys.stderr, flush=True)
    return result


def run(args: argparse.Namespace) -> int:
    from amb_rotor.cli import common
    from amb_rotor.errors import InputError

    command = roslaunch_command(args)
    if plant_is_running():
        raise InputError(f"a plant is running already at {os.environ.get('ROS_MASTER_URI')}: "
                         "end it, or set ROS_MASTER_URI to another port")
    environment = {**os.environ, "ROSCONSOLE_FORMAT": "[${severity}] ${message}", "PYTHONUNBUFFERED": "1"}
    with common.child(command, patience=_PATIENCE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                      text=True, errors="replace", env=environment) as process:
        result = follow(process)
    if args.record:
        result["bag"] = str(pathlib.Path(args.record))
    common.write_json(args, result)
    if result["state"] != "finished":
        print(f"amb launch: the run did not reach its end: {result.get('reason', 'a node ended before')}",
              file=sys.stderr)
        return 1
    print(f"{result['time_s']:g} s simulated in {result['steps']} steps and {result['wall_s']:.3g} s "
          f"({1e6 * result['wall_s'] / max(1, result['steps']):.0f} us a step)")
    if args.record:
        common.report_line(args.record)
    return 0
