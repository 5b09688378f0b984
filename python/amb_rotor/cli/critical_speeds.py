"""`amb critical-speeds`: speeds at which a mode turns with the shaft."""
from __future__ import annotations

from amb_rotor import models
from amb_rotor.cli import common
from amb_rotor.errors import InputError

HELP = "speeds at which a mode turns with the shaft"
EXAMPLE = "amb critical-speeds config/thesis/levitation_model.yaml --to 400"


def add_arguments(parser) -> None:
    models.add_model(parser)
    parser.add_argument("--to", metavar="HZ", type=float, default=500.0, help="highest speed (default: 500)")


def run(args) -> int:
    from amb_rotor import modal
    if args.to <= 0:
        raise InputError("--to: must be above 0")
    model = models.load(args)
    found = modal.critical_speeds(model, args.to)
    print(f"model {model.name} ({model.hash}): up to {args.to:g} Hz")
    for one in found:
        print(f"  {one['speed_hz']:8.2f} Hz  {one['whirl']:<8}  damping ratio {one['damping_ratio']:.4f}")
    if not found:
        print("  none")
    common.write_json(args, {"model": model.name, "model_hash": model.hash, "critical_speeds": found})
    return 0
