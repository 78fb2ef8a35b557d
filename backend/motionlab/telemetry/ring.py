"""The latest samples of a live run, column by column, in a fixed amount of memory.

One thread writes; any number read without a lock. The writer gives up the oldest ticks (`first`)
before it overwrites them, and counts new ones in (`end`) after they are written, so a reader who
finds its ticks still held after copying them has copied them whole.
"""

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

    Attributes
    ----------
    first, end : int
        The first tick that is held, and the one after the last.
    """

    def __init__(self, columns: int, capacity: int) -> None:
        self._data = np.empty((columns, capacity), dtype=np.float32)
        self.capacity = capacity
        self.first = 0
        self.end = 0
        self._first_before = 0

    @property
    def size(self) -> int:
        """Size, bytes."""
        return self._data.nbytes

    def clear(self) -> None:
        """Clear the ring and begin at tick 0."""
        self.first = self.end = self._first_before = 0

    def room(self, ticks: int) -> NDArray[np.float32]:
        """Return where the next ticks go, at most so many, in place of the oldest; a view.

        Shape (columns, at most `ticks`): what is written there counts once `fill` is called.
        """
        start = self.end % self.capacity
        room = self._data[:, start : start + ticks]
        self._first_before = self.first
        self.first = max(self.first, self.end + room.shape[1] - self.capacity)
        return room

    def fill(self, ticks: int) -> None:
        """Count in so many ticks that have been written to the room for them."""
        self.end += ticks
        self.first = max(self._first_before, self.end - self.capacity)  # the room may not be full

    def read(
        self, columns: Sequence[int] | Rows | slice, start: int, stop: int
    ) -> NDArray[np.float32]:
        """Return ticks [start, stop) of some columns, shape (columns, stop - start); a copy.

        Raises
        ------
        IndexError
            If the ring does not hold all of them, or no longer when they have been copied.
        """
        self._check_held(start, stop)
        data = self._copy(columns, start, stop)
        self._check_held(start, stop)
        return data

    def _check_held(self, start: int, stop: int) -> None:
        if not self.first <= start <= stop <= self.end:
            raise IndexError(f"ticks {start} to {stop} of {self.first} to {self.end}")

    def _copy(
        self, columns: Sequence[int] | Rows | slice, start: int, stop: int
    ) -> NDArray[np.float32]:
        begin = start % self.capacity
        count = stop - start
        before_wrap = min(count, self.capacity - begin)
        data = self._data[:, begin : begin + before_wrap][columns]
        if before_wrap == count:  # nearly always, and a concatenation takes longer than the rest
            return data.copy() if isinstance(columns, slice) else data
        return np.concatenate((data, self._data[:, : count - before_wrap][columns]), axis=1)
