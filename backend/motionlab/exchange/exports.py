"""Runs as files of other tools: CSV, Parquet, MAT, MCAP and MDF."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import tomli_w
from numpy.typing import NDArray
from pyarrow import csv, parquet

from motionlab.errors import ConfigError, FieldError, StoreError, needs
from motionlab.exchange.formulas import inert, original
from motionlab.exchange.mcap_files import Extras, identifiers, write_mcap
from motionlab.exchange.selection import ALL, Selection
from motionlab.files import failure
from motionlab.library.run import RunDetail
from motionlab.library.telemetry import check_columns, read_columns
from motionlab.telemetry.expressions.columns import is_math
from motionlab.telemetry.recorder import ROWS, parquet_writer, read
from motionlab.timing import CONTROL_PERIOD

MAT_MAX = 2**31 - 2**20
"""Most bytes of a variable in a MAT file of format 5, and some room for what describes it."""

_FILE_SHARE = {"csv": 3, "parquet": 1, "mat": 1, "mcap": 2, "mf4": 1}  # of the samples
WHOLE = {"mat": 2, "mf4": 3}
"""Formats that are written as a whole, and how often their samples are in memory then."""

_CSV_ROWS = 4096  # made text at a time
_ALWAYS = ("tick", "time")
_FIELD_MAX = 63  # characters of a field's name in MATLAB
_RESERVED = ("time", "tick", "units", "metadata", "channels", "fields")


@dataclass(frozen=True)
class Source:
    """Telemetry that is exported, and what is known of it.

    Attributes
    ----------
    file : ParquetFile
        Holds it.
    created : float
        Instant of time 0, seconds since 1970.
    about : dict of str to str
        Metadata: of the run, its scenario, seed and versions.
    period : float
        Time between samples, s.
    """

    file: parquet.ParquetFile
    created: float
    about: dict[str, str]
    period: float = CONTROL_PERIOD

    @classmethod
    def of(cls, file: parquet.ParquetFile, run: RunDetail) -> Source:
        """Return the telemetry of a run."""
        own = {"run": run.id, "name": run.name, "kind": run.kind, "state": run.state}
        return cls._with(file, run.created, own, run.period)

    @classmethod
    def of_file(cls, path: Path) -> Source:
        """Return the telemetry of a file that ``motionlab run --out`` or an export wrote.

        Raises
        ------
        ConfigError
            If it is no such file.
        """
        try:
            file = parquet.ParquetFile(_as_parquet(path) if path.suffix == ".csv" else path)
        except (OSError, pa.ArrowInvalid):
            allowed = ".parquet or .csv of motionlab run or export"
            raise ConfigError(FieldError("RUN", "is no telemetry", str(path), allowed)) from None
        except StoreError as error:
            raise ConfigError(FieldError("RUN", str(error), str(path))) from None
        if file.schema_arrow.names[:2] != list(_ALWAYS):
            file.close()
            raise ConfigError(FieldError("RUN", "does not begin with tick and time", str(path)))
        created = (file.schema_arrow.metadata or {}).get(b"created")
        instant = (
            path.stat().st_mtime
            if created is None
            else datetime.fromisoformat(created.decode()).timestamp()
        )
        return cls._with(file, instant, {}, _period(file))

    @classmethod
    def _with(
        cls, file: parquet.ParquetFile, created: float, own: dict[str, str], period: float
    ) -> Source:
        kept = {k.decode(): v.decode() for k, v in (file.schema_arrow.metadata or {}).items()}
        kept.pop("ARROW:schema", None)
        when = datetime.fromtimestamp(created, UTC).isoformat()
        return cls(file, created, kept | own | {"created": when}, period)


def _as_parquet(path: Path) -> pa.BufferReader:
    """Return a CSV file of telemetry as Parquet, in memory."""
    columns = read(str(path))
    arrays = [pa.array(column.values) for column in columns.values()]
    fields = [
        pa.field(original(name), array.type, metadata={"unit": column.unit})
        for (name, column), array in zip(columns.items(), arrays, strict=True)
    ]
    written = pa.BufferOutputStream()
    parquet.write_table(pa.table(arrays, schema=pa.schema(fields)), written, row_group_size=ROWS)
    return pa.BufferReader(written.getvalue())


def _period(file: parquet.ParquetFile) -> float:
    """Return the time of a tick, of which no file says how long it is."""
    ends = _batches_of(file, ROWS, range(file.metadata.num_row_groups), _ALWAYS)
    tick, time = 0, 0.0
    for batch in ends:
        if batch.num_rows:
            tick, time = (batch[name][-1].as_py() for name in _ALWAYS)
    return float(f"{time / tick:.12g}") if tick else CONTROL_PERIOD


def check_selection(source: Source, selection: Selection) -> Selection:
    """Return a selection with every column and the end of its range named.

    Raises
    ------
    ConfigError
        If a column is not there or cannot be computed, or no sample lies in the range.
    """
    named = [name for name in selection.columns if name != ALL]
    math = check_columns(source.file, named, source.period)
    schema, rows = source.file.schema_arrow, source.file.metadata.num_rows
    chosen_names = set(() if ALL in selection.columns else named)
    columns = tuple(
        name
        for name in schema.names
        if name not in _ALWAYS and (not chosen_names or name in chosen_names)
    )
    columns += tuple(math)
    stop = rows if selection.stop is None else min(selection.stop, rows)
    if selection.start >= stop:
        bounds: dict[str, float] = {"minimum": 0, "exclusive_maximum": stop}
        raise ConfigError(
            FieldError("from", "no sample lies there", selection.start, bounds=bounds)
        )
    return Selection(columns, selection.start, stop)


def size_of(selection: Selection, format: str) -> int:
    """Return how many bytes the file of a checked selection has at most, about.

    Raises
    ------
    ConfigError
        If this installation cannot write the format, or a MAT file cannot hold as much.
    """
    _check_installed(format)
    if format == "mat":
        _check_mat(selection)
    return _FILE_SHARE[format] * memory_of(selection)


def writing_memory_of(selection: Selection, format: str) -> int:
    """Return how many bytes of a checked selection are in memory while it is written.

    Formats are written by row groups, but for those in `WHOLE`; math channels are computed first.
    """
    assert selection.stop is not None
    math = 4 * (selection.stop - selection.start) * sum(map(is_math, selection.columns))
    return math + (WHOLE[format] * memory_of(selection) if format in WHOLE else 0)


def memory_of(selection: Selection) -> int:
    """Return how many bytes the samples of a checked selection are."""
    assert selection.stop is not None
    return (selection.stop - selection.start) * (4 * len(selection.columns) + 16)


def export(source: Source, selection: Selection, path: Path, format: str) -> None:
    """Write a part of a run; its float32 values come back equal from every format.

    Parameters
    ----------
    source : Source
        What is exported.
    selection : Selection
        Of `check_selection`.
    path : Path
        File to write.
    format : str
        One of FORMATS.

    Raises
    ------
    ConfigError
        If a MAT file cannot hold as much, or what writes MDF is not installed.
    StoreError
        If the file cannot be written.
    """
    _check_installed(format)
    writers = {
        "csv": _write_csv,
        "parquet": _write_parquet,
        "mat": _write_mat,
        "mcap": _write_mcap,
        "mf4": _write_mdf,
    }
    try:
        writers[format](source, selection, path)
    except OSError as error:
        raise failure(f"{path}: cannot be written", error) from error


def batches(source: Source, selection: Selection, rows: int = ROWS) -> Iterator[pa.RecordBatch]:
    """Yield ``tick``, ``time`` and the columns of a selection, `rows` at a time at most."""
    file, metadata = source.file, source.file.metadata
    assert selection.stop is not None
    math = check_columns(file, selection.columns, source.period)
    schema = schema_of(source, selection)
    computed = {
        text: read_columns(file, [text], {text: each}, selection.start, selection.stop)[0]
        for text, each in math.items()
    }
    groups, first, row = [], 0, 0
    for group in range(metadata.num_row_groups):
        length = metadata.row_group(group).num_rows
        if row + length > selection.start and row < selection.stop:
            first = first if groups else row
            groups.append(group)
        row += length
    names = [*_ALWAYS, *(name for name in selection.columns if name not in math)]
    row = first
    for batch in _batches_of(file, rows, groups, names):
        begin, end = max(selection.start, row), min(selection.stop, row + batch.num_rows)
        if begin < end:
            kept = batch.select(names).slice(begin - row, end - begin)
            part = slice(begin - selection.start, end - selection.start)
            more = [pa.array(computed[text][part], from_pandas=True) for text in math]
            yield pa.RecordBatch.from_arrays([*kept.columns, *more], schema=schema)
        row += batch.num_rows


def _batches_of(
    file: parquet.ParquetFile, rows: int, groups: Iterable[int], names: Sequence[str]
) -> Iterator[pa.RecordBatch]:
    """Yield some row groups; read at once, they would all stay in memory until the last."""
    for group in groups:
        yield from file.iter_batches(rows, [group], list(names), use_threads=False)


def schema_of(source: Source, selection: Selection) -> pa.Schema:
    """Return name, type, unit and meaning of what `batches` yields."""
    schema = source.file.schema_arrow
    math = check_columns(source.file, selection.columns, source.period)
    fields = [schema.field(name) for name in _ALWAYS]
    for name in selection.columns:
        if name in math:
            about = {"unit": math[name].program.unit, "meaning": math[name].expression}
            fields.append(pa.field(math[name].name, pa.float32(), metadata=about))
        else:
            fields.append(schema.field(name))
    return pa.schema(fields)


def _units(schema: pa.Schema) -> dict[str, str]:
    return {field.name: (field.metadata or {}).get(b"unit", b"").decode() for field in schema}


def _write_csv(source: Source, selection: Selection, path: Path) -> None:
    schema = schema_of(source, selection)
    units = _units(schema)
    renamed = pa.schema(
        [pa.field(f"{inert(each.name)} [{units[each.name]}]", each.type) for each in schema]
    )
    with csv.CSVWriter(path, renamed) as writer:
        for batch in batches(source, selection, _CSV_ROWS):
            writer.write(pa.RecordBatch.from_arrays(batch.columns, schema=renamed))


def _write_parquet(source: Source, selection: Selection, path: Path) -> None:
    fields = schema_of(source, selection).with_metadata(source.about)
    with parquet_writer(path, fields) as writer:
        for batch in batches(source, selection):
            whole = pa.RecordBatch.from_arrays(batch.columns, schema=fields)
            writer.write_batch(whole, row_group_size=ROWS)


def _write_mat(source: Source, selection: Selection, path: Path) -> None:
    from scipy.io import savemat  # noqa: PLC0415 - a server starts without it

    _check_mat(selection)
    values = _whole(source, selection)
    tick, time = values.pop("tick"), values.pop("time")
    fields = identifiers(list(values), _FIELD_MAX, _RESERVED)
    units = [_units(schema_of(source, selection))[name] for name in values]
    labels = identifiers(list(source.about), _FIELD_MAX)
    content: dict[str, Any] = {
        "time": time,
        "tick": tick,
        "units": {"time": "s", "tick": "1"} | dict(zip(fields, units, strict=True)),
        "metadata": dict(zip(labels, source.about.values(), strict=True)),
        "channels": np.array(list(values), dtype=object),
        "fields": np.array(fields, dtype=object),
    } | dict(zip(fields, values.values(), strict=True))
    with path.open("wb") as file:
        savemat(file, {"run": content}, format="5", long_field_names=True, oned_as="column")


def _check_mat(selection: Selection) -> None:
    """Refuse what no MAT file can hold."""
    size = memory_of(selection)
    if size > MAT_MAX:
        raise ConfigError(
            FieldError(
                "format",
                "a variable of a MAT file cannot hold as much: export fewer columns, a shorter "
                "range, or Parquet",
                size,
                unit="bytes",
                bounds={"maximum": MAT_MAX},
            )
        )


def _whole(source: Source, selection: Selection) -> dict[str, NDArray[Any]]:
    """Return ``tick``, ``time`` and the columns of a selection as whole arrays."""
    assert selection.stop is not None
    rows = selection.stop - selection.start
    values: dict[str, NDArray[Any]] = {"tick": np.empty(rows, np.int64), "time": np.empty(rows)}
    names = schema_of(source, selection).names[len(_ALWAYS) :]
    values |= {name: np.empty(rows, np.float32) for name in names}
    row = 0
    for batch in batches(source, selection):
        part = slice(row, row + batch.num_rows)
        for name, into in values.items():
            into[part] = batch[name].to_numpy(zero_copy_only=False)
        row = part.stop
    return values


def _write_mdf(source: Source, selection: Selection, path: Path) -> None:
    from asammdf import (  # noqa: PLC0415 - an extra  # pyright: ignore[reportMissingImports]
        MDF,
        Signal,
    )

    values = _whole(source, selection)
    time = values.pop("time")
    schema = schema_of(source, selection)
    meanings = {
        name: (schema.field(name).metadata or {}).get(b"meaning", b"").decode() for name in values
    }
    units = _units(schema)
    signals = [
        Signal(samples, time, units[name], name, comment=meanings[name])
        for name, samples in values.items()
    ]
    whole = path.with_name(f"{path.name}.mf4")  # the only ending that it writes
    try:
        with MDF(version="4.10") as file:
            file.start_time = datetime.fromtimestamp(source.created, UTC)
            file.append(signals, common_timebase=True, comment=source.about.get("run", "run"))
            for name, media, text in _attached(source):
                file.attach(text, name, mime=media)
            file.save(whole, overwrite=True)
        whole.replace(path)
    finally:
        whole.unlink(missing_ok=True)


def _attached(source: Source) -> list[tuple[str, str, bytes]]:
    """Return what goes with a file: metadata, and the scenario, as ``motionlab run`` takes it."""
    about = {name: text for name, text in source.about.items() if name != "scenario"}
    return [*_scenario(source), ("metadata.json", "application/json", json.dumps(about).encode())]


def _scenario(source: Source) -> list[tuple[str, str, bytes]]:
    text = source.about.get("scenario")
    if text is None:
        return []
    tables = _without_nulls(json.loads(text))
    return [("scenario.toml", "application/toml", tomli_w.dumps(tables).encode())]


def _check_installed(format: str) -> None:
    if format == "mf4" and find_spec("asammdf") is None:
        others = ", ".join(name for name in _FILE_SHARE if name != "mf4")
        raise ConfigError(FieldError("format", needs("asammdf"), format, f"one of {others}"))


def _write_mcap(source: Source, selection: Selection, path: Path) -> None:
    extras = Extras(
        {name: text for name, text in source.about.items() if name != "scenario"},
        _scenario(source),
    )
    units = dict(list(_units(schema_of(source, selection)).items())[len(_ALWAYS) :])
    with path.open("wb") as file:
        write_mcap(file, batches(source, selection), units, source.created, extras)


def _without_nulls(value: Any) -> Any:
    """Return tables without what is null, which TOML does not know."""
    if isinstance(value, dict):
        return {key: _without_nulls(item) for key, item in value.items() if item is not None}
    return [_without_nulls(item) for item in value] if isinstance(value, list) else value


def within(
    source: Source, selection: Selection, start: float | None, end: float | None
) -> Selection:
    """Return a selection of the samples of times [start, end], s.

    Raises
    ------
    ConfigError
        If a time is not finite.
    """
    for loc, time in (("--from", start), ("--to", end)):
        if time is not None and not np.isfinite(time):
            raise ConfigError(FieldError(loc, "is not finite", time))
    first, after = 0, 0
    groups = range(source.file.metadata.num_row_groups)
    for batch in _batches_of(source.file, ROWS, groups, ["time"]):
        times = batch["time"].to_numpy()
        first += 0 if start is None else int(np.searchsorted(times, start, "left"))
        after += len(times) if end is None else int(np.searchsorted(times, end, "right"))
    return dataclasses.replace(selection, start=first, stop=after)
