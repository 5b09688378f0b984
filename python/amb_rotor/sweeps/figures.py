"""Figures of single motions of the basic model (format amb-figure/1, doc/formats_sweep.md).

kind            what is computed                                                      thesis
motion          Poincare section, orbit, time history                                 5.6 to 5.12
contact_force   normal force over the time                                            5.13 to 5.15
waterfall       spectra over the driving frequency                                    5.16, 5.17
response        synchronous amplitude on run-up and run-down, each speed begun from
                the end of the last; Fourier coefficients of 5.15 to 5.18             5.3
impact          normal force over penetration of one impact, in SI                    3.16
magnet_force    force of one magnet over current and gap, in SI (sweeps/magnet.py)    3.9

Amplitude of harmonic k over n whole turns: |2/(n T) integral x exp(-j k eta t) dt|, here the mean of the samples.
Everything is dimensionless but an impact, which the file's `scale` takes to SI.
"""
from __future__ import annotations

import math
import pathlib

import numpy
import yaml

from amb_rotor.errors import InputError
from amb_rotor.sweeps.document import Document

FORMAT = "amb-figure/1"
KEYS = {"format", "name", "title", "source", "kind", "contact", "friction_law", "parameters", "initial", "run"}
# Kind -> further keys.
KINDS = {"motion": set(), "contact_force": {"time"}, "waterfall": {"frequency_ratio"}, "response": {"frequency_ratio"},
         "impact": {"scale"}}
SCALE = ("clearance_m", "natural_frequency_rad_s", "stiffness_N_per_m")
STEPS_PER_TURN = 400  # of the lanes that decide the regime; finer than any contact here needs


def read_figure(path: pathlib.Path) -> dict:
    """@raise InputError: all faults of the file"""
    document = Document(path, FORMAT)
    kind = document.get("kind")
    if kind == "magnet_force":
        from amb_rotor.sweeps import magnet
        return magnet.read(path)
    if kind not in KINDS:
        document.fault("kind", f"is none of {', '.join(KINDS)}, magnet_force")
        document.done()
    document.keys("", KEYS | KINDS[kind])
    known = document.laws()
    document.known("parameters", known)
    figure = dict(document.data, parameters=document.numbers("parameters"), run=document.run("samples_per_turn"),
                  initial=document.numbers("initial", ("x", "y", "vx", "vy")))
    if "scale" in KINDS[kind]:
        figure["scale"] = document.numbers("scale", SCALE)
    if "frequency_ratio" in KINDS[kind]:
        figure["frequency_ratio"] = document.axis("frequency_ratio")
    elif "frequency_ratio" not in figure["parameters"]:
        document.fault("parameters/frequency_ratio", "the key is missing")
    if "time" in KINDS[kind]:
        figure["time"] = document.axis("time")
        if len(figure["time"]) != 2 or not 0.0 <= figure["time"][0] < figure["time"][1]:
            document.fault("time", "must be [from, to], from at least 0 and below to")
    document.done()
    return figure


def _record(figure: dict, parameters: dict, initial, kept: int | None = None, skipped: int | None = None) -> dict:
    from amb_rotor import _core
    run = figure["run"]
    kept = run["kept_turns"] if kept is None else kept
    skipped = run["turns"] - run["kept_turns"] if skipped is None else skipped
    found = _core.record_basic(parameters, initial,
                               contact=figure["contact"], friction=figure["friction_law"], turns_skipped=skipped,
                               turns_kept=kept, samples_per_turn=run["samples_per_turn"])
    if not found["finite"]:
        raise InputError(f"{figure['name']}: the motion cannot be integrated (it leaves all bounds)")
    return found


def initial_state(figure: dict) -> tuple:
    return tuple(figure["initial"][key] for key in ("x", "y", "vx", "vy"))


def regime(figure: dict, turns: int | None = None) -> dict:
    """Regime, period, Lyapunov exponent and contact fraction as the lanes decide them."""
    from amb_rotor import _core
    run = figure["run"]
    kept = run["kept_turns"]
    found = _core.run_basic_lanes({key: numpy.array([value]) for key, value in figure["parameters"].items()},
                                  numpy.array([initial_state(figure)]), contact=figure["contact"],
                                  friction=figure["friction_law"], steps_per_turn=STEPS_PER_TURN,
                                  turns_skipped=(turns or run["turns"]) - kept, turns_kept=kept)
    return {"regime": found["regime"][0], "period": int(found["period"][0]),
            "largest_lyapunov": float(found["largest_lyapunov"][0]),
            "contact_fraction": float(found["contact_fraction"][0]), "max_radius": float(found["max_radius"][0])}


def motion(figure: dict) -> dict:
    """Record of the kept turns, its time axis and its points once a turn."""
    found = _record(figure, figure["parameters"], initial_state(figure))
    per_turn = figure["run"]["samples_per_turn"]
    eta = figure["parameters"]["frequency_ratio"]
    skipped = figure["run"]["turns"] - figure["run"]["kept_turns"]
    found["time"] = (found["phase"] + 2.0 * math.pi * skipped) / eta
    found["section"] = numpy.stack([found["x"][::per_turn], found["y"][::per_turn]], axis=1)
    return found


def contact_force(figure: dict) -> dict:
    """Normal force over the dimensionless time from `time[0]` to `time[1]`."""
    begin, end = figure["time"]
    eta = figure["parameters"]["frequency_ratio"]
    skipped = math.floor(begin * eta / (2.0 * math.pi))
    kept = math.ceil(end * eta / (2.0 * math.pi)) - skipped
    found = _record(figure, figure["parameters"], initial_state(figure), kept, skipped)
    found["time"] = (found["phase"] + 2.0 * math.pi * skipped) / eta
    inside = (found["time"] >= begin) & (found["time"] <= end)
    for key in ("time", "normal_force", "x", "y"):
        found[key] = found[key][inside]
    return found


def order_amplitude(signal, per_turn: int, order: float) -> float:
    """Amplitude of a harmonic of the shaft over whole turns (over whole periods for half orders)."""
    angle = 2.0 * math.pi * order * numpy.arange(len(signal)) / per_turn
    return float(abs(2.0 * numpy.mean(signal * numpy.exp(-1j * angle))))


def waterfall(figure: dict, progress=None) -> dict:
    """Amplitude spectra of x (Hann window) at each driving frequency; frequencies over the natural one."""
    frequencies = figure["frequency_ratio"]
    per_turn, kept = figure["run"]["samples_per_turn"], figure["run"]["kept_turns"]
    count = per_turn * kept
    window = numpy.hanning(count + 1)[:-1]
    rows, orders = [], {0.5: [], 1.0: [], 1.5: [], 2.0: []}
    for eta in frequencies:
        x = _record(figure, {**figure["parameters"], "frequency_ratio": eta}, initial_state(figure))["x"]
        rows.append(2.0 * numpy.abs(numpy.fft.rfft((x - x.mean()) * window)) / window.sum())
        for order, column in orders.items():
            column.append(order_amplitude(x - x.mean(), per_turn, order))
        if progress:
            progress(1)
    return {"driving": frequencies, "order": numpy.fft.rfftfreq(count, 1.0 / per_turn), "amplitude": numpy.array(rows),
            "orders": {order: numpy.array(column) for order, column in orders.items()}}


def response(figure: dict, progress=None) -> dict:
    """Synchronous amplitude of x and largest radius, run up and run down; the closed forms beside it."""
    from amb_rotor import _core
    frequencies = figure["frequency_ratio"]
    per_turn = figure["run"]["samples_per_turn"]
    found = {"driving": frequencies}
    for name, order in (("up", range(len(frequencies))), ("down", range(len(frequencies) - 1, -1, -1))):
        state = initial_state(figure)
        amplitude, fraction = numpy.zeros(len(frequencies)), numpy.zeros(len(frequencies))
        for index in order:
            record = _record(figure, {**figure["parameters"], "frequency_ratio": frequencies[index]}, state)
            state = record["end"]
            amplitude[index] = order_amplitude(record["x"], per_turn, 1.0)
            fraction[index] = record["contact_fraction"]
            if progress:
                progress(1)
        found[name], found[f"{name}_contact"] = amplitude, fraction
    p = figure["parameters"]
    found["free"] = frequencies ** 2 * p["eccentricity"] / numpy.abs(
        p["support_stiffness"] - frequencies ** 2 + 1j * p["damping"] * frequencies)
    centred = not p.get("misalignment") and figure["contact"] == "linear"
    found["rub"] = [[(radius, _core.annular_rub_stable({**p, "frequency_ratio": eta}, radius))
                     for radius in _core.annular_rub_radii({**p, "frequency_ratio": eta})] if centred else []
                    for eta in frequencies]
    return found


def jumps(driving, amplitude, least: float = 0.1) -> list[tuple[float, float, float]]:
    """(driving frequency behind the jump, amplitude before, behind), in the order of the frequencies given: the amplitude
    changes by more than `least`, and by three times what it does one step before and one step behind."""
    change = numpy.abs(numpy.diff(amplitude))
    around = numpy.concatenate([[0.0], change, [0.0]])
    steps = numpy.flatnonzero((change > least) & (change > 3.0 * around[:-2]) & (change > 3.0 * around[2:]))
    return [(float(driving[index + 1]), float(amplitude[index]), float(amplitude[index + 1])) for index in steps]


def impact(figure: dict) -> dict:
    """Penetration, its rate and force of the first impact in SI, with what follows from them."""
    scale = figure["scale"]
    clearance, speed = scale["clearance_m"], scale["clearance_m"] * scale["natural_frequency_rad_s"]
    found = _record(figure, figure["parameters"], initial_state(figure))
    centre = found["misalignment"]
    depth = numpy.hypot(found["x"] - centre[0], found["y"] - centre[1]) - 1.0
    inside = numpy.flatnonzero(depth > 0.0)
    if not len(inside):
        raise InputError(f"{figure['name']}: nothing touches")
    first = inside[0]
    last = first + numpy.argmax(depth[first:] <= 0.0) if (depth[first:] <= 0.0).any() else len(depth)
    part = slice(first, last)
    eta = figure["parameters"]["frequency_ratio"]
    time = (found["phase"][part] - found["phase"][first]) / eta / scale["natural_frequency_rad_s"]
    si = {"time_s": time, "depth_m": depth[part] * clearance, "rate_m_s": found["depth_rate"][part] * speed,
          "force_N": found["normal_force"][part] * clearance * scale["stiffness_N_per_m"]}
    si["speed_before_m_s"], si["speed_behind_m_s"] = float(si["rate_m_s"][0]), float(-si["rate_m_s"][-1])
    si["restitution"] = si["speed_behind_m_s"] / si["speed_before_m_s"]
    si["lost_J"] = float(numpy.sum(0.5 * (si["force_N"][1:] + si["force_N"][:-1]) * numpy.diff(si["depth_m"])))
    if figure["contact"] == "hertz":
        kappa = figure["parameters"]["hertz_stiffness"] * scale["stiffness_N_per_m"] / math.sqrt(clearance)
        si["stiffness_N_per_m"] = 1.5 * kappa * numpy.sqrt(si["depth_m"])
    return si


# ---- the subcommand's part
def run_figure(args, path: pathlib.Path) -> int:
    """`amb sweep FILE` for a file of this format."""
    from amb_rotor.cli import common
    from amb_rotor.sweeps import draw_figures, magnet
    if yaml.safe_load(path.read_text()).get("kind") == "magnet_force":
        return magnet.run_figure(args, path)
    figure = read_figure(path)
    folder = common.out_folder(args, "sweep", figure["name"])
    shown = {"motion": _motion, "contact_force": _contact_force, "waterfall": _waterfall, "response": _response,
             "impact": _impact}[figure["kind"]](figure, folder, draw_figures, common)
    numbers, columns, pictures = shown
    common.write_json(args, {"name": figure["name"], "kind": figure["kind"], **numbers})
    names = list(columns)
    lines = [",".join(names)] + [",".join(f"{value:.9g}" for value in row) for row in zip(*columns.values())]
    common.atomic_write(folder / "data.csv", "\n".join(lines) + "\n")
    common.report_line(pictures[0])
    return 0


def _motion(figure, folder, draw, common):
    found, kind = motion(figure), regime(figure)
    period = f"period {kind['period']}, " if kind["period"] else ""
    print(f"{kind['regime']}, {period}largest Lyapunov exponent {kind['largest_lyapunov']:+.4f}, in contact "
          f"{100 * found['contact_fraction']:.1f} % of the time, largest radius {kind['max_radius']:.4f}")
    per_turn = figure["run"]["samples_per_turn"]
    pictures = draw.motion(figure["title"], found, folder, min(24, figure["run"]["kept_turns"]), per_turn)
    return kind, {key: found[key] for key in ("time", "x", "y", "normal_force")}, pictures


def _contact_force(figure, folder, draw, common):
    found = contact_force(figure)
    force, touching = found["normal_force"], found["normal_force"] > 0.0
    numbers = {"largest": float(force.max()), "mean": float(force.mean()), "contact_fraction": float(touching.mean()),
               "touch_downs": int(numpy.sum(touching[1:] & ~touching[:-1]))}
    print(f"time {found['time'][0]:.1f} to {found['time'][-1]:.1f}: largest force {numbers['largest']:.4f}, mean "
          f"{numbers['mean']:.4f}, in contact {100 * numbers['contact_fraction']:.1f} %, {numbers['touch_downs']} touch-downs")
    return numbers, {key: found[key] for key in ("time", "normal_force")}, draw.contact_force(figure["title"], found, folder)


def _waterfall(figure, folder, draw, common):
    with common.progress_bar(len(figure["frequency_ratio"]), "speeds") as bar:
        found = waterfall(figure, bar.update)
    numbers = {}
    for order, column in found["orders"].items():
        top = int(column.argmax())
        numbers[f"order_{order:g}"] = {"largest": float(column[top]), "at": float(found["driving"][top])}
        over = found["driving"][column > 0.01]
        span = f"above 0.01 at {len(over)} speeds from {over[0]:.2f} to {over[-1]:.2f}" if len(over) else "never above 0.01"
        print(f"order {order:g}: largest amplitude {column[top]:.4f} at {found['driving'][top]:.2f}, {span}")
    columns = {"frequency_ratio": found["driving"], **{f"order_{k:g}": v for k, v in found["orders"].items()}}
    return numbers, columns, draw.waterfall(figure["title"], found, folder)


def _response(figure, folder, draw, common):
    with common.progress_bar(2 * len(figure["frequency_ratio"]), "speeds") as bar:
        found = response(figure, bar.update)
    numbers = {}
    for name, sense in (("up", 1), ("down", -1)):
        steps = jumps(found["driving"][::sense], found[name][::sense])
        numbers[f"jumps_{name}"] = steps
        touching = found["driving"][found[f"{name}_contact"] > 0.0]
        span = f"in contact from {touching[0]:.2f} to {touching[-1]:.2f}" if len(touching) else "never in contact"
        print(f"run-{name}: {span}; jumps " +
              (", ".join(f"at {eta:.2f} from {a:.3f} to {b:.3f}" for eta, a, b in steps) or "none"))
    apart = numpy.abs(found["up"] - found["down"])
    differ = found["driving"][apart > 0.02]
    numbers["largest_difference"] = float(apart.max())
    print(f"run-up and run-down differ by up to {apart.max():.3f}" +
          (f", at {len(differ)} speeds from {differ[0]:.2f} to {differ[-1]:.2f}" if len(differ) else ""))
    columns = {"frequency_ratio": found["driving"], "run_up": found["up"], "run_down": found["down"], "free": found["free"]}
    return numbers, columns, draw.response(figure["title"], found, folder)


def _impact(figure, folder, draw, common):
    found = impact(figure)
    numbers = {key: found[key] for key in ("speed_before_m_s", "speed_behind_m_s", "restitution", "lost_J")}
    numbers["largest_depth_m"], numbers["largest_force_N"] = float(found["depth_m"].max()), float(found["force_N"].max())
    print(f"speed {1e3 * found['speed_before_m_s']:.3f} mm/s before, {1e3 * found['speed_behind_m_s']:.3f} behind: "
          f"restitution {found['restitution']:.4f}; {1e6 * numbers['largest_depth_m']:.2f} um, {numbers['largest_force_N']:.2f} N, "
          f"lost {1e6 * found['lost_J']:.3f} uJ")
    columns = {key: found[key] for key in ("time_s", "depth_m", "rate_m_s", "force_N")}
    if "stiffness_N_per_m" in found:
        stiffness = found["stiffness_N_per_m"][1:-1]
        print(f"stiffness of the elastic part {stiffness.min():.3g} to {stiffness.max():.3g} N/m")
        columns["stiffness_N_per_m"] = found["stiffness_N_per_m"]
    return numbers, columns, draw.impact(figure["title"], found, folder)
