"""simulate, check, modes, campbell, critical-speeds, margins on the command line; the bindings behind them."""
from __future__ import annotations

import json
import math
import pathlib
import re
import shutil

import pytest

numpy = pytest.importorskip("numpy")
core = pytest.importorskip("amb_rotor._core")

from amb_rotor import cli, modal  # noqa: E402
from amb_rotor.errors import InputError  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]
MODEL = ROOT / "config/thesis/levitation_model.yaml"
ELECTRIC = ROOT / "config/thesis/levitation_electric.yaml"
FLEXIBLE = ROOT / "config/thesis/flexible_model.yaml"
CAMPBELL = ROOT / "config/thesis/campbell_model.yaml"
DROP = ROOT / "config/thesis/drop.yaml"
TABLE = ROOT / "config/thesis/table_4_2"


def scenario(tmp_path, text="") -> pathlib.Path:
    path = tmp_path / "short.yaml"
    path.write_text("format: amb-scenario/1\nname: short\nduration_s: 0.05\nrecord_rate_hz: 10000.0\n"
                    "speed: {type: constant, start_hz: 60.0, initial_angle_rad: 0.0}\nexcitations: []\n"
                    f"faults: []\nstart: settled\n{text}")
    return path


def test_simulate_writes_a_table_and_the_model_beside_it(tmp_path, capsys):
    out = tmp_path / "run.csv"
    assert cli.main(["simulate", str(MODEL), "--scenario", str(scenario(tmp_path)), "--out", str(out),
                     "--json", str(tmp_path / "run.json")]) == 0
    assert capsys.readouterr().out.splitlines()[-1] == f"report: {out}"
    names = out.read_text().splitlines()[0].split(",")
    table = numpy.loadtxt(out, delimiter=",", skiprows=1)
    assert names[0] == "t_s" and {"ax_m", "iby_A", "aux_ax_m", "normal_b_N"} <= set(names)
    assert table.shape == (501, len(names)) and table[-1, 0] == pytest.approx(0.05)
    result = json.loads((tmp_path / "run.json").read_text())
    assert result["status"] == "ok" and result["contacts"] == 0
    assert core.read_model(str(out) + ".model.yaml").hash == result["model_hash"]
    assert not list(tmp_path.glob(".*part*"))


def test_simulate_npz_holds_the_resolved_model_and_overrides_act(tmp_path):
    hashes = set()
    for mass in ("3.36", "4.0"):
        out = tmp_path / f"run_{mass}.npz"
        assert cli.main(["simulate", str(MODEL), "--scenario", str(scenario(tmp_path)), "--out", str(out),
                         "--set", f"rig.rotor.mass_kg={mass}"]) == 0
        with numpy.load(out) as file:
            model = core.parse_model(str(file["model"]), "npz")
            assert model.fields["rig.rotor.mass_kg"] == float(mass)
            assert model.hash == str(file["model_hash"])
            hashes.add(model.hash)
    assert len(hashes) == 2


def test_simulate_takes_the_model_beside_a_scenario(tmp_path, capsys):
    short = scenario(tmp_path)
    assert cli.main(["simulate", str(short)]) == 2
    assert "short_model.yaml" in capsys.readouterr().err
    assert cli.main(["simulate", str(MODEL)]) == 2
    assert "--scenario" in capsys.readouterr().err
    beside = tmp_path / "short_model.yaml"
    beside.write_text(MODEL.read_text())
    short = short.rename(tmp_path / "short_60_hz.yaml")
    one, two = tmp_path / "one.csv", tmp_path / "two.csv"
    assert cli.main(["simulate", str(short), "--out", str(one)]) == 0
    assert capsys.readouterr().out.startswith(f"model {beside}")
    assert cli.main(["simulate", str(MODEL), "--scenario", str(short), "--out", str(two)]) == 0
    assert one.read_text() == two.read_text()


def test_modes_of_a_state_space_controller_are_those_of_the_pid_that_it_is():
    """levitation_electric.yaml has the PID of levitation_model.yaml as a b c d, to 10 digits."""
    law = core.read_model(str(ELECTRIC)).with_overrides(["rig.controller.integrator_gain_A_per_m=0"])
    text = law.text
    for block, end in (("    coil:", "\n"), ("  signal_chain:", "  auxiliary_bearing:")):
        start = text.index(block)
        text = text[:start] + text[text.index(end, start) + (end == "\n"):]
    found = modal.modes(core.parse_model(text, "law"), 60.0)
    wanted = modal.modes(core.read_model(str(MODEL)), 60.0)
    assert [mode.frequency_hz for mode in found] == pytest.approx([mode.frequency_hz for mode in wanted], rel=1e-8)
    assert [mode.damping_ratio for mode in found] == pytest.approx([mode.damping_ratio for mode in wanted], rel=1e-7)


@pytest.mark.parametrize("phase", [0.0, math.pi])
def test_modes_show_that_a_notch_below_the_rigid_modes_is_unstable_unless_it_is_turned(phase):
    """s = j W - pi b S exp(j phase) of the translation, first order in the bandwidth b (unbalance_rejection.hpp)."""
    hz, bandwidth = 40.0, 0.2
    block = f"unbalance_force_rejection: {{bandwidth_hz: {bandwidth}, phase_rad: {phase}, minimum_speed_hz: 10.0, " \
        "displacement_compensation_A_per_m: 0.0, lead_s: 0.0}"
    place = "    derivative_filter_hz: 2000.0      # assumed\n"
    text = MODEL.read_text()
    assert place in text
    found = modal.modes(core.parse_model(text.replace(place, f"{place}    {block}\n"), "notch"), hz)
    s, period, m, ki, ks, kp, kd = 2j * math.pi * hz, 1.0 / 5000.0, 3.36, 19.0, 39700.0, 33458.0, 34.0
    back, pole = numpy.exp(-s * period), math.exp(-2.0 * math.pi * 2000.0 * period)
    law = kp + kd * (1.0 - pole) * (1.0 - back) / period / (1.0 - pole * back)
    chain = numpy.exp(-s * 1e-4) * (1.0 - back) / (s * period) / (1.0 + s / (2.0 * math.pi * 2000.0))
    open_loop = m * s ** 2 - 2.0 * ks
    growth = -math.pi * bandwidth * (open_loop / (open_loop + 2.0 * ki * law * chain) * numpy.exp(1j * phase)).real
    notch = [mode for mode in found if abs(mode.frequency_hz - hz) < 0.2 and mode.whirl == "planar"]
    assert len(notch) == 2 and (growth > 0.1) == (phase == 0.0)
    for mode in notch:  # second order in the bandwidth: b/W = 0.5 %, times a loop that changes over 60 Hz
        assert -mode.damping_ratio * 2.0 * math.pi * mode.frequency_hz == pytest.approx(growth, rel=0.02)


@pytest.mark.parametrize("arguments, complaint", [
    (["--set", "rig.rotor.mas_kg=3"], "rig.rotor.mass_kg"),
    (["--out", "run.xls"], ".npz"),
    (["--set", "rig.rotor.mass_kg=-1"], "above 0"),
])
def test_bad_input_of_simulate_is_one_message(tmp_path, capsys, arguments, complaint):
    assert cli.main(["simulate", str(MODEL), "--scenario", str(scenario(tmp_path)), *arguments]) == 2
    message = capsys.readouterr().err
    assert complaint in message and "Traceback" not in message


def test_a_run_that_does_not_begin_says_why(tmp_path, capsys):
    # nothing this light can be integrated: the run-in fails, and there is no orbit to sum up
    assert cli.main(["simulate", str(MODEL), "--scenario", str(scenario(tmp_path)), "--out", str(tmp_path / "run.npz"),
                     "--set", "rig.rotor.mass_kg=1e-300", "--set", "rig.rotor.transverse_inertia_kg_m2=5e-303",
                     "--set", "rig.rotor.polar_inertia_kg_m2=0", "--set", "rig.unbalance.0.moment_kg_m=0"]) == 1
    told = capsys.readouterr()
    assert "run-in" in told.out and "Traceback" not in told.err


@pytest.mark.parametrize("written, meant, complaint", [
    ("effect: compliant_mount", "effect: compliant_mounts", "the effect is not known; nearest: compliant_mount"),
    ("thickness_m: 0.4e-3", "thickness_m: -0.4e-3", "tolerance_ring.thickness_m = -0.4e-3: must be above 0 m"),
    ("mass_kg: 0.069", "mass_kg: -0.069", "compliant_mount.mass_kg = -0.069"),
])
def test_a_bad_effect_is_told_once_and_by_its_name(written, meant, complaint):
    text = (ROOT / "config/thesis/drop_model.yaml").read_text()
    assert written in text
    with pytest.raises(InputError) as caught:
        core.parse_model(text.replace(written, meant), "model.yaml")
    assert len(caught.value.faults) == 1 and complaint in str(caught.value.faults[0]), caught.value.faults


@pytest.mark.parametrize("arguments, complaint", [
    (["modes", str(MODEL), "--speed", "nan"], "speed_hz = nan"),
    (["margins", str(MODEL), "--speed", "inf"], "speed_hz = inf"),
    (["modes", str(MODEL), "--set", "rig.rotor.mass_kg=1e-300", "--set", "rig.rotor.transverse_inertia_kg_m2=5e-303", "--set",
      "rig.rotor.polar_inertia_kg_m2=0", "--set", "rig.unbalance.0.moment_kg_m=0"], "out of range"),
    (["check", str(MODEL), "--json", "-"], ""),
])
def test_numbers_without_sense_are_bad_input(capsys, arguments, complaint):
    assert cli.main(arguments) == (2 if complaint else 0)
    assert complaint in capsys.readouterr().err


@pytest.mark.parametrize("length", [".nan", "-0.0256"])
def test_a_section_without_length_is_the_only_fault_of_its_rotor(tmp_path, capsys, length):
    path = tmp_path / "rotor.yaml"
    text = (ROOT / "config/thesis/rotor.yaml").read_text()
    path.write_text(text.replace("length_m: 0.0256", f"length_m: {length}", 1))
    assert cli.main(["check", str(path)]) == 2
    told = capsys.readouterr().err.splitlines()
    assert len(told) == 1 and f"sections[0].length_m = {length}: " in told[0], told


def test_the_cores_input_error_is_pythons(tmp_path):
    path = tmp_path / "model.yaml"
    path.write_text(MODEL.read_text().replace("mass_kg: 3.36 ", "mass_kg: -3 ").replace("kp_A_per_m", "kp_A_m"))
    with pytest.raises(InputError) as caught:
        core.read_model(str(path))
    assert len(caught.value.faults) >= 2 and all(str(path) in fault for fault in caught.value.faults)


@pytest.mark.parametrize("path, text", [(MODEL, "amb-model/1"), (DROP, "amb-scenario/1"), (TABLE, "10 measurements of 2"),
                                        (ROOT / "config/thesis/rotor.yaml", "amb-rotor-geometry/1"),
                                        (ROOT / "config/tutorial/measured", "9 runs")])
def test_check_says_that_a_file_is_valid(capsys, path, text):
    assert cli.main(["check", str(path)]) == 0
    assert text in capsys.readouterr().out


def test_check_tells_every_fault_with_its_line(tmp_path, capsys):
    path = scenario(tmp_path, "more: 1\nnonsense: 2\n")
    assert cli.main(["check", str(path), "--json", str(tmp_path / "c.json")]) == 2
    message = capsys.readouterr().err
    assert "more" in message and "nonsense" in message and f"{path}:9" in message
    assert json.loads((tmp_path / "c.json").read_text())["valid"] is False


def test_modes_of_an_equivalent_bearing_are_the_closed_form(tmp_path):
    model = core.read_modes_dataset(str(TABLE)).belief
    fields = model.fields
    stiffness, damping = fields["rig.amb.stiffness_N_per_m"], fields["rig.amb.damping_N_s_per_m"]
    found = modal.modes(model, 0.0)
    natural = [math.sqrt(2 * stiffness / fields["rig.rotor.mass_kg"]) / (2 * math.pi),
               math.sqrt(2 * stiffness * fields["rig.planes.amb.b"] ** 2 / fields["rig.rotor.transverse_inertia_kg_m2"])
               / (2 * math.pi)]
    assert modal.distinct([mode.frequency_hz for mode in found], 2) == pytest.approx(natural, rel=1e-6)
    ratio = 2 * damping / (2 * math.sqrt(2 * stiffness * fields["rig.rotor.mass_kg"]))
    assert found[0].damping_ratio == pytest.approx(ratio, rel=1e-6) and found[0].whirl == "planar"


@pytest.mark.parametrize("path, overrides", [
    (MODEL, []),
    # the steps of the converters and the slow integrator are no ringing
    (ELECTRIC, ["rig.signal_chain.ad.bits=30", "rig.signal_chain.da.bits=30",
                "rig.controller.integrator_gain_A_per_m=0"])])
def test_modes_of_the_sampled_loop_ring_as_the_run_does(tmp_path, path, overrides):
    """The decay of a push in the event-accurate run has the frequency and damping of the linearised loop."""
    model = core.read_model(str(path)).with_overrides(["rig.gravity_m_s2=0", "rig.unbalance.0.moment_kg_m=0",
                                                       "rig.rotor.polar_inertia_kg_m2=0"] + overrides)
    push = scenario(tmp_path).read_text().replace("faults: []", "faults: [{type: force_impulse, start_s: 0.001, "
           "duration_s: 0.001, force_N: 30.0, plane_z_m: 0.0, direction_rad: 0.0}]")
    columns = core.simulate(model, core.parse_scenario(push, "push"))["columns"]
    t, x = columns["t_s"], columns["position_ax_m"]
    late = (t > 0.006) & (t < 0.03)
    mode = next(mode for mode in modal.modes(model, 60.0) if mode.shape["amb"][0] * mode.shape["amb"][2] != 0)
    rate, omega = mode.damping_ratio * mode.frequency_hz * 2 * math.pi, mode.damped_frequency_hz * 2 * math.pi
    basis = numpy.column_stack([numpy.exp(-rate * t[late]) * numpy.cos(omega * t[late]),
                                numpy.exp(-rate * t[late]) * numpy.sin(omega * t[late])])
    fitted = basis @ numpy.linalg.lstsq(basis, x[late], rcond=None)[0]
    # 2 %: the other modes of the loop (filter, amplifier) have not died away completely
    assert numpy.max(numpy.abs(fitted - x[late])) < 0.02 * numpy.max(numpy.abs(x[late]))


def test_bending_modes_that_the_samples_fold_stand_at_their_own_frequency_and_whirl():
    """5 kHz see 3.0, 5.2 and 7.3 kHz as 2.0, 0.17 and 2.3 kHz, the first with its whirl reversed."""
    levitated, held, rigid = core.read_model(str(FLEXIBLE)), core.read_model(str(CAMPBELL)), core.read_model(str(MODEL))
    for hz in (0.0, 100.0):
        wanted = [mode for mode in modal.modes(held, hz) if mode.frequency_hz > 1000.0]
        found = [mode for mode in modal.modes(levitated, hz) if mode.frequency_hz > 1000.0]
        # springs of the static stiffness beside the loop's force at such a frequency: 1e-3 of a mode that hardly feels either
        assert [mode.frequency_hz for mode in found] == pytest.approx([mode.frequency_hz for mode in wanted], rel=1e-3)
        assert [mode.whirl for mode in found] == [mode.whirl for mode in wanted]
        assert all(0.0 < mode.damping_ratio < 0.005 for mode in found), "0.002 of the shaft's and what the loop adds"
        slow = [mode for mode in modal.modes(levitated, hz) if mode.frequency_hz < 1000.0]
        # a rotor that gives way by its bending in the bearings: below 1 % at a thirtieth of its frequency
        assert [mode.frequency_hz for mode in slow] == pytest.approx([mode.frequency_hz for mode in modal.modes(rigid, hz)], rel=0.01)
    speeds, wanted = (modal.critical_speeds(model, 500.0) for model in (levitated, rigid))
    assert [one["whirl"] for one in speeds] == [one["whirl"] for one in wanted] == ["planar", "backward", "forward"]
    assert [one["speed_hz"] for one in speeds] == pytest.approx([one["speed_hz"] for one in wanted], rel=0.02)


def test_gyroscopic_modes_part_into_forward_and_backward():
    model = core.read_model(str(MODEL))
    whirls = {mode.whirl: mode.frequency_hz for mode in modal.modes(model, 200.0) if mode.whirl != "planar"}
    assert whirls["forward"] > whirls["backward"]


def test_a_rotor_that_reaches_a_magnet_ends_the_run(tmp_path, capsys):
    """Auxiliary bearings of another unit, 33.8 N/um as 33.8: they are remarked, and hold nothing."""
    found = tmp_path / "run.json"
    assert cli.main(["simulate", str(MODEL), "--scenario", str(DROP), "--out", str(tmp_path / "run.npz"), "--json", str(found),
                     "--set", "rig.auxiliary_bearing.contact.stiffness_N_per_m=33.8"]) == 1
    out = capsys.readouterr().out
    assert "remark: rig.auxiliary_bearing.contact.stiffness_N_per_m = 33.8: mostly from" in out
    assert "the rotor reached the magnets of bearing" in out
    summary = json.loads(found.read_text())
    hit = summary["magnet_hit"]
    assert summary["status"] == "magnet_hit" and hit["bearing"] in ("a", "b")
    assert hit["air_gap_m"] == 0.75e-3 <= hit["displacement_m"] < 0.76e-3
    assert 0.1 + math.sqrt(2 * 0.72e-3 / 9.81) < hit["time_s"] == summary["time_s"] < 0.3  # a fall, which the damper slows
    assert "motion" not in summary, "it did not come to the second half of the failure"


def test_check_remarks_what_is_of_another_unit(tmp_path, capsys):
    text = DROP.read_text().replace("start_hz: 136.5", "start_hz: 8190.0")  # turns a minute
    (tmp_path / "drop.yaml").write_text(text)
    assert cli.main(["check", str(tmp_path / "drop.yaml")]) == 0
    line = 1 + text[:text.index("speed: {")].count("\n")
    assert f"remark: {tmp_path / 'drop.yaml'}:{line}: speed.start_hz = 8190.0: " in capsys.readouterr().out
    (tmp_path / "model.yaml").write_text(MODEL.read_text().replace("stiffness_N_per_m: 3.38e7", "stiffness_N_per_m: 33.8"))
    assert cli.main(["check", str(tmp_path / "model.yaml")]) == 0
    assert "33.8 N/um are 3.38e7 N/m" in capsys.readouterr().out
    shutil.copytree(ROOT / "test/data/dataset_tiny", tmp_path / "set")
    text = (tmp_path / "set" / "dataset.yaml").read_text()
    (tmp_path / "set" / "dataset.yaml").write_text(re.sub(r"(contact: .*stiffness_N_per_m: )[0-9.e+]+", r"\g<1>33.8", text))
    assert cli.main(["check", str(tmp_path / "set")]) == 0
    out, line = capsys.readouterr().out, 1 + text[:text.index("contact: {model")].count("\n")
    assert "33.8 N/um are 3.38e7 N/m" in out
    assert f"remark: {tmp_path}/set/dataset.yaml:{line}: rig.auxiliary_bearing.contact.stiffness_N_per_m = 33.8: " in out


def test_check_remarks_what_a_diagnosis_will_lack(tmp_path, capsys):
    shutil.copytree(ROOT / "test/data/dataset_tiny", tmp_path / "set")
    path = tmp_path / "set" / "dataset.yaml"
    assert cli.main(["check", str(path.parent)]) == 0
    assert "no run has use" not in capsys.readouterr().out
    path.write_text(path.read_text().replace("use: validate", "use: fit"))
    assert cli.main(["check", str(path.parent)]) == 0
    out = capsys.readouterr().out
    assert "remark: amb diagnose will refuse it: no run has use: validate: nothing is held out to judge an effect by" in out
    assert "use: fit:" not in out


@pytest.mark.parametrize("path", sorted(path for path in (ROOT / "config").rglob("*.yaml")
                                        if re.match(r"(#.*\n)*format: amb-(model|scenario)/1", path.read_text())),
                         ids=lambda path: path.stem)
def test_nothing_is_odd_in_our_own_files(path, capsys):
    assert cli.main(["check", str(path)]) == 0
    assert "remark" not in capsys.readouterr().out


def test_an_unstable_loop_is_said_to_be(tmp_path, capsys):
    assert cli.main(["margins", str(MODEL), "--set", "rig.controller.kd_A_s_per_m=0", "--out", str(tmp_path)]) == 1
    out = capsys.readouterr().out
    assert "NOT STABLE" in out and "zone none" in out and "zone A" not in out


def test_check_remarks_a_loop_that_is_sampled_too_slowly(tmp_path, capsys):
    electric = MODEL.parent / "levitation_electric.yaml"
    assert cli.main(["check", str(electric)]) == 0
    assert "NOT STABLE" not in capsys.readouterr().out
    text = electric.read_text()
    slow = tmp_path / "slow.yaml"
    slow.write_text(re.sub(r"sample_rate_hz: [0-9.]+", "sample_rate_hz: 800.0", text))
    assert cli.main(["check", str(slow)]) == 0
    assert "NOT STABLE" in capsys.readouterr().out


def test_margins_campbell_and_critical_speeds(tmp_path, capsys):
    assert cli.main(["margins", str(MODEL), "--out", str(tmp_path), "--json", str(tmp_path / "m.json")]) == 0
    margins = json.loads((tmp_path / "m.json").read_text())
    assert margins["zone"] == "A" and 1.0 < margins["peak"] < 3.0 and len(margins["loops"]) == 4
    # k1 near rest is Ki kp - Ks (thesis 3.28): at 1 Hz what depends on the frequency is below 1e-4 of it
    bearings = margins["equivalent"]
    assert bearings["frequency_hz"][0] == pytest.approx(1.0)
    for axis in modal.AXES:
        assert bearings["stiffness_N_per_m"][axis][0] == pytest.approx(19.0 * 33458.0 - 39700.0, rel=1e-4)
        assert len(bearings["damping_N_s_per_m"][axis]) == len(bearings["frequency_hz"])
    assert (tmp_path / "equivalent.png").stat().st_size > 10000 and (tmp_path / "sensitivity.svg").stat().st_size > 10000
    assert "equivalent stiffness k1" in capsys.readouterr().out
    assert cli.main(["campbell", str(MODEL), "--points", "5", "--out", str(tmp_path), "--json", "-"]) == 0
    assert (tmp_path / "campbell.png").stat().st_size > 10000 and (tmp_path / "campbell.svg").stat().st_size > 10000
    assert cli.main(["critical-speeds", str(MODEL), "--json", str(tmp_path / "k.json")]) == 0
    found = json.loads((tmp_path / "k.json").read_text())["critical_speeds"]
    for one in found:
        frequencies = [mode.damped_frequency_hz for mode in modal.modes(core.read_model(str(MODEL)), one["speed_hz"])]
        assert min(abs(value - one["speed_hz"]) for value in frequencies) < 1e-3
    assert {one["whirl"] for one in found} == {"planar", "backward", "forward"}
    capsys.readouterr()


def test_modes_json_has_the_fields_that_others_rely_on(tmp_path):
    assert cli.main(["modes", str(MODEL), "--speed", "0", "--speed", "100", "--json", str(tmp_path / "m.json")]) == 0
    speeds = json.loads((tmp_path / "m.json").read_text())["speeds"]
    assert [row["speed_hz"] for row in speeds] == [0.0, 100.0]
    assert {"frequency_hz", "damping_ratio", "whirl"} <= set(speeds[1]["modes"][0])
