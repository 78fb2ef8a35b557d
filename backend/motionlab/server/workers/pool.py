"""Calls carried out by worker processes: in order of arrival, so many at once, each in its time."""

from __future__ import annotations

import asyncio
import contextlib
from collections import deque
from collections.abc import AsyncIterator, Callable, Coroutine
from typing import Any, TypeVar

from fastapi import HTTPException

from motionlab.server.memory_budget import MemoryBudget
from motionlab.server.workers.fork_client import CallResult, ForkLost, Forks, Worker

CALL_SECONDS = 120.0
"""Time after which a call is given up, s."""
LIGHT_SECONDS = 30.0
"""The same of one that takes milliseconds as a rule."""
WAIT_SECONDS = 30.0
"""Time after which a call gives up its place in the queue, s."""

_RESIDENT_MAX = 700_000_000  # bytes from which an idle worker is replaced
_CANCEL_SECONDS = 2.0  # for a cancelled call to end
_AGAIN_AFTER = 0.5  # s until another fork is tried
_RETRY = {"Retry-After": "1"}

_Turn = asyncio.Future[Worker]
_F = TypeVar("_F", bound=Callable[..., Any])
_INDEXED: set[Callable[..., Any]] = set()


def indexed(function: _F) -> _F:
    """Mark a function whose calls do little but read or write the index of runs."""
    _INDEXED.add(function)
    return function


class Workers:
    """A pool of worker processes.

    Parameters
    ----------
    count : int
        Calls carried out at once; one more process is there for light ones.
    waiting_max : int
        Calls that may wait, and as many light ones; one more is answered 429.
    memory : MemoryBudget
        Memory for the calls.
    index_share : int, optional
        Calls at once that are marked as `indexed`: a database that hangs occupies no more workers.
    """

    def __init__(
        self,
        *,
        count: int,
        waiting_max: int,
        memory: MemoryBudget,
        index_share: int | None = None,
    ) -> None:
        self.forks = Forks(memory)
        self._count = count
        self._waiting_max = waiting_max
        self._idle: list[Worker] = []
        self._alive: set[Worker] = set()
        self._stale: set[Worker] = set()
        self._heavy = 0
        self._index = None if index_share is None else asyncio.Semaphore(index_share)
        self._index_waiting = 0
        self._turns: dict[bool, deque[_Turn]] = {True: deque(), False: deque()}
        self._tasks: set[asyncio.Task[None]] = set()

    def start(self) -> None:
        """Start the processes; calls wait until they are there."""
        self.forks.start()
        for _ in range(self._count + 1):
            self._spawn(self._keep_one())
        self._spawn(self._renew())

    @property
    def ready(self) -> bool:
        """Whether calls are carried out; at first they wait for what is loaded or compiled."""
        return self.forks.settled.is_set()

    async def close(self) -> None:
        """End all processes, and calls with them."""
        for task in self._tasks:
            task.cancel()
        self.forks.close()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        for turn in (*self._turns[True], *self._turns[False]):
            turn.cancel()

    async def run(
        self,
        function: Callable[..., Any],
        *arguments: Any,
        light: bool = False,
        seconds: float = CALL_SECONDS,
    ) -> CallResult:
        """Call a function in a worker.

        Parameters
        ----------
        function : callable
            Of a module; takes a `Call` before the arguments.
        arguments
            Anything that can be pickled.
        light : bool
            Whether it takes milliseconds as a rule: then it does not wait for calls that do not.
        seconds : float
            Time after which it is given up, s.

        Raises
        ------
        HTTPException
            429 if too many calls wait, 503 if it takes too long or its process ends.
        """
        async with self._index_place(function, *arguments):
            return await self._run(function, *arguments, light=light, seconds=seconds)

    async def _run(
        self, function: Callable[..., Any], *arguments: Any, light: bool, seconds: float
    ) -> CallResult:
        worker = await self._turn(light=light)
        try:
            async with asyncio.timeout(seconds):
                return await worker.call(function, *arguments)
        except TimeoutError:
            worker.kill()
            detail = f"this took longer than {seconds:g} s and was given up"
        except ForkLost as error:
            detail = f"this was not computed: {error}"
        except MemoryError:
            detail = "this takes more memory than one call may have"
        finally:
            if worker.busy:
                self._spawn(self._free_later(worker, light=light))
            else:
                self._free(worker, light=light)
        raise HTTPException(503, detail, _RETRY)

    @contextlib.asynccontextmanager
    async def _index_place(self, *functions: Any) -> AsyncIterator[None]:
        """Hold a place among the calls that use the index, if one of the functions does."""
        if self._index is None or not any(callable(f) and f in _INDEXED for f in functions):
            yield
            return
        if self._index.locked() and self._index_waiting >= self._waiting_max:
            raise HTTPException(429, f"{self._waiting_max} calls wait already", _RETRY)
        self._index_waiting += 1
        try:
            async with asyncio.timeout(WAIT_SECONDS):
                await self._index.acquire()
        except TimeoutError:
            detail = f"the index of runs was not free within {WAIT_SECONDS:g} s"
            raise HTTPException(429, detail, _RETRY) from None
        finally:
            self._index_waiting -= 1
        try:
            yield
        finally:
            self._index.release()

    async def _turn(self, *, light: bool) -> Worker:
        """Return a worker that is free, when it is one's turn."""
        turn: _Turn = asyncio.get_running_loop().create_future()
        turns = self._turns[light]
        turns.append(turn)
        self._dispatch()
        try:
            if not turn.done() and len(turns) > self._waiting_max:
                raise HTTPException(429, f"{self._waiting_max} calls wait already", _RETRY)
            await self.forks.settled.wait()
            if self.forks.failure is not None:
                raise HTTPException(503, f"this was not computed: {self.forks.failure}", _RETRY)
            async with asyncio.timeout(WAIT_SECONDS):
                return await turn
        except TimeoutError:
            raise HTTPException(
                429, f"the processor was not free within {WAIT_SECONDS:g} s", _RETRY
            ) from None
        except asyncio.CancelledError:
            if turn.done() and not turn.cancelled():
                self._free(turn.result(), light=light)
            raise
        finally:
            if turn in turns:
                turns.remove(turn)

    def _dispatch(self) -> None:
        while self._idle:
            light = bool(self._turns[True])
            if not light and (self._heavy >= self._count or not self._turns[False]):
                return
            turn = self._turns[light].popleft()
            if not turn.done():
                self._heavy += not light
                turn.set_result(self._idle.pop())

    def _free(self, worker: Worker, *, light: bool) -> None:
        """Take a worker back; one that has grown is replaced."""
        self._heavy -= not light
        if worker.resident > _RESIDENT_MAX or worker in self._stale:
            worker.kill()
        elif worker.alive:
            self._idle.append(worker)
        self._dispatch()

    async def _free_later(self, worker: Worker, *, light: bool) -> None:
        await worker.cancel(_CANCEL_SECONDS)
        self._free(worker, light=light)

    async def _keep_one(self) -> None:
        """Keep one process for calls, in the place of each that has ended."""
        while True:
            try:
                worker = self.forks.fork()
                await asyncio.wait([worker.started])
                worker.started.result()
            except ForkLost:
                await asyncio.sleep(_AGAIN_AFTER)
                continue
            self._alive.add(worker)
            self._idle.append(worker)
            self._dispatch()
            await asyncio.wait([worker.ended])
            self._alive.discard(worker)
            self._stale.discard(worker)
            if worker in self._idle:
                self._idle.remove(worker)

    async def _renew(self) -> None:
        """Replace the first workers by fully loaded ones."""
        await self.forks.complete.wait()
        self._stale = set(self._alive)
        for worker in self._idle:
            worker.kill()
        self._idle.clear()

    def _spawn(self, work: Coroutine[Any, Any, None]) -> None:
        task = asyncio.get_running_loop().create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)
