"""Tables of numbers in files of other tools: what imports read."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray
from pyarrow import parquet

from motionlab.config.bounds import check_text
from motionlab.errors import ConfigError, FieldError
from motionlab.runs.import_document import COLUMNS_MAX, GUESSED, VALUES_MAX, ImportOptions
from motionlab.runs.mat_check import check_mat
from motionlab.runs.measured_csv import read_csv
from motionlab.runs.measured_mcap import read_mcap

FORMATS = ("csv", "parquet", "mat", "mcap")

_MAGIC = {b"PAR1": "parquet", b"\x89MCA": "mcap", b"MATL": "mat"}
_DEPTH_MAX = 4  # structs within structs


@dataclass
class FileColumn:
    """A column of a file.

    Attributes
    ----------
    header : str
        What the file calls it.
    unit : str
        What the file gives as its unit, beside the header; often empty.
    values : ndarray of float64
        NaN where the file has none.
    """

    header: str
    unit: str
    values: NDArray[np.float64]


@dataclass
class MeasuredFile:
    """The numbers of a file.

    Attributes
    ----------
    format : str
        One of FORMATS.
    columns : list of FileColumn
        All of one length.
    ignored : dict of str to str
        What is not read: its name, and why.
    text : dict of str to str or int
        Of CSV: ``delimiter``, ``decimal``, ``encoding``, ``first_line`` of the numbers.
    begun : float or None
        Instant of its first row, seconds since 1970, where the file has it.
    """

    format: str
    columns: list[FileColumn]
    ignored: dict[str, str] = field(default_factory=dict)
    text: dict[str, str | int] = field(default_factory=dict)
    begun: float | None = None

    def place(self, row: int) -> str:
        """Return where a row is, for people: a line of a text, else a row counted from 1."""
        first = self.text.get("first_line")
        return f"line {row + int(first)}" if first is not None else f"row {row + 1}"


def read_file(path: Path, said: ImportOptions = GUESSED) -> MeasuredFile:
    """Read a file of any format that is imported; its content decides which.

    Raises
    ------
    ConfigError
        If it cannot be read, naming line, column and reason where it has them.
    """
    with path.open("rb") as stream:
        head = stream.read(4)
    format = _MAGIC.get(head, "csv")
    readers = {"parquet": _read_parquet, "mat": _read_mat, "mcap": _read_mcap}
    file = readers[format](path) if format in readers else _read_csv(path, said)
    check_text([(c.header, c.unit) for c in file.columns], loc="file: column")
    check_text(file.ignored, loc="file")
    empty = [column.header for column in file.columns if not np.isfinite(column.values).any()]
    file.columns = [column for column in file.columns if column.header not in empty]
    file.ignored |= dict.fromkeys(empty, "has no number")
    if not file.columns or len(file.columns[0].values) < 2:
        raise refused("has no column of two numbers or more")
    if (count := len(file.columns)) > COLUMNS_MAX:
        bounds: dict[str, float] = {"maximum": COLUMNS_MAX}
        raise ConfigError(FieldError("file", "has too many columns", count, bounds=bounds))
    return file


def refused(message: str, value: object = None) -> ConfigError:
    """Return the error of a file that cannot be imported."""
    return ConfigError(FieldError("file", message, value))


def _bounded(count: int) -> None:
    if count > VALUES_MAX:
        bounds: dict[str, float] = {"maximum": VALUES_MAX}
        raise ConfigError(FieldError("file", "has too many numbers", count, bounds=bounds))


def _read_csv(path: Path, said: ImportOptions) -> MeasuredFile:
    table = read_csv(path, VALUES_MAX, said.delimiter, said.decimal)
    columns = [FileColumn(c.header, c.unit, c.values) for c in table.columns]
    return MeasuredFile("csv", columns, table.ignored, table.facts, table.begun)


def _read_parquet(path: Path) -> MeasuredFile:
    columns, ignored = [], {}
    try:
        with parquet.ParquetFile(path) as file:
            schema = file.schema_arrow
            wanted = [f for f in schema if _numeric(f.type)]
            ignored = {f.name: f"is {f.type}" for f in schema if not _numeric(f.type)}
            groups = [file.metadata.row_group(i) for i in range(file.metadata.num_row_groups)]
            rows = max(file.metadata.num_rows, sum(group.num_rows for group in groups))
            _bounded(rows * len(wanted))
            for each in wanted:
                column = file.read([each.name], use_threads=False).column(0)
                if pa.types.is_timestamp(each.type):
                    column = column.cast(pa.timestamp("us")).cast(pa.int64())
                    values = column.cast(pa.float64()).to_numpy() / 1e6
                else:
                    values = column.cast(pa.float64()).to_numpy()
                unit = (each.metadata or {}).get(b"unit", b"").decode()
                unit = "s" if pa.types.is_timestamp(each.type) else unit
                columns.append(FileColumn(each.name, unit, np.array(values)))
    except (OSError, pa.ArrowException, UnicodeError) as error:
        raise refused(f"is no Parquet file that can be read: {error}") from None
    return MeasuredFile("parquet", columns, ignored)


def _numeric(kind: pa.DataType) -> bool:
    types = pa.types
    return (
        types.is_floating(kind)
        or types.is_integer(kind)
        or types.is_boolean(kind)
        or types.is_decimal(kind)
        or types.is_timestamp(kind)
    )


def _read_mat(path: Path) -> MeasuredFile:
    from scipy.io import loadmat  # noqa: PLC0415 - a server starts without it

    check_mat(path, 10 * VALUES_MAX)
    try:
        content = loadmat(path, squeeze_me=True, struct_as_record=False)
    except NotImplementedError:
        raise refused("is a MAT file of version 7.3: save it with -v7 in MATLAB") from None
    except MemoryError:
        raise
    except Exception as error:  # whatever a damaged file makes of the reader
        raise refused(f"is no MAT file that can be read: {error}") from None
    roots = {name: value for name, value in content.items() if not name.startswith("__")}
    single = next(iter(roots.values())) if len(roots) == 1 else None
    found = list(_numbers("", vars(single) if _is_struct(single) else roots, 0))
    units, names = _described(single)
    if not found:
        raise refused("has no vector of numbers")
    lengths = Counter(len(values) for _, values in found)
    rows = max(lengths, key=lambda length: (lengths[length] * (length > 1), length))
    ignored = {
        name: f"has {len(values)} values instead of {rows}"
        for name, values in found
        if len(values) != rows
    }
    kept = [(name, values) for name, values in found if len(values) == rows]
    _bounded(rows * len(kept))
    columns = [
        FileColumn(names.get(n, n), units.get(n, ""), values.astype(np.float64))
        for n, values in kept
    ]
    return MeasuredFile("mat", columns, ignored)


def _is_struct(value: Any) -> bool:
    return hasattr(value, "_fieldnames")


def _numbers(prefix: str, members: dict[str, Any], depth: int) -> Iterator[tuple[str, Any]]:
    """Yield the vectors of numbers of structs, and the columns of matrices."""
    for name, value in members.items():
        if name == "_fieldnames":
            continue
        if _is_struct(value) and depth < _DEPTH_MAX:
            yield from _numbers(f"{prefix}{name}.", vars(value), depth + 1)
        if not isinstance(value, np.ndarray) or value.dtype.kind not in "fiub":
            continue
        if value.ndim == 1 and value.size > 1:
            yield f"{prefix}{name}", value
        elif value.ndim == 2:
            table = value if value.shape[0] >= value.shape[1] else value.T
            for index, column in enumerate(table.T, start=1):
                yield f"{prefix}{name}({index})", column


def _described(struct: Any) -> tuple[dict[str, str], dict[str, str]]:
    """Return units and channels of the fields of a struct that an export wrote."""
    units = getattr(struct, "units", None)
    fields, channels = (np.atleast_1d(getattr(struct, n, [])) for n in ("fields", "channels"))
    named = {n: str(u) for n, u in vars(units).items() if n != "_fieldnames"} if units else {}
    return named, {str(f): str(c) for f, c in zip(fields, channels, strict=False)}


def _read_mcap(path: Path) -> MeasuredFile:
    table = read_mcap(path, VALUES_MAX)
    columns = [FileColumn(name, unit, values) for name, unit, values in table.columns]
    return MeasuredFile("mcap", columns, table.ignored, begun=table.begun)
