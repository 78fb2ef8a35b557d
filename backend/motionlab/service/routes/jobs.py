"""Jobs: what takes long is accepted, watched, cancelled."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, HTTPException, Path, Query, Request, Response
from fastapi.responses import JSONResponse

from motionlab.service.described import ID, links
from motionlab.service.jobs import TooManyJobs, Work
from motionlab.service.kinds import JobReport, JobSummary, Kind
from motionlab.service.problems import responses

router = APIRouter()

JobId = Annotated[str, Path(json_schema_extra={"pattern": ID}, description="Identifier of a job")]

ACCEPTED: dict[int | str, dict[str, Any]] = {
    202: {
        "model": JobReport,
        "description": "Accepted as a job, at its Location",
        "headers": {"Location": {"schema": {"type": "string"}}},
        "links": links("job_id", "getJob", "cancelJob"),
    }
}
"""What OpenAPI says of an answer by `as_job`."""


@router.get("/jobs", operation_id="listJobs", tags=["jobs"])
def list_jobs(
    request: Request,
    kind: Annotated[Kind | None, Query(description="Only jobs of this kind")] = None,
) -> list[JobSummary]:
    """Return the jobs that wait, run or have ended, the newest first.

    Those that are done are recorded, and found again when the server is started anew.
    """
    return request.app.state.jobs.summaries(kind)


@router.get("/jobs/{job_id}", operation_id="getJob", tags=["jobs"], responses=responses(404))
def get_job(request: Request, job_id: JobId) -> JobReport:
    """Return the state, progress and, once it is done, the result of a job."""
    return _found(request.app.state.jobs.report(job_id), job_id)


@router.delete("/jobs/{job_id}", operation_id="cancelJob", tags=["jobs"], responses=responses(404))
def cancel_job(request: Request, job_id: JobId) -> JobReport:
    """Cancel a job that waits or runs; a finished one stays as it is."""
    return _found(request.app.state.jobs.cancel(job_id), job_id)


def _found(report: JobReport | None, job_id: str) -> JobReport:
    if report is None:
        raise HTTPException(404, f"no job {job_id!r}")
    return report


def as_job(request: Request, kind: Kind, body: dict[str, Any], work: Work) -> Response:
    """Queue work and return the answer that tells where to ask for it.

    Parameters
    ----------
    request : Request
        Whose application has the queue.
    kind : str
        What kind of work it is.
    body : dict
        What was asked for; the job's report tells it.
    work : callable
        See `motionlab.service.jobs.Jobs.submit`.
    """
    try:
        report = request.app.state.jobs.submit(kind, body, work)
    except TooManyJobs as error:
        raise HTTPException(429, str(error)) from None
    location = f"/api/v1/jobs/{report.id}"
    return JSONResponse(report.model_dump(mode="json"), 202, {"Location": location})
