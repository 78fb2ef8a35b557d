"""Captures: stretches of a live session, kept as runs."""

from __future__ import annotations

import asyncio
import contextlib
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from fastapi import APIRouter, Body, Request, Response
from pydantic import BaseModel, ConfigDict, Field

from motionlab.config.quantity import Whole
from motionlab.config.scenario import Scenario
from motionlab.errors import ConfigError, FieldError
from motionlab.library.captures import About, keep_capture, recorded_stretch
from motionlab.library.library import library
from motionlab.library.run import LINE, NAME_MAX, TEXT, Run
from motionlab.server.http.download import temporary_folder
from motionlab.server.http.openapi_input import examples, links
from motionlab.server.http.problems import responses
from motionlab.server.http.strict_json import JsonRoute
from motionlab.server.live.session import Session
from motionlab.server.live.session_recorder import SessionRecorder
from motionlab.server.memory_budget import MemoryBudget
from motionlab.server.routes.sessions import FoundSession
from motionlab.server.routes.whatif import ColumnName
from motionlab.server.worker_answers import called
from motionlab.server.workers.worker import Call
from motionlab.telemetry.channels import Channel
from motionlab.telemetry.recording import Recording, as_recording
from motionlab.timing import CONTROL_PERIOD

router = APIRouter(prefix="/sessions", tags=["sessions"], route_class=JsonRoute)

KEPT: dict[int | str, dict[str, Any]] = {
    201: {
        "description": "The run that was kept",
        "headers": {"Location": {"schema": {"type": "string"}}},
        "links": links("run_id", "getRun", "getRunTelemetry", "deleteRun"),
    }
}
"""Of an operation that keeps a run."""
_COPIES = 4
"""Memory for keeping a capture, in sizes of its samples: a copy, a file in memory, two to write."""
_NOTE_MAX = 2000
_COLUMNS_MAX = 4  # as many as a trigger has conditions
_TRIES, _PAUSE = 10, 0.3  # s: until what was just recorded is written


class StretchToKeep(BaseModel):
    """Ticks that become a run, and what triggered there."""

    from_tick: Whole = Field(ge=0, strict=True, description="First tick")
    to_tick: Whole = Field(ge=1, strict=True, description="Tick after the last")
    trigger_tick: Whole | None = Field(
        default=None,
        ge=0,
        strict=True,
        description="Tick at which it was triggered, of these; the first when left out",
    )
    columns: list[ColumnName] = Field(
        default_factory=list,
        max_length=_COLUMNS_MAX,
        description="Channels of the trigger: the capture tells their peaks, besides those of the "
        "following errors",
    )
    name: str = Field(default="", max_length=NAME_MAX, pattern=LINE, description="Of the run")
    note: str = Field(
        default="", max_length=_NOTE_MAX, pattern=TEXT, description="Such as what triggered"
    )


class CaptureRequest(StretchToKeep):
    """A stretch of a session: of its latest 30 s, or of what was recorded before."""

    model_config = ConfigDict(extra="forbid") | examples({"from_tick": 0, "to_tick": 400})

    timeline: Whole | None = Field(
        default=None,
        ge=0,
        strict=True,
        description="The session's timeline that the ticks are of: a reset begins another one, "
        "and what was before is taken from its recording. Without, the newest",
    )
    automatic: bool = Field(
        default=False,
        strict=True,
        description="Kept as it comes, not by a person: evicted when there is no room",
    )


@router.post(
    "/{session_id}/captures",
    operation_id="keepCapture",
    status_code=201,
    response_model=Run,
    responses={**KEPT, **responses(400, 404, 413, 415, 422, 429, 503, 507)},
)
async def keep_session_capture(
    request: Request, session: FoundSession, body: Annotated[CaptureRequest, Body()]
) -> Response:
    """Keep a stretch of a session, 30 s at most, as a run with every channel."""
    ring = session.history.ring
    start, stop = body.from_tick, body.to_tick
    timeline = session.timeline if body.timeline is None else body.timeline
    present = timeline == session.timeline
    if present:
        _check_begun(start, stop, ring.end)
    check_stretch(body, ring.capacity)
    memory: MemoryBudget = request.app.state.memory
    with contextlib.ExitStack() as held:
        held.enter_context(memory.hold(_COPIES * 4 * len(session.history.columns) * (stop - start)))
        record = session.records.get(timeline)
        origin = "" if record is None else record.run or record.kept or ""
        about = About(
            origin,
            body.name,
            body.note,
            session.drive,
            automatic=body.automatic,
            trigger=body.trigger_tick,
            columns=body.columns,
        )
        answer = (
            await _present(request, session, timeline, (start, stop), about) if present else None
        )
        if answer is None:
            answer = await _recorded(request, session, record, (start, stop), about)
    return created(answer)


def created(answer: Any) -> Response:
    """Return the response about a run that a worker has kept."""
    run: Run = answer.value
    answer.close()
    headers = {"Location": f"/api/v1/runs/{run.id}"}
    return Response(run.model_dump_json(), 201, headers, "application/json")


async def _present(
    request: Request, session: Session, timeline: int, ticks: tuple[int, int], about: About
) -> Any:
    """Keep a stretch that the session's ring holds; None if it does not, or no longer."""
    ring, scenario = session.history.ring, session.simulation.scenario
    with temporary_folder() as folder:
        path = folder / "samples.npy"

        def save() -> bool:
            try:
                samples = ring.read(slice(None), *ticks)
            except IndexError:  # overwritten since
                return False
            np.save(path, samples)
            return session.timeline == timeline  # or they may be of another

        if not await asyncio.to_thread(save):
            return None
        states = session.history.states
        return await called(request, _keep, str(path), ticks[0], states, scenario, about)


async def _recorded(
    request: Request,
    session: Session,
    record: SessionRecorder | None,
    ticks: tuple[int, int],
    about: About,
) -> Any:
    """Keep a stretch of what was recorded, once all of it is written."""
    if about.origin and record is not None:
        for _ in range(_TRIES):
            record.advanced(flush=True)
            answer = await called(request, _keep_recorded, ticks, about)
            if answer.value is not None:
                return answer
            answer.close()
            await asyncio.sleep(_PAUSE)
    first, end = session.history.ring.first, session.history.ring.end
    held = f"{first * CONTROL_PERIOD:.6g} to {end * CONTROL_PERIOD:.6g} s"
    start, stop = (f"{tick * CONTROL_PERIOD:.6g}" for tick in ticks)
    message = (
        f"the samples of {start} to {stop} s are gone: the session holds {held}, and they were not "
        "recorded"
    )
    bounds: dict[str, float] = {"minimum": first, "exclusive_maximum": end}
    raise ConfigError(FieldError("from_tick", message, ticks[0], bounds=bounds))


def _check_begun(start: int, stop: int, end: int) -> None:
    """Refuse ticks that the session has not reached."""
    wrong = []
    if start >= end:
        bounds: dict[str, float] = {"exclusive_maximum": end}
        wrong.append(
            FieldError("from_tick", "the session has not come so far", start, bounds=bounds)
        )
    if stop > end:
        bounds = {"maximum": end}
        wrong.append(FieldError("to_tick", "the session has not come so far", stop, bounds=bounds))
    if wrong:
        raise ConfigError(*wrong)


def check_stretch(body: StretchToKeep, most: int) -> None:
    """Refuse ticks that are none, too many, or without the trigger."""
    start, stop, trigger = body.from_tick, body.to_tick, body.trigger_tick
    if not start < stop <= start + most:
        bounds: dict[str, float] = {"exclusive_minimum": start, "maximum": start + most}
        message = "is not behind the first tick, or more than 30 s behind it"
        raise ConfigError(FieldError("to_tick", message, stop, bounds=bounds))
    if trigger is not None and not start <= trigger < stop:
        bounds = {"minimum": start, "exclusive_maximum": stop}
        raise ConfigError(FieldError("trigger_tick", "is not captured", trigger, bounds=bounds))


def _keep(
    _: Call,
    path: str,
    first: int,
    states: list[tuple[str, Channel]],
    scenario: Scenario,
    about: About,
) -> Run:
    recording = as_recording(first, np.load(Path(path)), _none(scenario), states=states)
    return kept_as_run(scenario, recording, about)


def _keep_recorded(_: Call, ticks: tuple[int, int], about: About) -> Run | None:
    stretch = recorded_stretch(library(), about.origin, *ticks)
    if stretch is None:
        return None
    scenario, samples, states = stretch
    recording = as_recording(ticks[0], samples, _none(scenario), states=states)
    return kept_as_run(scenario, recording, about)


def _none(scenario: Scenario) -> dict[str, int | None]:
    """Return the ticks at which variants diverged: not known of a stretch."""
    return dict.fromkeys(scenario.variants)


def kept_as_run(scenario: Scenario, recording: Recording, about: About) -> Run:
    """Keep a stretch and return its run, as lists show it."""
    kept = keep_capture(library(), scenario, recording, about)
    return Run(**{field: getattr(kept, field) for field in Run.model_fields})
