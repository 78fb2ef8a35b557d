"""The websocket of a session: JSON control, binary telemetry; docs/stream.md is its contract."""

from __future__ import annotations

import asyncio
import contextlib
import time
from collections import deque

from fastapi import WebSocket, WebSocketDisconnect
from pydantic import ValidationError

from motionlab.config.timing import CONTROL_PERIOD
from motionlab.service.listener import Listener
from motionlab.service.messages import (
    Acknowledge,
    ErrorMessage,
    Gap,
    Hello,
    Reset,
    ServerMessage,
    SessionMessage,
    StreamColumn,
    Subscribe,
    Subscribed,
    client_message,
)
from motionlab.service.monitor import Monitor
from motionlab.service.pace import FRAME_SECONDS
from motionlab.service.problems import Problem
from motionlab.service.session import Session
from motionlab.telemetry.frames import PROTOCOL, Frame, encode

LAG_SECONDS = 0.25
"""Age of the oldest unacknowledged frame at which no more are sent."""

FRAME_TICKS_MAX = 4000
"""Ticks in one frame at most; a resuming client gets several."""

ANSWERS_MAX = 64
"""Answers that wait for a client which asks without reading; older ones are dropped."""

DETAIL_MAX = 200
"""Characters of an error's detail, which may quote the client."""

_GOING_AWAY, _POLICY_VIOLATION = 1001, 1008


class Stream:
    """One client of a session's stream.

    The reader takes messages in as they come; the sender sends what is new, at most one frame at a
    time, and stops while the client lags. Nothing is queued beyond the ring, which is shared.

    Parameters
    ----------
    websocket : WebSocket
        Accepted by `serve`.
    session : Session
        What is streamed.
    """

    def __init__(self, websocket: WebSocket, session: Session) -> None:
        self._websocket = websocket
        self._monitor: Monitor = websocket.app.state.monitor
        self._session = session
        self._listener = Listener()
        self._rows = {name: i for i, (name, _) in enumerate(session.history.columns)}
        self._columns: list[int] = []
        self._next = 0
        self._sequence = 0
        self._unacknowledged: deque[tuple[int, float]] = deque()
        self._lagging = False
        self._skips = False
        self._answers: deque[ServerMessage] = deque(maxlen=ANSWERS_MAX)
        self._retry: asyncio.TimerHandle | None = None

    async def serve(self) -> None:
        """Serve until either side leaves."""
        await self._websocket.accept()
        self._session.listeners.add(self._listener)
        self._monitor.clients.inc()
        try:
            await self._tell(self._hello())
            sender = asyncio.create_task(self._send())
            try:
                await self._receive()
            finally:
                sender.cancel()
                with contextlib.suppress(asyncio.CancelledError, WebSocketDisconnect, RuntimeError):
                    await sender
                if self._retry is not None:
                    self._retry.cancel()
        except WebSocketDisconnect:
            pass
        finally:
            self._session.listeners.discard(self._listener)
            self._monitor.clients.dec()
            self._session.touched = time.monotonic()

    def _hello(self) -> Hello:
        return Hello(
            protocol=PROTOCOL,
            rate=round(1.0 / CONTROL_PERIOD),
            variants=self._session.variants,
            columns=[
                StreamColumn(name=name, unit=channel.unit, meaning=channel.meaning)
                for name, channel in self._session.history.columns
            ],
            session=self._session.info(),
        )

    def _answer(self, message: ServerMessage) -> None:
        self._answers.append(message)
        self._listener.wake.set()

    async def _tell(self, message: ServerMessage) -> None:
        await self._websocket.send_text(message.model_dump_json())

    async def _receive(self) -> None:
        while True:
            received = await self._websocket.receive()
            if received["type"] == "websocket.disconnect":
                break
            try:
                message = client_message.validate_json(received.get("text") or "")
            except ValidationError as error:
                self._refuse(f"not a message of this protocol: {error.errors()[0]['msg']}")
                continue
            match message:
                case Subscribe():
                    self._subscribe(message)
                case Acknowledge():
                    while self._unacknowledged and self._unacknowledged[0][0] <= message.sequence:
                        self._unacknowledged.popleft()
                    if self._pending():
                        self._listener.wake.set()

    def _subscribe(self, message: Subscribe) -> None:
        unknown = [name for name in message.columns if name not in self._rows]
        if unknown:
            self._refuse(f"no column {unknown[0]!r}")
            return
        if len(set(message.columns)) < len(message.columns):
            self._refuse("a column is named twice")
            return
        self._take_reset()
        ring = self._session.history.ring
        self._columns = [self._rows[name] for name in message.columns]
        wanted = ring.end if message.from_tick is None else message.from_tick
        self._next = min(max(wanted, ring.first), ring.end)
        self._skips = False  # where to go on has just been said
        self._answer(Subscribed(columns=message.columns, from_tick=self._next))

    def _refuse(self, detail: str) -> None:
        problem = Problem(
            type="about:blank",
            title="Bad message",
            status=400,
            detail=detail[:DETAIL_MAX],
            errors=[],
        )
        self._answer(ErrorMessage(problem=problem))

    async def _send(self) -> None:
        while not self._session.closed:
            await self._listener.wake.wait()
            self._listener.wake.clear()
            self._take_reset()
            while self._answers:
                await self._tell(self._answers.popleft())
            if self._listener.has_changed:
                self._listener.has_changed = False
                await self._tell(SessionMessage(session=self._session.info()))
            while self._pending() and not self._lags():
                await self._send_frame()
            if self._pending() and self._retry is None:
                self._retry = asyncio.get_running_loop().call_later(FRAME_SECONDS, self._try_again)
        await self._websocket.close(_GOING_AWAY, "the session has ended")

    def _try_again(self) -> None:
        self._retry = None
        self._listener.wake.set()

    def _take_reset(self) -> None:
        """Turn to the new timeline and say so before anything of it is sent."""
        if self._listener.was_reset:
            self._listener.was_reset = False
            self._next = 0
            self._answers.append(Reset())

    def _pending(self) -> bool:
        fresh = not self._listener.was_reset  # a frame of the new timeline must follow the reset
        return fresh and bool(self._columns) and self._next < self._session.history.ring.end

    def _lags(self) -> bool:
        """Return whether the client is behind; once behind it must catch up wholly."""
        if not self._unacknowledged:
            self._lagging = False
        elif not self._lagging and time.monotonic() - self._unacknowledged[0][1] > LAG_SECONDS:
            self._lagging = self._skips = True
        return self._lagging

    async def _send_frame(self) -> None:
        ring = self._session.history.ring
        start = max(self._next, ring.first)
        if self._skips:
            start = max(start, ring.end - round(FRAME_SECONDS / CONTROL_PERIOD))
            self._skips = False
        stop = min(ring.end, start + FRAME_TICKS_MAX)
        frame = Frame(self._sequence, start, ring.read(self._columns, start, stop))
        skipped, self._next = self._next, stop
        if start > skipped:
            frames = max(1, round((start - skipped) * CONTROL_PERIOD / FRAME_SECONDS))
            self._monitor.dropped.inc(frames)
            await self._tell(Gap(from_tick=skipped, to_tick=start, frames=frames))
        self._unacknowledged.append((self._sequence, time.monotonic()))
        self._sequence += 1
        self._monitor.frames.inc()
        await self._websocket.send_bytes(encode(frame))


async def refuse(websocket: WebSocket, reason: str) -> None:
    """Turn a client away before the hand-shake is over."""
    await websocket.close(_POLICY_VIOLATION, reason)
