"""Change notification from a session to a stream or a 3-D view."""

from __future__ import annotations

import asyncio


class Listener:
    """Notified of news of a session; clears its flags itself."""

    def __init__(self) -> None:
        self.wake = asyncio.Event()
        self.was_reset = False
        self.has_changed = False

    def notify(self) -> None:
        """Notify of new samples."""
        self.wake.set()

    def reset(self) -> None:
        """Notify that the session is back at tick 0."""
        self.was_reset = True
        self.notify()

    def state_changed(self) -> None:
        """Notify that state, speed or parameters have changed."""
        self.has_changed = True
        self.notify()
