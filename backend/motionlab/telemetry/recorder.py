"""Recordings as files: Parquet or CSV, float32 columns, units in the schema."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from motionlab.config.planar import AXES
from motionlab.errors import StoreError
from motionlab.files import check_target, complete_file
from motionlab.telemetry.channels import CHANNELS, REFERENCES, Channel
from motionlab.telemetry.recording import Recording
from motionlab.timing import CONTROL_PERIOD

if TYPE_CHECKING:
    import pyarrow as pa
    from pyarrow import parquet

SUFFIXES = (".parquet", ".csv")
ROWS = 65_536
"""Ticks in a row group: bounds the memory of long recordings."""

_CSV_ROWS = 4096  # ticks that are made text at a time


@dataclass(frozen=True)
class Column:
    """A column read back from a file."""

    unit: str
    values: NDArray[Any]


def columns(recording: Recording) -> Iterator[tuple[str, Channel, NDArray[np.float32]]]:
    """Yield name, channel and float32 values of every column but ``tick`` and ``time``.

    References come first, as ``x.position_reference``; then every channel of every variant, as
    ``A.x.following_error``; then states of laws of one's own, as ``B.x.law_w``.
    """
    for axis, axis_name in enumerate(AXES):
        for row, channel in enumerate(REFERENCES):
            values = recording.references[row, axis].astype(np.float32)
            yield f"{axis_name}.{channel.name}", channel, values
    for name, record in recording.variants.items():
        for axis in AXES:
            for channel in CHANNELS:
                yield f"{name}.{axis}.{channel.name}", channel, record.channel(channel.name, axis)
    for name, record in recording.variants.items():
        for axis_name, axis in zip(AXES, range(len(AXES)), strict=True):
            for channel, states in record.states.items():
                yield f"{name}.{axis_name}.{channel.name}", channel, states[axis]


def write(recording: Recording, path: str, *, metadata: dict[str, str]) -> None:
    """Write a recording; the same recording gives the same bytes.

    The file appears under its name only when it is complete. Samples after a divergence are null.

    Parameters
    ----------
    recording : Recording
        What to write.
    path : str
        File to write; its suffix, ``.parquet`` or ``.csv``, decides the format.
    metadata : dict of str to str
        Kept in the Parquet file's schema; CSV has no place for it.

    Raises
    ------
    ConfigError
        If the suffix is unknown.
    StoreError
        If the file cannot be written.
    """
    check_target(path, *SUFFIXES)
    with complete_file(path) as partial:
        _write(recording, partial, Path(path).suffix, metadata)


def read(path: str) -> dict[str, Column]:
    """Read a recording back, from Parquet or CSV.

    Parameters
    ----------
    path : str
        File that `write` wrote.

    Returns
    -------
    dict of str to Column
        By name, in the file's order; nulls are NaN.

    Raises
    ------
    StoreError
        If the file cannot be read.
    """
    import pyarrow as pa
    from pyarrow import parquet

    try:
        table = _read_csv(path) if path.endswith(".csv") else parquet.read_table(path)
    except (OSError, pa.ArrowInvalid) as error:
        raise StoreError(f"{path}: cannot be read: {error}") from error
    result = {}
    for field, column in zip(table.schema, table.columns, strict=True):
        if path.endswith(".csv"):
            name, unit = _split_header(field.name)
        else:
            name, unit = field.name, (field.metadata or {}).get(b"unit", b"").decode()
        result[name] = Column(unit, column.to_numpy())
    return result


def _read_csv(path: str) -> pa.Table:
    import pyarrow as pa
    from pyarrow import csv

    # Given, not inferred: a column of whole numbers or of nulls is float32 all the same.
    with csv.open_csv(path) as reader:
        types = {name: pa.float32() for name in reader.schema.names}
    whole = {"tick [1]": pa.int64(), "time [s]": pa.float64()}
    return csv.read_csv(path, convert_options=csv.ConvertOptions(column_types=types | whole))


def _split_header(header: str) -> tuple[str, str]:
    name, _, unit = header.partition(" [")
    return name, unit.removesuffix("]")


def parquet_writer(path: Path, schema: pa.Schema) -> parquet.ParquetWriter:
    """Return a writer of telemetry: byte-stream split, zstd; row groups of `ROWS` ticks."""
    from pyarrow import parquet

    floats = [field.name for field in schema][1:]
    return parquet.ParquetWriter(
        path,
        schema,
        compression="zstd",
        compression_level=3,
        use_dictionary=False,
        column_encoding=dict.fromkeys(floats, "BYTE_STREAM_SPLIT") | {"tick": "PLAIN"},
    )


def _write(recording: Recording, path: Path, suffix: str, metadata: dict[str, str]) -> None:
    from pyarrow import csv

    arrays = list(columns(recording))
    schema = telemetry_schema([(name, channel) for name, channel, _ in arrays], metadata)
    rows = ROWS if suffix == ".parquet" else _CSV_ROWS
    if suffix == ".parquet":
        writer = parquet_writer(path, schema)
    else:
        headers = [f"{f.name} [{f.metadata[b'unit'].decode()}]" for f in schema]
        schema = _renamed(schema, headers)
        writer = csv.CSVWriter(path, schema)
    with writer:
        for start in range(0, recording.ticks, rows):
            stop = min(start + rows, recording.ticks)
            writer.write(_batch(arrays, schema, start, stop, recording.first_tick))


def telemetry_schema(
    channels: Sequence[tuple[str, Channel]], metadata: dict[str, str]
) -> pa.Schema:
    """Return the schema of telemetry: ``tick``, ``time`` and a float32 column a channel."""
    import pyarrow as pa

    fields = [
        pa.field("tick", pa.int64(), metadata={"unit": "1", "meaning": "control period"}),
        pa.field("time", pa.float64(), metadata={"unit": "s", "meaning": "tick times 0.5 ms"}),
    ]
    fields += [
        pa.field(name, pa.float32(), metadata={"unit": channel.unit, "meaning": channel.meaning})
        for name, channel in channels
    ]
    return pa.schema(fields, metadata=metadata)


def _renamed(schema: pa.Schema, names: list[str]) -> pa.Schema:
    import pyarrow as pa

    return pa.schema([f.with_name(name) for f, name in zip(schema, names, strict=True)])


def _batch(
    arrays: list[tuple[str, Channel, NDArray[np.float32]]],
    schema: pa.Schema,
    start: int,
    stop: int,
    first_tick: int,
) -> pa.RecordBatch:
    import pyarrow as pa

    ticks = np.arange(first_tick + start, first_tick + stop)
    data = [pa.array(ticks), pa.array(ticks * CONTROL_PERIOD)]
    data += [pa.array(values[start:stop], from_pandas=True) for _, _, values in arrays]
    return pa.RecordBatch.from_arrays(data, schema=schema)
