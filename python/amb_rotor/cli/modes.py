"""`amb modes`: natural frequencies, damping, whirl direction and shapes of the closed loop."""
from __future__ import annotations

from amb_rotor import models
from amb_rotor.cli import common

HELP = "natural frequencies, damping, whirl direction and shapes"
EXAMPLE = "amb modes config/thesis/levitation_model.yaml --speed 0 --speed 100"


def add_arguments(parser) -> None:
    models.add_model(parser)
    parser.add_argument("--speed", metavar="HZ", type=float, action="append",
                        help="spin of the rotor; may be repeated (default: 0)")


def mode_dict(mode) -> dict:
    shape = {plane: {axis: [float(value.real), float(value.imag)] for axis, value in zip(("ax", "ay", "bx", "by"), place)}
             for plane, place in mode.shape.items()}
    return {"frequency_hz": mode.frequency_hz, "damped_frequency_hz": mode.damped_frequency_hz,
            "damping_ratio": mode.damping_ratio, "whirl": mode.whirl, "whirl_measure": mode.whirl_measure,
            "shape": shape}


def _motion(mode) -> str:
    """How the ends move to each other: the rigid modes' names."""
    import numpy
    a, b = mode.shape["amb"][0:2], mode.shape["amb"][2:4]
    axis = int(numpy.argmax(numpy.abs(a) + numpy.abs(b)) % 2)
    together = (a[axis] * numpy.conj(b[axis])).real
    return "ends together" if together > 0 else "ends against each other"


def run(args) -> int:
    from amb_rotor import modal
    model = models.load(args)
    rows = []
    print(f"model {model.name} ({model.hash})")
    for speed in args.speed or [0.0]:
        found = modal.modes(model, speed)
        growth = modal.largest_growth(model, speed)
        print(f"at {speed:g} Hz{'' if growth <= 1e-6 else f': NOT STABLE, grows with {growth:.3g} 1/s'}")
        print("  frequency   damping ratio  whirl     motion at the bearings")
        for mode in found:
            print(f"  {mode.frequency_hz:8.2f} Hz  {mode.damping_ratio:11.4f}  {mode.whirl:<8}  {_motion(mode)}")
        rows.append({"speed_hz": speed, "stable": bool(growth <= 1e-6), "modes": [mode_dict(mode) for mode in found]})
    if model.rotor_model == "flexible" and model.amb_model == "linear":
        print("(a bending mode above half the sample rate, "
              f"{0.5 * model.fields['rig.controller.sample_rate_hz']:g} Hz, stands at its own frequency; the controller's samples "
              "see it folded below)")
    common.write_json(args, {"model": model.name, "model_hash": model.hash, "speeds": rows})
    return 0
