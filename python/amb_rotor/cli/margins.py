"""`amb margins`: sensitivity of the control loops, ISO 14839-3; equivalent stiffness and damping of the bearings."""
from __future__ import annotations

from amb_rotor import models
from amb_rotor.cli import common
from amb_rotor.errors import InputError

HELP = "ISO 14839-3 sensitivity of each control loop, stiffness and damping of each bearing"
EXAMPLE = "amb margins config/thesis/levitation_model.yaml --speed 100"


def add_arguments(parser) -> None:
    models.add_model(parser)
    parser.add_argument("--speed", metavar="HZ", type=float, default=0.0, help="spin of the rotor (default: 0)")
    common.add_out(parser, "margins")


# Of the table that is printed; the file and the picture have them all.
PRINTED_HZ = (1.0, 10.0, 20.0, 50.0, 100.0, 150.0, 200.0, 300.0, 500.0, 1000.0)


def equivalent(model, speed_hz: float, highest_hz: float, frequencies) -> dict:
    """Equivalent stiffness and damping of each axis (thesis 3.26 to 3.30), as a table and over the frequencies."""
    from amb_rotor import _core, modal
    printed = [frequency for frequency in PRINTED_HZ if frequency <= highest_hz]
    stiffness, damping = _core.equivalent_bearings(model, float(speed_hz), printed)
    print("equivalent stiffness k1 [N/m] and damping d1 [N s/m] of each bearing")
    print("  frequency   " + "  ".join(f"{'k1 ' + axis:>10} {'d1 ' + axis:>9}" for axis in modal.AXES))
    for column, frequency in enumerate(printed):
        print(f"  {frequency:7.1f} Hz  " + "  ".join(f"{stiffness[row, column]:10.4g} {damping[row, column]:9.4g}"
                                                     for row in range(4)))
    stiffness, damping = _core.equivalent_bearings(model, float(speed_hz), [float(f) for f in frequencies])
    return {"frequency_hz": frequencies, "stiffness_N_per_m": dict(zip(modal.AXES, stiffness)),
            "damping_N_s_per_m": dict(zip(modal.AXES, damping))}


def run(args) -> int:
    import numpy
    from amb_rotor import modal
    from amb_rotor.plots import maps
    model = models.load(args)
    if model.amb_model != "linear":
        raise InputError(f"{args.model}: the bearing is {model.amb_model}: it has no control loop; needs rig.amb.model linear")
    folder = common.out_path(args, "margins", models.stem(args.model))
    half_rate = 0.5 * model.fields["rig.controller.sample_rate_hz"]
    growth = modal.largest_growth(model, args.speed)
    frequencies = numpy.geomspace(1.0, min(2000.0, 0.98 * half_rate), 800)
    rows = modal.sensitivity(model, args.speed, frequencies)
    stable = growth <= 1e-6
    zone = lambda peak: modal.zone(peak) if stable else None  # noqa: E731  an unstable loop has none
    loops = []
    print(f"model {model.name} ({model.hash}) at {args.speed:g} Hz"
          + ("" if stable else f": NOT STABLE, grows with {growth:.3g} 1/s; the figures have no meaning"))
    for axis, row in zip(modal.AXES, rows):
        place = int(numpy.argmax(row))
        peak = float(row[place])
        loops.append({"axis": axis, "peak": peak, "peak_db": float(20 * numpy.log10(peak)),
                      "frequency_hz": float(frequencies[place]), "zone": zone(peak)})
        print(f"  {axis}: {peak:6.3f} ({20 * numpy.log10(peak):5.2f} dB) at {frequencies[place]:7.1f} Hz, "
              f"zone {zone(peak) or 'none'}")
    worst = max(loop["peak"] for loop in loops)
    bearings = equivalent(model, args.speed, float(frequencies[-1]), frequencies)
    common.write_json(args, {"model": model.name, "model_hash": model.hash, "speed_hz": args.speed,
                             "stable": bool(stable), "peak": worst, "zone": zone(worst), "loops": loops,
                             "equivalent": bearings})
    folder.mkdir(parents=True, exist_ok=True)
    maps.equivalent(folder / "equivalent.png", model.name, bearings)
    common.report_line(maps.sensitivity(folder / "sensitivity.png", model.name, frequencies, rows))
    return 0 if stable else 1
