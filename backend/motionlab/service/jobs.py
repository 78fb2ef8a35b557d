"""Work that outlives its request: queued, run one at a time, watched, cancelled."""

from __future__ import annotations

import secrets
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any, Literal

from pydantic import BaseModel, Field

from motionlab.errors import MotionLabError

State = Literal["queued", "running", "done", "failed", "cancelled"]
Progress = Callable[[float], None]
Work = Callable[[Progress], dict[str, Any]]


class JobReport(BaseModel):
    """What is known of a job."""

    id: str = Field(description="Identifier, part of its URL")
    state: State = Field(description="queued, running, done, failed or cancelled")
    progress: float = Field(description="Share of the work that is done, 0 to 1")
    result: dict[str, Any] | None = Field(description="Result document of a job that is done")
    error: str | None = Field(description="Why a job failed")


class TooManyJobs(Exception):
    """The queue is full."""


class _Cancelled(Exception):
    """Raised inside a job's own thread to end it."""


class _Job:
    """State of one job; only its own thread and `Jobs` touch it, under the lock of `Jobs`."""

    def __init__(self, work: Work) -> None:
        self.id = secrets.token_urlsafe(9)
        self.work = work
        self.state: State = "queued"
        self.progress = 0.0
        self.result: dict[str, Any] | None = None
        self.error: str | None = None
        self.cancelled = threading.Event()

    def report(self) -> JobReport:
        return JobReport(
            id=self.id,
            state=self.state,
            progress=self.progress,
            result=self.result,
            error=self.error,
        )


class Jobs:
    """A bounded queue of jobs and the results of the latest.

    Parameters
    ----------
    waiting_max : int
        Jobs that may be queued or running.
    kept_max : int
        Finished jobs that are kept; the oldest go first.
    """

    def __init__(self, *, waiting_max: int, kept_max: int) -> None:
        self._waiting_max = waiting_max
        self._kept_max = kept_max
        self._jobs: dict[str, _Job] = {}
        self._lock = threading.Lock()
        self._pool = ThreadPoolExecutor(max_workers=1, thread_name_prefix="job")

    def submit(self, work: Work) -> JobReport:
        """Queue work.

        Parameters
        ----------
        work : callable
            Called with a function that takes the share done; returns the result document.

        Raises
        ------
        TooManyJobs
            If the queue is full.
        """
        job = _Job(work)
        with self._lock:
            active = [j for j in self._jobs.values() if j.state in {"queued", "running"}]
            if len(active) >= self._waiting_max:
                raise TooManyJobs(f"{len(active)} jobs wait or run already")
            self._jobs[job.id] = job
            finished = [j.id for j in self._jobs.values() if j not in active and j is not job]
            for old in finished[: max(0, len(finished) - self._kept_max)]:
                del self._jobs[old]
            report = job.report()
        self._pool.submit(self._run, job)
        return report

    def report(self, job_id: str) -> JobReport | None:
        """Return what is known of a job, or None if there is none of that id."""
        with self._lock:
            job = self._jobs.get(job_id)
            return None if job is None else job.report()

    def cancel(self, job_id: str) -> JobReport | None:
        """Cancel a job that waits or runs; a finished one stays as it is."""
        with self._lock:
            job = self._jobs.get(job_id)
            if job is None:
                return None
            if job.state in {"queued", "running"}:
                job.cancelled.set()
                job.state = "cancelled"
            return job.report()

    def close(self) -> None:
        """Cancel everything and end the thread."""
        with self._lock:
            for job in self._jobs.values():
                job.cancelled.set()
        self._pool.shutdown(wait=True, cancel_futures=True)

    def _run(self, job: _Job) -> None:
        with self._lock:
            if job.cancelled.is_set():
                return
            job.state = "running"

        def progress(share: float) -> None:
            if job.cancelled.is_set():
                raise _Cancelled
            job.progress = share

        try:
            result = job.work(progress)
        except _Cancelled:
            return
        except MotionLabError as error:
            self._finish(job, "failed", error=str(error))
        except Exception as error:
            self._finish(job, "failed", error=f"{type(error).__name__}: {error}")
            raise
        else:
            self._finish(job, "done", result=result)

    def _finish(
        self,
        job: _Job,
        state: State,
        *,
        result: dict[str, Any] | None = None,
        error: str | None = None,
    ) -> None:
        with self._lock:
            if job.state == "cancelled":
                return
            job.state, job.result, job.error = state, result, error
            job.progress = 1.0 if state == "done" else job.progress
