"""Ten thousand runs of 3 s: threads, worker processes, and a Dask cluster on loopback."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

from motionlab.executors.executor import executing
from motionlab.studies.table import BY_KIND
from tests.bench.table import Row
from tests.dask_cluster import cluster

_CASES = 5000  # of two variants each
_WORKERS = 2
_THREE_SECONDS = {"trajectory.frequency": 1.0, "trajectory.laps": 2, "trajectory.lead_in": 1.0}
_TURNS = 2
_MORE = 1.15


def on_cluster() -> Iterator[Row]:
    """Measure a Monte Carlo study on each executor in turns, workers running already."""
    study = BY_KIND["monte-carlo"]
    plan = study.plan({"cases": _CASES, "set": _THREE_SECONDS})
    few = study.plan({"cases": 8 * _WORKERS, "set": _THREE_SECONDS})
    best: dict[str, float] = {}
    with tempfile.TemporaryDirectory() as folder, ExitStack() as stack:
        lab = stack.enter_context(cluster(_WORKERS, folder=Path(folder)))
        for _ in range(_TURNS):
            for scheduler in ("threads", f"processes:{_WORKERS}", lab.address):
                with executing(scheduler):
                    study.run(few, lambda *_: None)
                    before = time.perf_counter()
                    study.run(plan, lambda *_: None)
                    taken = time.perf_counter() - before
                name = scheduler.partition(":")[0]
                best[name] = min(taken, best.get(name, taken))
    runs = 2 * _CASES
    threads, processes, dask = best["threads"], best["processes"], best["tcp"]
    yield Row(
        f"{runs} runs of 3 s, {_WORKERS} worker processes",
        "",
        f"{processes:.1f} s",
        f"threads: {threads:.1f} s",
        f"{processes / threads:.2f}",
    )
    yield Row(
        f"{runs} runs of 3 s, Dask, {_WORKERS} workers on loopback",
        f"<= {_MORE:g} x processes",
        f"{dask:.1f} s",
        f"processes: {processes:.1f} s",
        f"{dask / processes:.2f}",
        dask / processes <= _MORE,
    )
