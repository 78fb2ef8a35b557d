"""Records live sessions: their samples are copied as they come and written by a thread of its own.

A slow or full disk delays neither simulation nor event loop: what the thread cannot take is left
out, and the gap is in the record.
"""

from __future__ import annotations

import asyncio
import contextlib
import errno
import logging
import math
import os
import shutil
import threading
import time
from collections import deque
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from fastapi import HTTPException
from numpy.typing import NDArray

from motionlab.errors import MotionLabError
from motionlab.library.library import FREE_LEAST, UNDO_SECONDS, library, quota, spools
from motionlab.library.new_run import live_run
from motionlab.library.run import Event, RunDetail
from motionlab.reports.problems import plain
from motionlab.server.live.session_recorder import Item, Record
from motionlab.server.workers.pool import Workers, indexed
from motionlab.server.workers.worker import Call
from motionlab.simulation.result import metadata

if TYPE_CHECKING:
    from motionlab.library.spool import Spool

_PENDING_MAX = 128_000_000  # bytes that wait for the disk
_TIDY_PERIOD = 10.0  # s
_TIDY_LEAST = 1.0  # the same where recordings need room, s
_RESERVE = 0.05  # of the quota, that is free for what is recorded until the next tidying
_PARTS = 16  # files of a recording, of which the oldest goes
_PART_LEAST, _PART_MOST = 64_000, 64_000_000  # bytes of each
_HEADS = 64_000  # bytes of a batch and of a file beside samples, at most
_NO_ROOM = "runs that are kept leave no room in what all may take (MOTIONLAB_RUNS_MAX): delete some"
_RECOVER_TURNS = 3  # tidyings until what could not be made a run is tried again
_CLOSE_SECONDS = 1.5  # for what waits when the server ends
_FINISH_SECONDS = 600.0
_LISTED_SECONDS = 10.0  # that a request waits for a run to be in the index

_LOG = logging.getLogger(__name__)


class RunRecorder:
    """Writes the recordings of all sessions, and has them kept as runs."""

    def __init__(self, root: Path, workers: Workers) -> None:
        self._root = root
        self._workers = workers
        self._loop = asyncio.get_running_loop()
        self._tasks: dict[str, asyncio.Task[None]] = {}
        self._unlisted: dict[str, asyncio.Event] = {}  # announced, not yet in the index
        # What the index could not take: runs that are recorded, and those that have ended (None).
        self._missed: dict[str, tuple[Record, RunDetail | None]] = {}
        self._live: dict[str, Record] = {}  # what the thread is writing
        self._waiting = 0  # bytes of what it has written since, which are not yet runs
        self._allowed = math.inf  # bytes for all of it
        self._crowded = asyncio.Event()
        self._deletions: dict[tuple[str, float], float] = {}  # of runs, and when they were noticed
        self._items: deque[Item] = deque()
        self._pending = 0
        self._closed = False
        self._changed = threading.Condition()
        self._thread = threading.Thread(target=self._write_all, name="recorder", daemon=True)
        self._thread.start()
        self._tidying = self._loop.create_task(self._tidy())

    def put(self, item: Item) -> None:
        """Hand something to the thread; samples that it cannot take are left out."""
        size = 0 if item.samples is None else item.samples.nbytes
        with self._changed:
            if item.samples is not None and self._pending + size > _PENDING_MAX:
                item.lost += item.samples.shape[1]
                item.first += item.samples.shape[1]
                item.samples, size = None, 0
            self._pending += size
            self._items.append(item)
            self._changed.notify()

    def announce(self, run_id: str) -> None:
        """Note that sessions name a run from now on, before the index has it."""
        self._unlisted[run_id] = asyncio.Event()

    async def listed(self, run_id: str) -> None:
        """Wait until the index has a run that a session has just named; a few seconds at most."""
        if (unlisted := self._unlisted.get(run_id)) is not None:
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(_LISTED_SECONDS):
                    await unlisted.wait()

    async def close(self) -> None:
        """Write what waits, and end."""
        self._tidying.cancel()
        with self._changed:
            self._closed = True
            self._changed.notify()
        await asyncio.to_thread(self._thread.join, _CLOSE_SECONDS)
        # What is not a run within a moment becomes one when the next server starts.
        if tasks := list(self._tasks.values()):
            await asyncio.wait(tasks, timeout=_CLOSE_SECONDS)
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, self._tidying, return_exceptions=True)

    def _write_all(self) -> None:
        while True:
            with self._changed:
                while not self._items and not self._closed:
                    self._changed.wait()
                if not self._items:
                    return
                item = self._items.popleft()
            try:
                self._carry_out(item)
            except Exception as error:  # the thread writes the recordings of all sessions
                item.record.failed(error)
            if item.samples is not None:
                with self._changed:
                    self._pending -= item.samples.nbytes

    def _carry_out(self, item: Item) -> None:
        record = item.record
        record.lost += item.lost
        if item.event is not None:
            record.events.append(item.event)
        if item.samples is not None:
            self._attempt(record, self._append, item.first, item.samples)
            record.end = item.first + item.samples.shape[1]
        elif item.lost:
            record.end = item.first
        if record.spool is not None:
            if item.end:
                _note_gap(record, record.end)
            self._attempt(record, self._write_events)
            if item.end:
                self._live.pop(record.id, None)
                self._waiting += record.spool.size
                record.spool.end(complete=not record.events)
                self._call(record, _finished, record.id)
        elif item.end:
            self._unlisted.pop(record.id, None)

    def _attempt(self, record: Record, work: Callable[..., None], *arguments: Any) -> None:
        try:
            work(record, *arguments)
        except Exception as error:
            record.failed(error)

    def _append(self, record: Record, first: int, samples: NDArray[np.float32]) -> None:
        record.lost += samples.shape[1]  # until they are written
        spool = self._spool(record)
        self._make_room(record, spool, first, samples.nbytes + samples.nbytes // 16 + _HEADS)
        spool.append(first, samples)
        record.lost -= samples.shape[1]
        _note_gap(record, first)
        record.problem = ""

    def _write_events(self, record: Record) -> None:
        while record.spool is not None and record.events:
            event = record.events[0]
            try:
                record.spool.note(event)
            except ValueError as error:  # it will never be written; those after it are
                reason = plain(f"a {event.kind} cannot be written: {error}")
                _LOG.warning("%s: %s", record.id, reason)
                record.spool.note(Event(tick=event.tick, kind="gap", ticks=0, reason=reason))
                record.unwritten = reason
            del record.events[0]
            if event.kind == "change" and not record.changes_wait:
                record.changes_wait = True
                self._call(record, _changes_listed, record.id, light=True)

    def _spool(self, record: Record) -> Spool:
        """Return the file of a record; made when it is first wanted, and can be."""
        if record.spool is None:
            from motionlab.library.spool import Spool  # noqa: PLC0415 - slow to load: see preload

            self._check_disk()
            run = live_run(record.scenario, record.id, record.created, drive=record.drive)
            about = metadata(record.scenario)
            record.spool = Spool(spools(self._root), run, record.channels, about)
            self._live[record.id] = record
            self._call(record, _put, run, light=True)
        return record.spool

    def _check_disk(self) -> None:
        if shutil.disk_usage(self._root).free < FREE_LEAST:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    def _make_room(self, record: Record, spool: Spool, tick: int, size: int) -> None:
        """Make room for `size` bytes of samples from a tick on: the oldest samples go.

        A recording takes half of the quota at most; all together take what runs that are kept and
        other runs leave, and then the largest gives way.
        """
        self._check_disk()
        most = quota() // 2
        share = min(most, self._allowed / max(1, len(self._live))) / _PARTS
        if spool.part_size > min(_PART_MOST, max(_PART_LEAST, share)):
            spool.begin_part(tick)
        while spool.size + size > most and spool.drop_part():
            self._note_rolling(record)
        while self._total + size > self._allowed:
            self._call_soon(self._crowded.set)
            divided = [r for r in self._live.values() if r.spool is not None and r.spool.divided]
            if not divided:
                raise OSError(errno.EDQUOT, _NO_ROOM)
            largest = max(divided, key=lambda r: 0 if r.spool is None else r.spool.size)
            if largest.spool is not None and largest.spool.drop_part():
                self._note_rolling(largest)
        if spool.size + size > most:
            raise OSError(errno.EDQUOT, _NO_ROOM)

    @property
    def _total(self) -> int:
        """Bytes of all recordings."""
        live = (record.spool for record in self._live.values())
        return self._waiting + sum(spool.size for spool in live if spool is not None)

    def _note_rolling(self, record: Record) -> None:
        if not record.rolling:
            record.rolling = True
            _LOG.warning("%s: its beginning goes, to make room for what comes", record.id)

    def _call_soon(self, function: Callable[[], None]) -> None:
        with contextlib.suppress(RuntimeError):  # the loop has ended; the next server does it
            self._loop.call_soon_threadsafe(function)

    def _call(
        self, record: Record, function: Callable[..., None], *arguments: Any, light: bool = False
    ) -> None:
        """Have a worker carry something out, after what was begun for the same run."""

        def begin() -> None:
            before = self._tasks.get(record.id)

            async def carry_out() -> None:
                if before is not None:
                    await asyncio.wait([before])
                record.changes_wait = False  # what comes from now on may be too late for this call
                try:
                    done = await self._worked(function, *arguments, light=light)
                    self._note_missed(record, function, arguments, done=done)
                finally:
                    if (unlisted := self._unlisted.pop(record.id, None)) is not None:
                        unlisted.set()

            task = self._tasks[record.id] = self._loop.create_task(carry_out())
            task.add_done_callback(lambda done: self._forget(record.id, done))

        self._call_soon(begin)

    def _forget(self, run_id: str, task: asyncio.Task[None]) -> None:
        if self._tasks.get(run_id) is task:
            del self._tasks[run_id]

    def _note_missed(
        self,
        record: Record,
        function: Callable[..., None],
        arguments: tuple[Any, ...],
        *,
        done: bool,
    ) -> None:
        """Keep in mind what a call about a run has failed to put into the index."""
        if done and function is not _changes_listed:
            self._missed.pop(record.id, None)
        elif not done and function is _finished:
            self._missed[record.id] = record, None
        elif not done and function is not _changes_listed:
            self._missed[record.id] = record, arguments[0]

    async def _tidy(self) -> None:
        """Make runs of what killed servers recorded, and remove deleted ones, now and then.

        What the index could not take while it was out of reach follows once it answers.
        """
        unusable = ""
        while True:
            try:
                await self._tidy_once()
                unusable = ""
            except OSError as error:  # the folder of data has gone, or cannot be read
                if unusable != (reason := error.strerror or str(error)):
                    _LOG.warning("runs: the folder of data cannot be used: %s", reason)
                unusable = reason
                await asyncio.sleep(_TIDY_PERIOD)
            except Exception:
                _LOG.exception("runs: tidying failed")
                await asyncio.sleep(_TIDY_PERIOD)

    async def _tidy_once(self) -> None:
        if await asyncio.to_thread(_has_spools, self._root):
            await self._worked(_recovered)
        for _ in range(_RECOVER_TURNS):
            if await self._balanced() and self._missed:
                break
            self._crowded.clear()
            await asyncio.sleep(_TIDY_LEAST)
            with contextlib.suppress(TimeoutError):
                # wait_for of Python 3.11 drops a cancellation that comes with the event.
                async with asyncio.timeout(_TIDY_PERIOD):
                    await self._crowded.wait()
        missed, self._missed = self._missed, {}
        for record, run in missed.values():
            if run is not None:
                self._call(record, _listed_again, run, light=True)
        if missed:
            await asyncio.sleep(_TIDY_PERIOD)

    async def _balanced(self) -> bool:
        """Remove deleted runs whose time is over, evict what exceeds the quota; or return False.

        Time is counted here, since a clock that jumps would end the time of every deletion.
        """
        now = time.monotonic()
        due = [each for each, since in self._deletions.items() if now - since > UNDO_SECONDS]
        waiting, live = self._waiting, list(self._live)
        answer = await self._answer(_tidied, due, live, _RESERVE if live else 0.0, light=True)
        if answer is None:
            return False
        self._allowed, deletions, margins_due = answer.value
        answer.close()
        if margins_due:
            await self._worked(_margins_added)
        self._waiting -= waiting
        self._deletions = {each: self._deletions.get(each, now) for each in deletions}
        return True

    async def _worked(
        self, function: Callable[..., None], *arguments: Any, light: bool = False
    ) -> bool:
        """Have a worker carry something out; return whether it could."""
        answer = await self._answer(function, *arguments, light=light)
        if answer is not None:
            answer.close()
        return answer is not None

    async def _answer(
        self, function: Callable[..., Any], *arguments: Any, light: bool = False
    ) -> Any:
        """Return what a worker answers, to be closed, or None where it could not."""
        try:
            return await self._workers.run(
                function, *arguments, light=light, seconds=_FINISH_SECONDS
            )
        except (MotionLabError, HTTPException) as error:  # tried again later
            _LOG.warning("runs: %s", getattr(error, "detail", None) or error)
            return None
        except Exception:
            _LOG.exception("runs: %s failed", function.__name__)
            return None


def _note_gap(record: Record, end: int) -> None:
    """Note that the ticks before `end` were lost, if any were."""
    if record.lost:
        reason = record.problem or "the disk was too slow"
        first = end - record.lost
        record.events.append(Event(tick=first, kind="gap", ticks=record.lost, reason=reason))
    record.lost = 0


def _has_spools(root: Path) -> bool:
    """Tell whether there are recordings, and room for runs."""
    roomy = shutil.disk_usage(root).free >= FREE_LEAST
    return roomy and any(spools(root).glob("r-*"))


@indexed
def _put(_: Call, run: RunDetail) -> None:
    library().index.put(run)


@indexed
def _listed_again(_: Call, run: RunDetail) -> None:
    """Put a run into the index that lacks it, unless it has ended meanwhile."""
    if library().index.get(run.id) is None and any(library().spools.glob(f"{run.id}*")):
        library().index.put(run)
        library().list_changes(run.id)


@indexed
def _changes_listed(_: Call, run_id: str) -> None:
    library().list_changes(run_id)


def _finished(_: Call, run_id: str) -> None:
    library().finish(run_id)


def _recovered(_: Call) -> None:
    library().recover()


def _margins_added(_: Call) -> None:
    library().add_margins()


@indexed
def _tidied(
    _: Call, due: list[tuple[str, float]], live: list[str], reserve: float
) -> tuple[int, list[tuple[str, float]], bool]:
    """Return bytes that live recordings may take, deleted runs, whether margins are missing."""
    library().purge(*due)
    library().note_removed()
    allowed, index = library().room.balance(*live, reserve=reserve), library().index
    return allowed, index.deleted(), bool(index.margins_due())
