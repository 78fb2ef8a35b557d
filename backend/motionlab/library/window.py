"""Curves of a run for a plot: minima and maxima over equal bins, from a pyramid in memory."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.library.files import RunFiles
from motionlab.library.telemetry import check_columns, read_columns
from motionlab.telemetry.decimate import extremes
from motionlab.telemetry.expressions.columns import MathChannel
from motionlab.telemetry.parquet import read_ticks
from motionlab.timing import CONTROL_PERIOD

if TYPE_CHECKING:
    from pyarrow import parquet

FACTOR = 16
"""Samples in a bin of the pyramid's lowest level, and bins of a level in one of the next."""
PYRAMIDS_MAX = 32_000_000
"""Most that the pyramids in memory take, bytes; those used longest ago are dropped."""

_LEVELS = (FACTOR, FACTOR * FACTOR)
_PIECE = 65_536  # samples that are read at a time, a multiple of each level


class Grid(NamedTuple):
    """Equal bins of samples, counted from the first that is recorded.

    Attributes
    ----------
    first : int
        Sample at which the first bin begins.
    bin : int
        Samples in a bin.
    stop : int
        Sample after the last; the last bin may hold fewer than `bin`.
    level : int
        Samples in a bin of the level of the pyramid that they are made of; 1 for samples.
    """

    first: int
    bin: int
    stop: int
    level: int

    @property
    def bins(self) -> int:
        """How many bins there are."""
        return -(-(self.stop - self.first) // self.bin)


class Window(NamedTuple):
    """Minima and maxima over equal bins of samples.

    Attributes
    ----------
    grid : Grid
        The bins.
    low, high : ndarray of float32, shape (columns, bins)
        NaN where a sample of the bin is missing.
    """

    grid: Grid
    low: NDArray[np.float32]
    high: NDArray[np.float32]


class Pyramid(NamedTuple):
    """Minima and maxima of a column, level by level.

    Attributes
    ----------
    low, high : tuple of ndarray of float32
        Those of bins of `FACTOR` samples, and of `FACTOR` of these.
    """

    low: tuple[NDArray[np.float32], ...]
    high: tuple[NDArray[np.float32], ...]

    @property
    def size(self) -> int:
        """Memory that it takes, bytes."""
        return sum(level.nbytes for level in self.low + self.high)


class Pyramids:
    """Pyramids of columns of runs, which never change, within a bound of bytes."""

    def __init__(self, most: int = PYRAMIDS_MAX) -> None:
        self._most = most
        self._size = 0
        self._kept: OrderedDict[tuple[str, str], Pyramid] = OrderedDict()

    @property
    def size(self) -> int:
        """Memory that they take, bytes."""
        return self._size

    def get(self, run_id: str, column: str) -> Pyramid | None:
        """Return a pyramid, if it is there, and keep it before others."""
        key = (run_id, column)
        if key in self._kept:
            self._kept.move_to_end(key)
        return self._kept.get(key)

    def put(self, run_id: str, column: str, pyramid: Pyramid) -> None:
        """Keep a pyramid, in the place of those used longest ago."""
        key = (run_id, column)
        if key in self._kept or pyramid.size > self._most:
            return
        self._kept[key] = pyramid
        self._size += pyramid.size
        while self._size > self._most:
            _, oldest = self._kept.popitem(last=False)
            self._size -= oldest.size

    def clear(self) -> None:
        """Drop all."""
        self._kept.clear()
        self._size = 0


PYRAMIDS = Pyramids()
"""Those of this process."""


def grid(start: int, stop: int, points: int, ticks: int) -> Grid:
    """Return at most `points` bins over samples [start, stop).

    Bins of `FACTOR` samples or more are made of a level of the pyramid: they hold whole bins of it,
    and reach beyond the stretch by less than one of theirs.

    Parameters
    ----------
    start, stop : int
        Samples, 0 <= start < stop <= ticks.
    points : int
        Most bins, at least 1.
    ticks : int
        Samples of the run.
    """
    size = -(-(stop - start) // points)
    if size < FACTOR:
        return Grid(start, size, stop, 1)
    # At least four bins of a level in one of these, so that rounding them up costs few bins.
    level = max((each for each in _LEVELS if 4 * each <= size), default=FACTOR)
    first = start // level * level
    end = min(-(-stop // level) * level, ticks)
    return Grid(first, -(-(end - first) // (points * level)) * level, end, level)


def window(  # noqa: PLR0913 - which columns of which run, and how finely
    files: RunFiles,
    run_id: str,
    columns: Sequence[str],
    grid: Grid,
    pyramids: Pyramids = PYRAMIDS,
    *,
    math: Mapping[str, MathChannel] | None = None,
) -> Window:
    """Return some columns of a run over the bins of a grid.

    No spike is lost: a bin has its least and its largest sample. Columns of `math` are computed.

    Raises
    ------
    ConfigError
        If there is no column of a name, or it comes twice.
    StoreError
        If the telemetry cannot be read.
    """
    column_pyramids = {name: pyramids.get(run_id, name) for name in columns}
    missing = [name for name, pyramid in column_pyramids.items() if pyramid is None]
    if missing or grid.level == 1 or len(column_pyramids) < len(columns):
        with files.open(run_id) as file:
            math = math or {}
            check_columns(file, [name for name in columns if name not in math], CONTROL_PERIOD)
            if grid.level == 1:
                samples = read_columns(file, columns, math, grid.first, grid.stop)
                return Window(grid, *extremes(samples, grid.bin))
            recorded = [name for name in missing if name not in math]
            built = dict(zip(recorded, _built(file, recorded), strict=True))
            for name in missing:
                column_pyramids[name] = pyramid = built.get(name) or _computed(file, math[name])
                pyramids.put(run_id, name, pyramid)
    low, high = np.empty((2, len(columns), grid.bins), dtype=np.float32)
    level, per_bin = _LEVELS.index(grid.level), grid.bin // grid.level
    part = slice(grid.first // grid.level, -(-grid.stop // grid.level))
    for row, pyramid in enumerate(column_pyramids.values()):
        assert pyramid is not None
        low[row] = extremes(pyramid.low[level][None, part], per_bin)[0]
        high[row] = extremes(pyramid.high[level][None, part], per_bin)[1]
    return Window(grid, low, high)


def _computed(file: parquet.ParquetFile, math: MathChannel) -> Pyramid:
    """Compute a whole math channel, and return its pyramid."""
    samples = read_columns(file, [math.text], {math.text: math}, 0, file.metadata.num_rows)
    low, high = extremes(samples, FACTOR)
    upper = extremes(low, FACTOR)[0], extremes(high, FACTOR)[1]
    return Pyramid((low[0], upper[0][0]), (high[0], upper[1][0]))


def _built(file: parquet.ParquetFile, columns: Sequence[str]) -> list[Pyramid]:
    """Read whole columns, some samples at a time, and return their pyramids."""
    ticks = file.metadata.num_rows
    low, high = np.empty((2, len(columns), -(-ticks // FACTOR)), dtype=np.float32)
    for start in range(0, ticks, _PIECE):
        samples = read_ticks(file, columns, start, min(start + _PIECE, ticks))
        into = slice(start // FACTOR, start // FACTOR + -(-samples.shape[1] // FACTOR))
        low[:, into], high[:, into] = extremes(samples, FACTOR)
    upper_low, _ = extremes(low, FACTOR)
    _, upper_high = extremes(high, FACTOR)
    # Copies, so that dropping one column frees it.
    return [
        Pyramid((low[i].copy(), upper_low[i].copy()), (high[i].copy(), upper_high[i].copy()))
        for i in range(len(columns))
    ]
