"""Document of a sweep."""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel, ConfigDict, Field


class _Document(BaseModel):
    model_config = ConfigDict(extra="forbid")


class SweptField(_Document):
    """One swept field."""

    path: str
    unit: str = Field(description="SI; empty for names and switches")
    values: list[Any]


class SweptAxis(_Document):
    """One axis of one variant over all cases."""

    metrics: dict[str, list[float | None]] = Field(
        description="Metrics of a run by name, SI, one value a case; null where the case has none"
    )


class SweptVariant(_Document):
    """One variant over all cases."""

    label: str
    diverged: list[int] = Field(description="Cases in which it diverged")
    axes: dict[str, SweptAxis]


class Best(_Document):
    """Case with the smallest value of a metric."""

    variant: str
    axis: str
    metric: str
    case: int
    value: float
    set: dict[str, Any] = Field(description="Changes that make the case")


class SweptFigure(_Document):
    """An objective over all cases."""

    of: str = Field(description="Metric as VARIANT.AXIS.METRIC")
    unit: str = Field(description="SI")
    falls: bool = Field(description="Whether less is better")
    values: list[float | None] = Field(description="One a case; null where the case has none")


class SweptLimit(_Document):
    """What a case has to meet."""

    of: str = Field(description="Metric as VARIANT.AXIS.METRIC")
    unit: str = Field(description="SI")
    at_least: float | None
    at_most: float | None
    exceeded: list[int] = Field(description="Cases that do not meet it")


class PartialSweep(_Document):
    """Metrics of the first cases of a sweep; null for the others."""

    done: int = Field(description="Cases that have run")
    variants: dict[str, SweptVariant]


class SweepDocument(_Document):
    """Metrics of a scenario over a grid or a list of values of its fields."""

    scenario: str
    plant: str
    seed: int
    version: str = Field(repr=False)
    model: str = Field(description="Hash of the model's sources", repr=False)
    fields: list[SweptField]
    shape: list[int] = Field(
        description="Values along each dimension; cases are in row-major order, all but a grid "
        "have one"
    )
    cases: int
    infeasible: list[int] = Field(description="Cases whose motor cannot follow the motion")
    variants: dict[str, SweptVariant]
    best: list[Best]
    objectives: list[SweptFigure] = Field(description="What cases are compared by, if anything")
    limits: list[SweptLimit] = Field(description="What cases have to meet, if anything")
    front: list[int] = Field(
        description="Cases within all limits that no other one betters in every objective, by the "
        "first objective; with one objective the best case; none without objectives"
    )
