"""A motor of one's own: its tables, and where its numbers come from."""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel, ConfigDict, Field

from motionlab.config.includes import resolve
from motionlab.config.plant import PlantConfig
from motionlab.config.shipped import ORIGIN, data_root, is_name, names
from motionlab.config.validation_errors import checked
from motionlab.errors import ConfigError, FieldError
from motionlab.library.named_tables import NamedTables

_FITS_MAX = 100


class _Document(BaseModel):
    model_config = ConfigDict(extra="forbid")


class FittedValue(_Document):
    """One number of a motor that was fitted to a run."""

    value: float = Field(description="SI; forces in newtons of the force map beside it")
    low: float = Field(description="Lower end of the 95 % interval")
    high: float = Field(description="Upper end of the 95 % interval")
    before: float = Field(description="Of the motor that it started from")
    unit: str


class Residual(_Document):
    """Following error of the run less that of its simulation, root mean square."""

    before: float = Field(
        description="With the motor that it started from", json_schema_extra={"unit": "m"}
    )
    after: float = Field(description="With the fitted motor", json_schema_extra={"unit": "m"})


class MotorOrigin(_Document):
    """Where the numbers of a fitted motor come from."""

    run: str = Field(description="Run that it was fitted to")
    run_name: str
    recorded: str = Field(description="When the run began, ISO 8601")
    fits: dict[str, FittedValue] = Field(
        max_length=_FITS_MAX, description="By dotted path into the motor, such as x.friction.F_c"
    )
    residual: dict[str, Residual] | None = Field(
        default=None, description="By axis; null of a run without scenario, a measurement"
    )
    notes: list[str] = Field(default=[], description="What the fit does not hold")


class Motor(_Document):
    """A motor and its origin."""

    plant: dict[str, Any] = Field(description="Tables of the motor, as a scenario has them")
    origin: MotorOrigin | None = Field(default=None, description="null of one that was typed")


def motors() -> NamedTables:
    """Return the motors of one's own, files in ``MOTIONLAB_DATA/motors``."""
    return NamedTables(data_root() / "motors", "motors")


def check_name(name: str) -> None:
    """Check that a motor of one's own can have a name.

    Raises
    ------
    ConfigError
        If it is none, or a motor of that name ships.
    """
    if not is_name(name):
        raise ConfigError(FieldError("motor", "is not a name", name, "[a-z0-9-]{1,64}"))
    if name in names("motors"):
        raise ConfigError(FieldError("motor", "ships with the project: take another name", name))


def save_motor(name: str, motor: Motor) -> Motor:
    """Save a motor, in the place of the one of its name; a scenario finds it by that name.

    Parameters
    ----------
    name : str
        ``[a-z0-9-]{1,64}``, of no shipped motor.
    motor : Motor
        Its plant may name a ``base``.

    Returns
    -------
    Motor
        As saved: every name resolved, every field given.

    Raises
    ------
    ConfigError
        If the motor is not valid, or one of that name ships.
    StoreError
        If it cannot be written.
    """
    check_name(name)
    tables = resolve({"plant": motor.plant | {"name": name}})["plant"]
    plant = checked(PlantConfig, tables, "plant").model_dump(mode="json", exclude_none=True)
    origin = motor.model_dump(mode="json", exclude_none=True).get(ORIGIN)
    kept = {key: value for key, value in plant.items() if key != "name"}
    motors().write(name, kept | ({} if origin is None else {ORIGIN: origin}))
    return Motor(plant=plant, origin=motor.origin)


def find_motor(name: str) -> Motor:
    """Return a motor of one's own.

    Raises
    ------
    FileNotFoundError
        If there is none of that name.
    ConfigError
        If its file is damaged.
    """
    tables = motors().read(name)
    origin = tables.pop(ORIGIN, None)
    tables = resolve({"plant": tables | {"name": name}})["plant"]
    plant = checked(PlantConfig, tables, f"motor {name}").model_dump(mode="json")
    return Motor(
        plant=plant, origin=None if origin is None else checked(MotorOrigin, origin, "origin")
    )
