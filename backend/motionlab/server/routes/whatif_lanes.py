"""A what-if for the kernel in the page: checked, and as numbers."""

from __future__ import annotations

import asyncio
import itertools
from typing import Annotated, Any

import numpy as np
from fastapi import APIRouter, Body, Request, Response
from numpy.typing import NDArray
from pydantic import Field

from motionlab.server.http.binary_answer import MEDIA_TYPE, packed
from motionlab.server.http.openapi_input import examples
from motionlab.server.http.problems import responses
from motionlab.server.http.strict_json import JsonRoute
from motionlab.server.routes.simulate import prepare_request
from motionlab.server.routes.whatif import Stretch, stretch_of
from motionlab.server.settings import Settings
from motionlab.server.worker_answers import ComputedResponse, called
from motionlab.server.workers.pool import Workers
from motionlab.server.workers.worker import Call
from motionlab.simulation.lane_run import Known, Obstacle, lane_run
from motionlab.simulation.whatif import Extent, beginning
from motionlab.timing import CONTROL_PERIOD

router = APIRouter(tags=["simulate"], route_class=JsonRoute)

_Arrays = dict[str, NDArray[np.float64]]

_COPIES = 3
"""Times that an answer is in memory: as arrays, as bytes, as the file that is sent."""
_SMALL = 100_000
"""Answers of so many bytes are not accounted for, which takes as long as they do."""
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
            "content": {MEDIA_TYPE: {"schema": {"type": "string", "format": "binary"}}},
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
        return Response(await asyncio.to_thread(_at_once, body, bounds), media_type=MEDIA_TYPE)
    answer = await called(request, _answer, body, bounds)
    return ComputedResponse(answer, media_type=MEDIA_TYPE)


def _at_once(body: WhatIfLanesRequest, bounds: Settings) -> bytes:
    head, arrays = _numbers(body, bounds)
    return packed(head, list(arrays.values()), "<f8")


def _answer(call: Call, body: WhatIfLanesRequest, bounds: Settings) -> bytes:
    head, arrays = _numbers(body, bounds)
    size = sum(array.nbytes for array in arrays.values())
    if size > _SMALL:
        call.hold(_COPIES * size)
    return packed(head, list(arrays.values()), "<f8")


def _numbers(body: WhatIfLanesRequest, bounds: Settings) -> tuple[dict[str, Any], _Arrays]:
    prepared = prepare_request(body, bounds)
    extent = Extent(False, bounds.direct_work_max, stretch_of(body, prepared))
    start, stop = beginning(prepared, body.scenario, body.set, extent)
    try:
        run = lane_run(prepared, start, stop, Known(body.inputs, body.tables))
    except Obstacle as obstacle:
        return {"obstacle": str(obstacle)}, {}
    arrays = {
        name: array
        for name in ("lanes", "state", "inputs", "tables")
        if (array := getattr(run, name)) is not None
    }
    head = {
        **run.document(),
        "how": "whole" if start is None else "window",
        "period": CONTROL_PERIOD,
        "ticks": prepared.reference.ticks,
        "first": run.first,
        "stop": run.stop,
        "epochs": run.epochs,
        "tabled": run.tabled,
        "keys": run.keys._asdict(),
        "rows": run.rows,
        "arrays": _places(arrays),
    }
    return head, arrays


def _places(arrays: _Arrays) -> dict[str, dict[str, Any]]:
    """Return of each array the index of its first number, and its shape."""
    ends = itertools.accumulate(array.size for array in arrays.values())
    return {
        name: {"first": end - array.size, "shape": array.shape}
        for (name, array), end in zip(arrays.items(), ends, strict=True)
    }
