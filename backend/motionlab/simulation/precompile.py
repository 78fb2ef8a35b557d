"""Compile everything but drives ahead of its first use, for later processes to find.

``python -m motionlab.simulation.precompile``: what a first simulation and a path need, the kernels
of batches, then those with tables, of time-optimal profiles and linearised loops, and the rest.
"""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Mapping
from importlib.util import find_spec
from pathlib import Path

from motionlab.config.drawn_path import DrawnPath
from motionlab.config.load import epochs, load_scenario
from motionlab.kernel.law_calls import all_laws
from motionlab.lanes import WIDE
from motionlab.lanes.compiler.cache import cache_folder
from motionlab.loop.family import LoopFamily
from motionlab.motor_design.fem.compute import compute
from motionlab.motor_design.fem.geometry import Geometry
from motionlab.simulation.batch import run_prepared
from motionlab.simulation.prepare import limit_sets, prepare
from motionlab.simulation.result import document
from motionlab.simulation.run import run
from motionlab.telemetry.expressions import evaluate
from motionlab.timing import CONTROL_PERIOD
from motionlab.trajectories.spline import outline
from motionlab.trajectories.trajectory_check import examine

_PATH = {"kind": "path", "points": [[0.0, 0.0], [0.01, 0.0], [0.01, 0.01]]}
_LAP = _PATH | {"closed": True, "lap_time": 2.0}
_TIME_OPTIMAL = _PATH | {"law": "time_optimal", "v_max": 0.1, "a_max": 1.0, "j_max": 20.0}
_GEOMETRIES = "polyline", "spline"


def mark() -> Path:
    """Return the file that is there once the kernels of batches have been compiled."""
    return cache_folder() / "batches"


def first_use() -> None:
    """Compile, or load, what a first simulation, its loop and the check of a path need."""
    changes = {"trajectory": {"kind": "point", "duration": CONTROL_PERIOD}}
    prepared = prepare(load_scenario("circle", changes))
    document(prepared, run(prepared))
    family = LoopFamily.of(prepared.scenario, "A", "x")
    family.limits(1.0, 1.0)
    family.figures(1.0, 1.0)
    for geometry in _GEOMETRIES:
        _check(_LAP | {"geometry": geometry})
    _check(_TIME_OPTIMAL | {"geometry": "spline"})


def rare_use() -> None:
    """Compile, or load, math channels with memory and, where scikit-fem is, finite elements."""
    evaluate.warm_up()
    if find_spec("skfem") is not None:  # it comes with the extra lab
        compute(Geometry(), "preview")


def _check(path: Mapping[str, object]) -> None:
    scenario = prepare(load_scenario("circle", {"trajectory": path})).scenario
    examine(scenario.trajectory, limit_sets(epochs(scenario)), bins=10)
    if isinstance(drawn := scenario.trajectory, DrawnPath):
        outline(drawn.points, closed=drawn.closed, corners=drawn.corners)


def main() -> int:
    """Compile what is missing at low priority."""
    with contextlib.suppress(OSError):
        os.nice(10)
    first_use()
    all_laws()
    _compile_batches()
    for geometry in _GEOMETRIES:
        prepare(load_scenario("circle", {"trajectory": _TIME_OPTIMAL | {"geometry": geometry}}))
    rare_use()
    return 0


def _compile_batches() -> None:
    # Two ticks: arrays of one are contiguous whatever their strides, for which other code is made.
    point = {"trajectory": {"kind": "point", "duration": 2 * CONTROL_PERIOD}}
    for force_map in ({}, {"plant.force_map": "new-design"}):
        prepared = prepare(load_scenario("circle", point | force_map))
        run(prepared)
        run_prepared([prepared])
        run_prepared([prepared] * WIDE, threads=1)
        with contextlib.suppress(OSError):
            mark().touch()


if __name__ == "__main__":
    sys.exit(main())
