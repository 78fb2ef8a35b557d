"""Request and document of sensitivities."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field

from motionlab.config.quantity import Config, quantity
from motionlab.declarations import OURS

FIELDS_MAX = 1000


class SensitivityRequest(Config):
    """A scenario, and by how much its numbers are changed."""

    scenario: str | dict[str, Any] = Field(
        default="circle", description="Name of a shipped scenario, or its tables"
    )
    set: dict[str, Any] = Field(
        default_factory=dict, max_length=4096, description="Dotted path to value, SI"
    )
    step: float = quantity(
        "Change of each number, down and up, as a share of it",
        unit="1",
        source=OURS,
        default=0.01,
        ge=1e-4,
        le=0.5,
    )
    fields: Annotated[tuple[str, ...], Field(strict=False)] = Field(
        default=(),
        max_length=FIELDS_MAX,
        description="Dotted paths of numbers, or of tables for all numbers in them; empty for all",
    )
    margins: bool = Field(
        default=False, description="Also of gain and phase margins, which takes 20 ms a field"
    )


class _Document(BaseModel):
    model_config = ConfigDict(extra="forbid")


class ChangedField(_Document):
    """A number of the scenario, and what it was changed to."""

    path: str
    unit: str = Field(description="SI")
    value: float
    low: float | None = Field(description="null where the scenario refuses it")
    high: float | None = Field(description="As low")


class LeftField(_Document):
    """A number that was not changed."""

    path: str
    why: str


class FieldEffect(_Document):
    """One metric over all changes; null where a variant diverged or the metric does not apply."""

    base: float | None = Field(description="Without a change")
    low: list[float | None] = Field(description="With each field at its low value")
    high: list[float | None] = Field(description="With each field at its high value")
    slope: list[float | None] = Field(
        description="d(metric)/d(field) by central difference, of one side where there is one "
        "alone; in SI units of metric and field"
    )


class SensitivityDocument(_Document):
    """How the metrics of a scenario change with each of its numbers."""

    scenario: str
    plant: str
    seed: int
    version: str = Field(repr=False)
    model: str = Field(description="Hash of the model's sources", repr=False)
    step: float
    fields: list[ChangedField]
    left: list[LeftField] = Field(description="Numbers left out, such as zeros")
    variants: dict[str, dict[str, dict[str, FieldEffect]]] = Field(
        description="By variant, axis and metric"
    )
