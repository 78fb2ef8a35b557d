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

    def send(self) -> None:
        """Send pending data as far as buffers have room."""
        ...


class Broadcast:
    """Rounds in which each sender sends at most once."""

    def __init__(self) -> None:
        self._loop = asyncio.get_running_loop()
        self._due: dict[Sender, None] = {}
        self._round: list[Sender] = []
        self._runs = False
        self._begun = self._spent = 0.0

    def wake(self, sender: Sender) -> None:
        """Add a sender to the next round."""
        self._due[sender] = None
        if not self._runs:
            self._runs = True
            next_round = self._begun + self._spent / SHARE
            self._loop.call_later(max(next_round - time.perf_counter(), 0.0), self._begin)

    def forget(self, sender: Sender) -> None:
        """Remove a sender."""
        self._due.pop(sender, None)

    def _begin(self) -> None:
        self._begun, self._spent = time.perf_counter(), 0.0
        self._round = list(self._due)
        self._due = {}
        self._turn()

    def _turn(self) -> None:
        until, begun = time.perf_counter() + TURN_SECONDS, time.thread_time()
        while self._round and time.perf_counter() < until:
            sender = self._round.pop()
            try:
                sender.send()
            except Exception:
                _LOG.exception("a stream failed")
        self._spent += time.thread_time() - begun  # not by the clock: others' work must not count
        if self._round:
            self._loop.call_soon(self._turn)
            return
        self._runs = False
        for sender in self._due:
            self.wake(sender)
            break
