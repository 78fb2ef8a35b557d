"""Telemetry of a live session while it is being recorded: an Arrow stream that only grows.

A Parquet file without its footer cannot be read; of an Arrow stream every complete batch can, so a
killed server loses what was not yet written and nothing else. `compact` makes it Parquet at the
end, or when the next server starts. A long record is a row of such files, and its oldest can go.
"""

from __future__ import annotations

import contextlib
import errno
import fcntl
import io
import os
import shutil
import time
from collections import deque
from collections.abc import Iterator, Sequence
from itertools import chain
from pathlib import Path

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from motionlab.errors import StoreError
from motionlab.files import replace
from motionlab.library.run import Event, RunDetail, is_id
from motionlab.telemetry.channels import Channel
from motionlab.telemetry.recorder import ROWS, parquet_writer, telemetry_schema
from motionlab.timing import CONTROL_PERIOD

_IDLE_SECONDS = 600.0  # after which what is still there is a leftover
_RUN, _SAMPLES, _EVENTS, _ENDED = "run.json", "samples.arrows", "events.jsonl", "ended"
_FURTHER = "samples-*.arrows"  # files of samples after the first, by the tick at which each begins


class Spool:
    """The growing record of one live run; its lock says that its server is alive.

    Raises
    ------
    OSError
        If it cannot be made.
    """

    def __init__(
        self,
        root: Path,
        run: RunDetail,
        channels: Sequence[tuple[str, Channel]],
        metadata: dict[str, str],
    ) -> None:

        self.folder = root / run.id
        part = root / f".{run.id}.new"  # not taken for abandoned before it is locked
        schema = telemetry_schema(channels, metadata)
        self._schema = pa.schema(
            [field for field in schema if field.name != "time"], schema.metadata
        )
        self._sink = io.BytesIO()
        self._writer = self._stream()
        self._samples = self._events = self._lock = -1
        self._older: deque[tuple[Path, int]] = deque()  # complete files of samples, and their bytes
        self._current = self.folder / _SAMPLES
        self.part_size = 0
        self.size = 0
        self.begins = 0  # tick of the oldest sample; above 0 once files have gone
        try:
            replace(part / _RUN, run.model_dump_json().encode())
            self._lock = _created(part / _SAMPLES)
            fcntl.flock(self._lock, fcntl.LOCK_EX)
            self._samples = os.dup(self._lock)
            self._events = _created(part / _EVENTS)
            self._write()
            part.rename(self.folder)
        except OSError:
            self.close()
            shutil.rmtree(part, ignore_errors=True)
            raise

    def append(self, first_tick: int, samples: NDArray[np.float32]) -> None:
        """Append consecutive ticks, all of them or none.

        Parameters
        ----------
        first_tick : int
            Tick of the first.
        samples : ndarray of float32, shape (columns, ticks)
            In the order of the channels.

        Raises
        ------
        OSError
            If they cannot be written; what was written before stays readable.
        """
        ticks = np.arange(first_tick, first_tick + samples.shape[1])
        # Not pa.array, which imports pandas where that is installed: a second, at the first Play.
        arrays = [
            pa.Array.from_buffers(field.type, len(ticks), [None, pa.py_buffer(values)])
            for field, values in zip(self._schema, (ticks, *samples), strict=True)
        ]
        batch = pa.RecordBatch.from_arrays(arrays, schema=self._schema)
        try:
            self._writer.write_batch(batch)
        except BaseException:
            self._discard()
            raise
        self._write()

    def note(self, event: Event) -> None:
        """Append an event.

        Raises
        ------
        OSError
            If it cannot be written.
        """
        _append(self._events, event.model_dump_json().encode() + b"\n")

    def begin_part(self, first_tick: int) -> None:
        """Write what comes, from a tick on, to another file, so that those before can go.

        Raises
        ------
        OSError
            If it cannot be made; what comes is written to the same file as before then.
        """
        path = self.folder / _FURTHER.replace("*", f"{first_tick:012}")
        descriptor = _created(path)
        writer = self._stream()
        head = self._sink.getvalue()
        self._discard()
        try:
            _append(descriptor, head)
        except OSError:
            os.close(descriptor)
            path.unlink(missing_ok=True)
            raise
        os.close(self._samples)
        self._older.append((self._current, self.part_size))
        self._samples, self._current, self._writer = descriptor, path, writer
        self.part_size = len(head)
        self.size += len(head)

    @property
    def divided(self) -> bool:
        """Whether there is a file that can go."""
        return bool(self._older)

    def drop_part(self) -> bool:
        """Remove the oldest file but the one that is being written; return whether there was one.

        Raises
        ------
        OSError
            If it cannot be removed.
        """
        if not self._older:
            return False
        path, size = self._older[0]
        if path.name == _SAMPLES:  # whose lock stays
            os.ftruncate(self._lock, 0)
        else:
            path.unlink()
        self._older.popleft()
        self.size -= size
        oldest = self._older[0][0] if self._older else self._current
        self.begins = int(oldest.stem.rpartition("-")[2])
        return True

    def end(self, *, complete: bool) -> None:
        """Close it, so that it can be compacted."""
        if complete:
            with contextlib.suppress(OSError):
                (self.folder / _ENDED).touch()
        self.close()

    def close(self) -> None:
        """Close its files."""
        for descriptor in (self._events, self._samples, self._lock):
            with contextlib.suppress(OSError):
                os.close(descriptor)

    def _write(self) -> None:
        """Write what the Arrow writer has given; all of it, or the file is as it was."""
        data = self._sink.getvalue()
        self._discard()
        _append(self._samples, data)
        self.part_size += len(data)
        self.size += len(data)

    def _stream(self) -> pa.RecordBatchStreamWriter:
        options = pa.ipc.IpcWriteOptions(compression="lz4")
        return pa.ipc.new_stream(self._sink, self._schema, options=options)

    def _discard(self) -> None:
        self._sink.seek(0)
        self._sink.truncate()


def _created(path: Path) -> int:
    return os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND | os.O_CLOEXEC, 0o600)


def _append(descriptor: int, data: bytes) -> None:
    """Append to a file; all of it, or the file is as it was."""
    status = os.fstat(descriptor)
    if not status.st_nlink:  # removed by hand: what is written from here on cannot be read
        raise FileNotFoundError(errno.ENOENT, "its file was removed while it was written")
    end = status.st_size
    view = memoryview(data)
    try:
        while view:
            view = view[os.write(descriptor, view) :]
    except OSError:
        os.ftruncate(descriptor, end)
        raise


def waiting(root: Path) -> list[str]:
    """Return all spools, also those that are being written."""
    return sorted(folder.name for folder in root.glob("r-*") if is_id(folder.name))


@contextlib.contextmanager
def claimed(root: Path, run_id: str) -> Iterator[bool]:
    """Claim a spool, so that no other process compacts or removes it.

    Yields
    ------
    bool
        False where it is being written, another process has claimed it, or it is gone.
    """
    try:
        descriptor = os.open(root / run_id / _SAMPLES, os.O_RDONLY | os.O_CLOEXEC)
    except OSError:
        yield False
        return
    try:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            mine = os.fstat(descriptor).st_nlink > 0  # else removed since it was opened
        except OSError:
            mine = False
        yield mine
    finally:
        os.close(descriptor)


def gone(root: Path, run_id: str) -> bool:
    """Return whether the samples of a record are no longer there."""
    return not (root / run_id / _SAMPLES).exists()


def remove_leftovers(root: Path) -> None:
    """Remove what killed processes began to make or to remove."""
    for path in root.glob(".r-*"):
        with contextlib.suppress(OSError):
            if abs(time.time() - path.stat().st_mtime) < _IDLE_SECONDS:
                continue
            if path.is_dir():
                shutil.rmtree(path)
            else:
                path.unlink()


def ended(root: Path, run_id: str) -> bool:
    """Return whether a record is complete, and not cut off by its server's end."""
    return (root / run_id / _ENDED).is_file()


def begun(root: Path, run_id: str) -> tuple[RunDetail, list[Event]]:
    """Return what was known of a run at its beginning, and its events.

    Raises
    ------
    StoreError
        If it cannot be read.
    """
    folder = root / run_id
    try:
        run = RunDetail.model_validate_json((folder / _RUN).read_bytes())
        lines = (folder / _EVENTS).read_bytes().splitlines()
    except (OSError, ValueError) as error:
        raise StoreError(f"the recording of {run_id} cannot be read: {error}") from error
    events = []
    for line in lines:
        with contextlib.suppress(ValueError):  # the last may be cut off
            events.append(Event.model_validate_json(line))
    return run, sorted(events, key=lambda event: event.tick)


def compact(root: Path, run_id: str, target: Path) -> int:
    """Write what a spool holds as Parquet; ticks that are missing become nulls.

    Returns
    -------
    int
        Ticks written; a batch that was cut off when its server was killed is not counted.

    Raises
    ------
    OSError
        If it cannot be read, or `target` cannot be written.
    """
    total = 0
    batches = _batches(_parts(root / run_id))
    first = next(batches, None)
    if first is None:
        return 0
    fields = list(first.schema)
    schema = pa.schema([fields[0], _time_field(), *fields[1:]], first.schema.metadata)
    with parquet_writer(target, schema) as writer:
        for rows in _groups(_without_gaps(chain([first], batches), first.schema)):
            writer.write_table(_table(rows, schema), row_group_size=ROWS)
            total += rows.num_rows
    return total


def first_tick(root: Path, run_id: str) -> int:
    """Return the first tick of a record that has lost its oldest files; else 0."""
    parts = _parts(root / run_id)
    if len(parts) < 2 or parts[0].stat().st_size:
        return 0
    return next((batch.column(0)[0].as_py() for batch in _batches(parts)), 0)


def size_of(root: Path, run_id: str) -> int:
    """Return the bytes of the samples of a record; 0 where there is none."""
    size = 0
    for part in _parts(root / run_id):
        with contextlib.suppress(OSError):  # dropped since it was listed
            size += part.stat().st_size
    return size


def samples(root: Path, run_id: str, start: int, stop: int) -> NDArray[np.float32] | None:
    """Return ticks [start, stop) of a record, also while it is being written.

    Returns
    -------
    ndarray of float32, shape (columns, ticks), or None
        None where it does not hold all of them.
    """
    parts = _parts(root / run_id)
    begins = [0, *(int(part.stem.partition("-")[2]) for part in parts[1:])]
    ends = [*begins[1:], stop]
    within = [
        part
        for part, begin, end in zip(parts, begins, ends, strict=True)
        if begin < stop and (end > start or part is parts[-1])
    ]
    pieces, following = [], start
    for batch in _batches(within):
        first = batch.column(0)[0].as_py()
        if first + batch.num_rows <= start:
            continue
        if first >= stop:
            break
        if first > following:
            return None
        kept = batch.slice(following - first, stop - following)
        pieces.append(np.stack([column.to_numpy() for column in kept.columns[1:]]))
        following += kept.num_rows
    return np.concatenate(pieces, axis=1) if pieces and following == stop else None


def _parts(folder: Path) -> list[Path]:
    """Return the files of samples of a record, the oldest first."""
    return [folder / _SAMPLES, *sorted(folder.glob(_FURTHER))]


def remove(root: Path, run_id: str) -> None:
    """Remove a spool; at once, or a killed process would leave a part of it."""
    if not is_id(run_id):
        return
    gone = root / f".{run_id}.old"
    with contextlib.suppress(OSError):
        (root / run_id).rename(gone)
    shutil.rmtree(gone, ignore_errors=True)


def _batches(parts: Sequence[Path]) -> Iterator[pa.RecordBatch]:
    """Yield the complete batches of streams, each of which may be cut off anywhere, or be gone."""
    for part in parts:
        with contextlib.suppress(FileNotFoundError), part.open("rb") as file:
            try:
                reader = pa.ipc.open_stream(file)
            except pa.ArrowInvalid:  # empty, or cut off within the schema
                continue
            while True:
                try:
                    batch = reader.read_next_batch()
                except (StopIteration, OSError, pa.ArrowInvalid):
                    break
                if batch.num_rows:
                    yield batch


def _without_gaps(batches: Iterator[pa.RecordBatch], schema: pa.Schema) -> Iterator[pa.Table]:
    """Yield batches, with rows of NaN for ticks that are missing between them."""
    following: int | None = None
    for batch in batches:
        first = batch.column(0)[0].as_py()
        while following is not None and following < first:
            ticks = np.arange(following, min(first, following + ROWS))
            nothing = pa.array(np.full(len(ticks), np.nan, dtype=np.float32))
            yield pa.table([pa.array(ticks), *[nothing] * (len(schema) - 1)], schema=schema)
            following += len(ticks)
        yield pa.Table.from_batches([batch])
        following = first + batch.num_rows


def _groups(tables: Iterator[pa.Table]) -> Iterator[pa.Table]:
    """Yield rows by whole row groups, and the rest."""
    waiting: list[pa.Table] = []
    for table in tables:
        waiting.append(table)
        if sum(each.num_rows for each in waiting) >= ROWS:
            rows = pa.concat_tables(waiting)
            whole = rows.num_rows // ROWS * ROWS
            yield rows.slice(0, whole)
            waiting = [rows.slice(whole)]
    rest = pa.concat_tables(waiting) if waiting else None
    if rest is not None and rest.num_rows:
        yield rest


def _time_field() -> pa.Field:

    return pa.field("time", pa.float64(), metadata={"unit": "s", "meaning": "tick times 0.5 ms"})


def _table(rows: pa.Table, schema: pa.Schema) -> pa.Table:
    """Return rows with their times, and nulls for what is no number."""
    ticks = rows.column(0).to_numpy()
    floats = [pa.array(column.to_numpy(), from_pandas=True) for column in rows.columns[1:]]
    arrays = [pa.array(ticks), pa.array(ticks * CONTROL_PERIOD), *floats]
    return pa.Table.from_arrays(arrays, schema=schema)
