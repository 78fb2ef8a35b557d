"""Compile the kernels that a first simulation does not need, for later processes to find.

``python -m motionlab.simulation.precompile``: those of batches, then those with tables, then those
of time-optimal profiles and of linearised loops.
"""

from __future__ import annotations

import contextlib
import os
import sys
from pathlib import Path

from numba import float64

from motionlab.config.load import load_scenario
from motionlab.config.planar import AXES
from motionlab.config.timing import CONTROL_PERIOD
from motionlab.kernel.build import lane
from motionlab.kernel.force_maps import force_gain
from motionlab.kernel.tick import control_once
from motionlab.lanes import WIDE
from motionlab.lanes.compile_cache import cache_folder
from motionlab.simulation.batch import run_prepared
from motionlab.simulation.prepare import prepare
from motionlab.simulation.run import run

_TIME_OPTIMAL = {
    "kind": "path",
    "points": [[0.0, 0.0], [0.01, 0.0], [0.01, 0.01]],
    "law": "time_optimal",
    "v_max": 0.1,
    "a_max": 1.0,
    "j_max": 20.0,
}


def mark() -> Path:
    """Return the file that is there once the kernels of batches have been compiled."""
    return cache_folder() / "batches"


def main() -> int:
    """Compile missing kernels at low priority."""
    with contextlib.suppress(OSError):
        os.nice(10)
    # Two ticks: arrays of one are contiguous whatever their strides, for which other code is made.
    point = {"trajectory": {"kind": "point", "duration": 2 * CONTROL_PERIOD}}
    for force_map in ({}, {"plant.force_map": "new-design"}):
        prepared = prepare(load_scenario("circle", point | force_map))
        run(prepared)
        run_prepared([prepared])
        run_prepared([prepared] * WIDE, threads=1)
        with contextlib.suppress(OSError):
            mark().touch()
        variant = next(iter(prepared.scenario.variants.values()))
        force_gain(lane(prepared.scenario, variant.controller, AXES[0]), 1.0)
    for geometry in ("polyline", "spline"):
        prepare(load_scenario("circle", {"trajectory": _TIME_OPTIMAL | {"geometry": geometry}}))
    table = float64[:, ::1]
    control_once.compile((table, table, float64[:, :, ::1], table))
    return 0


if __name__ == "__main__":
    sys.exit(main())
