"""Tasks in worker processes of this machine."""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import threading
import types
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import CancelledError, Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing.synchronize import Event
from typing import Any

from motionlab.executors.executor import Pool, WorkerLost


class Processes(Pool):
    """Worker processes, which end with this one."""

    def __init__(self, count: int) -> None:
        context = multiprocessing.get_context("spawn")
        self._count = count
        self._stop = context.Event()
        self._shares = context.Array("d", count, lock=False)
        places = context.Value("i", 0)
        self._pool = ProcessPoolExecutor(
            count, context, initializer=_start, initargs=(self._stop, self._shares, places)
        )

    @property
    def workers(self) -> int:
        """Worker processes."""
        return self._count

    def submit(self, function: Callable[..., Any], tasks: Sequence[Any]) -> list[Future[Any]]:
        """Return a future for each task."""
        with _one_thread_each(), _without_main():
            return [self._pool.submit(_carry_out, function, task) for task in tasks]

    def under_way(self) -> float:
        """Return the sum of the shares that are done of tasks which have not ended."""
        return sum(self._shares)

    def result(self, future: Future[Any]) -> Any:
        """Return the result of a future that is done."""
        try:
            return future.result(timeout=0)
        except BrokenProcessPool:
            raise WorkerLost("a worker process was killed; is there enough memory?") from None

    def abandon(self, futures: Sequence[Future[Any]]) -> None:
        """Cancel what has not ended; wait for the workers to notice."""
        begun = [future for future in futures if not future.cancel() and not future.done()]
        if begun:
            self._stop.set()
            for future in begun:
                try:
                    future.exception()
                except CancelledError:
                    continue
            self._stop.clear()

    def close(self) -> None:
        """End the processes."""
        self._stop.set()
        self._pool.shutdown(wait=True, cancel_futures=True)


class _Stopped(Exception):
    """Raised in a task that was cancelled."""


_main_lock = threading.Lock()
_stop: Event | None = None
_shares: Any = None
_place = 0


def _start(stop: Event, shares: Any, places: Any) -> None:
    """Prepare a worker process, whose share is at the next place of `shares`."""
    # What is shared reaches a process only when it starts.
    global _stop, _shares, _place  # noqa: PLW0603
    _stop, _shares = stop, shares
    with places.get_lock():
        _place = places.value % len(shares)
        places.value += 1
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # an interrupt is the parent's to handle
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _carry_out(function: Callable[..., Any], task: Any) -> Any:
    try:
        return function(task, _tell)
    finally:
        _note(0.0)


def _tell(share: float) -> None:
    if _stop is not None and _stop.is_set():
        raise _Stopped
    _note(share)


def _note(share: float) -> None:
    if _shares is not None:
        _shares[_place] = share


@contextmanager
def _without_main() -> Iterator[None]:
    """Let processes that start here not run the caller's script again.

    `multiprocessing` has each import it for functions defined there; tasks are of our modules, and
    a script without ``if __name__ == "__main__"`` would start its studies once more.
    """
    with _main_lock:
        main = sys.modules["__main__"]
        sys.modules["__main__"] = types.ModuleType("__main__")
        try:
            yield
        finally:
            sys.modules["__main__"] = main


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
