"""Requests of an explanation of an error peak."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

from pydantic import Field

from motionlab.config.quantity import OURS, Config, quantity
from motionlab.config.scenario import VariantName
from motionlab.config.validation_errors import checked
from motionlab.studies.tune.request import Constraints


class MarginLimits(Config):
    """Limits that a mended loop holds; null disables one. The defaults are those of a search."""

    gain_margin: float | None = quantity(
        "Least factor by which the loop's gain may grow, or fall, to the stability boundary",
        unit="1",
        source=OURS,
        default=Constraints().gain_margin,
        gt=1,
        le=100,
    )
    phase_margin: float | None = quantity(
        "Least phase margin, at standstill and from 0.5 to 4 Stribeck velocities",
        shown="°",
        unit="rad",
        source=OURS,
        default=Constraints().phase_margin,
        gt=0,
        lt=3.1416,
    )
    Ms: float | None = quantity(
        "Largest peak of the sensitivity 1/(1 + L)",
        label="M_s",
        unit="1",
        source=OURS,
        default=Constraints().Ms,
        gt=1,
        le=100,
    )


class WhyRequest(Config):
    """A peak of the following error, and what counts as mended."""

    scenario: str | dict[str, Any] = Field(
        default="circle", description="Name of a shipped scenario, or its tables"
    )
    set: dict[str, Any] = Field(
        default_factory=dict, max_length=4096, description="Dotted path to value, SI"
    )
    variant: VariantName | None = Field(
        default=None,
        title="controller",
        description="Whose error; left out: the second variant, or the only one",
    )
    axis: Literal["x", "y"] | None = Field(
        default=None, description="Axis; left out: the one on which the error is largest"
    )
    time: float | None = quantity(
        "A moment near the peak, of a motion that repeats in any of its laps; left out: that of "
        "the largest error in the metrics window",
        unit="s",
        source=OURS,
        default=None,
        ge=0,
        le=3600,
    )
    goal: float | None = quantity(
        "Error that is to be reached, here and over the metrics window; left out: half the peak",
        unit="m",
        source=OURS,
        default=None,
        gt=0,
        le=1,
    )
    limits: MarginLimits = Field(default=MarginLimits(), description="Margins that a change keeps")


def read_request(request: Mapping[str, Any]) -> WhyRequest:
    """Return a request, checked; raise ConfigError naming every field that is wrong."""
    return checked(WhyRequest, request, "why")
