"""Request, document and text report of an explained error peak."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, Literal

from pydantic import BaseModel, Field

from motionlab.config.quantity import Config, quantity, si
from motionlab.config.scenario import VariantName
from motionlab.config.validation_errors import checked
from motionlab.declarations import OURS
from motionlab.studies.tune.documents import Constraints


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
        shown="µm",
        source=OURS,
        default=None,
        gt=0,
        le=1,
    )
    limits: MarginLimits = Field(default=MarginLimits(), description="Margins that a change keeps")


def read_request(request: Mapping[str, Any]) -> WhyRequest:
    """Return a request, checked; raise ConfigError naming every field that is wrong."""
    return checked(WhyRequest, request, "why")


class Cause(BaseModel):
    """A cause, and what the peak is without it."""

    labels: ClassVar[dict[str, str]] = {"label": "without"}

    id: str = Field(description="Which cause; docs/why.md", repr=False)
    label: str = Field(description="Its name for people")
    meaning: str = Field(description="What was taken away, and how")
    error: float | None = Field(
        description="Largest error about the peak without it, m; null where the run diverged"
    )
    share: float | None = si(
        "1 - error/peak: share of the peak that goes with it; below 0 it helps", "1", "%"
    )
    set: dict[str, Any] = Field(
        description="Dotted path to value: how it was taken away", repr=False
    )


class Absent(BaseModel):
    """A cause that this scenario does not have."""

    id: str = Field(repr=False)
    label: str


class Mend(BaseModel):
    """The change that is offered: the smallest that reaches the goal within the margins, if any."""

    reaches: bool = Field(
        description="Whether it reaches the goal; else it comes nearest and makes no margin worse"
    )
    label: str = Field(description="What is changed, for people")
    set: dict[str, Any] = Field(description="Dotted path to value")
    factor: float | None = Field(
        description="By which a number of the controller is multiplied; null for a switch, and for "
        "two changes together"
    )
    eased: bool = Field(
        description="Whether a margin stays beyond its limit, where it is now, and gets no worse"
    )
    error: float = Field(description="Largest error about the peak with it, m")
    window_error: float = Field(description="Largest error over the metrics window with it, m")
    gain_margin: float | None = Field(description="Worst gain margin with it, as a factor")
    phase_margin: float | None = si("Worst phase margin with it", "rad", "deg")
    Ms: float | None = Field(description="Worst peak of the sensitivity with it")


class WhyDocument(BaseModel):
    """Why a following error peaks, and what would mend it."""

    labels: ClassVar[dict[str, str]] = {"absent": "not there"}

    scenario: str
    variant: str
    axis: str
    time: float = Field(description="Of the peak, s")
    period: float | None = Field(
        description="After which the motion repeats, s; null of one that ends"
    )
    window: tuple[float, float] = Field(description="Errors about the peak are taken here, s")
    peak: float = Field(description="Largest error there now, m")
    window_peak: float | None = Field(
        description="Largest error over the metrics window now, m; null where the run diverges"
    )
    goal: float = Field(description="Error that counts as mended, m")
    causes: list[Cause] = Field(description="Largest share first")
    absent: list[Absent] = Field(description="Causes that are not there")
    mend: Mend | None = Field(description="null where no change that was tried makes it smaller")
    why_not: str = Field(description="Why none reaches the goal; empty where one does")
    tried: int = Field(description="Changes that were simulated")
    reached: int = Field(description="Changes that reach the goal, whatever their margins")
    notes: list[str]
