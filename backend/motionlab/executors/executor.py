"""Executors: they map a function over tasks and return the results in order.

A scheduler names one: ``threads``, ``processes``, ``processes:N``, ``tls://HOST:PORT``, or
``tcp://127.0.0.1:PORT``. The result of a task does not depend on where it is computed.
"""

from __future__ import annotations

import os
import queue
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from contextvars import ContextVar
from typing import Any, TypeVar

from motionlab.errors import ConfigError, FieldError, MotionLabError

VARIABLE = "MOTIONLAB_SCHEDULER"
"""Environment variable that names the scheduler."""
THREADS = "threads"

_FORMS = "threads, processes, processes:N, tls://HOST:PORT or tcp://127.0.0.1:PORT"
_POLL = 0.1  # s between reports of progress, in which the work may be cancelled
_PARTS = 4  # tasks for each worker, so that all end at about the same time
_SLICES = 64  # tasks of a pool, at least
_PROCESSES_MOST = 4
_FIRST = 64  # items of the first task of this process

TaskT = TypeVar("TaskT")
ResultT = TypeVar("ResultT")

Progress = Callable[[float], None]
"""Takes the share done, 0 to 1; what it raises ends the work."""


class WorkerLost(MotionLabError):
    """A worker process that ended before its task, usually for lack of memory."""


class Executor(ABC):
    """Computes tasks; a context that ends with its workers released."""

    threads: int | None = 1
    """Threads that one task may use; None for one on each core."""

    @abstractmethod
    def parts(self, count: int, most: int) -> list[slice]:
        """Return slices of `count` items for one task each, of `most` items at most."""

    @abstractmethod
    def map(
        self,
        function: Callable[[TaskT, Progress], ResultT],
        tasks: Sequence[TaskT],
        progress: Progress | None = None,
    ) -> Iterator[ResultT]:
        """Yield the result of each task, in order.

        Parameters
        ----------
        function : callable
            Of a module. Takes a task and `Progress`, which it calls now and then.
        tasks : sequence
            Of what can be pickled.
        progress : callable, optional
            Called in this thread.

        Raises
        ------
        WorkerLost
            If workers end again and again.
        MotionLabError
            Of the first task, in order, that has failed.
        """

    def close(self) -> None:  # noqa: B027 - not all have workers
        """Release the workers."""

    def __enter__(self) -> Executor:
        """Return the executor."""
        return self

    def __exit__(self, *_: object) -> None:
        """Release the workers."""
        self.close()


class InProcess(Executor):
    """One task after another in this process; compiled code uses threads of its own."""

    threads = None

    def parts(self, count: int, most: int) -> list[slice]:
        """Return slices of growing size: the first results come early, and few are small."""
        slices, size, first = [], min(_FIRST, most), 0
        while first < count:
            slices.append(slice(first, min(first + size, count)))
            first, size = slices[-1].stop, min(2 * size, most)
        return slices

    def map(
        self,
        function: Callable[[TaskT, Progress], ResultT],
        tasks: Sequence[TaskT],
        progress: Progress | None = None,
    ) -> Iterator[ResultT]:
        """Yield the result of each task; see `Executor.map`."""
        for done, task in enumerate(tasks):

            def tell(share: float, done: int = done) -> None:
                if progress is not None:
                    progress((done + share) / len(tasks))

            tell(0.0)
            result = function(task, tell)
            tell(1.0)
            yield result


class Pool(Executor):
    """Tasks submitted to workers, which finish in any order."""

    @property
    @abstractmethod
    def workers(self) -> int:
        """Number of tasks computed at once."""

    @abstractmethod
    def submit(self, function: Callable[..., Any], tasks: Sequence[Any]) -> list[Any]:
        """Return a future for each task."""

    @abstractmethod
    def result(self, future: Any) -> Any:
        """Return the result of a future that is done; TimeoutError if it has been lost since."""

    def under_way(self) -> float:
        """Return the sum of the shares that are done of tasks which have not ended."""
        return 0.0

    def check(self) -> None:
        """Raise WorkerLost if no further result can come; called while results are awaited."""

    @abstractmethod
    def abandon(self, futures: Sequence[Any]) -> None:
        """Cancel unfinished tasks and drop the others."""

    def parts(self, count: int, most: int) -> list[slice]:
        """Return some slices for each worker, of whole blocks of lanes.

        They are the same for any number of workers up to 16, and up to each double of it: what is
        kept of tasks serves a cluster of another size, too.
        """
        doubled = 1 << max(0, _PARTS * self.workers - 1).bit_length()
        size = -(-count // max(_SLICES, doubled))
        return _slices(count, min(most, -(-size // 8) * 8))

    def map(
        self,
        function: Callable[[TaskT, Progress], ResultT],
        tasks: Sequence[TaskT],
        progress: Progress | None = None,
    ) -> Iterator[ResultT]:
        """Yield the result of each task; see `Executor.map`."""
        done: queue.SimpleQueue[int] = queue.SimpleQueue()
        answers: dict[int, Callable[[], ResultT]] = {}
        arrived = following = 0
        share = 0.0
        futures = self.submit(function, tasks)
        try:
            for index, future in enumerate(futures):
                future.add_done_callback(lambda _, index=index: done.put(index))
            while following < len(tasks):
                if progress is not None:
                    # One that has ended may not have arrived yet; progress does not go back.
                    share = max(share, min(1.0, (arrived + self.under_way()) / len(tasks)))
                    progress(share)
                self.check()
                try:
                    index = done.get(timeout=_POLL)
                except queue.Empty:
                    continue
                try:
                    answers[index] = _answer(self.result, futures[index])
                except TimeoutError:
                    done.put(index)
                    continue
                arrived += 1
                while following in answers:
                    yield answers.pop(following)()
                    following += 1
            if progress is not None:
                progress(1.0)
        finally:
            self.abandon(futures)


HERE = InProcess()
_current: ContextVar[Executor] = ContextVar("executor", default=HERE)


def current() -> Executor:
    """Return the executor of `executing`; this process where there is none."""
    return _current.get()


@contextmanager
def executing(scheduler: str | None = None) -> Iterator[None]:
    """Have `current` return an executor until the block ends.

    Parameters
    ----------
    scheduler : str, optional
        That of ``MOTIONLAB_SCHEDULER``, or threads, when left out.

    Raises
    ------
    ConfigError
        See `opened`.
    """
    with opened(scheduler or os.environ.get(VARIABLE) or THREADS) as executor:
        token = _current.set(executor)
        try:
            yield
        finally:
            _current.reset(token)


def opened(scheduler: str) -> Executor:
    """Return the executor that a scheduler names; it connects when it is first used.

    Raises
    ------
    ConfigError
        If there is no such scheduler, it would be reached unencrypted from another machine, or
        what it needs is not installed.
    """
    kind, colon, rest = scheduler.partition(":")
    if scheduler == THREADS:
        return HERE
    if kind == "processes" and (not colon or (rest.isdecimal() and 1 <= int(rest) <= 1024)):
        from motionlab.executors.processes import Processes

        return Processes(int(rest) if rest else cores())
    if kind in {"tcp", "tls"}:
        from motionlab.executors.cluster import Cluster

        return Cluster(scheduler)
    raise ConfigError(FieldError("scheduler", "is no scheduler", scheduler, _FORMS))


def without_lock(workers: int | None = None) -> AbstractContextManager[Executor]:
    """Return an executor for tasks that hold Python's lock: processes in place of threads.

    Parameters
    ----------
    workers : int, optional
        Processes of this machine; the current executor, or as many as there are cores, four at
        most, when left out. One computes here.
    """
    if workers is None and current() is not HERE:
        return nullcontext(current())
    count = min(workers or cores(), _PROCESSES_MOST)
    if count == 1:
        return HERE
    from motionlab.executors.processes import Processes

    return Processes(count)


def cores() -> int:
    """Return the number of cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _slices(count: int, size: int) -> list[slice]:
    return [slice(first, min(first + size, count)) for first in range(0, count, size)]


def _answer(result: Callable[[Any], ResultT], future: Any) -> Callable[[], ResultT]:
    """Return a function that returns a result, or raises what the task has raised."""
    try:
        answer = result(future)
    except TimeoutError:
        raise
    except Exception as error:
        return _raising(error)
    return lambda: answer


def _raising(error: Exception) -> Callable[[], Any]:
    def answer() -> Any:
        raise error

    return answer
