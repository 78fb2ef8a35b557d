"""Motors: their tables, and where the numbers of one's own come from."""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel, ConfigDict, Field

from motionlab.config.includes import resolve
from motionlab.config.named_configs import ORIGIN, is_name, names, read
from motionlab.config.plant import PlantConfig
from motionlab.config.validation_errors import checked
from motionlab.errors import ConfigError, FieldError
from motionlab.library.named_documents import TomlDocuments

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
        repr=False,
        max_length=_FITS_MAX,
        description="By dotted path into the motor, such as x.friction.F_c",
    )
    residual: dict[str, Residual] | None = Field(
        default=None, description="By axis; null of a run without scenario, a measurement"
    )
    notes: list[str] = Field(default=[], description="What the fit does not hold")


class Motor(_Document):
    """A motor and its origin."""

    plant: dict[str, Any] = Field(
        description="Tables of the motor, as a scenario has them", repr=False
    )
    origin: MotorOrigin | None = Field(default=None, description="null of one that was typed")


class MotorEntry(BaseModel):
    """One motor."""

    name: str = Field(description="Name, as `plant` of a scenario takes it")
    shipped: bool = Field(description="Whether it ships with the project and cannot be changed")
    description: str


class KeptMotor(MotorEntry, Motor):
    """A motor with its numbers and where they come from."""


class Motors(TomlDocuments[MotorEntry, KeptMotor]):
    """Motors that ship, and motors of one's own; scenarios name them as `plant`."""

    def __init__(self) -> None:
        super().__init__("motors", "motor")

    def entry(self, name: str, *, shipped: bool) -> MotorEntry:
        """Return name and description of a motor."""
        return MotorEntry(name=name, shipped=shipped, description=description_of(name))

    def get(self, name: str) -> KeptMotor:
        """Return a motor, every name resolved and every field given."""
        if self.is_shipped(name):
            return self._kept(name, Motor(plant=resolve({"plant": name})["plant"]))
        tables = self.read(name)
        origin = tables.pop(ORIGIN, None)
        plant = _plant(name, tables, f"motor {name}").model_dump(mode="json")
        fitted = None if origin is None else checked(MotorOrigin, origin, "origin")
        return self._kept(name, Motor(plant=plant, origin=fitted))

    def put(self, name: str, motor: Motor) -> KeptMotor:
        """Save a motor, whose plant may name a ``base``, in the place of the one of its name."""
        self.check_own(name)
        plant = _plant(name, motor.plant, "plant").model_dump(mode="json", exclude_none=True)
        origin = motor.model_dump(mode="json", exclude_none=True, include={ORIGIN})
        self.write(name, {key: plant[key] for key in plant if key != "name"} | origin)
        return self._kept(name, Motor(plant=plant, origin=motor.origin))

    def _kept(self, name: str, motor: Motor) -> KeptMotor:
        return KeptMotor(
            name=name,
            shipped=self.is_shipped(name),
            description=str(motor.plant.get("description", "")),
            plant=motor.plant,
            origin=motor.origin,
        )


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


def description_of(name: str) -> str:
    """Return what a motor stands for; of a damaged file what is wrong with it."""
    try:
        return str(read("motors", name, loc="motor").get("description", ""))
    except (ConfigError, OSError) as error:  # also one deleted since this instant
        return f"cannot be read: {error}"


def _plant(name: str, tables: dict[str, Any], loc: str) -> PlantConfig:
    return checked(PlantConfig, resolve({"plant": tables | {"name": name}})["plant"], loc)
