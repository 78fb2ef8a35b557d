"""Fields at many positions, a task each."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.executors.executor import without_lock
from motionlab.motor_design.fem.field import FieldModel
from motionlab.motor_design.fem.geometry import Geometry
from motionlab.motor_design.fem.mesh import Resolution

Array = NDArray[np.float64]
Progress = Callable[[float], None]


class FieldTask(NamedTuple):
    """Fields to find: every current at every position."""

    geometry: Geometry
    resolution: Resolution
    currents: Array  # A, the first is 0
    shifts: list[int]  # of the mesh, in cells


def fields(work: FieldTask, *, workers: int | None, progress: Progress | None) -> list[Array]:
    """Return co-energy, flux linkage, thrust and normal force of every field.

    Parameters
    ----------
    work : FieldTask
        What to find.
    workers : int or None
        Processes; None for the executor of the study. One computes here.
    progress : callable or None
        Called with the share that is done. What it raises cancels the work and is passed on.

    Returns
    -------
    list of array, shape (currents, 4)
        One for each position; J, Wb, N, N.

    Raises
    ------
    NoConvergence
        If a field is not found.
    WorkerLost
        If a worker process was killed.
    """
    tasks = [work._replace(shifts=[shift]) for shift in work.shifts]
    with without_lock(workers) as executor:
        return list(executor.map(_position, tasks, progress))


def _position(work: FieldTask, progress: Progress) -> Array:
    """Return co-energy, linkage, thrust and normal force at one position for every current."""
    (shift,) = work.shifts
    key = work.geometry.model_dump_json(), work.resolution
    if getattr(_latest, "key", None) != key:
        _latest.key, _latest.model = key, FieldModel(work.geometry, work.resolution)
    position = _latest.model.at(shift)
    solutions = np.zeros((len(work.currents), 4))
    for k, current in enumerate(work.currents[1:], start=1):
        progress(k / len(work.currents))
        solutions[k] = position.solve(float(current))
    return solutions


_latest = threading.local()
"""The model of a thread's latest task: the next one most likely has the same."""
