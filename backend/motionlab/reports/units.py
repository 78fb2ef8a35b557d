"""Numbers with SI prefixes, as reports write them."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

_PREFIXES = ((1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "u"), (1e-9, "n"))
_SMALL = frozenset({"m", "s", "A", "m/s", "m/s^2", "m s^2", "rad"})
"""Units with prefixes for small numbers alone, as in 1200 mm and 0.3 ms."""
_BOTH = frozenset({"N", "Wb", "H", "V", "W", "T", "J", "Pa"})
_LARGE = frozenset({"A/m", "Hz", "N/m"})
_ROUNDING = 1.0 - 1e-9


class Scale(NamedTuple):
    """How numbers of a unit are written: as multiples of `size`, in `unit`."""

    size: float
    unit: str


def scale_for(values: Iterable[float], unit: str, micro: str = "\u00b5") -> Scale:
    """Return the prefix with which the largest of some values reads between 1 and 1000."""
    if unit == "1":
        return Scale(1.0, "")
    prefixes = [
        (size, prefix)
        for size, prefix in _PREFIXES
        if (size <= 1.0 and unit in _SMALL | _BOTH) or (size >= 1.0 and unit in _LARGE | _BOTH)
    ]
    largest = max((abs(value) for value in values if math.isfinite(value)), default=0.0)
    if not prefixes or largest == 0.0:
        return Scale(1.0, unit)
    chosen = next((each for each in prefixes if largest >= each[0] * _ROUNDING), prefixes[-1])
    prefix = micro if chosen[1] == "u" else chosen[1]
    return Scale(chosen[0], prefix + unit)
