"""A recorded motion, whatever it was recorded by: a run of a machine, a bag, a measured run, a point of a sweep.

In one plane, about the auxiliary bearing: z = rotor, c = bearing's centre, s = z - c, contact where abs(s) is above the
clearance. Lengths, times and forces are in the units of `units`: SI, or the thesis's dimensionless ones (5.3).
Samples are equally spaced in time.
"""
from __future__ import annotations

import dataclasses
import pathlib

import numpy

from amb_rotor.errors import InputError

UNEQUAL = 0.02  # share of a step by which steps may differ and still count as equal


@dataclasses.dataclass(frozen=True)
class Units:
    """What a number is called on an axis, and the factor that takes it there."""
    length: str
    length_factor: float
    time: str
    force: str
    frequency: str
    speed_factor: float     # from rad per unit of time to `frequency`
    speed: str
    plain: tuple            # of length, force and frequency in running text

    @property
    def si(self) -> bool:
        return self is SI


SI = Units("µm", 1e6, "time [s]", "[N]", "[Hz]", 0.5 / numpy.pi, "speed [Hz]", ("µm", "N", "Hz"))
DIMENSIONLESS = Units("clearance", 1.0, "time times natural frequency  $\\tau$", "/ (clearance $k_1$)",
                      "over natural frequency", 1.0, "driving frequency over natural frequency  $\\eta$",
                      ("clearances", "clearances k1", "natural frequencies"))


@dataclasses.dataclass
class Motion:
    """Columns of one length; `normal` is None where no force was recorded, `speed` is in rad per unit of time."""
    name: str
    time: numpy.ndarray
    angle: numpy.ndarray
    speed: numpy.ndarray
    x: numpy.ndarray
    y: numpy.ndarray
    centre_x: numpy.ndarray
    centre_y: numpy.ndarray
    normal: numpy.ndarray | None
    clearance: float
    rotor_radius: float = 0.0
    units: Units = SI
    plane: str = ""
    end: tuple = ()         # of a sweep's machine: the state behind the last turn, over the file's clearance

    @property
    def sx(self):
        return self.x - self.centre_x

    @property
    def sy(self):
        return self.y - self.centre_y

    @property
    def depth(self):
        """Penetration, negative inside the clearance."""
        return numpy.hypot(self.sx, self.sy) - self.clearance

    @property
    def touching(self):
        return self.normal > 0.0 if self.normal is not None else self.depth > 0.0

    @property
    def rate(self) -> float:
        return (len(self.time) - 1) / (self.time[-1] - self.time[0])

    @property
    def turns(self) -> float:
        return abs(self.angle[-1] - self.angle[0]) / (2.0 * numpy.pi)

    @property
    def mean_speed(self) -> float:
        """In `units.frequency`."""
        return float(numpy.mean(self.speed)) * self.units.speed_factor

    def speed_varies(self) -> bool:
        return bool(numpy.ptp(self.speed) > 0.02 * max(numpy.abs(self.speed).max(), 1e-12))

    def part(self, begin: float, finish: float) -> "Motion":
        """The samples in [begin, finish]. @raise InputError: fewer than 16"""
        inside = (self.time >= begin) & (self.time <= finish)
        if inside.sum() < 16:
            raise InputError(f"{self.name}: {int(inside.sum())} samples from {begin:g} to {finish:g}; it covers "
                             f"{self.time[0]:g} to {self.time[-1]:g}")
        cut = {field.name: getattr(self, field.name)[inside] for field in dataclasses.fields(self)
               if isinstance(getattr(self, field.name), numpy.ndarray)}
        return dataclasses.replace(self, **cut)


def _checked(motion: Motion) -> Motion:
    columns = [motion.time, motion.angle, motion.x, motion.y] + ([] if motion.normal is None else [motion.normal])
    if len(motion.time) < 16:
        raise InputError(f"{motion.name}: {len(motion.time)} samples; 16 at least")
    if not all(numpy.isfinite(column).all() for column in columns):
        raise InputError(f"{motion.name}: holds numbers that are not finite")
    steps = numpy.diff(motion.time)
    worst = int(numpy.argmax(numpy.abs(steps - steps.mean())))
    if abs(steps[worst] - steps.mean()) > UNEQUAL * steps.mean():
        raise InputError(f"{motion.name}: t_s: steps from {steps.min():g} to {steps.max():g}, the odd one behind "
                         f"{motion.time[worst]:g}; the samples must be equally spaced in time")
    return motion


LENGTHS = (("m", 1.0), ("mm", 1e-3), ("um", 1e-6))


def _displacement(table: dict, axis: str):
    """A measured displacement in m, None where the table has none."""
    for unit, factor in LENGTHS:
        if f"{axis}_{unit}" in table:
            return factor * table[f"{axis}_{unit}"]
    return None


def _shaft(table: dict, name: str, threshold: float):
    from amb_rotor import _core
    if "angle_rad" in table:
        speed = 2.0 * numpy.pi * table["speed_Hz"] if "speed_Hz" in table else numpy.gradient(table["angle_rad"], table["t_s"])
        return table["angle_rad"], speed
    if "tacho" in table:
        return tuple(map(numpy.asarray, _core.shaft_angle(table["t_s"], table["tacho"], threshold)))
    raise InputError(f"{name}: needs angle_rad or tacho: the shaft's angle")


def from_table(name: str, table: dict, end: str, clearance: float, rotor_radius: float = 0.0, planes: dict | None = None,
               threshold: float = 0.5) -> Motion:
    """The motion at an end's auxiliary bearing; of a measured table that of its sensors, carried there along the straight
    line through both where `planes` ({"sensor": (a, b), "aux": (a, b)}) are known. @raise InputError"""
    if "t_s" not in table:
        raise InputError(f"{name}: t_s: the column is missing")
    zeros = numpy.zeros(len(table["t_s"]))
    angle, speed = _shaft(table, name, threshold)
    if f"aux_{end}x_m" in table:
        x, y = table[f"aux_{end}x_m"], table[f"aux_{end}y_m"]
        centre = table.get(f"centre_{end}x_m", zeros), table.get(f"centre_{end}y_m", zeros)
        return _checked(Motion(name, table["t_s"], angle, speed, x, y, *centre, table.get(f"normal_{end}_N"), clearance,
                               rotor_radius, SI, f"auxiliary bearing {end}"))
    plane = f"sensors {end}"
    both = {axis: _displacement(table, axis) for axis in ("ax", "ay", "bx", "by")}
    x, y = both[f"{end}x"], both[f"{end}y"]
    if x is None or y is None:
        raise InputError(f"{name}: has neither aux_{end}x_m, aux_{end}y_m nor {end}x, {end}y in m, mm or um")
    if planes and all(column is not None for column in both.values()):
        first, second = planes["sensor"]
        share = (planes["aux"]["ab".index(end)] - first) / (second - first)
        x, y = (both[f"a{axis}"] + share * (both[f"b{axis}"] - both[f"a{axis}"]) for axis in "xy")
        plane = f"auxiliary bearing {end}, from the sensors"
    return _checked(Motion(name, table["t_s"], angle, speed, x, y, zeros, zeros, None, clearance, rotor_radius, SI, plane))


def rig_facts(fields: dict) -> dict:
    """What a motion needs of a model's fields: clearance, rotor radius, planes."""
    return {"clearance": fields["rig.auxiliary_bearing.clearance_m"],
            "rotor_radius": fields["rig.auxiliary_bearing.rotor_radius_m"],
            "planes": {plane: (fields[f"rig.planes.{plane}.a"], fields[f"rig.planes.{plane}.b"])
                       for plane in ("sensor", "aux")}}


def from_sweep(sweep, values: dict, samples_per_turn: int, name: str, initial: tuple | None = None,
               kept_turns: int | None = None) -> Motion:
    """The event-accurate motion of one machine of a sweep file, its kept turns; from the file's initial state unless
    another is given. @raise InputError"""
    from amb_rotor import _core
    parameters = {**sweep.parameters, **values}
    missing = [axis for axis, _ in sweep.axes if axis not in values]
    if missing:
        raise InputError(f"--at: {', '.join(missing)}: the swept parameter needs a value")
    kept = kept_turns or sweep.kept_turns
    found = _core.record_basic(parameters, initial or sweep.initial, contact=sweep.contact, friction=sweep.friction_law,
                               turns_skipped=sweep.turns - min(kept, sweep.kept_turns), turns_kept=kept, samples_per_turn=samples_per_turn)
    if not found["finite"]:
        raise InputError(f"{name}: the motion cannot be integrated (it leaves all bounds)")
    eta = parameters["frequency_ratio"]
    ones = numpy.ones(len(found["phase"]))
    return _checked(Motion(name, found["phase"] / eta, found["phase"], eta * ones, found["x"], found["y"],
                           found["misalignment"][0] * ones, found["misalignment"][1] * ones, found["normal_force"], 1.0,
                           parameters.get("surface_radius", 0.0), DIMENSIONLESS, end=found["end"]))


def model_of_table(path: pathlib.Path):
    """The model that `amb simulate` left with its table, or None."""
    from amb_rotor import _core
    beside = path.with_name(path.name + ".model.yaml")
    if beside.is_file():
        return _core.read_model(str(beside))
    if path.suffix == ".npz":
        try:
            with numpy.load(path, allow_pickle=False) as archive:
                return _core.parse_model(str(archive["model"]), path.name) if "model" in archive.files else None
        except (ValueError, OSError):
            return None
    return None
