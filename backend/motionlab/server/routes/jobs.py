"""Jobs: accepting, watching and cancelling long work."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Annotated, Any, NamedTuple

from fastapi import APIRouter, HTTPException, Path, Query, Request, Response
from pydantic import BaseModel, ValidationError

from motionlab.lanes import model_hash
from motionlab.library.job_records import RecordStore
from motionlab.server import shipped
from motionlab.server.http.openapi_input import ID, links
from motionlab.server.http.problems import responses
from motionlab.server.http.strict_json import JsonRoute
from motionlab.server.job_reports import (
    REPORT,
    JobReport,
    JobState,
    JobSummary,
    Kind,
    subject_of,
)
from motionlab.server.jobs import Jobs, JobTask, TooManyJobs
from motionlab.server.worker_answers import ComputedResponse, called, computed
from motionlab.server.workers.worker import Call

router = APIRouter(route_class=JsonRoute)

JobId = Annotated[
    str,
    Path(
        json_schema_extra={"pattern": ID},
        description="Identifier of a job",
        examples=["U0xWEJm0dmZg"],
    ),
]

_JSON = "application/json"
_GOES_ON = {"queued", "running"}
_INTERRUPTED = {
    "state": "interrupted",
    "error": "the server ended before this job did; ask for it again",
    "remaining": None,
    "waits_for": None,
}
"""What becomes of a job recorded as waiting or running that no server runs."""


def accepted(report: type[BaseModel]) -> dict[int | str, dict[str, Any]]:
    """Return the OpenAPI response of `as_job` for one kind of report."""
    return {
        202: {
            "model": report,
            "description": "Accepted as a job, at its Location",
            "headers": {"Location": {"schema": {"type": "string"}}},
            "links": links("job_id", "getJob", "cancelJob"),
        }
    }


@router.get(
    "/jobs",
    operation_id="listJobs",
    tags=["jobs"],
    response_model=list[JobSummary],
    responses=responses(429, 503),
)
async def list_jobs(
    request: Request,
    kind: Annotated[Kind | None, Query(description="Only jobs of this kind")] = None,
) -> Response:
    """Return the jobs that wait, run or have ended, the newest first.

    With a kind, the result of it that was shipped with the program is the last. Jobs are recorded,
    and found again when the server is started anew.
    """
    jobs: Jobs = request.app.state.jobs
    return await computed(request, _listed, jobs.records, kind, jobs.summaries(), light=True)


@router.get("/jobs/now", operation_id="getJobsNow", tags=["jobs"])
def get_jobs_now(request: Request) -> list[JobState]:
    """Return the jobs that wait or run, then the latest that have ended since the server's start.

    It is answered from memory, and without requests: one call a second keeps up with all of them.
    """
    jobs: Jobs = request.app.state.jobs
    return [JobState(**state) for state in jobs.states()]


@router.get(
    "/jobs/{job_id}",
    operation_id="getJob",
    tags=["jobs"],
    response_model=JobReport,
    responses=responses(404, 429, 503),
)
async def get_job(request: Request, job_id: JobId) -> Response:
    """Return the state, progress and, once it is done, the result of a job."""
    jobs: Jobs = request.app.state.jobs
    report = jobs.report(job_id)
    if report is not None:
        return Response(report, media_type=_JSON)
    return ComputedResponse(await called(request, _recorded, jobs.records, job_id, light=True))


@router.delete(
    "/jobs/{job_id}",
    operation_id="cancelJob",
    tags=["jobs"],
    response_model=JobReport,
    responses=responses(404, 429, 503),
)
async def cancel_job(request: Request, job_id: JobId) -> Response:
    """Cancel a job that waits or runs; a finished one stays as it is."""
    request.app.state.jobs.cancel(job_id)
    return await get_job(request, job_id)


class CheckedRequest(NamedTuple):
    """A request that passed every check.

    Attributes
    ----------
    request : bytes
        As in its job's report, JSON.
    size : int
        Memory that its job holds while it runs, bytes.
    subject : str
        What it is of, in short.
    """

    request: bytes
    size: int = 0
    subject: str = ""

    @classmethod
    def of(cls, body: dict[str, Any], size: int = 0) -> CheckedRequest:
        """Return a request by its body."""
        return cls(json.dumps(body, allow_nan=False).encode(), size, subject_of(body))


async def as_job(
    request: Request,
    kind: Kind,
    function: Callable[..., Any],
    check: Callable[..., bytes | CheckedRequest],
    *arguments: Any,
    batches: bool = False,
) -> Response:
    """Queue work and return 202 with its location.

    Parameters
    ----------
    request : Request
        Whose application has the queue.
    kind : str
        Kind of the job.
    function : callable
        Of a module, called in the job's process with a `Call`, the request as JSON has it, and
        `Settings`; returns the result document.
    check : callable
        Of a module, called in a worker with a `Call`, `Settings` and `asked`; returns the request
        for the job's report, or bytes to answer with at once.
    *asked
        Arguments of `check`.
    batches : bool
        Whether it needs the kernels of batches.
    """
    state = request.app.state
    answer = await called(request, check, state.settings.bounds, *arguments)
    if answer.contents is not None:
        return ComputedResponse(answer)
    body, size, subject = answer.value
    answer.close()
    state.memory.check(size)
    try:
        work = JobTask(kind, function, body, size, batches, subject)
        job_id, report = await state.jobs.submit(work)
    except TooManyJobs as error:
        raise HTTPException(429, str(error)) from None
    return Response(report, 202, {"Location": f"/api/v1/jobs/{job_id}"}, _JSON)


def _listed(
    records: RecordStore, kind: Kind | None, own: list[tuple[dict[str, Any], bytes]]
) -> list[JobSummary]:
    """Return all jobs, from memory or else from their records; runs in a worker."""
    jobs: dict[str, JobSummary] = {}
    for line in records.summaries():
        try:
            recorded = JobSummary.model_validate_json(line)
        except ValidationError:
            continue
        if recorded.state in _GOES_ON:
            recorded = recorded.model_copy(update=_INTERRUPTED)
        jobs[recorded.id] = recorded
    for summary, request in own:
        jobs[summary["id"]] = JobSummary(**summary, request=json.loads(request))
    latest = sorted(jobs.values(), key=lambda job: job.created, reverse=True)
    if kind is not None:
        latest += [JobSummary.model_validate_json(line) for line in shipped.summaries()]
    return [
        job.model_copy(update={"other_model": job.model not in {"", model_hash()}})
        for job in latest
        if kind in (None, job.kind)
    ]


def _recorded(_: Call, records: RecordStore, job_id: str) -> bytes:
    """Return the report of a job that is recorded; runs in a worker."""
    if (report := shipped.report(job_id)) is not None:
        return report
    record = records.read(job_id)
    try:
        if record is not None:
            report = REPORT.validate_json(record)
            if report.state not in _GOES_ON:
                return record
            return report.model_copy(update=_INTERRUPTED).model_dump_json().encode()
    except ValidationError:  # damaged, or of another version
        pass
    raise HTTPException(404, f"no job {job_id!r}")
