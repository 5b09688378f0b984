"""Errors in what a person wrote: a file, an argument. They are reported as a message, never a traceback."""
from __future__ import annotations


class InputError(ValueError):
    """Bad input. `faults` holds one line for each thing that is wrong; all are reported at once."""

    def __init__(self, faults: str | list[str]):
        self.faults = [faults] if isinstance(faults, str) else list(faults)
        super().__init__("\n".join(self.faults))
