"""The lab from Python: time to import and to run, and what a live session costs a script."""

from __future__ import annotations

import statistics
import subprocess
import sys
import time
from collections.abc import Iterator

import motionlab
from motionlab.config.load import load_scenario
from motionlab.simulation.prepare import prepare
from motionlab.simulation.run import run
from tests.bench.serving import Serving
from tests.bench.table import Row

_REPETITIONS = 9
_IMPORT, _RUN, _HELP, _SHARE = 0.3, 0.05, 0.25, 0.02  # s, s, s, of a core
_SECONDS = 10.0
_NAMES = ("position", "following_error", "velocity", "friction", "friction_estimate", "thrust")
_CHANNELS = [f"{variant}.{axis}.{name}" for variant in "AB" for axis in "xy" for name in _NAMES]


def scripting() -> Iterator[Row]:
    """Time imports, commands that only tell, a run, and the stream of a session."""
    bare = _process("-c", "pass")
    imported = _process("-c", "import motionlab")
    yield _row("import motionlab, whole process", _IMPORT, imported, "python alone", bare)
    for command in ("--help", "scenarios", "show circle"):
        took = _process("-m", "motionlab", *command.split())
        yield _row(f"motionlab {command}", _HELP, took, "python alone", bare)
    yield from _runs()
    yield _stream()


def _process(*arguments: str) -> float:
    times = []
    for _ in range(_REPETITIONS + 1):
        before = time.perf_counter()
        subprocess.run((sys.executable, *arguments), check=True, stdout=subprocess.DEVNULL)
        times.append(time.perf_counter() - before)
    return statistics.median(times[1:])


def _runs() -> Iterator[Row]:
    """Time `motionlab.run` of the circle beside the simulation inside of it."""
    prepared = prepare(load_scenario("circle"))
    whole, inside = [], []
    for _ in range(_REPETITIONS + 1):
        before = time.perf_counter()
        motionlab.run("circle")
        whole.append(time.perf_counter() - before)
        before = time.perf_counter()
        run(prepared)
        inside.append(time.perf_counter() - before)
    took, of_which = (statistics.median(times[1:]) for times in (whole, inside))
    yield _row('motionlab.run("circle")', _RUN, took, "simulation", of_which)


def _stream() -> Row:
    """Measure the processor of a script that records 24 channels of a session at 2 kHz."""
    with Serving() as server:
        lab = motionlab.Client(server.url)
        with lab.session("circle") as session:
            session.record(*_CHANNELS, seconds=0.5, speed=1.0)
            before, begun = time.process_time(), time.perf_counter()
            session.record(*_CHANNELS, seconds=_SECONDS)
            share = (time.process_time() - before) / (time.perf_counter() - begun)
    bytes_per_second = len(_CHANNELS) * 2000 * 4
    return Row(
        "Client: 24 channels of a session as arrays",
        f"< {_SHARE:.0%} of a core",
        f"{share:.1%}",
        f"{bytes_per_second / 1e3:.0f} kB/s",
        "",
        share < _SHARE,
    )


def _row(what: str, target: float, took: float, reference: str, other: float) -> Row:
    scale, unit = (1e3, "ms") if target < 0.2 else (1.0, "s")
    return Row(
        what,
        f"<= {target * scale:g} {unit}",
        f"{took * scale:.3g} {unit}",
        f"{reference}: {other * scale:.3g} {unit}",
        f"{took / other:.2f}",
        took <= target,
    )
