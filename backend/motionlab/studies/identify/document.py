"""The result of an identification, as REST answers and ``--json`` prints it."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from motionlab.analysis.result_document import ResultDocument
from motionlab.library.motors import Motor

Step = Literal["sliding", "presliding", "comparison", "record"]


def _si(description: str, unit: str) -> Any:
    return Field(description=description, json_schema_extra={"unit": unit})


class _Document(BaseModel):
    model_config = ConfigDict(extra="forbid")


class Point(_Document):
    """Friction at one velocity."""

    velocity: float = _si("Mean measured velocity", "m/s")
    force: float = _si(
        "Mean friction: thrust by the controller's map less mass times acceleration", "N"
    )
    deviation: float = _si("Standard deviation of the command over the window", "N")
    pitches: int = _si("Whole pole pitches averaged over; 0 of a run", "1")


class Parameter(_Document):
    """One identified number."""

    value: float = Field(description="Estimate; forces in newtons of the controller's map")
    unit: str
    standard_error: float | None = Field(description="null where the data do not determine it")
    low: float | None = Field(description="Lower end of the 95 % interval")
    high: float | None = Field(description="Upper end of the 95 % interval")
    believed: float | None = Field(description="In the controller's model before")
    true: float | None = Field(description="Of the simulated motor; a real one tells none")
    ratio: float | None = Field(description="Estimate over true value")


class Fit(_Document):
    """Parameters fitted together, and how well they are determined."""

    parameters: dict[str, Parameter]
    residual_rms: float = Field(description="Of the fit, in the unit that it is fitted in")
    residual_unit: str
    warnings: list[str]


class ForceRamp(_Document):
    """Response to force ramps of one rate, both signs and all places averaged."""

    rate: float = _si("Rate of the ramp", "N/s")
    force_max: float = _si("Largest force", "N")
    time: list[float] = _si("Since the ramp began", "s")
    force: list[float] = _si("Mean thrust, as of the points", "N")
    displacement: list[float] = _si("Measured", "m")
    fitted: list[float] = _si("Of the LuGre model with the identified parameters", "m")


class StribeckCurve(_Document):
    """The fitted Stribeck curve, from the fastest motion one way to the fastest the other."""

    velocity: list[float] = _si("Velocity", "m/s")
    force: list[float] = _si("Of the fit", "N")
    low: list[float] | None = Field(
        description="Lower edge of its 95 % band; null where the data do not determine the curve",
        json_schema_extra={"unit": "N"},
    )
    high: list[float] | None = Field(
        description="Upper edge of its 95 % band", json_schema_extra={"unit": "N"}
    )


class RecordEvidence(_Document):
    """What a run could tell about an axis, and how it was read."""

    position: str = Field(description="Column of the position")
    force: str = Field(description="Column of the force, or currents")
    duration: float = _si("Of the part that was read", "s")
    rate: float = _si("Samples a second", "Hz")
    bandwidth: float = _si("Of the filter at -3 dB", "Hz")
    noise: float = _si("Standard deviation of the position's noise", "m")
    slowest: float = _si("Least speed of the windows of sliding that were used", "m/s")
    fastest: float = _si("Largest speed of them", "m/s")
    reversals: int
    shares: dict[str, float] = Field(
        description="Of the samples: used; not used, by reason. 0 to 1"
    )
    condition: float = _si(
        "Condition number of the regression; beyond 1000 parameters can hardly be told apart", "1"
    )
    lag: float = _si("Time by which the motion is behind the force column", "s")
    lag_half_width: float | None = _si("Half of its 95 % interval", "s")
    mass_given: bool


class AxisIdentification(_Document):
    """Everything identified on one axis."""

    points: list[Point] = Field(description="In the order of measurement, both directions")
    residuals: list[float] = _si("Force of each point less the fitted curve's", "N")
    curve: StribeckCurve
    sliding: Fit = Field(description="F_c, F_s, v_s, sigma_2, and a constant offset of force")
    presliding: Fit | None = Field(description="sigma_0 and sigma_1; null when not asked for")
    ramps: list[ForceRamp]
    warnings: list[str] = Field(description="What is wrong with the measurements")
    record: RecordEvidence | None = Field(
        default=None, description="Of a run: what it could tell; null of an experiment"
    )


class IdentificationDocument(_Document):
    """Identified friction of one or two axes."""

    scenario: str
    seed: int
    plant: str
    version: str
    model: str = Field(description="Hash of the model's sources")
    variant: str = Field(description="Whose gains and force map drove the motor")
    apply_to: str = Field(description="Whose model `set` is for")
    run: str | None = Field(
        default=None, description="Run that it was identified from; null of an experiment"
    )
    simulated_time: float = _si("Time that the experiment takes on a motor, or of the run", "s")
    axes: dict[str, AxisIdentification]
    set: dict[str, float] = Field(
        description="Dotted path to value: puts what was identified into the model of `apply_to`"
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

    speed: float = _si("Wanted speed", "m/s")
    pitches: int = _si("Whole pole pitches averaged over, each way", "1")
    time: float = _si("How long it takes", "s")


class PlannedRecord(_Document):
    """What is read of a run for one axis."""

    position: str = Field(description="Column of the position")
    force: str = Field(description="Column of the force, or currents")
    rate: float = _si("Samples a second", "Hz")
    bandwidth: float = _si("Of the filter at -3 dB; noise may lower it", "Hz")
    duration: float = _si("Of the part that is read", "s")


class PlanDocument(_Document):
    """The plan of an identification."""

    simulated_time: float = _si("About how long it takes on a motor", "s")
    simulated_time_max: float = _si("Longest that one request may ask for", "s")
    known: dict[str, Known]
    axes: dict[str, list[PlannedMotion]]
    ramps: int = Field(description="Force ramps, all axes together")
    record: dict[str, PlannedRecord] = Field(
        default_factory=dict, description="By axis, of a run; empty of an experiment"
    )
