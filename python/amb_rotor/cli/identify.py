"""`amb identify`: natural frequencies, damping, k1, d1 and the magnets' stiffnesses from measured runs."""
from __future__ import annotations

import math

from amb_rotor.cli import common
from amb_rotor.errors import InputError

HELP = "natural frequencies, damping, k1, d1, Ki, Ks from runs at standstill"
EXAMPLE = "amb identify frf config/tutorial/measured"
KINDS = {"frf": "chirp", "step": "step"}


def add_arguments(parser) -> None:
    parser.add_argument("method", choices=sorted(KINDS), help="frf: the chirps, with Ki and Ks; step: the steps")
    parser.add_argument("dataset", metavar="DATASET", help="folder of a data set (amb-dataset/1)")
    parser.add_argument("--from", dest="lowest", metavar="HZ", type=float, default=5.0, help="of the band (default: 5)")
    parser.add_argument("--to", dest="highest", metavar="HZ", type=float, default=400.0, help="of the band (default: 400)")


def mean(values: list[tuple[float, float]]) -> tuple[float, float]:
    """Mean and standard deviation of independent (value, deviation), by their weights."""
    weights = [1.0 / max(deviation, 1e-12 * abs(value) + 1e-300) ** 2 for value, deviation in values]
    return sum(w * value for w, (value, _) in zip(weights, values)) / sum(weights), 1.0 / math.sqrt(sum(weights))


def run(args) -> int:
    from amb_rotor import _core, identify
    if not 0.0 < args.lowest < args.highest:
        raise InputError("--from must be above 0 and below --to")
    dataset = _core.read_dataset(str(common.dataset_folder(args.dataset)))
    rig = identify.rig_of(dataset.belief.fields)
    found, skipped = [], []
    for entry in dataset.runs:
        if entry["kind"] != KINDS[args.method]:
            continue
        if entry["speed_hz"] != 0.0 or entry["holds_contact"]:
            skipped.append(entry["id"])
            continue
        table = dataset.table(entry["id"])
        for axis in "xy":
            one = identify.axis_of(table, rig, axis, args.method == "step", (args.lowest, args.highest))
            if one is not None:
                found.append((entry["id"], axis, *one))
    if skipped:
        print(f"left out, as the rotor turns or touches: {', '.join(skipped)}")
    if not found:
        raise InputError(f"{args.dataset}: no {KINDS[args.method]} at standstill with an excitation current")
    for name, axis, modes, _ in found:
        print(f"{name} {axis}: " + ("; ".join(_words(mode) for mode in modes) or "no mode in the band"))
    result = _together(found, rig, args.method == "frf")
    for mode in result["modes"]:
        print(f"{'ends together' if mode['together'] else 'ends against each other'}: {mode['frequency_hz']:.2f} +- "
              f"{mode['frequency_std_hz']:.2f} Hz, damping ratio {mode['damping_ratio']:.4f} +- {mode['damping_ratio_std']:.4f}")
    if "k1_N_per_m" in result:
        print(f"k1 {result['k1_N_per_m']:.4g} N/m, d1 {result['d1_N_s_per_m']:.4g} N s/m of a bearing")
    if "magnet" in result:
        fields = dataset.belief.fields
        for key, name, unit in (("current_stiffness_N_per_A", "Ki", "N/A"), ("displacement_stiffness_N_per_m", "Ks", "N/m")):
            value, deviation = result["magnet"][key], result["magnet"][key + "_std"]
            print(f"{name} {value:.5g} +- {deviation:.2g} {unit}, believed {fields['rig.amb.' + key]:.5g}")
    common.write_json(args, {"method": args.method, **result})
    return 0


def _words(mode) -> str:
    return (f"{mode.frequency_hz:.2f} +- {mode.frequency_std_hz:.2f} Hz, {mode.damping_ratio:.4f} +- "
            f"{mode.damping_ratio_std:.4f}, ends {'together' if mode.together else 'against each other'}")


def _together(found: list, rig: dict, with_magnet: bool) -> dict:
    """What all runs and axes say: for both rigid modes the mean by weight, k1 and d1 of the first."""
    result: dict = {"modes": []}
    for together in (True, False):
        # of each run and axis the mode that is known best: others are what noise leaves
        best = [min((mode for mode in modes if mode.together == together), key=lambda mode: mode.frequency_std_hz,
                    default=None) for _, _, modes, _ in found]
        best = [mode for mode in best if mode is not None]
        if not best:
            continue
        frequency = mean([(mode.frequency_hz, mode.frequency_std_hz) for mode in best])
        damping = mean([(mode.damping_ratio, mode.damping_ratio_std) for mode in best])
        result["modes"].append({"frequency_hz": frequency[0], "frequency_std_hz": frequency[1], "damping_ratio": damping[0],
                                "damping_ratio_std": damping[1], "together": together})
        if together:
            w = 2.0 * math.pi * frequency[0]
            result["k1_N_per_m"] = 0.5 * rig["mass_kg"] * w ** 2
            result["d1_N_s_per_m"] = rig["mass_kg"] * damping[0] * w
    if with_magnet:
        magnet = {}
        for key, std in (("current_stiffness_N_per_A", "current_stiffness_std"),
                         ("displacement_stiffness_N_per_m", "displacement_stiffness_std")):
            magnet[key], magnet[key + "_std"] = mean([(getattr(one, key), getattr(one, std)) for *_, one in found])
        result["magnet"] = magnet
    return result
