"""Two runs compared, and runs simulated again."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np
from fastapi import APIRouter, Body, Header, HTTPException, Request, Response
from pydantic import BaseModel, ConfigDict, Field

from motionlab.analysis.aligned_runs import align, curves
from motionlab.analysis.comparison_document import Comparison
from motionlab.analysis.comparison_options import Comparing
from motionlab.analysis.run_comparison import compare, size
from motionlab.errors import Busy, ConfigError, FieldError
from motionlab.library.columns import Columns, of_run
from motionlab.library.library import library
from motionlab.library.replay import Again, Replay, again, replay
from motionlab.library.replays import Demand, Replays, demand, replay_all
from motionlab.library.run import ID
from motionlab.library.search import SEARCH_MAX, parse
from motionlab.server.http.openapi_input import examples
from motionlab.server.http.problems import responses
from motionlab.server.http.strict_json import JsonRoute
from motionlab.server.job_reports import REPORTS
from motionlab.server.routes.jobs import CheckedRequest, accepted, as_job
from motionlab.server.routes.runs import RunId
from motionlab.server.settings import Settings
from motionlab.server.worker_answers import NUMBERS, ComputedResponse, called, json_of
from motionlab.server.workers.worker import Call
from motionlab.studies.study import above
from motionlab.telemetry.packed import packed

router = APIRouter(prefix="/runs", tags=["runs"], route_class=JsonRoute)

RunName = Annotated[str, Field(json_schema_extra={"pattern": ID})]

_EXAMPLE: dict[str, Any] = {
    "a": "r-gpd6hecc7x3n",
    "b": "r-cb3v3zvyllhu",
    "tolerance": {"absolute": 1e-9, "relative": 1e-3},
    "channels": {"*.following_error": {"absolute": 1e-6, "time": 0.001}},
}


class CompareRequest(Comparing):
    """Two runs, and how they are compared."""

    model_config = examples(_EXAMPLE)

    a: RunName = Field(description="Identifier of the baseline")
    b: RunName = Field(description="Identifier of the candidate")


class CompareWindowRequest(CompareRequest):
    """Two runs, and the channel whose curves are wanted."""

    model_config = examples(_EXAMPLE | {"channel": "B.x.following_error", "points": 800})

    channel: str = Field(max_length=200, description="Name of a channel that both runs have")
    first: int = Field(default=0, alias="from", ge=0, strict=True, description="First instant")
    stop: int | None = Field(
        default=None, alias="to", ge=1, strict=True, description="Instant after the last"
    )
    points: int = Field(default=2000, ge=1, le=20_000, strict=True, description="Bins at most")


@router.post(
    "/compare",
    operation_id="compareRuns",
    response_model=Comparison,
    responses=responses(400, 404, 409, 413, 415, 422, 429, 503),
)
async def compare_runs(request: Request, body: Annotated[CompareRequest, Body()]) -> Response:
    """Compare every channel of two runs; what could not be compared does not hold."""
    return ComputedResponse(await called(request, _compared, body))


@router.post(
    "/compare/window",
    operation_id="getComparisonWindow",
    response_class=Response,
    responses={
        200: {
            "description": "Both curves, difference and tolerance; docs/runs-compare.md",
            "content": {NUMBERS: {"schema": {"type": "string", "format": "binary"}}},
        },
        **responses(400, 404, 409, 413, 415, 422, 429, 503),
    },
)
async def get_window(request: Request, body: Annotated[CompareWindowRequest, Body()]) -> Response:
    """Return one channel of two runs between two instants, decimated so that no spike is lost."""
    answer = await called(request, _window, body)
    return ComputedResponse(answer, media_type=NUMBERS)


@router.post(
    "/{run_id}/replay",
    operation_id="replayRun",
    response_model=Replay,
    responses={**accepted(REPORTS["replay"]), **responses(404, 409, 422, 429, 503)},
)
async def replay_run(
    request: Request,
    run_id: RunId,
    prefer: Annotated[str, Header(description="respond-async makes it a job")] = "",
) -> Response:
    """Simulate a run again and compare every channel, bit for bit.

    More than 300 s, or 600 s summed over variants, or ``Prefer: respond-async`` make it a job.
    """
    asynchronous = "respond-async" in prefer.lower()
    return await as_job(request, "replay", _replayed, _answer, run_id, asynchronous)


class ReplaysRequest(BaseModel):
    """Runs that are simulated again."""

    model_config = ConfigDict(extra="forbid") | examples({"q": "scenario:circle B.x.max<10um"})

    q: str = Field(
        default="", max_length=SEARCH_MAX, description="Search, as for the list; empty: all runs"
    )


@router.post(
    "/replay",
    operation_id="replayRuns",
    status_code=202,
    response_model=REPORTS["replays"],
    responses={**accepted(REPORTS["replays"]), **responses(400, 413, 415, 422, 429, 503)},
)
async def replay_runs(request: Request, body: Annotated[ReplaysRequest, Body()]) -> Response:
    """Simulate all runs again that a search finds, and list which have moved; a job."""
    return await as_job(request, "replays", _replayed_all, _check_all, body)


class _ReplayRequest(BaseModel):
    """Body of a job's report."""

    run: str


def _compared(call: Call, body: CompareRequest) -> bytes:
    baseline, candidate = _sides(call, body)
    return json_of(call, compare, (baseline, candidate, body, call.progress))


def _sides(call: Call, body: CompareRequest) -> tuple[Columns, Columns]:
    baseline, candidate = of_run(body.a), of_run(body.b)
    call.hold(size(baseline, candidate))
    return baseline, candidate


def _window(call: Call, body: CompareWindowRequest) -> bytes:
    baseline, candidate = _sides(call, body)
    aligned = align(baseline, candidate, body)
    units = [side.units.get(body.channel) for side in (aligned.baseline, aligned.candidate)]
    if None in units or units[0] != units[1]:
        message = "is not in both runs in one unit"
        raise ConfigError(FieldError("channel", message, body.channel))
    instants = aligned.alignment.instants
    if not instants:
        raise ConfigError(FieldError("align", aligned.alignment.note, body.align))
    start, stop = body.first, min(body.stop or instants, instants)
    if start >= stop:
        bounds: dict[str, float] = {"exclusive_maximum": stop}
        raise ConfigError(FieldError("from", "lies behind the end", start, bounds=bounds))
    drawn = curves(aligned, body.channel, start, stop, body.points)
    count = len(drawn.axis)
    path = aligned.alignment.path
    head = {
        "instants": {"start": start, "step": drawn.bin, "count": count, "total": instants},
        "axis": {
            "name": body.align,
            "unit": {"time": "s", "reference": "m", "index": "1"}[body.align],
            "start": drawn.start,
            "lap_length": None if path is None else path.lap_length,
            "values": 0,
        },
        "columns": [
            {
                "name": name,
                "unit": "1" if name == "beyond" else units[0],
                "minimum": (1 + 2 * row) * count,
                "maximum": (2 + 2 * row) * count,
            }
            for row, name in enumerate(drawn.names)
        ],
    }
    pairs = [curve for pair in zip(drawn.low, drawn.high, strict=True) for curve in pair]
    return packed(head, [drawn.axis.astype(np.float32), *pairs])


def _checked(run_id: str, bounds: Settings) -> Again:
    replayed = again(library().complete(run_id))
    if replayed.work > bounds.work_max:
        raise ConfigError(
            FieldError(
                loc="run_id",
                message="simulated time times variants is too large for one request",
                value=replayed.work,
                bounds={"maximum": bounds.work_max},
                unit="s",
            )
        )
    return replayed


def _answer(
    call: Call, bounds: Settings, run_id: str, asynchronous: bool
) -> bytes | CheckedRequest:
    """Return the result, or the request where it takes a job."""
    replayed = _checked(run_id, bounds)
    too_long = replayed.run.duration > bounds.direct_max or replayed.work > bounds.direct_work_max
    if too_long or asynchronous:
        return CheckedRequest.of(_ReplayRequest(run=run_id).model_dump(), replayed.size)
    call.hold(replayed.size)
    return json_of(call, _replay, (call, replayed))


def _replayed(call: Call, body: dict[str, Any], bounds: Settings) -> Replay:
    return _replay(call, _checked(_ReplayRequest(**body).run, bounds))


def _replay(call: Call, replayed: Again) -> Replay:
    with library().files.open(replayed.run.id) as file:
        return replay(replayed, file, call.progress)


def _demand(q: str, bounds: Settings) -> Demand:
    needed = demand(library(), parse(q))
    message = "simulated time of all runs and variants is too large for one request"
    if too_much := above(needed.work, bounds.trials_max, loc="q", message=message):
        raise ConfigError(*too_much)
    return needed


def _check_all(_: Call, bounds: Settings, body: ReplaysRequest) -> CheckedRequest:
    return CheckedRequest.of(body.model_dump(), _demand(body.q, bounds).size)


def _replayed_all(call: Call, body: dict[str, Any], bounds: Settings) -> Replays:
    q = ReplaysRequest(**body).q
    held = _demand(q, bounds).size

    def hold(size: int) -> None:
        """Reserve what a run takes beyond the runs before it."""
        nonlocal held
        if size > held:
            try:
                call.hold(size - held)
            except HTTPException as error:
                raise Busy(error.detail) from None
            held = size

    return replay_all(library(), parse(q), call.progress, hold)
