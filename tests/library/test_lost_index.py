"""A PostgreSQL out of reach for a while: requests say so, sessions go on, no run is lost."""

from __future__ import annotations

import contextlib
import socket
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from sqlalchemy import make_url

from tests.library.databases import database
from tests.library.served import API, PATIENCE, Served

SECOND = 2000  # ticks
PART = 65536


class Wire:
    """A loopback port that passes everything on to a server, until it is cut."""

    def __init__(self, host: str, port: int) -> None:
        self._to = (host, port)
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.port: int = self._listener.getsockname()[1]
        self._ends: list[socket.socket] = []
        self._whole = True
        self._thread = threading.Thread(target=self._accept, daemon=True)
        self._thread.start()

    def cut(self) -> None:
        self._whole = False
        for end in self._ends:
            with contextlib.suppress(OSError):
                end.shutdown(socket.SHUT_RDWR)
        self._ends.clear()

    def mend(self) -> None:
        self._whole = True

    def close(self) -> None:
        self.cut()
        self._listener.shutdown(socket.SHUT_RDWR)
        self._thread.join()

    def _accept(self) -> None:
        with self._listener, contextlib.suppress(OSError):
            while True:
                near, _ = self._listener.accept()
                threading.Thread(target=self._connect, args=(near,), daemon=True).start()

    def _connect(self, near: socket.socket) -> None:
        with near:
            if not self._whole:
                return
            with socket.create_connection(self._to) as far:
                self._ends += [near, far]
                back = threading.Thread(target=_pass_on, args=(far, near), daemon=True)
                back.start()
                _pass_on(near, far)
                back.join()


def _pass_on(source: socket.socket, target: socket.socket) -> None:
    with contextlib.suppress(OSError):
        while part := source.recv(PART):
            target.sendall(part)
    for end in (source, target):
        with contextlib.suppress(OSError):
            end.shutdown(socket.SHUT_RDWR)


@pytest.fixture
def wire(tmp_path: Path) -> Iterator[tuple[Wire, str]]:
    """A wire to an empty PostgreSQL, and the address of that database over it."""
    with database("postgresql", tmp_path) as address:
        url = make_url(address)
        wire = Wire(url.host or "127.0.0.1", url.port or 5432)
        over = url.set(host="127.0.0.1", port=wire.port)
        yield wire, over.render_as_string(hide_password=False)
        wire.close()


def states(served: Served) -> dict[str, str]:
    return {run["id"]: run["state"] for run in served.runs()}


def test_an_index_that_is_out_of_reach_for_a_while(wire: tuple[Wire, str], tmp_path: Path) -> None:
    line, address = wire
    served = Served(tmp_path / "data", MOTIONLAB_DATABASE_URL=address)
    try:
        before = served.play()
        end = time.monotonic() + PATIENCE
        while not served.session(before)["run"]:
            assert time.monotonic() < end
        first = served.session(before)["run"]
        assert served.client.get(f"{API}/runs/{first}").json()["state"] == "recording"

        line.cut()
        for path in ("/runs", f"/runs/{first}", "/runs/storage", "/gain-sets"):
            answer = served.client.get(API + path)
            assert answer.status_code == 503, answer.text
            assert "the index of runs cannot be reached" in answer.json()["detail"]
        tick = served.session(before)["tick"]
        short, long = served.play(), served.play()
        while served.session(long)["tick"] < SECOND or served.session(before)["tick"] <= tick:
            assert time.monotonic() < end
        begun, ended = served.session(long)["run"], served.session(short)["run"]
        assert served.session(before)["unrecorded"] == served.session(long)["unrecorded"] == ""
        served.client.delete(short).raise_for_status()

        line.mend()
        wanted = {first: "recording", begun: "recording", ended: "complete"}
        while states(served) != wanted:
            assert time.monotonic() < end, states(served)
            time.sleep(0.2)
        for path in (before, long):
            served.client.delete(path).raise_for_status()
        while set(states(served).values()) != {"complete"}:
            assert time.monotonic() < end, states(served)
            time.sleep(0.2)
        assert min(run["ticks"] for run in served.runs()) >= SECOND // 10
    finally:
        served.kill()
