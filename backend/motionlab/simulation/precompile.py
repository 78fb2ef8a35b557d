"""Compile everything but drives ahead of its first use, for later processes to find.

``python -m motionlab.simulation.precompile``: what a first simulation, its loop and a path need,
the kernels of batches, then those with tables, of time-optimal profiles, and the rest. It prints
each step that is done, after the share of all work, 0 to 1.
"""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Callable, Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

import numba

from motionlab.config.drawn_path import DrawnPath
from motionlab.config.load import epochs, load_scenario
from motionlab.force_sharing.pole_pitch import share_over
from motionlab.kernel.force_maps import force_model
from motionlab.kernel.law_calls import all_laws
from motionlab.lanes import WIDE
from motionlab.lanes.compiler.cache import cache_folder
from motionlab.loop.family import LoopFamily
from motionlab.motor_design.fem.compute import compute
from motionlab.motor_design.fem.geometry import Geometry
from motionlab.simulation.batch import run_prepared
from motionlab.simulation.prepare import Prepared, limit_sets, prepare
from motionlab.simulation.result import document
from motionlab.simulation.run import run
from motionlab.telemetry.expressions import evaluate
from motionlab.timing import CONTROL_PERIOD
from motionlab.trajectories.spline import outline
from motionlab.trajectories.trajectory_check import examine

_numba: Any = numba  # whose types do not name all that it exports

_PATH = {"kind": "path", "points": [[0.0, 0.0], [0.01, 0.0], [0.01, 0.01]]}
_LAP = _PATH | {"closed": True, "lap_time": 2.0}
_TIME_OPTIMAL = _PATH | {"law": "time_optimal", "v_max": 0.1, "a_max": 1.0, "j_max": 20.0}
_GEOMETRIES = "polyline", "spline"


class Step(NamedTuple):
    """What is compiled together."""

    name: str
    compile: Callable[[], None]
    seconds: float  # about: processor time, for shares of the work


def mark() -> Path:
    """Return the file that is there once the kernels of batches have been compiled."""
    return cache_folder() / "batches"


def batches_compiled() -> bool:
    """Return whether the kernels of batches are compiled, or numba is to compile nothing."""
    return _numba.config.DISABLE_JIT or mark().exists()


def first_use(done: Callable[[float], None] = lambda _: None) -> None:
    """Compile, or load, what a first simulation, its loop and the check of a path need.

    Parameters
    ----------
    done : callable, optional
        Takes the share that is done, 0 to 1, after each step.
    """
    _take((_KERNEL, *_FIRST), lambda share, _: done(share))


def rare_use() -> None:
    """Compile, or load, math channels with memory, sharing over positions, finite elements."""
    evaluate.warm_up()
    _share()
    if find_spec("skfem") is not None:  # it comes with the extra lab
        compute(Geometry(), "preview")


def main() -> int:
    """Compile what is missing at low priority."""
    with contextlib.suppress(OSError):
        os.nice(10)
    _take((_KERNEL, _TABLES, *_FIRST, *_MORE), lambda share, name: print(share, name, flush=True))
    return 0


def _take(steps: Sequence[Step], done: Callable[[float, str], None]) -> None:
    if _numba.config.DISABLE_JIT:
        return
    total, taken = sum(step.seconds for step in steps), 0.0
    for step in steps:
        step.compile()
        taken += step.seconds
        done(taken / total, step.name)


def _point(changes: Mapping[str, object] | None = None, ticks: int = 1) -> Prepared:
    point = {"trajectory": {"kind": "point", "duration": ticks * CONTROL_PERIOD}}
    return prepare(load_scenario("circle", {**point, **(changes or {})}))


def _kernel() -> None:
    prepared = _point()
    document(prepared, run(prepared))


def _tables() -> None:
    run(_point(_MAP))
    all_laws()


def _loops() -> None:
    family = LoopFamily.of(_point().scenario, "A", "x")
    family.limits(1.0, 1.0)
    family.figures(1.0, 1.0)


def _paths() -> None:
    for geometry in _GEOMETRIES:
        _check(_LAP | {"geometry": geometry})


def _time_optimal_spline() -> None:
    _check(_TIME_OPTIMAL | {"geometry": "spline"})


def _share() -> None:
    own = load_scenario("circle").variants["A"].controller
    model = force_model(own.model.x.force_map, own.sharing, own.current_limit)
    share_over(model, position=[0.0], force=1.0)


def _check(path: Mapping[str, object]) -> None:
    scenario = prepare(load_scenario("circle", {"trajectory": path})).scenario
    examine(scenario.trajectory, limit_sets(epochs(scenario)), bins=10)
    if isinstance(drawn := scenario.trajectory, DrawnPath):
        outline(drawn.points, closed=drawn.closed, corners=drawn.corners)


def _batches(changes: Mapping[str, object] | None = None) -> None:
    # Two ticks: arrays of one are contiguous whatever their strides, for which other code is made.
    prepared = _point(changes, ticks=2)
    run_prepared([prepared])
    run_prepared([prepared] * WIDE, threads=1)
    with contextlib.suppress(OSError):
        mark().touch()


def _batches_with_tables() -> None:
    _batches(_MAP)


def _time_optimal_paths() -> None:
    for geometry in _GEOMETRIES:
        prepare(load_scenario("circle", {"trajectory": _TIME_OPTIMAL | {"geometry": geometry}}))


_MAP = {"plant.force_map": "new-design"}

_KERNEL = Step("kernel", _kernel, 8.0)
_TABLES = Step("kernel with tables, laws", _tables, 5.0)
_FIRST = (
    Step("loops", _loops, 18.0),
    Step("paths", _paths, 6.0),
    Step("time-optimal splines", _time_optimal_spline, 14.0),
)
_MORE = (
    Step("batches", _batches, 20.0),
    Step("batches with tables", _batches_with_tables, 23.0),
    Step("time-optimal paths", _time_optimal_paths, 1.0),
    Step("math channels, sharing, finite elements", rare_use, 2.0),
)
LAST_OF_KERNEL = _TABLES.name
"""Step after which nothing compiles the kernel of single runs again."""


if __name__ == "__main__":
    sys.exit(main())
