"""A PostgreSQL that does not answer costs seconds: connections to it that give up."""

from __future__ import annotations

import contextlib
import os
import socket
import threading
import weakref
from collections.abc import Iterator
from typing import Any

import sqlalchemy as sa
from sqlalchemy import event

CONNECT_SECONDS = 5
"""After which a connection is given up, s."""

ANSWER_SECONDS = 10.0
"""After which a statement is given up, by the server or, where that hangs, by us, s."""

_GRACE = 2.0  # s that the server has to say so itself


def connect_arguments(url: sa.URL) -> dict[str, Any]:
    """Return the arguments of a connection; what its address sets itself counts."""
    options = url.query.get("options", "")
    return {
        "connect_timeout": url.query.get("connect_timeout", CONNECT_SECONDS),
        "options": f"-c statement_timeout={1e3 * ANSWER_SECONDS:.0f} {options}",
    }


class Deadline:
    """Ends connections on which nothing has come for too long.

    A server that is stopped still acknowledges what it gets, so no timeout of TCP helps, and a
    statement's own timeout is the server's to keep.
    """

    def __init__(self, engine: sa.Engine) -> None:
        self._connections: weakref.WeakSet[Any] = weakref.WeakSet()
        event.listen(engine, "connect", lambda connection, _: self._connections.add(connection))

    @contextlib.contextmanager
    def running(self) -> Iterator[None]:
        """Bound the time of what is done with the connections meanwhile."""
        timer = threading.Timer(ANSWER_SECONDS + _GRACE, self._end)
        timer.daemon = True
        timer.start()
        try:
            yield
        finally:
            timer.cancel()

    def _end(self) -> None:
        for connection in tuple(self._connections):
            with contextlib.suppress(Exception):  # it was closed meanwhile
                with socket.socket(fileno=os.dup(connection.pgconn.socket)) as link:
                    link.shutdown(socket.SHUT_RDWR)
