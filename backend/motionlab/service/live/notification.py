"""Change notification from a session to a stream or a 3-D view."""

from __future__ import annotations

import asyncio


class Listener:
    """Is woken when a session has something new, and takes its flags back itself."""

    def __init__(self) -> None:
        self.wake = asyncio.Event()
        self.was_reset = False
        self.has_changed = False

    def notify(self) -> None:
        """Say that there is something new."""
        self.wake.set()

    def reset(self) -> None:
        """Say that the session is back at tick 0."""
        self.was_reset = True
        self.notify()

    def state_changed(self) -> None:
        """Say that state, speed or parameters have changed."""
        self.has_changed = True
        self.notify()
