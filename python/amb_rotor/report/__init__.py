"""The HTML report: one file that needs no network. `data` makes the numbers, `page` the file around them."""
from amb_rotor.report.page import write_report

__all__ = ["write_report"]
