"""The answer of a comparison: a verdict for each channel."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, Field

from motionlab.analysis.alignment import Align, Reason, Samples
from motionlab.analysis.comparison_options import Interpolation, Tolerance

Verdict = Literal["within", "out-of-tolerance", "units-differ", "empty", "missing"] | Reason


class Side(BaseModel):
    """One of the two runs."""

    name: str = Field(description="Identifier or file")
    start: float = Field(description="Time of its first sample, s")
    period: float = Field(description="Time between two samples, s")
    ticks: int = Field(description="Samples, missing ones included")


class Place(BaseModel):
    """An instant of the comparison."""

    time: float = Field(description="In the baseline, s")
    candidate_time: float = Field(description="In the candidate, by its own clock, s")
    lap: int | None = Field(description="With align reference; counted from 0")
    arc: float | None = Field(description="With align reference: since the lap began, m")


class ChannelComparison(BaseModel):
    """One channel of the candidate against that of the baseline."""

    name: str
    unit: str | None = Field(description="In the baseline; null where it is missing")
    candidate_unit: str | None
    verdict: Verdict
    interpolation: Interpolation
    tolerance: Tolerance
    largest: float | None = Field(
        description="Candidate minus baseline where they are farthest apart; null without a value"
    )
    at: Place | None = Field(description="Where that is first")
    beyond: float | None = Field(description="Share of the instants beyond the tolerance")
    rms: float | None = Field(description="Root mean square of the difference")
    range: float | None = Field(description="Largest less least value of the baseline")
    compared: int = Field(description="Instants at which both have a value")
    single: int = Field(description="Instants at which only one has; beyond any value")


class Comparison(BaseModel):
    """Two runs compared; what could not be compared does not hold."""

    a: Side = Field(description="The baseline")
    b: Side = Field(description="The candidate")
    align: Align
    offset: float
    samples: Samples
    instants: int = Field(description="Instants of the overlap")
    start: Place | None = Field(description="Where the overlap begins; null where there is none")
    end: Place | None = Field(description="Its last instant")
    lap_length: float | None = Field(description="Mean length of the baseline's laps, m")
    standing: float = Field(
        description="Share of the baseline left out because its reference stands still"
    )
    note: str = Field(description="Why the runs are not aligned; empty where they are")
    channels: list[ChannelComparison]
    within: int = Field(description="Channels within tolerance")
    holds: bool = Field(description="Whether all are")
    headline: str = Field(description="The verdict as a sentence")
