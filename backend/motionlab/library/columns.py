"""Columns of a kept run, or of a telemetry file, for comparisons."""

from __future__ import annotations

import dataclasses
from pathlib import Path

from motionlab.analysis.columns import Columns, TableColumns
from motionlab.errors import ConfigError, StoreError
from motionlab.library.library import library
from motionlab.library.run import is_id
from motionlab.telemetry.recorder import SUFFIXES


def of_run(run_id: str) -> Columns:
    """Return the columns of a kept run.

    Raises
    ------
    Unknown
        If there is none of that identifier.
    Busy
        If it is still being recorded.
    """
    kept = library()
    kept.complete(run_id)
    return Columns(run_id, lambda: kept.files.open(run_id))


def of_file_or_run(name: str) -> Columns:
    """Return the columns of a kept run by identifier or name, or those of a telemetry file.

    Raises
    ------
    ConfigError
        If it is neither.
    StoreError
        If it cannot be read.
    """
    if is_id(name):
        return of_run(name)
    if not name.endswith(SUFFIXES):
        try:
            return of_run(library().named(name, "run"))
        except ConfigError as error:
            (wrong,) = error.errors
            files = f"{wrong.range}; or a file that ends in {' or '.join(SUFFIXES)}"
            raise ConfigError(dataclasses.replace(wrong, range=files)) from None
    if name.endswith(".csv"):
        return TableColumns(name)

    import pyarrow as pa
    from pyarrow import parquet

    def opened() -> parquet.ParquetFile:
        try:
            return parquet.ParquetFile(Path(name))
        except (OSError, pa.ArrowInvalid) as error:
            raise StoreError(f"{name} cannot be read: {error}") from error

    return Columns(name, opened)
