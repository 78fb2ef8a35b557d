"""Jobs: queued, run by a process, monitored, cancelled, and recorded."""

from __future__ import annotations

import asyncio
import json
import logging
import secrets
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from typing import Any, NamedTuple

from fastapi import HTTPException

from motionlab import __version__
from motionlab.errors import MotionLabError, StoreError
from motionlab.lanes import model_hash
from motionlab.library.job_records import RecordStore
from motionlab.server.job_reports import Kind, State, WaitsFor
from motionlab.server.kernel_compiler import Kernels
from motionlab.server.memory_budget import MemoryBudget
from motionlab.server.settings import Settings
from motionlab.server.worker_answers import result_of
from motionlab.server.workers.fork_client import ForkLost, Forks, Worker

_LOG = logging.getLogger(__name__)

_ESTIMATED_FROM = 0.02
"""Share of the work that has to be done before the rest of its time is estimated."""

_POLL = 0.1  # s between polls for memory and kernels
_CANCEL_SECONDS = 1.0  # for a cancelled job to end
_RECORD_SECONDS = 5.0  # between two records of a job that runs
_ENDED_MAX = 30  # jobs whose end is still listed with those that run


class JobTask(NamedTuple):
    """The work of a job.

    Attributes
    ----------
    kind : str
        Decides the form of its report.
    function : callable
        Of a module; takes a `Call`, the request and `Settings`, returns the result document.
    request : bytes
        The request, JSON; a part of the report.
    size : int
        Memory that it holds while it runs, bytes.
    batches : bool
        Whether it needs the kernels of batches.
    subject : str
        What it is of, in short.
    """

    kind: Kind
    function: Callable[..., Any]
    request: bytes
    size: int = 0
    batches: bool = False
    subject: str = ""


class TooManyJobs(Exception):
    """The queue is full."""


def _created() -> str:
    return datetime.now(UTC).isoformat().replace("+00:00", "Z")


@dataclass(eq=False)
class _Job:
    """State of one job; only the event loop touches it."""

    work: JobTask
    turn: asyncio.Future[Worker]
    id: str = field(default_factory=lambda: secrets.token_urlsafe(9))
    created: str = field(default_factory=_created)
    state: State = "queued"
    waits_for: WaitsFor = "server"
    progress: float = 0.0
    began: float | None = None
    ended: float | None = None
    partial: bytes = b"null"
    result: bytes = b"null"
    error: str | None = None
    unrecorded: str | None = None
    doing: asyncio.Task[bytes] | None = None

    @property
    def active(self) -> bool:
        return self.state in {"queued", "running"}

    def status(self) -> dict[str, Any]:
        """Return the report without request, partial and result."""
        elapsed = 0.0
        if self.began is not None:
            elapsed = (self.ended or time.monotonic()) - self.began
        remaining = None
        if self.state == "running" and self.progress >= _ESTIMATED_FROM:
            remaining = elapsed * (1.0 - self.progress) / self.progress
        return {
            "id": self.id,
            "kind": self.work.kind,
            "state": self.state,
            "progress": self.progress,
            "created": self.created,
            "elapsed": elapsed,
            "remaining": remaining,
            "waits_for": self.waits_for if self.state == "queued" else None,
            "subject": self.work.subject,
            "version": __version__,
            "model": model_hash(),
            "error": self.error,
            "unrecorded": self.unrecorded,
        }

    def summary(self) -> bytes:
        head = json.dumps(self.status()).encode()
        return b'%s,"request":%s}' % (head[:-1], self.work.request)

    def report(self) -> bytes:
        parts = self.summary()[:-1], self.partial, self.result
        return b'%s,"partial":%s,"result":%s}' % parts


class Jobs:
    """A bounded queue of jobs, each run by a process of its own.

    Every job has a record, from when it is accepted; in memory are only those that wait or run, and
    those whose end could not be recorded.
    """

    def __init__(
        self,
        settings: Settings,
        *,
        forks: Forks,
        memory: MemoryBudget,
        kernels: Kernels,
        records: RecordStore,
    ) -> None:
        self.records = records
        self._settings = settings
        self._forks = forks
        self._memory = memory
        self._kernels = kernels
        self._jobs: dict[str, _Job] = {}
        self._ended: deque[dict[str, Any]] = deque(maxlen=_ENDED_MAX)
        self._tasks: set[asyncio.Task[None]] = set()
        self._running = 0
        self._closed = False
        self._looking = asyncio.create_task(self._look())

    async def submit(self, work: JobTask) -> tuple[str, bytes]:
        """Queue work, and return its id and report once there is a record of it.

        Raises
        ------
        TooManyJobs
            If the queue is full.
        """
        active = sum(job.active for job in self._jobs.values())
        if active >= self._settings.jobs_max:
            raise TooManyJobs(f"{active} jobs wait or run already")
        job = _Job(work, asyncio.get_running_loop().create_future())
        self._jobs[job.id] = job
        await self._record(job)
        report = job.report()
        task = asyncio.create_task(self._run(job))
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)
        return job.id, report

    def report(self, job_id: str) -> bytes | None:
        """Return the report of a job in memory."""
        job = self._jobs.get(job_id)
        return None if job is None else job.report()

    def summaries(self) -> list[tuple[dict[str, Any], bytes]]:
        """Return summary and request of each job in memory."""
        return [(job.status(), job.work.request) for job in self._jobs.values()]

    def states(self) -> list[dict[str, Any]]:
        """Return the state of each job that waits or runs, then of the latest that have ended."""
        active = [job.status() for job in self._jobs.values() if job.active]
        return active + list(self._ended)

    def cancel(self, job_id: str) -> None:
        """Cancel a job that waits or runs; one that has ended stays as it is."""
        job = self._jobs.get(job_id)
        if job is None or not job.active or (job.doing is not None and job.doing.done()):
            return
        job.state, job.ended = "cancelled", time.monotonic()
        if job.doing is not None:
            job.doing.cancel()

    async def close(self) -> None:
        """End all job processes; unfinished jobs become interrupted."""
        self._closed = True
        self._looking.cancel()
        for job in self._jobs.values():
            if job.doing is not None:
                job.doing.cancel()
        await asyncio.gather(self._looking, *self._tasks, return_exceptions=True)

    async def _run(self, job: _Job) -> None:
        if job.active:  # else it has been cancelled while it was recorded
            job.doing = asyncio.create_task(self._result(job))
            self._dispatch()
            await self._follow(job, job.doing)
            await self._release(job)
        if self._closed:
            await self._record(job)  # as far as it is: the next server calls it interrupted
            return
        ended = replace(job)
        if job.active and job.doing is not None:
            ended.ended = time.monotonic()
            self._judge(ended, job.doing)
        await self._finish(ended)

    async def _follow(self, job: _Job, doing: asyncio.Task[bytes]) -> None:
        """Wait until a job has ended; until then record now and then how far it is."""
        recorded = job.progress
        while not (await asyncio.wait([doing], timeout=_RECORD_SECONDS))[0]:
            if job.progress > recorded:
                recorded = job.progress
                await self._record(job)

    async def _result(self, job: _Job) -> bytes:
        """Return the JSON result of a job once it has run."""

        def on_progress(share: float, partial: bytes | None) -> None:
            if job.state == "running":
                job.progress, job.partial = share, partial or job.partial

        worker = await job.turn
        arguments = job.work.function, job.work.request, self._settings.bounds
        answer = await worker.call(result_of, *arguments, on_progress=on_progress)
        return await asyncio.to_thread(answer.read)

    async def _release(self, job: _Job) -> None:
        """End a job's process, if it has had one."""
        if job.turn.cancelled() or not job.turn.done() or job.turn.exception() is not None:
            return
        worker = job.turn.result()
        await worker.cancel(0.0 if self._closed else _CANCEL_SECONDS)
        worker.kill()
        self._running -= 1
        self._dispatch()

    def _judge(self, job: _Job, doing: asyncio.Task[bytes]) -> None:
        """Note how a job has ended."""
        job.state = "failed"
        match doing.exception():
            case None:
                job.state, job.progress, job.result = "done", 1.0, doing.result()
            case ForkLost() as error:
                job.error = f"the job was not finished: {error}"
            case MotionLabError() as error:
                job.error = str(error)
            case HTTPException() as error:
                job.error = error.detail
            case MemoryError():
                job.error = "this takes more memory than one job may have"
            case error:
                _LOG.error("job %s (%s) failed", job.id, job.work.kind, exc_info=error)
                job.error = f"an unexpected error; the server's log has it (job {job.id})"
                if self._forks.incomplete:
                    job.error += "; not everything could be loaded when the server started"

    async def _finish(self, job: _Job) -> None:
        """Record how a job has ended and drop it from memory, unless the record fails."""
        await self._record(job)
        self._ended.appendleft(job.status())
        if job.unrecorded is None:
            del self._jobs[job.id]
            return
        self._jobs[job.id] = job
        kept = [each.id for each in self._jobs.values() if not each.active]
        for old in kept[: max(0, len(kept) - self._settings.jobs_kept)]:
            del self._jobs[old]

    async def _record(self, job: _Job) -> None:
        """Record a job as it is, or note why that cannot be done."""
        job.unrecorded = None
        try:
            await asyncio.to_thread(self._keep, job)
        except StoreError as error:
            _LOG.warning("job %s is not recorded: %s", job.id, error)
            job.unrecorded = str(error)
            if not job.active:  # what was recorded before is no longer true
                await asyncio.to_thread(self.records.drop, job.id)

    def _keep(self, job: _Job) -> None:
        self.records.keep(job.id, job.summary(), job.report())

    async def _look(self) -> None:
        """Poll for memory and kernels."""
        while True:
            await asyncio.sleep(_POLL)
            self._dispatch()

    def _dispatch(self) -> None:
        """Give jobs their turn, in order; one that waits for memory or kernels is passed over."""
        for job in self._jobs.values():
            if job.doing is None or job.turn.done() or not job.active or self._closed:
                continue
            if self._forks.failure is not None:
                job.turn.set_exception(ForkLost(self._forks.failure))
                continue
            reason = self._reason_to_wait(job.work)
            if reason is None:
                self._start(job)
            else:
                job.waits_for = reason

    def _reason_to_wait(self, work: JobTask) -> WaitsFor | None:
        """Return what a job waits for; None once it has its memory and may start."""
        if not self._forks.settled.is_set():
            return "server"
        if self._running >= self._settings.jobs_at_once:
            return "jobs"
        if work.batches and not self._kernels.settled:
            return "kernels"
        return None if self._memory.try_to_take(work.size) else "memory"

    def _start(self, job: _Job) -> None:
        try:
            worker = self._forks.fork(job.work.size)
        except ForkLost:  # the fork server is being started again
            return
        self._running += 1
        job.state, job.began = "running", time.monotonic()
        job.turn.set_result(worker)
