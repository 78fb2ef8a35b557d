"""Fair turns of the streams on the event loop."""

from __future__ import annotations

import asyncio
import logging
import time
from typing import Protocol

TURN_SECONDS = 0.002
"""Time for which streams send before the event loop handles other events, s."""

SHARE = 0.5
"""Share of the event loop's time that streams may take. Where sixty rounds a second would take
more, there are fewer, and their frames hold more ticks: nothing is lost, for any client.
"""

_LOG = logging.getLogger(__name__)


class Sender(Protocol):
    """A source of data to send."""

    async def send(self) -> None:
        """Send pending data as far as buffers have room, without waiting for more of it."""
        ...


class Broadcast:
    """Rounds in which each sender sends at most once."""

    def __init__(self) -> None:
        self._due: dict[Sender, None] = {}
        self._sending: asyncio.Task[None] | None = None
        self._next = 0.0

    def wake(self, sender: Sender) -> None:
        """Add a sender to the next round."""
        self._due[sender] = None
        if self._sending is None:
            self._sending = asyncio.create_task(self._send())

    def forget(self, sender: Sender) -> None:
        """Remove a sender."""
        self._due.pop(sender, None)

    async def _send(self) -> None:
        """Send round after round until nothing is due."""
        try:
            while self._due:
                await asyncio.sleep(max(self._next - time.perf_counter(), 0.0))
                begun, senders = time.perf_counter(), list(self._due)
                self._due.clear()
                self._next = begun + await self._round(senders) / SHARE
        finally:
            self._sending = None

    async def _round(self, senders: list[Sender]) -> float:
        """Have all send, turn by turn; return the processor time that it took, s."""
        spent = 0.0
        until, begun = time.perf_counter() + TURN_SECONDS, time.thread_time()
        for sender in senders:
            try:
                await sender.send()
            except Exception:
                _LOG.exception("a stream failed")
            if time.perf_counter() > until:
                spent += time.thread_time() - begun  # not by the clock: others' work must not count
                await asyncio.sleep(0)
                until, begun = time.perf_counter() + TURN_SECONDS, time.thread_time()
        return spent + time.thread_time() - begun
