"""`amb reduce`: Hankel singular values of a flexible rotor, a reduction of it, and what the reduction costs."""
from __future__ import annotations

from amb_rotor import models
from amb_rotor.cli import common
from amb_rotor.errors import InputError

HELP = "reduce a flexible rotor: Hankel singular values, transfer functions before and after"
EXAMPLE = "amb reduce config/thesis/flexible_model.yaml --order 8"
LEAST_ERROR = 0.01


def add_arguments(parser) -> None:
    models.add_model(parser)
    parser.add_argument("--method", choices=("balanced", "balanced_rotor", "modal"), default="balanced",
                        help="balanced truncation of the rotor on its bearings, the same of the free rotor by a projection that "
                             "leaves it a rotor (rotor.reduction: balanced), or the lowest free-free modes (default: balanced)")
    parser.add_argument("--order", metavar="N", type=int,
                        help="states that are kept (default: the fewest whose error bound is below --error)")
    parser.add_argument("--error", metavar="E", type=float, default=LEAST_ERROR,
                        help=f"share of the largest gain that a reduction may be off (default: {LEAST_ERROR:g})")
    parser.add_argument("--speed", metavar="HZ", type=float, default=0.0, help="spin of the rotor (default: 0)")
    parser.add_argument("--to", metavar="HZ", type=float, default=10000.0, help="highest frequency (default: 10000)")
    common.add_out(parser, "reduce")


def fewest_states(hankel, largest_gain: float, error: float, states_a_step: int) -> int:
    """The fewest states, a multiple of `states_a_step`, whose bound 2 (sum of what is cut) is below the error."""
    import numpy
    bounds = 2.0 * (hankel.sum() - numpy.cumsum(hankel))  # bounds[r - 1]: r states are kept
    kept = numpy.flatnonzero(bounds <= error * largest_gain)
    order = int(kept[0]) + 1 if len(kept) else len(hankel)
    return min(-(-order // states_a_step) * states_a_step, len(hankel))


def run(args) -> int:
    import numpy
    from amb_rotor import _core
    from amb_rotor.plots import reduction
    if not args.to > 1.0:
        raise InputError("--to: must be above 1 Hz")
    if not args.error > 0.0:
        raise InputError("--error: must be above 0")
    if args.order is not None and args.order < 1:
        raise InputError("--order: must be from 1")
    model = models.load(args)
    folder = common.out_path(args, "reduce", models.stem(args.model))
    frequencies = numpy.geomspace(1.0, args.to, 800)
    order, states_a_mode = args.order, 4 if args.speed else 2
    if order is None:
        first = _core.reduce_rotor(model, args.method, 0, args.speed, list(frequencies))
        gain = float(first["before_m_per_N"].max())
        step = states_a_mode if args.method != "balanced" else 1
        order = fewest_states(first["hankel_m_per_N"], gain, args.error, step)
    result = _core.reduce_rotor(model, args.method, order, args.speed, list(frequencies))
    hankel, gain = result["hankel_m_per_N"], float(result["before_m_per_N"].max())
    worst = int(numpy.argmax(result["error_m_per_N"]))
    share = float(result["error_m_per_N"][worst]) / gain
    bound = result["error_bound_m_per_N"]
    print(f"model {model.name} ({model.hash}) at {args.speed:g} Hz, on {result['support_stiffness_N_per_m']:.4g} N/m and "
          f"{result['support_damping_N_s_per_m']:.4g} N s/m a bearing: {result['states']} states")
    if result["model_reduction"] is not None:
        print(f"rotor.reduction of the model ({result['model_reduction']}) is not applied here: what is reduced is the full "
              f"rotor. Runs of this model use rotor.reduction, not the result of this command")
    if args.method == "balanced_rotor":
        print("position singular values of the free rotor's bending at bearings and sensors [m/N]: "
              + ", ".join(f"{value:.3g}" for value in result["position_m_per_N"][:8]) + " ...")
        print(f"a model file takes this rotor into its runs by rotor.reduction: "
              f"{{method: balanced, modes: {result['order'] // states_a_mode}}}")
    print("Hankel singular values [m/N]: " + ", ".join(f"{value:.3g}" for value in hankel[:12]) + " ...")
    print(f"{args.method} to {result['order']} states: largest error from 1 to {args.to:g} Hz "
          f"{result['error_m_per_N'][worst]:.3g} m/N at {frequencies[worst]:.0f} Hz, {100 * share:.3g} % of the largest gain"
          + (f"; bound {bound:.3g} m/N" if bound is not None else ""))
    folder.mkdir(parents=True, exist_ok=True)
    picture = reduction.reduction(folder / "reduction.png", f"{model.name}: {args.method} to {result['order']} states",
                                  frequencies, result)
    common.write_json(args, {"model": model.name, "model_hash": model.hash, "method": args.method,
                             "model_reduction": result["model_reduction"], "speed_hz": args.speed, "states": result["states"], "order": result["order"],
                             "hankel_m_per_N": hankel, "error_bound_m_per_N": bound,
                             "position_m_per_N": result["position_m_per_N"],
                             "largest_error_m_per_N": result["error_m_per_N"][worst], "largest_error_share": share,
                             "frequency_hz": frequencies, "before_m_per_N": result["before_m_per_N"],
                             "after_m_per_N": result["after_m_per_N"]})
    common.report_line(picture)
    return 0
