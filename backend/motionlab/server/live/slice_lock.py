"""The lock of a session, taken by a slice that advances it or by a command between two slices."""

from __future__ import annotations

import asyncio
import contextlib
import threading
import time
from collections.abc import AsyncIterator

_CLAIM_SECONDS = 0.001  # how often a command tries to act
_YIELD_SECONDS = 0.0005  # how often whoever advances looks whether a command has acted
_YIELD_MOST = 0.005  # s, between two slices


class SliceLock:
    """A lock that never blocks the event loop, and that threads hand over between slices."""

    def __init__(self) -> None:
        self.slice = threading.Lock()
        self.waiting = 0

    @contextlib.asynccontextmanager
    async def claimed(self) -> AsyncIterator[None]:
        """Hold it between two slices; other sessions' commands do not wait meanwhile."""
        self.waiting += 1
        try:
            while not self.slice.acquire(blocking=False):
                await asyncio.sleep(_CLAIM_SECONDS)
        finally:
            self.waiting -= 1
        try:
            yield
        finally:
            self.slice.release()

    def give_way(self) -> None:
        """Let commands that wait act; a thread calls it after each slice."""
        until = time.monotonic() + _YIELD_MOST
        while self.waiting and time.monotonic() < until:
            time.sleep(_YIELD_SECONDS)
