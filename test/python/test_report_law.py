"""The picture of a law: against its terms, put in by hand."""
from __future__ import annotations

import numpy
import pytest

pytest.importorskip("amb_rotor._core")

from amb_rotor.cli.diagnose import print_diagnosis  # noqa: E402
from amb_rotor.report import law  # noqa: E402

RATE, TURN = 10000.0, 2 * numpy.pi
TIME = numpy.arange(8000) / RATE
SIZE, SPEED = 4e-5, 300.0


def run_of(size=SIZE, kind="steady"):
    """A rotor that goes round at its speed; a current of 2 A at end a."""
    measured = numpy.zeros((len(TIME), 8))
    measured[:, 0], measured[:, 1] = size * numpy.cos(SPEED * TIME), size * numpy.sin(SPEED * TIME)
    measured[:, 4] = 2.0 * numpy.cos(SPEED * TIME)
    return {"measured": measured, "kind": kind, "sample_rate_hz": RATE, "speed_rad_s": numpy.full(len(TIME), SPEED)}


def unexplained(depends_on, **terms):
    return {"depends_on": depends_on, "frequency_hz": None,
            "terms": [{"term": name, "coefficient": value, "std": 0.0} for name, value in terms.items()]}


# 99.5 % of a sine's samples are below 0.99997 of its size; numbers are written with four digits.
DIGITS = 1e-3


def test_at_a_plane_the_range_is_that_of_the_rotor_there():
    run = run_of()
    run["measured"][:, 2:4] = 3 * run["measured"][:, 0:2]  # end b goes out three times as far, so the middle twice
    told = unexplained(["position"], position_cube_N_per_m3=-1e13) | {"plane_z_m": {"value": 0.01, "std": 1e-4}}
    one, = law.law_curves(told, [run], (-0.09, 0.11))
    assert one["at"][-1] == pytest.approx(2e6 * SIZE, rel=DIGITS)
    assert one["curves"][0]["x"][-1] == pytest.approx(-1e13 * (2 * SIZE) ** 3, rel=2e-3)


def test_of_the_tilt_the_range_is_half_of_b_less_a():
    run = run_of()
    run["measured"][:, 2:4] = 3 * run["measured"][:, 0:2]  # the sensors 0.2 m apart see twice the size between them, the magnets half of that
    told = unexplained(["position"], position_cube_N_per_m3=-1e13) | {"place": "tilt", "plane_z_m": None}
    one, = law.law_curves(told, [run], (-0.09, 0.11), (-0.05, 0.05))
    assert one["at"][-1] == pytest.approx(0.5e6 * SIZE, rel=DIGITS)
    assert one["curves"][0]["x"][-1] == pytest.approx(-1e13 * (0.5 * SIZE) ** 3, rel=2e-3)


def test_a_cubic_spring_goes_with_the_cube_as_far_as_the_rotor_went():
    one, = law.law_curves(unexplained(["position"], position_cube_N_per_m3=-1e13), [run_of()])
    assert one["at"][-1] == pytest.approx(1e6 * SIZE, rel=DIGITS) and one["at"][0] == -one["at"][-1]
    curve, = one["curves"]
    assert curve["x"] == pytest.approx(-1e13 * (1e-6 * numpy.array(one["at"])) ** 3, rel=2e-3, abs=1e-9)
    assert set(curve["y"]) == {0.0}


def test_of_the_sensors_it_is_what_is_added_to_the_signal():
    told = unexplained(["position"], signal_step_m=-2e-6) | {"place": "sensors", "plane_z_m": None, "step_width_m": 5e-6}
    one, = law.law_curves(told, [run_of()], (-0.09, 0.11), (-0.05, 0.05))
    assert one["at"][-1] == pytest.approx(1e6 * SIZE, rel=DIGITS)
    curve, = one["curves"]
    assert curve["x"] == pytest.approx(-2.0 * numpy.tanh(numpy.array(one["at"]) / 5.0), rel=2e-3, abs=1e-9)
    assert set(curve["y"]) == {0.0}


def test_a_product_is_shown_at_nothing_and_at_the_end_of_the_other():
    over_position, over_speed = law.law_curves(unexplained(["position", "spin speed"], position_speed_N_s2_per_m=-0.5), [run_of()])
    still, turning = over_position["curves"]
    assert set(still["x"]) <= {0.0, -0.0}
    assert turning["x"][-1] == pytest.approx(-0.5 * SPEED ** 2 * SIZE, rel=DIGITS)
    assert over_speed["at"][0] == 0.0 and over_speed["at"][-1] == pytest.approx(SPEED / TURN, rel=DIGITS)
    assert over_speed["curves"][1]["x"] == pytest.approx(-0.5 * (TURN * numpy.array(over_speed["at"])) ** 2 * SIZE, rel=3e-3, abs=1e-9)


def test_a_force_that_turns_is_shown_over_one_turn():
    one, = law.law_curves(unexplained(["shaft angle"], thrice_cosine_N=2.0), [run_of()])
    angle = numpy.radians(one["at"])
    assert angle[-1] == pytest.approx(TURN, rel=DIGITS)
    assert one["curves"][0]["x"] == pytest.approx(2.0 * numpy.cos(3 * angle), abs=5e-3)
    assert one["curves"][0]["y"] == pytest.approx(2.0 * numpy.sin(3 * angle), abs=5e-3)


def test_velocities_and_currents_are_those_of_the_runs():
    velocity, current = law.law_curves(
        unexplained(["velocity", "control current"], velocity_square_N_s2_per_m2=-10.0, current_cube_N_per_A3=3.0), [run_of()])
    # parabolas over 2.5 ms flatten the slope of a sine of 48 Hz by (2 pi 48 * 1.25e-3)^2/10 = 1.4 %
    assert velocity["at"][-1] == pytest.approx(1e3 * SPEED * SIZE, rel=0.02)
    assert current["at"][-1] == pytest.approx(2.0, rel=DIGITS)
    assert current["curves"][0]["x"][-1] == pytest.approx(24.0, rel=3 * DIGITS)


def test_runs_with_contact_do_not_lengthen_the_picture():
    law_of = unexplained(["position"], position_cube_N_per_m3=-1e13)
    one, = law.law_curves(law_of, [run_of(), run_of(5 * SIZE, "drop")])
    assert one["at"][-1] == pytest.approx(1e6 * SIZE, rel=DIGITS)
    alone, = law.law_curves(law_of, [run_of(5 * SIZE, "drop")])
    assert alone["at"][-1] == pytest.approx(5e6 * SIZE, rel=DIGITS)


def test_what_repeats_in_time_does_so_at_the_frequency_found():
    told = unexplained(["time"], hum_x_cosine_N=3.0) | {"frequency_hz": 52.0}
    one, = law.law_curves(told, [run_of()])
    assert one["at"][-1] == pytest.approx(0.8, rel=DIGITS)
    assert one["curves"][0]["x"] == pytest.approx(3.0 * numpy.cos(TURN * 52.0 * numpy.linspace(0, 0.8, law.POINTS)), abs=5e-3)


def test_a_line_with_a_phase_of_each_runs_own_has_no_picture():
    assert law.law_curves(unexplained(["time"]), [run_of()]) == []


@pytest.mark.parametrize(("gain", "said"), [(0.985, "takes 98.5 %"), (0.0, None)])
def test_the_console_tells_what_a_law_takes_where_it_was_tried(capsys, gain, said):
    """Where only contact is left there is no law, and no share to tell."""
    told = unexplained(["position"]) | {"shape": "a force where the clearance is used up", "held_out_gain": gain}
    print_diagnosis({"verdict": "unknown", "sentences": [], "baseline": {"validation_error": 2.0}, "steps": [], "ranking": [],
                     "unexplained": told, "remarks": []})
    line, = [one for one in capsys.readouterr().out.splitlines() if one.startswith("unexplained:")]
    assert (said in line) if said else "%" not in line


@pytest.mark.parametrize(("with_contact", "said"), [(0.9, False), (None, True)])
def test_the_console_tells_which_runs_an_error_is_of(capsys, with_contact, said):
    """Runs with contact that have waited are in the error as believed, and not in a candidate's."""
    row = {"effect": "amplifier_lag", "evidence": 67888.4, "validation_error": 1.01, "validation_error_contact": with_contact,
           "excited": True, "beside": "", "confounded_with": []}
    print_diagnosis({"verdict": "unknown", "sentences": [], "baseline": {"validation_error": 3.7, "validation_error_contact": 6.2},
                     "steps": [], "ranking": [row], "unexplained": unexplained([]), "remarks": []})
    line, = [one for one in capsys.readouterr().out.splitlines() if "amplifier_lag" in one]
    assert line.endswith("error without contact alone") is said
