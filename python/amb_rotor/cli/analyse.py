"""`amb analyse`: regime, spectra, sections and pictures of any run, bag, measured run or sweep, offline."""
from __future__ import annotations

import math
import pathlib

from amb_rotor.cli import common
from amb_rotor.errors import InputError

HELP = "pictures and regime of any run, bag, measured run or point of a sweep"
EXAMPLE = "amb analyse overload.npz --end b --from 0.2"

# Kind -> of one motion (else of several: of a swept value, or of speeds that differ).
SINGLE = ("history", "orbit", "section", "surface", "spectrum", "full_spectrum", "waterfall", "contact_force", "hysteresis")
SEVERAL = ("cascade", "response", "bifurcation")
BLOCK_TURNS = 8         # over which a synchronous amplitude is taken while the speed changes
SAMPLES_PER_TURN, SWEPT_SAMPLES, SWEPT_TURNS = 400, 64, 64
POINT_TURNS = 300       # of a single point of a sweep, at least: fewer do not tell quasi-periodic from chaotic by the section


def add_arguments(parser) -> None:
    parser.add_argument("what", metavar="WHAT", nargs="+", help="tables of runs (.csv, .csv.gz, .npz), bags, or the folder of a "
                        "data set with --run; or one sweep file (amb-sweep/1)")
    parser.add_argument("--kind", action="append", choices=SINGLE + SEVERAL, metavar="KIND", default=[],
                        help=f"only these pictures: {', '.join(SINGLE + SEVERAL)}")
    parser.add_argument("--end", choices=("a", "b"), default="b", help="of the rotor (default: b)")
    parser.add_argument("--from", dest="begin", metavar="T", type=float, default=-math.inf, help="leave out what is before")
    parser.add_argument("--to", dest="finish", metavar="T", type=float, default=math.inf, help="leave out what is behind")
    parser.add_argument("--run", action="append", metavar="ID", default=[], help="of a data set; may be repeated")
    parser.add_argument("--model", metavar="MODEL", help="whose clearance and planes; default: the one beside the table")
    parser.add_argument("--clearance-m", metavar="M", type=float, help="of the auxiliary bearing, instead of a model's")
    parser.add_argument("--at", action="append", metavar="NAME=VALUE", default=[], help="of a sweep file: the point; without "
                        "it, the swept values up and down, each begun where the last ended")
    parser.add_argument("--section-deg", metavar="DEG", type=float, default=0.0, help="shaft angle of the section (default: 0)")
    parser.add_argument("--surface", choices=("radial", "x", "y"), default="radial", help="of the section by a surface: "
                        "turning points outwards, or the bearing's centre passed in x or y (default: radial)")
    parser.add_argument("--tacho-threshold", metavar="VALUE", type=float, default=0.5, help="of a table's tacho (default: 0.5)")
    common.add_out(parser, "analyse")


def run(args) -> int:
    if args.clearance_m is not None and not (math.isfinite(args.clearance_m) and args.clearance_m > 0.0):
        raise InputError(f"--clearance-m {args.clearance_m:g}: must be above 0")
    paths = [common.input_path(word) for word in args.what]
    if any(_is_sweep(path) for path in paths):
        if len(paths) > 1:
            raise InputError("one sweep file at a time")
        return _sweep(args, paths[0])
    if args.at:
        raise InputError("--at: is for a sweep file")
    folder = common.out_path(args, "analyse", "run")  # named by what is read where not by --out
    motions = [motion for path in paths for motion in _motions(args, path)]
    if len({motion.name for motion in motions}) != len(motions):
        raise InputError("two of the runs have the same name")
    if not args.out:
        folder = common.out_path(args, "analyse", motions[0].name if len(motions) == 1 else f"{motions[0].name}-and-more")
    folder.mkdir(parents=True, exist_ok=True)
    found, pictures = {}, []
    for motion in motions:
        found[motion.name] = _tell(motion)
        pictures += _single(args, motion, folder, "" if len(motions) == 1 else f"{motion.name}_")
    pictures += _several(args, motions, folder)
    return _end(args, folder, found, pictures)


def _end(args, folder: pathlib.Path, found: dict, pictures: list) -> int:
    common.write_json(args, {"motions": found, "pictures": [str(path) for path in pictures]})
    if not pictures:
        raise InputError(f"nothing to draw: {', '.join(args.kind)} needs more turns, contacts or speeds than there are")
    print(f"pictures (PNG and SVG): {', '.join(path.stem for path in pictures)}")
    common.report_line(folder)
    return 0


# ---- what is analysed
def _is_sweep(path: pathlib.Path) -> bool:
    return path.is_file() and path.suffix in (".yaml", ".yml")


def _motions(args, path: pathlib.Path) -> list:
    from amb_rotor import _core, models, motion
    from amb_rotor.cli import convert
    facts = motion.rig_facts(_core.read_model(str(common.input_path(args.model))).fields) if args.model else None
    if path.is_dir():
        dataset = _core.read_dataset(str(common.dataset_folder(path)))
        ids = [entry["id"] for entry in dataset.runs]
        unknown = [name for name in args.run if name not in ids]
        if not args.run or unknown:
            asked = f"--run {', '.join(unknown)}" if unknown else "--run is missing"
            raise InputError(f"{asked}: {path} has the runs {', '.join(ids)}")
        facts = facts or motion.rig_facts(dataset.belief.fields)
        tables = [(name, dataset.table(name)) for name in args.run]
        # What its own threshold made of the tacho lies within 0 and 1.
        return [_cut(args, motion.from_table(name, table, args.end, **_given(args, facts, path), threshold=0.5))
                for name, table in tables]
    if args.run:
        raise InputError(f"--run: is for the folder of a data set; {path} is a file")
    table = convert.read_table(path)
    if facts is None and args.clearance_m is None:
        model = motion.model_of_table(path)
        facts = motion.rig_facts(model.fields) if model is not None else None
    return [_cut(args, motion.from_table(models.stem(path.name), table, args.end, **_given(args, facts, path),
                                         threshold=args.tacho_threshold))]


def _given(args, facts, path) -> dict:
    if facts is None and args.clearance_m is None:
        raise InputError(f"{path}: the clearance is not known: --model MODEL or --clearance-m M")
    return {**(facts or {}), **({"clearance": args.clearance_m} if args.clearance_m is not None else {})}


def _cut(args, motion):
    if args.begin > -math.inf or args.finish < math.inf:
        return motion.part(args.begin, args.finish)
    return motion


# ---- numbers
def _tell(motion) -> dict:
    """Prints and returns what kind of motion it is."""
    import numpy
    from amb_rotor import _core, drop
    units = motion.units
    normal = motion.normal if motion.normal is not None else numpy.maximum(motion.depth, 0.0)
    facts = _core.motion_facts(motion.time, motion.angle, motion.sx, motion.sy, normal, motion.clearance, motion.rotor_radius)
    peaks = [(2.0 * math.pi * units.speed_factor * frequency, amplitude)
             for frequency, amplitude in drop.peaks(motion.x, motion.rate, math.inf)[:4]]
    facts["peaks"] = peaks
    facts["speed"] = motion.mean_speed
    facts["whirl"] = {"direction": facts["whirl"], "frequency": facts.pop("whirl_rad_s") * units.speed_factor}
    if motion.normal is None:
        facts["max_force"] = None
    length, force, frequency = units.plain
    period = f", period {facts['period']}" if facts["period"] else ""
    slip = f", {facts['slip']}" if facts["regime"] == "dry_whirl" and facts["slip"] != "undefined" else ""
    print(f"{motion.name}: {facts['regime'].replace('_', ' ')}{period}{slip}{'' if facts['certain'] else ' (not certain)'}: "
          f"{facts['reason']}")
    print(f"  {motion.time[0]:g} to {motion.time[-1]:g}, {motion.turns:.1f} turns at {motion.mean_speed:.4g} {frequency}; "
          f"largest distance {facts['max_radius']:.4f} of the clearance, {'in contact' if motion.normal is not None else 'beyond it'} "
          f"{100 * facts['contact_fraction']:.1f} % of the time, {facts['impacts']} touch-downs"
          + (f", largest force {facts['max_force']:.4g} {force}" if facts["max_force"] is not None else ""))
    if motion.speed_varies():
        facts["largest_lyapunov"] = None
    exponent = facts["largest_lyapunov"]
    print(f"  whirl {facts['whirl']['direction']}, {facts['whirl']['frequency']:+.4g} {frequency}"
          + (f"; winding number {facts['winding_number']:.5f}" if facts["regime"] == "quasi_periodic" else "")
          + (f"; largest Lyapunov exponent of the section's points {exponent:+.4f} +- {facts['largest_lyapunov_error']:.4f} a turn"
             if exponent is not None else ""))
    print(f"  spectrum of x [{frequency}] ({length}): "
          + ", ".join(f"{line:.4g} ({units.length_factor * amplitude:.3g})" for line, amplitude in peaks))
    return facts


# ---- pictures
def _wanted(args, kind: str) -> bool:
    return not args.kind or kind in args.kind


def _save(figure, folder: pathlib.Path, stem: str) -> list:
    from amb_rotor.sweeps.draw import save
    return save(figure, folder, stem)[:1] if figure is not None else []


def _single(args, motion, folder: pathlib.Path, head: str) -> list:
    from amb_rotor.plots import analysis
    options = {"section": (math.radians(args.section_deg),), "surface": (args.surface,)}
    pictures = []
    for kind in SINGLE:
        if _wanted(args, kind):
            pictures += _save(getattr(analysis, kind)(motion, *options.get(kind, ())), folder, head + kind)
    return pictures


def synchronous(motion, turns: int = BLOCK_TURNS):
    """Speeds and complex amplitudes of x, block by block of whole turns; the last block is the rest where it is all there is."""
    import numpy
    from amb_rotor import _core
    turn = numpy.abs(motion.angle - motion.angle[0]) / (2.0 * numpy.pi)
    speeds, amplitudes = [], []
    for block in range(max(int(turn[-1] / turns), 1)):
        part = (turn >= block * turns) & (turn <= (block + 1) * turns)
        found = _core.orders(motion.angle[part], motion.x[part], motion.y[part], 1)
        if found["valid"]:
            speeds.append(float(numpy.mean(motion.speed[part])) * motion.units.speed_factor)
            amplitudes.append(complex(*found["forward"][1.0]) + complex(*found["backward"][1.0]).conjugate())
    return numpy.array(speeds), numpy.array(amplitudes)


def _up_and_down(motion) -> dict:
    """Synchronous response of a motion whose speed changes, where it rises and where it falls."""
    import numpy
    speeds, amplitudes = synchronous(motion)
    if len(speeds) < 3:
        return {}
    slope = numpy.gradient(speeds)
    return {name: (speeds[chosen], amplitudes[chosen]) for name, chosen in (("run-up", slope > 0.0), ("run-down", slope <= 0.0))
            if chosen.sum() > 1}


def _several(args, motions: list, folder: pathlib.Path) -> list:
    """Cascade, synchronous response and bifurcation diagram over the speed: of several runs, or of one whose speed changes."""
    import numpy
    from amb_rotor.plots import analysis
    varying = [motion for motion in motions if motion.speed_varies()]
    pictures = []
    if len(motions) > 1 and _wanted(args, "cascade"):
        pictures += _save(analysis.cascade(motions), folder, "cascade")
    label = motions[0].units.speed
    if _wanted(args, "response"):
        rows = {}
        for motion in varying:
            for name, row in _up_and_down(motion).items():
                rows[name if len(motions) == 1 else f"{motion.name}, {name}"] = row
        steady = [motion for motion in motions if not motion.speed_varies() and motion.turns >= 2.0]
        if len(steady) > 1:
            points = sorted((motion.mean_speed, synchronous(motion, max(int(motion.turns), 1))[1][0]) for motion in steady)
            rows["steady speeds"] = tuple(map(numpy.array, zip(*points)))
        if rows:
            pictures += _save(analysis.response(rows, motions[0], label), folder, "response")
    if _wanted(args, "bifurcation") and (varying or len(motions) > 1):
        values, points = [], []
        for motion in motions:
            time, x, _ = analysis.section_points(motion, math.radians(args.section_deg))
            values += list(numpy.interp(time, motion.time, motion.speed * motion.units.speed_factor))
            points += list(x)
        if len(points) >= analysis.LEAST_POINTS:
            pictures += _save(analysis.bifurcation(values, points, motions[0], label), folder, "bifurcation")
    return pictures


# ---- sweeps
def _at(args) -> dict:
    values = {}
    for word in args.at:
        name, _, text = word.partition("=")
        try:
            values[name] = float(text)
        except ValueError:
            raise InputError(f"--at {word}: NAME=VALUE, a number") from None
        if not math.isfinite(values[name]):
            raise InputError(f"--at {word}: must be finite")
    return values


def _sweep(args, path: pathlib.Path) -> int:
    from amb_rotor import _core, motion
    if args.model or args.clearance_m is not None or args.run:
        raise InputError("--model, --clearance-m, --run: a sweep file is dimensionless")
    sweep = _core.BasicSweep(str(path))
    given = _at(args)
    unknown = [name for name in given if name not in sweep.parameters and name not in dict(sweep.axes)]
    if unknown:
        raise InputError(f"--at {', '.join(unknown)}: is no parameter of {path}; there are "
                         f"{', '.join([*dict(sweep.axes), *sweep.parameters])}")
    free = [name for name, _ in sweep.axes if name not in given]
    if len(free) > 1:
        raise InputError(f"--at: one of {', '.join(free)} needs a value")
    folder = common.out_folder(args, "analyse", "-".join([sweep.name, *(f"{key}-{value:g}" for key, value in given.items())]))
    if not free:
        name = f"{sweep.name}, " + ", ".join(f"{key} {value:g}" for key, value in given.items())
        point = _cut(args, motion.from_sweep(sweep, given, SAMPLES_PER_TURN, name,
                                              kept_turns=max(sweep.kept_turns, POINT_TURNS)))
        found = {name: {**_tell(point), "lanes": _of_lanes(sweep, given)}}
        return _end(args, folder, found, _single(args, point, folder, ""))
    return _end(args, folder, *_swept(args, sweep, given, free[0], folder))


def _of_lanes(sweep, given: dict) -> dict:
    """The regime as `amb sweep` decides it, with the exponent of the variational equation."""
    import numpy
    from amb_rotor import _core
    parameters = {key: numpy.array([value]) for key, value in {**sweep.parameters, **given}.items()}
    found = _core.run_basic_lanes(parameters, numpy.array([sweep.initial]), contact=sweep.contact, friction=sweep.friction_law,
                                  steps_per_turn=sweep.steps_per_turn, turns_skipped=sweep.turns - sweep.kept_turns,
                                  turns_kept=sweep.kept_turns)
    regime, period, exponent = found["regime"][0], int(found["period"][0]), float(found["largest_lyapunov"][0])
    print(f"  as amb sweep decides: {regime.replace('_', ' ')}{f', period {period}' if period else ''}, largest Lyapunov exponent "
          f"{exponent:+.4f} per unit of dimensionless time (variational equation)")
    return {"regime": regime, "period": period, "largest_lyapunov": exponent}


def _swept(args, sweep, given: dict, axis: str, folder: pathlib.Path):
    """Up and down along the free axis, every value begun where the last ended."""
    import numpy
    from amb_rotor import motion
    from amb_rotor.plots import analysis
    from amb_rotor.sweeps.draw import label
    from amb_rotor.sweeps.figures import jumps
    values = numpy.sort(dict(sweep.axes)[axis])
    runs = {}
    with common.progress_bar(2 * len(values), "points") as bar:
        for name, order in (("up", values), ("down", values[::-1])):
            state, runs[name] = sweep.initial, []
            for value in order:
                at = {**given, axis: value}
                runs[name].append(motion.from_sweep(sweep, at, SWEPT_SAMPLES, f"{sweep.name}, {axis} {value:g}", state,
                                                    min(sweep.kept_turns, SWEPT_TURNS)))
                state = runs[name][-1].end
                bar.update(1)
    rows, found = {}, {}
    for name, motions in runs.items():
        order = values if name == "up" else values[::-1]
        amplitudes = numpy.array([synchronous(m, max(int(m.turns), 1))[1][0] for m in motions])
        rows[name] = (order, amplitudes)
        steps = jumps(order, numpy.abs(amplitudes))
        touched = [value for value, m in zip(order, motions) if m.touching.any()]
        print(f"{name}: " + (f"in contact from {min(touched):.4g} to {max(touched):.4g}" if touched else "never in contact")
              + "; jumps " + (", ".join(f"at {value:.4g} from {a:.3f} to {b:.3f}" for value, a, b in steps) or "none"))
        found[name] = {"jumps": steps, "amplitude": numpy.abs(amplitudes), axis: order}
    pictures = []
    first = runs["up"][0]
    first.name = sweep.title
    if _wanted(args, "cascade"):
        pictures += _save(analysis.cascade(runs["up"], None if axis == "frequency_ratio" else values, label(axis)), folder, "cascade")
    if _wanted(args, "response"):
        pictures += _save(analysis.response(rows, first, label(axis)), folder, "response")
    if _wanted(args, "bifurcation"):
        sections = [analysis.section_points(m, math.radians(args.section_deg))[1] for m in runs["up"]]
        pictures += _save(analysis.bifurcation(numpy.repeat(values, [len(s) for s in sections]), numpy.concatenate(sections),
                                               first, label(axis)), folder, "bifurcation")
    return found, pictures
