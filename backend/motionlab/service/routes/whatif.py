"""What-if: a run at every move of a slider, its curves decimated, in one binary answer."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from fastapi import APIRouter, Body, Request, Response
from fastapi.concurrency import run_in_threadpool
from pydantic import BeforeValidator, Field

from motionlab.config.planar import AXES
from motionlab.config.timing import CONTROL_PERIOD
from motionlab.errors import ConfigError, FieldError
from motionlab.service.binary import MEDIA_TYPE, packed
from motionlab.service.bodies import JsonRoute, whole
from motionlab.service.memory import Memory
from motionlab.service.monitor import Monitor
from motionlab.service.problems import responses
from motionlab.service.routes.simulate import SimulateRequest, prepare_request
from motionlab.service.settings import Settings
from motionlab.service.slots import free_slot
from motionlab.simulation.prepare import Prepared
from motionlab.simulation.result import document, main_window
from motionlab.simulation.whatif import run_changed, ticks_at_most
from motionlab.telemetry.channels import REFERENCES, stream_columns
from motionlab.telemetry.decimate import min_max
from motionlab.telemetry.recording import Recording

router = APIRouter(tags=["simulate"], route_class=JsonRoute)

# Which of them there are depends on the variants.
ColumnName = Annotated[
    str, Field(json_schema_extra={"pattern": r"^([A-Z]\.)?[xy]\.[a-z0-9_]+$", "maxLength": 64})
]


class WhatIfRequest(SimulateRequest):
    """A scenario, changes to it, and the curves that are wanted."""

    columns: list[ColumnName] = Field(
        default_factory=list, max_length=512, description="Names as in the stream's hello"
    )
    points: Annotated[int, BeforeValidator(whole)] = Field(
        default=1500, ge=10, le=20_000, strict=True, description="Bins over the window at most"
    )
    exact: bool = Field(
        default=False,
        strict=True,
        description="Run from the start, however long that takes; otherwise a long scenario whose "
        "changes a running session would take begins at a stored state shortly before its window",
    )


@router.post(
    "/whatif",
    operation_id="whatIf",
    response_class=Response,
    responses={
        200: {
            "description": "Result document and curves; docs/rest.md",
            "content": {MEDIA_TYPE: {"schema": {"type": "string", "format": "binary"}}},
        },
        **responses(400, 413, 415, 422, 429),
    },
)
async def what_if(request: Request, body: Annotated[WhatIfRequest, Body()]) -> Response:
    """Run a scenario and return its result with curves over the metrics window."""
    slot = free_slot(request)
    monitor: Monitor = request.app.state.monitor
    monitor.simulations.inc()
    async with slot:
        with monitor.simulation_seconds.time():
            state = request.app.state
            answer = await run_in_threadpool(_answer, body, state.settings, state.memory)
    return Response(answer, media_type=MEDIA_TYPE)


def _answer(body: WhatIfRequest, settings: Settings, memory: Memory) -> bytes:
    prepared = prepare_request(body, settings)
    known = dict(stream_columns(list(prepared.scenario.variants)))
    for index, name in enumerate(body.columns):
        if name not in known:
            raise ConfigError(FieldError(f"columns.{index}", "no column of that name", name))
    bounds = {"exact": body.exact, "work_max": settings.direct_work_max}
    size = prepared.recording_size(ticks_at_most(prepared, **bounds))
    memory.check(size)
    with memory.hold(size):
        return _encoded(body, prepared, run_changed(prepared, body.scenario, body.set, **bounds))


def _encoded(body: WhatIfRequest, prepared: Prepared, recording: Recording) -> bytes:
    known = dict(stream_columns(list(prepared.scenario.variants)))
    begin = recording.first_tick
    start, stop = main_window(prepared)
    columns = np.array(
        [_column(recording, name)[start - begin : stop - begin] for name in body.columns],
        dtype=np.float32,
    ).reshape(len(body.columns), stop - start)
    low, high = min_max(columns, body.points)
    count = low.shape[1]
    size = max(1, -(-(stop - start) // body.points))
    head = {
        "result": document(prepared, recording),
        "how": "window" if begin else "whole",
        "begin": begin * CONTROL_PERIOD,
        "time": {"start": start * CONTROL_PERIOD, "step": size * CONTROL_PERIOD, "count": count},
        "columns": [
            {
                "name": name,
                "unit": known[name].unit,
                "minimum": index * 2 * count,
                "maximum": (index * 2 + 1) * count,
            }
            for index, name in enumerate(body.columns)
        ],
    }
    return packed(head, [np.stack((low, high), axis=1)])


def _column(recording: Recording, name: str) -> np.ndarray:
    *variant, axis, channel = name.split(".")
    if variant:
        return recording.variants[variant[0]].channel(channel, axis)
    row = [reference.name for reference in REFERENCES].index(channel)
    return recording.references[row, AXES.index(axis)]
