"""``python -m tests.bench``: every figure beside its target and its reference of the same run."""

from __future__ import annotations

import argparse
import functools
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator

import motionlab  # noqa: F401 - first, as in the command: it decides how numpy is loaded
from tests.bench.accuracy import accuracy
from tests.bench.batch import batch
from tests.bench.cluster import on_cluster
from tests.bench.command import command
from tests.bench.controllers import controllers
from tests.bench.coverage import coverage
from tests.bench.drive import drive
from tests.bench.elsewhere import elsewhere
from tests.bench.expressions import expressions
from tests.bench.gym import gym
from tests.bench.hold import hold
from tests.bench.identify import identify
from tests.bench.instrument import instrument
from tests.bench.laws import laws
from tests.bench.learning import learning
from tests.bench.machine import AVX2_ENVIRONMENT, description, load
from tests.bench.maps import maps
from tests.bench.measured import measured
from tests.bench.minute import minute
from tests.bench.module import module
from tests.bench.page import page
from tests.bench.paths import dragging
from tests.bench.plates import plates
from tests.bench.plots import plots
from tests.bench.response import response
from tests.bench.runs import runs
from tests.bench.runs_index import runs_index
from tests.bench.safe import safe
from tests.bench.scene import scene
from tests.bench.scripting import scripting
from tests.bench.speed import speed
from tests.bench.start import start
from tests.bench.stream import stream
from tests.bench.table import Row, Table
from tests.bench.trajectories import trajectories
from tests.bench.truth import truth
from tests.bench.tuning import tuning

_KERNEL: dict[str, Callable[[str], Iterator[Row]]] = {
    "speed": speed,
    "module": module,
    "batch": batch,
    "accuracy": lambda _: accuracy(),
    "command": lambda _: command(),
    "tuning": tuning,
    "identify": lambda _: identify(),
    "coverage": lambda _: coverage(),
    "measured": lambda _: measured(),
    "controllers": lambda _: controllers(),
    "maps": lambda _: maps(),
    "plates": lambda _: plates(),
    "laws": lambda _: laws(),
    "elsewhere": lambda _: elsewhere(),
    "learning": lambda _: learning(),
    "response": lambda _: response(),
    "minute": lambda _: minute(),
    "safe": lambda _: safe(),
    "truth": lambda _: truth(),
    "instrument": lambda _: instrument(),
    "trajectories": lambda _: trajectories(),
    "cluster": lambda _: on_cluster(),
    "gym": lambda _: gym(),
}
_LAB: dict[str, Callable[[], Iterator[Row]]] = {
    "start": start,
    "scripting": scripting,
    "stream": stream,
    "page": page,
    "dragging": dragging,
    "plots": plots,
    "scene": scene,
    "hold": hold,
    "drive": drive,
    "runs": runs,
    "runs-index": runs_index,
    "expressions": expressions,
}


def main() -> int:
    """Measure and print; return 1 only if something could not be run."""
    parser = argparse.ArgumentParser(prog="python -m tests.bench", description=__doc__)
    parser.add_argument(
        "--target",
        choices=("native", "avx2"),
        default="native",
        help="avx2: compile kernel and C for a processor without AVX-512 (haswell)",
    )
    everything = [*_KERNEL, *_LAB]
    parser.add_argument(
        "names",
        metavar="NAME",
        nargs="*",
        help=f"what to measure, all when left out: {', '.join(everything)}",
    )
    options = parser.parse_args()
    if unknown := [name for name in options.names if name not in everything]:
        parser.error(f"nothing is called {unknown[0]}; there are {', '.join(everything)}")
    avx2 = options.target == "avx2"
    if avx2 and os.environ.get("NUMBA_CPU_NAME") != AVX2_ENVIRONMENT["NUMBA_CPU_NAME"]:
        return _again_for_avx2(options.names)

    wanted = options.names or everything
    arch = "haswell" if avx2 else "native"
    # Else the first server of a run would compile them while it is measured.
    subprocess.run(
        [sys.executable, "-m", "motionlab.simulation.precompile"],
        stdout=subprocess.DEVNULL,
        check=True,
    )
    print(description())
    table = Table()
    for name, kernel in _KERNEL.items():
        if name in wanted:
            table.add(name, functools.partial(kernel, arch))
    for name, lab in _LAB.items():
        if name in wanted:
            table.add(name, lab)
    missed = f"{table.missed} of the targets missed" if table.missed else "every target met"
    print(f"{missed}; load at the end {load()}")
    return 0 if table.complete else 1


def _again_for_avx2(names: list[str]) -> int:
    """Run this again where numba compiles for AVX2, with a cache of its own."""
    with tempfile.TemporaryDirectory() as cache:
        environment = os.environ | AVX2_ENVIRONMENT | {"NUMBA_CACHE_DIR": cache}
        again = (sys.executable, "-m", "tests.bench", "--target", "avx2", *names)
        return subprocess.run(again, env=environment, check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
