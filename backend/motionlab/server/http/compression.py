"""JSON compressed for clients that accept gzip."""

from __future__ import annotations

import asyncio
import re
import threading
import zlib
from concurrent.futures import ThreadPoolExecutor

from starlette.datastructures import Headers, MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

SMALLEST = 1024
"""Bytes from which JSON is compressed."""

_LEVEL = 4
_REFUSED = re.compile(r"\s*q=0(\.0*)?\s*")
_GZIP = 16 + zlib.MAX_WBITS
_IN_THREAD = 32 * 1024
"""Bytes from which compression takes a thread, so that it does not delay streams."""

_PACKING = 2
_PACKERS = ThreadPoolExecutor(_PACKING, thread_name_prefix="gzip")
_places = threading.Semaphore(_PACKING)


def accepts(coding: str, headers: Headers) -> bool:
    """Return whether a request accepts a content coding by its name (RFC 9110, 12.5.3)."""
    for part in ",".join(headers.getlist("accept-encoding")).lower().split(","):
        name, _, weight = part.partition(";")
        if name.strip() == coding:
            return not _REFUSED.fullmatch(weight)
    return False


class CompressedJson:
    """ASGI middleware that compresses JSON answers, and nothing else.

    Streams, files and binary answers pass as they are: they are compact, come in pieces, or are
    compressed already.
    """

    def __init__(self, app: ASGIApp) -> None:
        self.app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one connection."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        accepted = accepts("gzip", Headers(scope=scope))
        start: Message | None = None

        async def compressed(message: Message) -> None:
            nonlocal start
            if message["type"] == "http.response.start" and _is_json(message):
                start = message  # until the size of its body is known
                return
            if start is not None:
                body = message.get("body", b"")
                if len(body) >= SMALLEST and not message.get("more_body", False):
                    message = await _pack(start, message, accepted)
                await send(start)
                start = None
            await send(message)

        await self.app(scope, receive, compressed)


async def _pack(start: Message, message: Message, accepted: bool) -> Message:
    """Return a body compressed, if the client accepts it, and say so in the head."""
    headers = MutableHeaders(scope=start)
    headers.add_vary_header("Accept-Encoding")
    if not accepted:
        return message
    body = message["body"]
    if len(body) < _IN_THREAD:
        packed = _gzip(body)
    elif _places.acquire(blocking=False):
        try:
            packed = await asyncio.get_running_loop().run_in_executor(_PACKERS, _gzip, body)
        finally:
            _places.release()
    else:  # the answer to a STOP, which is long with many variants, waits for no other one
        return message
    headers["Content-Encoding"] = "gzip"
    headers["Content-Length"] = str(len(packed))
    return {**message, "body": packed}


def _gzip(body: bytes) -> bytes:
    return zlib.compress(body, _LEVEL, _GZIP)


def _is_json(start: Message) -> bool:
    headers = Headers(raw=start["headers"])
    media = headers.get("content-type", "").partition(";")[0]
    json = media == "application/json" or media.endswith("+json")
    return json and "content-encoding" not in headers
