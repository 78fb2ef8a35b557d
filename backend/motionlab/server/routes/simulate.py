"""Running a scenario: at once, or as a job."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any

from fastapi import APIRouter, Body, Header, Request, Response
from pydantic import BaseModel, ConfigDict, Field

from motionlab.analysis.result_document import ResultDocument
from motionlab.config.load import load_scenario
from motionlab.config.scenario import Scenario
from motionlab.errors import ConfigError, FieldError
from motionlab.library.library import library
from motionlab.library.run import LINE, NAME_MAX
from motionlab.server.http.openapi_input import PATHS_MAX, Paths, ScenarioSource, examples
from motionlab.server.http.problems import responses
from motionlab.server.http.strict_json import JsonRoute
from motionlab.server.job_reports import REPORTS
from motionlab.server.prometheus import Monitor
from motionlab.server.routes.jobs import CheckedRequest, accepted, as_job
from motionlab.server.settings import Settings
from motionlab.server.worker_answers import ComputedResponse, json_of
from motionlab.server.workers.worker import Call
from motionlab.simulation.prepare import Prepared, prepare
from motionlab.simulation.result import document
from motionlab.simulation.run import run

router = APIRouter(route_class=JsonRoute)


class ChangedScenario(BaseModel):
    """A scenario and changes to it."""

    model_config = ConfigDict(extra="forbid") | examples(
        {"scenario": "circle", "set": {"variants.B.controller.x.k_p": 312000.0}}
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


class SimulateRequest(ChangedScenario):
    """A scenario to run, and whether the run is kept."""

    keep: bool = Field(default=False, strict=True, description="Keep it as a run; docs/runs.md")
    name: str = Field(
        default="", max_length=NAME_MAX, pattern=LINE, description="What the kept run is called"
    )


@router.post(
    "/simulate",
    operation_id="simulate",
    tags=["simulate"],
    response_model=ResultDocument,
    responses={**accepted(REPORTS["simulate"]), **responses(400, 413, 415, 422, 429, 503, 507)},
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
    monitor: Monitor = request.app.state.monitor
    asynchronous = "respond-async" in prefer.lower()
    with monitor.simulation_seconds.time():
        answer = await as_job(request, "simulate", _simulated, _answer, body, asynchronous)
    if isinstance(answer, ComputedResponse):
        monitor.simulations.inc()
    return answer


def prepare_request(
    body: ChangedScenario,
    settings: Settings,
    adapted: Callable[[Scenario], Scenario] = lambda scenario: scenario,
) -> Prepared:
    """Return a request's validated scenario, as `adapted` returns it."""
    prepared = prepare(adapted(load_scenario(body.scenario, body.set)))
    if prepared.work > settings.work_max:
        raise ConfigError(
            FieldError(
                loc="trajectory",
                message="simulated time times variants is too large for one request",
                value=prepared.work,
                bounds={"maximum": settings.work_max},
                unit="s",
            )
        )
    return prepared


def _answer(
    call: Call, bounds: Settings, body: SimulateRequest, asynchronous: bool
) -> bytes | CheckedRequest:
    """Return the result document, or the request where it takes a job."""
    prepared = prepare_request(body, bounds)
    size = prepared.recording_size()
    too_long = prepared.duration > bounds.direct_max or prepared.work > bounds.direct_work_max
    if too_long or asynchronous:
        kept = None if body.keep else {"keep", "name"}
        return CheckedRequest.of(body.model_dump(exclude=kept), size)
    call.hold(size)
    return json_of(call, _run, (body, prepared, call.progress))


def _run(
    body: SimulateRequest, prepared: Prepared, progress: Callable[[float], None]
) -> dict[str, Any]:
    done = 0

    def advanced(ticks: int) -> None:
        nonlocal done
        done += ticks
        progress(done / prepared.reference.ticks)

    recording = run(prepared, advanced)
    result = document(prepared, recording)
    if body.keep:
        kept = library().keep(prepared, recording, result, name=body.name)
        result["run"] = kept.id
    return result


def _simulated(call: Call, body: dict[str, Any], bounds: Settings) -> dict[str, Any]:
    request = SimulateRequest(**body)
    return _run(request, prepare_request(request, bounds), call.progress)
