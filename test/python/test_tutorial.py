"""doc/tutorial.md is true: its commands run, and print what it says they print."""
from __future__ import annotations

import pathlib
import re

import pytest
from conftest import tutorial_steps

ROOT = pathlib.Path(__file__).resolve().parents[2]
NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[+-]?\d+)?")
# Numbers of a fit differ between machines (instruction sets) in the last digits that are printed.
RELATIVE, ABSOLUTE = 0.01, 0.02


def same(expected: str, line: str) -> bool:
    """Whether a printed line begins as the tutorial says: the words equal, the numbers nearly."""
    def words(text):
        return " ".join(NUMBER.sub("#", text).split())

    if not words(line).startswith(words(expected)):
        return False
    pairs = zip(NUMBER.findall(expected), NUMBER.findall(line))
    return all(abs(float(a) - float(b)) <= ABSOLUTE + RELATIVE * abs(float(a)) for a, b in pairs)


@pytest.mark.parametrize("command, expected", tutorial_steps(), ids=lambda value: value[:60] if isinstance(value, str) else "")
def test_a_command_of_the_tutorial_does_what_the_text_says(chain, command, expected):
    assert chain.status[command] == 0
    lines = chain.printed[command].splitlines()
    for wanted in expected:
        assert any(same(wanted, line) for line in lines), f"{wanted!r} was not printed:\n{chain.printed[command]}"


def test_a_wrong_number_or_word_would_be_found():
    assert same("  error 2.340 -> 1.009", "  error 2.341 -> 1.010; more")
    assert not same("  error 2.340", "  error 2.50")
    assert not same("verdict: none", "verdict: effect")


def test_links_of_the_pages_lead_somewhere():
    broken = []
    for page in [ROOT / "README.md", *sorted((ROOT / "doc").glob("*.md"))]:
        for target in re.findall(r"\]\(([^)#]+)(?:#[^)]*)?\)", page.read_text()):
            if "://" not in target and not (page.parent / target).exists():
                broken.append(f"{page.name}: {target}")
    assert not broken
