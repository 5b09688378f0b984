"""Numbers as a page takes them."""
from __future__ import annotations

import math


def short(values, digits: int = 4) -> list:
    """Numbers with a few digits; what is not finite becomes null."""
    return [float(f"{value:.{digits}g}") if math.isfinite(value) else None for value in values]
