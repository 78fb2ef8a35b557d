"""What a session has to tell a stream or a stage, which looks when it is woken."""

from __future__ import annotations

import asyncio


class Listener:
    """What is new for one listener; it takes the flags back itself."""

    def __init__(self) -> None:
        self.wake = asyncio.Event()
        self.was_reset = False
        self.has_changed = False

    def reset(self) -> None:
        """Tell that the session is back at tick 0."""
        self.was_reset = True
        self.wake.set()

    def state_changed(self) -> None:
        """Tell that state, speed or parameters have changed."""
        self.has_changed = True
        self.wake.set()
