"""Rigs, runs and data sets of format amb-dataset/1 made with the independent simulator."""
import gzip
import math
import pathlib

import numpy as np
import yaml

import driver
from driver import AXES


def rig(mass=2.6, tilt=0.025, polar=0.0, amb=(-0.11, 0.067), sensor=(-0.09, 0.044), aux=(-0.124, 0.094), ki=137.0,
        ks=6.0e5, bias=2.5, limit=5.0, gap=0.6e-3, flux=0.55, amplifier=2300.0, rate=10000.0, delay=1.2e-4,
        derivative=1800.0, integral=0.0, natural=80.0, damping=0.28, gravity=0.0, clearance=0.2e-3, radius=0.014,
        unbalance=((0.02, 3e-5, 0.4),)):
    """A rig block. The gains give about `natural` [Hz] and `damping` in translation behind delay, hold and lags."""
    k = mass / 2 * (2 * math.pi * natural) ** 2
    kp = (ks + k) / ki
    late = delay + 0.5 / rate + 1 / (2 * math.pi * amplifier)
    kd = damping * mass * 2 * math.pi * natural / ki + kp * late
    pair = lambda ab: {"a": ab[0], "b": ab[1]}  # noqa: E731
    return {
        "rotor": {"mass_kg": mass, "transverse_inertia_kg_m2": tilt, "polar_inertia_kg_m2": polar},
        "planes": {"amb": pair(amb), "sensor": pair(sensor), "aux": pair(aux)},
        "amb": {"model": "linear", "current_stiffness_N_per_A": ki, "displacement_stiffness_N_per_m": ks,
                "bias_current_A": bias, "air_gap_m": gap, "bias_flux_density_T": flux,
                "amplifier_bandwidth_hz": amplifier, "max_current_A": limit},
        "controller": {"type": "pid", "sample_rate_hz": rate, "kp_A_per_m": round(kp, 1), "kd_A_s_per_m": round(kd, 4),
                       "ki_A_per_m_s": integral, "derivative_filter_hz": derivative, "delay_s": delay},
        "auxiliary_bearing": {"clearance_m": clearance, "rotor_radius_m": radius, "friction_coefficient": 0.12,
                              "contact": {"model": "linear", "stiffness_N_per_m": 1.7e7, "damping_N_s_per_m": 1200.0},
                              "mount": "rigid"},
        "unbalance": [dict(zip(("plane_z_m", "moment_kg_m", "phase_rad"), u)) for u in unbalance],
        "gravity_m_s2": gravity,
        "uncertainty": {"rotor.mass_kg": 0.005, "amb.current_stiffness_N_per_A": 0.03,
                        "auxiliary_bearing.contact.stiffness_N_per_m": 0.1, "unbalance.moment_kg_m": 0.1,
                        "unbalance.phase_rad": 0.05, "sensor.offset_m": 1e-6},
    }


RIGS = {
    # as the tutorial sets are
    "plain": rig(),
    # controller slower than the recorder, delay over one period and no multiple of it
    "slow": rig(mass=6.1, tilt=0.061, polar=0.004, amb=(-0.071, 0.125), sensor=(-0.102, 0.099), aux=(-0.13, 0.16),
                ki=210.0, ks=9.0e5, bias=3.1, limit=5.0, gap=0.5e-3, flux=0.62, amplifier=1700.0, rate=8000.0, delay=1.63e-4,
                derivative=1300.0, natural=62.0, damping=0.3, gravity=9.81,
                unbalance=((-0.05, 4e-5, -1.1), (0.06, 5e-5, 2.0))),
    # controller faster than the recorder, delay shorter than a period, integral action
    "fast": rig(mass=1.4, tilt=0.0075, polar=0.0, amb=(-0.06, 0.075), sensor=(-0.085, 0.052), aux=(-0.05, 0.101), ki=61.0,
                ks=2.9e5, bias=2.0, limit=4.4, gap=0.7e-3, flux=0.5, amplifier=2900.0, rate=20000.0, delay=3.3e-5,
                derivative=2400.0, integral=2.0e4, natural=105.0, damping=0.25, gravity=9.81,
                unbalance=((-0.01, 1.3e-5, 2.5),)),
}


def chirp(t, amplitude, low, high, columns):
    """Excitation [A]: a sine that sweeps from low to high [Hz] within 5 to 95 % of the time, weights by axis."""
    start, end = 0.05 * t[-1], 0.95 * t[-1]
    u = np.clip(t - start, 0, end - start)
    wave = np.sin(2 * math.pi * (low * u + (high - low) / (end - start) * u * u / 2))
    return np.outer(amplitude * wave * ((t > start) & (t < end)), columns)


def step(t, amplitude, columns):
    return np.outer(amplitude * ((t > 0.02) & (t < 0.5 * t[-1])), columns)


def burst(t, amplitude, hz):
    """A current that turns with `hz` and swells and fades within 10 to 60 % of the time."""
    u = np.clip((t / t[-1] - 0.1) / 0.5, 0, 1)
    envelope = amplitude * np.sin(math.pi * u) ** 2
    x, y = envelope * np.cos(2 * math.pi * hz * t), envelope * np.sin(2 * math.pi * hz * t)
    return np.column_stack([x, y, x, y])


def plan(block, record_hz=10000.0, duration=0.5, contact=False, top=1.0):
    """Runs of a set, each a dictionary: id, kind, use, speed [Hz] or ramp (from, to), excitation, events."""
    control, amb = block["controller"], block["amb"]
    k = amb["current_stiffness_N_per_A"] * control["kp_A_per_m"] - amb["displacement_stiffness_N_per_m"]
    critical = math.sqrt(2 * k / block["rotor"]["mass_kg"]) / (2 * math.pi)
    size = 12e-6 * k / amb["current_stiffness_N_per_A"]
    t = np.arange(int(round(duration * record_hz)) + 1) / record_hz
    runs = []

    def add(kind, use, **more):
        number = 1 + sum(r["kind"] == kind for r in runs)
        runs.append({"id": f"{kind}_{number}", "kind": kind, "use": use, "record_hz": record_hz, "records": len(t),
                     "events": [], "excitation": None, **more})

    add("chirp", "fit", hz=0.0, excitation=chirp(t, size, 10, 300, (1, 0, 0, 0.3)))
    add("chirp", "fit", hz=0.0, excitation=chirp(t, size, 10, 300, (0, -0.4, 0, 1)))
    add("chirp", "fit", hz=round(1.23 * critical * top, 3), excitation=chirp(t, size, 10, 300, (0.5, 0, -0.8, 0)))
    add("step", "fit", hz=0.0, excitation=step(t, size, (0.7, 0, -0.4, 1)))
    for factor, use in ((0.53, "fit"), (0.91, "fit"), (1.9, "fit"), (0.77, "validate")):
        add("steady", use, hz=round(factor * critical * top, 3))
    add("run_up", "fit", ramp=(0.4 * critical * top, 1.8 * critical * top))
    add("coast_down", "validate", ramp=(1.9 * critical * top, 0.5 * critical * top))
    add("chirp", "validate", hz=0.0, excitation=chirp(t, size, 10, 300, (0.6, 1, 0.2, 0)))
    add("step", "validate", hz=0.0, excitation=step(t, size, (0, 1, 0.7, 0)))
    if contact:
        for factor, use in ((0.42, "fit"), (0.61, "validate")):
            add("rub", use, hz=round(factor * critical * top, 3), excitation=burst(t, 0.0, critical), burst_hz=critical)
        for factor, use in ((1.2, "fit"), (0.8, "validate")):
            add("drop", use, hz=round(factor * critical * top, 3), events=[(0.05, 0)])
    return runs


def spin(run, effects, polar):
    """Knots of the true speed [s, rad/s]."""
    duration = run["records"] / run["record_hz"]
    if "ramp" in run:
        a, b = (2 * math.pi * hz for hz in run["ramp"])
        t = np.arange(0, duration + 2e-3, 1e-3)
        u = np.minimum(t / duration, 1.0)
        return np.column_stack([t, a + (b - a) * u])
    w = 2 * math.pi * run["hz"]
    for entry in effects:
        if entry["effect"] == "spin_drag":
            q = entry["parameters"]
            return driver.drag_knots(w, q["decay_per_s"], q["torque_N_m"], polar, duration)
    return np.array([[0.0, w]])


def record(simulator, block, effects, run, angle, disturbance=None, free_step=1e-5, contact_step=1e-6, extra=None,
           offsets=None):
    """(channels, tacho) of one run: channels as Simulator.run gives them. extra: further parameters of the program."""
    parameters, unbalances = driver.machine(block, effects)
    parameters.update(extra or {})
    knots = spin(run, effects, parameters["polar_inertia"])
    fine = contact_step if run["kind"] in ("rub", "drop") else free_step
    # a loop of 20/s is e^-20 of its start; a foundation, a weakly damped loop say more
    settle = run.get("settle", 1.0)
    channels = simulator.run(parameters, unbalances, knots, angle, run["record_hz"], run["excitation"], run["records"],
                             run["events"], settle=settle, step=fine, disturbance=disturbance, offsets=offsets)
    return channels, driver.tacho(knots, angle, run["record_hz"], run["records"])


def raise_bursts(simulator, block, effects, runs, reach=1.15):
    """Scales the bursts of the rubs until the rotor would move `reach` times the clearance without the bearing."""
    parameters, _ = driver.machine(block, effects)
    clearance = block["auxiliary_bearing"]["clearance_m"]
    for run in runs:
        if run["kind"] != "rub":
            continue
        t = np.arange(run["records"]) / run["record_hz"]
        for amplitude in np.geomspace(0.03, 4.0, 16):
            run["excitation"] = burst(t, amplitude, run["burst_hz"])
            free = {**block, "auxiliary_bearing": {**block["auxiliary_bearing"], "clearance_m": 1.0}}
            try:
                channels, _ = record(simulator, free, effects, {**run, "kind": "steady", "settle": 0.4}, 0.3)
            except ArithmeticError:
                break
            if max(np.hypot(channels[:, e], channels[:, e + 1]).max() for e in (0, 2)) > reach * clearance:
                break


def write(folder, name, block, truth, nuisance, recordings, runs, noise_um=0.4, noise_A=None, resolution=None,
          floor=None, more=None):
    """Writes the set; `block` is the belief. recordings: [(channels, tacho)] in the order of runs. resolution
    (um, A) rounds; without it every digit is kept. more: further keys of truth.yaml."""
    folder = pathlib.Path(folder)
    (folder / "runs").mkdir(parents=True, exist_ok=True)
    channels = {"tacho": {"meaning": "one pulse a turn", "threshold": 0.5}}
    um, ampere = resolution or (1e-9, 1e-12)
    noise_A = [0.005] * 4 if noise_A is None else noise_A
    noise_um = [noise_um] * 4 if np.isscalar(noise_um) else noise_um
    for c, n in zip(AXES, noise_um):
        channels[f"{c}_um"] = {"meaning": "displacement", "plane": c[0], "axis": c[1],
                               "noise_rms_um": round(float(n), 5), "resolution_um": um}
    for c, n in zip(AXES, noise_A):
        channels[f"i{c}_A"] = {"meaning": "control current", "plane": c[0], "axis": c[1],
                               "noise_rms_A": round(float(n), 6), "resolution_A": ampere}
    for c in AXES:
        channels[f"exc_{c}_A"] = {"meaning": "excitation current", "plane": c[0], "axis": c[1]}
    listed = []
    for run, (rows, pulse) in zip(runs, recordings):
        table = [np.arange(run["records"]) / run["record_hz"], pulse]
        digits = ["%.10g", "%.6f"]
        for k in range(4):
            table.append(np.round(rows[:, k] * 1e6 / um) * um if resolution else rows[:, k] * 1e6)
        for k in range(4, 8):
            table.append(np.round(rows[:, k] / ampere) * ampere if resolution else rows[:, k])
        table += list(np.zeros((4, run["records"])) if run["excitation"] is None else run["excitation"].T)
        digits += ["%.8g" if resolution else "%.12g"] * 8 + ["%.12g"] * 4
        file = f"runs/{run['id']}.csv.gz"
        with gzip.open(folder / file, "wt", compresslevel=1) as f:
            np.savetxt(f, np.column_stack(table), fmt=digits, delimiter=",", comments="",
                       header=",".join(["t_s", *channels]))
        listed.append({"id": run["id"], "file": file, "kind": run["kind"], "sample_rate_hz": run["record_hz"],
                       "speed": {"type": "tacho"} if "ramp" in run else {"type": "constant", "hz": run["hz"]},
                       "events": [{"time_s": t, "type": "amb_on" if on else "amb_off"} for t, on in run["events"]],
                       "use": run["use"]})
    description = {"format": "amb-dataset/1", "name": name, "rig": block, "channels": channels, "runs": listed}
    (folder / "dataset.yaml").write_text(yaml.safe_dump(description, sort_keys=False))
    listed_truth = [{"effect": e["effect"],
                     "parameters": {n: {"value": v, "unit": "1"} for n, v in e["parameters"].items()}} for e in truth]
    (folder / "truth.yaml").write_text(yaml.safe_dump(
        {"format": "amb-truth/1", "effects": listed_truth, "nuisance": nuisance, "floor": floor or {}, **(more or {})},
        sort_keys=False))


def write_model(path, block, effects):
    """The model file with which the project predicts: the rig, rigid, with these effects."""
    pathlib.Path(path).write_text(yaml.safe_dump(
        {"format": "amb-model/1", "name": "independent", "rig": block, "rotor": {"model": "rigid_beam"},
         "effects": [{"effect": e["effect"], "parameters": dict(e["parameters"])} for e in effects]}, sort_keys=False))
