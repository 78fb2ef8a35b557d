"""Work that outlives its request: queued, run, watched, cancelled, and recorded when it is done."""

from __future__ import annotations

import logging
import secrets
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from datetime import UTC, datetime
from typing import Any, Protocol

from pydantic import BaseModel, ValidationError

from motionlab.errors import MotionLabError
from motionlab.service.kinds import REPORT, REPORTS, JobReport, JobSummary, Kind, State
from motionlab.store.records import RecordStore

_LOG = logging.getLogger(__name__)

_ESTIMATED_FROM = 0.02
"""Share of the work that has to be done before the rest of its time is estimated."""


class Progress(Protocol):
    """How work tells of itself."""

    def __call__(self, share: float, partial: BaseModel | None = None) -> None:
        """Take the share done, and what is there so far; end the work if it is cancelled."""


Work = Callable[[Progress], BaseModel]


class TooManyJobs(Exception):
    """The queue is full."""


class _Cancelled(Exception):
    """Raised inside a job's own thread to end it."""


class _Job:
    """State of one job; only its own thread and `Jobs` touch it, under the lock of `Jobs`."""

    def __init__(self, kind: Kind, request: dict[str, Any], work: Work) -> None:
        self.id = secrets.token_urlsafe(9)
        self.kind: Kind = kind
        self.request = request
        self.work = work
        self.created = datetime.now(UTC)
        self.state: State = "queued"
        self.progress = 0.0
        self.began: float | None = None
        self.ended: float | None = None
        self.partial: BaseModel | None = None
        self.result: BaseModel | None = None
        self.error: str | None = None
        self.cancelled = threading.Event()

    @property
    def active(self) -> bool:
        return self.state in {"queued", "running"}

    def end(self, state: State) -> None:
        self.state = state
        self.ended = time.monotonic()

    def summary(self) -> dict[str, Any]:
        elapsed = 0.0
        if self.began is not None:
            elapsed = (self.ended or time.monotonic()) - self.began
        remaining = None
        if self.state == "running" and self.progress >= _ESTIMATED_FROM:
            remaining = elapsed * (1.0 - self.progress) / self.progress
        return {
            "id": self.id,
            "kind": self.kind,
            "state": self.state,
            "progress": self.progress,
            "created": self.created,
            "elapsed": elapsed,
            "remaining": remaining,
            "request": self.request,
            "error": self.error,
        }

    def report(self) -> JobReport:
        # Partial and result are documents already: nothing to check again.
        made: Any = REPORTS[self.kind].model_construct(
            None, **self.summary(), partial=self.partial, result=self.result
        )
        return made


class Jobs:
    """A bounded queue of jobs and the results of the latest.

    Parameters
    ----------
    at_once : int
        Jobs that run at once; the others wait.
    waiting_max : int
        Jobs that may be queued or running.
    kept_max : int
        Finished jobs that are kept in memory; the oldest go first.
    records : RecordStore
        Where jobs that are done stay beyond that, and beyond this process.
    """

    def __init__(
        self, *, at_once: int, waiting_max: int, kept_max: int, records: RecordStore
    ) -> None:
        self._waiting_max = waiting_max
        self._kept_max = kept_max
        self._records = records
        self._jobs: dict[str, _Job] = {}
        self._lock = threading.Lock()
        self._pool = ThreadPoolExecutor(max_workers=at_once, thread_name_prefix="job")

    def submit(self, kind: Kind, request: dict[str, Any], work: Work) -> JobReport:
        """Queue work.

        Parameters
        ----------
        kind : str
            What kind of work it is; decides the form of its report.
        request : dict
            What was asked for; a part of the report.
        work : callable
            Called with a function that takes the share done and, where there is any, a partial
            result; returns the result document.

        Raises
        ------
        TooManyJobs
            If the queue is full.
        """
        job = _Job(kind, request, work)
        with self._lock:
            active = sum(j.active for j in self._jobs.values())
            if active >= self._waiting_max:
                raise TooManyJobs(f"{active} jobs wait or run already")
            finished = [j.id for j in self._jobs.values() if not j.active]
            for old in finished[: max(0, len(finished) - self._kept_max)]:
                del self._jobs[old]
            self._jobs[job.id] = job
            report = job.report()
        self._pool.submit(self._run, job)
        return report

    def report(self, job_id: str) -> JobReport | None:
        """Return what is known of a job, or None if there is none of that id."""
        with self._lock:
            job = self._jobs.get(job_id)
            if job is not None:
                return job.report()
        record = self._records.read(job_id)
        try:
            return None if record is None else REPORT.validate_json(record)
        except ValidationError as error:
            _LOG.warning("record %s is not of this version: %s", job_id, error.errors()[0]["msg"])
            return None

    def summaries(self, kind: Kind | None = None) -> list[JobSummary]:
        """Return all jobs that are known, of one kind where it is given; the newest first."""
        with self._lock:
            found = {job.id: JobSummary(**job.summary()) for job in self._jobs.values()}
        for line in self._records.summaries():
            try:
                recorded = JobSummary.model_validate_json(line)
            except ValidationError:
                continue
            found.setdefault(recorded.id, recorded)
        wanted = [job for job in found.values() if kind in (None, job.kind)]
        return sorted(wanted, key=lambda job: job.created, reverse=True)

    def cancel(self, job_id: str) -> JobReport | None:
        """Cancel a job that waits or runs; a finished one stays as it is."""
        with self._lock:
            job = self._jobs.get(job_id)
            if job is not None and job.active:
                job.cancelled.set()
                job.end("cancelled")
        return self.report(job_id)

    def close(self) -> None:
        """Cancel everything and end the threads."""
        with self._lock:
            for job in self._jobs.values():
                job.cancelled.set()
        self._pool.shutdown(wait=True, cancel_futures=True)

    def _run(self, job: _Job) -> None:
        with self._lock:
            if job.cancelled.is_set():
                return
            job.state = "running"
            job.began = time.monotonic()

        def progress(share: float, partial: BaseModel | None = None) -> None:
            if job.cancelled.is_set():
                raise _Cancelled
            with self._lock:
                job.progress = share
                job.partial = job.partial if partial is None else partial

        try:
            result = job.work(progress)
        except _Cancelled:
            return
        except MotionLabError as error:
            self._finish(job, "failed", error=str(error))
        except Exception as error:
            _LOG.exception("job %s (%s) failed", job.id, job.kind)
            self._finish(job, "failed", error=f"{type(error).__name__}: {error}")
        else:
            self._finish(job, "done", result=result)

    def _finish(
        self,
        job: _Job,
        state: State,
        *,
        result: BaseModel | None = None,
        error: str | None = None,
    ) -> None:
        with self._lock:
            if job.state == "cancelled":
                return
            job.end(state)
            job.result, job.error = result, error
            job.progress = 1.0 if state == "done" else job.progress
            report = job.report()
        if state == "done":
            summary = JobSummary(**job.summary()).model_dump_json().encode()
            self._records.keep(job.id, summary, report.model_dump_json().encode())
