"""A session that is left playing goes on being recorded within the quota, its latest part whole."""

from __future__ import annotations

import asyncio
import errno
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from pyarrow import parquet

from motionlab.config.load import load_scenario
from motionlab.library import library as library_module
from motionlab.library import spool
from motionlab.library.library import Library, library, spools
from motionlab.library.run import Event, RunDetail
from motionlab.server.live import run_recorder
from motionlab.server.live.run_recorder import RunRecorder
from motionlab.server.live.session_recorder import SessionRecorder
from motionlab.telemetry.channels import stream_columns
from motionlab.telemetry.ring import Ring
from tests.library.sample_runs import sample
from tests.server.servers import PATIENCE

SCENARIO = load_scenario("circle")
CHANNELS = stream_columns(list(SCENARIO.variants))
BATCH = 200  # ticks
QUOTA = 4_000_000
"""Of the scaled test: 10 GB over 2500."""

DAYS = 30.0
RATE = 670_000.0
"""Bytes that a session of two variants records in a second, measured."""

WRITTEN = DAYS * 86_400 * RATE / 2500
"""Bytes of 30 days in the same scale: 174 times the quota."""

HOUR = 3600 * RATE / 2500
"""Bytes of the last hour: a quarter of the quota."""


class Workers:
    """Calls carried out at once, instead of in processes of a server."""

    async def run(self, function: Any, *arguments: Any, **_: Any) -> Any:
        value = await asyncio.to_thread(function, None, *arguments)
        return SimpleNamespace(value=value, close=lambda: None)


class Fed:
    """A session without a simulation: its ring is filled with noise."""

    def __init__(self, recorder: RunRecorder) -> None:
        self.ring = Ring(len(CHANNELS), 4 * BATCH)
        self.recorder = SessionRecorder(recorder, self.ring, CHANNELS, SCENARIO)
        self._noise = np.random.default_rng(1).standard_normal((len(CHANNELS), BATCH), np.float32)

    def play(self) -> None:
        self.ring.room(BATCH)[:] = self._noise
        self.ring.fill(BATCH)
        self.recorder.advanced(flush=True)


@pytest.fixture
def data(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    monkeypatch.setenv("MOTIONLAB_DATA", str(tmp_path))
    monkeypatch.setenv("MOTIONLAB_RUNS_MAX", str(QUOTA))
    monkeypatch.setattr(run_recorder, "_TIDY_LEAST", 0.0)
    monkeypatch.setattr(run_recorder, "_TIDY_PERIOD", 0.05)
    yield tmp_path
    library().close()
    library_module._library.cache_clear()


def taken(data: Path) -> int:
    """Return the bytes of telemetry in a folder of data."""
    total = 0
    for path in (*data.glob("runs/*.parquet"), *data.glob("recording/r-*/samples*")):
        try:
            total += path.stat().st_size
        except OSError:  # gone since it was listed
            continue
    return total


async def written(recorder: RunRecorder) -> None:
    """Wait until the thread has written what it was handed."""
    async with asyncio.timeout(PATIENCE):
        while recorder._items or recorder._pending:
            await asyncio.sleep(0.001)


def test_thirty_days_fit_the_quota_and_the_last_hour_is_whole(data: Path) -> None:
    asyncio.run(_thirty_days(data))


async def _thirty_days(data: Path) -> None:
    index = library().index
    kept = sample(size=QUOTA // 4, kept=True)  # a quarter is taken by what a person keeps
    index.put(kept, automatic := sample(kind="live", size=QUOTA // 2))
    recorder = RunRecorder(data, Workers())  # pyright: ignore[reportArgumentType]
    session = Fed(recorder)
    most = batches = 0
    size = 4 * BATCH * len(CHANNELS)
    while batches * size < WRITTEN:
        session.play()
        batches += 1
        await written(recorder)
        if batches % 20 == 0:
            most = max(most, taken(data) + kept.size)
    assert session.recorder.problem == ""
    assert most <= QUOTA
    run_id = session.recorder.run
    assert run_id is not None
    assert (begins := session.recorder.begins) > 0
    held = spool.size_of(spools(data), run_id)
    assert held > HOUR
    session.recorder.end()
    await written(recorder)
    async with asyncio.timeout(PATIENCE):
        while index.get(run_id).state == "recording":  # pyright: ignore[reportOptionalMemberAccess]
            await asyncio.sleep(0.01)
    await recorder.close()
    run = library().get(run_id)
    end = batches * BATCH
    assert run.first_tick == begins  # as the Lab said while it was recorded
    table = parquet.read_table(data / "runs" / f"{run_id}.parquet", columns=["tick"])
    ticks = table["tick"].to_numpy()
    assert np.array_equal(ticks, np.arange(run.first_tick, end))
    assert (end - run.first_tick) * 4 * len(CHANNELS) > HOUR
    assert run.state == "partial"
    assert run.reason.startswith(f"its first {run.first_tick * 0.0005:.6g} s have gone")
    assert [(e.kind, e.tick, e.ticks) for e in run.events] == [("gap", 0, run.first_tick)]
    assert index.get(kept.id) == kept
    assert index.get(automatic.id) is None
    assert [each.run for each in index.evictions(10)] == [automatic.id]


def test_recordings_share_what_there_is(data: Path) -> None:
    asyncio.run(_shared(data))


async def _shared(data: Path) -> None:
    library().index.put(sample(size=QUOTA // 2, kept=True))
    recorder = RunRecorder(data, Workers())  # pyright: ignore[reportArgumentType]
    await recorder._balanced()
    sessions = [Fed(recorder) for _ in range(4)]
    for _ in range(100):
        for session in sessions:
            session.play()
        await written(recorder)
        assert taken(data) <= QUOTA // 2
    sizes = [spool.size_of(spools(data), session.recorder.run or "") for session in sessions]
    assert min(sizes) > QUOTA / 2 / len(sizes) / 2
    assert all(session.recorder.problem == "" for session in sessions)
    library().index.put(sample(size=QUOTA // 2, kept=True))  # a person keeps more: nothing is left
    await recorder._balanced()
    sessions[0].play()
    await written(recorder)
    assert "runs that are kept leave no room" in sessions[0].recorder.problem
    await recorder.close()


def test_a_recorder_ends_also_while_room_is_being_made(data: Path) -> None:
    async def ended() -> None:
        recorder = RunRecorder(data, Workers())  # pyright: ignore[reportArgumentType]
        async with asyncio.timeout(PATIENCE):
            while not recorder._crowded._waiters:  # pyright: ignore[reportAttributeAccessIssue]
                await asyncio.sleep(0.001)
        recorder._crowded.set()
        await asyncio.sleep(0)  # what waits has its event, and is ended before it goes on
        async with asyncio.timeout(PATIENCE):
            await recorder.close()

    asyncio.run(ended())


def test_a_recording_of_several_files_is_found_after_a_kill_and_read_in_part(
    tmp_path: Path,
) -> None:
    library = Library(tmp_path)
    run: RunDetail = sample(kind="live", state="recording")
    recorded = spool.Spool(library.spools, run, CHANNELS, {"scenario": "{}"})
    noise = np.random.default_rng(2).standard_normal((len(CHANNELS), 1000), np.float32)
    for first in range(0, 1000, 100):
        if first % 300 == 0 and first:
            recorded.begin_part(first)
        recorded.append(first, noise[:, first : first + 100])
    for start, stop in ((0, 1), (250, 350), (299, 301), (600, 1000), (0, 1000), (899, 900)):
        part = spool.samples(library.spools, run.id, start, stop)
        assert part is not None
        assert np.array_equal(part, noise[:, start:stop])
    assert spool.samples(library.spools, run.id, 900, 1001) is None
    assert recorded.begins == 0
    assert recorded.drop_part()
    assert recorded.begins == 300
    assert recorded.drop_part()
    assert recorded.begins == 600
    assert spool.samples(library.spools, run.id, 599, 700) is None
    assert spool.first_tick(library.spools, run.id) == 600
    with spool.claimed(library.spools, run.id) as mine:
        assert not mine  # its lock has outlived the file
    recorded.note(Event(tick=100, kind="gap", ticks=50, reason="the disk was full"))
    recorded.note(Event(tick=650, kind="push", axis="x", force=1.0, ticks=10))
    recorded.close()
    with spool.claimed(library.spools, run.id) as mine:
        assert mine
    assert spool.compact(library.spools, run.id, tmp_path / "run.parquet") == 400
    ticks = parquet.read_table(tmp_path / "run.parquet")["tick"].to_numpy()
    assert np.array_equal(ticks, np.arange(600, 1000))
    library.close()


def test_a_part_that_cannot_be_begun_leaves_all_as_it_was(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = sample(state="recording")
    recorded = spool.Spool(tmp_path, run, CHANNELS, {"scenario": "{}"})
    noise = np.zeros((len(CHANNELS), 100), np.float32)
    recorded.append(0, noise)

    def full(_: Path) -> int:
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(spool, "_created", full)
        with pytest.raises(OSError, match="No space"):
            recorded.begin_part(100)
    recorded.append(100, noise)
    recorded.close()
    assert spool.compact(tmp_path, run.id, tmp_path / "run.parquet") == 200
