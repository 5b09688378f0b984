"""`amb analyse`: numbers on motions made by hand, pictures of every kind from every source, bad input."""
from __future__ import annotations

import json
import pathlib

import numpy
import pytest

from amb_rotor import cli, motion
from amb_rotor.cli import analyse, convert
from amb_rotor.errors import InputError

pytest.importorskip("amb_rotor._core")
ROOT = pathlib.Path(__file__).resolve().parents[2]
CLEARANCE, RATE, SPEED_HZ = 3e-4, 10000.0, 100.0
TIME = numpy.arange(20001) / RATE


def table(z, normal=None, speed_hz=SPEED_HZ, angle=None):
    """A table of `amb simulate`: z in clearances at both ends."""
    columns = {"t_s": TIME, "angle_rad": 2 * numpy.pi * SPEED_HZ * TIME if angle is None else angle,
               "speed_Hz": numpy.broadcast_to(speed_hz, TIME.shape).astype(float)}
    for end in "ab":
        columns[f"aux_{end}x_m"], columns[f"aux_{end}y_m"] = CLEARANCE * z.real, CLEARANCE * z.imag
        columns[f"centre_{end}x_m"] = columns[f"centre_{end}y_m"] = numpy.zeros(len(z))
        columns[f"normal_{end}_N"] = numpy.zeros(len(z)) if normal is None else normal
    return columns


def whirl(radius, hz):
    return radius * numpy.exp(2j * numpy.pi * hz * TIME)


def facts(columns, capsys=None, **more):
    return analyse._tell(motion.from_table("made", columns, "b", CLEARANCE, **more))


def test_a_forward_rub_of_period_two_a_backward_whirl_and_no_contact_are_told_apart():
    touching = numpy.where(numpy.cos(numpy.pi * SPEED_HZ * TIME) > 0.5, 20.0, 0.0)
    two = facts(table(whirl(0.9, SPEED_HZ) + whirl(0.15, 0.5 * SPEED_HZ), touching))
    assert (two["regime"], two["period"]) == ("period", 2) and two["contact_fraction"] == pytest.approx(1 / 3, abs=0.01)
    assert [round(frequency) for frequency, _ in two["peaks"][:2]] == [100, 50]
    assert two["peaks"][1][1] == pytest.approx(0.15 * CLEARANCE, rel=1e-3)  # on a line of the spectrum
    dry = facts(table(whirl(1.05, -230.0), numpy.full(len(TIME), 50.0)))
    assert dry["regime"] == "dry_whirl" and dry["whirl"]["frequency"] == pytest.approx(-230.0, rel=1e-6)
    assert facts(table(whirl(0.3, SPEED_HZ)))["regime"] == "no_contact"


@pytest.mark.parametrize("whirl_hz, slip", [(-0.010 * 100 / 3.15e-4, "rolling"), (-150.0, "slipping")])
def test_dry_whirl_slips_or_rolls(whirl_hz, slip):
    # pure rolling: -R Omega/r, R 10 mm, r the radius of the circle. 3175 Hz is sampled as seldom as is needed.
    global TIME
    before, TIME = TIME, numpy.arange(20001) / 4e4
    try:
        found = facts(table(whirl(1.05, whirl_hz), numpy.full(len(TIME), 50.0)), rotor_radius=0.010)
    finally:
        TIME = before
    assert (found["regime"], found["slip"]) == ("dry_whirl", slip)


def test_synchronous_amplitude_and_phase_follow_a_run_up():
    # 50 to 150 Hz in 2 s, forward and backward; x = 1.3 A cos(angle - lag), A and lag known at every speed
    speed = 50.0 + 50.0 * TIME
    angle = 2 * numpy.pi * (50.0 * TIME + 25.0 * TIME ** 2)
    size, lag = 0.2 + 0.002 * (speed - 50.0), 0.01 * (speed - 50.0)
    turning = numpy.exp(1j * (angle - lag))
    made = motion.from_table("made", table(size * (turning + 0.3 / turning), speed_hz=speed, angle=angle), "b", CLEARANCE)
    rows = analyse._up_and_down(made)
    assert list(rows) == ["run-up"]
    speeds, found = rows["run-up"]
    # A grows by 2e-3 a Hz, and 8 turns are 4 to 8 Hz: the middle of a block is known to a tenth of that
    assert numpy.abs(found) == pytest.approx(1.3 * CLEARANCE * (0.2 + 0.002 * (speeds - 50.0)), rel=5e-3)
    assert numpy.angle(found) == pytest.approx(-0.01 * (speeds - 50.0), abs=5e-3)


def test_a_loop_has_the_work_of_its_damper():
    # depth d sin, half a period; N = k depth + c rate loses pi/2 c w d^2 a contact
    k, c, d, w = 1e6, 300.0, 1e-5, 2 * numpy.pi * 50.0
    depth = d * numpy.sin(w * TIME)
    z = (CLEARANCE + depth) / CLEARANCE
    normal = numpy.where(depth > 0, numpy.maximum(k * depth + c * d * w * numpy.cos(w * TIME), 0.0), 0.0)
    made = motion.from_table("made", table(z + 0j, normal), "b", CLEARANCE)
    from amb_rotor.plots import analysis
    figure = analysis.hysteresis(made)
    lost = figure.axes[1].lines[0].get_ydata()
    # the force stops where it would pull: work from there to the end of the depth is not lost, 0.5 d^2 (c w)^2/k of it
    pulled = 0.5 * (c * w * d) ** 2 / k * 2
    assert numpy.median(lost) == pytest.approx(0.5 * numpy.pi * c * w * d ** 2, abs=pulled + 0.02 * c * w * d ** 2)
    assert len(lost) in (99, 100)


def test_measured_sensors_are_carried_to_the_auxiliary_bearing_and_the_tacho_gives_the_angle():
    columns = {"t_s": TIME, "tacho": convert.tacho(TIME, 2 * numpy.pi * SPEED_HZ * TIME + 1.0, numpy.full(len(TIME), SPEED_HZ)),
               "ax_um": numpy.full(len(TIME), 10.0), "ay_um": numpy.zeros(len(TIME)),
               "bx_mm": 0.1 * numpy.cos(2 * numpy.pi * SPEED_HZ * TIME), "by_mm": 0.1 * numpy.sin(2 * numpy.pi * SPEED_HZ * TIME)}
    planes = {"sensor": (-0.1, 0.1), "aux": (-0.15, 0.15)}
    made = motion.from_table("made", columns, "b", CLEARANCE, planes=planes)
    assert made.x == pytest.approx(10e-6 + 1.25 * (1e3 * 1e-6 * columns["bx_mm"] - 10e-6), abs=1e-12)
    assert made.mean_speed == pytest.approx(SPEED_HZ, rel=1e-6) and made.turns == pytest.approx(200.0, rel=1e-4)
    assert made.normal is None and not made.touching.any()


@pytest.fixture(scope="module")
def run_file(tmp_path_factory):
    path = tmp_path_factory.mktemp("run") / "drop.npz"
    assert cli.main(["simulate", str(ROOT / "config/thesis/drop_model.yaml"), "--scenario",
                     str(ROOT / "config/thesis/drop_150_hz.yaml"), "--out", str(path)]) == 0
    return path


def test_a_run_gives_every_picture_of_one_motion_as_png_and_svg(run_file, tmp_path):
    out = tmp_path / "out"
    assert cli.main(["analyse", str(run_file), "--from", "0.4", "--out", str(out), "--json", str(tmp_path / "a.json")]) == 0
    names = {path.name for path in out.iterdir()}
    assert names == {f"{kind}{suffix}" for kind in analyse.SINGLE for suffix in (".png", ".svg")}
    found = json.loads((tmp_path / "a.json").read_text())["motions"]["drop"]
    assert found["whirl"]["frequency"] == pytest.approx(-75.0, abs=1.0)  # figure 4.18


def test_a_bag_is_analysed_as_its_table_is(run_file, tmp_path):
    pytest.importorskip("rosbag")
    assert cli.main(["convert", str(run_file), str(tmp_path / "drop.bag")]) == 0
    words = ["--from", "0.4", "--kind", "orbit"]
    assert cli.main(["analyse", str(run_file), *words, "--out", str(tmp_path / "a"), "--json", str(tmp_path / "a.json")]) == 0
    assert cli.main(["analyse", str(tmp_path / "drop.bag"), *words, "--clearance-m", "0.3e-3", "--out", str(tmp_path / "b"), "--json",
                     str(tmp_path / "b.json")]) == 0
    one, other = (json.loads((tmp_path / name).read_text())["motions"] for name in ("a.json", "b.json"))
    # the bag has no model, so no rotor radius: slip is not known
    assert {**one["drop"], "slip": None} == {**other["drop.bag"], "slip": None}


def test_runs_of_a_data_set_make_a_cascade_a_response_and_a_bifurcation_diagram(tmp_path):
    words = ["analyse", str(ROOT / "config/tutorial/measured")]
    for name in ("steady_2", "steady_3", "steady_4"):
        words += ["--run", name]
    for kind in analyse.SEVERAL:
        words += ["--kind", kind]
    assert cli.main([*words, "--out", str(tmp_path)]) == 0
    assert {path.stem for path in tmp_path.iterdir()} == set(analyse.SEVERAL)


def test_a_point_of_a_sweep_has_the_regime_of_the_sweep(tmp_path):
    path = str(ROOT / "config/thesis/fig_6_2.yaml")
    assert cli.main(["analyse", path, "--at", "frequency_ratio=1.05", "--out", str(tmp_path), "--json", str(tmp_path / "a.json")]) == 0
    found, = json.loads((tmp_path / "a.json").read_text())["motions"].values()
    assert (found["regime"], found["period"]) == ("period", 2)
    assert (found["lanes"]["regime"], found["lanes"]["period"]) == ("period", 2)
    assert found["peaks"][0][0] == pytest.approx(1.05, rel=1e-3)
    assert {path.stem for path in tmp_path.glob("*.png")} == set(analyse.SINGLE)


@pytest.mark.parametrize("frequency, regime", [(1.16, "quasi_periodic"), (1.28, "chaotic"), (0.8, "no_contact")])
def test_section_points_and_the_variational_equation_give_one_regime(frequency, regime, tmp_path):
    # Two ways that share nothing: the points alone (0-1 test, forecast), and the exponent of the lanes' tangent.
    assert cli.main(["analyse", str(ROOT / "config/thesis/fig_6_2.yaml"), "--at", f"frequency_ratio={frequency}", "--kind", "orbit",
                     "--out", str(tmp_path), "--json", str(tmp_path / "a.json")]) == 0
    found, = json.loads((tmp_path / "a.json").read_text())["motions"].values()
    assert found["regime"] == found["lanes"]["regime"] == regime


def test_a_sweep_up_and_down_shows_the_jump(tmp_path):
    text = (ROOT / "config/thesis/fig_6_2.yaml").read_text()
    text = text[:text.index("continuation:")].replace("from: 0.55, to: 1.5, step: 0.0073", "from: 1.12, to: 1.4, count: 5")
    assert "count: 5" in text
    (tmp_path / "s.yaml").write_text(text)
    assert cli.main(["analyse", str(tmp_path / "s.yaml"), "--out", str(tmp_path / "o"), "--json", str(tmp_path / "a.json")]) == 0
    found = json.loads((tmp_path / "a.json").read_text())["motions"]
    up, down = found["up"]["amplitude"], found["down"]["amplitude"][::-1]
    assert up[0] == pytest.approx(down[0], abs=0.01) and up[-1] > 4 * down[-1]
    assert len(found["down"]["jumps"]) == 1
    assert {path.stem for path in (tmp_path / "o").glob("*.svg")} == set(analyse.SEVERAL)


@pytest.mark.parametrize("change, words", [
    ({}, "clearance is not known"),
    ({"t_s": TIME ** 1.5}, "equally spaced"),
    ({"aux_bx_m": numpy.full(len(TIME), numpy.nan)}, "not finite"),
    ({"angle_rad": None}, "needs angle_rad or tacho"),
])
def test_a_table_that_does_not_do_is_refused_by_name(change, words, tmp_path, capsys):
    columns = {**table(whirl(0.3, 100.0)), **change}
    numpy.savez(tmp_path / "t.npz", **{key: column for key, column in columns.items() if column is not None})
    given = ["--clearance-m", "3e-4"] if change else []
    assert cli.main(["analyse", str(tmp_path / "t.npz"), *given, "--out", str(tmp_path / "o")]) == 2
    assert words in capsys.readouterr().err


@pytest.mark.parametrize("words, message", [
    (["config/thesis/fig_6_2.yaml", "--at", "frequency=1"], "is no parameter of"),
    (["config/thesis/fig_6_2.yaml", "--at", "frequency_ratio=fast"], "NAME=VALUE"),
    (["config/thesis/fig_5_7.yaml"], "format"),
    (["config/tutorial/measured"], "has the runs chirp_1"),
    (["config/tutorial/measured", "--run", "steady_2", "--from", "7"], "it covers 0 to"),
    (["config/tutorial/measured", "--run", "step_1", "--kind", "cascade"], "nothing to draw"),
])
def test_bad_input_has_one_message(words, message, capsys, tmp_path):
    words = [str(ROOT / word) if word.startswith("config") else word for word in words]
    assert cli.main(["analyse", *words, "--out", str(tmp_path)]) == 2
    assert message in capsys.readouterr().err


def test_a_motion_that_is_too_short_is_refused():
    with pytest.raises(InputError, match="16 at least"):
        motion.from_table("made", {key: column[:10] for key, column in table(whirl(0.3, 100.0)).items()}, "b", CLEARANCE)
