"""Request and result of one step, or of a rehearsal, of tuning on a machine."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from motionlab.config.plant import OURS
from motionlab.config.quantity import choices, quantity, si
from motionlab.library.run import ID as RUN_ID
from motionlab.studies.montecarlo.documents import DEFAULT, Variation
from motionlab.studies.tune.documents import AxisRequest

MOTIONS_MAX = 60

VARY = (
    *(each for each in DEFAULT if each.path.startswith("friction.")),
    Variation(path="mass", kind="log-normal", sigma=0.05),
    Variation(path="force_map.F_pk", kind="log-normal", sigma=0.05),
    Variation(path="force_map.offset", kind="normal", sigma=5e-5),
    Variation(path="amplifiers.gain", kind="normal", sigma=0.03),
    Variation(path="amplifiers.offset", kind="normal", sigma=0.1),
    Variation(path="amplifiers.bandwidth", kind="log-uniform", low=500.0, high=2000.0),
    Variation(path="resonance.frequency", kind="log-normal", sigma=0.05),
    Variation(path="resonance.coupling", kind="log-normal", sigma=0.2),
)
"""How far a machine may differ from the scenario's motor, by this project's judgement."""

Refusal = Literal["", "margin", "error", "force"]


class SafeTuneRequest(AxisRequest):
    """Request of the next motion on a machine, or of a rehearsal."""

    runs: Annotated[
        tuple[Annotated[str, Field(pattern=RUN_ID)], ...],
        Field(strict=False, max_length=MOTIONS_MAX),
    ] = Field(
        default=(),
        description="Kept runs of the motions made on the machine so far: same motion, same "
        "controller but for k_p and k_d of the axis. Without any, the present gains are proposed",
    )
    machine: dict[str, Any] | None = Field(
        default=None,
        max_length=4096,
        description="Changes that make the simulated machine of a rehearsal, such as plant: all "
        "motions are made on it at once, unseen by the search but for errors and forces",
    )
    response: Annotated[str, Field(pattern=RUN_ID)] | None = Field(
        default=None,
        description="Kept run of a `multisine` on the machine, with this controller but for the "
        "gains: margins are then read off the measured open loop, not the scenario's motor",
    )
    measure: bool = Field(
        default=True, description="Of a rehearsal: whether it begins with such a measurement"
    )
    metric: Literal["peak", "rms"] = Field(
        default="peak",
        description="Following error over the metrics window that is made small",
        json_schema_extra=choices(
            ("peak", "peak error", "Largest following error"),
            ("rms", "RMS error", "Root mean square of the following error"),
        ),
    )
    error: float | None = quantity(
        "Largest following error allowed, from the motion's first tick on; left out: twice that of "
        "the first motion",
        label="error allowed",
        shown="µm",
        unit="m",
        source=OURS,
        default=None,
        example=5e-5,
        gt=0,
        le=0.1,
    )
    force: float | None = quantity(
        "Largest force command allowed; left out: 90 % of the controller's limit",
        label="force allowed",
        unit="N",
        source=OURS,
        default=None,
        example=30.0,
        gt=0,
        le=1e5,
    )
    gain_margin: float = quantity(
        "Least gain margin, up or down, of the measured loop at the worse end of its interval, or "
        "else of the scenario's motor; a plausible motor keeps half of it in dB",
        unit="1",
        source=f"{OURS}: 6 dB",
        default=2.0,
        gt=1,
        le=100,
    )
    phase_margin: float = quantity(
        "Least phase margin, likewise",
        shown="°",
        unit="rad",
        source=f"{OURS}: 30 degrees",
        default=0.5235987755982988,
        ge=0.05,
        le=1.5,
    )
    step: float = quantity(
        "Largest factor between a gain and that of the nearest motion made",
        unit="1",
        source=OURS,
        default=1.5,
        ge=1.05,
        le=3,
    )
    motions: int = quantity("Most motions", unit="1", source=OURS, default=20, ge=1, le=MOTIONS_MAX)
    improvement: float = quantity(
        "Expected improvement below which the search stops",
        shown="%",
        unit="1",
        source=OURS,
        default=0.02,
        ge=0.001,
        le=0.5,
    )
    motors: int = quantity(
        "Plausible motors, drawn about the scenario's",
        unit="1",
        source=OURS,
        default=16,
        ge=1,
        le=64,
    )
    vary: Annotated[tuple[Variation, ...], Field(strict=False, min_length=1, max_length=100)] = (
        Field(default=VARY, description="How plausible motors differ from the scenario's")
    )
    seed: int = Field(default=0, ge=0, lt=2**32, description="Of the plausible motors")


class _Document(BaseModel):
    model_config = ConfigDict(extra="forbid")


class MotionMade(_Document):
    """A motion on the machine and what was measured in it."""

    run: str | None = Field(description="Kept run; null in a rehearsal")
    k_p: float = si("Proportional gain", "N/m")
    k_d: float = si("Derivative gain", "N s/m")
    metric: float | None = si(
        "What is made small: following error over the window; null if it diverged", "m"
    )
    error: float | None = si("Largest following error from the first tick on", "m")
    force: float | None = si("Largest force command", "N")
    within: bool = Field(description="Whether error and force stayed within their limits")


class LeastMargins(_Document):
    """Worst margins, stuck and sliding; null without a crossing."""

    gain_margin: float | None = si("Factor up, or down, to the stability boundary", "1")
    phase_margin: float | None = si("Distance of arg L from -180 degrees", "rad", "deg")


class NextMotion(_Document):
    """The motion that is proposed."""

    k_p: float = si("Proportional gain", "N/m")
    k_d: float = si("Derivative gain", "N s/m")
    changes: dict[str, Any] = Field(description="Dotted path to value, for `--set` or a session")
    expected: float = si("Expected metric: the median", "m")
    error_high: float = si("Upper bound, 97.7 %, of the largest following error", "m")
    force_high: float = si("Upper bound, 97.7 %, of the largest force command", "N")
    margins: LeastMargins = Field(description="Of the measured loop, or of the scenario's motor")
    plausible: LeastMargins = Field(description="Of the worst plausible motor")
    improvement: float = Field(description="Expected, as a share of the least metric measured")
    beyond: bool = Field(
        description="Whether a gain is larger than in every motion made, so that a person has to "
        "agree"
    )
    text: str


class Examined(_Document):
    """Gains within a step of a motion made, for drawing."""

    k_p: list[float] = si("Proportional gain", "N/m")
    k_d: list[float] = si("Derivative gain", "N s/m")
    refused: list[Refusal] = Field(description="Limit that is not sure to hold; empty: all are")
    expected: list[float | None] = si("Expected metric", "m")


class SafeTuneDocument(_Document):
    """The motions made, what is proposed next, and the best so far."""

    error: float | None = si("Limit of the error; null before the first motion", "m")
    force: float = si("Limit of the force command", "N")
    motions: list[MotionMade]
    proposal: NextMotion | None = Field(description="null where the search has ended")
    ended: str = Field(description="Why no further motion is proposed; empty where one is")
    best: int | None = Field(description="Which motion is best among those within the limits")
    changes: dict[str, Any] = Field(
        description="Gains of the best motion as dotted paths; empty where they are the present"
    )
    examined: Examined
    warnings: list[str]
