"""`amb campbell`: natural frequencies and damping over the speed."""
from __future__ import annotations

from amb_rotor import models
from amb_rotor.cli import common
from amb_rotor.errors import InputError

HELP = "natural frequencies and damping over the speed"
EXAMPLE = "amb campbell config/thesis/levitation_model.yaml --to 300"
LOWEST = 6  # modes that are printed


def add_arguments(parser) -> None:
    models.add_model(parser)
    parser.add_argument("--to", metavar="HZ", type=float, default=300.0, help="highest speed (default: 300)")
    parser.add_argument("--points", type=int, default=61, help="speeds from 0 on (default: 61)")
    common.add_out(parser, "campbell")


def run(args) -> int:
    import numpy
    from amb_rotor import modal
    from amb_rotor.cli.modes import mode_dict
    from amb_rotor.plots import maps
    if args.to <= 0 or args.points < 2:
        raise InputError("--to must be above 0 and --points at least 2")
    model = models.load(args)
    speeds = numpy.linspace(0.0, args.to, args.points)
    folder = common.out_path(args, "campbell", models.stem(args.model))
    rows = [modal.modes(model, speed) for speed in common.progress(speeds, "speeds")]
    folder.mkdir(parents=True, exist_ok=True)
    picture = maps.campbell(folder / "campbell.png", model.name, speeds, rows)
    common.write_json(args, {"model": model.name, "model_hash": model.hash, "speeds": [
        {"speed_hz": float(speed), "modes": [mode_dict(mode) for mode in row]} for speed, row in zip(speeds, rows)]})
    print(f"model {model.name} ({model.hash}): {len(speeds)} speeds from 0 to {args.to:g} Hz")
    for speed, row in ((speeds[0], rows[0]), (speeds[-1], rows[-1])):
        lowest = sorted(row, key=lambda mode: mode.damped_frequency_hz)[:LOWEST]
        print(f"at {speed:g} Hz: " + ", ".join(f"{mode.damped_frequency_hz:.1f} {mode.whirl}" for mode in lowest) + " [Hz]")
    common.report_line(picture)
    return 0
