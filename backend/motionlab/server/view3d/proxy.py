"""Proxy of a browser's requests to a 3-D view's process on loopback."""

from __future__ import annotations

import asyncio
import contextlib
import socket

from fastapi import Response, WebSocket
from starlette.datastructures import Headers
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, InvalidHandshake
from websockets.typing import Origin, Subprotocol

from motionlab.server.view3d.process import Scene

RECEIVE_BUFFER = 64 * 1024
"""Bytes from the process that wait in the kernel for a slow viewer."""

QUEUE_MESSAGES = 4
"""Messages from the process that wait here; beyond, it has to wait with its own."""

STALLED_SECONDS = 20.0
"""Time after which a viewer that reads nothing is disconnected, s."""

ANSWER_SECONDS = 10.0
"""How long the process may take to answer a request for its page."""

HANG_SECONDS = 20.0
"""How long the process may answer nothing at all before it counts as hung."""

FAREWELL_SECONDS = 1.0

MESSAGE_MAX = 1_000_000
"""Largest message of a viewer, bytes."""

PAGE_MAX = 32_000_000
_PASSED_ON = ("content-type", "content-encoding", "content-length")
_GOING_AWAY, _TOO_BIG, _TRY_AGAIN = 1001, 1009, 1013
_NEVER_SENT = (1005, 1006, 1015)  # codes that only stand for how a connection was lost

# The page runs inline scripts and workers of its own; it may connect to this server only, whatever
# its address contains.
CONTENT_POLICY = (
    "default-src 'self'; script-src 'self' 'unsafe-inline' 'unsafe-eval' blob: data:; "
    "style-src 'self' 'unsafe-inline'; img-src 'self' blob: data:; font-src 'self' data:; "
    "connect-src 'self' blob: data:; worker-src 'self' blob: data:; frame-ancestors 'self'"
)


async def fetch_page(scene: Scene, accept_encoding: str) -> Response:
    """Return the page of a scene.

    Raises
    ------
    OSError
        If the process does not answer, or not in time.
    """
    encoding = "gzip" if "gzip" in accept_encoding else "identity"
    fields = f"Origin: {scene.origin}\r\nAccept-Encoding: {encoding}\r\n"
    try:
        async with asyncio.timeout(ANSWER_SECONDS):
            status, headers, body = await _get(scene, fields)
    except TimeoutError:
        raise OSError(f"its process did not answer within {ANSWER_SECONDS:g} s") from None
    passed = {name: headers[name] for name in _PASSED_ON if name in headers}
    more = {"Cache-Control": "no-cache", "Content-Security-Policy": CONTENT_POLICY}
    return Response(body, status, passed | more)


async def answers(scene: Scene) -> bool:
    """Return whether the process answers at all, even with an error."""
    try:
        async with asyncio.timeout(HANG_SECONDS):
            await _get(scene, "")
    except OSError:
        return False
    return True


async def _get(scene: Scene, fields: str) -> tuple[int, Headers, bytes]:
    """Return status, headers and body of the process's root page."""
    reader, writer = await asyncio.open_connection("127.0.0.1", scene.port, limit=PAGE_MAX)
    try:
        host = f"Host: 127.0.0.1:{scene.port}\r\n"
        writer.write(f"GET / HTTP/1.1\r\n{host}{fields}Connection: close\r\n\r\n".encode())
        head = (await reader.readuntil(b"\r\n\r\n")).decode("latin-1").split("\r\n")
        raw = [line.partition(":") for line in head[1:] if line]
        headers = Headers(
            raw=[(k.lower().encode(), v.strip().encode()) for k, _, v in raw],
        )
        body = await reader.readexactly(int(headers["content-length"]))
        return int(head[0].split()[1]), headers, body
    except (asyncio.IncompleteReadError, asyncio.LimitOverrunError, KeyError, ValueError) as error:
        raise OSError("its process gave no whole answer") from error
    finally:
        writer.close()


async def carry(websocket: WebSocket, scene: Scene, viewer: str = "") -> None:
    """Carry one viewer's websocket until either side ends it."""
    offered = [Subprotocol(name) for name in websocket.scope.get("subprotocols", [])]
    try:
        upstream = await _connect(scene, viewer, offered)
    except (OSError, InvalidHandshake):
        await websocket.close(_TRY_AGAIN, "the scene's process does not answer")
        return
    async with upstream:
        await websocket.accept(upstream.subprotocol)
        ways = [
            asyncio.create_task(_outwards(websocket, upstream)),
            asyncio.create_task(_inwards(websocket, upstream)),
        ]
        try:
            done, _ = await asyncio.wait(ways, return_when=asyncio.FIRST_COMPLETED)
        finally:
            for way in ways:
                way.cancel()
            await asyncio.gather(*ways, return_exceptions=True)
        closing = next((way.result() for way in done if not way.exception()), None)
        if closing is not None:
            # It may have disconnected, or still not read.
            with contextlib.suppress(RuntimeError, TimeoutError):
                async with asyncio.timeout(FAREWELL_SECONDS):
                    await websocket.close(*closing)
        upstream.transport.abort()  # its close handshake would wait for data never read


async def _connect(scene: Scene, viewer: str, offered: list[Subprotocol]) -> ClientConnection:
    """Return a websocket to a 3-D view's process with a small receive buffer."""
    link = socket.socket(socket.AF_INET, socket.SOCK_STREAM, socket.IPPROTO_TCP)
    try:
        link.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVE_BUFFER)
        link.setblocking(False)
        await asyncio.get_running_loop().sock_connect(link, ("127.0.0.1", scene.port))
        return await connect(
            f"ws://127.0.0.1:{scene.port}/{viewer}",
            sock=link,
            origin=Origin(scene.origin),
            subprotocols=offered or None,
            compression=None,
            max_size=PAGE_MAX,
            max_queue=QUEUE_MESSAGES,
            ping_interval=None,
            proxy=None,
        )
    except BaseException:
        link.close()
        raise


async def _outwards(websocket: WebSocket, upstream: ClientConnection) -> tuple[int, str] | None:
    """Forward the process's messages, with back-pressure from the viewer."""
    try:
        async for message in upstream:
            async with asyncio.timeout(STALLED_SECONDS):
                if isinstance(message, bytes):
                    await websocket.send_bytes(message)
                else:
                    await websocket.send_text(message)
    except TimeoutError:
        return _TRY_AGAIN, "nothing was read for too long"
    except ConnectionClosed:
        pass  # with a code that says more than that it is over
    if upstream.close_code in {None, *_NEVER_SENT}:
        return _GOING_AWAY, "the scene's process has ended"
    return upstream.close_code or _GOING_AWAY, upstream.close_reason or ""


async def _inwards(websocket: WebSocket, upstream: ClientConnection) -> tuple[int, str] | None:
    """Forward the viewer's messages until it leaves."""
    while True:
        received = await websocket.receive()
        if received["type"] == "websocket.disconnect":
            return None
        message = received.get("bytes")
        if message is None:
            message = received.get("text") or ""
        if len(message) > MESSAGE_MAX:
            return _TOO_BIG, f"more than {MESSAGE_MAX} bytes"
        try:
            await upstream.send(message)
        except ConnectionClosed:
            return _GOING_AWAY, "the scene's process has ended"
