"""Laws of no catalogue: what they depend on, and parameters of the simulator with which they show on a rig.

At both bearings, in every round:
quadratic_damping       F = -c |v| v
cubic_spring            F = -c |p|^2 p
third_harmonic          F = f (cos, sin)(3 angle + phase)
dry_friction_levitated  F = -c v/|v|

At one plane, which may lie somewhat outside the bearings, against the tilt, or at both bearings; only with --laws:
plane_quadratic_damping F = -c |v| v
plane_cubic_spring      F = -c |p|^2 p
plane_speed_damping     F = -c |W| v
plane_third_harmonic    F = f (cos, sin)(3 angle + phase)
tilt_cubic              M = -c |theta|^2 theta, theta the rotations about x and y
tilt_drag               M = -c |theta'| theta'
swirl_square            at both bearings F = c W |p| (-y, x)
current_stiffening      at both bearings F = -c |i|^2 p, i the control currents of x and y there

What the four sensors read, each of its own displacement s, before anything else that a sensor does; the controller gets
it and the recorder. Only with --laws:
sensor_dead_zone        s - sign(s) min(|s|, d)
sensor_cubic            s + c s^3
sensor_saturating       L tanh(s/L)
sensor_speed_gain       s (1 + c |W|)

p, v: position and velocity of the shaft there, against the stator; W: spin speed.
"""
import math

import numpy as np

IN_ROUND = {"quadratic_damping": ["velocity"], "cubic_spring": ["position"], "third_harmonic": ["shaft angle"],
            "dry_friction_levitated": ["velocity"]}
APART = {"plane_quadratic_damping": ["velocity"], "plane_cubic_spring": ["position"],
         "plane_speed_damping": ["velocity", "spin speed"], "plane_third_harmonic": ["shaft angle"],
         "tilt_cubic": ["position"], "tilt_drag": ["velocity"], "swirl_square": ["position", "spin speed"],
         "current_stiffening": ["position", "control current"]}
OF_SENSORS = {"sensor_dead_zone": ["position"], "sensor_cubic": ["position"], "sensor_saturating": ["position"],
              "sensor_speed_gain": ["position", "spin speed"]}
APART.update(OF_SENSORS)
ALL = {**IN_ROUND, **APART}
BESIDE = 0.3  # how far outside the bearings a plane may lie, over their distance
# Of the motion in the runs, for a first guess of coefficients: radius [m], speed of it [m/s], spin speed [rad/s]
RADIUS, SPEED, SPIN = 20e-6, 10e-3, 500.0
DIFFERENCE = (3.0, 15.0)  # over the noise, of the laws apart
WITHIN = {"law_sensor_play": (1e-6, 4e-6)}  # what a parameter may come to [m]
AIM = (3.5, 13.0)         # what is drawn: the noise and angles of the runs to come make a little of it
# A controller's current follows the position: a spring in r^2 alone leaves a seventh of this law's force, which has to
# stand out of the noise, or the current would not be there to be found.
AIM_OF = {"current_stiffening": (9.0, 13.0)}


def _stiffness(rig):
    amb, control = rig["amb"], rig["controller"]
    return amb["current_stiffness_N_per_A"] * control["kp_A_per_m"] - amb["displacement_stiffness_N_per_m"]


def drawn(dice, law, rig):
    """Simulator parameters of a law of a round, of a size that shows on this rig; of none: {}."""
    k = _stiffness(rig)
    size = dice.uniform(0.5, 1.5)
    if law == "quadratic_damping":
        return {"law_quadratic": 0.3 * math.sqrt(k * rig["rotor"]["mass_kg"]) / 2e-3 * size}
    if law == "cubic_spring":
        return {"law_cubic": 0.25 * k / (20e-6) ** 2 * size}
    if law == "third_harmonic":
        return {"law_third": k * 3e-6 * size, "law_third_phase": dice.uniform(-3, 3)}
    return {"law_dry": k * 2e-6 * size} if law else {}


def drawn_apart(dice, law, rig):
    """(parameters of a law apart with a guess of its coefficient, the difference over noise that it is to make and the
    least that does)."""
    k, rotor, planes = _stiffness(rig), rig["rotor"], rig["planes"]["amb"]
    distance = planes["b"] - planes["a"]
    z = dice.uniform(planes["a"] - BESIDE * distance, planes["b"] + BESIDE * distance)
    least, most = AIM_OF.get(law, AIM)
    phase, aim = dice.uniform(-3, 3), math.exp(dice.uniform(math.log(least), math.log(most)))
    damping = 0.1 * math.sqrt(k * rotor["mass_kg"])
    tilt, arm = RADIUS / distance, distance / 2
    current = rig["controller"]["kp_A_per_m"] * RADIUS
    parameters = {
        "plane_quadratic_damping": {"law_z_m": z, "law_plane_quadratic": damping / SPEED},
        "plane_cubic_spring": {"law_z_m": z, "law_plane_cubic": 0.1 * k / RADIUS ** 2},
        "plane_speed_damping": {"law_z_m": z, "law_plane_speed": damping / SPIN},
        "plane_third_harmonic": {"law_z_m": z, "law_plane_third": k * 2e-6, "law_plane_third_phase": phase},
        "tilt_cubic": {"law_tilt_cubic": 0.2 * k * arm ** 2 / tilt ** 2},
        "tilt_drag": {"law_tilt_drag": 2 * damping * arm ** 2 / (SPEED / distance)},
        "swirl_square": {"law_swirl": 0.03 * k / (SPIN * RADIUS)},
        "current_stiffening": {"law_current": 0.1 * k / current ** 2},
        "sensor_dead_zone": {"law_sensor_play": 2e-6},
        "sensor_cubic": {"law_sensor_cubic": 0.1 / RADIUS ** 2},
        "sensor_saturating": {"law_sensor_limit": 2 * RADIUS},
        "sensor_speed_gain": {"law_sensor_speed": 0.05 / SPIN},
    }[law]
    return parameters, aim, least


def scaled(parameters, factor):
    """The same law with `factor` times its coefficient; that of L tanh(s/L) is 1/L^2."""
    def power(name):
        return 0 if name == "law_z_m" or name.endswith("_phase") else -0.5 if name.endswith("_limit") else 1
    return {name: factor ** power(name) * value for name, value in parameters.items()}


def displacements(readings, parameters, spin):
    """What sensors that read so have before them; spin: the speed [rad/s] at each record."""
    s = readings + np.sign(readings) * parameters.get("law_sensor_play", 0.0)
    s = s / (1 + parameters.get("law_sensor_speed", 0.0) * np.abs(spin)[:, None])
    if c := parameters.get("law_sensor_cubic"):
        s = 2 / math.sqrt(3 * c) * np.sinh(np.arcsinh(1.5 * math.sqrt(3 * c) * s) / 3)
    if limit := parameters.get("law_sensor_limit"):
        s = limit * np.arctanh(np.clip(s / limit, -1 + 1e-15, 1 - 1e-15))
    return s
