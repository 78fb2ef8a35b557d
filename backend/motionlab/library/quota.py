"""The room that runs and recordings take together, and what is evicted when it is used up."""

from __future__ import annotations

import logging
import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from motionlab.errors import ConfigError, FieldError, StoreFull

if TYPE_CHECKING:
    from motionlab.library.index import Index

QUOTA = 10_000_000_000
"""Most that runs and recordings take together, bytes; MOTIONLAB_RUNS_MAX is another one."""

_LOG = logging.getLogger(__name__)


class Room:
    """One quota for runs, what is being recorded and captures."""

    def __init__(self, index: Index, spools: Path, remove: Callable[[str], None]) -> None:
        self._index = index
        self._spools = spools
        self._remove = remove

    def make_room(self, size: int, *, instead_of: str = "") -> None:
        """Evict runs that no person keeps, the oldest first, until `size` bytes fit the quota.

        What is being recorded counts; it gives way by itself where kept runs need its room.

        Parameters
        ----------
        size : int
            Of the new run, bytes.
        instead_of : str
            Its recording, which goes.

        Raises
        ------
        StoreFull
            If it does not fit however many are evicted; none is evicted then.
        """
        self.check(size)
        held, _ = self._index.sizes()
        self._evict(held + size + self.recorded(instead_of) - quota())

    def check(self, size: int) -> None:
        """Refuse what does not fit beside the runs that are kept or pinned.

        Raises
        ------
        StoreFull
            If so.
        """
        most = quota()
        _, kept = self._index.sizes()
        if kept + size > most:
            raise StoreFull(
                f"runs may take {most} bytes (MOTIONLAB_RUNS_MAX), those that are kept or pinned "
                f"take {kept}, and this one would take {size}: delete some that are no longer "
                "needed, or raise MOTIONLAB_RUNS_MAX"
            )

    def balance(self, *active: str, reserve: float = 0.0) -> int:
        """Evict what exceeds the quota, and return the bytes that live recordings may take.

        Parameters
        ----------
        *active : str
            What is being recorded.
        reserve : float
            Share of the quota that is to be free, for what comes until the next call.
        """
        most, recorded = quota(), self.recorded()
        held, _ = self._index.sizes()
        held -= self._evict(held + recorded + int(reserve * most) - most)
        return most - held - self.recorded(*active)

    def recorded(self, *without: str) -> int:
        """Return the bytes of recordings, also of those that wait to be made runs."""
        from motionlab.library import spool  # noqa: PLC0415 - slow to load, and not always wanted

        names = set(spool.waiting(self._spools)) - set(without)
        return sum(spool.size_of(self._spools, name) for name in names)

    def _evict(self, excess: int) -> int:
        """Evict so many bytes, or what there is; return how many."""
        evicted = 0
        for run_id, size in self._index.evictable() if excess > 0 else ():
            if evicted >= excess:
                break
            run = self._index.get(run_id)
            if run is not None and self._index.condemn(run_id):
                self._remove(run_id)
                evicted += size
                if run.deleted is None:
                    self._index.note_eviction(run)
                    _LOG.warning(
                        "%s %r was evicted: recordings that no person keeps go, the oldest first, "
                        "when runs take MOTIONLAB_RUNS_MAX",
                        run_id,
                        run.name,
                    )
        return evicted


def quota() -> int:
    """Return how many bytes of telemetry are kept.

    Raises
    ------
    ConfigError
        If MOTIONLAB_RUNS_MAX is no whole number of bytes.
    """
    text = os.environ.get("MOTIONLAB_RUNS_MAX") or str(QUOTA)
    if not text.isascii() or not text.isdigit():
        raise ConfigError(
            FieldError("MOTIONLAB_RUNS_MAX", "is no whole number", text, ">= 0", "bytes")
        )
    return int(text)
