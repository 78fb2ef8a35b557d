"""Telemetry of runs read back: as a recording, as arrays, as minima and maxima for a plot."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.errors import ConfigError, FieldError
from motionlab.runs.files import read_ticks
from motionlab.telemetry.channels import stream_columns
from motionlab.telemetry.decimate import min_max
from motionlab.telemetry.recording import Recording, as_recording

if TYPE_CHECKING:
    from pyarrow import parquet


class Window(NamedTuple):
    """Minima and maxima over equal bins of samples.

    Attributes
    ----------
    first : int
        Sample at which the first bin begins, counted from the first that is recorded.
    bin : int
        Samples in a bin; the last may hold fewer.
    low, high : ndarray of float32, shape (columns, bins)
        NaN where a sample of the bin is missing.
    """

    first: int
    bin: int
    low: NDArray[np.float32]
    high: NDArray[np.float32]


def check_columns(file: parquet.ParquetFile, columns: Sequence[str]) -> None:
    """Refuse columns that are not there or come twice.

    Raises
    ------
    ConfigError
        Naming each.
    """
    known = set(file.schema_arrow.names) - {"tick", "time"}
    wrong = [
        FieldError(f"columns.{i}", "no column of that name", name)
        for i, name in enumerate(columns)
        if name not in known
    ]
    wrong += [
        FieldError(f"columns.{i}", "comes twice", name)
        for i, name in enumerate(columns)
        if name in columns[:i]
    ]
    if wrong:
        raise ConfigError(*wrong)


def window(
    file: parquet.ParquetFile, columns: Sequence[str], start: int, stop: int, points: int
) -> Window:
    """Return samples [start, stop) of some columns in at most `points` bins.

    No spike is lost: a bin shows its least and its largest sample.
    """
    samples = read_ticks(file, columns, start, stop)
    low, high = min_max(samples, points)
    return Window(start, max(1, -(-samples.shape[1] // points)), low, high)


def recording(
    file: parquet.ParquetFile, variants: Sequence[str], start: int, stop: int
) -> Recording:
    """Return samples [start, stop) as a recording; references are float32, as they are kept."""
    columns = [name for name, _ in stream_columns(variants)]
    samples = read_ticks(file, columns, start, stop)
    rows = {name: row for row, name in enumerate(columns)}
    failed: dict[str, int | None] = {}
    first = int(file.read_row_group(0, columns=["tick"])["tick"][0].as_py()) + start
    recorded = ~np.isnan(samples[0])  # what is missing for all is a gap of the recording
    for name in variants:  # the command is there also where drives measure nothing
        missing = np.flatnonzero(np.isnan(samples[rows[f"{name}.x.force_command"]]) & recorded)
        failed[name] = first + int(missing[0]) if missing.size else None
    return as_recording(first, samples, failed)
