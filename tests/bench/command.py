"""Time of the whole command, and of the simulation in it."""

from __future__ import annotations

import statistics
import subprocess
import sys
import time
from collections.abc import Iterator

from tests.bench.speed import simulation_time
from tests.bench.table import Row

_REPETITIONS = 7
_WHOLE, _SIMULATION = 2.0, 0.05  # s
_COMMAND = (sys.executable, "-m", "motionlab", "run", "circle", "--json")


def command() -> Iterator[Row]:
    """Time ``motionlab run circle --json`` as a process; the first, cold run is not counted."""
    times = []
    for _ in range(_REPETITIONS + 1):
        before = time.perf_counter()
        subprocess.run(_COMMAND, check=True, stdout=subprocess.DEVNULL)
        times.append(time.perf_counter() - before)
    whole = statistics.median(times[1:])
    yield Row(
        "motionlab run circle --json, whole process",
        f"<= {_WHOLE:g} s",
        f"{whole:.2f} s",
        "warm cache",
        "",
        whole <= _WHOLE,
    )
    simulation = simulation_time()
    yield Row(
        "  of which simulation",
        f"<= {_SIMULATION * 1e3:g} ms",
        f"{simulation * 1e3:.1f} ms",
        "run() in this process",
        "",
        simulation <= _SIMULATION,
    )
