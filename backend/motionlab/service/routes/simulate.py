"""Running a scenario: at once, or as a job."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Body, Header, HTTPException, Request, Response
from fastapi.concurrency import run_in_threadpool
from fastapi.responses import JSONResponse
from pydantic import BaseModel, ConfigDict, Field

from motionlab.config.load import load_scenario
from motionlab.config.timing import CONTROL_PERIOD
from motionlab.errors import ConfigError, FieldError
from motionlab.service.documents import ResultDocument
from motionlab.service.jobs import JobReport, Jobs, Progress, TooManyJobs
from motionlab.service.monitor import Monitor
from motionlab.service.problems import responses
from motionlab.service.settings import Settings
from motionlab.simulation.result import document
from motionlab.simulation.run import Prepared, prepare, run

router = APIRouter()


class SimulateRequest(BaseModel):
    """A scenario and changes to it."""

    model_config = ConfigDict(
        extra="forbid",
        json_schema_extra={
            "examples": [{"scenario": "circle", "set": {"variants.B.controller.x.k_p": 312000.0}}]
        },
    )

    scenario: str | dict[str, Any] = Field(
        default="circle",
        description="Name of a shipped scenario, or its tables as in a TOML file; see /schema",
    )
    set: dict[str, Any] = Field(
        default_factory=dict,
        description="Dotted path to value, SI; all applied together before validation",
    )


@router.post(
    "/simulate",
    operation_id="simulate",
    tags=["simulate"],
    response_model=ResultDocument,
    responses={
        202: {
            "model": JobReport,
            "description": "Accepted as a job, at its Location",
            "headers": {"Location": {"schema": {"type": "string"}}},
        },
        **responses(400, 413, 422, 429),
    },
)
async def simulate(
    request: Request,
    body: Annotated[SimulateRequest, Body()],
    prefer: Annotated[str, Header(description="respond-async makes it a job")] = "",
) -> Response:
    """Run a scenario and return its result document.

    More than 300 s of simulated time, or ``Prefer: respond-async``, make it a job.
    """
    settings: Settings = request.app.state.settings
    prepared = await run_in_threadpool(prepare_request, body, settings)
    seconds = prepared.reference.ticks * CONTROL_PERIOD
    if seconds > settings.direct_max or "respond-async" in prefer:
        return _as_job(request.app.state.jobs, prepared)
    slots = request.app.state.slots
    if slots.locked():
        raise HTTPException(429, f"{settings.running_max} simulations run already")
    monitor: Monitor = request.app.state.monitor
    monitor.simulations.inc()
    async with slots:
        with monitor.simulation_seconds.time():
            return JSONResponse(await run_in_threadpool(_run, prepared, None))


@router.get("/jobs/{job_id}", operation_id="getJob", tags=["jobs"], responses=responses(404))
def get_job(request: Request, job_id: str) -> JobReport:
    """Return the state, progress and, once it is done, the result of a job."""
    return _found(request.app.state.jobs.report(job_id), job_id)


@router.delete("/jobs/{job_id}", operation_id="cancelJob", tags=["jobs"], responses=responses(404))
def cancel_job(request: Request, job_id: str) -> JobReport:
    """Cancel a job that waits or runs; a finished one stays as it is."""
    return _found(request.app.state.jobs.cancel(job_id), job_id)


def _found(report: JobReport | None, job_id: str) -> JobReport:
    if report is None:
        raise HTTPException(404, f"no job {job_id!r}")
    return report


def prepare_request(body: SimulateRequest, settings: Settings) -> Prepared:
    """Return a request's scenario, checked, or raise what is wrong with it."""
    prepared = prepare(load_scenario(body.scenario, body.set))
    seconds = prepared.reference.ticks * CONTROL_PERIOD
    work = seconds * len(prepared.scenario.variants)
    if work > settings.work_max:
        raise ConfigError(
            FieldError(
                loc="trajectory",
                message="simulated time times variants is too large for one request",
                value=work,
                range=f"<= {settings.work_max:g}",
                unit="s",
            )
        )
    return prepared


def _run(prepared: Prepared, progress: Progress | None) -> dict[str, Any]:
    done = 0

    def advanced(ticks: int) -> None:
        nonlocal done
        done += ticks
        if progress is not None:
            progress(done / prepared.reference.ticks)

    return document(prepared, run(prepared, advanced))


def _as_job(jobs: Jobs, prepared: Prepared) -> Response:
    try:
        report = jobs.submit(lambda progress: _run(prepared, progress))
    except TooManyJobs as error:
        raise HTTPException(429, str(error)) from None
    location = f"/api/v1/jobs/{report.id}"
    return JSONResponse(report.model_dump(), 202, {"Location": location})
