"""Captures: stretches of a live session, kept as runs."""

from __future__ import annotations

import asyncio
import contextlib
import json
from pathlib import Path
from typing import Annotated

import numpy as np
from fastapi import APIRouter, Body, Request, Response
from pydantic import BaseModel, ConfigDict, Field

from motionlab.config.quantity import Whole
from motionlab.config.scenario import Scenario
from motionlab.errors import ConfigError, FieldError
from motionlab.runs.captures import About, keep_capture
from motionlab.runs.library import library
from motionlab.runs.run import LINE, NAME_MAX, TEXT, Run
from motionlab.service.http.download import temporary_folder
from motionlab.service.http.openapi_input import examples, links
from motionlab.service.http.problems import responses
from motionlab.service.http.strict_json import JsonRoute
from motionlab.service.live.session import Session
from motionlab.service.memory_budget import MemoryBudget
from motionlab.service.routes.sessions import FoundSession
from motionlab.service.worker_answers import called
from motionlab.service.workers.worker import Call

router = APIRouter(prefix="/sessions", tags=["sessions"], route_class=JsonRoute)

_COPIES = 4
"""Memory for keeping a capture, in sizes of its samples: a copy, a file in memory, two to write."""
_NOTE_MAX = 2000


class CaptureRequest(BaseModel):
    """A stretch of the latest 30 s of a session."""

    model_config = ConfigDict(extra="forbid") | examples({"from_tick": 0, "to_tick": 400})

    from_tick: Whole = Field(ge=0, strict=True, description="First tick")
    to_tick: Whole = Field(ge=1, strict=True, description="Tick after the last")
    timeline: Whole | None = Field(
        default=None,
        ge=0,
        strict=True,
        description="The session's timeline that the ticks are of: a reset begins another one, "
        "and what was before is refused. Without, the newest",
    )
    name: str = Field(default="", max_length=NAME_MAX, pattern=LINE, description="Of the run")
    note: str = Field(
        default="", max_length=_NOTE_MAX, pattern=TEXT, description="Such as what triggered"
    )


@router.post(
    "/{session_id}/captures",
    operation_id="keepCapture",
    status_code=201,
    response_model=Run,
    responses={
        201: {
            "description": "The run that was kept",
            "headers": {"Location": {"schema": {"type": "string"}}},
            "links": links("run_id", "getRun", "getRunTelemetry", "deleteRun"),
        },
        **responses(400, 404, 413, 415, 422, 429, 503, 507),
    },
)
async def keep_session_capture(
    request: Request, session: FoundSession, body: Annotated[CaptureRequest, Body()]
) -> Response:
    """Keep a stretch of a session's latest 30 s as a run with every channel."""
    ring, scenario = session.history.ring, session.simulation.scenario
    start, stop = body.from_tick, body.to_tick
    timeline = session.timeline if body.timeline is None else body.timeline
    _check_timeline(session, timeline)
    _check(start, stop, ring.first, ring.end)
    memory: MemoryBudget = request.app.state.memory
    with contextlib.ExitStack() as held:
        held.enter_context(memory.hold(_COPIES * 4 * len(session.history.columns) * (stop - start)))
        path = held.enter_context(temporary_folder()) / "samples.npy"

        def save() -> None:
            try:
                np.save(path, ring.read(slice(None), start, stop))
            except IndexError:  # overwritten meanwhile
                _check(start, stop, ring.first, ring.end)

        await asyncio.to_thread(save)
        _check_timeline(session, timeline)  # reset meanwhile
        about = About(_origin(session), body.name, body.note, session.drive)
        answer = await called(request, _keep, str(path), start, scenario, about)
    run: Run = answer.value
    answer.close()
    headers = {"Location": f"/api/v1/runs/{run.id}"}
    return Response(run.model_dump_json(), 201, headers, "application/json")


def _origin(session: Session) -> str:
    """Return the run that a session is recorded as; empty if it is not."""
    return json.loads(session.info())["run"] or ""


def _check_timeline(session: Session, timeline: int) -> None:
    """Refuse ticks of a timeline that a reset has ended."""
    if timeline != session.timeline:
        message = "the session was reset since: the samples of that timeline are gone"
        now = float(session.timeline)
        allowed = {"minimum": now, "maximum": now}
        raise ConfigError(FieldError("timeline", message, timeline, bounds=allowed))


def _check(start: int, stop: int, first: int, end: int) -> None:
    """Refuse ticks that the session no longer holds, or does not yet."""
    wrong = []
    if not first <= start < end:
        bounds: dict[str, float] = {"minimum": first, "exclusive_maximum": end}
        wrong.append(FieldError("from_tick", "is not among those held", start, bounds=bounds))
    if not start < stop <= end:
        bounds = {"exclusive_minimum": start, "maximum": end}
        wrong.append(FieldError("to_tick", "is not among those held", stop, bounds=bounds))
    if wrong:
        raise ConfigError(*wrong)


def _keep(_: Call, path: str, first: int, scenario: Scenario, about: About) -> Run:
    kept = keep_capture(library(), scenario, (first, np.load(Path(path))), about)
    return Run(**{field: getattr(kept, field) for field in Run.model_fields})
