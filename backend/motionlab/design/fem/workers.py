"""Fields at many positions: here, or by worker processes that can be cancelled."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing.synchronize import Event
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.design.fem.field import FieldModel
from motionlab.design.fem.geometry import Geometry
from motionlab.design.fem.mesh import Resolution
from motionlab.errors import MotionLabError

_WORKERS_MOST = 4
_POLL = 0.1  # s between looks at whether the work was cancelled

Array = NDArray[np.float64]
Progress = Callable[[float], None]


class WorkerLost(MotionLabError):
    """A worker process that ended before its work, for want of memory as a rule."""


class Work(NamedTuple):
    """Fields to find: every current at every position."""

    geometry: Geometry
    resolution: Resolution
    currents: Array  # A, the first is 0
    shifts: list[int]  # of the mesh, in cells


def fields(work: Work, *, workers: int | None, progress: Progress | None) -> list[Array]:
    """Return co-energy, flux linkage, thrust and normal force of every field.

    Parameters
    ----------
    work : Work
        What to find.
    workers : int or None
        Processes; None for as many as there are cores, four at most. One computes here.
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
    count = min(workers or len(os.sched_getaffinity(0)), _WORKERS_MOST, len(work.shifts))
    if count > 1:
        return _spread(work, count, progress)
    model, found = FieldModel(work.geometry, work.resolution), []
    for shift in work.shifts:
        if progress:
            progress(len(found) / len(work.shifts))
        found.append(_position(model, shift, work.currents))
    return found


def _position(
    model: FieldModel, shift: int, currents: Array, stopped: Callable[[], bool] | None = None
) -> Array:
    """Return co-energy, linkage, thrust and normal force at one position for every current."""
    position = model.at(shift)
    found = np.zeros((len(currents), 4))
    for k, current in enumerate(currents[1:], start=1):
        if stopped and stopped():
            break
        found[k] = position.solve(float(current))
    return found


def _spread(work: Work, workers: int, progress: Progress | None) -> list[Array]:
    """Return the same from worker processes, a position at a time."""
    context = multiprocessing.get_context("spawn")
    stop = context.Event()
    pool = ProcessPoolExecutor(workers, context, initializer=_start_worker, initargs=(work, stop))
    try:
        with _one_thread_each():
            futures = [pool.submit(_found, shift) for shift in work.shifts]
        _await(futures, progress)
        return [future.result() for future in futures]
    except BrokenProcessPool:
        raise WorkerLost("a worker process was killed; is there enough memory?") from None
    finally:
        stop.set()
        pool.shutdown(wait=True, cancel_futures=True)


def _await(futures: list[Future[Array]], progress: Progress | None) -> None:
    waiting = set(futures)
    while waiting:
        done, waiting = wait(waiting, timeout=_POLL, return_when=FIRST_COMPLETED)
        for future in done:
            future.result()
        if progress:
            progress(1 - len(waiting) / len(futures))


@contextmanager
def _one_thread_each() -> Iterator[None]:
    """Let processes that start here use one thread each for linear algebra."""
    names = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
    before = {name: os.environ.get(name) for name in names}
    os.environ.update(dict.fromkeys(names, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


class _Worker:
    """State of a worker process: one model."""

    model: FieldModel
    currents: Array
    stop: Event


def _start_worker(work: Work, stop: Event) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # an interrupt is the parent's to handle
    threading.Thread(target=_end_with_parent, daemon=True).start()
    _Worker.model = FieldModel(work.geometry, work.resolution)
    _Worker.currents, _Worker.stop = work.currents, stop


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _found(shift: int) -> Array:
    return _position(_Worker.model, shift, _Worker.currents, _Worker.stop.is_set)
