"""Telemetry in Parquet files, read by row groups."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from pyarrow import parquet


def read_ticks(
    file: parquet.ParquetFile, columns: Sequence[str], start: int, stop: int
) -> NDArray[np.float32]:
    """Return samples [start, stop) of some columns, counted from the first that is recorded.

    Only the row groups that hold them are read.

    Parameters
    ----------
    file : ParquetFile
        An open file of telemetry.
    columns : sequence of str
        Names of float32 columns.
    start, stop : int
        Samples; cut to what there is.

    Returns
    -------
    ndarray of float32, shape (columns, stop - start)
        Nulls are NaN.
    """
    metadata = file.metadata
    groups, first, row = [], 0, 0
    for group in range(metadata.num_row_groups):
        rows = metadata.row_group(group).num_rows
        if row + rows > start and row < stop:
            if not groups:
                first = row
            groups.append(group)
        row += rows
    start, stop = min(start, row), min(stop, row)
    result = np.empty((len(columns), max(0, stop - start)), dtype=np.float32)
    if not groups or stop <= start:
        return result
    table = file.read_row_groups(groups, columns=list(columns), use_threads=False)
    for into, name in zip(result, columns, strict=True):
        into[:] = table[name].slice(start - first, stop - start).to_numpy()
    return result


def column_descriptions(schema: Any) -> list[dict[str, str]]:
    """Return name, unit and meaning of every column but ``tick`` and ``time``."""
    return [
        {"name": field.name, "unit": _text(field, b"unit"), "meaning": _text(field, b"meaning")}
        for field in schema
        if field.name not in {"tick", "time"}
    ]


def _text(field: Any, key: bytes) -> str:
    return (field.metadata or {}).get(key, b"").decode()
