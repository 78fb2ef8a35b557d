"""Telemetry of a live session while it is being recorded: an Arrow stream that only grows.

A Parquet file without its footer cannot be read; of an Arrow stream every complete batch can, so a
killed server loses what was not yet written and nothing else. `compact` makes it Parquet at the
end, or when the next server starts.
"""

from __future__ import annotations

import contextlib
import errno
import fcntl
import io
import os
import shutil
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from motionlab.config.timing import CONTROL_PERIOD
from motionlab.errors import StoreError
from motionlab.runs.run import Event, RunDetail, is_id
from motionlab.store.files import replace
from motionlab.telemetry.channels import Channel
from motionlab.telemetry.recorder import ROWS, parquet_writer, telemetry_schema

_RUN, _SAMPLES, _EVENTS, _ENDED = "run.json", "samples.arrows", "events.jsonl", "ended"


class Spool:
    """The growing record of one live run; its lock says that its server is alive.

    Parameters
    ----------
    root : Path
        Folder of all spools.
    run : RunDetail
        What is known of it at its beginning.
    channels : sequence of (str, Channel)
        Its columns.
    metadata : dict of str to str
        For the schema of its telemetry.

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
        replace(self.folder / _RUN, run.model_dump_json().encode())
        schema = telemetry_schema(channels, metadata)
        self._schema = pa.schema(
            [field for field in schema if field.name != "time"], schema.metadata
        )
        self._sink = io.BytesIO()
        options = pa.ipc.IpcWriteOptions(compression="lz4")
        self._writer = pa.ipc.new_stream(self._sink, self._schema, options=options)
        self._samples = os.open(
            self.folder / _SAMPLES, os.O_WRONLY | os.O_CREAT | os.O_CLOEXEC, 0o600
        )
        try:
            fcntl.flock(self._samples, fcntl.LOCK_EX | fcntl.LOCK_NB)
            self._end = 0
            self._write()
        except OSError:
            self.close()
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
        arrays = [pa.array(ticks), *(pa.array(row) for row in samples)]
        batch = pa.RecordBatch.from_arrays(arrays, schema=self._schema)
        self._writer.write_batch(batch)
        self._write()

    def note(self, event: Event) -> None:
        """Append an event.

        Raises
        ------
        OSError
            If it cannot be written.
        """
        with (self.folder / _EVENTS).open("ab") as file:
            file.write(event.model_dump_json().encode() + b"\n")

    @property
    def size(self) -> int:
        """Bytes of its samples."""
        return self._end

    def end(self) -> None:
        """Say that the record is complete, and close it; others may then compact it."""
        with contextlib.suppress(OSError):
            (self.folder / _ENDED).touch()
        self.close()

    def close(self) -> None:
        """Close its file."""
        with contextlib.suppress(OSError):
            os.close(self._samples)

    def _write(self) -> None:
        """Write what the Arrow writer has given; all of it, or the file is as it was."""
        view = memoryview(self._sink.getvalue())
        self._sink.seek(0)
        self._sink.truncate()
        try:
            while view:
                view = view[os.write(self._samples, view) :]
        except OSError:
            os.ftruncate(self._samples, self._end)
            os.lseek(self._samples, self._end, os.SEEK_SET)
            raise
        self._end = os.lseek(self._samples, 0, os.SEEK_CUR)


def abandoned(root: Path) -> Iterator[str]:
    """Yield the spools whose server has ended."""
    for folder in sorted(root.glob("r-*")):
        if is_id(folder.name) and _unlocked(folder / _SAMPLES):
            yield folder.name


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
        lines = (folder / _EVENTS).read_bytes().splitlines() if (folder / _EVENTS).is_file() else []
    except (OSError, ValueError) as error:
        raise StoreError(f"the recording of {run_id} cannot be read: {error}") from error
    events = []
    for line in lines:
        with contextlib.suppress(ValueError):  # the last may be cut off
            events.append(Event.model_validate_json(line))
    return run, events


def compact(root: Path, run_id: str, target: Path) -> int:
    """Write what a spool holds as Parquet.

    Parameters
    ----------
    root : Path
        Folder of all spools.
    run_id : str
        Which.
    target : Path
        File to write.

    Returns
    -------
    int
        Ticks written; a batch that was cut off when its server was killed is not counted.

    Raises
    ------
    OSError
        If `target` cannot be written.
    """
    try:
        file = (root / run_id / _SAMPLES).open("rb")
    except FileNotFoundError:  # killed before it was made
        return 0
    total = 0
    with file:
        try:
            reader = pa.ipc.open_stream(file)
        except pa.ArrowInvalid:  # cut off within the schema
            return 0
        fields = list(reader.schema)
        schema = pa.schema([fields[0], _time_field(), *fields[1:]], reader.schema.metadata)
        with parquet_writer(target, schema) as writer:
            for batches in _groups(reader):
                table = _table(batches, schema)
                writer.write_table(table, row_group_size=ROWS)
                total += table.num_rows
    return total


def remove(root: Path, run_id: str) -> None:
    """Remove a spool."""
    if is_id(run_id):
        shutil.rmtree(root / run_id, ignore_errors=True)


def _groups(reader: pa.RecordBatchReader) -> Iterator[list[pa.RecordBatch]]:
    """Yield the complete batches of a stream, which may be cut off anywhere, by row groups."""
    waiting: list[pa.RecordBatch] = []
    with contextlib.suppress(StopIteration, OSError, pa.ArrowInvalid):
        while True:
            waiting.append(reader.read_next_batch())
            if sum(batch.num_rows for batch in waiting) >= ROWS:
                yield waiting
                waiting = []
    if waiting:
        yield waiting


def _time_field() -> pa.Field:

    return pa.field("time", pa.float64(), metadata={"unit": "s", "meaning": "tick times 0.5 ms"})


def _table(batches: list[pa.RecordBatch], schema: pa.Schema) -> pa.Table:
    """Return batches as one table with times, and nulls for what is no number."""
    table = pa.Table.from_batches(batches)
    ticks = table.column(0).to_numpy()
    floats = [pa.array(column.to_numpy(), from_pandas=True) for column in table.columns[1:]]
    arrays = [pa.array(ticks), pa.array(ticks * CONTROL_PERIOD), *floats]
    return pa.Table.from_arrays(arrays, schema=schema)


def _unlocked(path: Path) -> bool:
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_CLOEXEC)
    except OSError as error:
        return error.errno == errno.ENOENT  # killed before it was made
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    finally:
        os.close(descriptor)
    return True
