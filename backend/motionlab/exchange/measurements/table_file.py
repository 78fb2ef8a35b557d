"""Tables of numbers in files of other tools: what imports read."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray
from pyarrow import parquet

from motionlab.config.bounds import check_text
from motionlab.errors import ConfigError, FieldError
from motionlab.exchange.formulas import original
from motionlab.exchange.measurements import npz_arrays
from motionlab.exchange.measurements.csv_table import read_csv
from motionlab.exchange.measurements.document import COLUMNS_MAX, GUESSED, VALUES_MAX, ImportOptions
from motionlab.exchange.measurements.mat_structs import read_mat
from motionlab.exchange.measurements.mcap_table import read_mcap
from motionlab.exchange.measurements.npz_arrays import read_npz

FORMATS = ("csv", "parquet", "mat", "npz", "mcap")

_MAGIC = {
    b"PAR1": "parquet",
    b"\x89MCA": "mcap",
    b"MATL": "mat",
    npz_arrays.ZIP: "npz",
    npz_arrays.NPY: "npz",
    b"\x89HDF": "hdf5",
}
_REPEATED_MAX = 100  # columns of one name


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
    instant : bool
        Whether the file says that these are times.
    bare : bool
        Whether the header is the name alone, and brackets in it hold no unit.
    """

    header: str
    unit: str
    values: NDArray[np.float64]
    instant: bool = False
    bare: bool = False


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
    notes : list of str
        What was passed over, cut off or guessed.
    own : bool
        Whether an export wrote it: names are then what they are.
    """

    format: str
    columns: list[FileColumn]
    ignored: dict[str, str] = field(default_factory=dict)
    text: dict[str, str | int] = field(default_factory=dict)
    begun: float | None = None
    notes: list[str] = field(default_factory=list)
    own: bool = False

    def place(self, row: int) -> str:
        """Return where a row is, for people: a line of a text, else a row counted from 1."""
        first = self.text.get("first_line")
        return f"line {row + int(first)}" if first is not None else f"row {row + 1}"


def read_file(path: Path, options: ImportOptions = GUESSED) -> MeasuredFile:
    """Read a file of any format that is imported; its content decides which.

    Raises
    ------
    ConfigError
        If it cannot be read, naming line, column and reason where it has them.
    """
    with path.open("rb") as stream:
        head = stream.read(4)
    format = _MAGIC.get(head, "csv")
    match format:
        case "parquet":
            file = _read_parquet(path)
        case "mat" | "npz":
            file = _read_arrays(path, format)
        case "mcap":
            file = _read_mcap(path)
        case "hdf5":
            raise refused("is HDF5: save it as NPZ, CSV or Parquet, or with -v7 in MATLAB")
        case _:
            file = _read_csv(path, options)
    check_text([(c.header, c.unit) for c in file.columns], loc="file: column")
    check_text(file.ignored, loc="file")
    empty = [column for column in file.columns if not np.isfinite(column.values).any()]
    file.columns = [column for column in file.columns if np.isfinite(column.values).any()]
    file.ignored |= {column.header: "has no number" for column in empty}
    if not file.columns or len(file.columns[0].values) < 2:
        raise refused("has no column of two numbers or more")
    _bounded_columns(len(file.columns))
    return file


def numbers_in(path: Path) -> int:
    """Return how many numbers a packed file says that it holds; 0 where only reading it tells."""
    with path.open("rb") as stream:
        head = stream.read(4)
    if head == npz_arrays.ZIP:
        return npz_arrays.numbers_in(path)
    if _MAGIC.get(head) != "parquet":
        return 0
    try:
        with parquet.ParquetFile(path) as file:
            return file.metadata.num_rows * file.metadata.num_columns
    except (OSError, pa.ArrowException):  # said by `read_file`
        return 0


def refused(message: str, value: object = None) -> ConfigError:
    """Return the error of a file that cannot be imported."""
    return ConfigError(FieldError("file", message, value))


def _bounded_columns(count: int) -> None:
    if count > COLUMNS_MAX:
        bounds: dict[str, float] = {"maximum": COLUMNS_MAX}
        raise ConfigError(FieldError("file", "has too many columns", count, bounds=bounds))


def _bounded(count: int) -> None:
    if count > VALUES_MAX:
        bounds: dict[str, float] = {"maximum": VALUES_MAX}
        raise ConfigError(FieldError("file", "has too many numbers", count, bounds=bounds))


def _read_csv(path: Path, options: ImportOptions) -> MeasuredFile:
    table = read_csv(path, VALUES_MAX, options.delimiter, options.decimal)
    columns = [FileColumn(original(c.header), c.unit, c.values, c.instant) for c in table.columns]
    return MeasuredFile(
        "csv", columns, table.ignored, table.facts, table.begun, table.notes, table.own
    )


def _read_parquet(path: Path) -> MeasuredFile:
    measured = MeasuredFile("parquet", [])
    try:
        with parquet.ParquetFile(path) as file:
            schema = file.schema_arrow
            measured.own = _is_own(schema)
            measured.ignored = {f.name: f"is {f.type}" for f in schema if not _numeric(f.type)}
            numbers = [f.name for f in schema if _numeric(f.type)]
            groups = [file.metadata.row_group(i) for i in range(file.metadata.num_row_groups)]
            rows = max(file.metadata.num_rows, sum(group.num_rows for group in groups))
            _bounded_columns(len(numbers))  # each is looked for among all
            _bounded(rows * len(numbers))
            counts = Counter(schema.names)
            _refuse_repeated(counts)
            before = Counter[str]()
            for each in schema:
                if _numeric(each.type):
                    table = file.read([each.name], use_threads=False)
                    # A name that stands twice gives all columns of that name.
                    at = before[each.name] if counts[each.name] > 1 else 0
                    _add(measured, each, table.column(at))
                before[each.name] += 1
    except (OSError, pa.ArrowException, UnicodeError) as error:
        raise refused(f"is no Parquet file that can be read: {error}") from None
    return measured


def _refuse_repeated(counts: Counter[str]) -> None:
    """Refuse a name so often that reading its columns takes time by their square."""
    name, count = counts.most_common(1)[0] if counts else ("", 0)
    if count > _REPEATED_MAX:
        message = f"has {count} columns named {name!r}, at most {_REPEATED_MAX} are read"
        raise refused(message)


def _is_own(schema: pa.Schema) -> bool:
    units = [(f.metadata or {}).get(b"unit") for f in schema][:2]
    return schema.names[:2] == ["tick", "time"] and units == [b"1", b"s"]


def _add(file: MeasuredFile, field: pa.Field, column: pa.ChunkedArray) -> None:
    """Add a column; times are seconds, instants count from the first one."""
    per_second = _per_second(field.type)
    if per_second is None:
        unit = (field.metadata or {}).get(b"unit", b"").decode()
        values = np.array(column.cast(pa.float64()).to_numpy())
        file.columns.append(FileColumn(field.name, unit, values, bare=file.own))
        return
    whole = column.cast(pa.int32() if pa.types.is_time32(field.type) else pa.int64())
    missing = np.asarray(whole.is_null())
    ticks = np.asarray(whole.fill_null(0)).astype(np.int64)
    if pa.types.is_timestamp(field.type) and not missing.all():
        first = int(ticks[np.argmin(missing)])
        ticks = ticks - first
        file.begun = first / per_second if file.begun is None else file.begun
    values = np.where(missing, np.nan, ticks / per_second)
    file.columns.append(FileColumn(field.name, "s", values, instant=True, bare=True))


def _per_second(kind: pa.DataType) -> int | None:
    """Return how many steps of a type of times are a second; None for one of numbers."""
    types = pa.types
    if types.is_timestamp(kind) or types.is_time(kind) or types.is_duration(kind):
        unit: str = kind.unit  # pyright: ignore[reportAttributeAccessIssue]
        return {"s": 1, "ms": 10**3, "us": 10**6, "ns": 10**9}[unit]
    return None


def _numeric(kind: pa.DataType) -> bool:
    types = pa.types
    return (
        types.is_floating(kind)
        or types.is_integer(kind)
        or types.is_boolean(kind)
        or types.is_decimal(kind)
        or _per_second(kind) is not None
    )


def _read_arrays(path: Path, format: str) -> MeasuredFile:
    read = read_mat if format == "mat" else read_npz
    table = read(path, 10 * VALUES_MAX, _bounded)
    columns = [
        FileColumn(name, unit, values, instant=instant, bare=table.own or instant)
        for name, unit, values, instant in table.columns
    ]
    return MeasuredFile(format, columns, table.ignored, begun=table.begun, own=table.own)


def _read_mcap(path: Path) -> MeasuredFile:
    table = read_mcap(path, VALUES_MAX)
    columns = [
        FileColumn(name, unit, values, bare=table.own) for name, unit, values in table.columns
    ]
    file = MeasuredFile("mcap", columns, table.ignored, begun=table.begun)
    file.notes, file.own = table.notes, table.own
    return file
