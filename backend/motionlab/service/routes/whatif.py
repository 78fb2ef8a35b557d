"""What-if: a run for every move of a slider, its curves decimated, in one binary answer."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Annotated

import numpy as np
from fastapi import APIRouter, Body, Request, Response
from pydantic import Field

from motionlab.config.planar import AXES
from motionlab.config.quantity import Whole
from motionlab.config.timing import CONTROL_PERIOD, to_ticks
from motionlab.errors import ConfigError, FieldError
from motionlab.service.http.binary_answer import MEDIA_TYPE, packed
from motionlab.service.http.openapi_input import examples
from motionlab.service.http.problems import responses
from motionlab.service.http.strict_json import JsonRoute
from motionlab.service.prometheus import Monitor
from motionlab.service.routes.simulate import ChangedScenario, prepare_request
from motionlab.service.settings import Settings
from motionlab.service.worker_answers import ComputedResponse, called
from motionlab.service.workers.worker import Call
from motionlab.simulation.prepare import Prepared
from motionlab.simulation.result import document
from motionlab.simulation.whatif import Extent, run_changed, ticks_at_most
from motionlab.telemetry.channels import REFERENCES, stream_columns
from motionlab.telemetry.decimate import min_max
from motionlab.telemetry.expressions.columns import (
    TEXT_MAX,
    MathChannel,
    compile_columns,
    values_of,
)
from motionlab.telemetry.expressions.compile import CHANNELS_MAX
from motionlab.telemetry.recording import Recording

router = APIRouter(tags=["simulate"], route_class=JsonRoute)

_VALUE_BYTES = 2 * np.float32().itemsize
"""Minimum and maximum of a bin."""
_LATEST = 1e6
"""Latest time that curves may be asked of, s."""
_COPIES = 3
_MATH_COPIES = 2 * CHANNELS_MAX + 2
"""Columns of the whole run that a math channel is computed from and in."""
"""Times that an answer is in memory: as arrays, as bytes, as the file that is sent."""

# Which of them there are depends on the variants.
ColumnName = Annotated[
    str,
    Field(
        max_length=TEXT_MAX,
        json_schema_extra={"pattern": r"^(([A-Z]\.)?[xy]\.[a-z0-9_]+|[^=]*=.+)$"},
    ),
]


class WhatIfRequest(ChangedScenario):
    """A scenario, changes to it, and the curves that are wanted."""

    model_config = examples(
        {
            "scenario": "circle",
            "set": {"variants.B.controller.x.k_p": 312000.0},
            "columns": ["B.x.following_error"],
            "points": 800,
        }
    )

    columns: list[ColumnName] = Field(
        default_factory=list,
        max_length=512,
        description="Names as in the stream's hello, or name=expression",
    )
    points: Whole = Field(
        default=1500, ge=10, le=500_000, strict=True, description="Bins of a curve at most"
    )
    start: float | None = Field(
        default=None,
        ge=0.0,
        le=_LATEST,
        strict=True,
        allow_inf_nan=False,
        description="Begin of the curves, s; without, of the window of the metrics. Where that far "
        "back nothing was simulated, they begin later",
    )
    end: float | None = Field(
        default=None,
        ge=0.0,
        le=_LATEST,
        strict=True,
        allow_inf_nan=False,
        description="End of the curves, s; without, of the window of the metrics",
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
        **responses(400, 413, 415, 422, 429, 503),
    },
)
async def what_if(request: Request, body: Annotated[WhatIfRequest, Body()]) -> Response:
    """Run a scenario and return its result with curves over a stretch of it."""
    monitor: Monitor = request.app.state.monitor
    monitor.simulations.inc()
    with monitor.simulation_seconds.time():
        answer = await called(request, _answer, body, request.app.state.settings.bounds)
    return ComputedResponse(answer, media_type=MEDIA_TYPE)


def _answer(call: Call, body: WhatIfRequest, bounds: Settings) -> bytes:
    prepared = prepare_request(body, bounds)
    math = compile_columns(body.columns, _units(prepared), CONTROL_PERIOD)
    start, stop = _stretch(body, prepared)
    curves = len(body.columns) * _bins(stop - start, body.points)[1] * _VALUE_BYTES
    if curves > bounds.answer_max:
        raise ConfigError(
            FieldError(
                loc="columns",
                message="so many columns of so many points are too large for one answer "
                "(answer_max)",
                value=curves,
                bounds={"maximum": bounds.answer_max},
                unit="bytes",
            )
        )
    extent = Extent(body.exact, bounds.direct_work_max, (start, stop))
    ticks = ticks_at_most(prepared, extent)
    whole = _MATH_COPIES * np.float32().itemsize * ticks if math else 0
    call.hold(prepared.recording_size(ticks) + _COPIES * curves + whole)
    recording = run_changed(prepared, body.scenario, body.set, extent)
    return _encoded(body, prepared, recording, math)


def _units(prepared: Prepared) -> dict[str, str]:
    return {name: each.unit for name, each in stream_columns(list(prepared.scenario.variants))}


def _stretch(body: WhatIfRequest, prepared: Prepared) -> tuple[int, int]:
    """Return the ticks [start, stop) that curves are wanted of, within the scenario."""
    start, stop = prepared.window
    ticks = prepared.reference.ticks
    if body.start is not None:
        start = min(to_ticks(body.start), ticks - 1)
    if body.end is not None:
        stop = min(to_ticks(body.end), ticks)
    if stop > start:
        return start, stop
    raise ConfigError(
        FieldError(
            "end",
            "is not after start",
            body.end,
            bounds={"minimum": start * CONTROL_PERIOD},
            unit="s",
        )
    )


def _bins(ticks: int, points: int) -> tuple[int, int]:
    """Return how many ticks a bin has, and how many bins there are."""
    size = max(1, -(-ticks // points))
    return size, -(-ticks // size)


def _encoded(
    body: WhatIfRequest, prepared: Prepared, recording: Recording, math: Mapping[str, MathChannel]
) -> bytes:
    units = _units(prepared) | {text: each.program.unit for text, each in math.items()}
    begin = recording.first_tick
    start, stop = _stretch(body, prepared)
    start = max(start, begin)
    if stop <= start:  # It lies before what was simulated.
        start, stop = prepared.window
    size, count = _bins(stop - start, body.points)
    curves = np.empty((len(body.columns), 2, count), dtype=np.float32)
    for curve, name in zip(curves, body.columns, strict=True):
        # From the first sample on, so that what is looked at changes no value.
        whole = (
            values_of(math[name], partial(_column, recording))
            if name in math
            else _column(recording, name)
        )
        column = whole[start - begin : stop - begin]
        low, high = min_max(np.asarray(column, dtype=np.float32)[np.newaxis], body.points)
        curve[0], curve[1] = low[0], high[0]
    head = {
        "result": document(prepared, recording),
        "how": "window" if begin else "whole",
        "begin": begin * CONTROL_PERIOD,
        "duration": prepared.reference.ticks * CONTROL_PERIOD,
        "period": CONTROL_PERIOD,
        "time": {"start": start * CONTROL_PERIOD, "step": size * CONTROL_PERIOD, "count": count},
        "columns": [
            {
                "name": name,
                "unit": units[name],
                "minimum": index * 2 * count,
                "maximum": (index * 2 + 1) * count,
            }
            for index, name in enumerate(body.columns)
        ],
    }
    return packed(head, [curves])


def _column(recording: Recording, name: str) -> np.ndarray:
    *variant, axis, channel = name.split(".")
    if variant:
        return recording.variants[variant[0]].channel(channel, axis)
    row = [reference.name for reference in REFERENCES].index(channel)
    return recording.references[row, AXES.index(axis)]
