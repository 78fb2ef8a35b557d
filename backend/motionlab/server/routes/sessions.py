"""Live sessions: create, run, change, stop, stream."""

from __future__ import annotations

import functools
from typing import Annotated, Any, Literal

from fastapi import (
    APIRouter,
    Body,
    Depends,
    Header,
    HTTPException,
    Path,
    Request,
    Response,
    WebSocket,
)
from pydantic import BaseModel, ConfigDict, Field

from motionlab.config.changes import SCHEDULABLE
from motionlab.config.planar import AXES
from motionlab.config.quantity import Whole
from motionlab.errors import ConfigError
from motionlab.library.run import Event
from motionlab.reports.problems import fields_of
from motionlab.server.http.openapi_input import ID, PATHS_MAX, Paths, examples, links
from motionlab.server.http.problems import problem, responses
from motionlab.server.http.strict_json import JsonRoute, refuse_unknown
from motionlab.server.live.people import decoded_name
from motionlab.server.live.session import Session
from motionlab.server.live.session_info import SessionInfo
from motionlab.server.live.sessions import Sessions
from motionlab.server.live.stream import Stream, refuse
from motionlab.server.routes.simulate import ChangedScenario, prepare_request
from motionlab.server.settings import Settings

_JSON = "application/json"
router = APIRouter(prefix="/sessions", tags=["sessions"], route_class=JsonRoute)
_OF_A_SESSION = (
    "getSession",
    "deleteSession",
    "play",
    "pause",
    "step",
    "reset",
    "stop",
    "undo",
    "push",
    "changeParameters",
    "getEarlierEvents",
    "getMetrics",
    "getTelemetry",
    "getScenarioFile",
    "keepCapture",
)

SessionId = Annotated[
    str,
    Path(
        json_schema_extra={"pattern": ID},
        description="Identifier of a session",
        examples=["k3Jx_9aQ-mZ1"],
    ),
]


class _Body(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False)


class PlayRequest(_Body):
    """How fast to run."""

    model_config = examples({"speed": 0.5})

    speed: float | None = Field(
        default=None,
        ge=0.1,
        le=10.0,
        description="Simulated time per time; left out: as before",
    )


class StepRequest(_Body):
    """How far to step."""

    model_config = examples({"ticks": 200})

    ticks: Whole = Field(default=1, ge=1, le=20_000, description="Control periods")


class PushRequest(_Body):
    """A push of the mover of every variant."""

    model_config = examples({"axis": "x", "force": 2.0, "duration": 0.05})

    axis: Literal["x", "y"]
    force: float = Field(ge=-100.0, le=100.0, description="N, positive towards positive positions")
    duration: float = Field(default=0.05, gt=0.0, le=10.0, description="s")


class ChangeRequest(_Body):
    """Changes of parameters, all or none."""

    model_config = examples({"set": {"variants.B.controller.x.k_p": 312000.0}})

    set: Annotated[dict[str, Any], Paths(*SCHEDULABLE)] = Field(
        min_length=1, max_length=PATHS_MAX, description="Dotted path to value, SI"
    )


class TickAnswer(BaseModel):
    """From when on something holds."""

    tick: int = Field(description="First tick at which it holds")


async def find_session(request: Request, session_id: SessionId) -> Session:
    """Return a session, or answer 404."""
    # A coroutine: what is none runs in AnyIO's threads, and STOP would wait there for a turn.
    return request.app.state.sessions.find(session_id)


FoundSession = Annotated[Session, Depends(find_session)]
Lease = Annotated[
    str,
    Header(alias="Lease", max_length=64, description="On drives: token of the lease"),
]


async def _person(
    person: Annotated[
        str,
        Header(
            alias="Person",
            description="Percent-encoded name of who acts, as others see it; 40 characters",
            examples=["Anna%20K."],
        ),
    ] = "",
) -> str:
    """Return the name of who acts; empty where none is given."""
    return decoded_name(person)


Actor = Annotated[str, Depends(_person)]


def _info(session: Session, status: int = 200, headers: dict[str, str] | None = None) -> Response:
    return Response(session.info(), status, headers, _JSON)


@router.post(
    "",
    operation_id="createSession",
    status_code=201,
    response_model=SessionInfo,
    responses={
        201: {
            "headers": {"Location": {"schema": {"type": "string"}}},
            "links": links("session_id", *_OF_A_SESSION),
        },
        **responses(400, 413, 415, 422, 429),
    },
)
async def create_session(request: Request, body: Annotated[ChangedScenario, Body()]) -> Response:
    """Create a live session, paused at tick 0; ``{}`` is the circle."""
    sessions: Sessions = request.app.state.sessions
    settings: Settings = request.app.state.settings
    session = await sessions.create(functools.partial(prepare_request, body, settings))
    return _info(session, 201, {"Location": f"/api/v1/sessions/{session.id}"})


@router.get("", operation_id="listSessions", response_model=list[SessionInfo])
async def list_sessions(request: Request) -> Response:
    """List the sessions."""
    infos = [session.info() for session in request.app.state.sessions.all()]
    return Response(f"[{','.join(infos)}]", media_type=_JSON)


@router.get(
    "/{session_id}", operation_id="getSession", response_model=SessionInfo, responses=responses(404)
)
async def get_session(session: FoundSession) -> Response:
    """Return the state of a session."""
    return _info(session)


@router.get(
    "/{session_id}/earlier-events",
    operation_id="getEarlierEvents",
    response_model=list[Event],
    responses=responses(404),
)
async def get_earlier_events(session: FoundSession) -> tuple[Event, ...]:
    """List the latest 200 events before the reset, oldest first; `reset` begins each timeline."""
    return session.events.earlier


@router.delete(
    "/{session_id}", operation_id="deleteSession", status_code=204, responses=responses(404)
)
async def delete_session(request: Request, session: FoundSession) -> Response:
    """End a session."""
    request.app.state.sessions.remove(session)
    return Response(status_code=204)


@router.post(
    "/{session_id}/play",
    operation_id="play",
    response_model=SessionInfo,
    responses=responses(400, 404, 409, 413, 415, 422),
)
async def play(session: FoundSession, by: Actor, body: PlayRequest | None = None) -> Response:
    """Run against the clock."""
    await session.play(None if body is None else body.speed, by)
    return _info(session)


@router.post(
    "/{session_id}/pause",
    operation_id="pause",
    response_model=SessionInfo,
    responses=responses(404, 409),
)
async def pause(session: FoundSession, by: Actor) -> Response:
    """Halt the clock."""
    await session.pause(by)
    return _info(session)


@router.post(
    "/{session_id}/step",
    operation_id="step",
    response_model=SessionInfo,
    responses=responses(400, 404, 409, 413, 415, 422),
)
async def step(session: FoundSession, body: StepRequest | None = None) -> Response:
    """Advance a paused session by some ticks."""
    await session.step(1 if body is None else body.ticks)
    return _info(session)


@router.post(
    "/{session_id}/reset",
    operation_id="reset",
    response_model=SessionInfo,
    responses=responses(404, 409, 422),
)
async def reset(session: FoundSession, by: Actor) -> Response:
    """Go back to tick 0; changes stay."""
    await session.reset(by)
    return _info(session)


@router.post(
    "/{session_id}/stop", operation_id="stop", response_model=SessionInfo, responses=responses(404)
)
async def stop(session: FoundSession, by: Actor) -> Response:
    """Brake to rest, then switch the currents off; only a reset leaves that."""
    session.stop(by)
    return _info(session)


@router.post(
    "/{session_id}/undo",
    operation_id="undo",
    response_model=SessionInfo,
    responses=responses(404, 409, 422),
)
async def undo(session: FoundSession, by: Actor, lease: Lease = "") -> Response:
    """Take back the latest change of parameters."""
    session.authorise(lease)
    await session.undo(by)
    return _info(session)


@router.post(
    "/{session_id}/push", operation_id="push", responses=responses(400, 404, 409, 413, 415, 422)
)
async def push(session: FoundSession, body: PushRequest, by: Actor) -> TickAnswer:
    """Push the mover of every variant."""
    tick = await session.push(AXES.index(body.axis), body.force, body.duration, by)
    return TickAnswer(tick=tick)


@router.patch(
    "/{session_id}/parameters",
    operation_id="changeParameters",
    responses=responses(400, 404, 409, 413, 415, 422),
)
async def change_parameters(
    session: FoundSession, body: ChangeRequest, by: Actor, lease: Lease = ""
) -> TickAnswer:
    """Change parameters at the next tick, all or none; on drives, of the controller that moves."""
    session.authorise(lease)
    return TickAnswer(tick=await session.change(body.set, by))


@router.websocket("/{session_id}/stream")
async def stream(websocket: WebSocket, session_id: str) -> None:
    """Stream a session; docs/stream.md."""
    try:
        refuse_unknown(websocket.query_params)
        session = websocket.app.state.sessions.find(session_id)
    except ConfigError as error:
        answer = problem("invalid-field", str(error), errors=fields_of(error))
        await websocket.send_denial_response(answer)
        return
    except HTTPException as error:
        await refuse(websocket, str(error.detail))
        return
    await Stream(websocket, session).serve()
