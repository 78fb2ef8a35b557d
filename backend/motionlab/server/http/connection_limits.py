"""Limits on the number of client connections, their heads, their reading and their messages.

`Connection` and `Socket` stand between a transport and a protocol of uvicorn, which takes them as
its classes of protocols (`http`, `ws`). They use of both only what `asyncio.Protocol` and
`asyncio.Transport` document.
"""

from __future__ import annotations

import asyncio
import math
import time
from collections import deque
from collections.abc import Callable
from contextvars import ContextVar
from typing import Any, cast

from starlette.responses import PlainTextResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from uvicorn.protocols.http.httptools_impl import HttpToolsProtocol
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

from motionlab.server.settings import Settings

HEAD_MAX = 64 * 1024
"""Bytes of a request's head."""

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

_HEAD_TOO_LARGE = f"The head of a request has more than {HEAD_MAX} bytes."
_NO_HANDSHAKE = "A websocket is asked for by a GET of some short headers."
_TOO_MANY = "There are too many websockets already."
_HEADER_MARKS = 4  # bytes: a colon, a space and the end of the line
_UNUSED_MAX = 512 * 1024  # bytes that may arrive before the application takes any as a body
_REST_MAX = 16 * 1024 * 1024  # bytes of a body that may follow the answer to its request
_PIECE = 1024  # bytes that are parsed at a time: some 200 messages of the shortest
_TURN = 0.002  # s for which one websocket is read without a look at others
_LEAST_BURST = 0.0005  # s
_LONGEST_PIECE = 0.001  # s
_LONGEST_WAIT = 1.0  # s
_HANDSHAKE = 1.0  # s


class Places:
    """The open connections of a server.

    Parameters
    ----------
    settings : Settings
        Their largest number. A further connection takes the place of that which has waited longest
        for its client: idle, or with a request that has not arrived; of those that were answered
        lately only where there is no other. So slow clients keep no others out.
    """

    def __init__(self, settings: Settings) -> None:
        self._settings = settings
        self.sockets = set[Socket]()
        self._open: dict[Any, Connection | Socket] = {}

    @property
    def taken(self) -> int:
        """Number of open connections."""
        return len(self._open)

    @property
    def websockets_left(self) -> bool:
        """Whether there may be another websocket."""
        return len(self.sockets) < self._settings.websockets_max

    def enter(self, transport: asyncio.BaseTransport, connection: Connection | Socket) -> bool:
        """Take a place; return whether there is one."""
        full = transport not in self._open and len(self._open) >= self._settings.connections_max
        if full and not self._make_room():
            return False
        self._open[transport] = connection
        return True

    def leave(self, transport: asyncio.BaseTransport) -> None:
        """Free a place."""
        self._open.pop(transport, None)

    def _make_room(self) -> bool:
        """Abort what has waited longest for its client; return whether there was such a one."""
        waiting = [c for c in self._open.values() if isinstance(c, Connection) and c.waits]
        if not waiting:
            return False
        lately = asyncio.get_running_loop().time() - ANSWERED_LATELY
        longest = min(waiting, key=lambda each: (each.answered > lately, each.since))
        longest.transport.abort()
        self.leave(longest.transport)  # now, and not only when the event loop comes to it
        return True


class Connection(asyncio.Protocol):
    """One connection that speaks HTTP, until a websocket takes it over.

    Attributes
    ----------
    waits : bool
        Whether its client is to send something: a request, or the rest of a body.
    since : float
        When its last request was answered, or it began, s of the event loop.
    answered : float
        When its last request was answered.
    """

    places: Places

    def __init__(self, **options: Any) -> None:
        self.waits = True
        self.since, self.answered = 0.0, -math.inf
        self._protocol: asyncio.Protocol = HttpToolsProtocol(**options)
        self._loop = asyncio.get_running_loop()
        self._serves = self._rest_comes = False
        self._unused = 0
        self._reading: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Take a place."""
        self.transport = cast(asyncio.Transport, transport)
        self.since = self._loop.time()
        if self.places.enter(transport, self):
            self._protocol.connection_made(transport)
        else:  # every place is held by an answer or a websocket
            self._protocol = asyncio.Protocol()
            self.transport.abort()

    def connection_lost(self, exc: Exception | None) -> None:
        """Free its place."""
        self.places.leave(self.transport)
        if self._reading is not None:
            self._reading.cancel()
        self._protocol.connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        """Pass on data, or refuse it if too much is pending."""
        self._unused += len(data)
        _CURRENT.set(self)
        self._protocol.data_received(data)
        if self._unused > HEAD_MAX:
            self._loop.call_soon(self._check_unused)  # once requests that it completes have begun

    def eof_received(self) -> bool | None:
        """Pass on the end."""
        return self._protocol.eof_received()

    def pause_writing(self) -> None:
        """Watch a client that does not read as fast as it is answered."""
        self._protocol.pause_writing()
        if self._reading is None:
            self._watch_reader(self.transport.get_write_buffer_size())

    def resume_writing(self) -> None:
        """Watch it no longer."""
        if self._reading is not None:
            self._reading.cancel()
            self._reading = None
        self._protocol.resume_writing()

    def begin(self) -> None:
        """Note that a head is complete."""
        self.waits, self._serves, self._rest_comes, self._unused = False, True, False, 0

    def await_body(self, *, waits: bool) -> None:
        """Note that a part of a body is waited for, or has come."""
        self.waits, self._unused = waits, 0

    def end(self, *, rest_comes: bool) -> None:
        """Note that a request is answered, perhaps before all of its body has come."""
        self.waits, self._serves, self._rest_comes, self._unused = True, False, rest_comes, 0
        self.since = self.answered = self._loop.time()

    def _check_unused(self) -> None:
        if self._serves and self._unused > _UNUSED_MAX:
            self.transport.abort()  # in the middle of an answer
        elif self._rest_comes:  # what comes is no head: its client would read a second answer
            if self._unused > _REST_MAX:
                self.transport.abort()
        elif not self._serves and self._unused > HEAD_MAX:
            _refuse(self.transport, _HEAD_TOO_LARGE)

    def _watch_reader(self, unread: int) -> None:
        self._reading = self._loop.call_later(READ_GRACE, self._check_reader, unread)

    def _check_reader(self, unread: int) -> None:
        now = self.transport.get_write_buffer_size()
        if unread - now < READ_GRACE * READ_RATE:
            self.transport.abort()
        else:
            self._watch_reader(now)


class Socket(asyncio.Protocol):
    """One websocket, with a bound on the work that its client may cause.

    Incoming data is parsed in small pieces, and not while its client has used up its share of the
    event loop's time or does not read what it is sent: the rest waits in the client's own kernel.

    Attributes
    ----------
    drained : callable
        Called when there is room to write again.
    """

    places: Places

    def __init__(self, **options: Any) -> None:
        self.drained: Callable[[], None] = _nothing
        self._options = options
        self._protocol = asyncio.Protocol()  # which does nothing
        self._loop = asyncio.get_running_loop()
        self._pieces: deque[bytes] = deque()
        self._begun = self._served = False
        self._full = False  # of what the client does not read
        self._held = False  # by a message that the application has not taken
        self._stopped = False
        self._later: asyncio.Handle | None = None
        self._credit = SOCKET_BURST
        self._counted = time.perf_counter()

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Take the place of the connection that it was, or refuse it at no further cost."""
        self.transport = cast(asyncio.Transport, transport)
        self.places.enter(transport, self)
        if not self.places.websockets_left:
            _refuse(self.transport, _TOO_MANY)
            return
        self.places.sockets.add(self)
        self._protocol = WebSocketsSansIOProtocol(**self._options)
        self._protocol.connection_made(cast(Any, _Transport(self.transport, self)))

    def connection_lost(self, exc: Exception | None) -> None:
        """Free its place, and notify who waits to write."""
        self.places.leave(self.transport)
        self.places.sockets.discard(self)
        if self._later is not None:
            self._later.cancel()
        self._pieces.clear()
        self._protocol.connection_lost(exc)
        self.drained()

    def data_received(self, data: bytes) -> None:
        """Process incoming data piece by piece, but the head of the request whole."""
        if not self._begun:
            self._begun = True
            _CURRENT.set(self)
            self._protocol.data_received(data)
            self._loop.call_later(_HANDSHAKE, self._check_handshake)
            return
        if len(data) <= _PIECE:
            self._pieces.append(data)
        else:
            self._pieces.extend(data[at : at + _PIECE] for at in range(0, len(data), _PIECE))
        if not self._blocked:
            self._parse()
        if self._pieces and not self._stopped and not self.transport.is_closing():
            self._stopped = True
            self.transport.pause_reading()

    def eof_received(self) -> bool | None:
        """Pass on the end."""
        return self._protocol.eof_received()

    def pause_writing(self) -> None:
        """Take in no more, such as pings to be answered."""
        self._full = True
        self._protocol.pause_writing()

    def resume_writing(self) -> None:
        """Notify who waits to write."""
        self._full = False
        self._protocol.resume_writing()
        self._go_on()
        self.drained()

    @property
    def has_room(self) -> bool:
        """Whether little enough waits for the client that a message is sent without waiting."""
        return not self._full and not self.transport.is_closing()

    def begin(self) -> None:
        """Note that the application serves it."""
        self._served = True

    def hold(self) -> None:
        """Parse no more until the application has taken a message."""
        self._held = True

    def release(self) -> None:
        """Parse again."""
        self._held = False
        self._go_on()

    def spend(self, begun: float) -> None:
        """Count the time since `begun`, s of `time.perf_counter`, as the client's."""
        now = time.perf_counter()
        taken = min(now - begun, _LONGEST_PIECE)  # most of a longer time was another process's
        others = max(self.places.taken, 1)
        rate = min(SOCKET_SHARE, SOCKETS_SHARE / others)
        burst = max(SOCKET_BURST / others, _LEAST_BURST)
        self._credit = min(burst, self._credit + (begun - self._counted) * rate) - taken
        self._counted = begun
        if self._credit < 0.0:
            self._wait(min(-self._credit / rate, _LONGEST_WAIT))

    @property
    def _blocked(self) -> bool:
        return self._held or self._full or self._later is not None

    def _parse(self) -> None:
        """Process pending data for one time slice."""
        until = time.perf_counter() + _TURN
        while self._pieces and not self._blocked:
            begun = time.perf_counter()
            self._protocol.data_received(self._pieces.popleft())
            self.spend(begun)
            if begun > until:
                self._wait(0.0)

    def _go_on(self) -> None:
        if (self._pieces or self._stopped) and not self._blocked:
            self._wait(0.0)

    def _wait(self, seconds: float) -> None:
        if self._later is None and not self.transport.is_closing():
            self._later = self._loop.call_later(seconds, self._wait_no_more)

    def _wait_no_more(self) -> None:
        self._later = None
        if not self._blocked:
            self._parse()
        if self._stopped and not self._pieces and not self.transport.is_closing():
            self._stopped = False
            self.transport.resume_reading()

    def _check_handshake(self) -> None:
        """Answer a request that uvicorn leaves without an answer."""
        if not self._served:
            _refuse(self.transport, _NO_HANDSHAKE)


class _Transport:
    """The transport as a websocket's protocol sees it: when to read is decided by `Socket`."""

    def __init__(self, transport: asyncio.Transport, socket: Socket) -> None:
        self._transport = transport
        self.write = transport.write
        self.is_closing = transport.is_closing
        self.pause_reading = socket.hold
        self.resume_reading = socket.release

    def __getattr__(self, name: str) -> Any:
        return getattr(self._transport, name)


_CURRENT: ContextVar[Connection | Socket] = ContextVar("connection")


def current() -> Connection | Socket:
    """Return the connection whose request is served."""
    return _CURRENT.get()


class ConnectionLimits:
    """ASGI middleware that refuses long heads, and tells connections what is served of them."""

    def __init__(self, app: ASGIApp) -> None:
        self.app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one request or websocket."""
        connection = _CURRENT.get(None)
        if scope["type"] == "websocket" and isinstance(connection, Socket):
            connection.begin()
        elif scope["type"] == "http" and isinstance(connection, Connection):
            await self._answer(connection, scope, receive, send)
            return
        await self.app(scope, receive, send)

    async def _answer(
        self, connection: Connection, scope: Scope, receive: Receive, send: Send
    ) -> None:
        arrived = not _has_body(scope)

        async def received() -> Message:
            nonlocal arrived
            if arrived:
                return await receive()
            connection.await_body(waits=True)
            message = await receive()
            connection.await_body(waits=False)
            arrived = not message.get("more_body", False)
            return message

        connection.begin()
        try:
            if _head_size(scope) > HEAD_MAX:
                refused = PlainTextResponse(_HEAD_TOO_LARGE, 400, {"connection": "close"})
                await refused(scope, receive, send)
            else:
                await self.app(scope, received, send)
        finally:
            connection.end(rest_comes=not arrived)


def protocols(settings: Settings) -> tuple[type[Connection], type[Socket]]:
    """Return the classes of connections and websockets of one server."""
    places = {"places": Places(settings)}
    return type("Bounded", (Connection,), places), type("BoundedSocket", (Socket,), places)


def _head_size(scope: Scope) -> int:
    headers = sum(len(name) + len(value) + _HEADER_MARKS for name, value in scope["headers"])
    return headers + len(scope["raw_path"]) + len(scope["query_string"])


def _has_body(scope: Scope) -> bool:
    return any(
        name == b"transfer-encoding" or (name == b"content-length" and value.strip(b"0 "))
        for name, value in scope["headers"]
    )


def _refuse(transport: asyncio.Transport, reason: str) -> None:
    """Answer what is no request, and close its connection."""
    if transport.is_closing():
        return
    head = "HTTP/1.1 400 Bad Request\r\nconnection: close\r\ncontent-type: text/plain"
    transport.write(f"{head}\r\ncontent-length: {len(reason)}\r\n\r\n{reason}".encode())
    transport.close()


def _nothing() -> None:
    """Do nothing."""
