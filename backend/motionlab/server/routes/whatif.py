"""What-if: a run for every move of a slider, its curves decimated, in one binary answer."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Annotated, Any

import numpy as np
from fastapi import APIRouter, Body, Request, Response
from numpy.typing import NDArray
from pydantic import Field

from motionlab.config.planar import AXES
from motionlab.config.quantity import Whole
from motionlab.errors import ConfigError, FieldError
from motionlab.kernel.force_maps import map_digests
from motionlab.laws import SOURCES
from motionlab.server.http.openapi_input import examples
from motionlab.server.http.problems import responses
from motionlab.server.http.strict_json import JsonRoute
from motionlab.server.prometheus import Monitor
from motionlab.server.routes.simulate import ChangedScenario, prepare_request
from motionlab.server.settings import Settings
from motionlab.server.worker_answers import NUMBERS, ComputedResponse, called
from motionlab.server.workers.worker import Call
from motionlab.simulation.prepare import Prepared
from motionlab.simulation.result import document
from motionlab.simulation.whatif import Extent, recorded_ticks_max, run_changed
from motionlab.telemetry.channels import REFERENCES
from motionlab.telemetry.decimate import min_max
from motionlab.telemetry.expressions.columns import (
    TEXT_MAX,
    MathChannel,
    compile_columns,
    values_of,
)
from motionlab.telemetry.expressions.compile import CHANNELS_MAX
from motionlab.telemetry.law_channels import all_columns, any_law
from motionlab.telemetry.packed import packed
from motionlab.telemetry.recording import Recording
from motionlab.timing import CONTROL_PERIOD, to_ticks

router = APIRouter(tags=["simulate"], route_class=JsonRoute)

_VALUE_BYTES = 2 * np.float32().itemsize
"""Minimum and maximum of a bin."""
_LATEST = 1e6
"""Latest time that curves may be asked of, s."""
_COPIES = 3
"""Times that an answer is in memory: as arrays, as bytes, as the file that is sent."""
_MATH_COPIES = 2 * CHANNELS_MAX + 2
"""Columns of the whole run that a math channel is computed from and in."""
_KEPT_MAX = 64_000_000
"""Most that the columns of a run take that a worker keeps, bytes."""

# Which of them there are depends on the variants.
ColumnName = Annotated[
    str,
    Field(
        max_length=TEXT_MAX,
        json_schema_extra={"pattern": r"^(([A-Z]\.)?[xy]\.[a-z0-9_]+|[^=]*=.+)$"},
    ),
]


class Stretch(ChangedScenario):
    """A scenario, changes to it, and the part of it that is looked at."""

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


class WhatIfRequest(Stretch):
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
            "content": {NUMBERS: {"schema": {"type": "string", "format": "binary"}}},
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
    return ComputedResponse(answer, media_type=NUMBERS)


@dataclass(frozen=True)
class _Run:
    """A run, as far as curves of it are asked for.

    Attributes
    ----------
    result : dict
        Its result document.
    begin : int
        Its first tick.
    columns : dict of str to ndarray of float32, shape (ticks,)
        Every sample of the columns that were asked for.
    """

    result: dict[str, Any]
    begin: int
    columns: dict[str, NDArray[np.float32]]


class _Last:
    """The last exact run of this worker: who looks closer at it needs no other one."""

    def __init__(self) -> None:
        self._key: tuple[Any, ...] = ()
        self._run: _Run | None = None

    def get(self, key: tuple[Any, ...], columns: Iterable[str]) -> _Run | None:
        """Return it if it is the one, and has the columns."""
        run = self._run if key == self._key else None
        return run if run and run.columns.keys() >= set(columns) else None

    def put(self, key: tuple[Any, ...], run: _Run) -> None:
        """Keep it in place of the one before, if it is not too large."""
        size = sum(column.nbytes for column in run.columns.values())
        self._key, self._run = (key, run) if size <= _KEPT_MAX else ((), None)


_LAST = _Last()


def _answer(call: Call, body: WhatIfRequest, bounds: Settings) -> bytes:
    prepared = prepare_request(body, bounds)
    math = compile_columns(body.columns, _units(prepared), CONTROL_PERIOD)
    start, stop = stretch_of(body, prepared)
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
    call.hold(_COPIES * curves)
    key, run = (), None
    if body.exact:
        versions = (*map_digests(prepared.epochs), *SOURCES.values())
        key = (prepared.scenario.model_dump_json(), versions)
        run = _LAST.get(key, body.columns)
    if run is None:
        extent = Extent(body.exact, bounds.direct_work_max, (start, stop))
        run = _computed(call, body, prepared, math, extent)
        if body.exact and run.begin == 0:
            _LAST.put(key, run)
    return _encoded(body, prepared, run, math)


def _computed(
    call: Call,
    body: WhatIfRequest,
    prepared: Prepared,
    math: Mapping[str, MathChannel],
    extent: Extent,
) -> _Run:
    ticks = recorded_ticks_max(prepared, extent)
    whole = len(body.columns) + (_MATH_COPIES if math else 0)
    call.hold(prepared.recording_size(ticks) + np.float32().itemsize * ticks * whole)
    recording = run_changed(prepared, body.scenario, body.set, extent)
    # Of the whole run, so that what is looked at changes no value of a math channel.
    columns = {
        name: values_of(math[name], partial(_column, recording))
        if name in math
        else _column(recording, name)
        for name in body.columns
    }
    copies = {name: np.array(column, dtype=np.float32) for name, column in columns.items()}
    return _Run(document(prepared, recording), recording.first_tick, copies)


def _units(prepared: Prepared) -> dict[str, str]:
    return {name: each.unit for name, each in all_columns(any_law(prepared.scenario.variants))}


def stretch_of(body: Stretch, prepared: Prepared) -> tuple[int, int]:
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
            bounds={"minimum": (start + 1) * CONTROL_PERIOD},
            unit="s",
        )
    )


def _bins(ticks: int, points: int) -> tuple[int, int]:
    """Return how many ticks a bin has, and how many bins there are."""
    size = max(1, -(-ticks // points))
    return size, -(-ticks // size)


def _encoded(
    body: WhatIfRequest, prepared: Prepared, run: _Run, math: Mapping[str, MathChannel]
) -> bytes:
    units = _units(prepared) | {text: each.program.unit for text, each in math.items()}
    begin = run.begin
    start, stop = stretch_of(body, prepared)
    start = max(start, begin)
    if stop <= start:  # It lies before what was simulated.
        start, stop = prepared.window
    size, count = _bins(stop - start, body.points)
    curves = np.empty((len(body.columns), 2, count), dtype=np.float32)
    for curve, name in zip(curves, body.columns, strict=True):
        low, high = min_max(
            run.columns[name][np.newaxis, start - begin : stop - begin], body.points
        )
        curve[0], curve[1] = low[0], high[0]
    head = {
        "result": run.result,
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
