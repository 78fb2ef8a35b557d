"""Motions of kind `samples` from arrays and from files of arrays."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab.config.samples import SAMPLES_MAX
from motionlab.errors import ConfigError, FieldError
from motionlab.exchange.paths.tables import column_units
from motionlab.timing import CONTROL_PERIOD

SUFFIXES = (".npy", ".parquet")
_DIGITS = 12  # of a position in m and a time in s: a picometre, a picosecond
_SINCE_1970 = 9e8, 2.5e9  # s, of an instant from 1998 to 2049
_BYTES_MAX = 50_000_000


def table_of(array: Any, loc: str) -> dict[str, Any]:
    """Return the table of a motion from rows of time, x and y, or of x and y every 0.5 ms, in SI.

    Raises
    ------
    ConfigError
        If the array has another shape, or too many rows.
    """
    values = np.asarray(array)
    if values.ndim != 2 or values.shape[1] not in {2, 3} or values.dtype.kind not in "fiu":
        shapes = "numbers of shape (n, 3), time, x and y, or (n, 2), x and y at 2 kHz"
        raise ConfigError(FieldError(loc, "is no motion", f"{values.dtype} {values.shape}", shapes))
    if np.ma.is_masked(array):
        hidden = f"{np.ma.count_masked(array)} masked values"
        raise ConfigError(FieldError(loc, "has masked values; fill or remove them", hidden))
    _check_count(len(values), loc)
    values = values.astype(np.float64)
    times = np.arange(len(values)) * CONTROL_PERIOD if values.shape[1] == 2 else values[:, 0]
    return samples_table(times, values[:, -2], values[:, -1])


def samples_table(time: NDArray[Any], x: NDArray[Any], y: NDArray[Any]) -> dict[str, Any]:
    """Return the table of a motion: numbers are rounded to 1e-12 s and 1e-12 m.

    Instants since 1970 begin at 0 s, rounded to 1 us, near their resolution.
    """
    if len(time) and _SINCE_1970[0] <= time[0] <= _SINCE_1970[1]:
        time = np.round(time - time[0], 6)
    columns = {"time": time, "x": x, "y": y}
    rounded = {name: np.round(values, _DIGITS).tolist() for name, values in columns.items()}
    return {"kind": "samples", **rounded}


def _check_count(count: int, loc: str) -> None:
    if not 2 <= count <= SAMPLES_MAX:
        message = f"has too {'few' if count < 2 else 'many'} rows"
        bounds = {"minimum": 2.0, "maximum": float(SAMPLES_MAX)}
        raise ConfigError(FieldError(loc, message, count, unit="rows", bounds=bounds))


def table_of_file(path: Path, unit: str, loc: str) -> dict[str, Any]:
    """Return the table of a motion from a NumPy or Parquet file.

    Columns of Parquet are named as those of CSV, `time`, `x` and `y`, with a unit if there is one.

    Raises
    ------
    ConfigError
        If it cannot be read, is too large or has no such columns.
    """
    try:
        size = path.stat().st_size
        if size > _BYTES_MAX:
            bounds = {"maximum": float(_BYTES_MAX)}
            raise ConfigError(FieldError(loc, "is too large", size, unit="bytes", bounds=bounds))
        if path.suffix == ".npy":
            return table_of(np.load(path, allow_pickle=False), loc)
        return _of_parquet(path, unit, loc)
    except (OSError, ValueError) as error:
        message = f"cannot be read: {str(error)[:200]}"
        raise ConfigError(FieldError(loc, message, str(path))) from None


def _of_parquet(path: Path, unit: str, loc: str) -> dict[str, Any]:
    from pyarrow import parquet  # noqa: PLC0415 - slow to import, and seldom needed

    with parquet.ParquetFile(path) as file:
        names = file.schema_arrow.names
        rows = file.metadata.num_rows
        columns = column_units(names, unit)
        missing = [name for name in ("time", "x", "y") if name not in columns]
        if missing:
            message = f"has no column {missing[0]}"
            raise ConfigError(FieldError(loc, message, ", ".join(names)[:200], "time, x and y"))
        _check_count(rows, loc)
        kept = [names[columns[name][0]] for name in ("time", "x", "y")]
        table = file.read(columns=kept)
    values = []
    for name, column in zip(("time", "x", "y"), kept, strict=True):
        numbers = np.asarray(table[column].to_numpy(zero_copy_only=False))
        if numbers.dtype.kind in {"m", "M"}:
            numbers = (numbers - numbers[0]) / np.timedelta64(1, "ns") * 1e-9
        elif numbers.dtype.kind not in "fiu":
            raise ConfigError(FieldError(loc, f"column {column} holds no numbers"))
        values.append(numbers.astype(np.float64) * columns[name][1])
    return samples_table(*values)
