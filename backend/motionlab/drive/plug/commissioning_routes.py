"""Commissioning of drives: its steps, what they found, and the document of it."""

from __future__ import annotations

from typing import Annotated, Literal

import tomli_w
from fastapi import APIRouter, Body, Response
from pydantic import BaseModel, ConfigDict, Field

from motionlab.drive.commissioning.record import (
    STEPS,
    CommissioningRecord,
    ConfigChange,
    Finding,
    StepName,
    step_of,
)
from motionlab.drive.plug.drives import Drives, RunningStep
from motionlab.drive.plug.routes import ServedDrives, Token
from motionlab.errors import ConfigError, FieldError
from motionlab.server.http.openapi_input import examples
from motionlab.server.http.problems import responses
from motionlab.server.http.strict_json import JsonRoute

router = APIRouter(prefix="/drive", tags=["drive"], route_class=JsonRoute)


class CommissioningRequest(BaseModel):
    """That the person means it."""

    model_config = ConfigDict(extra="forbid", strict=True) | examples({"confirm": True})

    confirm: bool = Field(
        default=False, description="True: the mover may move from now on; needed with torque"
    )


class StepStatus(BaseModel):
    """One step as it stands."""

    name: StepName
    title: str
    task: str
    state: Literal["done", "now", "waiting"]
    torque: bool = Field(description="Whether it switches torque on, and so needs `confirm`")
    finding: Finding | None


class HandStatus(BaseModel):
    """A mover that is being pushed by hand, x and y."""

    moved: list[float] = Field(description="From where it was, m")
    travel: list[float | None] = Field(description="First move that was far enough, m")


class CommissioningStatus(BaseModel):
    """Where commissioning stands."""

    steps: list[StepStatus]
    by_hand: HandStatus | None = Field(description="While encoders are moved by hand")
    running: RunningStep | None = Field(description="A step that goes on at the moment")
    record: CommissioningRecord
    other_drives: str = Field(
        description="Why `record` is not of the drives that were found, and none of it in effect; "
        "or empty"
    )
    damage: str = Field(
        description="Why the document that was kept was not taken, until another is; or empty"
    )


@router.get("/commissioning", operation_id="getCommissioning", responses=responses(404))
async def get_commissioning(drives: ServedDrives) -> CommissioningStatus:
    """Return the steps and what they found."""
    return _status(drives)


@router.post(
    "/commissioning/{step}",
    operation_id="doCommissioningStep",
    responses=responses(400, 404, 409, 413, 415, 422, 503, 507),
)
async def do_commissioning_step(
    drives: ServedDrives,
    step: StepName,
    lease: Token,
    body: Annotated[CommissioningRequest | None, Body()] = None,
) -> CommissioningStatus:
    """Do a step, or do it again; those after it are forgotten.

    A step with torque begins, and its finding comes later.
    """
    drives.lease.check(lease)
    if step_of(step).torque and not (body and body.confirm):
        raise ConfigError(FieldError("confirm", "this step switches torque on: send true"))
    await drives.do_step(step)
    return _status(drives)


@router.post(
    "/commissioning/{step}/changes",
    operation_id="takeChanges",
    responses=responses(400, 404, 409, 413, 415, 422, 503, 507),
)
async def take_changes(
    drives: ServedDrives,
    step: StepName,
    body: Annotated[
        list[ConfigChange],
        Body(
            min_length=1,
            max_length=64,
            examples=[[{"path": "x.direction", "now": 1.0, "then": -1.0}]],
        ),
    ],
    lease: Token,
) -> CommissioningStatus:
    """Take the changes that a step shows, all of them; the drives are brought up with them."""
    drives.lease.check(lease)
    await drives.take(step, body)
    return _status(drives)


@router.put(
    "/commissioning",
    operation_id="loadCommissioning",
    responses=responses(400, 404, 409, 413, 415, 422, 503, 507),
)
async def load_commissioning(
    drives: ServedDrives, body: Annotated[CommissioningRecord, Body()], lease: Token
) -> CommissioningStatus:
    """Take a document that was kept, unchanged and of these drives; an empty one starts over."""
    drives.lease.check(lease)
    await drives.load_commissioning(body)
    return _status(drives)


@router.get(
    "/configuration",
    operation_id="getDriveConfiguration",
    response_class=Response,
    responses={
        200: {
            "description": "A file for `motionlab serve --drive`; docs/drive.md",
            "content": {"text/plain": {"schema": {"type": "string"}}},
        },
        **responses(404),
    },
)
async def get_drive_configuration(drives: ServedDrives) -> Response:
    """Return the configuration in effect as TOML: the file with the changes that were taken."""
    text = tomli_w.dumps(drives.config.model_dump(mode="json"))
    headers = {"Content-Disposition": 'attachment; filename="drive.toml"'}
    return Response(text, headers=headers, media_type="text/plain; charset=utf-8")


def _status(drives: Drives) -> CommissioningStatus:
    drives.note_serials()
    commissioning = drives.commissioning
    present, findings = commissioning.present, commissioning.findings
    by_hand = commissioning.by_hand
    # Steps before the present one hold, those after it wait for it.
    reached = [step.name for step in STEPS]
    here = len(reached) if present is None else reached.index(present)

    def state(number: int) -> Literal["done", "now", "waiting"]:
        return "done" if number < here else "now" if number == here else "waiting"

    return CommissioningStatus(
        steps=[
            StepStatus(
                name=step.name,
                title=step.title,
                task=step.task,
                state=state(number),
                torque=step.torque,
                finding=findings.get(step.name),
            )
            for number, step in enumerate(STEPS)
        ],
        by_hand=by_hand and HandStatus(moved=list(by_hand.moved), travel=by_hand.travel),
        running=drives.running,
        record=commissioning.record,
        other_drives=commissioning.other_drives,
        damage=commissioning.damage,
    )
