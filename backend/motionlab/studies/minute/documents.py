"""Request and result of a recorded stretch under another controller."""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel, ConfigDict, Field

from motionlab.config.quantity import si
from motionlab.config.scenario import VariantName
from motionlab.library.run import ID
from motionlab.studies.record.part import PartOptions

SECONDS_MIN, SECONDS_MAX = 3.0, 300.0
"""Shortest and longest stretch, s."""


class MinuteRequest(PartOptions):
    """A stretch of a run, and the controller that it did not have."""

    run: str = Field(pattern=ID, description="Identifier of a kept run")
    variant: VariantName | None = Field(
        default=None, description="Whose record is read; null: the first of the run"
    )
    other: VariantName | None = Field(
        default=None,
        description="Whose controller is tried; null: the second variant of the scenario, or the "
        "first where there is one only",
    )
    set: dict[str, Any] = Field(
        default_factory=dict,
        max_length=4096,
        description="Changes of the run's scenario for the controller that is tried: dotted path "
        "to value, SI",
    )
    members: int = Field(
        default=24, ge=8, le=200, description="Motors within the fit's errors that are simulated"
    )
    seed: int = Field(default=0, ge=0, le=2**53 - 1, description="Of the motors and their noise")


class _Document(BaseModel):
    model_config = ConfigDict(extra="forbid")


class MotorEstimate(_Document):
    """A number of the motor as the controller's newtons have it, fitted to the record."""

    value: float
    low: float = Field(description="Of the 95 % interval")
    high: float
    believed: float = Field(description="The controller's model, which is the prior")
    unit: str


class PredictedError(_Document):
    """A metric of the other controller."""

    value: float = si("Median of the members", "m")
    low: float = si("Of the 95 % interval", "m")
    high: float = si("The same", "m")


class MinuteErrors(_Document):
    """Following errors, m, at the instants `time`: those where the prediction is extreme."""

    time: list[float] = Field(repr=False, description="From the first sample of the run on, s")
    recorded: list[float] = Field(repr=False)
    again: list[float] = Field(
        repr=False, description="Of the recorded controller, simulated: how good the motor is"
    )
    predicted: list[float] = Field(repr=False, description="Of the other controller")
    low: list[float] = Field(repr=False, description="Of the 95 % band, at each instant")
    high: list[float] = Field(repr=False)


class MinuteAxis(_Document):
    """One axis."""

    reversals: int
    max_recorded: float = si("Largest recorded following error", "m")
    rms_recorded: float = si("Its root mean square", "m")
    miss: float = si("RMS by which the recorded controller, simulated, misses its record", "m")
    max_predicted: PredictedError
    rms_predicted: PredictedError
    disturbance: float = si("RMS of the disturbance that the stretch had", "N")
    motor: dict[str, MotorEstimate] = Field(description="M, f_0, and LuGre's by name")
    errors: MinuteErrors


class MinuteDocument(_Document):
    """What another controller would have done in a recorded stretch."""

    run: str
    name: str = Field(description="Of the run")
    variant: str
    label: str = Field(description="Of the controller that was recorded")
    other: str
    other_label: str = Field(description="Of the controller that is tried")
    start: float = si("First instant that metrics are of", "s")
    end: float = si("Last one", "s")
    members: int
    diverged: int = Field(description="Members in which the other controller diverges")
    axes: dict[str, MinuteAxis] = Field(description="Of the axes that move and reverse")
    warnings: list[str]
    version: str
    model: str = Field(repr=False, description="Hash of the model's sources")
