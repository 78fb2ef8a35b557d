"""What a server has to bear: ordinary load, and requests that mean harm."""

from __future__ import annotations

import base64
import contextlib
import http.client
import json
import os
import socket
import string
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

PATIENCE = 120.0  # s
_JOIN = 2.0  # s that a thread gets to end; its last request may take longer
VARIANTS = string.ascii_uppercase
BODIES = {
    "of paths": json.dumps({"set": {f"variants.A.controller.x.k_p{i}": 1 for i in range(6500)}}),
    "of numbers": json.dumps({"set": {"window": [0.123456789012] * 16_000}}),
    "of tables": json.dumps({"set": {"window": [{"a": 1} for _ in range(25_000)]}}),
    "with a key twice": json.dumps({"set": {f"k{i}": 1 for i in range(20_000)}})[:-1] + ',"set":1}',
}
"""Bodies of 250 kB that are refused."""
EQUAL_HEADERS = ",".join(["x"] * 30_000) + "\n1\n"
BOMB = "a." * 20_000 + "a=1"  # 40 kB of one dotted key


class Client:
    """Asks a server over connections of its own."""

    def __init__(self, port: int) -> None:
        self.port = port

    def ask(
        self, method: str, path: str, body: Any = None, media: str = "application/json"
    ) -> tuple[int, bytes]:
        """Return status and content of an answer."""
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=PATIENCE)
        with contextlib.closing(connection):
            text = body if isinstance(body, str | None) else json.dumps(body)
            headers = {} if body is None else {"Content-Type": media}
            connection.request(method, f"/api/v1{path}", text, headers)
            answer = connection.getresponse()
            return answer.status, answer.read()

    def session(self, body: Any = None) -> str:
        """Create a session and return its path."""
        status, content = self.ask("POST", "/sessions", body or {})
        if status != 201:
            raise RuntimeError(f"no session: {status} {content[:200]!r}")
        return f"/sessions/{json.loads(content)['id']}"

    def connect(self) -> socket.socket:
        """Open a connection."""
        return socket.create_connection(("127.0.0.1", self.port), PATIENCE)

    def websocket(self, path: str) -> socket.socket:
        """Open a websocket; what comes is not read."""
        stream = self.connect()
        key = base64.b64encode(os.urandom(16)).decode()
        stream.sendall(
            f"GET /api/v1{path}/stream HTTP/1.1\r\nHost: 127.0.0.1:{self.port}\r\n"
            "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
            f"Sec-WebSocket-Key: {key}\r\n\r\n".encode()
        )
        return stream


Attack = Callable[[Client, threading.Event], None]


@contextlib.contextmanager
def under(attack: Attack, client: Client, threads: int = 1) -> Iterator[None]:
    """Attack from threads while the block lasts."""
    over = threading.Event()

    def run() -> None:
        with contextlib.suppress(OSError, http.client.HTTPException):
            attack(client, over)

    running = [threading.Thread(target=run, daemon=True) for _ in range(threads)]
    for thread in running:
        thread.start()
    try:
        yield
    finally:
        over.set()
        for thread in running:
            thread.join(_JOIN)


def again(method: str, path: str, body: Any = None, **options: Any) -> Attack:
    """Return an attack that asks for one thing again and again."""

    def attack(client: Client, over: threading.Event) -> None:
        while not over.is_set():
            with contextlib.suppress(OSError, http.client.HTTPException):
                client.ask(method, path, body, **options)

    return attack


def framed(opcode: int, payload: bytes) -> bytes:
    """Return a client's websocket frame, masked with zeros."""
    length = len(payload)
    head = (
        bytes((0x80 | opcode, 0x80 | length))
        if length < 126
        else struct.pack(">BBH", 0x80 | opcode, 0x80 | 126, length)
    )
    return head + bytes(4) + payload


def flood(opcode: int, payload: bytes) -> Attack:
    """Return an attack that sends one websocket message for ever and reads nothing."""

    def attack(client: Client, over: threading.Event) -> None:
        stream = client.websocket(client.session())
        stream.settimeout(0.5)
        data = 200 * framed(opcode, payload)
        while not over.is_set():
            with contextlib.suppress(TimeoutError):
                stream.send(data)
        stream.close()

    return attack


def many_websockets(client: Client, over: threading.Event) -> None:
    """Ask for ten thousand websockets of one session."""
    path = client.session()
    held = []
    for _ in range(10_000):
        if over.is_set():
            break
        try:
            held.append(client.websocket(path))
        except OSError:
            time.sleep(0.01)
    over.wait()
    for stream in held:
        stream.close()


def slow_bodies(client: Client, over: threading.Event) -> None:
    """Hold connections by bodies that come a byte at a time."""
    held: list[socket.socket] = []
    head = (
        f"POST /api/v1/simulate HTTP/1.1\r\nHost: 127.0.0.1:{client.port}\r\n"
        "Content-Type: application/json\r\nContent-Length: 100000\r\n\r\n"
    ).encode()
    while not over.is_set():
        with contextlib.suppress(OSError):
            if len(held) < 2000:
                held.append(client.connect())
                held[-1].sendall(head)
                continue
        for stream in held:
            with contextlib.suppress(OSError):
                stream.send(b"x")
        over.wait(1.0)
    for stream in held:
        stream.close()


def unread_files(path: str, format: str) -> Attack:
    """Return an attack that asks for files and reads nothing of them."""

    def attack(client: Client, over: threading.Event) -> None:
        held = []
        while not over.is_set():
            stream = client.connect()
            stream.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            stream.sendall(
                f"GET /api/v1{path}/telemetry?format={format} HTTP/1.1\r\n"
                f"Host: 127.0.0.1:{client.port}\r\n\r\n".encode()
            )
            held.append(stream)
            over.wait(2.0)
        for stream in held:
            stream.close()

    return attack


def what_ifs(per_second: float) -> Attack:
    """Return an attack of what-ifs at a rate, as from somebody who drags a slider."""

    def attack(client: Client, over: threading.Event) -> None:
        k_p = 2e5
        while not over.wait(1.0 / per_second):
            k_p += 10.0
            body = {"set": {"variants.B.controller.x.k_p": k_p}, "columns": ["B.x.following_error"]}
            with contextlib.suppress(OSError, http.client.HTTPException):
                client.ask("POST", "/whatif", body)

    return attack


def dragging(client: Client, over: threading.Event) -> None:
    """Drag as a page does: each change is checked, and margins are asked for, 60 times a second."""
    force = 60.0
    while not over.wait(1.0 / 60.0):
        force += 0.01
        body = {"scenario": "circle", "set": {"variants.B.controller.force_limit": force}}
        with contextlib.suppress(OSError, http.client.HTTPException):
            client.ask("POST", "/whatif/lanes", body | {"inputs": "0" * 32, "tables": ""})
            client.ask("POST", "/loop", body)


def jobs(client: Client, over: threading.Event) -> None:
    """Keep two jobs running."""
    body = {"scenario": "circle-matched", "runs": 2000}
    while not over.is_set():
        with contextlib.suppress(OSError, http.client.HTTPException):
            client.ask("POST", "/montecarlo", body)
        over.wait(1.0)


def wide(events: int) -> dict[str, Any]:
    """Return a request for a session of 26 variants whose parameters change `events` times."""
    controller = "lugre-observer"
    return {
        "set": {
            **{f"variants.{v}": {"label": v, "controller": {"base": controller}} for v in VARIANTS},
            "schedule": [
                {"time": 0.01 * (i + 1), "set": {"variants.B.controller.x.k_p": 2e5 + i}}
                for i in range(events)
            ],
        }
    }


@contextlib.contextmanager
def watchers(
    client: Client, session: str, count: int, seconds: float
) -> Iterator[subprocess.Popen]:
    """Watch a session by many clients, from a process of their own, while the block lasts."""
    command = (sys.executable, "-m", "tests.bench.clients", "--clients", str(count))
    command += ("--windows", "1", "--seconds", str(seconds), "--", str(client.port), session)
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None and process.stdin is not None
        if process.stdout.readline() != "playing\n":
            raise RuntimeError("the clients failed")
        try:
            yield process
        finally:
            with contextlib.suppress(OSError):
                process.stdin.write("\n")
                process.stdin.flush()
