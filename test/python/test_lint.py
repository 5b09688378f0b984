"""House rules that a machine can check, and checks of the checkers."""
from __future__ import annotations

import os
import pathlib
import re

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
LONGEST_FILE = 500  # lines

SOURCE_FOLDERS = ("include", "src", "python", "test", "bench", "launch", "config", "msg", "srv", "rviz", "cmake",
                  "doc", ".ci")
TEXT = {".hpp", ".cpp", ".h", ".py", ".cmake", ".txt", ".md", ".rst", ".yaml", ".yml", ".launch", ".test",
        ".msg", ".srv", ".rviz", ".xml", ".json", ".html", ""}
# Folders of a person's or a machine's own; nobody else has them.
MACHINE_PATH = re.compile(r"""(?<![\w.])/(?:home|root|work|Users|mnt|media)/\w""")


def text_files() -> list[pathlib.Path]:
    files = [path for path in ROOT.iterdir() if path.is_file() and path.name != ".git"]  # of a worktree: where it belongs
    for folder in SOURCE_FOLDERS:
        for base, folders, names in os.walk(ROOT / folder):
            folders[:] = [name for name in folders if name != "__pycache__"]
            files += [pathlib.Path(base) / name for name in names]
    return sorted(path for path in files if path.suffix in TEXT)


def files(folders: tuple[str, ...], suffixes: tuple[str, ...]) -> list[pathlib.Path]:
    return [path for folder in folders for path in sorted((ROOT / folder).rglob("*")) if path.suffix in suffixes]


def too_long(text: str) -> bool:
    return text.count("\n") > LONGEST_FILE


def has_guard(text: str) -> bool:
    return re.search(r"^#pragma once$", text, re.MULTILINE) is not None


def machine_paths(text: str) -> list[str]:
    return [match.group() for match in MACHINE_PATH.finditer(text)]


def relative(paths) -> list[str]:
    return [str(path.relative_to(ROOT)) for path in paths]


def test_files_are_short_enough_to_read():
    found = [path for path in files(("include", "src", "python", "test"), (".hpp", ".cpp", ".py"))
             if too_long(path.read_text())]
    assert not relative(found), f"over {LONGEST_FILE} lines"


def missing_words(text: str) -> list[str]:
    """Which of a physical model's statements its header comment lacks."""
    comment = " ".join(line for line in text.split("#include")[0].splitlines() if line.startswith("//"))
    return [word for word in ("Valid:", "Source:", "Left out:") if word not in comment]


def test_every_effect_says_where_it_holds_where_it_is_from_and_what_it_leaves_out():
    texts = {path.stem: path.read_text() for path in files(("include/amb_rotor/effects",), (".hpp",))}
    effects = {name: text for name, text in texts.items() if "  static EffectSchema schema() {" in text}
    assert len(effects) >= 28
    found = {name: missing_words(text) for name, text in effects.items()}
    assert not {name: words for name, words in found.items() if words}


COMPONENTS = ("rotor", "magnetic_bearing", "auxiliary_bearing", "excitation")
PHYSICS = ("machine/basic_model.hpp", "machine/set_valued_friction.hpp")  # of the machine, where components meet


def test_every_component_says_where_it_holds_where_it_is_from_and_what_it_leaves_out():
    headers = files(tuple(f"include/amb_rotor/{layer}" for layer in COMPONENTS), (".hpp",))
    headers += [ROOT / "include" / "amb_rotor" / name for name in PHYSICS]
    assert len(headers) >= 23
    found = {path.name: missing_words(path.read_text()) for path in headers}
    assert not {name: words for name, words in found.items() if words}


def test_a_header_without_its_source_is_seen():
    assert missing_words("#pragma once\n// Drag. Valid: slow. Left out: heat.\n#include <x>\n// Source: late") == ["Source:"]


def test_every_header_has_a_guard():
    found = [path for path in files(("include", "src", "test", "bench"), (".hpp",))
             if not has_guard(path.read_text())]
    assert not relative(found), "#pragma once is missing"


def test_no_path_of_one_machine():
    this = pathlib.Path(__file__).resolve()
    found = {str(path.relative_to(ROOT)): machine_paths(path.read_text(errors="replace"))
             for path in text_files() if path != this}
    assert not {path: hits for path, hits in found.items() if hits}


@pytest.mark.parametrize("text, hits", [
    ("see /home/someone/x", 1), ('"/work/main"', 1), ("/usr/bin/python3 and ../work/x", 0),
    ("https://host/home/page", 0), ("a/root/b", 0), ("/tmp/x", 0), ("of the /root folder", 0),
])
def test_the_path_checker(text, hits):
    assert len(machine_paths(text)) == hits


def test_the_length_and_guard_checkers():
    assert too_long("x\n" * (LONGEST_FILE + 1)) and not too_long("x\n" * LONGEST_FILE)
    assert has_guard("// what\n#pragma once\n") and not has_guard("// #pragma once\n")


def test_every_debian_package_is_explained():
    listed = {line.split()[1] for line in (ROOT / "packages.txt").read_text().splitlines()
              if line and not line.startswith("#")}
    explained = set(re.findall(r"^\| `([^`]+)` \|", (ROOT / "doc" / "dependencies.md").read_text(), re.MULTILINE))
    assert listed == explained
