"""The runner of `amb test`: programs that write JUnit XML are run, and their results summed up."""
from amb_rotor.testing.programs import KINDS, Selection
from amb_rotor.testing.runner import run_all

__all__ = ["KINDS", "Selection", "run_all"]
