"""Keeping step with the clock, a frame at a time."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable

FRAME_SECONDS = 1.0 / 60.0
CATCH_UP_SECONDS = 0.25
"""Time that may pass between two frames and count; beyond it a session lets go of its clock."""


class Pace:
    """Tells some 60 times a second how much time has passed.

    Parameters
    ----------
    passed : callable
        Takes the time since its last call, s; returns whether to go on.
    """

    def __init__(self, passed: Callable[[float], bool]) -> None:
        self._passed = passed
        self._timer: asyncio.TimerHandle | None = None
        self._last = self._due = 0.0

    def start(self) -> None:
        """Begin now, unless it has begun before."""
        if self._timer is None:
            self._last = self._due = time.monotonic()
            self._wait()

    def stop(self) -> None:
        """End now; time until another start does not count."""
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def _wait(self) -> None:
        self._due = max(self._due + FRAME_SECONDS, self._last)
        delay = self._due - time.monotonic()
        self._timer = asyncio.get_running_loop().call_later(max(delay, 0.0), self._beat)

    def _beat(self) -> None:
        self._timer = None
        now = time.monotonic()
        passed = min(now - self._last, CATCH_UP_SECONDS)
        self._last = now
        if self._passed(passed):
            self._wait()
