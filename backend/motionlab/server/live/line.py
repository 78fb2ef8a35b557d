"""What the line to one client carries: bytes in flight, rate, and how far curves are thinned.

Frames are sent as far as a window has room for the bytes that are not acknowledged yet. The window
is the measured rate times the shortest round trip, twice, and a fifth of a second more: enough to
find a faster line, and little enough that nothing waits long on a slow one.
"""

from __future__ import annotations

import time
from collections import deque
from dataclasses import dataclass

WINDOW_MIN = 8 * 1024
"""Bytes in flight at least."""

QUEUE_SECONDS = 0.2
"""Bytes that may wait on the line, as the time it takes them, s."""

ROUND_TRIP_MAX = 0.2
"""Longest round trip that counts, s: the first ones include what waited on the line."""

BEHIND_SECONDS = 0.3
"""Time for which frames wait for a line without all being sent, until curves are thinned, s."""

STALL_SECONDS = 0.15
"""Of a time without any acknowledgement only so much counts: the client was busy, s."""

SPARE = 0.75
"""Share of the line's rate that thinned curves may take."""

CATCH_UP_SECONDS = 0.5
"""Time in which a line takes all that waited until curves were thinned, s."""

STRIDE_MAX = 128
"""Ticks that a sample stands for at most."""

BACKLOG_STRIDE_MAX = 1024
"""The same, of samples that waited."""

TRIAL_SECONDS = 3.0
"""Time after which finer curves are tried; twice as long after each failure, s."""

TRIAL_SECONDS_MAX = 48.0
JUDGED_SECONDS = 5.0
"""A trial has failed if the line is behind so soon after it, s."""

_LEAST_PART = 4  # of the window
_PAUSE_SECONDS = 2.0  # between two steps
_RATE_SECONDS = 1.0  # whose largest rate counts
_ATTACHED_SECONDS = 0.5  # after which other messages no longer count as in flight


@dataclass(slots=True)
class _Sent:
    sequence: int
    size: int
    at: float
    made: float  # when its oldest sample was
    delivered: int  # bytes until then
    since: float  # when the latest of them were


class Line:
    """The line to one client.

    Attributes
    ----------
    stride : int
        Ticks that a sample of the newest curves stands for: a power of two, 1 while the client
        keeps up.
    delay : float or None
        Longest time from a sample until the client had it, since this was last cleared, s.
    """

    def __init__(self) -> None:
        self.stride = 1
        self.delay: float | None = None
        self._in_flight: deque[_Sent] = deque()
        self._bytes = 0  # of those
        self._attached, self._attached_at = 0, 0.0  # bytes of other messages
        self._delivered, self._delivered_at = 0, 0.0
        self._rates: deque[tuple[float, float]] = deque()
        self._rate = 0.0
        self._round_trip = float("inf")
        self._drained, self._behind = True, 0.0
        self._catches_up = False
        self._next_step = self._last_step = 0.0
        self._tried, self._trial = float("-inf"), TRIAL_SECONDS

    @property
    def oldest(self) -> float | None:
        """When the oldest frame in flight was sent, s of the monotonic clock."""
        return self._in_flight[0].at if self._in_flight else None

    @property
    def room(self) -> int:
        """Bytes that may be sent now; 0 where they are so few that a header would be most of it."""
        waiting = self._bytes
        if time.monotonic() - self._attached_at < _ATTACHED_SECONDS:
            waiting += self._attached
        room = self._window - waiting
        return int(room) if room * _LEAST_PART >= self._window else 0

    @property
    def idle(self) -> bool:
        """Whether nothing is in flight."""
        return not self._in_flight

    @property
    def _window(self) -> float:
        round_trip = min(self._round_trip, ROUND_TRIP_MAX)
        return max(WINDOW_MIN, self._rate * (2 * round_trip + QUEUE_SECONDS))

    def attach(self, size: int) -> None:
        """Count another message as in flight until the next frame is acknowledged."""
        self._attached += size
        self._attached_at = time.monotonic()

    def sent(self, sequence: int, size: int, *, age: float = 0.0) -> None:
        """Note a frame that is sent, and the age of its oldest sample, s."""
        now = time.monotonic()
        if self._attached and now - self._attached_at < _ATTACHED_SECONDS:
            size += self._attached
        self._attached = 0
        if not self._in_flight:
            self._delivered_at = now
        self._in_flight.append(
            _Sent(sequence, size, now, now - age, self._delivered, self._delivered_at)
        )
        self._bytes += size

    def note_backlog(self, *, waits: bool) -> None:
        """Note whether samples wait for the line after a frame was sent, or could not be."""
        self._drained = not waits
        if self._drained:
            self._behind, self._catches_up = 0.0, False

    def acknowledged(self, sequence: int) -> None:
        """Take a frame, and all before it, out of flight."""
        now = time.monotonic()
        newest: _Sent | None = None
        while self._in_flight and self._in_flight[0].sequence <= sequence:
            newest = self._in_flight.popleft()
            self._bytes -= newest.size
            self._delivered += newest.size
            self._round_trip = min(self._round_trip, now - newest.at)
            self.delay = max(self.delay or 0.0, now - newest.made - self._round_trip / 2)
        if newest is None:
            return
        if not self._drained:
            self._behind += min(now - self._delivered_at, STALL_SECONDS)
        self._delivered_at = now
        elapsed = max(now - newest.since, 1e-4)
        self._rates.append((now, (self._delivered - newest.delivered) / elapsed))
        while self._rates[0][0] < now - _RATE_SECONDS:
            self._rates.popleft()
        self._rate = max(rate for _, rate in self._rates)

    def adapt(self, demand: float) -> None:
        """Thin curves further, or less, as the line has been behind or not.

        Parameters
        ----------
        demand : float
            Rate of all samples, bytes/s; 0 while the session rests.
        """
        now = time.monotonic()
        if self._behind >= BEHIND_SECONDS:
            self._catches_up = True
            if demand > 0.0 and now >= self._next_step:
                self._thin_further(demand, now)
        elif (
            self.stride > 1
            and demand > 0.0
            and self._drained
            and now - self._last_step > self._trial
        ):
            self.stride //= 2
            self._tried = self._last_step = now

    def stride_of(self, backlog: float) -> int:
        """Return the ticks that each sample of so many bytes stands for, which wait."""
        stride = self.stride
        if self._catches_up:
            while stride < BACKLOG_STRIDE_MAX and backlog > stride * CATCH_UP_SECONDS * self._rate:
                stride *= 2
        return stride

    def _thin_further(self, demand: float, now: float) -> None:
        before = self.stride
        while self.stride < STRIDE_MAX and demand > self.stride * SPARE * self._rate:
            self.stride *= 2
        repeated = now - self._last_step < 2 * JUDGED_SECONDS and self._next_step > 0.0
        if self.stride == before and repeated:  # the rate is less than it seems
            self.stride = min(2 * before, STRIDE_MAX)
        if self.stride > before:
            failed = now - self._tried < JUDGED_SECONDS
            self._trial = min(2 * self._trial, TRIAL_SECONDS_MAX) if failed else TRIAL_SECONDS
        self._behind, self._last_step = 0.0, now
        self._next_step = now + _PAUSE_SECONDS
