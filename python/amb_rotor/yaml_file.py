"""YAML of a person's file: whatever is wrong with it as a whole is one line."""
from __future__ import annotations

import contextlib
import pathlib
from typing import Iterator

from amb_rotor.errors import InputError


@contextlib.contextmanager
def one_message(path: pathlib.Path) -> Iterator[None]:
    """What reading and parsing `path` raises, as an InputError."""
    import yaml
    try:
        yield
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: is no text in UTF-8: {error}") from None
    except (yaml.YAMLError, ValueError) as error:  # ValueError: a date that is none
        raise InputError(f"{path}: is no YAML: {' '.join(str(error).split())}") from None
    except RecursionError:
        raise InputError(f"{path}: is nested too deeply for a file of ours") from None


def read(path: pathlib.Path):
    """The document in a file."""
    import yaml
    with one_message(path):
        return yaml.safe_load(path.read_text())
