"""A what-if for the kernel in the page: checked, and as numbers."""

from __future__ import annotations

import asyncio
import threading
from typing import Annotated

from fastapi import APIRouter, Body, HTTPException, Request, Response
from pydantic import Field

from motionlab.server.http.openapi_input import examples
from motionlab.server.http.problems import responses
from motionlab.server.http.strict_json import JsonRoute
from motionlab.server.routes.simulate import prepare_request
from motionlab.server.routes.whatif import Stretch, stretch_of
from motionlab.server.settings import Settings
from motionlab.server.worker_answers import NUMBERS, ComputedResponse, called
from motionlab.server.workers.pool import Workers
from motionlab.server.workers.worker import Call
from motionlab.simulation.lane_run import Known, LaneRun, Obstacle, lane_run
from motionlab.simulation.whatif import Extent, beginning, may_begin_late
from motionlab.telemetry.packed import packed

router = APIRouter(tags=["simulate"], route_class=JsonRoute)

_COPIES = 3
"""Times that an answer is in memory: as arrays, as bytes, as the file that is sent."""
_SMALL = 100_000
"""Answers of so many bytes are not accounted for, which takes as long as they do."""
_AT_ONCE = threading.Semaphore(2)
"""Answers that threads of the server compute; each delays what stops a motor."""
_RETRY = {"Retry-After": "1"}
_KEY = r"^[0-9a-f]{0,32}$"


class WhatIfLanesRequest(Stretch):
    """A scenario, changes to it, and what is known of it."""

    model_config = examples(
        {"scenario": "circle", "set": {"variants.B.controller.x.k_p": 312000.0}, "inputs": ""}
    )

    inputs: str = Field(default="", pattern=_KEY, description="Key of the inputs that are known")
    tables: str = Field(default="", pattern=_KEY, description="Key of the tables that are known")


@router.post(
    "/whatif/lanes",
    operation_id="whatIfLanes",
    response_class=Response,
    responses={
        200: {
            "description": "Parameters, state and inputs of the kernel; docs/rest.md",
            "content": {NUMBERS: {"schema": {"type": "string", "format": "binary"}}},
        },
        **responses(400, 413, 415, 422, 429, 503),
    },
)
async def what_if_lanes(request: Request, body: Annotated[WhatIfLanesRequest, Body()]) -> Response:
    """Check a changed scenario and return the numbers with which a kernel elsewhere runs it."""
    bounds = request.app.state.settings.bounds
    workers: Workers = request.app.state.workers
    if not workers.ready:
        # They wait for the kernel to be compiled, which takes much longer than these numbers.
        return Response(await asyncio.to_thread(_at_once, body, bounds), media_type=NUMBERS)
    answer = await called(request, _answer, body, bounds)
    return ComputedResponse(answer, media_type=NUMBERS)


def _at_once(body: WhatIfLanesRequest, bounds: Settings) -> bytes:
    """Return an answer while the kernel is being compiled, with all that needs no kernel."""
    if not _AT_ONCE.acquire(blocking=False):
        raise HTTPException(503, "the kernel is being compiled, and others ask already", _RETRY)
    try:
        numbers = _numbers(body, bounds, compiled=False)
        return numbers.packed() if isinstance(numbers, LaneRun) else numbers
    finally:
        _AT_ONCE.release()


def _answer(call: Call, body: WhatIfLanesRequest, bounds: Settings) -> bytes:
    numbers = _numbers(body, bounds)
    if not isinstance(numbers, LaneRun):
        return numbers
    size = sum(array.nbytes for array in numbers.arrays.values())
    if size > _SMALL:
        call.hold(_COPIES * size)
    return numbers.packed()


def _numbers(
    body: WhatIfLanesRequest, bounds: Settings, *, compiled: bool = True
) -> LaneRun | bytes:
    """Return the numbers of a run; in their place, packed, why there are none."""
    prepared = prepare_request(body, bounds)
    extent = Extent(False, bounds.direct_work_max, stretch_of(body, prepared))
    try:
        if not compiled and may_begin_late(prepared, body.set, extent):
            raise Obstacle("the kernel of the server is being compiled")
        start, stop = beginning(prepared, body.scenario, body.set, extent)
        return lane_run(prepared, start, stop, Known(body.inputs, body.tables))
    except Obstacle as obstacle:
        return packed({"obstacle": str(obstacle)}, [])
