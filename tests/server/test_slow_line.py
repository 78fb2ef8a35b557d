"""Curves over a line that cannot carry every sample: thinned evenly, without a gap."""

from __future__ import annotations

import time
from collections.abc import Iterator

import numpy as np
import pytest

from motionlab.telemetry.frames import Frame
from motionlab.telemetry.thinning import thinned
from tests.server.conftest import Connect
from tests.server.live import Live, Reader, Stream, until
from tests.server.openapi import Contract
from tests.server.servers import Server
from tests.server.slow_line import SlowLine

LAB = [
    f"{variant}.{axis}.{channel}"
    for channel in (
        "following_error",
        "position",
        "velocity",
        "thrust",
        "force_command",
        "friction",
    )
    for variant in "AB"
    for axis in "xy"
] + [f"{axis}.{kind}_reference" for axis in "xy" for kind in ("position", "velocity")]
"""As many columns as the scopes of the Lab show: 224 kB/s at 2 kHz."""

ERRORS = ["A.x.following_error", "B.x.following_error"]
RATE = 2000  # ticks a second
SECONDS = 8.0
SETTLED = 4.0


def behind(line: SlowLine, live: Live, when_behind: str) -> Stream:
    """Return a stream of the Lab's curves over a slow line."""
    stream = Stream(line, live.id)
    stream.message("hello")
    stream.subscribe(LAB, from_tick=0, when_behind=when_behind)
    return stream


@pytest.fixture
def slow(server: Server, request: pytest.FixtureRequest) -> Iterator[SlowLine]:
    """Return a line of so many bytes/s, 40 ms either way."""
    with SlowLine(server.port, request.param, 0.04) as line:
        yield line


def watched(stream: Stream, live: Live, seconds: float = SECONDS) -> Reader:
    """Return all that came of a session that played for some time."""
    reader = Reader(stream)
    live.do("play")
    time.sleep(seconds)
    live.do("pause")
    reader.finish(live.tick)
    assert not [message for message in reader.messages if message["type"] == "gap"]
    return reader


def check_whole(frames: list[Frame], live: Live) -> None:
    """Check that frames follow one another from tick 0 on and hold what was recorded."""
    tick, columns = 0, live.columns()
    for frame in frames:
        assert frame.first_tick == tick
        full = np.stack([columns[name][tick : frame.end] for name in LAB])
        as_sent = full if frame.stride == 1 else thinned(full, frame.stride)
        assert frame.columns.tobytes() == as_sent.tobytes()
        tick = frame.end


@pytest.mark.parametrize(("slow", "most"), [(250_000, 4), (50_000, 16)], indirect=["slow"])
def test_a_slow_line_has_whole_curves(
    slow: SlowLine, live: Live, contract: Contract, most: int
) -> None:
    with behind(slow, live, "thin") as stream:
        reader = watched(stream, live)
    check_whole(reader.frames, live)
    settled = [frame for frame in reader.frames if frame.first_tick > RATE * SETTLED]
    assert max(frame.stride for frame in settled) <= most
    assert max(frame.end - frame.first_tick for frame in settled) < RATE  # no islands
    delays = [message for message in reader.messages if message["type"] == "delay"]
    for message in delays:
        contract.schema("Delay", message)
    assert delays


@pytest.mark.parametrize("slow", [5_000_000], indirect=True)
def test_a_fast_line_has_every_sample(slow: SlowLine, live: Live) -> None:
    with behind(slow, live, "thin") as stream:
        frames = watched(stream, live, 3.0).frames
    check_whole(frames, live)
    assert {frame.stride for frame in frames} == {1}


@pytest.mark.parametrize("slow", [50_000], indirect=True)
def test_a_line_that_recovers_has_every_sample_again(slow: SlowLine, live: Live) -> None:
    with behind(slow, live, "thin") as stream:
        reader = Reader(stream)
        live.do("play")
        until(lambda: bool(reader.frames) and reader.frames[-1].stride >= 4)
        slow.rate = 5e6
        until(lambda: reader.frames[-1].stride == 1)
        live.do("pause")
        reader.finish(live.tick)
    check_whole(reader.frames, live)


@pytest.mark.parametrize("slow", [100_000], indirect=True)
def test_a_client_that_waits_gets_every_sample_late(slow: SlowLine, live: Live) -> None:
    with behind(slow, live, "wait") as stream:
        reader = watched(stream, live, 2.0)
    check_whole(reader.frames, live)
    assert {frame.stride for frame in reader.frames} == {1}
    assert "delay" not in {message["type"] for message in reader.messages}


@pytest.mark.parametrize("slow", [50_000], indirect=True)
def test_a_slow_line_takes_nothing_from_others(
    slow: SlowLine, live: Live, connect: Connect
) -> None:
    fast = [connect() for _ in range(20)]
    with behind(slow, live, "thin") as late:
        for stream in fast:
            stream.subscribe(ERRORS, from_tick=0, when_behind="thin")
        live.do("play")
        readers = [Reader(stream) for stream in fast]
        slow_reader = Reader(late)
        until(lambda: bool(slow_reader.frames) and slow_reader.frames[-1].stride > 1)
        live.do("pause")
        end = live.tick
        for reader in [*readers, slow_reader]:
            reader.finish(end)
    for reader in readers:
        assert {frame.stride for frame in reader.frames} == {1}
        columns = np.concatenate([frame.columns for frame in reader.frames], axis=1)
        assert columns[0].tobytes() == live.columns()[ERRORS[0]][:end].tobytes()


def test_samples_that_are_left_at_rest_come(connect: Connect, live: Live) -> None:
    """Also where they do not fill the bins of a thinned curve."""
    stream = connect()
    stream.subscribe(LAB, from_tick=0, when_behind="thin")
    for ticks in (1, 37, 1000):
        before = live.tick
        live.step(ticks)
        stream.collect(before, before + ticks)
