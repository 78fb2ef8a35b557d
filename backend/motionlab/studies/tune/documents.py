"""Requests and documents of a search for gains and of landscapes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal, Self, TypeVar

from pydantic import BaseModel, ConfigDict, Field, model_validator

from motionlab.config.plant import OURS
from motionlab.config.quantity import Config, choices, quantity, si
from motionlab.config.scenario import Scenario, VariantName, WindowConfig
from motionlab.config.validation_errors import checked
from motionlab.errors import ConfigError, FieldError
from motionlab.loop.document import WorstMargin

Metric = Literal["peak", "rms", "itae", "settling", "effort"]
OBJECTIVE = choices(
    ("peak", "peak error", "Largest following error over the window", "µm"),
    ("rms", "RMS error", "Root mean square of the following error", "µm"),
    ("itae", "ITAE", "Integral of time times |e|, from the start of the window", "µm s^2"),
    (
        "settling",
        "settling time",
        "Longest settling time of a hold; needs a motion that comes to rest",
        "10 ms",
    ),
    ("effort", "RMS thrust", "Root mean square of the thrust", "N"),
)
"""Metrics of an objective; the unit is that of a weight of 1."""

_Weight = Annotated[float, Field(gt=0.0, le=1e9)]
_Path = Annotated[str, Field(max_length=100)]
_Edge = Annotated[float, Field(gt=0.0, le=1e9)]
Range = Annotated[tuple[_Edge, _Edge], Field(strict=False)]


class GainBounds(Config):
    """Bounds of the search, low and high of each gain; the search is in their logarithms."""

    k_p: Range = quantity(
        "Of k_p", label="range of k_p", shown="N/mm", unit="N/m", source=OURS, default=(1e4, 3e7)
    )
    k_d: Range = quantity(
        "Of k_d",
        label="range of k_d",
        shown="N s/mm",
        unit="N s/m",
        source=OURS,
        default=(1e2, 1e5),
    )


class Constraints(Config):
    """Constraints of a candidate; null disables one.

    Margins are the worst of the linearised loop, at standstill and from 0.5 to 4 Stribeck
    velocities.
    """

    gain_margin: float | None = quantity(
        "Least factor by which the loop's gain may grow, or fall, to the stability boundary",
        unit="1",
        example=2.0,
        source=f"{OURS}: 6 dB",
        default=2.0,
        gt=1,
        le=100,
    )
    phase_margin: float | None = quantity(
        "Least phase margin, at standstill and from 0.5 to 4 Stribeck velocities",
        shown="°",
        example=0.5236,
        unit="rad",
        source=f"{OURS}: 30 degrees",
        default=0.5236,
        gt=0,
        lt=3.1416,
    )
    Ms: float | None = quantity(
        "Largest peak of the sensitivity 1/(1 + L)",
        label="M_s",
        unit="1",
        source=OURS,
        default=None,
        example=2.0,
        gt=1,
        le=100,
    )
    saturated: float | None = quantity(
        "Largest share of ticks with force or current at its limit",
        shown="%",
        example=0.0,
        unit="1",
        source=OURS,
        default=0.0,
        ge=0,
        le=1,
    )
    force: float | None = quantity(
        "Largest thrust",
        label="thrust",
        unit="N",
        source=OURS,
        default=None,
        example=30.0,
        gt=0,
        le=1000,
    )


class _Source(Config):
    """The scenario that all requests begin with."""

    scenario: str | dict[str, Any] = Field(
        default="circle", description="Name of a shipped scenario, or its tables"
    )
    set: dict[str, Any] = Field(
        default_factory=dict, max_length=4096, description="Dotted path to value, SI"
    )
    variant: VariantName | None = Field(
        default=None,
        title="gains of",
        description="Whose gains; left out: the second variant, or the only one",
    )

    def chosen(self, scenario: Scenario) -> str:
        """Return the requested variant.

        Raises
        ------
        ConfigError
            If the scenario has no such variant.
        """
        letters = list(scenario.variants)
        variant = self.variant or letters[min(1, len(letters) - 1)]
        if variant not in letters:
            raise ConfigError(
                FieldError(
                    loc="variant",
                    message="is no variant of the scenario",
                    value=variant,
                    range="one of " + ", ".join(letters),
                )
            )
        return variant


class AxisRequest(_Source):
    """Request of a loop."""

    axis: Literal["x", "y"] = Field(default="x", description="Axis")


class _TuningRequest(_Source):
    """Fields common to both requests."""

    axis: Literal["x", "y", "both"] = Field(default="both", description="Axes")
    objective: dict[Metric, _Weight] = Field(
        default={"rms": 1.0},
        min_length=1,
        description="Weights; the cost is the sum of weight times metric, in um (peak, rms), "
        "um s^2 (itae), 10 ms (settling) and N (effort)",
        json_schema_extra=OBJECTIVE,
    )
    bounds: GainBounds = Field(default=GainBounds(), title="ranges of the gains")
    window: WindowConfig | None = Field(
        default=None,
        description="Metrics window, at whose end a run ends; left out: the second lap of a motion "
        "that repeats, otherwise the scenario's own",
    )
    plants: Annotated[tuple[str, ...], Field(strict=False, max_length=8)] = Field(
        default=(),
        title="motors",
        description="Shipped motors on which the gains must do as well: the worst one counts",
    )

    @property
    def ranges(self) -> dict[str, tuple[float, float]]:
        """Every range that is searched, by field."""
        return {"bounds.k_p": self.bounds.k_p, "bounds.k_d": self.bounds.k_d}

    @property
    def axes(self) -> tuple[str, ...]:
        """The axes, in order."""
        return ("x", "y") if self.axis == "both" else (self.axis,)

    @model_validator(mode="after")
    def _plants_differ(self) -> Self:
        if len(set(self.plants)) < len(self.plants):
            raise ValueError("plants must differ from one another")
        return self


class TuneRequest(_TuningRequest):
    """Request of a gain search."""

    constraints: Constraints = Field(default=Constraints(), title="limits")
    also: dict[_Path, Range] = Field(
        default_factory=dict,
        max_length=8,
        title="further numbers",
        description="Further numbers of the controller to search, each with low and high, SI: "
        "compensation.NAME of any number that its law declares, disturbance_observer.bandwidth; "
        "both axes share them and are then tuned together",
    )
    starts: int = quantity(
        "Starts of the simplex: the present gains, the others drawn within the bounds",
        unit="1",
        source=OURS,
        default=4,
        ge=1,
        le=16,
    )
    evaluations: int = quantity(
        "Evaluations of a start at most", unit="1", source=OURS, default=200, ge=10, le=2000
    )

    @property
    def ranges(self) -> dict[str, tuple[float, float]]:
        """Every range that is searched, by field."""
        return super().ranges | {f"also.{path}": ends for path, ends in self.also.items()}


class LandscapeRequest(_TuningRequest):
    """Request of a cost map."""

    points: int = quantity(
        "Gains along each side of the map", unit="1", source=OURS, default=64, ge=8, le=128
    )


_UNITS = {"bounds.k_p": "N/m", "bounds.k_d": "N s/m"}
_Request = TypeVar("_Request", bound=_Source)


def read_request(model: type[_Request], request: Mapping[str, Any]) -> _Request:
    """Return a request, checked.

    Parameters
    ----------
    model : type
        `TuneRequest`, `LandscapeRequest`, `AxisRequest` or one built on it.
    request : mapping
        Its fields.

    Raises
    ------
    ConfigError
        Naming every field that is wrong, its value, range and unit.
    """
    tuning = checked(model, request, "tune")
    if isinstance(tuning, _TuningRequest):
        _refuse_inverted(tuning)
    return tuning


def _refuse_inverted(request: _TuningRequest) -> None:
    inverted = [
        FieldError(
            loc=loc,
            message="the lower end must lie below the upper one",
            value=f"{low:g} to {high:g}",
            unit=_UNITS.get(loc, ""),
        )
        for loc, (low, high) in request.ranges.items()
        if not low < high
    ]
    if inverted:
        raise ConfigError(*inverted)


class _Document(BaseModel):
    model_config = ConfigDict(extra="forbid")


class GainMetrics(_Document):
    """Metrics of one axis on one motor over the window; null if it diverged."""

    peak: float | None = si("Largest following error", "m")
    rms: float | None = si("Root mean square of the following error", "m")
    itae: float | None = si("Integral of time times abs(e), from the window's start", "m s^2")
    settling: float | None = si(
        "Longest settling time of a hold; the window's length without or beyond one", "s"
    )
    effort: float | None = si("Root mean square of the thrust", "N")
    force: float | None = si("Largest thrust", "N")
    saturated: float | None = si("Share of ticks with force or current at its limit", "1", "%")


class GainMargins(_Document):
    """Worst margins of the linearised loop on one motor, stuck and sliding.

    Null where the loop is unstable or has no such crossing.
    """

    stable: bool = Field(description="At each of these velocities")
    gain_margin: WorstMargin | None = si("Factor up, or down, to the stability boundary", "1")
    phase_margin: WorstMargin | None = si("Distance of arg L from -180 degrees", "rad", "deg")
    Ms: WorstMargin | None = si("Peak of the sensitivity", "1")


class TunedAxis(_Document):
    """One axis under a set of gains."""

    k_p: float = si("Proportional gain", "N/m")
    k_d: float = si("Derivative gain", "N s/m")
    metrics: dict[str, GainMetrics] = Field(description="By motor; the scenario's own is first")
    margins: dict[str, GainMargins] = Field(
        description="By motor; empty where the law has no linearisation"
    )


class VerdictDocument(_Document):
    """Evaluation of a set of gains."""

    labels: ClassVar[dict[str, str]] = {"violations": "not held"}

    cost: float | None = Field(description="On the worst motor; null where it diverged")
    feasible: bool = Field(description="Whether it holds every constraint")
    violations: list[str] = Field(description="Constraints that it does not hold, with figures")

    def betters(self, other: VerdictDocument) -> bool:
        """Return whether it is feasible while the other is not, or costs more."""
        if not self.feasible or self.cost is None:
            return False
        return not other.feasible or other.cost is None or self.cost < other.cost


class Candidate(VerdictDocument):
    """A set of gains, tried."""

    origin: Literal["present", "paper", "start"] = Field(
        description="Where it comes from", repr=False
    )
    start: int | None = Field(description="Which start of the simplex led to it", repr=False)
    axes: dict[str, TunedAxis]
    also: dict[str, float] = Field(description="Further numbers of the controller, by path")
    set: dict[str, float] = Field(description="Dotted path to value: puts it into the scenario")

    @property
    def name(self) -> str:
        """What it is called among others."""
        return self.origin if self.start is None else f"{self.origin} {self.start}"


class TuneHistory(_Document):
    """Evaluations of one start of the simplex, in order."""

    gains: dict[str, list[float]] = Field(description="By path below the controller, SI")
    cost: list[float | None] = Field(description="null where a constraint does not hold")


class TunedStart(TuneHistory):
    """One start of the simplex, from its first evaluation to its last."""

    ended: Literal["converged", "evaluations used up"] = Field(
        description="converged: the simplex shrank below half a percent of each gain"
    )

    def derived(self) -> dict[str, int]:
        """Return the number of evaluations."""
        return {"evaluations": len(self.cost)}


class TunedGroup(_Document):
    """Axes that are tuned together."""

    axes: list[str] = Field(repr=False)
    present: Candidate
    paper: Candidate = Field(
        description="The gains that the paper prints for this motion, or else for the pentagram"
    )
    candidates: list[Candidate] = Field(description="What each start came to; the best first")
    starts: list[TunedStart]

    @property
    def name(self) -> str:
        """What it is called among others."""
        return " and ".join(self.axes)


class TuneDocument(_Document):
    """Gains found by the simplex."""

    labels: ClassVar[dict[str, str]] = {"set": "the best of it"}

    scenario: str
    seed: int
    plant: str
    plants: list[str] = Field(description="Motors that the gains are judged on")
    version: str = Field(repr=False)
    model: str = Field(description="Hash of the model's sources", repr=False)
    variant: str
    objective: dict[str, float] = Field(description="Weights of the cost")
    window: list[float] = si("Start and end of the window that is judged", "s")
    evaluations: int = Field(description="Sets of gains that were tried, all starts together")
    groups: list[TunedGroup]
    set: dict[str, float] = Field(
        description="The best candidate of each group, where it betters the present gains",
    )
    warnings: list[str]


class PartialGroup(_Document):
    """Evaluations of one group so far."""

    axes: list[str]
    starts: list[TuneHistory]


class PartialTuning(_Document):
    """Intermediate results of a search."""

    groups: list[PartialGroup]


class AxisLandscape(_Document):
    """The cost of one axis over its gains."""

    stride: int = Field(description="Every which gain of each side is there; 1 at the end")
    k_p: list[float] = si("Along the columns", "N/m")
    k_d: list[float] = si("Along the rows", "N s/m")
    cost: list[list[float | None]] = Field(
        description="Row by row, on the worst motor; null where it diverged"
    )
    limits: dict[str, list[list[float | None]]] = Field(
        default_factory=dict,
        description="What a search can limit, by constraint, row by row, on the worst motor: "
        "gain_margin, phase_margin and Ms as a candidate has them, null where the loop is "
        "unstable, the first at most 1000 and the second at most pi; none of them for a law "
        "without linearisation; saturated and force, null where it diverged",
    )
    edge: list[list[tuple[float, float]]] = Field(
        description="Lines of (k_p, k_d) on which the linearised loop is at the stability "
        "boundary, on the scenario's own motor"
    )
    present: tuple[float, float] = Field(description="k_p and k_d of the scenario")
    paper: tuple[float, float] = Field(
        description="k_p and k_d of the paper for this motion, or else for the pentagram"
    )


class PartialLandscape(_Document):
    """A landscape, coarse at first."""

    axes: dict[str, AxisLandscape]


class LandscapeDocument(PartialLandscape):
    """The cost over the plane of gains, with the stability boundary."""

    scenario: str
    seed: int
    plant: str
    plants: list[str] = Field(
        default_factory=list, description="Motors whose worst counts; the scenario's own is first"
    )
    version: str = Field(repr=False)
    model: str = Field(description="Hash of the model's sources", repr=False)
    variant: str
    objective: dict[str, float] = Field(description="Weights of the cost")
    window: list[float] = si("Start and end of the window that is judged", "s")
    warnings: list[str]
