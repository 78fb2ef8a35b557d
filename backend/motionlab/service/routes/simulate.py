"""Running a scenario: at once, or as a job."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Body, Header, Request, Response
from fastapi.concurrency import run_in_threadpool
from fastapi.responses import JSONResponse
from pydantic import BaseModel, ConfigDict, Field

from motionlab.config.load import load_scenario
from motionlab.config.scenario import Scenario
from motionlab.errors import ConfigError, FieldError
from motionlab.service.bodies import JsonRoute
from motionlab.service.described import PATHS_MAX, Paths, ScenarioSource
from motionlab.service.jobs import Progress
from motionlab.service.memory import Memory
from motionlab.service.monitor import Monitor
from motionlab.service.problems import responses
from motionlab.service.routes.jobs import ACCEPTED, as_job
from motionlab.service.settings import Settings
from motionlab.service.slots import free_slot
from motionlab.simulation.document import ResultDocument
from motionlab.simulation.prepare import Prepared, prepare
from motionlab.simulation.result import document
from motionlab.simulation.run import run

router = APIRouter(route_class=JsonRoute)


class SimulateRequest(BaseModel):
    """A scenario and changes to it."""

    model_config = ConfigDict(
        extra="forbid",
        json_schema_extra={
            "examples": [{"scenario": "circle", "set": {"variants.B.controller.x.k_p": 312000.0}}]
        },
    )

    scenario: Annotated[str | dict[str, Any], ScenarioSource()] = Field(
        default="circle",
        description="Name of a shipped scenario, or its tables as in a TOML file; see /schema",
    )
    set: Annotated[dict[str, Any], Paths(*Scenario.model_fields)] = Field(
        default_factory=dict,
        max_length=PATHS_MAX,
        description="Dotted path to value, SI; all applied together before validation",
    )


@router.post(
    "/simulate",
    operation_id="simulate",
    tags=["simulate"],
    response_model=ResultDocument,
    responses={**ACCEPTED, **responses(400, 413, 415, 422, 429)},
)
async def simulate(
    request: Request,
    body: Annotated[SimulateRequest, Body()],
    prefer: Annotated[str, Header(description="respond-async makes it a job")] = "",
) -> Response:
    """Run a scenario and return its result document.

    More than 300 s of simulated time, or 600 s summed over variants, or ``Prefer: respond-async``
    make it a job.
    """
    settings: Settings = request.app.state.settings
    prepared = await run_in_threadpool(prepare_request, body, settings)
    memory: Memory = request.app.state.memory
    size = prepared.recording_size()
    memory.check(size)
    too_long = prepared.duration > settings.direct_max or prepared.work > settings.direct_work_max
    if too_long or "respond-async" in prefer.lower():
        asked = body.model_dump()
        work = memory.before(size, lambda progress: _simulated(prepared, progress))
        return as_job(request, "simulate", asked, work)
    slot = free_slot(request)
    monitor: Monitor = request.app.state.monitor
    monitor.simulations.inc()
    async with slot:
        with memory.hold(size), monitor.simulation_seconds.time():
            return JSONResponse(await run_in_threadpool(_run, prepared, None))


def prepare_request(body: SimulateRequest, settings: Settings) -> Prepared:
    """Return a request's scenario, checked, or raise what is wrong with it."""
    prepared = prepare(load_scenario(body.scenario, body.set))
    if prepared.work > settings.work_max:
        raise ConfigError(
            FieldError(
                loc="trajectory",
                message="simulated time times variants is too large for one request",
                value=prepared.work,
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


def _simulated(prepared: Prepared, progress: Progress) -> ResultDocument:
    return ResultDocument.model_validate(_run(prepared, progress))
