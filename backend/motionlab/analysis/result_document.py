"""The result document as a pydantic model, for OpenAPI."""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel, ConfigDict, Field, create_model

from motionlab.analysis.metrics import CONTOUR_DEFINITIONS, DEFINITIONS, Definition
from motionlab.analysis.variant_comparison import RATIOS


class _Document(BaseModel):
    model_config = ConfigDict(extra="forbid")


def _metrics(name: str, doc: str, definitions: dict[str, Definition]) -> type[BaseModel]:
    """Return a model with a nullable number for each metric."""
    fields: dict[str, Any] = {
        metric: (
            float | None,
            Field(description=definition.meaning, json_schema_extra={"unit": definition.unit}),
        )
        for metric, definition in definitions.items()
    }
    return create_model(name, __doc__=doc, __base__=_Document, **fields)


AxisMetrics = _metrics("AxisMetrics", "Metrics of one axis over a window.", DEFINITIONS)
ContourMetrics = _metrics("ContourMetrics", "Distance from the path.", CONTOUR_DEFINITIONS)
AxisComparison = _metrics(
    "AxisComparison",
    "The second variant over the first; null where one is missing or the first is 0.",
    {f"{metric}_ratio": Definition("1", f"ratio of {metric}", "B/A") for metric in RATIOS},
)


class DivergenceRecord(_Document):
    """Time and channel of a divergence."""

    time: float = Field(description="First instant not to be trusted, s")
    channel: str = Field(description="Axis and channel that failed")
    last_states: list[dict[str, float | str]] = Field(description="Samples of the last ticks")


class MapRecord(_Document):
    """A force map that a run used."""

    name: str
    content_hash: str = Field(description="Of geometry, preset and method")
    digest: str = Field(description="Of the numbers themselves")


class VariantMetrics(_Document):
    """Metrics of one variant; all null where it diverged."""

    axes: dict[str, AxisMetrics]  # pyright: ignore[reportInvalidTypeForm]
    contour: ContourMetrics  # pyright: ignore[reportInvalidTypeForm]


class VariantResult(VariantMetrics):
    """Result of one variant."""

    label: str
    law: str
    enabled: bool = Field(description="Whether its compensation was on at the end of the window")
    diverged: DivergenceRecord | None
    notes: list[str]


class Window(_Document):
    """The part of the run that metrics are taken over."""

    start: float = Field(description="s")
    end: float = Field(description="s")


class WindowMetrics(_Document):
    """Metrics of every variant over one window."""

    window: Window
    variants: dict[str, VariantResult]
    comparison: dict[str, AxisComparison]  # pyright: ignore[reportInvalidTypeForm]


class ResultDocument(WindowMetrics):
    """Result of a run, as printed by ``motionlab run --json``."""

    scenario: str
    seed: int
    plant: str
    plant_description: str
    version: str = Field(repr=False)
    model: str = Field(description="Hash of the model's sources", repr=False)
    maps: dict[str, MapRecord] = Field(description="Tables that stood in for analytic force maps")
    segments: list[WindowMetrics] = Field(description="One for each interval between switches")
    run: str | None = Field(default=None, description="Identifier of the run, where it was kept")
