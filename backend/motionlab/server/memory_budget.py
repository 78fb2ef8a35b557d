"""Memory budget of recordings, so that no request can exhaust the machine's memory."""

from __future__ import annotations

import contextlib
import os
import threading
from collections.abc import Iterator
from pathlib import Path

from fastapi import HTTPException

from motionlab.errors import ConfigError, FieldError

SHARE = 0.5
"""Share of the machine's memory for recordings."""

_CGROUPS = Path("/sys/fs/cgroup")
_OWN_CGROUPS = Path("/proc/self/cgroup")


class MemoryBudget:
    """Memory that runs reserve and release.

    Parameters
    ----------
    most : int
        Size, bytes.
    """

    def __init__(self, most: int) -> None:
        self._most = most
        self._taken = 0
        self._lock = threading.Lock()

    @property
    def taken(self) -> int:
        """Bytes that are reserved."""
        return self._taken

    def check(self, size: int) -> None:
        """Refuse a run larger than the whole budget.

        Raises
        ------
        ConfigError
            Naming what it would take and what there is.
        """
        if size > self._most:
            raise ConfigError(
                FieldError(
                    "trajectory",
                    "simulated time times variants takes more memory than may be used (memory_max)",
                    size,
                    f"<= {self._most}",
                    "bytes",
                )
            )

    @contextlib.contextmanager
    def hold(self, size: int) -> Iterator[None]:
        """Reserve memory for a run that starts at once, or answer 429 if it is in use."""
        self.take(size)
        try:
            yield
        finally:
            self.give_back(size)

    def take(self, size: int) -> None:
        """Reserve memory, or answer 429 if it is in use."""
        if not self.try_to_take(size):
            raise HTTPException(
                429,
                f"runs and sessions hold {self._taken} of {self._most} bytes (memory_max); this "
                f"takes {size}",
            )

    def give_back(self, taken: int) -> None:
        """Release memory."""
        with self._lock:
            self._taken -= taken

    def try_to_take(self, size: int) -> bool:
        """Reserve memory; return whether there was enough."""
        with self._lock:
            free = self._taken + size <= self._most
            self._taken += size if free else 0
            return free


def recordable(most: int) -> int:
    """Return how many bytes recordings may take on this machine, `most` at most."""
    machine = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    return min(most, int(SHARE * min([machine, *_limits()])))


def _limits() -> Iterator[int]:
    """Yield the memory limits of this process's control groups and of all above them, bytes.

    Lines of ``/proc/self/cgroup`` are ``0::/path`` of version 2 and ``4:memory:/path`` of version
    1. In a container the path may be that of the host, where its own group is at the root.
    """
    try:
        lines = _OWN_CGROUPS.read_text().splitlines()
    except OSError:  # a kernel without control groups
        return
    for line in lines:
        _, _, rest = line.partition(":")
        controllers, _, path = rest.partition(":")
        if controllers and "memory" not in controllers.split(","):
            continue
        root, name = (
            (_CGROUPS / "memory", "memory.limit_in_bytes")
            if controllers
            else (_CGROUPS, "memory.max")
        )
        group = root / path.strip("/")
        for folder in {root, group, *group.parents} - set(root.parents):
            with contextlib.suppress(OSError, ValueError):  # "max", or no such group here
                yield int((folder / name).read_text())
