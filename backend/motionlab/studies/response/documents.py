"""Request and result of a measured frequency response."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from motionlab.config.multisine import SIGNAL, Signal
from motionlab.config.plant import OURS
from motionlab.config.quantity import quantity, si
from motionlab.library.run import ID as RUN_ID
from motionlab.loop.margins import NYQUIST
from motionlab.studies.loop.frequency_sweep import (
    FrequencySweepDocument,
    LoopCurve,
    ResponseDocument,
)
from motionlab.studies.record.part import PartOptions
from motionlab.studies.tune.documents import AxisRequest


class ResponseRequest(PartOptions, AxisRequest):
    """Request of a measured frequency response."""

    seconds: float = quantity(
        "Time of all slides",
        label="time",
        unit="s",
        source=f"{OURS}: 14 slides on x of the shipped motors",
        default=60.0,
        ge=1,
        le=3600,
    )
    signal: Signal = Field(default="multisine", description=SIGNAL)
    velocity: float = quantity(
        "Velocity of the slides; rounded to whole pole pitches in a slide, no whole ones in a "
        "period",
        unit="m/s",
        source=f"{OURS}: at rest the bristles answer, not the machine",
        default=0.04,
        gt=0,
        le=0.2,
    )
    force: float | None = quantity(
        "Force of the signal, RMS; left out: nine tenths of the friction that the slide overcomes, "
        "so that the command seldom changes its sign",
        unit="N",
        source=OURS,
        default=None,
        example=1.0,
        gt=0,
        le=100,
    )
    low: float = quantity(
        "Lowest frequency; its period is that of the multisine",
        unit="Hz",
        source=OURS,
        default=1.0,
        ge=0.2,
        le=50,
    )
    high: float = quantity(
        "Highest frequency", unit="Hz", source=OURS, default=700.0, ge=10, le=0.95 * NYQUIST
    )
    lines: int = Field(
        default=60,
        ge=8,
        le=1000,
        description="Frequencies, evenly over their logarithm",
    )
    seed: int = Field(default=0, ge=0, description="Of the phases")
    run: Annotated[str, Field(pattern=RUN_ID)] | None = Field(
        default=None,
        description="Kept run to estimate it from, in place of an experiment: one that followed a "
        "`multisine`, or any other that was excited enough. Of a measurement, `scenario` has motor "
        "and controllers; else they are the run's own",
    )
    position_column: str | None = Field(
        default=None, max_length=200, description="Of a measurement: its column of the position"
    )
    force_column: str | None = Field(
        default=None, max_length=200, description="Of a measurement: its column of the force"
    )
    excitation_column: str | None = Field(
        default=None,
        max_length=200,
        description="Of a measurement: what excited the loop and does not depend on it, its "
        "reference if left out and there is one; else the force, which feedback biases",
    )

    @model_validator(mode="after")
    def _rises(self) -> Self:
        if self.high < 2.0 * self.low:
            raise ValueError(f"high must be at least twice low; got {self.high:g} and {self.low:g}")
        if self.end is not None and self.end <= self.start:
            raise ValueError(f"end must be after start; got {self.end:g} s and {self.start:g} s")
        if self.run is None:
            for name in ("position_column", "force_column", "excitation_column"):
                if getattr(self, name) is not None:
                    raise ValueError(f"{name} is of a run; name that as run")
        return self


class MeasuredPlant(LoopCurve):
    """The plant, m/N, and how sure it is; shares are of its magnitude."""

    model_config = ConfigDict(extra="forbid")

    interval: list[float] = si(
        "Half of the 95 % interval of the magnitude, as a share; of the phase, in rad", "1"
    )
    noise: list[float] = si(
        "Standard deviation by noise, which a slide without the signal shows, or else periods", "1"
    )
    distortion: list[float] = si(
        "Standard deviation by what is not linear, which only slides of other phases show", "1"
    )
    coherence: list[float] = si(
        "Share of a slide's power that the response explains, or of the command's that the "
        "excitation does, whichever is less; at least 0.5 in the end",
        "1",
    )


class MarginInterval(BaseModel):
    """A margin of the measured loop."""

    value: float | None = Field(description="As measured; null where there is none")
    interval: tuple[float, float] | None = Field(
        description="95 % interval, for any force between that of the experiment and half of it; "
        "null before the last slide, and where some loop within its errors has none"
    )
    model: float | None = Field(description="Of the linearised loop at the same frequencies")


class HalfForce(BaseModel):
    """What half of the force changes, in the mean of all lines."""

    gain: float = Field(description="Magnitude of the plant, over that with all of the force")
    phase: float = si("Of the plant, less that with all of the force", "rad")
    interval: float = Field(description="Half of the 95 % interval: of `gain`, and of `phase`, rad")


class Crossing(BaseModel):
    """A crossover of the measured loop."""

    frequency: float = si("At which the magnitude is 1", "Hz")
    phase_margin: float = si("There", "rad")


class PlantValue(BaseModel):
    """A parameter of the fitted model, SI."""

    value: float
    error: float = Field(
        description="Standard error; grows with the residual where that exceeds the intervals"
    )
    model: float | None = Field(description="The same fitted to the linearised plant")


class FittedMode(BaseModel):
    """A mode, ``(coupling/mass)/(s^2 + 2 damping w s + w^2)`` with ``w = 2 pi frequency``."""

    frequency: PlantValue = Field(description="Undamped, Hz")
    damping: PlantValue = Field(description="Damping ratio, 1")
    coupling: PlantValue = Field(description="Over that of the mass, 1")


class FittedPlant(BaseModel):
    """A rational model of the measured plant, of as many terms as it supports.

    ``exp(-s delay)/(1 + s lag) (1/(mass s^2 + damping s + stiffness) + modes)``, whose command is
    held over `period`.
    """

    mass: PlantValue = Field(description="That a newton of command moves, kg")
    delay: PlantValue = Field(description="Besides the holding of the command, s")
    lag: PlantValue | None = Field(description="First-order lag of the force, s")
    damping: PlantValue | None = Field(description="Viscous friction about the velocity, N s/m")
    stiffness: PlantValue | None = Field(description="N/m")
    modes: list[FittedMode]
    misfit: float = Field(
        description="RMS of the residual for each degree of freedom, over the standard deviation "
        "of the lines; 1 where intervals explain it"
    )
    residual: list[float] = si(
        "Of each measured line: distance from the model, over half of the 95 % interval", "1"
    )
    period: float = si("For which each command is held", "s")
    zeros: list[tuple[float, float]] = Field(
        description="Without the delay, real and imaginary part, rad/s"
    )
    poles: list[tuple[float, float]] = Field(description="As `zeros`")
    gain: float = Field(description="Of the highest powers of s, so that P = gain times products")
    loop: ResponseDocument = Field(description="The loop with the model as its plant")
    plant: LoopCurve = Field(description="The model at the frequencies of `loop`, sampled, m/N")
    margins: dict[str, float | None] = Field(description="Of that loop, as `margins` of all")


class MeasuredResponse(FrequencySweepDocument):
    """The loop of one axis with the plant as it was measured, or as far as it has been."""

    plant: MeasuredPlant = Field(description="Force command to position")
    linearised_plant: LoopCurve = Field(description="The same of the scenario, linearised")
    margins: dict[str, MarginInterval] = Field(
        description="crossover, Hz, phase_margin, rad, gain_margin and gain_reduction: factors by "
        "which the gain may grow, and to which it may fall, before the loop is unstable"
    )
    own_margins: dict[str, MarginInterval] | None = Field(
        default=None,
        description="Of a measurement with its reference: margins of its own loop, from following "
        "error to position, beside those of the scenario's controller as `model`",
    )
    half_force: HalfForce | None = Field(
        default=None,
        description="From two further slides; null before them, of a run and of stepped sines",
    )
    crossings: list[Crossing] = Field(
        description="All crossovers of the measured loop, the lowest first"
    )
    fitted: FittedPlant | None = Field(
        default=None,
        description="A model of the plant; null before the last slide, and where none is near",
    )
    run: str | None = Field(default=None, description="That was read; null of an experiment")
    warnings: list[str] = Field(default=[], description="What a reader must know")
    slides: int = Field(
        description="Slides to and fro, each with phases of its own; 1 of a run with other motions"
    )
    periods: int = Field(description="Periods that were measured in each; 1 as before")
    seconds: float = si("Time of all slides, or of what was read of the run", "s")
