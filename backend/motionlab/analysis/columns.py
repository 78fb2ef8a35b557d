"""Whole columns of telemetry on an equidistant grid."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from motionlab.analysis.alignment import Grid
from motionlab.config.planar import AXES
from motionlab.errors import ConfigError, FieldError, StoreError
from motionlab.telemetry.parquet import read_ticks
from motionlab.telemetry.recorder import Column, read
from motionlab.timing import CONTROL_PERIOD

if TYPE_CHECKING:
    from pyarrow import parquet

_FLOAT = np.dtype(np.float32).itemsize
_VARIANT = re.compile(r"([A-Z])(?=\.[xy]\.)")


class Columns:
    """Columns of one run; threads may read some each.

    Parameters
    ----------
    name : str
        What the run is called: its identifier, or its file.
    open_file : callable
        Opens its Parquet file.

    Attributes
    ----------
    grid : Grid
        Its samples; a tick that was not recorded is missing.
    units : dict of str to str
        Of each channel, in the order of the file.
    counts : dict of str to float
        What the encoder of each axis resolves, m; empty where the file does not say.

    Raises
    ------
    StoreError
        If it cannot be read, or has no ``tick`` or ``time``.
    """

    counts: Mapping[str, float] = MappingProxyType({})

    def __init__(self, name: str, open_file: Callable[[], parquet.ParquetFile]) -> None:
        import pyarrow as pa

        self.name = name
        self._open = open_file
        self._places: NDArray[np.int64] | None = None
        with open_file() as file:
            schema = file.schema_arrow
            if {"tick", "time"} - set(schema.names):
                raise StoreError(f"{name} is no telemetry: it has no columns tick and time")
            self.units = {
                field.name: (field.metadata or {}).get(b"unit", b"").decode()
                for field in schema
                if pa.types.is_floating(field.type) and field.name != "time"
            }
            self.counts = _counts((schema.metadata or {}).get(b"scenario", b""))
            self._rows = file.metadata.num_rows
            self.grid = self._grid(file)

    def read(self, names: Sequence[str]) -> NDArray[np.float32]:
        """Return some columns, shape (columns, ticks); missing samples are NaN."""
        with self._open() as file:
            samples = read_ticks(file, names, 0, self._rows)
        if self._places is None:
            return samples
        columns = np.full((len(names), self.grid.ticks), np.nan, dtype=np.float32)
        columns[:, self._places] = samples
        return columns

    @property
    def variants(self) -> list[str]:
        """Letters of the variants that have channels."""
        return sorted({match[1] for name in self.units if (match := _VARIANT.match(name))})

    def size(self, columns: int) -> int:
        """Return the memory that reading so many columns takes, bytes."""
        read_twice = 2  # as Arrow has it, and as an array
        return read_twice * columns * self.grid.ticks * _FLOAT

    def _grid(self, file: parquet.ParquetFile) -> Grid:
        if self._rows == 0:
            return Grid(0.0, CONTROL_PERIOD, 0)
        (begin, start), (end, stop) = (
            (int(ends["tick"][0].as_py()), float(ends["time"][0].as_py()))
            for ends in (
                file.read_row_group(group, columns=["tick", "time"]).slice(row, 1)
                for group, row in _ends(file)
            )
        )
        ticks = end - begin + 1
        period = (stop - start) / (ticks - 1) if ticks > 1 else CONTROL_PERIOD
        self._check(ticks >= self._rows and period > 0.0)
        if ticks != self._rows:
            places = file.read(columns=["tick"])["tick"].to_numpy() - begin
            self._check(bool((np.diff(places) > 0).all()))
            self._places = places
        return Grid(start, period, ticks)

    def _check(self, ordered: bool) -> None:
        if not ordered:
            raise StoreError(f"{self.name} is no telemetry: its ticks or times do not grow")


class TableColumns(Columns):
    """Columns of a CSV file, which is read as a whole."""

    def __init__(self, path: str) -> None:
        self._table = read(path)
        if {"tick", "time"} - set(self._table):
            raise StoreError(f"{path} is no telemetry: it has no columns tick and time")
        self.name = path
        self.units = {
            name: column.unit
            for name, column in self._table.items()
            if name not in {"tick", "time"}
        }
        ticks, times = self._table["tick"].values, self._table["time"].values
        self._check(bool((np.diff(ticks) == 1).all()))
        period = (times[-1] - times[0]) / (len(times) - 1) if len(times) > 1 else CONTROL_PERIOD
        self.grid = Grid(float(times[0]) if len(times) else 0.0, float(period), len(ticks))

    def read(self, names: Sequence[str]) -> NDArray[np.float32]:
        """Return some columns, shape (columns, ticks)."""
        columns: list[Column] = [self._table[name] for name in names]
        return np.stack([column.values for column in columns])


class _Renamed(Columns):
    """Columns of a run with other letters of its variants."""

    def __init__(self, run: Columns, letters: Mapping[str, str]) -> None:
        self.name, self.grid, self.counts = run.name, run.grid, run.counts
        self._run = run
        self._own = {_VARIANT.sub(lambda m: letters.get(m[1], m[1]), n, 1): n for n in run.units}
        self.units = {name: run.units[own] for name, own in self._own.items()}

    def read(self, names: Sequence[str]) -> NDArray[np.float32]:
        return self._run.read([self._own[name] for name in names])

    def size(self, columns: int) -> int:
        return self._run.size(columns)


def renamed(candidate: Columns, baseline: Columns, letters: Mapping[str, str]) -> Columns:
    """Return the candidate with variants named as those of the baseline that they stand for.

    Parameters
    ----------
    candidate, baseline : Columns
        Two runs that are compared.
    letters : mapping of str to str
        Of variants of the candidate, the letter of one of the baseline. What is not named keeps its
        letter.

    Raises
    ------
    ConfigError
        If a run has no such variant, or two variants would have one letter.
    """
    if not letters:
        return candidate
    wrong: list[FieldError] = []
    kept = set(candidate.variants) - set(letters)
    taken: set[str] = set()
    for letter, target in letters.items():
        loc = f"variants.{letter}"
        if letter not in candidate.variants:
            allowed = ", ".join(candidate.variants) or "none: it has no variants"
            wrong.append(FieldError(loc, "is no variant of the candidate", letter, allowed))
        if target not in baseline.variants:
            allowed = ", ".join(baseline.variants) or "none: it has no variants"
            wrong.append(FieldError(loc, "is no variant of the baseline", target, allowed))
        elif target in kept | taken:
            free = sorted(set(baseline.variants) - kept - taken)
            allowed = ", ".join(free) or "none: all are taken"
            message = f"another variant of the candidate is {target} already"
            wrong.append(FieldError(loc, message, target, allowed))
        taken.add(target)
    if wrong:
        raise ConfigError(*wrong)
    return _Renamed(candidate, letters)


def _counts(scenario: bytes) -> dict[str, float]:
    """Return what the encoders of the plant of a scenario resolve, by axis, m."""
    try:
        plant = json.loads(scenario)["plant"]
        return {axis: float(plant[axis]["encoder"]["resolution"]) for axis in AXES}
    except (ValueError, KeyError, TypeError):  # no scenario, or a plant by name
        return {}


def _ends(file: parquet.ParquetFile) -> tuple[tuple[int, int], tuple[int, int]]:
    """Return row group and row of the first and of the last sample."""
    groups = [g for g in range(file.num_row_groups) if file.metadata.row_group(g).num_rows]
    return (groups[0], 0), (groups[-1], file.metadata.row_group(groups[-1]).num_rows - 1)
