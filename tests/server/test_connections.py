"""Connections that hold places, websockets that flood, files that are not read: all are bounded."""

from __future__ import annotations

import base64
import contextlib
import json
import os
import resource
import socket
import tempfile
from collections.abc import Iterator

import httpx
import pytest
from websockets.frames import Frame, Opcode

from motionlab.server.http import connection_limits, download
from motionlab.server.serve import _within_open_files
from motionlab.server.settings import Settings
from tests.server.conftest import Connect, MakeServer
from tests.server.live import API, Live, until
from tests.server.servers import PATIENCE, Server

SLOW = (
    b"POST /api/v1/simulate HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Type: application/json\r\n"
    b"Content-Length: 1000\r\n\r\n{"
)
ERRORS = ["A.x.following_error"]
UNREAD_MAX = 64 * 1024  # bytes that a transport keeps for a client before it has them wait


@contextlib.contextmanager
def link(server: Server, first: bytes = b"") -> Iterator[socket.socket]:
    """Open a connection that has sent something."""
    with socket.create_connection(("127.0.0.1", server.port), PATIENCE) as opened:
        opened.sendall(first)
        yield opened


def read_all(opened: socket.socket) -> bytes:
    """Return what comes until the server closes the connection."""
    answer = b""
    with contextlib.suppress(ConnectionResetError):
        while piece := opened.recv(100_000):
            answer += piece
    return answer


def test_a_new_connection_takes_the_place_of_the_oldest_that_waits(
    make_server: MakeServer,
) -> None:
    server = make_server(Settings(connections_max=4))
    with contextlib.ExitStack() as opened:
        first, *others = [opened.enter_context(link(server, SLOW)) for _ in range(4)]
        until(lambda: len(server._uvicorn.server_state.connections) == 4)
        assert httpx.get(f"{server.url}{API}/health", timeout=PATIENCE).status_code == 200
        assert read_all(first) == b""
        for other in others:
            other.settimeout(0.1)
            with pytest.raises(TimeoutError):  # it goes on waiting
                other.recv(1)


def test_who_was_answered_lately_keeps_its_connection(
    make_server: MakeServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(connection_limits, "ANSWERED_LATELY", PATIENCE)
    server = make_server(Settings(connections_max=4))
    health = f"GET {API}/health HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n".encode()
    with contextlib.ExitStack() as opened:
        kept = opened.enter_context(link(server, health))
        assert answer_of(kept).startswith(b"HTTP/1.1 200")
        for _ in range(9):  # each takes the place of one before it
            opened.enter_context(link(server, SLOW))
            until(lambda: len(server._uvicorn.server_state.connections) <= 4)
        kept.sendall(health)
        assert answer_of(kept).startswith(b"HTTP/1.1 200")


def answer_of(opened: socket.socket) -> bytes:
    """Return an answer whose body is one flat JSON table."""
    answer = b""
    while not answer.endswith(b"}"):
        answer += (piece := opened.recv(1000))
        assert piece, answer
    return answer


def test_websockets_are_bounded_apart_from_requests(make_server: MakeServer) -> None:
    server = make_server(Settings(websockets_max=2))
    with (
        httpx.Client(base_url=server.url, timeout=PATIENCE) as client,
        contextlib.ExitStack() as opened,
    ):
        live = Live.create(client)
        for _ in range(2):
            opened.enter_context(handshaken(server, live, b"101"))
        with handshaken(server, live, b"400") as refused:
            assert b"too many websockets" in read_all(refused)
        assert live.do("stop")["state"] == "stopping"


@contextlib.contextmanager
def handshaken(server: Server, live: Live, status: bytes) -> Iterator[socket.socket]:
    """Ask for a session's stream, by hand."""
    key = base64.b64encode(os.urandom(16)).decode()
    request = (
        f"GET {live.path}/stream HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\n"
        "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
        f"Sec-WebSocket-Key: {key}\r\n\r\n"
    )
    with link(server, request.encode()) as opened:
        head = b""
        while b"\r\n" not in head:
            head += opened.recv(1)
        assert head.startswith(b"HTTP/1.1 " + status), head
        yield opened


def framed(opcode: Opcode, payload: bytes, *, final: bool = True) -> bytes:
    """Return a client's frame."""
    return Frame(opcode, payload, final).serialize(mask=True)


SUBSCRIBE = json.dumps({"type": "subscribe", "columns": ERRORS}).encode()
LONG = json.dumps({"type": "subscribe", "columns": ERRORS, "from_tick": 0}).encode() + 200 * b" "
HUGE = LONG + 70_000 * b" "


@pytest.mark.parametrize(
    "sent",
    [
        framed(Opcode.TEXT, SUBSCRIBE),
        framed(Opcode.TEXT, LONG),
        framed(Opcode.TEXT, HUGE),
        framed(Opcode.PING, b"x") + framed(Opcode.TEXT, SUBSCRIBE),
        framed(Opcode.TEXT, SUBSCRIBE[:20], final=False) + framed(Opcode.CONT, SUBSCRIBE[20:]),
        framed(Opcode.TEXT, SUBSCRIBE[:20], final=False)
        + framed(Opcode.PING, b"between")
        + framed(Opcode.CONT, SUBSCRIBE[20:40], final=False)
        + framed(Opcode.CONT, SUBSCRIBE[40:])
        + framed(Opcode.TEXT, SUBSCRIBE),
        framed(Opcode.BINARY, b"\x00") + framed(Opcode.TEXT, SUBSCRIBE),
    ],
    ids=["short", "long", "huge", "ping", "fragments", "between", "binary"],
)
@pytest.mark.parametrize("piece", [1, 7, 1_000_000])
def test_messages_in_any_frames_and_pieces(
    server: Server, live: Live, sent: bytes, piece: int
) -> None:
    if len(sent) > 10_000 and piece == 1:
        piece = 997
    with handshaken(server, live, b"101") as stream:
        for at in range(0, len(sent), piece):
            stream.sendall(sent[at : at + piece])
        got = b""
        while b'"type":"subscribed"' not in got:
            got += stream.recv(100_000)
        if b"between" in sent:  # control frames and text are masked at random
            assert b"between" in got


@pytest.mark.parametrize(
    "payload",
    [
        (Opcode.TEXT, b"garbage"),
        (Opcode.TEXT, b'{"type": "ack", "sequence": 0}'),
        (Opcode.TEXT, 60_000 * b"["),
        (Opcode.PING, b"ping"),
        (Opcode.BINARY, b""),
    ],
    ids=lambda payload: f"{payload[0].name} {payload[1][:12]!r}",
)
def test_a_flood_by_one_client_is_held_back(
    server: Server,
    connect: Connect,
    live: Live,
    monkeypatch: pytest.MonkeyPatch,
    payload: tuple[Opcode, bytes],
) -> None:
    monkeypatch.setattr(connection_limits, "SOCKET_SHARE", 1e-4)
    monkeypatch.setattr(connection_limits, "SOCKET_BURST", 1e-3)
    flood = 200 * framed(*payload)
    with handshaken(server, live, b"101") as rude:
        rude.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 4096)
        rude.settimeout(1.0)
        with pytest.raises(TimeoutError):  # what is not taken waits in the client's own kernel
            for _ in range(20_000):
                rude.sendall(flood)
        assert max(server.unsent) <= 4 * UNREAD_MAX
        monkeypatch.undo()
        other = connect()
        other.subscribe(ERRORS)
        live.step(5)
        other.collect(0, 5)


# -- files ----------------------------------------------------------------------------------------


def test_a_file_holds_its_place_until_it_is_sent(make_server: MakeServer) -> None:
    server = make_server(Settings(downloads_max=1, downloads_waiting_max=0))
    with httpx.Client(base_url=server.url, timeout=PATIENCE) as client:
        live = Live.create(client)
        live.step(40_000)
        path = f"{live.path}/telemetry?format=csv"
        with client.stream("GET", path) as unread:
            assert unread.status_code == 200
            refused = client.get(path)
            assert refused.status_code == 429
            assert int(refused.headers["Retry-After"]) > 0
            unread.read()
        until(lambda: client.get(path).status_code == 200)


def test_a_reader_that_is_too_slow_is_cut_off(
    make_server: MakeServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(download, "READ_GRACE", 1.0)
    server = make_server(Settings(downloads_max=1))
    with httpx.Client(base_url=server.url, timeout=PATIENCE) as client:
        live = Live.create(client)
        live.step(40_000)
        path = f"{live.path}/telemetry?format=csv"
        with socket.socket() as slow:
            slow.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            slow.connect(("127.0.0.1", server.port))
            slow.sendall(f"GET {path} HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n".encode())
            slow.recv(100)
            until(lambda: client.get(path).status_code == 200)


def test_an_answer_that_is_not_read_is_cut_off(
    make_server: MakeServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(connection_limits, "READ_GRACE", 0.5)
    server = make_server(Settings())
    with socket.socket() as slow:
        slow.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        slow.connect(("127.0.0.1", server.port))
        slow.sendall(b"GET /openapi.json HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n")
        slow.recv(100)
        until(lambda: not server._uvicorn.server_state.connections)


def test_a_full_temporary_folder_is_told_apart(
    server: Server, live: Live, monkeypatch: pytest.MonkeyPatch, tmp_path: os.PathLike[str]
) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device", str(tmp_path))

    monkeypatch.setattr("numpy.save", full)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    answer = httpx.get(f"{server.url}{live.path}/telemetry?format=csv", timeout=PATIENCE)
    assert answer.status_code == 507
    assert str(tmp_path) not in answer.text
    assert os.listdir(tmp_path) == []


@pytest.mark.parametrize(
    ("soft", "hard", "most", "raised"),
    [
        (1024, 4096, 800, None),
        (256, 4096, 800, 1024),
        (256, resource.RLIM_INFINITY, 800, 1024),
        (64, 64, 32, None),
        (128, 512, 288, 512),
    ],
)
def test_a_limit_of_open_files_lowers_that_of_connections(
    soft: int, hard: int, most: int, raised: int | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    limits = []
    monkeypatch.setattr(resource, "getrlimit", lambda _: (soft, hard))
    monkeypatch.setattr(resource, "setrlimit", lambda _, pair: limits.append(pair[0]))
    settings = _within_open_files(Settings(connections_max=800, websockets_max=512))
    assert settings.connections_max == most
    assert settings.websockets_max == (512 if most == 800 else most // 2)
    assert limits == ([] if raised is None else [raised])


def test_a_body_that_goes_on_after_its_answer_has_no_second_answer(server: Server) -> None:
    size = 2_000_000
    post = SLOW.replace(b"1000\r\n\r\n{", b"%d\r\n\r\n" % size)
    with link(server, post) as opened:
        assert opened.recv(12) == b"HTTP/1.1 413"
        for _ in range(size // 50_000):
            opened.sendall(50_000 * b"a")
        get = f"GET {API}/health HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n\r\n"
        opened.sendall(get.encode())
        assert [text[:4] for text in read_all(opened).split(b"HTTP/1.1")[1:]] == [b" 200"]
