"""Views of a kept run, or of a scenario that is simulated for them."""

from __future__ import annotations

from collections.abc import Callable, Coroutine
from typing import Annotated, Any

from fastapi import APIRouter, Body, Request, Response
from pydantic import BaseModel, Field

from motionlab.analysis.views.positioning import (
    COLUMNS,
    Positioning,
    PositioningCycle,
    cycled,
    positioning,
)
from motionlab.analysis.views.table import BY_NAME, VIEWS, View
from motionlab.config.timing import CONTROL_PERIOD
from motionlab.errors import ConfigError, FieldError
from motionlab.library.recorded import of_recording, of_run, of_scenario, ticks_needed
from motionlab.library.run import ID
from motionlab.server.http.openapi_input import examples
from motionlab.server.http.problems import responses
from motionlab.server.http.strict_json import JsonRoute
from motionlab.server.routes.simulate import ChangedScenario, prepare_request
from motionlab.server.settings import Settings
from motionlab.server.worker_answers import ComputedResponse, called, json_of
from motionlab.server.workers.worker import Call
from motionlab.simulation.run import run

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


class PositioningRequest(ViewRequest, PositioningCycle):
    """A kept run that rests at targets, or a scenario whose motor goes through a test cycle."""

    model_config = examples(
        {"scenario": "circle-matched", "axis": "y", "targets": 3, "runs": 2}
        | {"dwell": 0.2, "low": -0.01, "high": 0.01}
    )


def _endpoint(view: View) -> Callable[..., Coroutine[Any, Any, Response]]:
    """Return the function that answers requests of a view."""

    async def endpoint(request: Request, body: Annotated[ViewRequest, Body()]) -> Response:
        bounds: Settings = request.app.state.settings.bounds
        return ComputedResponse(await called(request, _viewed, view.name, body, bounds))

    # The annotations are text, and refer to names that only this module has.
    endpoint.__annotations__ = {"request": Request, "body": Annotated[ViewRequest, Body()]}
    return endpoint


def _viewed(call: Call, name: str, body: ViewRequest, bounds: Settings) -> bytes:
    return json_of(call, _view, (call, BY_NAME[name], body, bounds))


def _view(call: Call, view: View, body: ViewRequest, bounds: Settings) -> BaseModel:
    stretch = (body.start, body.end)
    if body.run is not None:
        recorded = of_run(body.run, *stretch, window=view.window)
    else:
        prepared = prepare_request(body, bounds)
        ticks = ticks_needed(prepared, body.end)
        if ticks * CONTROL_PERIOD > bounds.direct_max:
            most = {"maximum": bounds.direct_max}
            told = "too long to be simulated for a view; simulate it with keep, and name the run"
            raise ConfigError(FieldError("end", told, ticks * CONTROL_PERIOD, "", "s", most))
        call.hold(prepared.recording_size())
        recorded = of_scenario(prepared, *stretch, window=view.window)
    call.hold(view.columns * recorded.column_size)
    return view.compute(recorded)


for _each in VIEWS:
    router.add_api_route(
        f"/{_each.name}",
        _endpoint(_each),
        methods=["POST"],
        operation_id=f"view{_each.name.title()}",
        summary=_each.summary,
        description=f"{_each.summary}, of "
        + ("the window of the metrics" if _each.window else "all of a run or a scenario")
        + " by default; docs/views.md.",
        response_model=_each.document,
        responses=_REFUSED,
    )


@router.post(
    "/positioning", operation_id="viewPositioning", response_model=Positioning, responses=_REFUSED
)
async def view_positioning(
    request: Request, body: Annotated[PositioningRequest, Body()]
) -> Response:
    """Return accuracy and repeatability of an axis, ISO 230-2 style; docs/views.md."""
    bounds: Settings = request.app.state.settings.bounds
    return ComputedResponse(await called(request, _positioned, body, bounds))


def _positioned(call: Call, body: PositioningRequest, bounds: Settings) -> bytes:
    return json_of(call, _positioning, (call, body, bounds))


def _positioning(call: Call, body: PositioningRequest, bounds: Settings) -> Positioning:
    if body.run is not None:
        recorded = of_run(body.run, body.start, body.end, window=False)
        call.hold(COLUMNS * recorded.column_size)
        return positioning(recorded, body, simulated=False)
    for name, time in (("start", body.start), ("end", body.end)):
        if time is not None:
            raise ConfigError(FieldError(name, "is of a run; a cycle is measured whole", time))
    prepared = prepare_request(body, bounds, lambda scenario: cycled(scenario, body))
    if prepared.duration > bounds.direct_max:
        most = {"maximum": bounds.direct_max}
        told = "the cycle is too long for a view: fewer runs or targets, or a shorter dwell"
        raise ConfigError(FieldError("runs", told, prepared.duration, "", "s", most))
    call.hold(prepared.recording_size())
    recorded = of_recording(run(prepared), prepared, 0, prepared.reference.ticks)
    call.hold(COLUMNS * recorded.column_size)
    return positioning(recorded, body, simulated=True)
