"""One case or more of each effect of the catalogue, with sizes that show on each rig."""


def _e(effect, **parameters):
    return {"effect": effect, "parameters": {k: float(v) for k, v in parameters.items()}}


def effects_of(block):
    """name: list of effects, with sizes for this rig."""
    amb, control, rotor = block["amb"], block["controller"], block["rotor"]
    k = amb["current_stiffness_N_per_A"] * control["kp_A_per_m"] - amb["displacement_stiffness_N_per_m"]
    moment = block["unbalance"][0]["moment_kg_m"]
    mass, aux = rotor["mass_kg"], block["auxiliary_bearing"]
    contact = aux["contact"]["stiffness_N_per_m"]
    f = (2 * k / mass) ** 0.5 / 6.283185307
    runout = {}
    for end, r in (("a", 1.1e-6), ("b", 0.7e-6)):
        for n, p in ((1, 0.5), (2, -0.8)):
            runout[f"{end}_{n}x_m"] = r / n
            runout[f"{end}_{n}x_phase_rad"] = p + (0.9 if end == "b" else 0)
    static = _e("static_load", force_x_N=k * 8e-6, force_y_N=-k * 12e-6)
    nonlinear = _e("magnetic_nonlinearity", bias_current_A=amb["bias_current_A"], air_gap_m=amb["air_gap_m"])
    return {
        "couple_unbalance": [_e("couple_unbalance", moment_kg_m=0.7 * moment, phase_rad=1.9, plane_z_m=0.06)],
        "shaft_bow": [_e("shaft_bow", bow_a_m=3e-6, bow_b_m=-1.5e-6, phase_rad=0.8)],
        "sensor_runout": [_e("sensor_runout", **runout)],
        "sensor_gain_error": [_e("sensor_gain_error", factor_ax=1.06, factor_ay=0.97, factor_bx=0.93, factor_by=1.03)],
        "sensor_axis_rotation": [_e("sensor_axis_rotation", angle_a_rad=0.12, angle_b_rad=-0.07)],
        "static_load": [static],
        "gyroscopic_coupling": [_e("gyroscopic_coupling", polar_inertia_kg_m2=0.3 * rotor["transverse_inertia_kg_m2"])],
        "stiffness_anisotropy": [_e("stiffness_anisotropy", relative_difference=0.12)],
        "cross_coupled_stiffness": [_e("cross_coupled_stiffness", stiffness_N_per_m=0.12 * k, reference_speed_hz=80,
                                       speed_exponent=1.4, z_m=0.03)],
        "internal_damping": [_e("internal_damping", damping_N_s_per_m=0.1 * k / 6.28 / f, z_m=-0.03)],
        "foundation_resonance": [_e("foundation_resonance", mass_kg=8 * mass, frequency_hz=0.6 * f, damping_ratio=0.05)],
        "magnetic_nonlinearity": [nonlinear],
        "magnetic_saturation": [_e("magnetic_saturation", knee_flux_density_T=1.35 * amb["bias_flux_density_T"])],
        # the caller sets the limit: a little less than the largest current of the same runs without it
        "current_saturation": [_e("current_saturation", max_current_A=0.9 * amb["max_current_A"])],
        "amplifier_lag": [_e("amplifier_lag", bandwidth_hz=0.6 * amb["amplifier_bandwidth_hz"])],
        "control_delay": [_e("control_delay", delay_s=control["delay_s"] + 7.7e-5)],
        "eddy_current_lag": [_e("eddy_current_lag", corner_hz=60000)],
        "motor_magnetic_pull": [_e("motor_magnetic_pull", stiffness_N_per_m=0.1 * k, z_m=-0.04)],
        "auxiliary_bearing_misalignment": [_e("auxiliary_bearing_misalignment", offset_ax_m=15e-6, offset_ay_m=-9e-6,
                                              offset_bx_m=-20e-6, offset_by_m=12e-6)],
        "hertzian_contact": [_e("hertzian_contact", stiffness_N_per_m1_5=contact / 3e-3, damping_s_per_m=0.15)],
        "compliant_mount": [_e("compliant_mount", stiffness_N_per_m=0.25 * contact, damping_N_s_per_m=900, mass_kg=0.08)],
        "velocity_dependent_friction": [_e("velocity_dependent_friction", static_coefficient=0.3,
                                           dynamic_coefficient=0.06, speed_m_per_s=1.5)],
        "inner_ring_spin": [_e("inner_ring_spin", inertia_kg_m2=4e-6, drag_torque_N_m=0.01)],
        "spin_drag": [_e("spin_drag", decay_per_s=0.06, torque_N_m=0.004)],
        "shaft_crack": [_e("shaft_crack", relative_depth=0.12, phase_rad=-0.9)],
        "shaft_flexibility": [_e("shaft_flexibility", frequency_hz=290, damping_ratio=0.01, shape_amb_a=0.55,
                                 shape_amb_b=0.35, shape_sensor_a=0.9, shape_sensor_b=0.1, shape_aux_a=1.2,
                                 shape_aux_b=0.8, shape_unbalance=-0.6)],
        "nonlinear_and_load": [nonlinear, static],
        "runout_and_gain": [_e("sensor_runout", **runout), _e("sensor_gain_error", factor_ax=1.06, factor_ay=0.97,
                                                             factor_bx=0.93, factor_by=1.03),
                            _e("sensor_axis_rotation", angle_a_rad=0.12, angle_b_rad=-0.07)],
        "none": [],
    }


CONTACT = ("auxiliary_bearing_misalignment", "hertzian_contact", "compliant_mount", "velocity_dependent_friction",
           "inner_ring_spin")
