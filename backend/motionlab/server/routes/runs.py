"""Runs: found, shown, changed, deleted; their telemetry as files and as curves."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np
from fastapi import APIRouter, Body, Depends, Query, Request, Response
from fastapi import Path as PathParameter
from pydantic import BaseModel, ConfigDict, Field

from motionlab.analysis.glitch_document import RunGlitches
from motionlab.errors import ConfigError, FieldError
from motionlab.exchange.selection import formats
from motionlab.library.histogram import RunHistogram
from motionlab.library.library import FREE_LEAST, UNDO_SECONDS, library, quota
from motionlab.library.recorded import run_glitches
from motionlab.library.run import (
    ID,
    LINE,
    NAME_MAX,
    NOTE_MAX,
    TAG,
    TAGS_MAX,
    TEXT,
    Evicted,
    Page,
    Run,
    RunDetail,
)
from motionlab.library.search import LIMIT_MAX, SEARCH_MAX, parse
from motionlab.library.window import grid, window
from motionlab.server.http.openapi_input import examples
from motionlab.server.http.problems import responses
from motionlab.server.http.strict_json import JsonRoute
from motionlab.server.live.run_recorder import RunRecorder
from motionlab.server.worker_answers import NUMBERS, ComputedResponse, called, computed
from motionlab.server.workers.pool import indexed
from motionlab.server.workers.worker import Call
from motionlab.telemetry.expressions.columns import compile_columns, split_columns
from motionlab.telemetry.packed import packed

_MATH_BYTES = 3 * np.float32().itemsize
"""Bytes of a sample of a column while math channels are computed."""

router = APIRouter(prefix="/runs", tags=["runs"], route_class=JsonRoute)

_EVICTED = 20  # evictions that are shown
_UNHELD = 8_000_000  # bytes of samples and curves that a call needs not reserve


async def _listed(
    request: Request,
    run_id: Annotated[
        str,
        PathParameter(
            json_schema_extra={"pattern": ID},
            description="Identifier of a run",
            examples=["r-k5q2mzx7abcd"],
        ),
    ],
) -> str:
    """Return the identifier once the index has the run, if a session has only just begun it."""
    recorder: RunRecorder = request.app.state.recorder
    await recorder.listed(run_id)
    return run_id


RunId = Annotated[str, Depends(_listed)]


class Storage(BaseModel):
    """What all runs take, and what there is."""

    runs: int
    size: int = Field(description="Bytes of telemetry")
    pinned_size: int = Field(description="Of these, bytes of pinned ones")
    kept_size: int = Field(description="Of these, bytes that are kept or pinned: never evicted")
    recording_size: int = Field(description="Bytes of what is being recorded, beside `size`")
    quota: int = Field(
        description="Bytes beyond which the oldest run that no person keeps is evicted"
    )
    evicted: list[Evicted] = Field(description="The latest evictions, the newest first")
    free_least: int = Field(description="Bytes that are left free on the disk")
    undo: float = Field(description="Time for which a deletion can be undone, s")
    tags: dict[str, int] = Field(description="Runs by tag, the most used first")
    scenarios: dict[str, int]
    kinds: dict[str, int]
    states: dict[str, int]
    formats: list[str] = Field(description="Of telemetry; mf4 where asammdf is installed")


class RunChange(BaseModel):
    """What can be changed of a run; what is left out stays."""

    model_config = ConfigDict(extra="forbid") | examples({"tags": ["rig"], "pinned": True})

    name: str | None = Field(default=None, min_length=1, max_length=NAME_MAX, pattern=LINE)
    note: str | None = Field(default=None, max_length=NOTE_MAX, pattern=TEXT)
    tags: list[Annotated[str, Field(pattern=TAG)]] | None = Field(default=None, max_length=TAGS_MAX)
    pinned: bool | None = Field(default=None, strict=True)


class WindowQuery(BaseModel):
    """Which part of a run is wanted, and how finely."""

    columns: str = Field(
        max_length=4000,
        description="Names of channels or name=expression, comma between them; docs/expressions.md",
        examples=["A.x.following_error"],
    )
    start: int = Field(default=0, alias="from", ge=0, description="First sample")
    stop: int | None = Field(default=None, alias="to", ge=1, description="Sample after the last")
    points: int = Field(default=2000, ge=1, le=500_000, description="Bins at most")


@router.get(
    "",
    operation_id="listRuns",
    response_model=Page,
    responses=responses(422, 429, 503),
)
async def list_runs(
    request: Request,
    q: Annotated[
        str, Query(max_length=SEARCH_MAX, description="Search, such as tag:rig B.x.max<3um")
    ] = "",
    sort: Annotated[
        str, Query(max_length=64, description="created, name, duration, size or B.x.max; - first")
    ] = "-created",
    limit: Annotated[int, Query(ge=1, le=LIMIT_MAX, description="Runs on the page")] = 50,
    cursor: Annotated[str | None, Query(max_length=500, description="Of the page before")] = None,
) -> Response:
    """Return a page of the runs that a search finds."""
    return await computed(request, _page, q, sort, limit, cursor, light=True)


@router.get(
    "/storage",
    operation_id="getRunStorage",
    response_model=Storage,
    responses=responses(429, 503),
)
async def get_storage(request: Request) -> Response:
    """Return what all runs take, and how many there are of each kind."""
    return await computed(request, _storage, light=True)


@router.get(
    "/histogram",
    operation_id="getRunHistogram",
    response_model=RunHistogram,
    responses=responses(422, 429, 503),
)
async def get_histogram(
    request: Request,
    metric: Annotated[str, Query(max_length=64, description="Of a variant")] = "B.x.max",
    q: Annotated[str, Query(max_length=SEARCH_MAX, description="Search, as for the list")] = "",
) -> Response:
    """Return how a metric is spread over what a search finds, but for its own bounds."""
    return await computed(request, _histogram, q, metric, light=True)


@router.get(
    "/{run_id}",
    operation_id="getRun",
    response_model=RunDetail,
    responses=responses(404, 429, 503),
)
async def get_run(request: Request, run_id: RunId) -> Response:
    """Return a run with all that makes it reproducible."""
    return await computed(request, _get, run_id, light=True)


@router.patch(
    "/{run_id}",
    operation_id="changeRun",
    response_model=Run,
    responses=responses(400, 404, 413, 415, 422, 429, 503, 507),
)
async def change_run(
    request: Request, run_id: RunId, body: Annotated[RunChange, Body()]
) -> Response:
    """Change name, note, tags or pin of a run."""
    changes = body.model_dump(exclude_none=True)
    if "tags" in changes:
        changes["tags"] = list(dict.fromkeys(changes["tags"]))
    return await computed(request, _change, run_id, changes, light=True)


@router.delete(
    "/{run_id}",
    operation_id="deleteRun",
    response_model=Run,
    responses=responses(404, 409, 429, 503),
)
async def delete_run(request: Request, run_id: RunId) -> Response:
    """Delete a run; it can be restored for ten minutes, then its files are removed."""
    return await computed(request, _delete, run_id, light=True)


@router.post(
    "/{run_id}/restore",
    operation_id="restoreRun",
    response_model=Run,
    responses=responses(404, 429, 503),
)
async def restore_run(request: Request, run_id: RunId) -> Response:
    """Take the deletion of a run back."""
    return await computed(request, _restore, run_id, light=True)


@router.get(
    "/{run_id}/window",
    operation_id="getRunWindow",
    response_class=Response,
    responses={
        200: {
            "description": "Minima and maxima over equal bins; docs/runs.md",
            "content": {NUMBERS: {"schema": {"type": "string", "format": "binary"}}},
        },
        **responses(404, 409, 422, 429, 503),
    },
)
async def get_window(
    request: Request, run_id: RunId, query: Annotated[WindowQuery, Query()]
) -> Response:
    """Return some columns between two samples, decimated so that no spike is lost."""
    answer = await called(request, _window, run_id, query, light=True)
    return ComputedResponse(answer, media_type=NUMBERS)


@router.get(
    "/{run_id}/glitches",
    operation_id="getRunGlitches",
    response_model=RunGlitches,
    responses=responses(404, 409, 429, 503),
)
async def get_glitches(request: Request, run_id: RunId) -> Response:
    """Return the quadrant glitch of every reversal; docs/glitches.md."""
    return await computed(request, _glitches, run_id)


@indexed
def _page(q: str, sort: str, limit: int, cursor: str | None) -> Page:
    return library().index.page(parse(q), sort=sort, limit=limit, cursor=cursor)


@indexed
def _histogram(q: str, metric: str) -> RunHistogram:
    return library().index.histogram(parse(q), metric)


@indexed
def _storage() -> Storage:
    return Storage(
        **library().index.totals(),
        recording_size=library().room.recorded(),
        evicted=library().index.evictions(_EVICTED),
        quota=quota(),
        free_least=FREE_LEAST,
        undo=UNDO_SECONDS,
        formats=formats(),
    )


@indexed
def _get(run_id: str) -> RunDetail:
    return library().get(run_id)


@indexed
def _glitches(run_id: str) -> RunGlitches:
    return run_glitches(run_id)


@indexed
def _change(run_id: str, changes: dict[str, Any]) -> Run:
    return _entry(library().change(run_id, changes))


@indexed
def _delete(run_id: str) -> Run:
    return _entry(library().delete(run_id))


@indexed
def _restore(run_id: str) -> Run:
    return _entry(library().restore(run_id))


def _entry(run: RunDetail) -> Run:
    return Run(**{name: getattr(run, name) for name in Run.model_fields})


def _window(call: Call, run_id: str, query: WindowQuery) -> bytes:
    columns = split_columns(query.columns)
    run = library().complete(run_id)
    start, stop = query.start, min(query.stop or run.ticks, run.ticks)
    if start >= stop:
        bounds: dict[str, float] = {"exclusive_maximum": stop}
        raise ConfigError(FieldError("from", "lies behind the end", start, bounds=bounds))
    units = {column["name"]: column["unit"] for column in run.columns}
    math = compile_columns(columns, units, run.period)
    units |= {text: each.program.unit for text, each in math.items()}
    bins = grid(start, stop, query.points, run.ticks)
    size = 4 * len(columns) * (2 * bins.bins + (stop - start if bins.level == 1 else 0))
    if math:
        size += _MATH_BYTES * (run.ticks if bins.level > 1 else stop - start)
    if size > _UNHELD:
        call.hold(size)
    extremes = window(library().files, run_id, columns, bins, math=math)
    count = bins.bins
    time = {"start": bins.first * run.period, "step": bins.bin * run.period, "count": count}
    head = {
        "time": time,
        "columns": [
            {
                "name": name,
                "unit": units[name],
                "minimum": index * 2 * count,
                "maximum": (index * 2 + 1) * count,
            }
            for index, name in enumerate(columns)
        ],
    }
    curves = [curve for pair in zip(extremes.low, extremes.high, strict=True) for curve in pair]
    return packed(head, curves)
