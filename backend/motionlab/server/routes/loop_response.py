"""The loop over frequency, and eqs (39) to (42) beside simulations."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Body, Request, Response

from motionlab.errors import ConfigError, FieldError
from motionlab.loop.linearise import SLIDING
from motionlab.server.http.openapi_input import Described
from motionlab.server.http.problems import responses
from motionlab.server.http.strict_json import JsonRoute
from motionlab.server.settings import Settings
from motionlab.server.worker_answers import computed
from motionlab.simulation.prepare import prepare
from motionlab.studies.loop.accuracy import AccuracyDocument, accuracy
from motionlab.studies.loop.frequency_sweep import ResponseDocument, loaded, response
from motionlab.studies.tune.documents import AxisRequest

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


def _response(body: dict[str, Any]) -> ResponseDocument:
    checked, scenario = loaded(body)
    v = SLIDING * getattr(scenario.plant, checked.axis).friction.v_s
    return response(checked, scenario, v=v)


def _accuracy(body: dict[str, Any], settings: Settings) -> AccuracyDocument:
    checked, scenario = loaded(body)
    duration = prepare(scenario).duration
    if duration > settings.direct_max:
        raise ConfigError(
            FieldError(
                loc="trajectory",
                message="simulated time is too large for an answer at once",
                value=duration,
                bounds={"maximum": settings.direct_max},
                unit="s",
            )
        )
    return accuracy(checked, scenario)
