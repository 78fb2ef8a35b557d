"""Motors: those that ship, and those of one's own, which scenarios find by name."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Body, HTTPException, Path, Response
from pydantic import BaseModel, Field

from motionlab.config.includes import resolve
from motionlab.config.shipped import names, own_motors, read
from motionlab.errors import ConfigError, Shipped
from motionlab.library.motors import Motor, find_motor, motors, save_motor
from motionlab.server.http.problems import responses
from motionlab.server.http.strict_json import JsonRoute

router = APIRouter(prefix="/motors", tags=["motors"], route_class=JsonRoute)

Name = Annotated[
    str, Path(pattern="^[a-z0-9-]{1,64}$", description="Name of a motor", examples=["nominal"])
]
_EXAMPLE = {"plant": {"base": "nominal", "x": {"mass": 6.1}}}


class MotorEntry(BaseModel):
    """One motor."""

    name: str = Field(description="Name, as `plant` of a scenario takes it")
    shipped: bool = Field(description="Whether it ships with the project and cannot be changed")
    description: str


class KeptMotor(MotorEntry, Motor):
    """A motor with its numbers and where they come from."""


@router.get("", operation_id="listMotors", responses=responses(422))
def list_motors() -> list[MotorEntry]:
    """List the motors that ship and those of one's own."""
    shipped = [_entry(name, shipped=True) for name in names("motors")]
    return shipped + [_entry(name, shipped=False) for name in own_motors()]


@router.get("/{name}", operation_id="getMotor", responses=responses(404, 422))
def get_motor(name: Name) -> KeptMotor:
    """Return a motor by name, every field given."""
    if name in names("motors"):
        plant = resolve({"plant": name})["plant"]
        return _kept(name, Motor(plant=plant), shipped=True)
    try:
        return _kept(name, find_motor(name), shipped=False)
    except FileNotFoundError:
        raise HTTPException(404, f"no motor {name!r}") from None


@router.put(
    "/{name}", operation_id="putMotor", responses=responses(400, 409, 413, 415, 422, 503, 507)
)
def put_motor(name: Name, body: Annotated[Motor, Body(examples=[_EXAMPLE])]) -> KeptMotor:
    """Save or replace a motor of one's own, such as `motor` of an identification from a run."""
    _refuse_shipped(name)
    return _kept(name, save_motor(name, body), shipped=False)


@router.delete(
    "/{name}", operation_id="deleteMotor", status_code=204, responses=responses(404, 409, 422, 503)
)
def delete_motor(name: Name) -> Response:
    """Delete a motor of one's own; scenarios and runs that have it keep its numbers."""
    _refuse_shipped(name)
    if not motors().delete(name):
        raise HTTPException(404, f"no motor {name!r}")
    return Response(status_code=204)


def _entry(name: str, *, shipped: bool) -> MotorEntry:
    return MotorEntry(name=name, shipped=shipped, description=description_of(name))


def description_of(name: str) -> str:
    """Return what a motor stands for; of a damaged file what is wrong with it."""
    try:
        return str(read("motors", name, loc="motor").get("description", ""))
    except (ConfigError, OSError) as error:  # also one deleted since this instant
        return f"cannot be read: {error}"


def _kept(name: str, motor: Motor, *, shipped: bool) -> KeptMotor:
    description = str(motor.plant.get("description", ""))
    return KeptMotor(
        name=name,
        shipped=shipped,
        description=description,
        plant=motor.plant,
        origin=motor.origin,
    )


def _refuse_shipped(name: str) -> None:
    if name in names("motors"):
        raise Shipped(f"{name!r} ships with the project and cannot be changed")
