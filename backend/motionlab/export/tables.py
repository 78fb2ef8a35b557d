"""Tables of exported C: one array of those that a motor or a controller reads."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from motionlab.lanes.bank import TABLES
from motionlab.targets.c_values import array_lines

Array = NDArray[np.float64]


class Tables:
    """Tables one after another, each once, whoever reads them.

    They are copied from those of this process: the caller holds a lease.
    """

    def __init__(self) -> None:
        self._places: dict[float, int] = {}
        self._lines: list[str] = []
        self._size = 0

    def place(self, first: float, shape: tuple[int, ...], about: str) -> float:
        """Return where a table lies in the array, of its place among this process's; -1: none."""
        if first < 0.0:
            return first
        if first not in self._places:
            start = int(first)
            numbers = TABLES.values[start : start + math.prod(shape)]
            self._places[first] = self._size
            self._lines.append(f"    /* from {self._size}: {about} */")
            self._lines += array_lines(numbers, "    ")
            self._size += numbers.size
        return float(self._places[first])

    def code(self) -> str:
        """Return the array's definition; empty without tables."""
        if not self._lines:
            return ""
        return "\n".join(["static const double TABLES[] = {", *self._lines, "};"])
