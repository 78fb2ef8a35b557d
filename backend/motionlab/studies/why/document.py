"""The document of an explained peak."""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel, Field


class Cause(BaseModel):
    """A cause, and what the peak is without it."""

    id: str = Field(description="Which cause; docs/why.md")
    label: str = Field(description="Its name for people")
    meaning: str = Field(description="What was taken away, and how")
    error: float | None = Field(
        description="Largest error about the peak without it, m; null where the run diverged"
    )
    share: float | None = Field(
        description="1 - error/peak: share of the peak that goes with it; below 0 it helps"
    )
    set: dict[str, Any] = Field(description="Dotted path to value: how it was taken away")


class Absent(BaseModel):
    """A cause that this scenario does not have."""

    id: str
    label: str


class Mend(BaseModel):
    """The smallest change found that reaches the goal within the margins."""

    label: str = Field(description="What is changed, for people")
    set: dict[str, Any] = Field(description="Dotted path to value")
    factor: float | None = Field(
        description="By which a number of the controller is multiplied; null for a switch"
    )
    eased: bool = Field(
        description="Whether a margin stays beyond its limit, where it is now, and gets no worse"
    )
    error: float = Field(description="Largest error about the peak with it, m")
    window_error: float = Field(description="Largest error over the metrics window with it, m")
    gain_margin: float | None = Field(description="Worst gain margin with it, as a factor")
    phase_margin: float | None = Field(description="Worst phase margin with it, rad")
    Ms: float | None = Field(description="Worst peak of the sensitivity with it")


class WhyDocument(BaseModel):
    """Why a following error peaks, and what would mend it."""

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
    mend: Mend | None = Field(description="null where no change that was tried mends it")
    why_not: str = Field(description="Why there is none; empty where there is one")
    tried: int = Field(description="Changes that were simulated")
    reached: int = Field(description="Changes that reach the goal, whatever their margins")
    notes: list[str]
