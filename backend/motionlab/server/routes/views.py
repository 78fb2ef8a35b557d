"""Views of a kept run, or of a scenario that is simulated for them."""

from __future__ import annotations

from collections.abc import Callable, Coroutine
from typing import Annotated, Any, cast

from fastapi import APIRouter, Body, Request, Response
from pydantic import BaseModel, Field, create_model

from motionlab.analysis.views.recorded import Recorded
from motionlab.analysis.views.table import BY_NAME, VIEWS, View
from motionlab.errors import ConfigError, FieldError
from motionlab.library.recorded import of_run
from motionlab.library.run import ID
from motionlab.server.http.openapi_input import examples
from motionlab.server.http.problems import responses
from motionlab.server.http.strict_json import JsonRoute
from motionlab.server.routes.simulate import ChangedScenario, prepare_request
from motionlab.server.settings import Settings
from motionlab.server.worker_answers import ComputedResponse, called, json_of
from motionlab.server.workers.worker import Call
from motionlab.simulation.recorded import of_scenario, ticks_needed
from motionlab.timing import CONTROL_PERIOD

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


def _request_of(view: View) -> type[ViewRequest]:
    """Return the model of a view's requests: one of its own where it has options."""
    if view.options is None:
        return ViewRequest
    name = f"{view.document_name}Request"
    summary = f"{view.summary}: of what, and its options."
    bases = (ViewRequest, view.options)
    model = create_model(name, __base__=bases, __module__=__name__, __doc__=summary)
    globals()[name] = model  # where workers look for the class of a request
    return cast(type[ViewRequest], model)


def _endpoint(view: View) -> Callable[..., Coroutine[Any, Any, Response]]:
    """Return the function that answers requests of a view."""

    async def endpoint(request: Request, body: ViewRequest) -> Response:
        bounds: Settings = request.app.state.settings.bounds
        return ComputedResponse(await called(request, _viewed, view.name, body, bounds))

    # The annotations are text, and refer to names that only this module has.
    body = Annotated[_request_of(view), Body()]
    endpoint.__annotations__ = {"request": Request, "body": body}
    return endpoint


def _viewed(call: Call, name: str, body: ViewRequest, bounds: Settings) -> bytes:
    return json_of(call, _view, (call, BY_NAME[name], body, bounds))


def _view(call: Call, view: View, body: ViewRequest, bounds: Settings) -> BaseModel:
    if body.run is not None:
        recorded = of_run(body.run, body.start, body.end, window=view.window)
    else:
        recorded = _simulated(call, view, body, bounds)
    call.hold(view.columns * recorded.column_size)
    return view.compute(recorded, body)


def _simulated(call: Call, view: View, body: ViewRequest, bounds: Settings) -> Recorded:
    """Return the stretch of a scenario, or the whole of what a view simulates in its place."""
    stretch = {"start": body.start, "end": body.end}
    prepared = prepare_request(body, bounds, lambda each: view.to_simulate(each, body, stretch))
    ticks = ticks_needed(prepared, body.end)
    if ticks * CONTROL_PERIOD > bounds.direct_max:
        message = "too long to be simulated for a view; simulate it with keep, and name the run"
        if view.measures:
            message = "what is measured is too long for a view of a scenario: measure less"
        most = {"maximum": bounds.direct_max}
        raise ConfigError(FieldError("end", message, ticks * CONTROL_PERIOD, "", "s", most))
    call.hold(prepared.recording_size())
    return of_scenario(prepared, body.start, body.end, window=view.window)


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
