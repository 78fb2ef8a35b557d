"""One line of JSON for each request, and for each opening and closing of a websocket."""

from __future__ import annotations

import asyncio
import itertools
import json
import logging
import re
import secrets
import sys
import time
from collections.abc import Callable
from datetime import UTC, datetime
from typing import Any

from starlette.types import ASGIApp, Message, Receive, Scope, Send

LOG = logging.getLogger("motionlab.access")
"""Its level decides: at info every request is logged, above that none."""

KNOWN = "motionlab.known"
"""Extension of a scope that says that its client may use the server: with its token, if any."""

UNKNOWN_MAX = 100
"""Lines that clients without the token may cause in `UNKNOWN_SECONDS`, all of them together."""

UNKNOWN_SECONDS = 60.0
"""After which requests of such clients that have no line are counted in one, s."""

ID_HEADER = b"x-request-id"
_SERVER = logging.getLogger("uvicorn.error")  # where uvicorn logs all but requests
_NO_REQUESTS = {"Invalid HTTP request received.", "Unsupported upgrade request."}
_OF_SOCKETS = re.compile(r'"WebSocket |^connection |^ASGI callable returned without ')
_ID = re.compile(rb"[A-Za-z0-9._-]{1,64}")
_PATH_MAX = 500  # characters
_OURS = secrets.token_hex(4)
_COUNT = itertools.count(1)


class AccessLog:
    """ASGI middleware that logs requests: never their query, headers or body.

    Answers carry the line's identifier as ``X-Request-ID``: that of the request, where it has one.
    """

    def __init__(self, app: ASGIApp) -> None:
        self.app = app
        self._unknown = _Unknown(_note_unknown)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one connection."""
        kind = scope["type"]
        if kind not in {"http", "websocket"} or not LOG.isEnabledFor(logging.INFO):
            await self.app(scope, receive, send)
            return
        begun = time.perf_counter()
        identifier = _identifier(scope)
        status = 0  # of a client that has left before its answer
        size = 0

        def log(**event: str) -> None:
            if not scope.get("extensions", {}).get(KNOWN) and not self._unknown.take():
                return
            line = {
                "time": _now(),
                "method": scope.get("method", "WEBSOCKET"),
                "path": scope["path"][:_PATH_MAX],
                "status": status,
                "ms": round(1e3 * (time.perf_counter() - begun), 3),
                "bytes": size,
                "client": (scope.get("client") or ("",))[0],
                "request": identifier.decode(),
            }
            LOG.info(json.dumps(line | event))

        async def watched(message: Message) -> None:
            nonlocal status, size
            match message["type"]:
                case "http.response.body":
                    size += len(message.get("body", b""))
                case "http.response.start":
                    status = message["status"]
                    headers = [*message.get("headers", ()), (ID_HEADER, identifier)]
                    message = {**message, "headers": headers}
                case "websocket.send":
                    size += len(message.get("bytes") or message.get("text") or b"")
                case "websocket.accept":
                    status = 101
                    log(event="open")
                case "websocket.close":
                    status = message.get("code", 1000) if status else 403
                case _:
                    pass
            await send(message)

        try:
            await self.app(scope, receive, watched)
        finally:
            if kind == "http":
                log()
            else:
                log(event="close")


class _Unknown:
    """A bounded number of lines for clients without the token, and a count of their requests."""

    def __init__(self, note: Callable[[int], None]) -> None:
        self._note = note
        self._written = 0
        self._missing = 0

    def take(self) -> bool:
        """Count a line; return whether it may be written."""
        if self._written == 0:
            asyncio.get_running_loop().call_later(UNKNOWN_SECONDS, self._begin_anew)
        if self._written >= UNKNOWN_MAX:
            self._missing += 1
            return False
        self._written += 1
        return True

    def _begin_anew(self) -> None:
        missing, self._written, self._missing = self._missing, 0, 0
        if missing:
            self._note(missing)


def _note_unknown(count: int) -> None:
    LOG.info(json.dumps({"time": _now(), "event": "not logged", "count": count}))


class _NoRequests(logging.Filter):
    """Bound what uvicorn logs of bytes that are no request: any client may send them.

    Its lines about websockets are dropped: they repeat the query, and call a refusal an error. The
    access log has a line for each websocket.
    """

    def __init__(self) -> None:
        super().__init__()
        self._unknown = _Unknown(_note_no_requests)

    def filter(self, record: logging.LogRecord) -> bool:
        """Return whether a record is written."""
        if record.msg in _NO_REQUESTS:
            return self._unknown.take()
        return not _OF_SOCKETS.search(str(record.msg))


def _note_no_requests(count: int) -> None:
    _SERVER.warning("%d more invalid requests within %g s", count, UNKNOWN_SECONDS)


def install() -> None:
    """Write the lines to stdout, whatever other loggers do, and bound those of uvicorn."""
    handler = _Lines(sys.stdout)
    handler.setFormatter(logging.Formatter("%(message)s"))
    LOG.handlers = [handler]
    LOG.propagate = False
    for former in [each for each in _SERVER.filters if isinstance(each, _NoRequests)]:
        _SERVER.removeFilter(former)
    _SERVER.addFilter(_NoRequests())


class _Lines(logging.StreamHandler[Any]):
    """A handler that loses lines which cannot be written."""

    def handleError(self, record: logging.LogRecord) -> None:
        """Do nothing: a full disk or a reader that has left must not fill stderr too."""


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="milliseconds")


def _identifier(scope: Scope) -> bytes:
    """Return the identifier that a proxy has given, or a new one."""
    for name, value in scope["headers"]:
        if name == ID_HEADER and _ID.fullmatch(value):
            return value
    return f"{_OURS}-{next(_COUNT):x}".encode()
