"""Limits on the size and duration of client connections, HTTP and websocket."""

from __future__ import annotations

import asyncio
import math
import sys
import time
from collections import deque
from collections.abc import Callable
from typing import Any, cast

from uvicorn.protocols.http.httptools_impl import HttpToolsProtocol
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol
from websockets.exceptions import InvalidMessage
from websockets.frames import Opcode

from motionlab.server.settings import Settings

try:
    from websockets.speedups import apply_mask
except ImportError:  # a platform that it is not compiled for
    from websockets.utils import apply_mask

HEAD_MAX = 64 * 1024
"""Bytes of a request's head, or of what follows a body, that may wait for its end."""

HEAD_SECONDS = 30.0
"""How long a head may take, from the connection's or the request's first byte, s."""

BODY_SECONDS = 60.0
"""How long a body may take, s."""

READ_GRACE = 30.0
"""How long a client may take over any answer, s; beyond it, it has to read at `READ_RATE`."""

READ_RATE = 64 * 1024
"""Least rate at which an answer has to be read, bytes/s."""

ANSWERED_LATELY = 10.0
"""Time for which a client that was answered is not the first to lose its connection, s."""

SOCKET_SHARE = 0.1
"""Share of the event loop's time that the messages of one websocket may take."""

SOCKETS_SHARE = 0.5
"""Share of it that those of all websockets together may take, each its equal part."""

SOCKET_BURST = 0.02
"""Time that one websocket's messages may take at once after a silence, s; less with many."""

UNREAD_MAX = 64 * 1024
"""Bytes that may wait for a client before its pings are no longer answered."""


_HEAD_TOO_LARGE = f"The head of a request has more than {HEAD_MAX} bytes."
_HEADER_MARKS = 4  # bytes: a colon, a space and the end of the line
_FINAL, _MASKED, _TEXT = 0x80, 0x80, 0x81  # RFC 6455, 5.2
_SHORT = 126 + 6  # bytes: a frame whose length needs one byte, with its head and mask
_PIECE = 1024  # bytes that are parsed at a time: some 200 messages of the shortest
_TURN = 0.002  # s for which one websocket is read without a look at others
_LEAST_BURST = 0.0005  # s
_LONGEST_PIECE = 0.001  # s
_LONGEST_WAIT = 1.0  # s


class Connection(HttpToolsProtocol):
    """HTTP as uvicorn speaks it, with deadlines for heads, bodies and readers.

    Attributes
    ----------
    connections_max : int
        Connections in all. A further one takes the place of that which has waited longest for its
        client: idle, or with a request that has not arrived; of those that were answered lately
        only where there is no other. So slow clients keep no others out.
    websockets_max : int
        Websockets among them; a further one is refused.
    """

    connections_max = Settings().connections_max
    websockets_max = Settings().websockets_max

    _waiting = 0
    _head = 0
    _deadline: asyncio.TimerHandle | None = None
    _reading: asyncio.TimerHandle | None = None
    _since = 0.0
    _answered = -math.inf

    def connection_made(self, transport: Any) -> None:
        """Begin to wait for a head."""
        if len(self.connections) >= self.connections_max and not self._make_room():
            transport.abort()  # every place is held by an answer or a websocket
            self.transport = transport
            return
        super().connection_made(transport)
        self._since = self.loop.time()
        self._set_deadline(HEAD_SECONDS, "head")

    def connection_lost(self, exc: Exception | None) -> None:
        """Wait no longer."""
        self._clear_deadline()
        if self._reading is not None:
            self._reading.cancel()
        if self.flow is not None:
            super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        """Parse incoming data, or refuse it if too much is pending."""
        if self.flow is None:
            return
        self._waiting += len(data)
        super().data_received(data)
        if self._waiting > HEAD_MAX:
            self._refuse(_HEAD_TOO_LARGE)

    def on_message_begin(self) -> None:
        """Begin to wait for a head."""
        super().on_message_begin()
        self._head = 0
        self.scope["extensions"] = {"motionlab.abort": self.transport.abort}  # pyright: ignore
        if self._deadline is None:
            self._set_deadline(HEAD_SECONDS, "head")

    def on_url(self, url: bytes) -> None:
        """Take a piece of a path, which counts as part of the head."""
        self._count_head(len(url))
        super().on_url(url)

    def on_header(self, name: bytes, value: bytes) -> None:
        """Take a header; those that follow a body have the same bound."""
        self._count_head(len(name) + len(value) + _HEADER_MARKS)
        super().on_header(name, value)

    def on_headers_complete(self) -> None:
        """Begin to wait for a body."""
        self._waiting = self._head = 0
        self._clear_deadline()
        super().on_headers_complete()
        self._set_deadline(BODY_SECONDS, "body")

    def on_body(self, body: bytes) -> None:
        """Take a piece of a body; the application bounds the whole."""
        self._waiting = 0
        super().on_body(body)

    def on_message_complete(self) -> None:
        """Take the end of a request."""
        self._waiting = 0
        self._clear_deadline()
        super().on_message_complete()

    def on_response_complete(self) -> None:
        """Begin to wait for the next request."""
        self._since = self._answered = self.loop.time()
        super().on_response_complete()

    def send_400_response(self, msg: str) -> None:
        """Refuse a request, unless it is refused already."""
        if not self.transport.is_closing():
            super().send_400_response(msg)

    def pause_writing(self) -> None:
        """Watch a client that does not read as fast as it is answered."""
        super().pause_writing()
        if self._reading is None:
            self._watch_reader(self.transport.get_write_buffer_size())

    def resume_writing(self) -> None:
        """Watch it no longer."""
        if self._reading is not None:
            self._reading.cancel()
            self._reading = None
        super().resume_writing()

    def handle_websocket_upgrade(self) -> None:
        """Upgrade to a websocket, or refuse a request that would wait without an answer."""
        self._clear_deadline()
        sockets = sum(isinstance(c, Socket) for c in self.connections)
        if sockets >= self.websockets_max:
            self._refuse(f"There are {sockets} websockets already.")
            return
        super().handle_websocket_upgrade()
        taken_over = self.transport.get_protocol()
        refused = getattr(getattr(taken_over, "conn", None), "handshake_exc", None)
        if isinstance(refused, InvalidMessage) and not self.transport.is_closing():
            self.send_400_response("A websocket is asked for by a GET of some short headers.")

    def _count_head(self, size: int) -> None:
        """Bound a head that arrives whole, which never waits for its end."""
        self._head += size
        if self._head > HEAD_MAX:
            self._refuse(_HEAD_TOO_LARGE)
            raise ValueError(_HEAD_TOO_LARGE)  # which ends the parser

    def _make_room(self) -> bool:
        """Abort what has waited longest for its client; return whether there was such a one."""
        waiting = [c for c in self.connections if isinstance(c, Connection) and c._waits_for_client]
        if not waiting:
            return False
        lately = self.loop.time() - ANSWERED_LATELY
        longest = min(waiting, key=lambda each: (each._answered > lately, each._since))
        longest.transport.abort()
        longest.connections.discard(longest)  # now, and not only when the event loop comes to it
        return True

    @property
    def _waits_for_client(self) -> bool:
        return self._deadline is not None or self.cycle is None or self.cycle.response_complete

    def _set_deadline(self, seconds: float, what: str) -> None:
        self._deadline = self.loop.call_later(
            seconds, self._refuse, f"The {what} of a request took more than {seconds:g} s."
        )

    def _clear_deadline(self) -> None:
        if self._deadline is not None:
            self._deadline.cancel()
            self._deadline = None

    def _watch_reader(self, unread: int) -> None:
        self._reading = self.loop.call_later(READ_GRACE, self._check_reader, unread)

    def _check_reader(self, unread: int) -> None:
        now = self.transport.get_write_buffer_size()
        if unread - now < READ_GRACE * READ_RATE:
            self.transport.abort()
        else:
            self._watch_reader(now)

    def _refuse(self, reason: str) -> None:
        self._clear_deadline()
        if self.transport.is_closing():
            return
        if self.cycle is None or self.cycle.response_complete:
            self.send_400_response(reason)
        else:
            self.transport.abort()  # in the middle of an answer


def bounded(settings: Settings) -> type[Connection]:
    """Return the class of connections with the bounds of a server's settings."""
    bounds = ("connections_max", "websockets_max")
    return type("Bounded", (Connection,), {name: getattr(settings, name) for name in bounds})


def _end_of_frame(data: bytes, at: int) -> int:
    """Return where the websocket frame that begins at `at` ends; -1 where its head is cut off."""
    if len(data) < at + 2:
        return -1
    length, start = data[at + 1] & 0x7F, at + 2
    if length >= 126:  # RFC 6455, 5.2
        start += 2 if length == 126 else 8
        if len(data) < start:
            return -1
        length = int.from_bytes(data[at + 2 : start], "big")
    return start + length + (4 if data[at + 1] & _MASKED else 0)


class Socket(WebSocketsSansIOProtocol):
    """A websocket as uvicorn speaks it, with a bound on the work that its client may cause.

    Incoming data is parsed in small pieces, and not while its client has used up its share of the
    event loop's time: the rest waits in the client's own kernel.

    The application may receive messages directly by `take` and send its own by `write`: for a
    stream of frames a fraction of the work of one ASGI message each.
    """

    written = 0
    """Bytes of messages that were sent by `write`."""

    _taker: Callable[[bytes | None], None] | None = None
    _drained: Callable[[], None] | None = None

    def connection_made(self, transport: Any) -> None:
        """Begin to count its time."""
        super().connection_made(transport)
        self._credit = SOCKET_BURST
        self._counted = time.perf_counter()
        self._rest = b""  # the beginning of a frame
        self._left = 0  # bytes of a frame that are still the library's
        self._pieces: deque[bytes] = deque()
        self._later: asyncio.TimerHandle | None = None

    def connection_lost(self, exc: Exception | None) -> None:
        """Tell who waits to write."""
        if self._later is not None:
            self._later.cancel()
        self._pieces.clear()
        super().connection_lost(exc)
        if self._drained is not None:
            self._drained()

    async def run_asgi(self) -> None:
        """Serve, with this connection in the ASGI scope."""
        cast(dict[str, Any], self.scope).setdefault("extensions", {})["motionlab.socket"] = self
        await super().run_asgi()

    def take(self, taker: Callable[[bytes | None], None], drained: Callable[[], None]) -> None:
        """Hand over messages as they come.

        Parameters
        ----------
        taker : callable
            Takes the text of every message; None for a binary one.
        drained : callable
            Called when there is room to write again.
        """
        self._taker, self._drained = taker, drained
        waiting = []
        while not self.queue.empty():
            waiting.append(self.queue.get_nowait())
        for message in waiting:
            if message["type"] == "websocket.receive":
                text = message.get("text")
                taker(None if text is None else text.encode())
            else:
                self.queue.put_nowait(message)
        self.read_paused = False
        self._read_on()

    @property
    def has_room(self) -> bool:
        """Whether little enough waits for the client that more can be written."""
        return self.writable.is_set() and not self.transport.is_closing()

    def write(self, opcode: Opcode, *parts: bytes) -> None:
        """Send a message without waiting; `has_room` tells whether the buffer accepts it."""
        if self.close_sent or self.transport.is_closing():
            return
        length = sum(map(len, parts))
        self.written += length
        if length < 126:  # RFC 6455, 5.2
            head = bytes((_FINAL | opcode, length))
        elif length < 1 << 16:
            head = bytes((_FINAL | opcode, 126)) + length.to_bytes(2, "big")
        else:
            head = bytes((_FINAL | opcode, 127)) + length.to_bytes(8, "big")
        self.transport.write(b"".join((head, *parts)))

    def data_received(self, data: bytes) -> None:
        """Process incoming data piece by piece, but the head of the request whole.

        `Connection` looks right after the head, and only then, at whether it was refused.
        """
        if not self.handshake_initiated or (len(data) <= _PIECE and not self._pieces):
            self._take_in(data)
        else:
            self._pieces.extend(data[at : at + _PIECE] for at in range(0, len(data), _PIECE))
        self._go_on()

    def resume_writing(self) -> None:
        """Tell who waits to write."""
        super().resume_writing()
        if self._drained is not None:
            self._drained()

    def send_receive_event_to_app(self) -> None:
        """Hand a message on."""
        if self._taker is None:
            super().send_receive_event_to_app()
            return
        data = self.frames[0] if len(self.frames) == 1 else b"".join(self.frames)
        self.frames = []
        if not self.close_sent:
            self._taker(bytes(data) if self.curr_msg_data_type == "text" else None)

    def handle_ping(self) -> None:
        """Answer a ping, unless its client does not read its answers."""
        output = b"".join(self.conn.data_to_send())
        if self.transport.get_write_buffer_size() < UNREAD_MAX:
            self.transport.write(output)

    def _take_in(self, data: bytes) -> None:
        begun = time.perf_counter()
        if self._taker is None:
            super().data_received(data)
        else:
            self._take_frames(data)
        now = time.perf_counter()
        taken = min(now - begun, _LONGEST_PIECE)  # most of a longer time was another process's
        others = max(len(self.connections), 1)
        rate = min(SOCKET_SHARE, SOCKETS_SHARE / others)
        burst = max(SOCKET_BURST / others, _LEAST_BURST)
        self._credit = min(burst, self._credit + (begun - self._counted) * rate) - taken
        self._counted = begun
        if self._credit < 0.0:
            self._wait(min(-self._credit / rate, _LONGEST_WAIT))

    def _take_frames(self, data: bytes) -> None:
        """Take short whole texts straight from their frames; the library takes all others.

        The library receives whole frames only, so that it is always at the beginning of one. After
        a message in several frames, which no client of ours sends, it handles everything that
        follows.
        """
        data, at = self._rest + data, 0
        self._rest = b""
        while at < len(data):  # also once it closes: the client's answer ends the connection
            if self._left > 0:
                passed = min(self._left, len(data) - at)
                super().data_received(data[at : at + passed])
                self._left -= passed
                at += passed
                continue
            end = _end_of_frame(data, at)
            short = data[at] == _TEXT and end - at < _SHORT
            if end < 0 or (short and end > len(data)):
                self._rest = data[at:]
            elif short and data[at + 1] & _MASKED and self._taker is not None:
                if not self.close_sent:
                    self._taker(apply_mask(data[at + 6 : end], data[at + 2 : at + 6]))
                at = end
                continue
            else:
                self._left = end - at if data[at] & _FINAL else sys.maxsize
                continue
            return

    def _go_on(self) -> None:
        """Process pending data for one time slice."""
        until = time.perf_counter() + _TURN
        while self._pieces and self._later is None:
            self._take_in(self._pieces.popleft())
            if self._pieces and time.perf_counter() > until:
                self._wait(0.0)

    def _wait(self, seconds: float) -> None:
        if self._later is None and not self.transport.is_closing():
            self.transport.pause_reading()
            self._later = self.loop.call_later(seconds, self._wait_no_more)

    def _wait_no_more(self) -> None:
        self._later = None
        self._go_on()
        self._read_on()

    def _read_on(self) -> None:
        if self._later is None and not self.read_paused and not self.transport.is_closing():
            self.transport.resume_reading()
