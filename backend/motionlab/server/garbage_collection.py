"""Cyclic garbage of the server, collected where it delays no STOP.

A full collection goes through all objects of the process and holds the interpreter's lock
meanwhile: 100 to 300 ms of a server at rest, more beside wide sessions. Here what has survived one
is frozen, so that the next only goes through what is new since, some 20,000 objects. What was
frozen and has become garbage waits for a sweep of everything. That comes while nothing moves, or
once the process has grown by `GROWTH_MAX` beyond its sessions since the last one.
"""

from __future__ import annotations

import asyncio
import contextlib
import gc
import logging
import os
import time
from collections.abc import Callable
from pathlib import Path

GROWTH_MAX = 400_000_000
"""Bytes of resident memory beyond that of sessions after which a sweep does not wait for rest."""

_THRESHOLDS = (700, 10, 3)  # of new objects, and of collections of each generation
_PERIOD = 5.0  # s
_REST_SECONDS = 2.0  # without motion, before a sweep: who has just stopped may go on at once
_WORTH = 300  # collections since the last sweep, of some 20,000 new objects each
_OLDEST = 2  # generation
_STATM = Path("/proc/self/statm")
_PAGE = os.sysconf("SC_PAGE_SIZE")
_LOG = logging.getLogger(__name__)


class GarbageCollection:
    """Collections of this process: small ones as they come, sweeps of everything at rest."""

    def __init__(self, moving: Callable[[], bool], held: Callable[[], int]) -> None:
        self._moving = moving
        self._held = held
        self._collections = 0  # since the last sweep
        self._moved = time.monotonic()
        self._size = 0  # of the process without sessions, after the last sweep
        self._thresholds = gc.get_threshold()

    def begin(self) -> None:
        """Freeze what a start has made, and whatever survives a full collection from now on."""
        if self._freeze not in gc.callbacks:
            gc.callbacks.append(self._freeze)
        gc.set_threshold(*_THRESHOLDS)
        self._sweep()

    def end(self) -> None:
        """Collect as Python does by itself."""
        with contextlib.suppress(ValueError):
            gc.callbacks.remove(self._freeze)
        gc.set_threshold(*self._thresholds)
        gc.unfreeze()

    async def keep_collecting(self) -> None:
        """Sweep when it is worth it and nothing moves; runs for ever."""
        while True:
            await asyncio.sleep(_PERIOD)
            self.look(time.monotonic())

    def look(self, now: float) -> None:
        """Sweep if this is the moment for it; `now` is of the monotonic clock, s."""
        if self._moving():
            self._moved = now
        rests = now - self._moved > _REST_SECONDS
        if (rests and self._collections >= _WORTH) or self._growth() > GROWTH_MAX:
            self._sweep()

    def _growth(self) -> int:
        return _resident() - self._held() - self._size

    def _sweep(self) -> None:
        begun = time.perf_counter()
        gc.unfreeze()
        count = gc.collect()  # whose end freezes what is left
        gc.collect()  # of nothing: else Python waits until a quarter as many objects are new
        self._collections = 0
        self._size = _resident() - self._held()
        took = 1e3 * (time.perf_counter() - begun)
        _LOG.info("garbage collection: %d objects, %.0f ms", count, took)

    def _freeze(self, phase: str, info: dict[str, int]) -> None:
        if phase == "stop" and info["generation"] == _OLDEST:
            self._collections += 1
            gc.freeze()


def _resident() -> int:
    return int(_STATM.read_text().split()[1]) * _PAGE
