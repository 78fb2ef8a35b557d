"""Requests whose head never ends: refused before they fill the memory."""

from __future__ import annotations

import contextlib
import socket

import httpx
import pytest

from motionlab.server.http import connection_limits
from tests.server.servers import PATIENCE, Server

HEAD = b"GET /api/v1/health HTTP/1.1\r\nHost: 127.0.0.1\r\n"
CHUNKED = (
    b"POST /api/v1/simulate HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Type: application/json\r\n"
    b"Transfer-Encoding: chunked\r\n\r\n"
)
PIECE = b"a" * 16 * 1024
MOST = 256 * connection_limits.HEAD_MAX


def _taken(server: Server, start: bytes, *, piece: bytes = PIECE) -> tuple[int, bytes]:
    """Return how many bytes a server takes after a start, MOST if all, and what it answers."""
    sent, answer = 0, b""
    with socket.create_connection(("127.0.0.1", server.port), PATIENCE) as link:
        try:
            link.sendall(start)
            while sent < MOST:
                link.sendall(piece)
                sent += len(piece)
            return sent, b""
        except (BrokenPipeError, ConnectionResetError):
            pass
        try:
            answer = link.recv(100)
        except ConnectionResetError:
            pass
    return sent, answer


@pytest.mark.parametrize(
    ("start", "piece"),
    [
        (HEAD + b"X-Long: ", PIECE),
        (HEAD, b"X-Many: " + b"a" * 100 + b"\r\n"),
        (b"GET /", PIECE),
        (CHUNKED + b"2\r\n{}\r\n0\r\nX-Trailer: ", PIECE),
        (CHUNKED + b"2;", PIECE),
    ],
    ids=["header", "headers", "path", "trailer", "extension"],
)
def test_a_head_without_end_is_refused(server: Server, start: bytes, piece: bytes) -> None:
    assert _taken(server, start, piece=piece)[0] < MOST


@pytest.mark.parametrize(
    "head",
    [
        HEAD + b"X-Long: " + 70_000 * b"a" + b"\r\n\r\n",
        HEAD + 700 * (b"X-Many: " + b"a" * 100 + b"\r\n") + b"\r\n",
        HEAD.replace(b"health", b"health?" + 70_000 * b"a") + b"\r\n",
        HEAD + b"\r\n" + HEAD + b"X-Long: " + 70_000 * b"a" + b"\r\n\r\n",
    ],
    ids=["header", "headers", "path", "second"],
)
def test_a_long_head_that_comes_at_once_is_refused(server: Server, head: bytes) -> None:
    with socket.create_connection(("127.0.0.1", server.port), PATIENCE) as link:
        link.sendall(head)
        answer = b""
        with contextlib.suppress(ConnectionResetError):  # in the middle of an answer
            while piece := link.recv(1000):  # until the server closes it
                answer += piece
    last = answer.rpartition(b"HTTP/1.1 ")[2]
    assert last[:1] in {b"4", b""}, answer


def test_a_large_body_may_come_in_small_pieces(server: Server, client: httpx.Client) -> None:
    def body() -> object:
        yield b'{"scenario":"none"'
        for _ in range(2000):
            yield b" " * 100
        yield b"}"

    headers = {"Content-Type": "application/json"}
    answer = client.post("/api/v1/simulate", content=body(), headers=headers)  # pyright: ignore
    assert (answer.status_code, answer.json()["errors"][0]["loc"]) == (422, "scenario")


@pytest.mark.parametrize(
    ("method", "headers"),
    [
        ("POST", ""),
        ("GET", "X-Long: " + 20_000 * "a" + "\r\n"),
        ("GET", "".join(f"X-{i}: a\r\n" for i in range(300))),
    ],
    ids=["method", "long", "many"],
)
def test_a_websocket_that_cannot_be_is_answered(server: Server, method: str, headers: str) -> None:
    text = (
        f"{method} /api/v1/sessions/x/stream HTTP/1.1\r\nHost: 127.0.0.1\r\n"
        "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
        f"Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n{headers}\r\n"
    )
    with socket.create_connection(("127.0.0.1", server.port), PATIENCE) as link:
        link.sendall(text.encode())
        answer = b""
        while piece := link.recv(1000):  # until the server closes it
            answer += piece
    assert answer.startswith(b"HTTP/1.1 400 ")
