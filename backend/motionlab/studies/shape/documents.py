"""Request and result of shaping a loop on what was measured."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from motionlab.config.plant import OURS
from motionlab.config.quantity import quantity
from motionlab.library.run import ID as RUN_ID
from motionlab.studies.loop.frequency_sweep import LoopCurve
from motionlab.studies.response.documents import MarginInterval, MeasuredResponse, ResponseRequest


class ShapeRequest(ResponseRequest):
    """Request of gains and filters on a measured plant; how it is measured is a response's."""

    lines: int = Field(
        default=300,
        ge=8,
        le=1000,
        description="Frequencies, evenly over their logarithm where whole cycles of the period lie "
        "so close: a mode between two of them is not seen",
    )
    phase_margin: float = quantity(
        "Least phase margin, at the lower end of its interval; 0.5236 is 30 degrees",
        unit="rad",
        source=OURS,
        default=0.5235987755982988,
        ge=0.05,
        le=1.5,
    )
    gain_margin: float = quantity(
        "Least factor by which the gain may grow, or fall, at the nearer end of its interval",
        unit="1",
        source=f"{OURS}: 6 dB",
        default=2.0,
        gt=1,
        le=100,
    )
    step: float = quantity(
        "Largest factor by which a gain or the observer's bandwidth may change, either way, and "
        "the controller as a whole grow at any frequency",
        unit="1",
        source=f"{OURS}: a step further is taken after a second measurement",
        default=2.0,
        gt=1,
        le=10,
    )
    filters: int = quantity(
        "Most filters that are added", unit="1", source=OURS, default=4, ge=0, le=4
    )
    second_run: Annotated[str, Field(pattern=RUN_ID)] | None = Field(
        default=None,
        description="Kept run with the proposed controller, to check it; only with `run`, and of a "
        "measurement the same part of it. Without `run` a second experiment checks it",
    )


class Resonance(BaseModel):
    """A resonance that the measurement shows."""

    model_config = ConfigDict(extra="forbid")

    frequency: float = Field(description="Hz", json_schema_extra={"unit": "Hz"})
    height: float = Field(
        description="Of the plant over its neighbourhood, dB", json_schema_extra={"unit": "dB"}
    )
    least: float = Field(
        description="The same at the lower end of the 95 % interval, dB",
        json_schema_extra={"unit": "dB"},
    )
    resolved: bool = Field(description="Whether the frequencies lie close enough to have its top")


class ProposedFilter(BaseModel):
    """A filter that is proposed, and why."""

    kind: Literal["notch", "low-pass", "lead"]
    place: str = Field(description="`notch`, or `filter_1` to `filter_3`")
    values: dict[str, float] = Field(description="Of its fields, Hz and 1")
    reason: str
    gain: float = Field(
        description="By how much the loop would be less stiff without it, dB; 100: no gains keep "
        "the limits then",
        json_schema_extra={"unit": "dB"},
    )


class ShapeCheck(BaseModel):
    """The second measurement, with what was proposed."""

    margins: dict[str, MarginInterval] = Field(
        description="As measured; `model` is as predicted. Nothing where it could not be measured"
    )
    open: LoopCurve = Field(description="L as measured")
    frequency: list[float] = Field(description="Hz", json_schema_extra={"unit": "Hz"})
    holds: bool = Field(description="Whether every margin is at least what was requested")
    text: str


class ShapeDocument(BaseModel):
    """What is proposed on what was measured."""

    response: MeasuredResponse
    resonances: list[Resonance] = Field(description="Significant ones")
    filters: list[ProposedFilter] = Field(description="In the order in which they were added")
    changes: dict[str, Any] = Field(
        description="Dotted path to value, for `--set`, a scenario or a session; empty where "
        "nothing within the limits is better"
    )
    before: dict[str, float] = Field(
        description="k_p, k_d and, where it acts, the observer's bandwidth, SI"
    )
    after: dict[str, float] = Field(description="The same, proposed")
    margins: dict[str, MarginInterval] = Field(
        description="Of the proposed loop on the measured plant; `model` is before"
    )
    frequency: list[float] = Field(
        description="Frequencies of the response whose interval is within 50 %, Hz: only these "
        "were shaped on",
        json_schema_extra={"unit": "Hz"},
    )
    open: LoopCurve = Field(description="L as proposed, at these frequencies")
    compliance: float = Field(
        description="Mean of abs(P/(1 + L)) below the crossover before, after over before, dB: "
        "negative is stiffer",
        json_schema_extra={"unit": "dB"},
    )
    notes: list[str]
    check: ShapeCheck | None = Field(description="null until a second measurement")
