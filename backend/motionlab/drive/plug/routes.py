"""The drive link: state, lease, arming, stop."""

from __future__ import annotations

from typing import Annotated, Literal

from fastapi import APIRouter, Body, Depends, Header, Query, Request, Response
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field
from pydantic_core import PydanticKnownError

from motionlab.config.load import load_scenario
from motionlab.drive.lease import SECONDS, NotHeld
from motionlab.drive.link.carrier import LinkError
from motionlab.drive.link.shared import Order
from motionlab.drive.motion import on_drives
from motionlab.drive.plug.drives import Drives
from motionlab.drive.plug.session import create_session
from motionlab.drive.plug.status import DriveStatus
from motionlab.reports.plain_text import NAME_PATTERN
from motionlab.server.http.openapi_input import examples
from motionlab.server.http.problems import responses
from motionlab.server.http.strict_json import JsonRoute
from motionlab.server.live.session_info import SessionInfo
from motionlab.server.live.sessions import Sessions
from motionlab.server.routes.simulate import ChangedScenario, prepare_request
from motionlab.server.settings import Settings
from motionlab.simulation.prepare import Prepared

router = APIRouter(prefix="/drive", tags=["drive"], route_class=JsonRoute)

Token = Annotated[
    str,
    Header(
        alias="Lease",
        max_length=64,
        description="Token of the lease, from takeControl",
        examples=["q0zYg1Vv5xkPjQ2m"],
    ),
]


class LeaseRequest(BaseModel):
    """Who takes control."""

    model_config = ConfigDict(extra="forbid", strict=True) | examples({"holder": "script"})

    holder: str = Field(
        min_length=1, max_length=40, pattern=NAME_PATTERN, description="Name that others see"
    )


class LeaseAnswer(BaseModel):
    """A lease."""

    lease: str = Field(description="Token, for the header Lease of every command")
    seconds: float = Field(description="Time without a heartbeat after which it ends, s")


class MotionRequest(ChangedScenario):
    """A scenario and one of its variants."""

    model_config = examples({"scenario": "circle", "variant": "B"})

    variant: str | None = Field(
        default=None, pattern="^[A-Z]$", description="Which variant; the only one when left out"
    )


def _true(value: object) -> object:
    """Refuse what only equals true, such as 1."""
    if value is not True:
        raise PydanticKnownError("literal_error", {"expected": "True"})
    return value


class ArmRequest(MotionRequest):
    """Whose gains hold the position, and that the person means it."""

    model_config = examples({"scenario": "circle", "variant": "A", "confirm": True})

    confirm: Annotated[Literal[True], BeforeValidator(_true)] = Field(
        description="True: the mover may move from now on"
    )


async def drives_of(request: Request) -> Drives:
    """Return the drives of the server."""  # a coroutine, as `find_session`
    return request.app.state.drives


ServedDrives = Annotated[Drives, Depends(drives_of)]


@router.get("", operation_id="getDrive", responses=responses(404))
async def get_drive(drives: ServedDrives) -> DriveStatus:
    """Return the state of the link, its drives and its loop."""
    return drives.status()


@router.post(
    "/lease",
    operation_id="takeControl",
    status_code=201,
    responses=responses(400, 404, 409, 413, 415, 422),
)
async def take_control(drives: ServedDrives, body: Annotated[LeaseRequest, Body()]) -> LeaseAnswer:
    """Take the lease: only its holder may move the drives. It ends without a heartbeat."""
    return LeaseAnswer(lease=drives.lease.take(body.holder), seconds=SECONDS)


@router.put(
    "/lease", operation_id="keepControl", status_code=204, responses=responses(404, 409, 422)
)
async def keep_control(drives: ServedDrives, lease: Token) -> Response:
    """Keep the lease: its heartbeat."""
    drives.lease.renew(lease)
    return Response(status_code=204)


@router.delete(
    "/lease", operation_id="giveUpControl", status_code=204, responses=responses(404, 409, 422)
)
async def give_up_control(drives: ServedDrives, lease: Token) -> Response:
    """Give the lease up; armed drives are stopped and disarmed first."""
    drives.give_up(lease)
    return Response(status_code=204)


@router.post(
    "/lease/request",
    operation_id="askForControl",
    status_code=204,
    responses=responses(400, 404, 409, 413, 415, 422),
)
async def ask_for_control(drives: ServedDrives, body: Annotated[LeaseRequest, Body()]) -> Response:
    """Let the holder of the lease know who would like it; it stays with the holder."""
    drives.lease.ask(body.holder)
    return Response(status_code=204)


@router.post("/arm", operation_id="arm", responses=responses(400, 404, 409, 413, 415, 422))
async def arm(
    drives: ServedDrives, body: Annotated[ArmRequest, Body()], lease: Token
) -> DriveStatus:
    """Switch the torque on and hold the present position."""
    await drives.arm(lambda: load_scenario(body.scenario, body.set), body.variant, lease)
    return drives.status()


@router.post(
    "/motions",
    operation_id="beginMotion",
    status_code=201,
    response_model=SessionInfo,
    responses=responses(400, 404, 409, 413, 415, 422, 429),
)
async def begin_motion(
    request: Request, drives: ServedDrives, body: Annotated[MotionRequest, Body()], lease: Token
) -> Response:
    """Begin a motion of armed drives; it is a live session, recorded as a run."""
    drives.lease.check(lease)
    drives.check_free()
    stops = drives.link.stops
    settings: Settings = request.app.state.settings
    sessions: Sessions = request.app.state.sessions

    def prepare() -> Prepared:
        return prepare_request(body, settings, lambda scenario: on_drives(scenario, body.variant))

    session = await create_session(sessions, drives, prepare)
    try:
        drives.lease.check(lease)  # preparing takes its time
        with drives.ordering():
            await session.begin(stops)
    except (LinkError, NotHeld):
        sessions.remove(session)
        raise
    headers = {"Location": f"/api/v1/sessions/{session.id}"}
    return Response(session.info(), 201, headers, "application/json")


@router.post("/disarm", operation_id="disarm", responses=responses(404, 409, 422))
async def disarm(drives: ServedDrives, lease: Token) -> DriveStatus:
    """Switch the torque off at once."""
    await drives.order(Order.DISARM, lease)
    return drives.status()


@router.post("/reset", operation_id="resetFault", responses=responses(404, 409, 422))
async def reset(drives: ServedDrives, lease: Token) -> DriveStatus:
    """Clear a latched fault, or bring the drives up again; never arms."""
    await drives.reset(lease)
    return drives.status()


@router.post("/stop", operation_id="stopDrive", responses=responses(404))
async def stop(
    drives: ServedDrives,
    by: Annotated[str, Query(description="Name that others see as who stopped")] = "",
) -> DriveStatus:
    """Brake to rest, then switch the torque off; anyone may, without the lease."""
    drives.note_stop("STOP", by)
    drives.stop()
    return drives.status()
