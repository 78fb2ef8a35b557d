"""Sessions as a client sees them: over REST, and their stream."""

from __future__ import annotations

import contextlib
import inspect
import io
import json
import re
import socket
import struct
import threading
import time
from collections.abc import Callable, Sequence
from types import TracebackType
from typing import Any, Protocol, Self

import httpx
import numpy as np
import pyarrow.parquet as pq
from numpy.typing import NDArray
from websockets.sync.client import connect

from motionlab.telemetry.frames import Frame, decode
from tests.server.servers import PATIENCE

API = "/api/v1"
NOTICE = 0.3
"""Seconds to wait for what should not come."""


def until(holds: Callable[[], bool]) -> None:
    """Wait until something holds; fail when it does not for long."""
    end = time.monotonic() + PATIENCE
    pause = 0.01
    while not holds():
        assert time.monotonic() < end, (
            f"not within {PATIENCE} s: {inspect.getsource(holds).strip()}"
        )
        time.sleep(pause)
        pause = min(1.2 * pause, 0.05)  # a look is often a request, which is not free


def counted(client: httpx.Client, name: str) -> float:
    """Return a count of /metrics."""
    match = re.search(rf"^motionlab_{name} (\S+)$", client.get("/metrics").text, re.MULTILINE)
    assert match is not None, name
    return float(match[1])


class Live:
    """A session over REST.

    Parameters
    ----------
    client : httpx.Client
        Talks to the server.
    path : str
        Address of the session.
    """

    def __init__(self, client: httpx.Client, path: str) -> None:
        self.client = client
        self.path = path

    @classmethod
    def create(
        cls, client: httpx.Client, scenario: Any = "circle", changes: dict[str, Any] | None = None
    ) -> Live:
        """Create a session."""
        body = {"scenario": scenario, "set": changes or {}}
        response = client.post(f"{API}/sessions", json=body)
        assert response.status_code == 201, response.text
        return cls(client, response.headers["location"])

    @property
    def id(self) -> str:
        return self.path.rsplit("/", 1)[1]

    def info(self) -> dict[str, Any]:
        """Return what the server knows of it."""
        response = self.client.get(self.path)
        assert response.status_code == 200, response.text
        return response.json()

    @property
    def state(self) -> str:
        return self.info()["state"]

    @property
    def tick(self) -> int:
        return self.info()["tick"]

    def post(self, action: str, **body: Any) -> httpx.Response:
        """Ask for an action."""
        return self.client.post(f"{self.path}/{action}", json=body or None)

    def do(self, action: str, **body: Any) -> dict[str, Any]:
        """Ask for an action that has to succeed."""
        response = self.post(action, **body)
        assert response.status_code == 200, response.text
        return response.json()

    def step(self, ticks: int) -> dict[str, Any]:
        """Advance by any number of ticks."""
        for done in range(0, ticks, 20_000):
            self.do("step", ticks=min(20_000, ticks - done))
        return self.info()

    def change(self, changes: dict[str, Any]) -> int:
        """Change parameters and return the tick from which they hold."""
        response = self.client.patch(f"{self.path}/parameters", json={"set": changes})
        assert response.status_code == 200, response.text
        return response.json()["tick"]

    def columns(self) -> dict[str, NDArray[Any]]:
        """Return every column that the ring holds."""
        response = self.client.get(f"{self.path}/telemetry", params={"format": "parquet"})
        assert response.status_code == 200, response.text
        table = pq.read_table(io.BytesIO(response.content))
        return {name: table[name].to_numpy() for name in table.column_names}

    def delete(self) -> None:
        """End it, if it has not ended yet."""
        assert self.client.delete(self.path).status_code in {204, 404}


class Place(Protocol):
    """Where streams are: a server, or a line to one."""

    def stream(self, session_id: str) -> str:
        """Return the address of a session's stream."""
        ...


class Stream:
    """One client of a session's stream.

    Parameters
    ----------
    server : Place
        Where the session lives.
    session_id : str
        Which session.
    options
        Further arguments of ``websockets.sync.client.connect``.
    """

    def __init__(self, server: Place, session_id: str, **options: Any) -> None:
        address = server.stream(session_id)
        self._ended = contextlib.ExitStack()
        self.socket = self._ended.enter_context(
            connect(
                address,
                compression=None,
                max_size=None,
                proxy=None,
                open_timeout=PATIENCE,
                **options,
            )
        )

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        value: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """Leave."""
        self._ended.close()

    def cut(self) -> None:
        """Be gone without a word, as when a machine loses its power."""
        connection = self.socket.socket
        with contextlib.suppress(OSError):  # the server may have gone first
            connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            connection.shutdown(socket.SHUT_RD)
        connection.close()

    def send(self, **message: Any) -> None:
        """Send a JSON message."""
        self.socket.send(json.dumps(message))

    def receive(self, timeout: float = PATIENCE) -> dict[str, Any] | Frame:
        """Return the next message, decoded."""
        data = self.socket.recv(timeout)
        return json.loads(data) if isinstance(data, str) else decode(data)

    def message(self, kind: str) -> dict[str, Any]:
        """Return the next message, which has to be JSON of this type."""
        got = self.receive()
        assert isinstance(got, dict), f"a frame of tick {got.first_tick}"
        assert got["type"] == kind, got
        return got

    def find(self, kind: str) -> dict[str, Any]:
        """Return the next JSON message of this type; frames on the way are acknowledged."""
        while True:
            got = self.receive()
            if isinstance(got, Frame):
                self.ack(got)
            elif got["type"] == kind:
                return got

    def frame(self) -> Frame:
        """Return the next frame without acknowledging it; news of the session are passed over."""
        while True:
            got = self.receive()
            if isinstance(got, Frame):
                return got
            assert got["type"] in {"session", "delay"}, got

    def ack(self, frame: Frame) -> None:
        """Acknowledge a frame."""
        self.send(type="ack", sequence=frame.sequence)

    def subscribe(
        self, columns: Sequence[str], from_tick: int | None = None, **others: Any
    ) -> dict[str, Any]:
        """Subscribe and return the answer."""
        more = others if from_tick is None else others | {"from_tick": from_tick}
        self.send(type="subscribe", columns=list(columns), **more)
        return self.find("subscribed")

    def collect(self, start: int, end: int) -> NDArray[np.float32]:
        """Return the columns over ticks [start, end) from frames without a hole between them."""
        pieces = []
        tick = start
        while tick < end:
            frame = self.frame()
            assert frame.first_tick == tick
            pieces.append(frame.columns)
            tick += frame.columns.shape[1]
            self.ack(frame)
        assert tick == end
        return np.concatenate(pieces, axis=1)

    def silent(self) -> bool:
        """Return whether nothing comes for a while."""
        try:
            self.socket.recv(NOTICE)
        except TimeoutError:
            return True
        return False


class Reader:
    """A client that takes everything in and acknowledges it, in a thread of its own.

    Parameters
    ----------
    stream : Stream
        Subscribed to something.
    """

    def __init__(self, stream: Stream) -> None:
        self.frames: list[Frame] = []
        self.messages: list[dict[str, Any]] = []
        self._stream = stream
        self._until: int | None = None
        self._thread = threading.Thread(target=self._read, name="reader")
        self._thread.start()

    def finish(self, tick: int) -> None:
        """Wait until every tick before `tick` has come."""
        self._until = tick
        self._thread.join(PATIENCE)
        assert not self._thread.is_alive()

    @property
    def end(self) -> int:
        """The tick after the last that has come."""
        return self.frames[-1].end if self.frames else 0

    def _read(self) -> None:
        while self._until is None or self.end < self._until:
            try:
                got = self._stream.receive(0.1)
            except TimeoutError:
                continue
            if isinstance(got, Frame):
                self._stream.ack(got)
                self.frames.append(got)
            else:
                self.messages.append(got)
