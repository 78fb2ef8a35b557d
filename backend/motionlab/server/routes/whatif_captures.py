"""Captures of a what-if: stretches of a changed scenario, kept as runs."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Body, Request, Response
from pydantic import ConfigDict

from motionlab.errors import ConfigError, FieldError
from motionlab.library.captures import About
from motionlab.library.run import Run
from motionlab.server.http.openapi_input import examples
from motionlab.server.http.problems import responses
from motionlab.server.http.strict_json import JsonRoute
from motionlab.server.live.history import RING_SECONDS
from motionlab.server.routes.captures import (
    KEPT,
    StretchToKeep,
    check_stretch,
    created,
    kept_as_run,
)
from motionlab.server.routes.simulate import ChangedScenario, prepare_request
from motionlab.server.settings import Settings
from motionlab.server.worker_answers import called
from motionlab.server.workers.worker import Call
from motionlab.simulation.whatif import Extent, recorded_ticks_max, run_changed
from motionlab.telemetry.recording import Recording
from motionlab.timing import to_ticks

router = APIRouter(prefix="/whatif", tags=["simulate"], route_class=JsonRoute)


class WhatIfCaptureRequest(ChangedScenario, StretchToKeep):
    """A stretch of a scenario with changes, 30 s at most."""

    model_config = ConfigDict(extra="forbid") | examples(
        {"scenario": "circle", "from_tick": 0, "to_tick": 400}
    )


@router.post(
    "/captures",
    operation_id="keepWhatIfCapture",
    status_code=201,
    response_model=Run,
    responses={**KEPT, **responses(400, 413, 415, 422, 429, 503, 507)},
)
async def keep_what_if_capture(
    request: Request, body: Annotated[WhatIfCaptureRequest, Body()]
) -> Response:
    """Run a scenario, and keep a stretch of it as a run with every channel."""
    check_stretch(body, to_ticks(RING_SECONDS))
    return created(await called(request, _keep_simulated, body, request.app.state.settings.bounds))


def _keep_simulated(call: Call, body: WhatIfCaptureRequest, bounds: Settings) -> Run:
    prepared = prepare_request(body, bounds)
    start, stop, end = body.from_tick, body.to_tick, prepared.reference.ticks
    if stop > end:
        limit: dict[str, float] = {"maximum": end}
        raise ConfigError(FieldError("to_tick", "the motion ends before", stop, bounds=limit))
    extent = Extent(exact=True, work_max=bounds.direct_work_max)
    call.hold(prepared.recording_size(recorded_ticks_max(prepared, extent)))
    whole = run_changed(prepared, body.scenario, body.set, extent)
    if not whole.holds((start, stop)):
        least: dict[str, float] = {"minimum": whole.first_tick}
        raise ConfigError(FieldError("from_tick", "is not simulated", start, bounds=least))
    first, last = start - whole.first_tick, stop - whole.first_tick
    part = Recording(
        whole.references[:, :, first:last],
        {name: record.cut(first, last) for name, record in whole.variants.items()},
        start,
    )
    about = About(
        "",
        body.name,
        body.note,
        "",
        simulated=True,
        trigger=body.trigger_tick,
        columns=body.columns,
    )
    return kept_as_run(prepared.scenario, part, about)
