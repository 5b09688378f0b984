"""The independent simulator (simulator.cpp) for a rig, effects and nuisance values in the words of the data-set format.

Reads nothing of the project: a rig is the mapping under `rig` in dataset.yaml, effects the list in truth.yaml.
SI units; speeds in Hz where the name says so.
"""
import copy
import ctypes
import math
import pathlib
import subprocess

import numpy as np

SOURCE = pathlib.Path(__file__).with_name("simulator.cpp")
_FLAGS = ["-std=c++17", "-O3", "-march=native", "-ffast-math", "-fno-finite-math-only", "-shared", "-fPIC"]
_DOUBLES = np.ctypeslib.ndpointer(dtype=np.float64, flags="C_CONTIGUOUS")


class Simulator:
    """The compiled program; `folder` takes the shared library."""

    def __init__(self, folder, source=SOURCE):
        library = pathlib.Path(folder) / "independent_simulator.so"
        if not library.exists() or library.stat().st_mtime < pathlib.Path(source).stat().st_mtime:
            subprocess.run(["g++", *_FLAGS, "-o", str(library), str(source)], check=True)
        self._library = ctypes.CDLL(str(library))
        self._library.parameter_names.restype = ctypes.c_char_p
        self.names = self._library.parameter_names().decode().split()

    def run(self, parameters, unbalances, knots, angle, record_hz, excitation=None, records=None, events=(),
            settle=1.5, step=1e-5, disturbance=None, offsets=None):
        """Channels, records x 8: signals ax ay bx by [m], currents ax ay bx by [A].

        knots: rows of time [s] and speed [rad/s]; angle [rad] at time 0; excitation: records x 4 [A].
        offsets: of the sensors and their drift, 2 x 4 [m], that the controller acts on.
        """
        unknown = set(parameters) - set(self.names)
        if unknown:
            raise KeyError(unknown)
        values = np.array([float(parameters.get(name, 0.0)) for name in self.names])
        records = len(excitation) if records is None else records
        out = np.full((records, 8), np.nan)

        def block(rows, columns):
            return np.ascontiguousarray(np.asarray(rows, float).reshape(-1, columns))

        u, w, e = block(unbalances, 4), block(knots, 2), block(events, 2)
        x = None if excitation is None else block(excitation, 4)
        n = None if disturbance is None else block(disturbance, 4)
        o = None if offsets is None else block(offsets, 4)

        def pointer(rows):
            return None if rows is None else rows.ctypes.data_as(ctypes.c_void_p)

        c = ctypes.c_double
        status = self._library.simulate(
            pointer(values), pointer(u), len(u), pointer(w), len(w), c(angle), c(settle), c(step), c(record_hz),
            records, pointer(x), pointer(e), len(e), pointer(n), pointer(o), pointer(out))
        if status or not np.all(np.isfinite(out)):
            raise ArithmeticError("the motion diverged")
        return out


def with_nuisance(rig, nuisance):
    """The rig with the values of truth.yaml's `nuisance` in place of the belief's."""
    rig = copy.deepcopy(rig)
    for path, value in nuisance.items():
        keys = path.split(".")
        if keys[0] == "sensor":
            continue
        place = rig
        for key in keys[:-1]:
            place = place[key]
        for entry in place if isinstance(place, list) else [place]:
            entry[keys[-1]] = float(value)
    return rig


def machine(rig, effects):
    """Parameters of the program and its unbalances, for a rig and effects: (mapping, rows z, moment, phase, shape)."""
    rotor, planes, aux = rig["rotor"], rig["planes"], rig["auxiliary_bearing"]
    p = {
        "mass": rotor["mass_kg"], "transverse_inertia": rotor["transverse_inertia_kg_m2"],
        "polar_inertia": rotor["polar_inertia_kg_m2"], "gravity": rig["gravity_m_s2"],
        "clearance": aux["clearance_m"], "radius": aux["rotor_radius_m"],
        "contact_k": aux["contact"]["stiffness_N_per_m"], "contact_d": aux["contact"]["damping_N_s_per_m"],
        "friction": aux["friction_coefficient"],
        "gain_ax": 1, "gain_ay": 1, "gain_bx": 1, "gain_by": 1,
        "control_hz": 1e4, "filter_hz": 1e3, "amplifier_hz": 1e3, "bias_current": 1, "max_current": 2,
    }
    for plane in ("amb", "sensor", "aux"):
        for end in "ab":
            p[f"z_{plane}_{end}"] = planes[plane][end]
    amb = rig["amb"]
    if amb["model"] == "equivalent":
        p.update(equivalent=1, equivalent_k=amb["stiffness_N_per_m"], equivalent_d=amb["damping_N_s_per_m"])
    else:
        control = rig["controller"]
        p.update(ki_force=amb["current_stiffness_N_per_A"], ks=amb["displacement_stiffness_N_per_m"],
                 bias_current=amb["bias_current_A"], bias_flux=amb.get("bias_flux_density_T", 0),
                 amplifier_hz=amb["amplifier_bandwidth_hz"], max_current=amb["max_current_A"],
                 control_hz=control["sample_rate_hz"], kp=control["kp_A_per_m"], kd=control["kd_A_s_per_m"],
                 ki=control["ki_A_per_m_s"], filter_hz=control["derivative_filter_hz"], delay=control["delay_s"])
    unbalances = [[u["plane_z_m"], u["moment_kg_m"], u["phase_rad"], 0.0] for u in rig["unbalance"]]
    shape = 0.0
    for entry in effects:
        q = {name: float(v["value"] if isinstance(v, dict) else v) for name, v in entry["parameters"].items()}
        name = entry["effect"]
        if name == "couple_unbalance":
            unbalances.append([q["plane_z_m"], q["moment_kg_m"], q["phase_rad"], 0.0])
        elif name == "spin_drag":
            pass  # in the knots of the speed
        elif name == "shaft_flexibility":
            shape = q["shape_unbalance"]
            p.update(flexible=1, flex_hz=q["frequency_hz"], flex_ratio=q["damping_ratio"])
            for plane in ("amb", "sensor", "aux"):
                for end in "ab":
                    p[f"shape_{plane}_{end}"] = q[f"shape_{plane}_{end}"]
        else:
            p.update({TARGET[name][key]: value for key, value in q.items()})
            p.update(SWITCH.get(name, {}))
    for row in unbalances[:len(rig["unbalance"])]:
        row[3] = shape
    return p, unbalances


def _runout():
    names = {}
    for end in "ab":
        for n in "12":
            names[f"{end}_{n}x_m"] = f"runout_{end}{n}"
            names[f"{end}_{n}x_phase_rad"] = f"runout_{end}{n}_phase"
    return names


AXES = ("ax", "ay", "bx", "by")
SWITCH = {"foundation_resonance": {"foundation": 1}, "magnetic_nonlinearity": {"nonlinear": 1},
          "magnetic_saturation": {"saturating": 1}, "eddy_current_lag": {"eddy": 1}, "hertzian_contact": {"hertz": 1},
          "compliant_mount": {"mount": 1}, "velocity_dependent_friction": {"stribeck": 1},
          "inner_ring_spin": {"ring": 1}}
TARGET = {
    "shaft_bow": {"bow_a_m": "bow_a", "bow_b_m": "bow_b", "phase_rad": "bow_phase"},
    "sensor_runout": _runout(),
    "sensor_gain_error": {f"factor_{c}": f"gain_{c}" for c in AXES},
    "sensor_axis_rotation": {"angle_a_rad": "angle_a", "angle_b_rad": "angle_b"},
    "static_load": {"force_x_N": "load_x", "force_y_N": "load_y"},
    "gyroscopic_coupling": {"polar_inertia_kg_m2": "polar_inertia"},
    "stiffness_anisotropy": {"relative_difference": "anisotropy"},
    "cross_coupled_stiffness": {"stiffness_N_per_m": "cross_q", "reference_speed_hz": "cross_hz",
                                "speed_exponent": "cross_exponent", "z_m": "cross_z"},
    "internal_damping": {"damping_N_s_per_m": "internal_d", "z_m": "internal_z"},
    "foundation_resonance": {"mass_kg": "foundation_mass", "frequency_hz": "foundation_hz",
                             "damping_ratio": "foundation_ratio"},
    "magnetic_nonlinearity": {"bias_current_A": "nonlinear_i0", "air_gap_m": "nonlinear_s0"},
    "magnetic_saturation": {"knee_flux_density_T": "knee"},
    "current_saturation": {"max_current_A": "max_current"},
    "amplifier_lag": {"bandwidth_hz": "amplifier_hz"},
    "control_delay": {"delay_s": "delay"},
    "eddy_current_lag": {"corner_hz": "eddy_hz"},
    "motor_magnetic_pull": {"stiffness_N_per_m": "pull_k", "z_m": "pull_z"},
    "auxiliary_bearing_misalignment": {f"offset_{c}_m": f"offset_{c}" for c in AXES},
    "hertzian_contact": {"stiffness_N_per_m1_5": "hertz_k", "damping_s_per_m": "hertz_l"},
    "compliant_mount": {"stiffness_N_per_m": "mount_k", "damping_N_s_per_m": "mount_d", "mass_kg": "mount_mass"},
    "velocity_dependent_friction": {"static_coefficient": "mu_static", "dynamic_coefficient": "mu_dynamic",
                                    "speed_m_per_s": "stribeck_speed"},
    "inner_ring_spin": {"inertia_kg_m2": "ring_inertia", "drag_torque_N_m": "ring_drag"},
    "shaft_crack": {"relative_depth": "crack_depth", "phase_rad": "crack_phase"},
}


def drag_knots(speed, decay, torque, polar_inertia, duration, spacing=1e-3):
    """Knots of W' = -decay W - torque/Ip from `speed` [rad/s] at time 0 until it stands."""
    t = np.arange(0, duration + 2 * spacing, spacing)
    brake = torque / polar_inertia if polar_inertia > 0 else 0.0
    w = speed * np.exp(-decay * t) - (brake / decay * -np.expm1(-decay * t) if decay > 0 else brake * t)
    return np.column_stack([t, np.maximum(w, 0.0)])


def tacho(knots, angle, record_hz, records):
    """The pulse, high for the first 15 % of a turn, averaged over two samples as a recorder's filter does."""
    fine = 64
    t = (np.arange(-fine, records * fine) + 0.5) / (record_hz * fine)
    w = np.interp(t, knots[:, 0], knots[:, 1])
    dt = np.diff(knots[:, 0])
    at = angle + np.concatenate([[0], np.cumsum(dt * (knots[1:, 1] + knots[:-1, 1]) / 2)])
    i = np.clip(np.searchsorted(knots[:, 0], t, side="right") - 1, 0, len(knots) - 1)
    theta = at[i] + (knots[i, 1] + w) / 2 * (t - knots[i, 0])
    high = (np.mod(theta, 2 * math.pi) < 0.3 * math.pi).astype(float)
    pulse = high.reshape(-1, fine).mean(axis=1)  # over [n - 1, n] of the samples
    return (pulse[:-1] + pulse[1:]) / 2
