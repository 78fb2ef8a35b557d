"""The loop over frequency, and what eqs (39) to (42) promise of it."""

from __future__ import annotations

from typing import Annotated, Any, TypeVar

from fastapi import APIRouter, Body, Request, Response

from motionlab.config.load import load_scenario
from motionlab.config.scenario import Scenario
from motionlab.errors import ConfigError, FieldError
from motionlab.loop.linearise import SLIDING, linearise
from motionlab.service.http.openapi_input import Described
from motionlab.service.http.problems import responses
from motionlab.service.http.strict_json import JsonRoute
from motionlab.service.job_reports import SweepJob
from motionlab.service.routes.jobs import Asked, accepted, as_job
from motionlab.service.settings import Settings
from motionlab.service.worker_answers import computed
from motionlab.service.workers.worker import Call
from motionlab.simulation.prepare import prepare
from motionlab.studies.loop.accuracy import AccuracyDocument, accuracy
from motionlab.studies.loop.response import (
    ResponseDocument,
    SweepDocument,
    SweepRequest,
    response,
    swept,
)
from motionlab.studies.tune.request import AxisRequest, read_request

router = APIRouter(tags=["simulate"], route_class=JsonRoute)

_REFUSED = responses(400, 413, 415, 422, 429, 503)
_OfAxis = Annotated[
    dict[str, Any], Described(AxisRequest), Body(examples=[{"scenario": "circle", "axis": "x"}])
]


@router.post(
    "/loop/response",
    operation_id="getResponse",
    response_model=ResponseDocument,
    responses=_REFUSED,
)
async def get_response(request: Request, body: _OfAxis) -> Response:
    """Return open loop, closed loop and sensitivity of one axis over frequency, linearised."""
    return await computed(request, _response, body, light=True)


@router.post(
    "/loop/accuracy",
    operation_id="getAccuracy",
    response_model=AccuracyDocument,
    responses=_REFUSED,
)
async def get_accuracy(request: Request, body: _OfAxis) -> Response:
    """Return crossover and steady-state errors by eqs (39) to (42), beside simulated ones."""
    return await computed(request, _accuracy, body, request.app.state.settings.bounds)


@router.post(
    "/loop/sweep",
    operation_id="sweepLoop",
    status_code=202,
    response_model=SweepJob,
    responses={**accepted(SweepJob), **_REFUSED},
)
async def sweep_loop(
    request: Request,
    body: Annotated[
        dict[str, Any], Described(SweepRequest), Body(examples=[{"frequencies": [10.0, 40.0]}])
    ],
) -> Response:
    """Measure the loop of one axis by a frequency sweep of the simulation, as a job.

    A slow motion goes on meanwhile. The job's report carries the points as they arrive.
    """
    return await as_job(request, "sweep", _swept, _checked, body)


def _response(body: dict[str, Any]) -> ResponseDocument:
    checked, scenario = _loaded(AxisRequest, body)
    v = SLIDING * getattr(scenario.plant, checked.axis).friction.v_s
    return response(checked, scenario, v=v)


def _accuracy(body: dict[str, Any], settings: Settings) -> AccuracyDocument:
    checked, scenario = _loaded(AxisRequest, body)
    duration = prepare(scenario).duration
    if duration > settings.direct_max:
        raise ConfigError(
            FieldError(
                loc="trajectory",
                message="simulated time is too large for an answer at once",
                value=duration,
                range=f"<= {settings.direct_max:g}",
                unit="s",
            )
        )
    return accuracy(checked, scenario)


def _checked(_: Call, _bounds: Settings, body: dict[str, Any]) -> Asked:
    checked, scenario = _loaded(SweepRequest, body)
    linearise(scenario, checked.chosen(scenario), checked.axis, v=checked.velocity)
    return Asked.of(body)


def _swept(call: Call, body: dict[str, Any], _: Settings) -> SweepDocument:
    return swept(*_loaded(SweepRequest, body), call.progress)


_Asked = TypeVar("_Asked", bound=AxisRequest)


def _loaded(model: type[_Asked], body: dict[str, Any]) -> tuple[_Asked, Scenario]:
    checked = read_request(model, body)
    scenario = load_scenario(checked.scenario, checked.set)
    checked.chosen(scenario)
    return checked, scenario
