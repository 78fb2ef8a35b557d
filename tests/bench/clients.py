"""``python -m tests.bench.clients``: many clients of one stream, in a process of their own.

The framing is done by hand: a hundred clients of a library would be timed with its own work on
six thousand frames a second.
"""

from __future__ import annotations

import argparse
import json
import selectors
import socket
import struct
import sys
import time
from dataclasses import dataclass, field

import httpx
import numpy as np

from motionlab.timing import CONTROL_PERIOD

COLUMNS = 24
_TEXT, _BINARY, _PING, _PONG = 1, 2, 9, 10
_FRAME = struct.Struct("<4sHHIIQ")  # docs/stream.md
_PATIENCE = 30.0  # s
_SLEEP = 1.0 / 60.0  # s


@dataclass
class Client:
    """One client, which acknowledges every frame and keeps when its newest tick came in."""

    stream: socket.socket
    columns: list[str] = field(default_factory=list)
    received: list[tuple[float, int]] = field(default_factory=list)
    subscribed: bool = False
    dropped: int = 0
    _data: bytearray = field(default_factory=bytearray)

    @classmethod
    def connect(cls, port: int, session: str) -> Client:
        """Shake hands."""
        stream = socket.create_connection(("127.0.0.1", port), _PATIENCE)
        stream.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        request = (
            f"GET /api/v1/sessions/{session}/stream HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n"
            "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
            "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n"
        )
        stream.sendall(request.encode())
        client = cls(stream)
        head = b""
        while b"\r\n\r\n" not in head:
            got = stream.recv(65536)
            if not got:
                raise ConnectionError(f"no hand-shake: {head!r}")
            head += got
        status, _, rest = head.partition(b"\r\n\r\n")
        if not status.startswith(b"HTTP/1.1 101"):
            raise ConnectionError(status.decode())
        client.take(rest, 0.0)
        while not client.subscribed:
            client.take(stream.recv(65536), 0.0)
        return client

    def take(self, data: bytes, now: float) -> None:
        """Take in what came at `now`, s of ``time.monotonic()``."""
        self._data += data
        while (end := self._end()) is not None:
            start, stop = end
            kind = self._data[0] & 0x0F
            if kind == _BINARY:
                _, _, _, sequence, samples, tick = _FRAME.unpack_from(self._data, start)
                self.received.append((now, tick + samples))
                self._say(b'{"type": "ack", "sequence": %d}' % sequence)
            elif kind == _TEXT:
                self._message(json.loads(self._data[start:stop]))
            elif kind == _PING:
                self._say(bytes(self._data[start:stop]), _PONG)
            del self._data[:stop]

    def _end(self) -> tuple[int, int] | None:
        """Return where the payload of the first message begins and ends, once all of it is here."""
        data = self._data
        if len(data) < 2:
            return None
        start, length = 2, data[1] & 0x7F
        for marker, form in ((126, ">H"), (127, ">Q")):
            if data[1] & 0x7F == marker:
                start = 2 + struct.calcsize(form)
                if len(data) < start:
                    return None
                (length,) = struct.unpack_from(form, data, 2)
        return (start, start + length) if len(data) >= start + length else None

    def _message(self, message: dict) -> None:
        if message["type"] == "hello":
            self.columns = [column["name"] for column in message["columns"]][:COLUMNS]
            subscribe = {"type": "subscribe", "columns": self.columns}
            self._say(json.dumps(subscribe).encode())
        elif message["type"] == "subscribed":
            self.subscribed = True
        elif message["type"] == "gap":
            self.dropped += message["frames"]

    def _say(self, payload: bytes, kind: int = _TEXT) -> None:
        """Send a message, masked with zeros, which changes nothing."""
        length = len(payload)
        head = (
            bytes((0x80 | kind, 0x80 | length))
            if length < 126
            else struct.pack(">BBH", 0x80 | kind, 0x80 | 126, length)
        )
        self.stream.sendall(head + bytes(4) + payload)


def run(clients: list[Client], seconds: float) -> None:
    """Take in what comes for some time."""
    selector = selectors.DefaultSelector()
    for client in clients:
        selector.register(client.stream, selectors.EVENT_READ, client)
    end = time.monotonic() + seconds
    while (left := end - time.monotonic()) > 0.0:
        # Everything is read, and so timed, before the first of it is looked at.
        came = []
        for key, _ in selector.select(left):
            data = key.data.stream.recv(1 << 20)
            if not data:
                raise ConnectionError("the server has closed the stream")
            came.append((key.data, data, time.monotonic()))
        for client, data, now in came:
            client.take(data, now)
    selector.close()


def latencies(clients: list[Client], begun: float, tick: int) -> np.ndarray:
    """Return receipt of every frame less the time at which its newest tick was due, s.

    The session cannot have begun before it was asked to, at `begun`: the request's own way is
    counted in.
    """
    received = np.array([pair for client in clients for pair in client.received])
    return received[:, 0] - begun - (received[:, 1] - tick) * CONTROL_PERIOD


def oversleep(times: int) -> list[float]:
    """Return how much later than asked for this process was woken, s."""
    late = []
    for _ in range(times):
        before = time.monotonic()
        time.sleep(_SLEEP)
        late.append(time.monotonic() - before - _SLEEP)
    return late


def main() -> None:
    """Connect, play, print ``playing``, measure in windows, print the figures, wait for the end."""
    parser = argparse.ArgumentParser(prog="python -m tests.bench.clients", description=__doc__)
    parser.add_argument("port", type=int)
    parser.add_argument("session")
    parser.add_argument("--clients", type=int, default=1)
    parser.add_argument("--frozen", type=int, default=0, help="of them never read")
    parser.add_argument("--windows", type=int, default=3)
    parser.add_argument("--seconds", type=float, default=4.0, help="length of a window")
    options = parser.parse_args()

    clients = [Client.connect(options.port, options.session) for _ in range(options.clients)]
    reading = clients[options.frozen :]
    late = oversleep(60)
    path = f"http://127.0.0.1:{options.port}/api/v1/sessions/{options.session}"
    with httpx.Client(trust_env=False, timeout=_PATIENCE) as rest:

        def play() -> tuple[float, int]:
            tick = rest.post(f"{path}/pause").raise_for_status().json()["tick"]
            time.sleep(0.1)  # until the session no longer keeps pace with the time before
            begun = time.monotonic()
            rest.post(f"{path}/play", json={"speed": 1.0}).raise_for_status()
            run(reading, 0.5)
            return begun, tick

        play()
        print("playing", flush=True)
        windows = []
        for _ in range(options.windows):
            begun, tick = play()
            for client in reading:
                client.received.clear()
            run(reading, options.seconds)
            taken = latencies(reading, begun, tick)
            p50, p99 = np.percentile(taken, (50.0, 99.0))
            frames = len(taken) / len(reading) / options.seconds
            windows.append({"p50": p50, "p99": p99, "frames": frames})
        dropped = sum(client.dropped for client in reading)
        figures = {"windows": windows, "dropped": dropped, "oversleep": max(late)}
        print(json.dumps(figures), flush=True)
        sys.stdin.readline()
        rest.post(f"{path}/pause").raise_for_status()


if __name__ == "__main__":
    main()
