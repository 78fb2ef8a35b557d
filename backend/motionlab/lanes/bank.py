"""The tables that lanes read: one long array for the whole process, which only grows."""

from __future__ import annotations

import threading
from collections.abc import Callable, Hashable

import numpy as np
from numpy.typing import NDArray

from motionlab.errors import StoreError

Array = NDArray[np.float64]

NUMBERS_MOST = 2**26
"""Room for tables in a process, numbers: half a gigabyte, several hundred force maps."""

_FIRST = 64  # zeros, which lanes without a table read and forget
_ROOM = 2**17


class Bank:
    """Tables by key, each at a place that never changes.

    What `values` returned goes on to hold what it held: a kernel may run while tables are added.
    """

    def __init__(self, numbers_most: int = NUMBERS_MOST) -> None:
        self._most = numbers_most
        self._values = np.zeros(min(_ROOM, numbers_most))
        self._used = _FIRST
        self._places: dict[Hashable, int] = {}
        self._lock = threading.Lock()

    @property
    def values(self) -> Array:
        """All tables, one after another."""
        return self._values

    def place(self, key: Hashable, make: Callable[[], Array]) -> int:
        """Return where a table begins; it is made the first time that its key is asked for.

        Raises
        ------
        StoreError
            If there is no room left.
        """
        with self._lock:
            if key not in self._places:
                self._places[key] = self._add(make().ravel())
            return self._places[key]

    def _add(self, table: Array) -> int:
        first, end = self._used, self._used + table.size
        if end > self._most:
            raise StoreError(
                f"no room for another force map: those in use take {first} of {self._most} numbers;"
                " start anew"
            )
        if end > self._values.size:
            grown = np.zeros(min(max(end, 2 * self._values.size), self._most))
            grown[:first] = self._values[:first]
            self._values = grown
        self._values[first:end] = table
        self._used = end
        return first


TABLES = Bank()
"""The tables of this process."""
