"""Cached summaries of files, refreshed when a file changes."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable
from pathlib import Path
from typing import Generic, TypeVar

T = TypeVar("T")

Stamp = tuple[int, int, int, int]


def stamp(path: Path) -> Stamp:
    """Return a stamp that changes with a file, even if a copy keeps the modification time."""
    found = path.stat()
    return found.st_ino, found.st_mtime_ns, found.st_ctime_ns, found.st_size


class Index(Generic[T]):
    """A summary of each file, by path and stamp; the least recently used are evicted.

    Parameters
    ----------
    read : callable
        Returns the summary of a file; also of a damaged one, which else would be read each time.
    most : int
        Number of cached summaries.
    """

    def __init__(self, read: Callable[[Path], T], *, most: int) -> None:
        self._read = read
        self._most = most
        self._known: OrderedDict[Path, tuple[Stamp, T]] = OrderedDict()
        self._lock = threading.Lock()

    def of(self, path: Path) -> T:
        """Return the summary of a file.

        Raises
        ------
        FileNotFoundError
            If it is not there.
        """
        now = stamp(path)
        with self._lock:
            known = self._known.get(path)
            if known is not None and known[0] == now:
                self._known.move_to_end(path)
                return known[1]
        found = self._read(path)
        with self._lock:
            self._known[path] = now, found
            self._known.move_to_end(path)
            while len(self._known) > self._most:
                self._known.popitem(last=False)
        return found
