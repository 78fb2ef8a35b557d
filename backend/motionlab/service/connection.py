"""A client's connection, bounded in what is taken from it before the application sees any of it."""

from __future__ import annotations

import asyncio
from typing import Any

from uvicorn.protocols.http.httptools_impl import HttpToolsProtocol
from websockets.exceptions import InvalidMessage

HEAD_MAX = 64 * 1024
"""Bytes of a request's head, or of what follows a body, that may wait for its end."""

HEAD_SECONDS = 30.0
"""How long a head may take, from the connection's or the request's first byte."""


class Connection(HttpToolsProtocol):
    """HTTP as uvicorn speaks it, without heads that never end.

    The parser keeps a header until its last byte and copies it with each that comes: a few hundred
    megabytes of one, from a client that need not know the token, fill the memory and delay
    everybody's STOP by a few tenths of a second.
    """

    _waiting = 0
    _deadline: asyncio.TimerHandle | None = None

    def connection_made(self, transport: Any) -> None:
        """Begin to wait for a head."""
        super().connection_made(transport)
        self._set_deadline()

    def connection_lost(self, exc: Exception | None) -> None:
        """Wait no longer."""
        self._clear_deadline()
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        """Parse what came, or refuse where too much of it waits."""
        self._waiting += len(data)
        super().data_received(data)
        if self._waiting > HEAD_MAX:
            self._refuse(f"The head of a request has more than {HEAD_MAX} bytes.")

    def on_message_begin(self) -> None:
        """Begin to wait for a head."""
        super().on_message_begin()
        if self._deadline is None:
            self._set_deadline()

    def on_headers_complete(self) -> None:
        """Wait no longer."""
        self._waiting = 0
        self._clear_deadline()
        super().on_headers_complete()

    def on_body(self, body: bytes) -> None:
        """Take a piece of a body; the application bounds the whole."""
        self._waiting = 0
        super().on_body(body)

    def on_message_complete(self) -> None:
        """Take the end of a request."""
        self._waiting = 0
        super().on_message_complete()

    def handle_websocket_upgrade(self) -> None:
        """Hand over to a websocket, or refuse what it would wait for without an answer."""
        super().handle_websocket_upgrade()
        taken_over = self.transport.get_protocol()
        refused = getattr(getattr(taken_over, "conn", None), "handshake_exc", None)
        if isinstance(refused, InvalidMessage) and not self.transport.is_closing():
            self.send_400_response("A websocket is asked for by a GET of some short headers.")

    def _set_deadline(self) -> None:
        self._deadline = self.loop.call_later(
            HEAD_SECONDS, self._refuse, f"The head of a request took more than {HEAD_SECONDS:g} s."
        )

    def _clear_deadline(self) -> None:
        if self._deadline is not None:
            self._deadline.cancel()
            self._deadline = None

    def _refuse(self, reason: str) -> None:
        self._clear_deadline()
        if self.transport.is_closing():
            return
        if self.cycle is None or self.cycle.response_complete:
            self.send_400_response(reason)
        else:
            self.transport.abort()  # in the middle of an answer
