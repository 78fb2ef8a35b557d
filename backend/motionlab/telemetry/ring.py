"""The latest samples of a live run, column by column, in a fixed amount of memory."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Rows = NDArray[np.intp]


class Ring:
    """A ring of float32 columns over consecutive ticks.

    Parameters
    ----------
    columns : int
        Number of columns.
    capacity : int
        Ticks that are kept.
    """

    def __init__(self, columns: int, capacity: int) -> None:
        self._data = np.empty((columns, capacity), dtype=np.float32)
        self._capacity = capacity
        self.first = 0
        self.end = 0

    @property
    def size(self) -> int:
        """What it takes, bytes."""
        return self._data.nbytes

    def clear(self) -> None:
        """Forget everything and begin at tick 0."""
        self.first = self.end = 0

    def room(self, ticks: int) -> NDArray[np.float32]:
        """Return where the next ticks go, at most so many, in place of the oldest; a view.

        Shape (columns, at most `ticks`): what is written there counts once `fill` is told of it.
        """
        start = self.end % self._capacity
        return self._data[:, start : start + ticks]

    def fill(self, ticks: int) -> None:
        """Take so many ticks into account that have been written to the room for them."""
        self.end += ticks
        self.first = max(self.first, self.end - self._capacity)

    def read(
        self, columns: Sequence[int] | Rows | slice, start: int, stop: int
    ) -> NDArray[np.float32]:
        """Return ticks [start, stop) of some columns, shape (columns, stop - start).

        Raises
        ------
        IndexError
            If the ring does not hold all of them.
        """
        if not self.first <= start <= stop <= self.end:
            raise IndexError(f"ticks {start} to {stop} of {self.first} to {self.end}")
        begin = start % self._capacity
        count = stop - start
        before_wrap = min(count, self._capacity - begin)
        data = self._data[:, begin : begin + before_wrap][columns]
        if before_wrap == count:  # nearly always, and a concatenation takes longer than the rest
            return data.copy() if isinstance(columns, slice) else data
        return np.concatenate((data, self._data[:, : count - before_wrap][columns]), axis=1)
