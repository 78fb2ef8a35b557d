"""The stream over real sockets: every message of docs/stream.md, and those that are none."""

from __future__ import annotations

import contextlib
import json
import struct
import time
from collections.abc import Callable
from typing import Any

import httpx
import numpy as np
import pytest
from websockets.exceptions import ConnectionClosed

from motionlab.server.live.stream import DETAIL_MAX, FRAME_TICKS_MAX
from motionlab.server.serve import MESSAGE_MAX
from motionlab.telemetry.channels import CHANNELS, REFERENCES
from motionlab.telemetry.frames import HEADER_BYTES
from motionlab.timing import CONTROL_PERIOD
from tests.server.conftest import Connect, MakeLive
from tests.server.live import Live, Stream, counted, until
from tests.server.offline import RING, expected, offline, wanted
from tests.server.openapi import Contract
from tests.server.servers import PATIENCE, Server

ERRORS = ["A.x.following_error", "B.x.following_error"]


@pytest.fixture(autouse=True)
def _patient(monkeypatch: pytest.MonkeyPatch) -> None:
    """Have no client of these tests count as one that lags, however busy the machine is."""
    monkeypatch.setattr("motionlab.server.live.stream.LAG_SECONDS", PATIENCE)


# -- the protocol ---------------------------------------------------------------------------------


def test_hello(server: Server, live: Live, contract: Contract) -> None:
    live.step(5)
    with Stream(server, live.id) as stream:
        hello = stream.message("hello")
    contract.schema("Hello", hello)
    assert (hello["protocol"], hello["rate"]) == (1, round(1 / CONTROL_PERIOD))
    assert hello["variants"] == ["A", "B"]
    assert hello["session"] == live.info() | {"watchers": 1}
    columns = {column["name"]: column for column in hello["columns"]}
    assert list(columns) == list(expected(offline("circle"), 0, 0))
    for prefix, channels in (("x.", REFERENCES), ("y.", REFERENCES), ("B.y.", CHANNELS)):
        for channel in channels:
            column = columns[prefix + channel.name]
            assert (column["unit"], column["meaning"]) == (channel.unit, channel.meaning)


def test_every_column_bit_for_bit(connect: Connect, live: Live) -> None:
    stream = connect()
    names = list(expected(offline("circle"), 0, 0))
    assert stream.subscribe(names)["columns"] == names
    for ticks in (1, 99, 900):
        start = live.tick
        live.step(ticks)
        columns = stream.collect(start, start + ticks)
        for row, name in enumerate(names):
            assert columns[row].tobytes() == wanted(name, start, start + ticks), name


def test_a_frame_is_laid_out_as_documented(connect: Connect, live: Live) -> None:
    stream = connect()
    live.step(10)
    stream.subscribe(ERRORS)
    for sequence, (first, count) in enumerate([(10, 7), (17, 3)]):
        live.step(count)
        data = stream.socket.recv()
        while isinstance(data, str):
            data = stream.socket.recv()
        header = struct.unpack_from("<4sHHIIQ", data)
        assert header == (b"PSRM", 1, 2, sequence, count, first)
        assert len(data) == 24 + 4 * 2 * count
        assert HEADER_BYTES == 24
        assert data[24:] == b"".join(wanted(name, first, first + count) for name in ERRORS)


def test_subscriptions_begin_where_they_say(connect: Connect, live: Live) -> None:
    stream = connect()
    live.step(500)
    assert stream.subscribe(ERRORS) == {
        "type": "subscribed",
        "columns": ERRORS,
        "from_tick": 500,
    }
    assert stream.silent()
    assert stream.subscribe(ERRORS[::-1], from_tick=120)["from_tick"] == 120
    columns = stream.collect(120, 500)
    assert columns[1].tobytes() == wanted(ERRORS[0], 120, 500)
    assert stream.subscribe(ERRORS, from_tick=10_000)["from_tick"] == 500  # has not come yet
    live.step(3)
    stream.collect(500, 503)


def test_a_client_resumes_without_a_hole(server: Server, live: Live) -> None:
    live.do("play", speed=2.0)
    pieces = []
    tick = 0
    for _ in range(3):
        with Stream(server, live.id) as stream:
            stream.message("hello")
            assert stream.subscribe(ERRORS, from_tick=tick)["from_tick"] == tick
            for _ in range(5):
                frame = stream.frame()
                assert frame.first_tick == tick
                stream.ack(frame)
                pieces.append(frame.columns)
                tick += frame.columns.shape[1]
        time.sleep(0.1)
    assert np.concatenate(pieces, axis=1)[0].tobytes() == wanted(ERRORS[0], 0, tick)


def test_resuming_from_before_what_is_kept(connect: Connect, live: Live) -> None:
    live.step(RING + 700)
    stream = connect()
    assert stream.subscribe(ERRORS, from_tick=0)["from_tick"] == 700
    columns = stream.collect(700, RING + 700)
    assert columns.shape == (2, RING)
    kept = live.columns()
    assert columns[1].tobytes() == kept[ERRORS[1]].tobytes()


def test_long_stretches_come_in_several_frames(connect: Connect, live: Live) -> None:
    live.step(2 * FRAME_TICKS_MAX + 1)
    stream = connect()
    stream.subscribe(ERRORS, from_tick=0)
    sizes = [stream.frame().columns.shape[1] for _ in range(3)]
    assert sizes == [FRAME_TICKS_MAX, FRAME_TICKS_MAX, 1]


def test_frames_of_as_many_ticks_as_were_asked_for(connect: Connect, live: Live) -> None:
    stream = connect()
    live.do("play", speed=10.0)
    tick = stream.subscribe(ERRORS, frame_ticks=500)["from_tick"]
    for _ in range(3):
        frame = stream.frame()
        assert (frame.first_tick, frame.columns.shape[1] >= 500) == (tick, True)
        tick += frame.columns.shape[1]
        stream.ack(frame)
    live.do("pause")
    if live.tick > tick:
        stream.collect(tick, live.tick)  # fewer than 500, or they were sent before
    live.step(7)
    stream.collect(live.tick - 7, live.tick)


def test_changing_the_subscription_while_playing(connect: Connect, live: Live) -> None:
    stream = connect()
    live.do("play")
    for names in (ERRORS, ["y.position_reference"], [], ["B.y.thrust", "A.y.K", "x.load_force"]):
        answer = stream.subscribe(names)
        assert answer["columns"] == names
        if not names:
            assert stream.silent()
            continue
        frame = stream.frame()
        assert frame.first_tick == answer["from_tick"]
        assert frame.columns.shape[0] == len(names)
        end = frame.first_tick + frame.columns.shape[1]
        for row, name in enumerate(names):
            assert frame.columns[row].tobytes() == wanted(name, frame.first_tick, end)
        stream.ack(frame)


def test_clients_with_subscriptions_of_their_own(connect: Connect, live: Live) -> None:
    subscriptions = [ERRORS, ["A.y.thrust"], ["x.position_reference", "B.x.K", "B.y.friction"]]
    streams = [connect() for _ in subscriptions]
    for stream, names in zip(streams, subscriptions, strict=True):
        stream.subscribe(names)
    live.step(1500)
    for stream, names in zip(streams, subscriptions, strict=True):
        for row, values in enumerate(stream.collect(0, 1500)):
            assert values.tobytes() == wanted(names[row], 0, 1500)


def told_until(stream: Stream, holds: Callable[[dict[str, Any]], bool], contract: Contract) -> Any:
    """Return what a session tells once something holds; it also tells which run is recorded."""
    told: dict[str, Any] = {}
    for _ in range(5):
        message = stream.find("session")
        contract.schema("SessionMessage", message)
        told = message["session"]
        if holds(told):
            return told
    raise AssertionError(told)


def test_a_session_tells_of_its_state(connect: Connect, live: Live, contract: Contract) -> None:
    stream = connect()
    revision = 0
    for asks, holds in (
        (
            lambda: live.do("play", speed=0.5),
            lambda s: (s["state"], s["speed"]) == ("playing", 0.5),
        ),
        (lambda: live.do("pause"), lambda s: s["state"] == "paused"),
        (
            lambda: live.change({"plant.x.mass": 7.0}),
            lambda s: [each["set"] for each in s["changes"]] == [{"plant.x.mass": 7.0}],
        ),
        (lambda: live.do("undo"), lambda s: s["changes"] == []),
        (lambda: live.do("stop"), lambda s: s["state"] == "stopping"),
    ):
        asks()
        told = told_until(stream, holds, contract)
        assert told["revision"] > revision
        revision = told["revision"]
    told_until(stream, lambda s: s["state"] == "stopped", contract)
    live.do("reset")
    told_until(stream, lambda s: s["state"] == "paused", contract)
    live.change({"plant.x.mass": 7.0})
    (change,) = told_until(stream, lambda s: s["changes"] != [], contract)["changes"]
    assert (change["tick"], change["set"]) == (0, {"plant.x.mass": 7.0})
    live.do("undo")
    told_until(stream, lambda s: s["changes"] == [], contract)


def test_a_reset_begins_a_new_timeline(connect: Connect, live: Live) -> None:
    stream = connect()
    stream.subscribe(ERRORS)
    live.do("play")
    for _ in range(4):
        stream.ack(stream.frame())
    live.do("reset")
    assert stream.find("reset") == {"type": "reset"}
    assert stream.message("session")["session"]["tick"] == 0
    live.step(50)
    columns = stream.collect(0, 50)
    assert columns[0].tobytes() == wanted(ERRORS[0], 0, 50)


# -- messages that cannot be used -----------------------------------------------------------------

SUBSCRIBE = {"type": "subscribe", "columns": ERRORS}


@pytest.mark.parametrize(
    "message",
    [
        "",
        "nonsense",
        "{",
        "[]",
        "null",
        "{}",
        b"\x00\x01\x02",
        b'{"type": "ack", "sequence": 0}',
        '{"type": "shout"}',
        '{"type": "ack"}',
        '{"type": "ack", "sequence": -1}',
        '{"type": "ack", "sequence": 1.5}',
        '{"type": "ack", "sequence": NaN}',
        '{"type": "ack", "sequence": 0, "more": 1}',
        '{"type": "subscribe"}',
        '{"type": "subscribe", "columns": "A.x.thrust"}',
        '{"type": "subscribe", "columns": [1]}',
        '{"type": "subscribe", "columns": ["\\ud800"]}',
        '{"type": "subscribe", "columns": [], "from_tick": -1}',
        json.dumps(SUBSCRIBE | {"columns": ["A.x.nonsense"]}),
        json.dumps(SUBSCRIBE | {"columns": ["C.x.thrust"]}),
        json.dumps(SUBSCRIBE | {"columns": [*ERRORS, ERRORS[0]]}),
        json.dumps(SUBSCRIBE | {"columns": 5000 * ["A.x.K"]}),
        json.dumps(SUBSCRIBE | {"columns": [100_000 * "x"]}),
        json.dumps({"type": 100_000 * "x"}),
        50_000 * "[",
    ],
    ids=lambda message: repr(message[:60]),
)
def test_a_message_that_cannot_be_used(
    connect: Connect, live: Live, contract: Contract, message: str | bytes
) -> None:
    stream = connect()
    stream.subscribe(ERRORS)
    stream.socket.send(message)
    error = stream.message("error")
    contract.schema("ErrorMessage", error)
    assert error["problem"]["status"] == 400
    assert 0 < len(error["problem"]["detail"]) <= DETAIL_MAX
    live.step(20)
    stream.collect(0, 20)  # what was subscribed goes on


def test_an_unknown_column_is_named(connect: Connect) -> None:
    stream = connect()
    stream.send(type="subscribe", columns=["A.x.nonsense"])
    assert "'A.x.nonsense'" in stream.message("error")["problem"]["detail"]


def test_a_huge_message_closes_the_connection(connect: Connect, live: Live) -> None:
    stream, other = connect(), connect()
    stream.socket.send(MESSAGE_MAX * " " + "{}")
    with pytest.raises(ConnectionClosed) as closed:
        stream.receive()
    assert closed.value.rcvd is not None
    assert closed.value.rcvd.code == 1009
    other.subscribe(ERRORS)
    live.step(1)
    other.collect(0, 1)


def test_an_ack_of_what_was_never_sent(connect: Connect, live: Live) -> None:
    stream = connect()
    stream.send(type="ack", sequence=10**12)
    stream.subscribe(ERRORS)
    stream.send(type="ack", sequence=2**63)
    live.step(40)
    frame = stream.frame()
    stream.send(type="ack", sequence=frame.sequence + 10)
    stream.send(type="ack", sequence=frame.sequence)
    live.step(40)
    again = stream.frame()
    assert (again.sequence, again.first_tick) == (1, 40)


def test_questions_without_reading_the_answers(
    server: Server, connect: Connect, live: Live
) -> None:
    rude = connect(max_queue=1)
    other = connect()
    other.subscribe(ERRORS)
    with contextlib.suppress(TimeoutError, ConnectionClosed):
        rude.socket.socket.settimeout(1.0)
        for _ in range(20_000):
            rude.socket.send('{"type": "nonsense"}')
    assert max(server.unsent) < 1_000_000
    live.step(5)
    other.collect(0, 5)
    rude.cut()


# -- the end --------------------------------------------------------------------------------------


def test_a_session_deleted_while_it_streams(
    server: Server, make_live: MakeLive, connect: Connect, live: Live
) -> None:
    ending = make_live()
    with Stream(server, ending.id) as stream:
        stream.message("hello")
        stream.subscribe(ERRORS)
        ending.do("play")
        stream.ack(stream.frame())
        ending.delete()
        with pytest.raises(ConnectionClosed) as closed:
            while True:
                stream.receive()
        assert closed.value.rcvd is not None
        assert closed.value.rcvd.code == 1001
    other = connect()
    other.subscribe(ERRORS)
    live.step(1)
    other.collect(0, 1)


def test_a_stream_of_no_session(server: Server) -> None:
    with pytest.raises(Exception, match="403"):
        Stream(server, "nowhere")


def test_a_hundred_quick_clients_leave_nothing(
    server: Server, client: httpx.Client, live: Live
) -> None:
    live.do("play")
    for round_ in range(100):
        stream = Stream(server, live.id)
        if round_ % 2:
            stream.send(type="subscribe", columns=ERRORS, from_tick=0)
        if round_ % 3 == 0:
            stream.cut()
        stream.close()
    until(lambda: server.listeners == 0)
    until(lambda: counted(client, "stream_clients") == 0.0)
