"""The websocket of a session: JSON control, binary telemetry; docs/stream.md is its contract."""

from __future__ import annotations

import asyncio
import time
from collections import deque

from fastapi import WebSocket
from pydantic import ValidationError

from motionlab.reports.problems import PREFIX, TYPES
from motionlab.server.http.connection_limits import Socket, current
from motionlab.server.http.problems import Problem
from motionlab.server.live.broadcast import Broadcast
from motionlab.server.live.clock import FRAME_SECONDS
from motionlab.server.live.messages import (
    Acknowledge,
    ErrorMessage,
    Gap,
    Greeting,
    Reset,
    ServerMessage,
    Subscribe,
    Subscribed,
    client_message,
)
from motionlab.server.live.notification import Listener
from motionlab.server.live.session import Session
from motionlab.server.prometheus import Monitor
from motionlab.telemetry.frames import PROTOCOL, header
from motionlab.timing import CONTROL_PERIOD

LAG_SECONDS = 0.25
"""Age of the oldest unacknowledged frame at which no more are sent."""

FRAME_TICKS_MAX = 4000
"""Ticks in one frame at most; a resuming client gets several."""

ANSWERS_MAX = 64
"""Queued answers to a client that does not read; older ones are dropped."""

DETAIL_MAX = 200
"""Characters of an error's detail, which may quote the client."""

_GOING_AWAY, _POLICY_VIOLATION = 1001, 1008


class Stream(Listener):
    """One client of a session's stream.

    Messages are handled on arrival. New data is sent in the broadcast's rounds, one frame at a time
    and none while the client lags or does not read. Nothing is queued beyond the ring, which is
    shared.

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
        self._unacknowledged: deque[tuple[int, float]] = deque()
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
        if self.has_changed and self._socket.has_room:
            self.has_changed = False
            await self._websocket.send_text(self._session.announcement())
        if self._pending() and not self._lags() and self._socket.has_room:
            await self._send_frame()
            if self._pending():  # a client that resumes gets several
                self.notify()

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
            case Acknowledge():
                while self._unacknowledged and self._unacknowledged[0][0] <= message.sequence:
                    self._unacknowledged.popleft()
                if self._lagging and self._pending():
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
        return new >= (self._frame_ticks if self._session.runs else 1)

    def _lags(self) -> bool:
        """Return whether the client is behind; once behind it must catch up wholly."""
        if not self._unacknowledged:
            self._lagging = False
        elif not self._lagging and time.monotonic() - self._unacknowledged[0][1] > LAG_SECONDS:
            self._lagging = self._skips = True
        return self._lagging

    async def _send_frame(self) -> None:
        history = self._session.history
        ring = history.ring
        start = max(self._next, ring.first)
        if self._skips:
            start = max(start, ring.end - round(FRAME_SECONDS / CONTROL_PERIOD))
        stop = min(ring.end, start + FRAME_TICKS_MAX)
        try:
            payload = history.payload(self._rows, start, stop)
        except IndexError:  # overwritten while it was read: the next round begins later
            self.notify()
            return
        self._skips = False
        skipped, self._next = self._next, stop
        if start > skipped:
            frames = max(1, round((start - skipped) * CONTROL_PERIOD / FRAME_SECONDS))
            self._monitor.dropped.inc(frames)
            gap = Gap(from_tick=skipped, to_tick=start, frames=frames)
            await self._websocket.send_text(gap.model_dump_json())
            if not self._socket.has_room:  # to wait for this client would hold up all others
                self._next = start
                return
        self._unacknowledged.append((self._sequence, time.monotonic()))
        head = header(len(self._rows), self._sequence, stop - start, start)
        self._sequence += 1
        self._monitor.frames.inc()
        await self._websocket.send_bytes(head + payload)


async def refuse(websocket: WebSocket, reason: str) -> None:
    """Refuse a client before the hand-shake is over."""
    await websocket.close(_POLICY_VIOLATION, reason)
