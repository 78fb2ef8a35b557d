"""Requests and documents of an identification."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, model_validator

from motionlab.analysis.result_document import ResultDocument
from motionlab.config.plant import OURS, PAPER
from motionlab.config.quantity import Config, quantity, si
from motionlab.config.scenario import VariantName
from motionlab.config.validation_errors import checked
from motionlab.library.motors import Motor
from motionlab.library.run import ID as RUN_ID
from motionlab.studies.record.part import PartOptions

SPEEDS = tuple(float(f"{v:.4g}") for v in np.geomspace(0.5e-3, 0.15, 32))
"""Speeds of the uniform motions, m/s: 0.5 to 150 mm/s, each as far from the next in ratio."""

FEWEST_SPEEDS = 5
_BLIND = 6
_COLUMN_MAX = 120
RAMPS_MAX = 8
"""Rates of force ramps in one experiment: they are simulated side by side."""

_Speed = Annotated[float, Field(ge=1e-4, le=1.0)]
_Rate = Annotated[float, Field(ge=0.1, le=1000.0)]


class ForceRamps(Config):
    """Open-loop force ramps below stiction."""

    enabled: bool = Field(
        default=True, title="ramp the force", description="Identify sigma_0 and sigma_1 too"
    )
    rates: Annotated[tuple[_Rate, ...], Field(strict=False, min_length=1, max_length=RAMPS_MAX)] = (
        quantity(
            "Rates of the force ramps; a warning below 20 N/s, where ripple spoils them",
            label="rates of the ramps",
            unit="N/s",
            source=OURS,
            default=(20.0, 50.0, 100.0),
        )
    )
    share: float = quantity(
        "Largest force of a ramp, as a share of the stiction just identified",
        label="up to, of F_s",
        unit="1",
        shown="%",
        source=OURS,
        default=0.5,
        ge=0.05,
        le=0.5,
    )
    places: int = quantity(
        "Places in one pole pitch at which the ramps are repeated",
        label="positions",
        unit="1",
        source=OURS,
        default=7,
        ge=4,
        le=25,
    )

    @model_validator(mode="after")
    def _sees_the_ripple(self) -> Self:
        if self.places == _BLIND:
            raise ValueError(
                "places = 6 all see the same part of a ripple that repeats six times a pole "
                "pitch: take 5 or 7"
            )
        return self


class RecordOptions(PartOptions):
    """Columns and filter of a run; chosen automatically where left out."""

    variant: VariantName | None = Field(
        default=None,
        title="variant of the run",
        description="Variant of the run whose channels are read; left out: its first",
    )
    position_column: str | None = Field(
        default=None,
        max_length=_COLUMN_MAX,
        description="Column of the position; left out: position_measured of the variant",
    )
    force_column: str | None = Field(
        default=None,
        max_length=_COLUMN_MAX,
        description="Column of the force, or currents: thrust of the three currents by the force "
        "map of the driving variant; left out: currents, force_realised, force_command or thrust, "
        "the first that the run has",
    )
    mass: float | None = quantity(
        "Moving mass; left out: identified too",
        unit="kg",
        source=OURS,
        default=None,
        ge=1e-3,
        le=1e4,
    )
    bandwidth: float | None = quantity(
        "Bandwidth of the filter at -3 dB; left out: 50 Hz, or 0.075 of the sample rate where that "
        "is less",
        unit="Hz",
        source=OURS,
        default=None,
        ge=0.1,
        le=1000.0,
    )


class IdentifyRequest(Config):
    """Request of an identification."""

    scenario: str | dict[str, Any] = Field(
        default="circle", description="Name of a shipped scenario, or its tables: motor and loop"
    )
    set: dict[str, Any] = Field(
        default_factory=dict, max_length=4096, description="Dotted path to value, SI"
    )
    axis: Literal["x", "y", "both"] = Field(default="both", description="Axes to identify")
    speeds: Annotated[
        tuple[_Speed, ...], Field(strict=False, min_length=FEWEST_SPEEDS, max_length=200)
    ] = quantity(
        "Speeds of the uniform motions; each is run both ways",
        shown="mm/s",
        unit="m/s",
        source=f"{PAPER}, section IV: many; the list is this project's choice",
        default=SPEEDS,
    )
    time_max: float = quantity(
        "Time after which a uniform motion takes no further pole pitch; one is always taken",
        label="time of each",
        unit="s",
        source=OURS,
        default=20.0,
        gt=0,
        le=3600,
    )
    pitches_max: int | None = quantity(
        "Most pole pitches that a force is averaged over; left out: as many as time and stroke "
        "allow",
        label="pole pitches",
        unit="1",
        source=OURS,
        default=None,
        ge=1,
        le=1000,
    )
    presliding: ForceRamps = Field(default=ForceRamps(), title="force ramps")
    variant: VariantName | None = Field(
        default=None,
        title="driven by",
        description="Variant whose gains and force map drive the motor; left out: the first",
    )
    apply_to: VariantName | None = Field(
        default=None,
        title="model of",
        description="Variant whose model the result is for; left out: the second, or the only one",
    )
    run: Annotated[str, Field(pattern=RUN_ID)] | None = Field(
        default=None,
        title="measured run",
        description="Run to identify from; nothing moves then, and speeds, times and ramps do not "
        "matter",
    )
    record: RecordOptions = Field(default=RecordOptions(), title="of the run")
    compare: bool = Field(
        default=False,
        description="Run the circle under that variant with its old model (A) and the new one (B)",
    )

    @model_validator(mode="after")
    def _speeds_differ(self) -> Self:
        if len(set(self.speeds)) < len(self.speeds):
            raise ValueError("speeds must differ from one another")
        if len(set(self.presliding.rates)) < len(self.presliding.rates):
            raise ValueError("presliding.rates must differ from one another")
        return self

    @property
    def axes(self) -> tuple[str, ...]:
        """The axes, in order."""
        return ("x", "y") if self.axis == "both" else (self.axis,)


def read_request(request: Mapping[str, Any]) -> IdentifyRequest:
    """Return a request, checked; raise ConfigError naming every field that is wrong."""
    return checked(IdentifyRequest, request, "identify")


Step = Literal["sliding", "presliding", "comparison", "record"]


class _Document(BaseModel):
    model_config = ConfigDict(extra="forbid")


class Point(_Document):
    """Friction at one velocity."""

    velocity: float = si("Mean measured velocity", "m/s")
    force: float = si(
        "Mean friction: thrust by the controller's map less mass times acceleration", "N"
    )
    deviation: float = si("Standard deviation of the command over the window", "N")
    pitches: int = si("Whole pole pitches averaged over; 0 of a run", "1")


class Parameter(_Document):
    """One identified number."""

    value: float = Field(description="Estimate; forces in newtons of the controller's map")
    unit: str
    standard_error: float | None = Field(
        repr=False, description="null where the data do not determine it"
    )
    low: float | None = Field(description="Lower end of the 95 % interval", repr=False)
    high: float | None = Field(description="Upper end of the 95 % interval", repr=False)
    believed: float | None = Field(description="In the controller's model before")
    true: float | None = Field(description="Of the simulated motor; a real one tells none")
    ratio: float | None = si("Estimate over true value", "1")

    def derived(self) -> dict[str, float | None]:
        """Return half of the 95 % interval, which says more than its ends in few digits."""
        return {"+-": None if self.high is None else self.high - self.value}


class Fit(_Document):
    """Parameters fitted together, and how well they are determined."""

    parameters: dict[str, Parameter]
    residual_rms: float = Field(description="Of the fit, in the unit that it is fitted in")
    residual_unit: str = Field(repr=False)
    warnings: list[str]

    @property
    def unit(self) -> str:
        """Unit of its own numbers."""
        return self.residual_unit


class ForceRamp(_Document):
    """Response to force ramps of one rate, both signs and all places averaged."""

    rate: float = si("Rate of the ramp", "N/s")
    force_max: float = si("Largest force", "N")
    time: list[float] = si("Since the ramp began", "s")
    force: list[float] = si("Mean thrust, as of the points", "N")
    displacement: list[float] = si("Measured", "m")
    fitted: list[float] = si("Of the LuGre model with the identified parameters", "m")


class StribeckCurve(_Document):
    """The fitted Stribeck curve, from the fastest motion one way to the fastest the other."""

    velocity: list[float] = si("Velocity", "m/s")
    force: list[float] = si("Of the fit", "N")
    low: list[float] | None = Field(
        description="Lower edge of its 95 % band; null where the data do not determine the curve",
        json_schema_extra={"unit": "N"},
    )
    high: list[float] | None = Field(
        description="Upper edge of its 95 % band", json_schema_extra={"unit": "N"}
    )


class RecordEvidence(_Document):
    """Information of a run about an axis, and how it was read."""

    position: str = Field(description="Column of the position")
    force: str = Field(description="Column of the force, or currents")
    duration: float = si("Of the part that was read", "s")
    rate: float = si("Samples a second", "Hz")
    bandwidth: float = si("Of the filter at -3 dB", "Hz")
    noise: float = si("Standard deviation of the position's noise", "m")
    slowest: float = si("Least speed of the windows of sliding that were used", "m/s")
    fastest: float = si("Largest speed of them", "m/s")
    reversals: int
    shares: dict[str, float] = si("Of the samples: used; not used, by reason. 0 to 1", "1", "%")
    condition: float = si(
        "Condition number of the regression; beyond 1000 parameters can hardly be told apart", "1"
    )
    lag: float = si("Time by which the motion is behind the force column", "s")
    lag_half_width: float | None = si("Half of its 95 % interval", "s")
    mass_given: bool

    def derived(self) -> dict[str, bool]:
        """Return whether the lag is determined."""
        return {"lag determined": self.lag_half_width is not None}


class AxisIdentification(_Document):
    """Everything identified on one axis."""

    points: list[Point] = Field(
        description="In the order of measurement, both directions", repr=False
    )
    residuals: list[float] = si("Force of each point less the fitted curve's", "N")
    curve: StribeckCurve
    sliding: Fit = Field(description="F_c, F_s, v_s, sigma_2, and a constant offset of force")
    presliding: Fit | None = Field(description="sigma_0 and sigma_1; null when not asked for")
    ramps: list[ForceRamp] = Field(repr=False)
    warnings: list[str] = Field(description="What is wrong with the measurements")
    record: RecordEvidence | None = Field(
        default=None, description="Of a run: what it could tell; null of an experiment"
    )

    def derived(self) -> dict[str, int]:
        """Return the number of points."""
        return {"points": len(self.points)}


class IdentificationDocument(_Document):
    """Identified friction of one or two axes."""

    labels: ClassVar[dict[str, str]] = {
        "variant": "gains and map of",
        "apply_to": "into the model of",
        "set": "into the model",
    }

    foot: ClassVar[str] = (
        "Forces are in newtons of the controller's map; +- is half of the 95 % interval."
    )

    scenario: str
    seed: int
    plant: str
    version: str = Field(repr=False)
    model: str = Field(description="Hash of the model's sources", repr=False)
    variant: str = Field(description="Whose gains and force map drove the motor")
    apply_to: str = Field(description="Whose model `set` is for")
    run: str | None = Field(
        default=None, description="Run that it was identified from; null of an experiment"
    )
    simulated_time: float = si("Time that the experiment takes on a motor, or of the run", "s")
    axes: dict[str, AxisIdentification]
    set: dict[str, float] = Field(
        description="Dotted path to value: puts what was identified into the model of `apply_to`",
    )
    motor: Motor | None = Field(
        default=None,
        description="Of a measured run: its simulated motor with what was identified in it; "
        "`PUT /motors/{name}` saves it. null of an experiment and of a simulation",
    )
    comparison: ResultDocument | None = Field(
        description="Result document of the circle with the old model (A) and the new one (B)"
    )


class ExperimentProgress(_Document):
    """Progress of the experiment."""

    axis: str | None = Field(description="null while the circle is run for comparison")
    step: Step = Field(description="sliding, presliding or comparison; record of a run")
    done: int = Field(description="Motions of this step that are done")
    count: int = Field(description="Motions of this step")


class Known(_Document):
    """Friction of an axis before it is identified."""

    believed: dict[str, float] = Field(description="In the controller's model, SI")
    true: dict[str, float] | None = Field(
        description="Of the simulated motor, SI; null without friction, and a real one tells none"
    )


class PartialIdentification(_Document):
    """Intermediate results of an identification."""

    standing: ExperimentProgress
    known: dict[str, Known]
    axes: dict[str, list[Point]] = Field(description="Points measured so far")
    found: dict[str, AxisIdentification] = Field(description="Axes that are finished")


class PlannedMotion(_Document):
    """A uniform motion there and back that is planned."""

    speed: float = si("Wanted speed", "m/s")
    pitches: int = si("Whole pole pitches averaged over, each way", "1")
    time: float = si("How long it takes", "s")


class PlannedRecord(_Document):
    """Columns of a run for one axis."""

    position: str = Field(description="Column of the position")
    force: str = Field(description="Column of the force, or currents")
    rate: float = si("Samples a second", "Hz")
    bandwidth: float = si("Of the filter at -3 dB; noise may lower it", "Hz")
    duration: float = si("Of the part that is read", "s")


class PlanDocument(_Document):
    """The plan of an identification."""

    simulated_time: float = si("About how long it takes on a motor", "s")
    simulated_time_max: float = si("Longest that one request may ask for", "s")
    known: dict[str, Known]
    axes: dict[str, list[PlannedMotion]]
    ramps: int = Field(description="Force ramps, all axes together")
    record: dict[str, PlannedRecord] = Field(
        default_factory=dict, description="By axis, of a run; empty of an experiment"
    )
