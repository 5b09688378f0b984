"""`amb margins`: sensitivity of the control loops, ISO 14839-3."""
from __future__ import annotations

from amb_rotor import models
from amb_rotor.cli import common
from amb_rotor.errors import InputError

HELP = "ISO 14839-3 sensitivity of each control loop"
EXAMPLE = "amb margins config/thesis/levitation_model.yaml --speed 100"


def add_arguments(parser) -> None:
    models.add_model(parser)
    parser.add_argument("--speed", metavar="HZ", type=float, default=0.0, help="spin of the rotor (default: 0)")
    common.add_out(parser, "margins")


def run(args) -> int:
    import numpy
    from amb_rotor import modal
    from amb_rotor.plots import maps
    model = models.load(args)
    if model.amb_model != "linear":
        raise InputError(f"{args.model}: the bearing is {model.amb_model}: it has no control loop; needs rig.amb.model linear")
    half_rate = 0.5 * model.fields["rig.controller.sample_rate_hz"]
    growth = modal.largest_growth(model, args.speed)
    frequencies = numpy.geomspace(1.0, min(2000.0, 0.98 * half_rate), 800)
    rows = modal.sensitivity(model, args.speed, frequencies)
    loops = []
    print(f"model {model.name} ({model.hash}) at {args.speed:g} Hz"
          + ("" if growth <= 1e-6 else f": NOT STABLE, grows with {growth:.3g} 1/s; the figures have no meaning"))
    for axis, row in zip(modal.AXES, rows):
        place = int(numpy.argmax(row))
        peak = float(row[place])
        loops.append({"axis": axis, "peak": peak, "peak_db": float(20 * numpy.log10(peak)),
                      "frequency_hz": float(frequencies[place]), "zone": modal.zone(peak)})
        print(f"  {axis}: {peak:6.3f} ({20 * numpy.log10(peak):5.2f} dB) at {frequencies[place]:7.1f} Hz, "
              f"zone {modal.zone(peak)}")
    worst = max(loop["peak"] for loop in loops)
    common.write_json(args, {"model": model.name, "model_hash": model.hash, "speed_hz": args.speed,
                             "stable": bool(growth <= 1e-6), "peak": worst, "zone": modal.zone(worst), "loops": loops})
    folder = common.out_folder(args, "margins", models.stem(args.model))
    common.report_line(maps.sensitivity(folder / "sensitivity.png", model.name, frequencies, rows))
    return 0 if growth <= 1e-6 else 1
