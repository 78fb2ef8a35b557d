"""Request and document of learning from lap to lap."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar

from pydantic import BaseModel, ConfigDict, Field

from motionlab.config.quantity import Config, quantity, si
from motionlab.config.scenario import VariantName
from motionlab.declarations import OURS
from motionlab.studies.learn.learning_filter import BANDWIDTH, BELOW_NOTCH

LAPS_MAX = 1000
MOTORS_MAX = 1000


class LearningBandwidth(Config):
    """Bandwidth of learning on each axis; null: that of a notch times 0.6, or else 150 Hz."""

    x: float | None = quantity(
        f"On x; left out: {BELOW_NOTCH:g} of the notch's frequency, {BANDWIDTH:g} Hz without one",
        label="learning bandwidth x",
        unit="Hz",
        source=OURS,
        default=None,
        example=150.0,
        ge=1,
        le=900,
    )
    y: float | None = quantity(
        "On y; left out: by the rule for x, of its own notch",
        label="learning bandwidth y",
        unit="Hz",
        source=OURS,
        default=None,
        example=150.0,
        ge=1,
        le=900,
    )


class LearnRequest(Config):
    """Scenario, which controller learns, and how."""

    scenario: str | dict[str, Any] = Field(
        default="circle-matched", description="Name of a shipped scenario, or its tables"
    )
    set: dict[str, Any] = Field(
        default_factory=dict, max_length=4096, description="Dotted path to value, SI"
    )
    after: Annotated[tuple[str | dict[str, Any], ...], Field(strict=False, max_length=8)] = Field(
        default=(),
        title="after motions",
        description="Motions that are learnt first, by name or as tables: what they teach of "
        "friction, mass and force map is carried over to the first lap",
    )
    variant: VariantName | None = Field(
        default=None, description="Whose controller learns; null: the last"
    )
    laps: int = quantity(
        "Laps to learn in", label="laps", unit="1", source=OURS, default=12, ge=1, le=LAPS_MAX
    )
    gain: float = quantity(
        "Share of a lap's error that the next is corrected by; after 8 laps it falls",
        label="learning gain",
        unit="1",
        source=OURS,
        default=0.6,
        gt=0,
        le=2,
    )
    bandwidth: LearningBandwidth = LearningBandwidth()
    encoder: bool = Field(
        default=True,
        title="learn the encoder's error",
        description="Whether the sub-divisional error of the encoder is found and corrected, too",
    )
    motors: int = quantity(
        "Drawn motors, as of Monte Carlo, for which convergence is predicted",
        label="drawn motors",
        unit="1",
        source=OURS,
        default=100,
        ge=0,
        le=MOTORS_MAX,
    )
    seed: int | None = quantity(
        "Seed of the draws; left out: the scenario's",
        unit="1",
        source=OURS,
        default=None,
        ge=0,
        le=2**53 - 1,
    )
    anyway: bool = Field(
        default=False,
        title="learn anyway",
        description="Learn where it is predicted to diverge, too",
    )


class _Document(BaseModel):
    model_config = ConfigDict(extra="forbid")


class LearnLap(_Document):
    """A lap of one axis; the force is what had been learnt before it."""

    labels: ClassVar[dict[str, str]] = {"true_peak": "true max", "true_rms": "true rms"}

    peak: float = si("Largest following error", "m")
    rms: float = si("Its root mean square", "m")
    true_peak: float = si("Largest distance of the mover from its reference", "m")
    true_rms: float = si("Its root mean square", "m")
    force: float = si("Largest learnt force", "N")
    gain: float = si("Learning gain after the lap", "1")
    went_back: bool = Field(
        description="Whether it was so much worse than the best lap that learning went back to it"
    )


class Prediction(_Document):
    """Factor rho of the error that repeats, from lap to lap: below 1 at all frequencies it fades.

    The largest at standstill and at 0.5, 1 and 4 Stribeck velocities.
    """

    frequency: list[float] = Field(repr=False, description="Hz")
    motor: list[float] = Field(repr=False, description="rho of the scenario's motor, 1")
    model: list[float] = Field(repr=False, description="rho of the controller's model, 1")
    low: list[float] | None = Field(
        repr=False, description="5 % of the drawn motors are below; null without them"
    )
    high: list[float] | None = Field(repr=False, description="95 % of them are below")
    worst: float = si("Largest rho of the motor", "1")
    worst_frequency: float = si("Where", "Hz")
    converging: float | None = Field(
        description="Share of the drawn motors that converge, 1; null without them"
    )


class EncoderError(_Document):
    """Sub-divisional error of the encoder that was found: ``S sin + C cos`` of the scale."""

    amplitude: float = si("Amplitude", "m", "nm")
    sine: float = si("Amplitude of the sine", "m", "nm")
    cosine: float = si("Amplitude of the cosine", "m", "nm")
    period: float = si("Period of the scale", "m")


class CarriedOver(_Document):
    """What other motions taught of an axis, before its first lap."""

    motions: list[str] = Field(description="Of which this axis had learnt a lap")
    explained: float = si(
        "Share of what the model leaves, in those motions, that is explained", "1", "%"
    )
    peak: float = si("Largest following error in the first lap without it", "m")


class LearnAxis(_Document):
    """One axis."""

    bandwidth: float = si("Bandwidth of learning", "Hz")
    prediction: Prediction
    laps: list[LearnLap] = Field(description="One after another")
    carried_over: CarriedOver | None = Field(
        default=None, description="null where no other motion was learnt first"
    )
    encoder: EncoderError | None = Field(description="null where it was not looked for")
    force: list[float] = Field(repr=False, description="Learnt force over the lap, N")
    remains: list[float] = Field(repr=False, description="Following error of the last lap, m")


class LearnDocument(_Document):
    """What was learnt, lap by lap, and what it changes."""

    scenario: str
    plant: str
    version: str
    model: str = Field(repr=False, description="Hash of the model's sources")
    variant: str
    law: str
    lap: float = si("Duration of a lap", "s")
    laps: int = Field(description="Laps that were run")
    diverged: bool = Field(description="Whether the motor diverged before the last lap")
    summary: list[str] = Field(description="In sentences")
    time: list[float] = Field(repr=False, description="Of force and error, from the lap's start, s")
    axes: dict[str, LearnAxis]
    changes: dict[str, Any] = Field(
        repr=False, description="What was learnt as changes of the scenario: dotted path to value"
    )


class PartialLearning(_Document):
    """Laps so far, by axis."""

    laps: dict[str, list[LearnLap]]
