"""Comparison of two runs of 240 s, every channel."""

from __future__ import annotations

import statistics
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from motionlab.config.load import load_scenario
from motionlab.runs.columns import of_file_or_run
from motionlab.runs.compare import Comparing, Tolerance, compare
from motionlab.simulation.prepare import prepare
from motionlab.simulation.result import metadata
from motionlab.simulation.run import run
from motionlab.telemetry.recorder import write
from tests.bench.table import Row

_LAPS = 80  # of 3 s
_REPETITIONS = 5
_TARGET = 1.0  # s
_HOWS: dict[str, Comparing] = {
    "by time": Comparing(),
    "by time, 5 ms of tolerance": Comparing(tolerance=Tolerance(absolute=1e-6, time=0.005)),
    "by reference": Comparing(align="reference"),
}


def runs_compare() -> Iterator[Row]:
    """Measure comparisons of files with one gain changed; columns are read each time."""
    with tempfile.TemporaryDirectory() as folder:
        changes: list[dict[str, Any]] = [{}, {"variants.B.controller.x.k_p": 210_000.0}]
        files = [_written(Path(folder) / f"{i}.parquet", some) for i, some in enumerate(changes)]
        for what, how in _HOWS.items():
            times, spent, count = [], [], 0
            for _ in range(_REPETITIONS + 1):
                wall, processor = time.perf_counter(), time.process_time()
                baseline, candidate = map(of_file_or_run, files)
                count = len(compare(baseline, candidate, how).channels)
                times.append(time.perf_counter() - wall)
                spent.append(time.process_time() - processor)
            taken = statistics.median(times[1:])
            yield Row(
                f"compare two 240 s runs, {count} channels, {what}",
                f"< {_TARGET:g} s",
                f"{taken:.2f} s",
                f"{statistics.median(spent[1:]):.2f} s of processor",
                "",
                taken < _TARGET if what == "by time" else None,
            )


def _written(path: Path, changes: dict[str, Any]) -> str:
    prepared = prepare(load_scenario("circle", {"trajectory.laps": _LAPS} | changes))
    write(run(prepared), str(path), metadata=metadata(prepared.scenario))
    return str(path)
