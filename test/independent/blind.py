"""Blind data sets of the independent program: other rigs than ours, other code than ours, noise, a hidden effect.

    python3 test/independent/blind.py --sets 38 --seed 1 --out DIR
    python3 test/independent/blind.py --laws all --seed 1 --out DIR
    ./amb bench-diagnosis --data DIR

Writes DIR/set-0000 and so on, each of format amb-dataset/1 with its truth.yaml (amb-truth/1 and the keys `verdict`,
`law`, `depends_on`, `difference` of doc/blind_sets.md). A round of 38 sets hides every effect once, nothing three times,
four laws of no catalogue once and five pairs; then again on other rigs. A set that is there already is not made again.
With --laws a round hides each of the laws named (laws.py has the list) once and nothing else, on rigs of its own.

Drawn: mass 1.2 to 12 kg, lever arms that differ, Ki, bias, gap, gravity or none, integral action or none, controllers
at 8, 10 and 20 kHz, delays of 30 to 170 us, two in five rigs with a polar inertia, contact and friction. Off by their
stated uncertainty: mass, Ki, contact stiffness, unbalance, constant speeds (0.1 %), the sensors' offset and drift.
With --offsets loop the controller acts on the sensors' offset and drift, and the offset is one for all runs; else it lies in
the recording alone; sensor_dead_zone is made with loop only. With --integrators settled its integrators stand where they
come to rest when a recording begins; else at 0. Two fifths of the sensors' noise goes round the loop; `noise_rms` states
all of it, measured from the same runs.
Effects with contact are always recorded with rubs and drops, the others in half of the sets.

Left out: quantised currents finer than 1 mA, speeds that a rub slows down, friction off by its uncertainty.
"""
import argparse
import copy
import math
import pathlib
import sys
import typing

import numpy as np
import yaml

import cases
import driver
import laws
import sets

FREE = ("couple_unbalance", "shaft_bow", "sensor_runout", "sensor_gain_error", "sensor_axis_rotation", "static_load",
        "gyroscopic_coupling", "stiffness_anisotropy", "cross_coupled_stiffness", "internal_damping",
        "foundation_resonance", "magnetic_nonlinearity", "magnetic_saturation", "current_saturation", "amplifier_lag",
        "control_delay", "eddy_current_lag", "motor_magnetic_pull", "spin_drag", "shaft_crack", "shaft_flexibility")
LAWS = laws.IN_ROUND
CLEAN, PAIRS = 3, 5
ROUND = len(FREE) + len(cases.CONTACT) + CLEAN + len(LAWS) + PAIRS
IN_LOOP = 0.4           # of a sensor's noise
OFFSET_M = 1e-6         # of sensors, and their drift in a run
SPEED_BELIEF = 0.001    # of a constant speed
LOUDER = 1.5            # times the noise without a law apart it may be with it
SETTLING = 3.0          # run-in of integrators, whose loops take up to half a second [s]
RESOLUTION = (0.01, 0.001)  # um, A
CONTACT_KINDS = ("rub", "drop")
KEPT = {"max_current_A", "bias_current_A", "air_gap_m", "bandwidth_hz", "knee_flux_density_T", "delay_s", "z_m",
        "plane_z_m", "speed_exponent", "reference_speed_hz", "static_coefficient", "dynamic_coefficient"}


class Reading(typing.NamedTuple):
    """How sentences of the format are read that can be read in two ways: see --offsets, --integrators."""
    offsets: str = "recording"
    integrators: str = "zero"


class Unfit(Exception):
    """This rig does not carry this effect, or touches where it must not; another one is drawn."""


def hidden_in(index, seed, chosen=()):
    """(kind, names) of a set; chosen: the laws of a round of nothing else."""
    if chosen:
        return "unknown", [chosen[index % len(chosen)]]
    place = index % ROUND
    for kind, names in (("effect", FREE), ("effect", cases.CONTACT), ("none", [None] * CLEAN), ("unknown", list(LAWS))):
        if place < len(names):
            return kind, [names[place]] if names[place] else []
        place -= len(names)
    pair = np.random.default_rng([seed, index, 1]).choice(FREE + cases.CONTACT, 2, replace=False)
    return "pair", [str(name) for name in pair]


def draw_rig(dice):
    mass = float(np.exp(dice.uniform(math.log(1.2), math.log(12))))
    arm = (mass / 3) ** 0.25
    la, lb = dice.uniform(0.06, 0.14, 2) * arm
    tilt = mass * la * lb * dice.uniform(0.7, 1.3)
    ki, bias, gap = dice.uniform(45, 110) * math.sqrt(mass), dice.uniform(1.8, 3.2), dice.uniform(0.4e-3, 0.8e-3)
    block = sets.rig(
        mass=mass, tilt=tilt, polar=dice.choice([0.0, 0.0, 0.0, 0.02, 0.3]) * tilt, amb=(-la, lb),
        sensor=(-la * dice.uniform(0.75, 1.3), lb * dice.uniform(0.75, 1.3)),
        aux=(-la * dice.uniform(0.8, 1.5), lb * dice.uniform(0.8, 1.5)), ki=ki, ks=ki * bias / gap, bias=bias,
        limit=2 * bias, gap=gap, flux=dice.uniform(0.4, 0.7), amplifier=dice.uniform(1300, 3000),
        rate=dice.choice([8000.0, 10000.0, 10000.0, 20000.0]), delay=dice.uniform(3e-5, 1.7e-4),
        derivative=dice.uniform(1300, 2600), integral=dice.choice([0.0, 0.0, 1.0]) * 2e4 * ki / 137,
        natural=dice.uniform(60, 105), damping=dice.uniform(0.2, 0.32), gravity=dice.choice([0.0, 9.81]),
        clearance=dice.uniform(0.12e-3, 0.3e-3), radius=dice.uniform(0.008, 0.025),
        unbalance=((dice.uniform(-0.05, 0.05), 10 ** dice.uniform(-5.0, -4.3) * mass / 2.6, dice.uniform(-3, 3)),))
    aux = block["auxiliary_bearing"]
    aux["friction_coefficient"] = round(dice.uniform(0.05, 0.2), 3)
    stiffness = round(float(np.exp(dice.uniform(math.log(6e6), math.log(5e7)))), -3)
    damping = round(dice.uniform(0.05, 0.2) * math.sqrt(stiffness * mass), 1)
    aux["contact"].update(stiffness_N_per_m=stiffness, damping_N_s_per_m=damping)
    return plain(block)


def plain(value):
    """The same with Python's own numbers, as YAML writes them."""
    if isinstance(value, dict):
        return {key: plain(v) for key, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(v) for v in value]
    if isinstance(value, (float, int, np.number)) and not isinstance(value, bool):
        return float(value)
    return value


def drawn_sizes(dice, effects):
    """The cases with other sizes and phases."""
    effects, scale = copy.deepcopy(effects), dice.uniform(0.5, 1.3)
    for effect in effects:
        parameters = effect["parameters"]
        for name, value in parameters.items():
            if name in KEPT:
                continue
            if name.endswith("phase_rad"):
                parameters[name] = dice.uniform(-3, 3)
            elif name.startswith("factor_"):
                parameters[name] = 1 + (value - 1) * scale * dice.uniform(0.7, 1.3)
            elif name == "damping_s_per_m":  # with the cases' own most drops end in dry whirl of many clearances
                parameters[name] = value * dice.uniform(3, 10)
            elif name.startswith("shape_"):
                parameters[name] = value * dice.uniform(0.7, 1.3)
            else:
                parameters[name] = value * scale * dice.uniform(0.8, 1.2)
    return plain(effects)


def drawn_truth(dice, belief):
    """Nuisance values off by their stated uncertainty."""
    amb, aux, first = belief["amb"], belief["auxiliary_bearing"], belief["unbalance"][0]
    stated = belief["uncertainty"]
    off = lambda value, key: value * (1 + stated[key] * float(np.clip(dice.normal(), -2.5, 2.5)))  # noqa: E731
    return plain({
        "rotor.mass_kg": off(belief["rotor"]["mass_kg"], "rotor.mass_kg"),
        "amb.current_stiffness_N_per_A": off(amb["current_stiffness_N_per_A"], "amb.current_stiffness_N_per_A"),
        "auxiliary_bearing.contact.stiffness_N_per_m":
            off(aux["contact"]["stiffness_N_per_m"], "auxiliary_bearing.contact.stiffness_N_per_m"),
        "unbalance.moment_kg_m": off(first["moment_kg_m"], "unbalance.moment_kg_m"),
        "unbalance.phase_rad": first["phase_rad"] + stated["unbalance.phase_rad"] * dice.normal()})


class Recorder:
    """Runs of one true rig with their noise."""

    def __init__(self, dice, simulator, truth, law, reading):
        self.dice, self.simulator, self.truth, self.law = dice, simulator, truth, law
        self.offsets_in_loop, self.integrators_settled = reading.offsets == "loop", reading.integrators == "settled"
        sigma = 10 ** dice.uniform(-0.7, 0) * 1e-6
        self.sensor_noise = sigma * dice.uniform(0.7, 1.4, 4)
        self.amplifier_noise = dice.uniform(0.002, 0.008, 4)
        self.offset = OFFSET_M * dice.normal(size=4)
        self.clearance = truth["auxiliary_bearing"]["clearance_m"]
        self.most_swayed = None  # if set, how far noise in the loop may move the channels of a run without contact, rms

    def quiet(self, effects, run, angle, disturbance=None, law=None, offsets=None):
        extra = dict(law or {}, integral_settled=float(self.integrators_settled))
        if self.integrators_settled and self.truth["controller"]["ki_A_per_m_s"] > 0:
            run = {**run, "settle": run.get("settle", 1.0) + SETTLING}
        return sets.record(self.simulator, self.truth, effects, run, angle, disturbance, extra=extra, offsets=offsets)

    def check_reach(self, run, channels):
        if any(name.startswith("law_sensor") for name in self.law):
            knots = sets.spin(run, [], 0.0)
            spin = np.interp(np.arange(len(channels)) / run["record_hz"], knots[:, 0], knots[:, 1])
            channels = laws.displacements(channels[:, :4], self.law, spin)
        radius = max(np.hypot(channels[:, e], channels[:, e + 1]).max() for e in (0, 2)) / self.clearance
        if run["kind"] not in CONTACT_KINDS and radius > 0.6:
            raise Unfit(f"{run['id']} reaches {radius:.2f} of the clearance")
        if run["kind"] == "rub" and radius < 0.8 or radius > 1.8:
            raise Unfit(f"{run['id']} reaches {radius:.2f} of the clearance")

    def all(self, effects, runs):
        """([(channels, tacho)], noise of sensors [m], of currents [A], difference over noise)."""
        dice, recordings, loop, changes = self.dice, [], [], []
        for run in runs:
            angle, records = dice.uniform(-3, 3), run["records"]
            disturbance = IN_LOOP * self.sensor_noise * dice.normal(size=(records, 4))
            drift = OFFSET_M * dice.normal(size=4)
            acted_on = np.array([self.offset, drift]) if self.offsets_in_loop else None
            channels, tacho = self.quiet(effects, run, angle, disturbance, self.law, acted_on)
            self.check_reach(run, channels)
            free = run["kind"] not in CONTACT_KINDS
            if run["kind"] == "steady" or free and self.most_swayed is not None:
                still, _ = self.quiet(effects, run, angle, None, self.law, acted_on)
                if self.most_swayed is not None and (np.sqrt(np.mean((channels - still) ** 2, axis=0)) > self.most_swayed).any():
                    raise Unfit(f"the loop's noise decides where the rotor rests in {run['id']}")
            if run["kind"] == "steady":
                loop.append((channels - still).std(axis=0))
            if free and (effects or self.law):
                without, _ = self.quiet([], run, angle, disturbance, None, acted_on)
                changes.append(channels - without)
            shown = channels.copy()
            shown[:, :4] += self.offset + np.outer(np.linspace(0, 1, records), drift) + disturbance
            shown[:, :4] += math.sqrt(1 - IN_LOOP ** 2) * self.sensor_noise * dice.normal(size=(records, 4))
            shown[:, 4:] += self.amplifier_noise * dice.normal(size=(records, 4))
            recordings.append((shown, tacho))
        loop = np.mean(loop, axis=0)
        if loop[4:].max() > 0.25 * self.truth["amb"]["bias_current_A"]:
            raise Unfit("the loop's noise fills the amplifiers")
        noise = np.hypot(np.concatenate([self.sensor_noise, self.amplifier_noise]), loop)
        difference = math.sqrt(np.mean([np.mean((c / noise) ** 2) for c in changes])) if changes else 0.0
        return recordings, noise[:4], noise[4:], difference


def sized_law(recorder, parameters, runs, aim, least):
    """The parameters with the coefficient that changes the runs without contact by `aim` times the noise, and that noise.

    More damping leaves less motion to damp: where it hardly tells any more, what it has come to does from `least` on.
    """
    free = [run for run in runs if run["kind"] not in CONTACT_KINDS]
    without = [recorder.quiet([], run, 0.3)[0] for run in free]
    noise = np.concatenate([recorder.sensor_noise, recorder.amplifier_noise])
    turning = next(n for n, run in enumerate(free) if run["kind"] == "steady")
    # a generator of its own: what is drawn after this does not depend on it
    inner = IN_LOOP * recorder.sensor_noise * np.random.default_rng(1).normal(size=(free[turning]["records"], 4))
    noise = np.hypot(noise, (recorder.quiet([], free[turning], 0.3, inner)[0] - without[turning]).std(axis=0))
    change, factor = None, 1.0
    for _ in range(10):
        motions = [recorder.quiet([], run, 0.3, None, parameters)[0] for run in free]
        before, change = change, math.sqrt(np.mean([np.mean(((m - w) / noise) ** 2) for m, w in zip(motions, without)]))
        growth = math.log(change / before) / math.log(factor) if before else 1.0
        if abs(change / aim - 1) < 0.1 or growth < 0.5 and least < change < aim:
            return parameters, noise
        if growth < 0.2 and change < aim:
            break
        factor = float(np.clip(aim / change, 0.2, 4.0))
        parameters = laws.scaled(parameters, factor)
    raise Unfit(f"the law comes to {change:.1f} times the noise, not to {aim:.1f}")


def limited_current(recorder, effects, runs):
    """Sets the limit a little below what the runs without it take."""
    for effect in effects:
        if effect["effect"] == "current_saturation":
            largest = max(np.abs(recorder.quiet([], run, 0.3)[0][:, 4:]).max()
                          for run in runs if run["kind"] not in CONTACT_KINDS)
            effect["parameters"]["max_current_A"] = recorder.truth["amb"]["bias_current_A"] + 0.85 * float(largest)


def try_set(dice, simulator, kind, names, folder, reading):
    belief = draw_rig(dice)
    catalogue = cases.effects_of(belief)
    law = names[0] if kind == "unknown" else None
    effects = [] if law else drawn_sizes(dice, [e for name in names for e in catalogue[name]])
    if "spin_drag" in names and belief["rotor"]["polar_inertia_kg_m2"] <= 0:
        raise Unfit("its torque needs a polar inertia")
    if {"magnetic_nonlinearity", "magnetic_saturation"} <= set(names):
        raise Unfit("one magnet law or the other")
    if law == "current_stiffening" and belief["gravity_m_s2"] > 0:
        raise Unfit("where the current bears a weight, it hardly changes, and the law is a spring")
    if law == "sensor_dead_zone" and reading.offsets != "loop":
        raise Unfit("within the play the bearings push outwards: from its very middle noise decides to which side")
    nuisance = drawn_truth(dice, belief)
    truth = driver.with_nuisance(belief, nuisance)
    with_contact = any(name in cases.CONTACT for name in names) or dice.random() < 0.5
    runs = sets.plan(belief, duration=0.8, contact=with_contact)
    apart = law in laws.APART
    law_parameters, *aim = laws.drawn_apart(dice, law, belief) if apart else (laws.drawn(dice, law, belief),)
    recorder = Recorder(dice, simulator, truth, law_parameters, reading)
    for run in runs:  # most rigs that do not do show it here
        if run["kind"] == "drop":
            recorder.check_reach(run, recorder.quiet(effects, run, 0.3, None, law_parameters)[0])
    if apart:
        law_parameters, noise = sized_law(recorder, law_parameters, runs, *aim)
        recorder.law = law_parameters
        for name, (low, high) in laws.WITHIN.items():
            if name in law_parameters and not low <= law_parameters[name] <= high:
                raise Unfit(f"{name} would have to be {law_parameters[name]:.2g}")
        if law in laws.OF_SENSORS:
            recorder.most_swayed = LOUDER * noise
    limited_current(recorder, effects, runs)
    sets.raise_bursts(simulator, truth, effects, runs)
    recordings, noise_m, noise_A, difference = recorder.all(effects, runs)
    if apart and (np.concatenate([noise_m, noise_A]) > LOUDER * noise).any():
        raise Unfit("the law has two motions to settle in: what the loop's noise decides would be stated as noise")
    if apart and not laws.DIFFERENCE[0] <= difference <= laws.DIFFERENCE[1]:
        raise Unfit(f"the law comes to {difference:.1f} times the noise")
    for run in runs:
        if run.get("hz"):
            run["hz"] = round(run["hz"] * (1 + SPEED_BELIEF * dice.normal()), 3)
    more = {"verdict": {"none": "none", "unknown": "unknown"}.get(kind, "effect"),
            "difference": None if any(name in cases.CONTACT for name in names) else difference,
            "law": law or "", "depends_on": laws.ALL.get(law, []), "law_parameters": plain(law_parameters)}
    sets.write(folder, folder.name, belief, effects, nuisance, recordings, runs, noise_um=noise_m * 1e6,
               noise_A=noise_A, resolution=RESOLUTION, more=plain(more))
    return difference


def make_set(seed, index, simulator, folder, reading=Reading(), attempts=60, chosen=()):
    kind, names = hidden_in(index, seed, chosen)
    for attempt in range(attempts):
        dice = np.random.default_rng([seed, index, 2 + attempt] + [1] * bool(chosen))
        try:
            difference = try_set(dice, simulator, kind, names, folder, reading)
        except (Unfit, ArithmeticError) as reason:
            print(f"{folder.name}: another rig: {reason}", file=sys.stderr)
            continue
        print(f"{folder.name}: difference {difference:.1f} times the noise without contact, {attempt + 1} rigs")
        return
    print(f"{folder.name}: not made, no rig of {attempts} carries {names}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sets", type=int, metavar="N", help=f"how many (default: a round, of {ROUND} without --laws)")
    parser.add_argument("--seed", type=int, default=1, metavar="S")
    parser.add_argument("--out", required=True, metavar="DIR")
    parser.add_argument("--only", type=int, action="append", metavar="INDEX", help="only this set; may be repeated")
    parser.add_argument("--offsets", choices=("recording", "loop"), default="recording",
                        help="whether the controller acts on what the sensors are off by (default: recording)")
    parser.add_argument("--integrators", choices=("zero", "settled"), default="zero",
                        help="where the controller's integrators stand when a recording begins (default: zero)")
    parser.add_argument("--laws", nargs="+", choices=["all", *laws.ALL], metavar="NAME", default=[],
                        help=f"a round of these laws only: all, or some of {', '.join(laws.ALL)}")
    args = parser.parse_args()
    chosen = list(laws.ALL) if "all" in args.laws else args.laws
    out = pathlib.Path(args.out)
    out.mkdir(parents=True, exist_ok=True)
    simulator = driver.Simulator(out)
    for index in args.only or range(args.sets or len(chosen) or ROUND):
        folder = out / f"set-{index:04d}"
        if not (folder / "truth.yaml").exists():
            make_set(args.seed, index, simulator, folder, Reading(args.offsets, args.integrators), chosen=chosen)


if __name__ == "__main__":
    main()
