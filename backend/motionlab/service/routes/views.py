"""Views of a kept run, or of a scenario that is simulated for them."""

from __future__ import annotations

from collections.abc import Callable, Coroutine
from typing import Annotated, Any

from fastapi import APIRouter, Body, Request, Response
from pydantic import BaseModel, Field

from motionlab.config.timing import CONTROL_PERIOD
from motionlab.errors import ConfigError, FieldError
from motionlab.runs.run import ID
from motionlab.runs.views.recorded import of_run, of_scenario, ticks_needed
from motionlab.runs.views.table import BY_NAME, VIEWS, View
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
