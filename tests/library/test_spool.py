"""What a live session recorded can be read, wherever its server was killed or its disk was full."""

from __future__ import annotations

import contextlib
import errno
import os
import random
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from pyarrow import parquet

from motionlab.errors import StoreError
from motionlab.library import spool
from motionlab.library.run import Event
from motionlab.library.spool import Spool
from motionlab.telemetry.channels import stream_columns
from motionlab.telemetry.recorder import ROWS
from tests.library.sample_runs import sample
from tests.paths import ROOT

CHANNELS = stream_columns(["A"])


@contextlib.contextmanager
def small_disk(folder: Path, options: str) -> Iterator[Path]:
    """Mount a file system in memory, which only root may."""
    folder.mkdir()
    command = ["mount", "-t", "tmpfs", "-o", options, "tmpfs", str(folder)]
    if os.geteuid() != 0 or subprocess.run(command, capture_output=True, check=False).returncode:
        pytest.skip("a small disk is mounted by root only")
    try:
        yield folder
    finally:
        subprocess.run(["umount", "-l", str(folder)], check=True)


def noise(first: int, ticks: int) -> NDArray[np.float32]:
    """Return samples that any tick can be told by, and that cannot be compressed."""
    generator = np.random.default_rng(first)
    samples = generator.standard_normal((len(CHANNELS), ticks), dtype=np.float32)
    samples[0] = np.arange(first, first + ticks)
    return samples


def made(root: Path) -> Spool:
    return Spool(root, sample(state="recording"), CHANNELS, {"scenario": "{}"})


def ticks_of(root: Path, run_id: str, target: Path) -> NDArray[np.int64]:
    """Compact a spool and return its ticks; every sample must stand at its own."""
    count = spool.compact(root, run_id, target)
    if count == 0:
        return np.empty(0, dtype=np.int64)
    table = parquet.read_table(target)
    assert table.num_rows == count
    ticks = table["tick"].to_numpy()
    first = table[CHANNELS[0][0]].to_numpy()
    assert np.array_equal(table["time"].to_numpy(), ticks * 0.0005)
    assert np.all((first == ticks) | np.isnan(first))
    return ticks


def test_recording_waits_for_no_import_of_pandas(tmp_path: Path) -> None:
    """pyarrow imports it, where it is installed, as soon as an array is made of anything."""
    script = f"""
import sys
from pathlib import Path
from tests.library.test_spool import made, noise
recorded = made(Path({str(tmp_path)!r}))
recorded.append(0, noise(0, 100))
sys.exit("pandas" in sys.modules)
"""
    subprocess.run([sys.executable, "-c", script], cwd=ROOT, check=True)


def test_batches_come_back_in_whole_row_groups(tmp_path: Path) -> None:
    recorded = made(tmp_path)
    sizes = [1000, 1, 70_000, 64_536, 3]
    samples = [noise(sum(sizes[:i]), size) for i, size in enumerate(sizes)]
    for i, each in enumerate(samples):
        recorded.append(sum(sizes[:i]), each)
    recorded.end(complete=True)
    target = tmp_path / "run.parquet"
    assert np.array_equal(ticks_of(tmp_path, recorded.folder.name, target), np.arange(sum(sizes)))
    table = parquet.read_table(target)
    whole = np.concatenate(samples, axis=1)
    for row, (name, _) in zip(whole, CHANNELS, strict=True):
        assert table[name].to_numpy().tobytes() == row.tobytes()
    groups = parquet.read_metadata(target)
    assert groups.row_group(0).num_rows == ROWS
    assert groups.num_row_groups == -(-sum(sizes) // ROWS)


def test_a_file_that_is_cut_off_anywhere_holds_every_whole_batch(tmp_path: Path) -> None:
    recorded = made(tmp_path)
    ends = [(recorded.size, 0)]
    for first in range(0, 50, 10):
        recorded.append(first, noise(first, 10))
        ends.append((recorded.size, first + 10))
    recorded.close()
    path = recorded.folder / "samples.arrows"
    data = path.read_bytes()
    chance = random.Random(5)
    cuts = {0, 1, len(data)} | {end + d for end, _ in ends for d in (-1, 0, 1)}
    cuts |= {chance.randrange(len(data)) for _ in range(40)}
    for cut in sorted(cut for cut in cuts if 0 <= cut <= len(data)):
        path.write_bytes(data[:cut])
        expected = max((ticks for end, ticks in ends if end <= cut), default=0)
        found = ticks_of(tmp_path, recorded.folder.name, tmp_path / "run.parquet")
        assert len(found) == expected, cut


def test_a_gap_becomes_nulls(tmp_path: Path) -> None:
    recorded = made(tmp_path)
    recorded.append(100, noise(100, 50))
    recorded.append(70_200, noise(70_200, 10))
    recorded.end(complete=True)
    target = tmp_path / "run.parquet"
    ticks = ticks_of(tmp_path, recorded.folder.name, target)
    assert np.array_equal(ticks, np.arange(100, 70_210))
    column = parquet.read_table(target)[CHANNELS[-1][0]]
    assert column.null_count == 70_200 - 150


def test_a_full_disk_leaves_the_file_as_it_was(tmp_path: Path) -> None:
    with small_disk(tmp_path / "disk", "size=1m") as disk:
        recorded = made(disk)
        recorded.append(0, noise(0, 100))
        event = Event(tick=1, kind="change", set={"x": 1})
        recorded.note(event)
        filler = disk / "filler"
        with pytest.raises(OSError, match="No space") as refused, filler.open("wb") as file:
            while True:
                file.write(bytes(4096))
                file.flush()
        assert refused.value.errno == errno.ENOSPC
        for _ in range(3):
            with pytest.raises(OSError, match="No space"):
                recorded.append(100, noise(100, 5000))
            with pytest.raises(OSError, match="No space"):
                recorded.note(Event(tick=2, kind="change", set={"x": "y" * 50_000}))
        with pytest.raises(OSError, match="No space"):
            made(disk)
        assert [path.name for path in disk.iterdir() if path.name.startswith(".")] == []
        filler.unlink()
        recorded.append(5100, noise(5100, 100))
        recorded.note(Event(tick=3, kind="stop"))
        recorded.end(complete=True)
        ticks = ticks_of(disk, recorded.folder.name, tmp_path / "run.parquet")
        assert (len(ticks), ticks[-1]) == (5200, 5199)
        _, events = spool.begun(disk, recorded.folder.name)
        assert [each.tick for each in events] == [1, 3]


def test_a_spool_is_claimed_by_one_and_only_when_its_server_is_done(tmp_path: Path) -> None:
    recorded = made(tmp_path)
    recorded.append(0, noise(0, 10))
    run_id = recorded.folder.name
    assert spool.waiting(tmp_path) == [run_id]
    with spool.claimed(tmp_path, run_id) as mine:
        assert not mine
    recorded.end(complete=True)
    with spool.claimed(tmp_path, run_id) as mine, spool.claimed(tmp_path, run_id) as other:
        assert (mine, other) == (True, False)
        descriptor = os.open(recorded.folder / "samples.arrows", os.O_RDONLY)
        spool.remove(tmp_path, run_id)
        os.close(descriptor)
    with spool.claimed(tmp_path, run_id) as mine:
        assert not mine
    assert list(tmp_path.iterdir()) == []


def test_leftovers_of_killed_processes_are_removed_not_those_of_live_ones(tmp_path: Path) -> None:
    old, new = tmp_path / ".r-aaaaaaaaaaaa.old", tmp_path / ".r-bbbbbbbbbbbb.new"
    for folder in (old, new):
        folder.mkdir()
        (folder / "run.json").touch()
    os.utime(old, (1.0, 1.0))
    spool.remove_leftovers(tmp_path)
    assert not old.exists()
    assert new.exists()


def test_events_are_sorted_and_one_that_was_cut_off_is_left_out(tmp_path: Path) -> None:
    recorded = made(tmp_path)
    for tick in (5, 3, 4):
        recorded.note(Event(tick=tick, kind="stop"))
    recorded.close()
    path = recorded.folder / "events.jsonl"
    path.write_bytes(path.read_bytes()[:-10])
    _, events = spool.begun(tmp_path, recorded.folder.name)
    assert [event.tick for event in events] == [3, 5]
    (recorded.folder / "run.json").write_text("{}")
    with pytest.raises(StoreError, match="cannot be read"):
        spool.begun(tmp_path, recorded.folder.name)


def test_a_spool_that_was_removed_takes_nothing(tmp_path: Path) -> None:
    recording = made(tmp_path)
    recording.append(0, noise(0, 100))
    shutil.rmtree(recording.folder)
    with pytest.raises(OSError, match="its file was removed"):
        recording.append(100, noise(100, 100))
    with pytest.raises(OSError, match="its file was removed"):
        recording.note(Event(tick=100, kind="stop"))
    recording.close()
