"""Views of a kept run, or of a scenario that is simulated for them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any

from fastapi import APIRouter, Body, Request, Response
from pydantic import BaseModel, Field

from motionlab.config.timing import CONTROL_PERIOD
from motionlab.errors import ConfigError, FieldError
from motionlab.runs.run import ID
from motionlab.runs.views.ballbar import Ballbar, ballbar
from motionlab.runs.views.recorded import Recorded, of_run, of_scenario, ticks_needed
from motionlab.service.http.openapi_input import examples
from motionlab.service.http.problems import responses
from motionlab.service.http.strict_json import JsonRoute
from motionlab.service.routes.simulate import ChangedScenario, prepare_request
from motionlab.service.settings import Settings
from motionlab.service.worker_answers import ComputedResponse, called, json_of
from motionlab.service.workers.worker import Call

router = APIRouter(prefix="/views", tags=["simulate"], route_class=JsonRoute)

_REFUSED = responses(400, 404, 409, 413, 415, 422, 429, 503)
_TIME_MAX = 1e6


class ViewRequest(ChangedScenario):
    """A kept run, or a scenario that is simulated, and which stretch of it."""

    model_config = examples(
        {"scenario": "circle", "set": {"variants.B.controller.x.k_p": 312000.0}}
    )

    run: str | None = Field(
        default=None, pattern=ID, description="A kept run, in place of scenario and set"
    )
    start: float | None = Field(
        default=None,
        ge=0.0,
        le=_TIME_MAX,
        allow_inf_nan=False,
        description="Begin of the stretch, s; without both ends, the window of the metrics",
    )
    end: float | None = Field(
        default=None, ge=0.0, le=_TIME_MAX, allow_inf_nan=False, description="Its end, s"
    )


@router.post("/ballbar", operation_id="viewBallbar", response_model=Ballbar, responses=_REFUSED)
async def view_ballbar(request: Request, body: Annotated[ViewRequest, Body()]) -> Response:
    """Return the circular test of a run or a scenario, all of it by default; docs/views.md."""
    return await _answer(request, body, ballbar, window=False)


async def _answer(
    request: Request, body: ViewRequest, view: Callable[[Recorded], BaseModel], **options: Any
) -> Response:
    bounds: Settings = request.app.state.settings.bounds
    return ComputedResponse(await called(request, _viewed, body, bounds, view, options))


def _viewed(
    call: Call,
    body: ViewRequest,
    bounds: Settings,
    view: Callable[[Recorded], BaseModel],
    options: dict[str, Any],
) -> bytes:
    return json_of(call, _view, (call, body, bounds, view, options))


def _view(
    call: Call,
    body: ViewRequest,
    bounds: Settings,
    view: Callable[[Recorded], BaseModel],
    options: dict[str, Any],
) -> BaseModel:
    if body.run is not None:
        return view(of_run(body.run, body.start, body.end, **options))
    prepared = prepare_request(body, bounds)
    ticks = ticks_needed(prepared, body.end)
    if ticks * CONTROL_PERIOD > bounds.direct_max:
        most = {"maximum": bounds.direct_max}
        told = "too long to be simulated for a view; simulate it with keep, and name the run"
        raise ConfigError(FieldError("end", told, ticks * CONTROL_PERIOD, "", "s", most))
    call.hold(prepared.recording_size())
    return view(of_scenario(prepared, body.start, body.end, **options))
