"""The websocket of a session: JSON control, binary telemetry; docs/stream.md is its contract."""

from __future__ import annotations

import asyncio
import time
from collections import deque
from dataclasses import dataclass

from fastapi import WebSocket
from pydantic import ValidationError

from motionlab.reports.problems import PREFIX, TYPES
from motionlab.server.http.connection_limits import Socket, current
from motionlab.server.http.problems import Problem
from motionlab.server.live.broadcast import Broadcast
from motionlab.server.live.clock import FRAME_SECONDS
from motionlab.server.live.line import Line
from motionlab.server.live.messages import (
    Acknowledge,
    Delay,
    ErrorMessage,
    Gap,
    Greeting,
    Named,
    Person,
    Reset,
    ServerMessage,
    Subscribe,
    Subscribed,
    WhenBehind,
    client_message,
)
from motionlab.server.live.notification import Listener
from motionlab.server.live.session import Session
from motionlab.server.prometheus import Monitor
from motionlab.telemetry.frames import HEADER_BYTES, PROTOCOL, header
from motionlab.timing import CONTROL_PERIOD

LAG_SECONDS = 0.25
"""Age of the oldest unacknowledged frame at which no more are sent to a client that skips."""

DELAY_SECONDS = 1.0
"""Time between two reports of how late samples are."""

FRAME_TICKS_MAX = 4000
"""Ticks in one frame at most; a resuming client gets several."""

ANSWERS_MAX = 64
"""Queued answers to a client that does not read; older ones are dropped."""

DETAIL_MAX = 200
"""Characters of an error's detail, which may quote the client."""

_GOING_AWAY, _POLICY_VIOLATION = 1001, 1008


@dataclass(frozen=True, slots=True)
class Piece:
    """Ticks [start, stop) as one frame, a sample for each `stride`."""

    start: int
    stop: int
    stride: int = 1


class Stream(Listener):
    """One client of a session's stream.

    Messages are handled on arrival. New data is sent in the broadcast's rounds, one frame at a time
    and none while the client lags or does not read. Nothing is queued beyond the ring, which is
    shared. What a client that lags misses is its own choice: ticks, all but the extremes, or none.

    Parameters
    ----------
    websocket : WebSocket
        Accepted by `serve`.
    session : Session
        What is streamed.
    """

    def __init__(self, websocket: WebSocket, session: Session) -> None:
        super().__init__()
        self._websocket = websocket
        socket = current()
        assert isinstance(socket, Socket)
        self._socket = socket
        self._broadcast: Broadcast = websocket.app.state.broadcast
        self._monitor: Monitor = websocket.app.state.monitor
        self._session = session
        self._rows: tuple[int, ...] = ()
        self._next = 0
        self._frame_ticks = 1
        self._sequence = 0
        self._line = Line()
        self._when_behind: WhenBehind = "skip"
        self._delay_due = 0.0
        self._lagging = False
        self._skips = False
        self._answers: deque[ServerMessage] = deque(maxlen=ANSWERS_MAX)

    async def serve(self) -> None:
        """Serve until either side leaves."""
        await self._websocket.accept()
        self._session.listeners.add(self)
        self._monitor.clients.inc()
        await self._websocket.send_text(self._hello())
        self._socket.drained = self.notify
        leaving = asyncio.create_task(self._receive())
        ending = asyncio.create_task(self.wake.wait())
        try:
            await asyncio.wait((leaving, ending), return_when=asyncio.FIRST_COMPLETED)
            if not leaving.done():
                await self._websocket.close(_GOING_AWAY, "the session has ended")
        finally:
            leaving.cancel()
            ending.cancel()
            self._broadcast.forget(self)
            self._session.listeners.discard(self)
            self._session.people.leave(self)
            self._monitor.clients.dec()
            self._session.touched = time.monotonic()

    def notify(self) -> None:
        """Send in the next round."""
        self._broadcast.wake(self)

    async def send(self) -> None:
        """Send what is new, as far as the client has room for it, and so without waiting."""
        if self._session.closed:
            self.wake.set()  # and so `serve` ends
            return
        self._take_reset()
        while self._answers and self._socket.has_room:
            await self._websocket.send_text(self._answers.popleft().model_dump_json())
        if self.has_changed and self._socket.has_room and self._has_room_for_news():
            self.has_changed = False
            news = self._session.announcement()
            self._line.attach(len(news))
            await self._websocket.send_text(news)
        if self._pending() and not self._lags() and self._socket.has_room:
            sent = await self._send_frame()
            if sent and self._pending():  # a client that resumes gets several
                self.notify()

    def _has_room_for_news(self) -> bool:
        """Return whether news need not wait for a line that is slow; then only the latest count."""
        return self._when_behind == "skip" or self._line.idle or self._line.room > 0

    def _hello(self) -> str:
        head = Greeting(
            protocol=PROTOCOL, rate=round(1.0 / CONTROL_PERIOD), variants=self._session.variants
        )
        columns, session = self._session.history.columns_json, self._session.info()
        return f'{head.model_dump_json()[:-1]},"columns":{columns},"session":{session}}}'

    async def _receive(self) -> None:
        """Handle messages until the client leaves; their time counts as the client's."""
        while (message := await self._websocket.receive())["type"] == "websocket.receive":
            begun = time.perf_counter()
            self._take(message.get("text"))
            self._socket.spend(begun)

    def _answer(self, message: ServerMessage) -> None:
        self._answers.append(message)
        self.notify()

    def _take(self, text: str | None) -> None:
        try:
            message = client_message.validate_json(text or "")
        except ValidationError as error:
            first = error.errors(include_url=False, include_context=False, include_input=False)[0]
            field = "".join(f"{part}: " for part in first["loc"][1:])  # the first is the type
            self._refuse(f"not a message of this protocol: {field}{first['msg']}")
            return
        match message:
            case Subscribe():
                self._subscribe(message)
            case Person(name=name, key=key):
                self._answer(Named(name=self._session.people.enter(self, key=key, name=name)))
            case Acknowledge():
                self._line.acknowledged(message.sequence)
                waits = self._lagging if self._when_behind == "skip" else True
                if waits and (self._pending() or self.has_changed):
                    self.notify()

    def _subscribe(self, message: Subscribe) -> None:
        rows = self._session.history.rows
        unknown = [name for name in message.columns if name not in rows]
        if unknown:
            self._refuse(f"no column {unknown[0]!r}")
            return
        if len(set(message.columns)) < len(message.columns):
            self._refuse("a column is named twice")
            return
        self._take_reset()
        ring = self._session.history.ring
        self._rows = tuple(rows[name] for name in message.columns)
        start = ring.end if message.from_tick is None else message.from_tick
        self._next = min(max(start, ring.first), ring.end)
        self._frame_ticks = message.frame_ticks or 1
        self._when_behind = message.when_behind or "skip"
        self._skips = False  # the first tick has just been announced
        self._answer(Subscribed(columns=message.columns, from_tick=self._next))

    def _refuse(self, detail: str) -> None:
        status, title, _ = TYPES["invalid-message"]
        problem = Problem(
            type=f"{PREFIX}invalid-message",
            title=title,
            status=status,
            detail=detail[:DETAIL_MAX],
            errors=[],
        )
        self._answer(ErrorMessage(problem=problem))

    def _take_reset(self) -> None:
        """Switch to the new timeline, announced before any of its data."""
        if self.was_reset:
            self.was_reset = False
            self._next = 0
            self._answers.append(Reset())

    def _pending(self) -> bool:
        if self.was_reset or not self._rows:  # a frame of the new timeline must follow the reset
            return False
        new = self._session.history.ring.end - self._next
        least = self._frame_ticks
        if self._when_behind == "thin" and self._line.stride > 1:  # whole bins
            least = max(least, 2 * self._line.stride)
        return new >= (least if self._session.runs else 1)

    def _lags(self) -> bool:
        """Return whether a client that skips is behind; once behind it must catch up wholly."""
        oldest = self._line.oldest
        if oldest is None or self._when_behind != "skip":
            self._lagging = False
        elif not self._lagging and time.monotonic() - oldest > LAG_SECONDS:
            self._lagging = self._skips = True
        return self._lagging

    async def _send_frame(self) -> bool:
        """Send the next frame, if the line has room for one; return whether it had."""
        history = self._session.history
        piece = self._next_piece()
        if piece is None:
            return False
        start, stop, stride = piece.start, piece.stop, piece.stride
        try:
            payload = history.payload(self._rows, start, stop, stride)
        except IndexError:  # overwritten while it was read: the next round begins later
            self.notify()
            return False
        self._skips = False
        skipped, self._next = self._next, stop
        if start > skipped:
            frames = max(1, round((start - skipped) * CONTROL_PERIOD / FRAME_SECONDS))
            self._monitor.dropped.inc(frames)
            gap = Gap(from_tick=skipped, to_tick=start, frames=frames)
            await self._websocket.send_text(gap.model_dump_json())
            if not self._socket.has_room:  # to wait for this client would hold up all others
                self._next = start
                return False
        age = (history.ring.end - start) / self._ticks_a_second if self._session.runs else 0.0
        head = header(len(self._rows), self._sequence, (stop - start) // stride, start, stride)
        self._line.sent(self._sequence, len(head) + len(payload), age=age)
        self._line.note_backlog(waits=self._pending())
        self._sequence += 1
        self._monitor.frames.inc()
        await self._websocket.send_bytes(head + payload)
        await self._report_delay()
        return True

    def _next_piece(self) -> Piece | None:
        """Return what the next frame holds; none while the line has no room for it."""
        ring, runs = self._session.history.ring, self._session.runs
        start, end = max(self._next, ring.first), ring.end
        if self._when_behind == "skip":
            if self._skips:
                start = max(start, end - round(FRAME_SECONDS / CONTROL_PERIOD))
            return Piece(start, min(end, start + FRAME_TICKS_MAX))
        tick_bytes = 4 * len(self._rows)
        stride = 1
        if self._when_behind == "thin":
            self._line.adapt(tick_bytes * self._ticks_a_second if runs else 0.0)
            stride = self._line.stride_of(tick_bytes * (end - start))
        while stride > 1 and 2 * stride > end - start:
            if runs and stride <= self._line.stride:  # the rest of the bin is still to come
                return None
            stride //= 2
        bin_ticks = 2 * stride if stride > 1 else 1
        bin_bytes = tick_bytes * bin_ticks // stride
        fitting = (self._line.room - HEADER_BYTES) // bin_bytes
        if self._line.idle:
            fitting = max(fitting, 1)
        most = FRAME_TICKS_MAX * stride // bin_ticks
        bins = min(fitting, most, (end - start) // bin_ticks)
        if bins <= 0:
            self._line.note_backlog(waits=True)
            return None
        return Piece(start, start + bins * bin_ticks, stride)

    @property
    def _ticks_a_second(self) -> float:
        """Ticks a second while the session runs."""
        return (self._session.speed if self._session.state == "playing" else 1.0) / CONTROL_PERIOD

    async def _report_delay(self) -> None:
        now, delay = time.monotonic(), self._line.delay
        if self._when_behind != "thin" or delay is None or now < self._delay_due:
            return
        self._delay_due, self._line.delay = now + DELAY_SECONDS, None
        if self._socket.has_room:
            await self._websocket.send_text(Delay(seconds=round(delay, 4)).model_dump_json())


async def refuse(websocket: WebSocket, reason: str) -> None:
    """Refuse a client before the hand-shake is over."""
    await websocket.close(_POLICY_VIOLATION, reason)
