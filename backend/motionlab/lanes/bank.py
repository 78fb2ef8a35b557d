"""The tables that lanes read: one long array for the whole process, bounded in size."""

from __future__ import annotations

import threading
import weakref
from collections import OrderedDict
from collections.abc import Callable, Hashable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motionlab.errors import StoreError

Array = NDArray[np.float64]

NUMBERS_MOST = 2**26
"""Room for tables in a process, numbers: half a gigabyte, several hundred force maps."""

_FIRST = 64  # zeros, read and discarded by lanes without a table
_ROOM = 2**17


class Lease:
    """Holds the tables that were placed while it was the current one, for as long as it lives."""

    def __init__(self, held: set[Hashable]) -> None:
        self._held = held

    def keep_with(self, owner: object) -> None:
        """Let this lease live as long as `owner`, such as the array that holds the places."""
        weakref.finalize(owner, lambda _: None, self).atexit = False


@dataclass
class _Table:
    first: int
    size: int
    holders: int = 0
    pinned: bool = False


class Bank:
    """Tables by key, each at an offset that does not change while a lease holds it.

    Arrays returned by `values` stay valid: a kernel may run while tables are added. Tables without
    a lease are evicted to make room, the least recently used first. A table placed outside any
    lease stays.
    """

    def __init__(self, numbers_most: int = NUMBERS_MOST) -> None:
        self._most = numbers_most
        self._values = np.zeros(min(_ROOM, numbers_most))
        self._tables: OrderedDict[Hashable, _Table] = OrderedDict()
        self._lease: ContextVar[set[Hashable] | None] = ContextVar("lease", default=None)
        # A lease may end wherever the interpreter collects garbage, here too.
        self._lock = threading.RLock()

    @property
    def values(self) -> Array:
        """All tables, one after another."""
        return self._values

    @contextmanager
    def lease(self) -> Iterator[Lease]:
        """Attach tables placed in this thread to a lease until the block ends.

        For longer use, keep the lease.
        """
        held: set[Hashable] = set()
        lease = Lease(held)
        weakref.finalize(lease, self._release, held).atexit = False
        before = self._lease.set(held)
        try:
            yield lease
        finally:
            self._lease.reset(before)

    def place(self, key: Hashable, make: Callable[[], Array]) -> int:
        """Return the offset of a table, created on the first use of its key.

        Raises
        ------
        StoreError
            If there is no room left.
        """
        with self._lock:
            if key in self._tables:
                return self._hold(key)
        table = make().ravel()  # other threads may look up tables meanwhile
        with self._lock:
            if key not in self._tables:
                self._add(key, table)
            return self._hold(key)

    def _hold(self, key: Hashable) -> int:
        table = self._tables[key]
        self._tables.move_to_end(key)
        held = self._lease.get()
        if held is None:
            table.pinned = True
        elif key not in held:
            held.add(key)
            table.holders += 1
        return table.first

    def _release(self, held: set[Hashable]) -> None:
        with self._lock:
            for key in held:
                self._tables[key].holders -= 1

    def _add(self, key: Hashable, table: Array) -> None:
        first = self._room(table.size)
        end = first + table.size
        if end > self._values.size:
            grown = np.zeros(min(max(end, 2 * self._values.size), self._most))
            grown[: self._values.size] = self._values
            self._values = grown
        self._values[first:end] = table
        self._tables[key] = _Table(first, table.size)

    def _room(self, size: int) -> int:
        """Return an offset with room for so many numbers, evicting as few tables as possible."""
        while (first := self._gap(size)) is None:
            free = (k for k, t in self._tables.items() if t.holders == 0 and not t.pinned)
            oldest = next(free, None)
            if oldest is None:
                taken = sum(table.size for table in self._tables.values())
                raise StoreError(
                    f"no room for another force map: those in use take {taken} of {self._most} "
                    "numbers; end a session or a job that uses one"
                )
            del self._tables[oldest]
        return first

    def _gap(self, size: int) -> int | None:
        end = _FIRST
        for table in sorted(self._tables.values(), key=lambda table: table.first):
            if table.first - end >= size:
                return end
            end = table.first + table.size
        return end if end + size <= self._most else None


TABLES = Bank()
"""The tables of this process."""
