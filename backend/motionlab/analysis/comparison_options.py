"""Options of a comparison: alignment, range, tolerances, channels, variants."""

from __future__ import annotations

import fnmatch
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

from motionlab.analysis.alignment import Align, Samples
from motionlab.config.scenario import VariantName

Interpolation = Literal["linear", "hold"]
Pattern = Annotated[str, Field(min_length=1, max_length=100)]

RULES_MAX = 1000
"""Rules and selections of channels in one request."""


class Tolerance(BaseModel):
    """Tolerance of a channel about the baseline: max(absolute, relative * abs(baseline))."""

    model_config = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False)

    absolute: float = Field(default=0.0, ge=0.0, description="In the unit of the channel")
    relative: float = Field(default=0.0, ge=0.0, description="Share of the baseline's value")
    time: float = Field(
        default=0.0, ge=0.0, description="How much earlier or later it may be there, s"
    )


class Rule(BaseModel):
    """Options of some channels; those left out are as for all others."""

    model_config = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False)

    absolute: float | None = Field(default=None, ge=0.0, description="In the unit of the channel")
    relative: float | None = Field(default=None, ge=0.0, description="Share of the baseline")
    time: float | None = Field(default=None, ge=0.0, description="Tolerance in time, s")
    interpolation: Interpolation | None = Field(
        default=None, description="Between samples; hold for flags and commands, otherwise linear"
    )


class Comparing(BaseModel):
    """Options of a comparison of two runs."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)

    align: Align = Field(
        default="time", description="reference: by lap and arc length of the position reference"
    )
    offset: float = Field(
        default=0.0, strict=True, description="With align time: how far b is moved, s"
    )
    samples: Samples = Field(
        default="union", description="Instants: samples of either run, or only those of both"
    )
    start: float | None = Field(
        default=None, strict=True, description="Time of a at which the comparison begins, s"
    )
    end: float | None = Field(
        default=None, strict=True, description="Time of a at which the comparison ends, s"
    )
    tolerance: Tolerance | None = Field(
        default=None,
        description="Of all channels; left out: 2 % of the baseline's range, six times its noise "
        "and an encoder count, 1 ms in time",
    )
    exact: bool = Field(
        default=False,
        strict=True,
        description="Every channel, and equal values where no tolerance is given",
    )
    channels: dict[Pattern, Rule] = Field(
        default_factory=dict,
        max_length=RULES_MAX,
        description="By name, or by a pattern such as *.following_error; a name counts before "
        "patterns, of these the last that fits",
    )
    only: list[Pattern] = Field(
        default_factory=list,
        max_length=RULES_MAX,
        description="Names or patterns of the channels to compare; left out: eight at most that "
        "tell how the motion was, following errors, forces and currents",
    )
    variants: dict[VariantName, VariantName] = Field(
        default_factory=dict,
        max_length=26,
        description="Letters of variants of b to those of a that they are compared with",
    )


def fits(name: str, pattern: str) -> bool:
    """Return whether a channel has a name, which may hold brackets, or fits a pattern."""
    return name == pattern or fnmatch.fnmatchcase(name, pattern)
