"""The chain compare, diagnose, adopt, run once for all tests that look at it."""
from __future__ import annotations

import json
import pathlib
import types

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
MEASURED = ROOT / "config/tutorial/measured"


@pytest.fixture(scope="session")
def chain(tmp_path_factory):
    """Folders and results of: compare; diagnose with three candidates; adopt; compare with what was adopted."""
    pytest.importorskip("amb_rotor._core")
    from amb_rotor import cli
    folder = tmp_path_factory.mktemp("chain")

    def run(*arguments: str) -> dict:
        path = folder / f"{arguments[0]}_{len(list(folder.glob('*.json')))}.json"
        assert cli.main([*arguments, "--json", str(path)]) == 0
        return json.loads(path.read_text())

    before = run("compare", "-", str(MEASURED), "--out", str(folder / "before"))
    diagnosis = run("diagnose", str(MEASURED), "--quick", "--steps", "1", "--effect", "cross_coupled_stiffness",
                    "--effect", "sensor_runout", "--effect", "auxiliary_bearing_misalignment",
                    "--out", str(folder / "diagnosis"))
    adopted = run("adopt", str(folder / "diagnosis"), "--out", str(folder / "models" / "model.yaml"))
    after = run("compare", str(folder / "models" / "model.yaml"), str(MEASURED), "--out", str(folder / "after"))
    return types.SimpleNamespace(folder=folder, before=before, diagnosis=diagnosis, adopted=adopted, after=after)
