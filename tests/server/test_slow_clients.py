"""Clients that lag, stop reading or vanish: they miss frames and are told, nobody else suffers."""

from __future__ import annotations

import os
import socket
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import httpx
import pytest

from motionlab.server.live.messages import Gap
from motionlab.server.live.stream import LAG_SECONDS
from motionlab.server.settings import Settings
from motionlab.telemetry.frames import Frame
from motionlab.timing import CONTROL_PERIOD
from tests.server.conftest import Connect, MakeServer
from tests.server.live import Live, Reader, Stream, counted, until
from tests.server.offline import RING, expected, offline, wanted
from tests.server.servers import PATIENCE, Server

ERRORS = ["A.x.following_error", "B.x.following_error"]
FREEZE = 8.0  # s
SPEED = 10.0
UNREAD = 1_000_000  # bytes


def test_a_client_that_does_not_acknowledge(
    client: httpx.Client, connect: Connect, live: Live
) -> None:
    stream, other = connect(), connect()
    for one in (stream, other):
        one.subscribe(ERRORS)
    before = counted(client, "stream_frames_dropped_total")
    live.step(10)
    first = stream.frame()
    other.ack(other.frame())
    time.sleep(2 * LAG_SECONDS)
    for _ in range(5):
        live.step(1000)
        other.ack(other.frame())
    stream.message("session")
    while not stream.silent():  # session messages only: the frames of 5000 ticks are held back
        pass
    stream.ack(first)
    gap = stream.message("gap")
    assert gap["from_tick"] == 10
    assert gap["to_tick"] == 5010 - 33  # the newest frame of 1/60 s
    assert gap["frames"] == round((gap["to_tick"] - 10) * CONTROL_PERIOD * 60)
    frame = stream.frame()
    assert (frame.sequence, frame.first_tick) == (1, gap["to_tick"])
    assert frame.columns[0].tobytes() == wanted(ERRORS[0], 5010 - 33, 5010)
    assert counted(client, "stream_frames_dropped_total") == before + gap["frames"]


def test_a_slow_client_that_subscribes_again_gets_what_it_asks_for(
    connect: Connect, live: Live
) -> None:
    stream = connect()
    stream.subscribe(ERRORS)
    live.step(10)
    first = stream.frame()
    time.sleep(2 * LAG_SECONDS)
    live.step(5000)
    assert stream.find("session")["session"]["tick"] == 5010
    assert stream.subscribe(ERRORS[:1], from_tick=10)["from_tick"] == 10
    stream.ack(first)
    assert stream.collect(10, 5010)[0].tobytes() == wanted(ERRORS[0], 10, 5010)


def test_a_client_that_stops_reading_between_a_gap_and_its_frame_holds_up_no_other(
    server: Server, connect: Connect, live: Live, monkeypatch: pytest.MonkeyPatch
) -> None:
    # More than any buffer on the way takes: whoever sends after it would wait for its reader.
    monkeypatch.setattr(Gap, "model_dump_json", lambda _: 50_000_000 * " ")
    frozen, other = connect(sock=small_socket(server), max_queue=1), connect()
    for one in (frozen, other):
        one.subscribe(ERRORS)
    live.step(10)
    first = frozen.frame()
    other.ack(other.frame())
    time.sleep(2 * LAG_SECONDS)
    for _ in range(4):  # messages that it does not read, so that it takes in no more
        live.step(1000)
        other.ack(other.frame())
    frozen.ack(first)
    until(lambda: max(server.unsent) > UNREAD)
    for tick in (4010, 4020):
        live.step(10)
        frame = other.frame()
        other.ack(frame)
        assert frame.first_tick == tick
    assert max(server.unsent) > UNREAD  # those came while it had not read yet
    frozen.cut()


@dataclass
class Thaw:
    """What a client found that had not read for a while, and how the server bore it."""

    old: int
    """Ticks that had waited for it."""
    passed: int
    """Ticks of the session meanwhile."""
    gap: dict[str, Any]
    newest: Frame
    tick: int
    """Tick of the session when the client began to read again."""
    unsent: int
    """Most bytes that waited in the server for one connection."""
    grown: int
    """Bytes by which the memory of this process, which is the server too, had grown."""


def resident() -> int:
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def small_socket(server: Server) -> socket.socket:
    """Return a connection whose kernel takes in next to nothing that nobody reads."""
    small = socket.socket()
    small.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    small.connect(("127.0.0.1", server.port))
    return small


def freeze(frozen: Stream, server: Server, live: Live) -> Thaw:
    """Let a client that has just begun to read stop for a while."""
    last = frozen.frame()
    frozen.ack(last)
    start = after(last)
    memory, unsent = resident(), 0
    end = time.monotonic() + FREEZE
    while time.monotonic() < end:
        unsent = max(unsent, *server.unsent)
        time.sleep(0.1)
    grown, tick = resident() - memory, live.tick
    old = 0
    while isinstance(got := frozen.receive(), Frame):
        frozen.ack(got)
        assert got.first_tick == after(last)
        last, old = got, old + got.columns.shape[1]
    assert got["type"] == "gap", got
    assert got["from_tick"] == after(last)
    newest = last = frozen.frame()
    for _ in range(3):
        frozen.ack(last)
        frame = frozen.frame()
        assert frame.first_tick == after(last)
        last = frame
    return Thaw(old, tick - start, got, newest, tick, unsent, grown)


def after(frame: Frame) -> int:
    return frame.first_tick + frame.columns.shape[1]


def test_a_client_that_stops_reading(
    server: Server,
    client: httpx.Client,
    connect: Connect,
    live: Live,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # Longer than a reader is held up by a busy machine.
    monkeypatch.setattr("motionlab.server.live.stream.LAG_SECONDS", FREEZE / 4)
    live.step(RING)  # fills the ring, so that memory need not grow for it
    frozen, reading = connect(sock=small_socket(server), max_queue=1), connect()
    names = list(expected(offline("circle"), 0, 0))
    frozen.subscribe(names)
    reading.subscribe(ERRORS)
    reader = Reader(reading)
    dropped = counted(client, "stream_frames_dropped_total")
    live.do("play", speed=SPEED)
    try:
        thaw = freeze(frozen, server, live)
    finally:
        reader.finish(live.do("pause")["tick"])

    second = SPEED / CONTROL_PERIOD  # ticks
    assert 0 < thaw.old <= 0.5 * second
    assert thaw.gap["to_tick"] == thaw.newest.first_tick
    assert after(thaw.newest) >= thaw.tick
    skipped = thaw.gap["to_tick"] - thaw.gap["from_tick"]
    assert skipped > thaw.passed - 0.5 * second  # a busy machine simulates fewer
    assert thaw.gap["frames"] == round(skipped * CONTROL_PERIOD * 60)
    now = counted(client, "stream_frames_dropped_total")
    assert now >= dropped + thaw.gap["frames"]
    queue = FREEZE * second * 4 * len(names)  # bytes that a queue would hold
    assert thaw.unsent < queue / 20
    assert thaw.grown < queue / 2

    assert {message["type"] for message in reader.messages} <= {"session"}
    assert [frame.first_tick for frame in reader.frames] == [
        RING,
        *(after(frame) for frame in reader.frames[:-1]),
    ]
    assert reader.end >= thaw.tick


def test_a_client_that_never_reads_again_is_given_up(
    make_server: MakeServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("motionlab.server.serve._UNREAD_MAX", 1000)
    server = make_server(Settings())
    with httpx.Client(base_url=server.url, timeout=PATIENCE) as client:
        live = Live.create(client)
        live.step(RING)
        frozen = Stream(server, live.id, sock=small_socket(server), max_queue=1)
        names = list(expected(offline("circle"), 0, 0))
        frozen.send(type="subscribe", columns=names, from_tick=0)
        until(lambda: max(server.unsent) > 0)
        live.delete()
        until(lambda: counted(client, "stream_clients") == 0.0)
        frozen.cut()
