"""Commissioning of drives: its steps, what they found, and the document of it."""

from __future__ import annotations

import asyncio
from typing import Annotated, Literal

from fastapi import APIRouter, Body
from pydantic import BaseModel, Field

from motionlab.drive.commissioning import STEPS, CommissioningRecord, Finding, StepName
from motionlab.service.drives import Drives
from motionlab.service.http.problems import responses
from motionlab.service.http.strict_json import JsonRoute
from motionlab.service.routes.drive import FoundDrives, Token

router = APIRouter(prefix="/drive/commissioning", tags=["drive"], route_class=JsonRoute)


class StepStatus(BaseModel):
    """One step as it stands."""

    name: StepName
    title: str
    task: str
    state: Literal["done", "now", "waiting"]
    finding: Finding | None


class HandStatus(BaseModel):
    """A mover that is being pushed by hand, x and y."""

    moved: list[float] = Field(description="From where it was, m")
    travel: list[float | None] = Field(description="First move that was far enough, m")


class CommissioningStatus(BaseModel):
    """Where commissioning stands."""

    steps: list[StepStatus]
    by_hand: HandStatus | None = Field(description="While encoders are moved by hand")
    record: CommissioningRecord


@router.get("", operation_id="getCommissioning", responses=responses(404))
async def get_commissioning(drives: FoundDrives) -> CommissioningStatus:
    """Return the steps and what they found."""
    return _status(drives)


@router.post(
    "/{step}", operation_id="doCommissioningStep", responses=responses(404, 409, 422, 503, 507)
)
async def do_commissioning_step(
    drives: FoundDrives, step: StepName, lease: Token
) -> CommissioningStatus:
    """Do a step, or do it again; those after it are forgotten. No step here switches torque on."""
    drives.lease.check(lease)
    await drives.do_step(step)
    return _status(drives)


@router.put(
    "",
    operation_id="loadCommissioning",
    responses=responses(400, 404, 409, 413, 415, 422, 503, 507),
)
async def load_commissioning(
    drives: FoundDrives, body: Annotated[CommissioningRecord, Body()], lease: Token
) -> CommissioningStatus:
    """Take a document that was kept; an empty one starts over."""
    drives.lease.check(lease)
    await asyncio.to_thread(drives.commissioning.load, body)
    return _status(drives)


def _status(drives: Drives) -> CommissioningStatus:
    commissioning = drives.commissioning
    present, findings = commissioning.present, commissioning.record.findings
    by_hand = commissioning.by_hand
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
                finding=findings.get(step.name),
            )
            for number, step in enumerate(STEPS)
        ],
        by_hand=by_hand and HandStatus(moved=list(by_hand.moved), travel=by_hand.travel),
        record=commissioning.record,
    )
