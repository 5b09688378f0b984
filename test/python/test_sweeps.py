"""Sweeps: scores, intervals and summaries on cases with a known answer."""
from __future__ import annotations

import json
import pathlib
import subprocess
import sys
import time

import numpy
import pytest

from amb_rotor import _core, cli
from amb_rotor.cli import sweep as command
from amb_rotor.errors import InputError
from amb_rotor.sweeps import basin, figures, magnet, probability, search

ROOT = pathlib.Path(__file__).resolve().parents[2]
FILES = sorted((ROOT / "config" / "thesis").glob("search_*.yaml"))


def test_wilson_interval_against_published_values():
    # Newcombe, Statistics in Medicine 17 (1998), table I: 81/263, 15/148, 0/20, 1/29, to four digits.
    for hits, samples, low, high in ((81, 263, 0.2553, 0.3662), (15, 148, 0.0624, 0.1605), (0, 20, 0.0, 0.1611),
                                     (1, 29, 0.0061, 0.1718)):
        assert probability.wilson(hits, samples) == pytest.approx((low, high), abs=5e-5)


def test_paired_error_counts_only_what_changed():
    before = numpy.array([True] * 50 + [False] * 50)
    assert probability.paired_error(before, before) == 0.0
    after = before.copy()
    after[:10] = False  # 10 of 100 better, none worse: sqrt(10 - 100/100)/100
    assert probability.paired_error(before, after) == pytest.approx(0.03)


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_the_files_of_searches_are_valid(path):
    assert any(motion is not None for motion in search.published(search.read_search(path)))


def test_agreement_counts_the_published_motion_only_inside_its_ranges():
    found = search.read_search(ROOT / "config" / "thesis" / "search_6_2.yaml")
    motions = search.published(found)
    right = numpy.array([{"period_1": 1, "period_2": 2, "aperiodic": 0, None: 7}[motion] for motion in motions])
    total = sum(motion is not None for motion in motions)
    assert search.agreement(found, right) == total
    right[0] = 3
    assert search.agreement(found, right) == total - 1


def test_what_diverges_is_no_aperiodic_motion_and_contact_counts_where_it_is_asked_for():
    found = search.read_search(ROOT / "config" / "thesis" / "search_6_2.yaml")
    # Friction of 1 drives a backward whirl out of all bounds (far above the corrected 5.20); chaos at 1.28 touches now and
    # then; at 0.55 nothing touches; a bearing displaced by 1.2 is always touched.
    found.values = numpy.array([0.55, 1.28])
    found.grid = {"friction": [], "misalignment": [], "misalignment_angle_deg": [], "x": [], "vy": []}
    codes = search.run_points(found, numpy.array([[1.0, 0.0, 230.0, 2.0, -8.0], [0.015, 0.62, 230.0, 0.0, 0.0],
                                                  [0.015, 1.2, 230.0, 0.0, 0.0]]))
    assert codes[0].tolist() == [search.DIVERGED] * 2
    assert codes[1].tolist() == [1, search.IMPACTS] and codes[2][0] == 1 + search.ALWAYS
    # Hertz contact and friction of 0.24: a whirl of 126 turns a turn, a radian a step of 800 (an artefact from there on).
    found.contact, found.parameters = "hertz", {"damping": 0.0347, "eccentricity": 0.0973, "hertz_stiffness": 605.05,
                                                "hertz_damping": 0.4794, "friction": 0.2386}
    found.values, found.run = numpy.array([0.55]), {"turns": 200, "kept_turns": 100, "steps_per_turn": 800}
    found.grid = {"x": [], "y": [], "vx": [], "vy": []}
    assert search.run_points(found, numpy.array([[-0.0519, -2.0, 1.8268, -1.1007]])).tolist() == [[search.DIVERGED]]
    kinds = {name: shows(codes).tolist() for name, shows in search.MOTIONS.items()}
    assert kinds["aperiodic"] == [[False, False], [False, True], [False, False]]
    assert kinds["aperiodic_with_impacts"] == kinds["aperiodic"] and kinds["period_1"][2][0]
    assert not any(any(row) for row in kinds["aperiodic_always_in_contact"]) and not kinds["period_8_or_more"][0][0]


def test_a_search_file_with_a_wrong_motion_is_refused(tmp_path):
    text = (ROOT / "config/thesis/search_6_2.yaml").read_text().replace("motion: period_1}", "motion: period_77}", 1)
    (tmp_path / "a.yaml").write_text(text)
    with pytest.raises(InputError, match="period_77"):
        search.read_search(tmp_path / "a.yaml")


def test_ranges_join_equal_motions():
    lines = command.ranges([1.0, 2.0, 3.0], ["period", "period", "chaotic"], [2, 2, 0])
    assert [line.split()[-2:] for line in lines] == [["period", "2"], ["1", "chaotic"]]


# ---- figures of single motions
FIGURES = [path for path in sorted((ROOT / "config" / "thesis").glob("fig_*.yaml"))
           if "amb-figure/1" in path.read_text()]


@pytest.mark.parametrize("path", FIGURES, ids=lambda path: path.stem)
def test_the_files_of_figures_are_valid(path):
    assert figures.read_figure(path)["name"] == path.stem


def test_a_figure_file_names_all_its_faults(tmp_path):
    text = (ROOT / "config/thesis/fig_5_7.yaml").read_text()
    (tmp_path / "a.yaml").write_text(text.replace("title:", "tittle:"))
    with pytest.raises(InputError, match="(?s)title: the key is missing.*tittle"):
        figures.read_figure(tmp_path / "a.yaml")
    (tmp_path / "b.yaml").write_text(text.replace("kept_turns: 400", "kept_turns: 40000"))
    with pytest.raises(InputError, match="kept_turns"):
        figures.read_figure(tmp_path / "b.yaml")


def test_order_amplitude_of_a_known_signal():
    angle = 2 * numpy.pi * numpy.arange(8 * 32) / 32
    signal = 0.3 + 0.7 * numpy.cos(angle + 0.4) + 0.2 * numpy.sin(0.5 * angle)
    assert figures.order_amplitude(signal, 32, 1.0) == pytest.approx(0.7, abs=1e-12)  # whole turns: orthogonal
    assert figures.order_amplitude(signal, 32, 0.5) == pytest.approx(0.2, abs=1e-12)
    assert figures.order_amplitude(signal, 32, 2.0) == pytest.approx(0.0, abs=1e-12)


def test_a_jump_is_no_steep_slope():
    slope = 1.0 / (1.02 - numpy.linspace(0.5, 1.0, 51))
    assert not figures.jumps(numpy.linspace(0.5, 1.0, 51), slope)
    slope[30:] -= 1.0
    assert [round(jump[0], 2) for jump in figures.jumps(numpy.linspace(0.5, 1.0, 51), slope)] == [0.80]


def test_the_impact_of_figure_3_16_keeps_energy_and_gives_hunt_and_crossleys_restitution():
    found = figures.impact(figures.read_figure(ROOT / "config/thesis/fig_3_16.yaml"))
    before, behind = found["speed_before_m_s"], found["speed_behind_m_s"]
    lost = 0.5 * 3.36 * (before ** 2 - behind ** 2)
    # The first and last sample lie up to a sample inside the contact: 1e-3 of the loop.
    assert found["lost_J"] == pytest.approx(lost, rel=5e-3)
    # Small speeds: 1 - a v (Hunt and Crossley 1975); the next term of the series is (a v)^2, 5e-3.
    assert found["restitution"] == pytest.approx(1.0 - 5.0 * before, abs=7e-3)


def test_the_magnet_of_figure_3_9_pulls_by_the_square_of_current_over_gap(tmp_path, capsys):
    path = ROOT / "config/thesis/fig_3_9.yaml"
    figure = magnet.read(path)
    one = _core.magnet_pull(**figure["magnet"], current_A=1.0, air_gap_m=0.5e-3)
    # 350^2 4e-7 pi 0.0016/(4 0.0005^2), and "proportional to i^2 and g^-2"
    assert one == pytest.approx(246.3, abs=0.05)
    other = _core.magnet_pull(**figure["magnet"], current_A=2.0, air_gap_m=0.2e-3)
    assert other == pytest.approx(one * 4.0 * 2.5 ** 2, rel=1e-12)
    assert cli.main(["sweep", str(path), "--out", str(tmp_path / "f")]) == 0
    # what the iron carries pulls B^2 A/mu0 at most, and the grid meets that to one of its steps, 2.5 %
    carried = 1.5 ** 2 * 0.0016 / (4e-7 * numpy.pi)
    table = numpy.loadtxt(tmp_path / "f" / "data.csv", delimiter=",", skiprows=1)
    assert 0.95 * carried < table[table[:, 3] <= 1.5, 2].max() <= carried
    assert "flux density up to 2.199 T" in capsys.readouterr().out


def test_the_slopes_of_two_magnets_are_the_stiffnesses_that_a_model_file_gets(tmp_path):
    text = (ROOT / "config/thesis/levitation_model.yaml").read_text().splitlines()
    drop = ("displacement_stiffness", "bias_flux_density")
    text = [line for line in text if not line.strip().startswith(drop)]
    text = ["    magnet: {windings: 170.0, pole_area_m2: 2.25e-4, force_angle_rad: 0.3927}"
            if line.strip().startswith("current_stiffness") else line for line in text]
    (tmp_path / "m.yaml").write_text("\n".join(text))
    fields = _core.read_model(str(tmp_path / "m.yaml")).fields
    one, bias, gap = {"windings": 170.0, "pole_area_m2": 2.25e-4, "force_angle_rad": 0.3927}, 2.5, 0.75e-3

    def force(current, position):
        return _core.magnet_pull(**one, current_A=bias + current, air_gap_m=gap - position) \
            - _core.magnet_pull(**one, current_A=bias - current, air_gap_m=gap + position)

    # central differences of 1e-4 of the scales: 1e-8
    ki, ks = force(1e-4, 0.0) / 1e-4, force(0.0, 1e-7) / 1e-7
    assert fields["rig.amb.current_stiffness_N_per_A"] == pytest.approx(ki, rel=1e-6)
    assert fields["rig.amb.displacement_stiffness_N_per_m"] == pytest.approx(ks, rel=1e-6)
    assert fields["rig.amb.bias_flux_density_T"] == pytest.approx(_core.magnet_flux_density(170.0, bias, gap), rel=1e-12)


def test_run_up_of_the_centred_rotor_is_the_closed_form():
    figure = figures.read_figure(ROOT / "config/thesis/fig_5_3.yaml")
    figure["frequency_ratio"] = numpy.linspace(0.8, 1.1, 4)
    found = figures.response(figure)
    assert found["up"][0] == pytest.approx(found["free"][0], abs=1e-6)  # 200 turns of transient: e^-27
    rub = max(radius for radius, _ in found["rub"][2])
    assert found["up_contact"][2] == pytest.approx(1.0) and found["up"][2] == pytest.approx(rub, abs=1e-4)
    # At 1.1 both motions hold: which one is there depends on where the rotor comes from.
    assert found["up"][3] > 1.0 and found["down"][3] == pytest.approx(found["free"][3], abs=1e-6)


def test_figure_6_4_is_a_cascade_of_period_doublings():
    sweep = _core.BasicSweep(str(ROOT / "config/thesis/fig_6_4.yaml"))
    values = numpy.asarray(sweep.axes[0][1])
    # Inside the ranges of doc/thesis.md, away from their ends: the thesis's 2 to 13.4, 4 to 15.6, then 8 and chaos.
    for stiffness, regime, period in ((0.625, "period", 1), (8.0, "period", 2), (14.5, "period", 4), (16.0, "period", 8),
                                      (19.0, "chaotic", 0)):
        found = sweep.run(int(numpy.argmin(abs(values - stiffness))), 1)
        assert (found["regime"][0], found["period"][0]) == (regime, period), stiffness


# ---- files with a fault
@pytest.mark.parametrize("name, old, new, message", [
    ("basin_knock", "steps_per_turn: 120", "step_per_turn: 120", "19: run.step_per_turn = 120: the key is not known here; nearest: steps_per_turn"),
    ("basin_knock", "friction: 0.15", "friction: a lot", "11: parameters.friction = a lot: must be a finite number"),
    ("basin_knock", "contact: linear", "contact: lineer", "7: contact = lineer: is none of linear, hertz"),
    ("basin_knock", "speed: {from: 0.0, to: 4.0, count: 121}", "speed: {from: 0.0, to: 4.0}", "18: speed: a list of numbers"),
    ("dry_whirl_probability", "friction: {uniform: [0.02, 0.3]}", "friction: {uniform: [0.3]}", "friction.uniform: must be [least"),
    ("dry_whirl_probability", "{friction: 0.8}", "{frictoin: 0.8}", "frictoin = 0.8: the key is not known here; nearest: friction"),
    ("dry_whirl_probability", "turns: 160,", "turns: x,", "run.turns = x: must be a whole number"),
    ("search_5_10", "contact: hertz", "contact: herz", "contact = herz: is none of"),
    ("search_5_10", "kept_turns: 48", "kept_turns: 4800", "run.kept_turns = 4800: at most `turns`"),
    ("search_5_10", "parameter: frequency_ratio", "parameter: frequency", "swept.parameter = frequency: is none of"),
    ("search_5_10", "initial: [0, 0, 0, 0]", "initial: [0, 0]", "initial: must be [x, y, vx, vy]"),
    ("search_5_10", "hertz_damping: 1.286", "contact_stiffness: 13", "contact_stiffness = 13: the key is not known here"),
    ("fig_5_7", "contact: linear", "contact: lin", "contact = lin: is none of"),
    ("fig_5_7", "damping: 0.0347", "dampping: 0.0347", "parameters.dampping = 0.0347: the key is not known here; nearest: damping"),
    ("fig_5_7", "damping: 0.0347", "damping: 0.0347\n  damping: 0.1", "parameters.damping = 0.1: is there twice"),
    ("fig_5_13", "time: [400, 500]", "time: [500, 400]", "time: must be [from, to]"),
    ("fig_5_16", "count: 47", "cuont: 47", "frequency_ratio: a list of numbers"),
    ("fig_3_16", "clearance_m:", "clearence_m:", "scale.clearance_m: the key is missing"),
    ("fig_3_9", "iron_T: 1.5", "iron_T: -1.5", "iron_T = -1.5: must be above 0"),
    ("drop_map_150_hz", "damping_N_s_per_m: [150.0", "dampping: [150.0", "dampping: the key is not known here"),
    ("drop_map_150_hz", "motion_from_s: 0.4", "motion_from_s: soon", "motion_from_s = soon: must be at least 0"),
])
def test_a_fault_is_told_with_line_key_value_and_rule(name, old, new, message, tmp_path, capsys):
    text = (ROOT / "config/thesis" / f"{name}.yaml").read_text()
    assert old in text
    text = text.replace(old, new, 1)
    for file in ("drop_model.yaml", "drop_150_hz.yaml"):
        text = text.replace(f" {file}", f" {ROOT}/config/thesis/{file}")
    (tmp_path / "f.yaml").write_text(text)
    # `amb check` and the command say the same.
    assert cli.main(["check", str(tmp_path / "f.yaml")]) == 2
    told = capsys.readouterr().err
    assert message in told and f"{tmp_path}/f.yaml:" in told
    assert cli.main(["sweep", str(tmp_path / "f.yaml"), "--out", str(tmp_path / "o")]) == 2
    assert capsys.readouterr().err.splitlines()[0].split(": ", 1)[1] == told.splitlines()[0].split(": ", 1)[1]


@pytest.mark.parametrize("path", sorted((ROOT / "config" / "thesis").glob("*.yaml")), ids=lambda path: path.stem)
def test_the_files_of_the_thesis_are_valid(path, capsys):
    assert cli.main(["check", str(path)]) == 0, capsys.readouterr().err


# ---- searches with many unstated values
def test_a_sampled_search_finds_a_known_value():
    found = search.read_search(ROOT / "config" / "thesis" / "search_6_4_wide.yaml")
    # Without contact up to eccentricity e the motion is of period 1; "aperiodic" nowhere: the score is known.
    found.values = numpy.array([0.6, 1.0])
    found.expected = [(0.5, 0.7, "period_1"), (0.9, 1.1, "aperiodic")]
    found.grid = {"frequency_ratio": numpy.array([0.3, 0.5]), "eccentricity": numpy.array([0.01, 0.05])}
    found.sampling = {"samples": 8, "seed": 1, "refinements": 1}
    points, hits, scores = search.run_sampled(found)
    assert len(points) == search.sampled_size(found) == 16
    assert (hits == 1).all() and scores == pytest.approx(0.5)
    assert (points.min(axis=0) >= [0.3, 0.01]).all() and (points.max(axis=0) <= [0.5, 0.05]).all()


# ---- bifurcation diagrams and maps
SWEPT = {"frequency_ratio": (0.9, 1.3), "support_stiffness": (0.8, 1.2), "contact_stiffness": (5.0, 20.0), "friction": (0.0, 0.05),
         "clearance": (0.8, 1.2), "misalignment": (0.5, 0.7), "eccentricity": (0.05, 0.15), "damping": (0.02, 0.1)}


def swept_file(*names: str) -> str:
    values = {"frequency_ratio": 1.05, "damping": 0.0347, "support_stiffness": 1.0, "eccentricity": 0.0973, "friction": 0.015,
              "contact_stiffness": 13.68, "friction_sign": 1, "misalignment": 0.62, "misalignment_angle_deg": 230,
              "unbalance_phase_deg": 0}
    fixed = ", ".join(f"{name}: {value}" for name, value in values.items() if name not in names)
    axes = "".join(f"  - {{parameter: {name}, from: {SWEPT[name][0]}, to: {SWEPT[name][1]}, count: 4}}\n" for name in names)
    return f"""format: amb-sweep/1
name: swept
title: a test
source: a test
machine: basic
contact: linear
friction_law: spin
parameters: {{{fixed}}}
initial: {{x: 0.0, y: 0.0, vx: 0.0, vy: 0.0}}
swept:
{axes}run: {{turns: 100, kept_turns: 20, steps_per_turn: 140}}
"""


@pytest.mark.parametrize("names", [*((name,) for name in SWEPT), ("clearance", "friction"), ("misalignment", "eccentricity")],
                         ids=lambda names: "-".join(names))
def test_any_parameter_makes_a_bifurcation_diagram_and_any_two_a_map(names, tmp_path):
    (tmp_path / "s.yaml").write_text(swept_file(*names))
    assert cli.main(["sweep", str(tmp_path / "s.yaml"), "--out", str(tmp_path), "--json", str(tmp_path / "p.json")]) == 0
    stem = "bifurcation" if len(names) == 1 else "regime_map"
    assert all((tmp_path / f"{stem}{suffix}").stat().st_size > 5000 for suffix in (".png", ".svg"))
    points = json.loads((tmp_path / "p.json").read_text())["points"]
    assert len(points) == 4 ** len(names)
    for name in names:
        shown = sorted({point["parameters"][name] for point in points})
        assert shown == pytest.approx(numpy.linspace(*SWEPT[name], 4).tolist(), rel=1e-12)
    assert len({(point["regime"], round(point["max_radius"], 6)) for point in points}) > 1, "nothing changed with it"


# ---- maps
SMALL_MAP = """format: amb-sweep/1
name: small
title: small
source: a test
machine: basic
contact: linear
friction_law: spin
parameters: {damping: 0.0347, support_stiffness: 1.0, eccentricity: 0.0973, contact_stiffness: 13.68, friction_sign: 1,
             misalignment: 0.0, misalignment_angle_deg: 0, unbalance_phase_deg: 0}
initial: {x: 1.2809, y: 0.0, vx: 0.0, vy: -2.5618}
swept:
  - {parameter: friction, from: 0.0, to: 0.05, count: 160}
  - {parameter: frequency_ratio, from: 0.9, to: 1.8, count: 160}
run: {turns: 20, kept_turns: 8, steps_per_turn: 112}
"""


def test_a_map_killed_half_way_goes_on_and_is_the_same(tmp_path):
    (tmp_path / "map.yaml").write_text(SMALL_MAP)
    assert cli.main(["sweep", str(tmp_path / "map.yaml"), "--out", str(tmp_path / "whole")]) == 0
    killed = subprocess.Popen([sys.executable, "-P", "-m", "amb_rotor", "sweep", str(tmp_path / "map.yaml"), "--out",
                               str(tmp_path / "killed")], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    parts = tmp_path / "killed" / "parts"
    deadline = time.monotonic() + 60.0
    while len(list(parts.glob("part_*.npz"))) < 2 and time.monotonic() < deadline and killed.poll() is None:
        time.sleep(0.01)
    killed.kill()
    killed.wait()
    there = {path.name: path.stat().st_mtime_ns for path in parts.glob("part_*.npz")}
    assert 2 <= len(there) < 7, "it was to be killed half way through its 7 chunks"
    assert cli.main(["sweep", str(tmp_path / "map.yaml"), "--out", str(tmp_path / "killed"), "--resume"]) == 0
    for name, written in there.items():
        assert (parts / name).stat().st_mtime_ns == written, "a chunk that was there was computed again"
    assert (tmp_path / "killed" / "points.csv").read_bytes() == (tmp_path / "whole" / "points.csv").read_bytes()


def test_dry_whirl_of_a_map_lies_above_its_closed_form(tmp_path):
    (tmp_path / "map.yaml").write_text(SMALL_MAP.replace("count: 160", "count: 30").replace("turns: 20", "turns: 240"))
    sweep = _core.BasicSweep(str(tmp_path / "map.yaml"))
    border = command._whirl_border(sweep)
    assert border == pytest.approx(0.0347 * 2 / 3, rel=1e-3)
    regimes = numpy.array(sweep.run(0, sweep.size)["regime"]).reshape(30, 30)
    friction = numpy.asarray(sweep.axes[0][1])
    whirls = numpy.isin(regimes, ("dry_whirl", "diverged"))
    # The closed form leaves the unbalance out: 0.0973 of a clearance against a circle of 1.28.
    assert whirls[friction > 1.1 * border].all() and not whirls[friction < 0.9 * border].any()
    lines = command.border_report(sweep.axes, regimes.ravel(), (numpy.asarray(sweep.axes[1][1]), numpy.full(30, border)))
    assert "100.0 % of the points above" in lines[0] and "0.0 % of those below" in lines[0]


# ---- probabilities
def test_a_knock_in_a_wider_bearing_is_the_same_knock():
    # The speed of a knock is that of a hit in m/s: without contact the motion over its own clearance is smaller by it.
    document = probability.read_probability(ROOT / "config" / "thesis" / "dry_whirl_probability.yaml")
    columns = {key: numpy.array([0.0 if key == "friction" else spec if isinstance(spec, float) else 1.5])
               for key, spec in document["parameters"].items()}
    far = {}
    for clearance in (1.0, 1.25):
        columns["clearance"] = numpy.array([clearance])
        found = _core.run_basic_lanes(columns, numpy.array([[0.0, 0.0, 0.3, 0.0]]), friction="sliding", turns_skipped=0,
                                      turns_kept=8, steps_per_turn=200)
        far[clearance] = found["max_radius"][0]
    assert far[1.0] < 1.0 and far[1.25] == pytest.approx(far[1.0] / 1.25, rel=1e-12)


def test_probability_of_a_drop_counts_what_its_runs_show(tmp_path, capsys):
    # Friction 0.002 whirls never, and at 0.15 and 150 Hz this machine does (doc/thesis.md): a change by the factor decides.
    text = (ROOT / "config/thesis/drop_probability.yaml").read_text()
    head = text[:text.index("samples:")].replace(" drop_", f" {ROOT}/config/thesis/drop_").replace(
        f"name: {ROOT}/config/thesis/drop_", "name: drop_")
    (tmp_path / "p.yaml").write_text(head + """samples: 3
seed: 2
drawn:
  rig.auxiliary_bearing.friction_coefficient: 0.15
  scenario.speed.start_hz: {uniform: [149.0, 151.0]}
changes:
  oiled: {rig.auxiliary_bearing.friction_coefficient: 0.0133}
""")
    assert cli.main(["sweep", str(tmp_path / "p.yaml"), "--out", str(tmp_path / "o"), "--json", str(tmp_path / "p.json")]) == 0
    found = json.loads((tmp_path / "p.json").read_text())
    assert [row["probability"] for row in found["designs"]] == [1.0, 0.0]
    assert found["designs"][1]["change"] == -1.0 and len(found["samples"]) == 3
    assert "by quarters of scenario.speed.start_hz (149" in capsys.readouterr().out


@pytest.mark.parametrize("change, words", [
    (("samples: 400", "samples: 0"), "11: samples = 0: must be a whole number"),
    (("motion: backward_whirl", "motion: whirling"), "wanted.motion = whirling: is none of"),
    (("clearance_m: 1.5", "clearance_m: -1.5"), "a factor above 0"),
    (("scenario: drop_150_hz.yaml", "scenario: none.yaml"), "scenario = none.yaml: there is no such file"),
    (("rig.unbalance.0.phase_rad", "rig.unbalance.7.phase_rad"), "rig.unbalance.7.phase_rad: the key is not known here; nearest: rig.unbalance.0.phase_rad"),
    (("uniform: [0.01, 0.2]", "normal: [0.01, 0.2]"), "drawn.rig.auxiliary_bearing.friction_coefficient.uniform: the key is missing"),
])
def test_a_wrong_probability_of_drops_is_refused_by_name(change, words, tmp_path, capsys):
    text = (ROOT / "config/thesis/drop_probability.yaml").read_text()
    assert change[0] in text
    text = text.replace(change[0], change[1], 1)
    for name in ("drop_model.yaml", "drop_150_hz.yaml"):
        text = text.replace(f" {name}", f" {ROOT}/config/thesis/{name}")
    (tmp_path / "p.yaml").write_text(text)
    assert cli.main(["sweep", str(tmp_path / "p.yaml"), "--out", str(tmp_path / "o")]) == 2
    assert words in capsys.readouterr().err


# ---- basins
def test_a_basin_without_friction_has_no_dry_whirl_and_turns_with_the_direction():
    document = basin.read_basin(ROOT / "config" / "thesis" / "basin_knock.yaml")
    document.update(direction_deg=numpy.array([0.0, 180.0, 360.0]), speed=numpy.array([0.0, 1.0, 3.0]))
    found = basin.run_basin(document)
    assert (found["regime"][0] == "no_contact").all() and (found["regime"][2] == "dry_whirl").all()
    assert (found["whirl"][:, 0] == pytest.approx(found["whirl"][:, 2], abs=1e-6))  # 0 and 360 deg
    document["parameters"]["friction"] = 0.0
    assert not (basin.run_basin(document)["regime"] == "dry_whirl").any()


# ---- branches
def test_a_bifurcation_is_told_with_its_own_multiplier():
    from amb_rotor.cli.continuation import critical
    unstable = [-2.79 + 0j, -1.0 + 0j, 0.3 + 0.2j, 0.3 - 0.2j]
    assert critical({"kind": "flip", "multipliers": unstable}) == -1.0
    assert critical({"kind": "grazing", "multipliers": unstable}) == -2.79
    assert critical({"kind": "fold", "multipliers": [1.7 + 0j, 1.0 + 0j, 0.1 + 0j, 0j]}) == 1.0
    assert critical({"kind": "neimark_sacker", "multipliers": [2.0 + 0j, 0.6 - 0.8j, 0.6 + 0.8j, 0.1 + 0j]}) == 0.6 + 0.8j


def test_a_branch_over_one_of_two_swept_parameters_is_refused(tmp_path, capsys):
    text = SMALL_MAP + """continuation: {parameter: friction, from: 0.01, to: 0.04, step: 0.01,
               starts: [{at: 0.015, turns: 1, x: 0, y: 0, vx: 0, vy: 0}]}
"""
    (tmp_path / "s.yaml").write_text(text)
    assert cli.main(["continue", str(tmp_path / "s.yaml"), "--out", str(tmp_path / "o")]) == 2
    assert "frequency_ratio is swept, so it has no value here" in capsys.readouterr().err


def test_a_branch_in_the_clearance_and_the_direction(tmp_path, capsys):
    text = (ROOT / "config/thesis/fig_6_2.yaml").read_text()
    head, _ = text.split("continuation:")
    head = head.replace("  - {parameter: frequency_ratio, from: 0.55, to: 1.5, step: 0.0073}",
                        "  - {parameter: clearance, from: 0.95, to: 1.05, count: 3}")
    head = head.replace("parameters:", "parameters:\n  frequency_ratio: 0.905", 1)
    (tmp_path / "s.yaml").write_text(head + """continuation:
  parameter: clearance
  from: 0.97
  to: 1.03
  step: 0.01
  starts: [{at: 1.0, turns: 1, x: 0, y: 0, vx: 0, vy: 0}]
""")
    assert cli.main(["continue", str(tmp_path / "s.yaml"), "--out", str(tmp_path / "o")]) == 0
    assert "period 1" in capsys.readouterr().out


def test_harmonic_balance_agrees_with_a_branch():
    from amb_rotor import _core
    from amb_rotor.cli import continuation
    sweep = _core.BasicSweep(str(ROOT / "config" / "thesis" / "fig_6_2.yaml"))
    state = sweep.run(48, 1)["end"][0]  # frequency ratio 0.9004: period 1, in contact
    point = {"parameter": 0.55 + 48 * 0.0073, "state": tuple(state)}
    check = continuation.balance_check(sweep, {"points": [point, point], "turns": 1})
    assert check["converged"] == check["points"] == 2
    assert check["largest_difference"] < 1e-3  # of the lanes' section and of 64 harmonics
    off = {"parameter": point["parameter"], "state": (state[0] + 0.01, *state[1:])}
    assert continuation.balance_check(sweep, {"points": [off, off], "turns": 1})["largest_difference"] > 5e-3
