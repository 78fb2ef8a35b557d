"""Telemetry of runs read back as a recording."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from motionlab.errors import ConfigError, FieldError
from motionlab.runs.files import read_ticks
from motionlab.telemetry.channels import stream_columns
from motionlab.telemetry.recording import Recording, as_recording

if TYPE_CHECKING:
    from pyarrow import parquet


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
