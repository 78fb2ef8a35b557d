"""Room for what runs record, so that no request can exhaust the machine's memory."""

from __future__ import annotations

import contextlib
import os
import threading
from collections.abc import Iterator
from pathlib import Path

from fastapi import HTTPException

from motionlab.errors import ConfigError, FieldError

SHARE = 0.5
"""What of the machine's memory recordings may take."""

_CGROUP = Path("/sys/fs/cgroup/memory.max")


class MemoryBudget:
    """A number of bytes that runs take from and give back.

    Parameters
    ----------
    most : int
        How many there are.
    """

    def __init__(self, most: int) -> None:
        self._most = most
        self._taken = 0
        self._lock = threading.Lock()

    def check(self, wanted: int) -> None:
        """Refuse a run for which there never will be room.

        Raises
        ------
        ConfigError
            Naming what it would take and what there is.
        """
        if wanted > self._most:
            raise ConfigError(
                FieldError(
                    "trajectory",
                    "simulated time times variants takes more memory than may be used (memory_max)",
                    wanted,
                    f"<= {self._most}",
                    "bytes",
                )
            )

    @contextlib.contextmanager
    def hold(self, wanted: int) -> Iterator[None]:
        """Hold memory for a run that starts at once, or answer 429 where others have it."""
        self.take(wanted)
        try:
            yield
        finally:
            self.give_back(wanted)

    def take(self, wanted: int) -> None:
        """Take memory until it is given back, or answer 429 where others have it."""
        if not self.try_to_take(wanted):
            raise HTTPException(
                429,
                f"runs and sessions hold {self._taken} of {self._most} bytes (memory_max); this "
                f"takes {wanted}",
            )

    def give_back(self, taken: int) -> None:
        """Give back what was taken."""
        with self._lock:
            self._taken -= taken

    def try_to_take(self, wanted: int) -> bool:
        """Take memory until it is given back; return whether there was as much."""
        with self._lock:
            free = self._taken + wanted <= self._most
            self._taken += wanted if free else 0
            return free


def recordable(most: int) -> int:
    """Return how many bytes recordings may take on this machine, `most` at most."""
    machine = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    with contextlib.suppress(OSError, ValueError):  # no container, or none with a limit
        machine = min(machine, int(_CGROUP.read_text()))
    return min(most, int(SHARE * machine))
