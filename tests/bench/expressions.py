"""Math channels of a run of 240 s, beside a recorded channel of it."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

from pyarrow import parquet

from motionlab.library.telemetry import check_columns, read_columns
from motionlab.telemetry import recorder
from motionlab.telemetry.decimate import extremes
from motionlab.timing import CONTROL_PERIOD
from tests.bench.table import Row
from tests.recordings import noise

_TICKS, _SECOND = 480_000, 2000
_POINTS = 2000
_MOST = 0.1  # s
_REPETITIONS = 5
_CHANNEL = "B.x.following_error"
_MATH = (
    "=hypot(B.x.following_error, B.y.following_error)",
    "=derivative(B.x.position)",
    "=lowpass(B.x.thrust * B.x.velocity, 50)",
    "=integral(hypot(B.x.current_a, B.x.current_b) ** 2)",
    "=mean(abs(B.x.thrust), 0.1)",
)


def expressions() -> Iterator[Row]:
    """Time the whole of a run, and its last second, from the question to minima and maxima."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.parquet"
        recorder.write(noise(_TICKS), str(path), metadata={})
        with parquet.ParquetFile(path) as file:
            reference = [_best(file, _CHANNEL, first) for first in (0, _TICKS - _SECOND)]
            for column in _MATH:
                for place, first in enumerate((0, _TICKS - _SECOND)):
                    taken, channel = _best(file, column, first), reference[place]
                    yield Row(
                        f"{column[1:30]}, {('240 s', 'last 1 s')[place]}",
                        f"< {1e3 * _MOST:g} ms",
                        f"{1e3 * taken:.1f} ms",
                        f"channel {1e3 * channel:.1f} ms",
                        f"{taken / channel:.1f}",
                        taken < _MOST,
                    )


def _best(file: parquet.ParquetFile, column: str, first: int) -> float:
    times = []
    for _ in range(_REPETITIONS):
        before = time.perf_counter()
        math = check_columns(file, [column], CONTROL_PERIOD)
        samples = read_columns(file, [column], math, first, _TICKS)
        extremes(samples, -(-samples.shape[1] // _POINTS))
        times.append(time.perf_counter() - before)
    return min(times)
