"""What cannot be written is one line with the path and the reason, told before the work, of every command."""
from __future__ import annotations

import importlib
import json
import pathlib
import shutil

import pytest

core = pytest.importorskip("amb_rotor._core")

from amb_rotor import cli  # noqa: E402
from amb_rotor.cli import common  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]
THESIS = ROOT / "config/thesis"
MEASURED = str(ROOT / "config/tutorial/measured")
MODEL, SHAFT = str(THESIS / "levitation_model.yaml"), str(THESIS / "flexible_model.yaml")
SCENARIO = str(THESIS / "drop.yaml")
LAW = {"depends_on": ["position"], "shape": "", "held_out_gain": 0.9, "frequency_hz": 30.0,
       "terms": [{"term": "position_cube_N_per_m3", "coefficient": -3e12, "std": 1e10}]}
DIAGNOSIS = {"format": "amb-diagnosis/1", "verdict": "unknown", "unexplained": LAW, "dataset": {"name": "rig", "folder": MEASURED},
             "steps": [], "ranking": [{"effect": "static_load", "parameters": {}}]}

# The command, and its work: what must not begin. {} stands for what cannot be written.
FOLDERS = {
    "analyse": (f"analyse {MEASURED} --run steady_1 --out {{}}", "amb_rotor._core.read_dataset"),
    "analyse sweep": (f"analyse {THESIS}/fig_6_2.yaml --at frequency_ratio=1 --out {{}}", "amb_rotor.motion.from_sweep"),
    "bench": ("bench --out {}", "amb_rotor.cli.bench._programs"),
    "bench-diagnosis": ("bench-diagnosis --sets 1 --out {}", "amb_rotor._core.make_dataset"),
    "bench-diagnosis keep": ("bench-diagnosis --sets 1 --keep {}", "amb_rotor._core.make_dataset"),
    "campbell": (f"campbell {MODEL} --out {{}}", "amb_rotor.modal.modes"),
    "compare": (f"compare {MEASURED} --out {{}}", "amb_rotor._core.compare"),
    "compare modes": (f"compare {THESIS}/table_4_2 --out {{}}", "amb_rotor.modes_comparison.predicted"),
    "continue": (f"continue {THESIS}/fig_6_2.yaml --out {{}}", "amb_rotor._core.BasicSweep.run_continuation"),
    "demo": ("demo --out {}", "amb_rotor.cli.demo.motion"),
    "diagnose": (f"diagnose {MEASURED} --out {{}}", "amb_rotor._core.diagnose"),
    "make-dataset": ("make-dataset --seed 1 --out {}", "amb_rotor._core.make_dataset"),
    "margins": (f"margins {MODEL} --out {{}}", "amb_rotor.modal.sensitivity"),
    "new-effect": ("new-effect grease --from diagnosis --out {}", "amb_rotor.new_effect.yaml_file"),
    "reduce": (f"reduce {SHAFT} --out {{}}", "amb_rotor._core.reduce_rotor"),
    "sweep": (f"sweep {THESIS}/fig_6_2.yaml --out {{}}", "amb_rotor._core.BasicSweep.run"),
    "sweep basin": (f"sweep {THESIS}/basin_knock.yaml --out {{}}", "amb_rotor.sweeps.basin.run_basin"),
    "sweep drop probability": (f"sweep {THESIS}/drop_probability.yaml --out {{}}", "amb_rotor.sweeps.drop_probability.run"),
    "sweep drops": (f"sweep {THESIS}/drop_map_40_hz.yaml --out {{}}", "amb_rotor.sweeps.drops.run_drops"),
    "sweep figure": (f"sweep {THESIS}/fig_5_6.yaml --out {{}}", "amb_rotor.sweeps.figures._motion"),
    "sweep magnet": (f"sweep {THESIS}/fig_3_9.yaml --out {{}}", "amb_rotor._core.magnet_pull"),
    "sweep probability": (f"sweep {THESIS}/dry_whirl_probability.yaml --out {{}}", "amb_rotor.sweeps.probability.run_probability"),
    "sweep search": (f"sweep {THESIS}/search_6_2.yaml --out {{}}", "amb_rotor.sweeps.search.run_search"),
}
FILES = {
    "adopt": ("adopt diagnosis --effect static_load --out {}.yaml", "amb_rotor.cli.adopt._chosen"),
    "convert": ("convert table.csv {}.npz", "amb_rotor.cli.convert.read_table"),
    "launch": (f"launch {SCENARIO} --record {{}}.bag", "amb_rotor.cli.launch.plant_is_running"),
    "simulate": (f"simulate {SCENARIO} --out {{}}.csv", "amb_rotor._core.simulate"),
    "simulate picture": (f"simulate {SCENARIO} --out run.csv --picture {{}}.png", "amb_rotor._core.simulate"),
}
# With the name that is in the way, where it is not what was asked for.
BAD_FOLDERS = [("afile", "afile: is a file"), ("afile/sub/set", "afile/sub/set: cannot be written: afile is a file"),
               ("/proc/no/where", "/proc/no/where: cannot be written: nothing can be made in /proc"),
               ("x" * 300, "x: cannot be written: File name too long")]
BAD_FILES = [("afolder", ": is a folder"), ("afile/sub/run", ": cannot be written: afile is a file"),
             ("/proc/no/where", ": cannot be written: nothing can be made in /proc"), ("x" * 300, ": cannot be written: File name too long")]


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch):
    """A folder with what the commands read, and what stands in their way."""
    monkeypatch.chdir(tmp_path)
    pathlib.Path("afile").write_text("mine")
    for ending in ("yaml", "npz", "bag", "csv", "png", "json"):
        pathlib.Path(f"afolder.{ending}").mkdir()
    pathlib.Path("table.csv").write_text("t_s,ax_m\n0,0\n1,0\n")
    pathlib.Path("diagnosis").mkdir()
    pathlib.Path("diagnosis/diagnosis.json").write_text(json.dumps(DIAGNOSIS))
    for name in ("model.yaml", "adopted.yaml"):
        shutil.copy(MODEL, pathlib.Path("diagnosis", name))
    before = sorted(map(str, tmp_path.rglob("*")))
    yield
    assert sorted(map(str, tmp_path.rglob("*"))) == before and pathlib.Path("afile").read_text() == "mine"


def idle(monkeypatch, work: str) -> None:
    """Makes the work fail the test."""
    owner, name = work.rsplit(".", 1)
    try:
        owner = importlib.import_module(owner)
    except ModuleNotFoundError:
        module, kind = owner.rsplit(".", 1)
        owner = getattr(importlib.import_module(module), kind)
    monkeypatch.setattr(owner, name, lambda *_, **__: pytest.fail(f"{work} was called in vain"))


def refused(capsys, line: str) -> str:
    """The one line of a command that is refused."""
    assert cli.main(line.split()) == 2, line
    shown = capsys.readouterr()
    assert shown.err.startswith(f"amb {line.split()[0]}: ") and shown.err.count("\n") == 1 and ".part" not in shown.err, shown.err
    assert shown.out.replace(f"model {THESIS}/drop_model.yaml, by the name of the scenario\n", "") == ""
    return shown.err


def test_every_command_that_writes_is_here():
    writes = set()
    for command, module in cli.available_commands().items():
        text = pathlib.Path(importlib.import_module(module).__file__).read_text()
        if any(word in text for word in ('"--out"', "add_out(", '"--record"', '"--picture"', '"output"')):
            writes.add(command)
    assert writes == {name.split()[0] for name in [*FOLDERS, *FILES]}


@pytest.mark.parametrize("out, said", BAD_FOLDERS, ids=["a file", "below a file", "nowhere", "too long"])
@pytest.mark.parametrize("name", FOLDERS)
def test_a_folder_that_cannot_be_written_is_told_before_the_work(name, out, said, monkeypatch, capsys):
    line, work = FOLDERS[name]
    idle(monkeypatch, work)
    assert said in refused(capsys, line.format(out))


@pytest.mark.parametrize("out, said", BAD_FILES, ids=["a folder", "below a file", "nowhere", "too long"])
@pytest.mark.parametrize("name", FILES)
def test_a_file_that_cannot_be_written_is_told_before_the_work(name, out, said, monkeypatch, capsys):
    line, work = FILES[name]
    idle(monkeypatch, work)
    message = refused(capsys, line.format(out))
    assert out in message and said in message


@pytest.mark.parametrize("name", [name for name, (line, _) in {**FOLDERS, "simulate": FILES["simulate"]}.items()
                                  if " --out " in line and name.split()[0] not in ("new-effect", "make-dataset")])
def test_the_folder_that_is_written_by_itself_is_told_too(name, monkeypatch, capsys):
    pathlib.Path("out").write_text("mine")
    line, work = {**FOLDERS, **FILES}[name]
    idle(monkeypatch, work)
    message = refused(capsys, line.split(" --out ")[0])
    pathlib.Path("out").unlink()
    assert "cannot be written: out is a file" in message


@pytest.mark.parametrize("out, said", [*BAD_FILES, ("nowhere/result", "there is no such folder")],
                         ids=["a folder", "below a file", "nowhere", "too long", "no folder"])
@pytest.mark.parametrize("command", cli.available_commands())
def test_a_result_that_cannot_be_written_is_told_before_the_work(command, out, said, monkeypatch, capsys):
    module = cli.available_commands()[command]
    idle(monkeypatch, f"{module}.run")
    monkeypatch.setattr(importlib.import_module(module), "add_arguments", lambda _: None)
    message = refused(capsys, f"{command} --json {out}.json")
    assert f"--json {out}.json" in message and (said in message or out in ("afile/sub/run", "/proc/no/where"))


def test_a_result_goes_to_what_is_no_file_without_taking_its_place(tmp_path):
    """Pipes and devices are written, not replaced: --json /dev/stdout, /dev/null."""
    import os
    import threading
    pipe, read = tmp_path / "pipe", []
    os.mkfifo(pipe)
    reader = threading.Thread(target=lambda: read.append(pipe.read_text()), daemon=True)
    reader.start()
    writer = threading.Thread(target=common.atomic_write, args=(pipe, "all"), daemon=True)
    writer.start()
    writer.join(timeout=10.0)
    reader.join(timeout=10.0)
    assert read == ["all"] and pipe.is_fifo()
    pipe.unlink()
