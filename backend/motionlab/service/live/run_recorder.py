"""Records live sessions: their samples are copied as they come and written by a thread of its own.

A slow or full disk delays neither simulation nor event loop: what the thread cannot take is left
out, and the gap is in the record.
"""

from __future__ import annotations

import asyncio
import contextlib
import errno
import logging
import os
import shutil
import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from fastapi import HTTPException
from numpy.typing import NDArray

from motionlab.config.scenario import Scenario
from motionlab.errors import MotionLabError
from motionlab.problems import plain
from motionlab.runs.library import FREE_LEAST, library, quota, spools
from motionlab.runs.new_run import live_run
from motionlab.runs.run import Event, RunDetail, new_id
from motionlab.service.workers.pool import Workers, indexed
from motionlab.service.workers.worker import Call
from motionlab.simulation.result import metadata
from motionlab.telemetry.channels import Channel
from motionlab.telemetry.ring import Ring

if TYPE_CHECKING:
    from motionlab.runs.spool import Spool

_PERIOD = 0.4  # s between two batches, so that less than a second is lost by a kill
_SHARE = 4  # of the ring: a batch is taken at the latest when so much of it is new
_PENDING_MAX = 128_000_000  # bytes that wait for the disk
_TIDY_PERIOD = 10.0  # s
_RECOVER_TURNS = 3  # tidyings until what could not be made a run is tried again
_CLOSE_SECONDS = 1.5  # for what waits when the server ends
_FINISH_SECONDS = 600.0
_LISTED_SECONDS = 10.0  # that a request waits for a run to be in the index

_LOG = logging.getLogger(__name__)


@dataclass(eq=False)
class _Record:
    """What the thread knows of a recording."""

    scenario: Scenario
    channels: list[tuple[str, Channel]]
    drive: str = ""  # title of the drive link that moves
    id: str = field(default_factory=new_id)
    created: float = field(default_factory=time.time)
    spool: Spool | None = None
    events: list[Event] = field(default_factory=list)  # that are not yet written
    end: int = 0  # the tick after the latest
    lost: int = 0  # of the latest ticks, so many in a row could not be written
    problem: str = ""
    unwritten: str = ""  # what will never be
    changes_wait: bool = False  # a call that lists its changes is queued

    def failed(self, error: Exception) -> None:
        """Note why it is not written, and say so in the log when that is new."""
        known = isinstance(error, OSError | MotionLabError)
        reason = (isinstance(error, OSError) and error.strerror) or str(error)
        if not known:
            reason = f"the recorder failed, {type(error).__name__}: {error}"
        reason = plain(reason)
        if not self.problem:
            _LOG.warning(
                "%s is not being recorded: %s", self.id, reason, exc_info=None if known else error
            )
        self.problem = reason


@dataclass
class _Item:
    record: _Record
    first: int = 0
    samples: NDArray[np.float32] | None = None
    event: Event | None = None
    end: bool = False
    lost: int = 0


class SessionRecorder:
    """Records one timeline of one session, from its first tick.

    Parameters
    ----------
    recorder : RunRecorder
        Whose thread writes.
    ring : Ring
        Where the session's samples are.
    channels : list of (str, Channel)
        Its columns.
    scenario : Scenario
        What is in effect at tick 0.
    drive : str
        Title of the drive link that moves; empty for a simulated session.
    """

    def __init__(
        self,
        recorder: RunRecorder,
        ring: Ring,
        channels: list[tuple[str, Channel]],
        scenario: Scenario,
        *,
        drive: str = "",
    ) -> None:
        self._recorder = recorder
        self._ring = ring
        self._channels = channels
        self._scenario = scenario
        self._drive = drive
        self._lock = threading.Lock()
        self._record: _Record | None = None
        self._early: list[Event] = []  # before the first sample
        self._taken = 0
        self._due = 0.0
        self._ended = False

    @property
    def run(self) -> str | None:
        """Identifier of the run that is being recorded; none while nothing could be written."""
        record = self._record
        if record is None or self._ended or (record.spool is None and record.problem):
            return None
        return record.id

    @property
    def kept(self) -> str | None:
        """Identifier of the run, also once it is complete; none while nothing was written."""
        record = self._record
        return None if record is None or record.spool is None else record.id

    @property
    def problem(self) -> str:
        """Why nothing can be recorded at the moment; empty when all is well."""
        record = self._record
        return "" if record is None else record.problem or record.unwritten

    def advanced(self, *, flush: bool = False) -> None:
        """Take what is new when it is time for it, or at once with `flush`."""
        new = self._ring.end - self._taken
        due = flush or new * _SHARE > self._ring.capacity or time.monotonic() >= self._due
        if new > 0 and due:
            with self._lock:
                self._take()

    def note(self, event: Event) -> None:
        """Record an event, after the ticks before it."""
        with self._lock:
            self._take()
            if self._record is None:
                self._early.append(event)
            elif not self._ended:
                self._recorder.put(_Item(self._record, event=event))

    def end(self) -> None:
        """Record the rest, and make it a run."""
        with self._lock:
            self._take()
            if not self._ended and self._record is not None:
                self._recorder.put(_Item(self._record, end=True))
            self._ended = True

    def _take(self) -> None:
        """Take what is new; whatever that raises, the session and its stop go on."""
        try:
            self._take_new()
        except Exception as error:
            if self._record is not None:
                self._record.failed(error)
            else:
                _LOG.exception("a session is not being recorded")

    def _take_new(self) -> None:
        self._due = time.monotonic() + _PERIOD
        if self._ended or self._ring.end <= self._taken:
            return
        if self._record is None:
            record = _Record(self._scenario, self._channels, self._drive, events=self._early)
            self._recorder.announce(record.id)
            self._record = record
        record = self._record
        while self._taken < (end := self._ring.end):
            start = max(self._taken, self._ring.first)
            try:
                samples = self._ring.read(slice(None), start, end)
            except IndexError:  # overwritten meanwhile
                continue
            self._recorder.put(_Item(record, start, samples, lost=start - self._taken))
            self._taken = end


class RunRecorder:
    """Writes the recordings of all sessions, and has them kept as runs.

    Parameters
    ----------
    root : Path
        Folder of the data.
    workers : Workers
        Where the index is written and recordings are compacted.
    """

    def __init__(self, root: Path, workers: Workers) -> None:
        self._root = root
        self._workers = workers
        self._loop = asyncio.get_running_loop()
        self._tasks: dict[str, asyncio.Task[None]] = {}
        self._unlisted: dict[str, asyncio.Event] = {}  # announced, not yet in the index
        # What the index could not take: runs that are recorded, and those that have ended (None).
        self._missed: dict[str, tuple[_Record, RunDetail | None]] = {}
        self._items: deque[_Item] = deque()
        self._pending = 0
        self._closed = False
        self._changed = threading.Condition()
        self._thread = threading.Thread(target=self._write_all, name="recorder", daemon=True)
        self._thread.start()
        self._tidying = self._loop.create_task(self._tidy())

    def put(self, item: _Item) -> None:
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
                await asyncio.wait_for(unlisted.wait(), _LISTED_SECONDS)

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

    def _carry_out(self, item: _Item) -> None:
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
                record.spool.end(complete=not record.events)
                self._call(record, _finished, record.id)
        elif item.end:
            self._unlisted.pop(record.id, None)

    def _attempt(self, record: _Record, work: Callable[..., None], *arguments: Any) -> None:
        try:
            work(record, *arguments)
        except Exception as error:
            record.failed(error)

    def _append(self, record: _Record, first: int, samples: NDArray[np.float32]) -> None:
        record.lost += samples.shape[1]  # until they are written
        spool = self._spool(record)
        self._check_room(spool)
        spool.append(first, samples)
        record.lost -= samples.shape[1]
        _note_gap(record, first)
        record.problem = ""

    def _write_events(self, record: _Record) -> None:
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

    def _spool(self, record: _Record) -> Spool:
        """Return the file of a record; made when it is first wanted, and can be."""
        if record.spool is None:
            from motionlab.runs.spool import Spool  # noqa: PLC0415 - slow to load: see preload

            self._check_room(None)
            run = live_run(record.scenario, record.id, record.created, drive=record.drive)
            about = metadata(record.scenario)
            record.spool = Spool(spools(self._root), run, record.channels, about)
            self._call(record, _put, run, light=True)
        return record.spool

    def _check_room(self, spool: Spool | None) -> None:
        if shutil.disk_usage(self._root).free < FREE_LEAST:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        if spool is not None and spool.size > quota():
            raise OSError(errno.EDQUOT, "the run takes all that runs may take (MOTIONLAB_RUNS_MAX)")

    def _call(
        self, record: _Record, function: Callable[..., None], *arguments: Any, light: bool = False
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

        with contextlib.suppress(RuntimeError):  # the loop has ended; the next server does it
            self._loop.call_soon_threadsafe(begin)

    def _forget(self, run_id: str, task: asyncio.Task[None]) -> None:
        if self._tasks.get(run_id) is task:
            del self._tasks[run_id]

    def _note_missed(
        self,
        record: _Record,
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
        while True:
            try:
                await self._tidy_once()
            except Exception:
                _LOG.exception("runs: tidying failed")
                await asyncio.sleep(_TIDY_PERIOD)

    async def _tidy_once(self) -> None:
        if await asyncio.to_thread(_has_spools, self._root):
            await self._worked(_recovered)
        for _ in range(_RECOVER_TURNS):
            if await self._worked(_purged, light=True) and self._missed:
                break
            await asyncio.sleep(_TIDY_PERIOD)
        missed, self._missed = self._missed, {}
        for record, run in missed.values():
            if run is not None:
                self._call(record, _listed_again, run, light=True)
        if missed:
            await asyncio.sleep(_TIDY_PERIOD)

    async def _worked(
        self, function: Callable[..., None], *arguments: Any, light: bool = False
    ) -> bool:
        """Have a worker carry something out; return whether it could."""
        try:
            answer = await self._workers.run(
                function, *arguments, light=light, seconds=_FINISH_SECONDS
            )
            answer.close()
        except (MotionLabError, HTTPException) as error:  # tried again later
            _LOG.warning("runs: %s", getattr(error, "detail", None) or error)
            return False
        except Exception:
            _LOG.exception("runs: %s failed", function.__name__)
            return False
        return True


def _note_gap(record: _Record, end: int) -> None:
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


@indexed
def _purged(_: Call) -> None:
    library().purge()
