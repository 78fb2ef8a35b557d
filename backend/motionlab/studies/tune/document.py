"""Results of tuning and of cost maps, for REST and ``--json``."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from motionlab.loop.document import WorstMargin


def _si(description: str, unit: str) -> Any:
    return Field(description=description, json_schema_extra={"unit": unit})


class _Document(BaseModel):
    model_config = ConfigDict(extra="forbid")


class GainMetrics(_Document):
    """Metrics of one axis on one motor over the window; null if it diverged."""

    peak: float | None = _si("Largest following error", "m")
    rms: float | None = _si("Root mean square of the following error", "m")
    itae: float | None = _si("Integral of time times abs(e), from the window's start", "m s^2")
    settling: float | None = _si(
        "Longest settling time of a hold; the window's length without or beyond one", "s"
    )
    effort: float | None = _si("Root mean square of the thrust", "N")
    force: float | None = _si("Largest thrust", "N")
    saturated: float | None = _si("Share of ticks with force or current at its limit", "1")


class GainMargins(_Document):
    """Worst margins of the linearised loop on one motor, stuck and sliding.

    Null where the loop is unstable or has no such crossing.
    """

    stable: bool = Field(description="At each of these velocities")
    gain_margin: WorstMargin | None = _si("Factor up, or down, to the stability boundary", "1")
    phase_margin: WorstMargin | None = _si("Distance of arg L from -180 degrees", "rad")
    Ms: WorstMargin | None = _si("Peak of the sensitivity", "1")


class TunedAxis(_Document):
    """One axis under a set of gains."""

    k_p: float = _si("Proportional gain", "N/m")
    k_d: float = _si("Derivative gain", "N s/m")
    metrics: dict[str, GainMetrics] = Field(description="By motor; the scenario's own is first")
    margins: dict[str, GainMargins] = Field(
        description="By motor; empty where the law has no linearisation"
    )


class VerdictDocument(_Document):
    """Evaluation of a set of gains."""

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

    origin: Literal["present", "paper", "start"] = Field(description="Where it comes from")
    start: int | None = Field(description="Which start of the simplex led to it")
    axes: dict[str, TunedAxis]
    also: dict[str, float] = Field(description="Further numbers of the controller, by path")
    set: dict[str, float] = Field(description="Dotted path to value: puts it into the scenario")


class TuneHistory(_Document):
    """Evaluations of one start of the simplex, in order."""

    gains: dict[str, list[float]] = Field(description="By path below the controller, SI")
    cost: list[float | None] = Field(description="null where a constraint does not hold")


class TunedStart(TuneHistory):
    """One start of the simplex, from its first evaluation to its last."""

    ended: Literal["converged", "evaluations used up"] = Field(
        description="converged: the simplex shrank below half a percent of each gain"
    )


class TunedGroup(_Document):
    """Axes that are tuned together."""

    axes: list[str]
    present: Candidate
    paper: Candidate = Field(description="The gains that the paper prints for this motion")
    candidates: list[Candidate] = Field(description="What each start came to; the best first")
    starts: list[TunedStart]


class TuneDocument(_Document):
    """Gains found by the simplex."""

    scenario: str
    seed: int
    plant: str
    plants: list[str] = Field(description="Motors that the gains are judged on")
    version: str
    model: str = Field(description="Hash of the model's sources")
    variant: str
    objective: dict[str, float] = Field(description="Weights of the cost")
    window: list[float] = _si("Start and end of the window that is judged", "s")
    evaluations: int = Field(description="Sets of gains that were tried, all starts together")
    groups: list[TunedGroup]
    set: dict[str, float] = Field(
        description="The best candidate of each group, where it betters the present gains"
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
    k_p: list[float] = _si("Along the columns", "N/m")
    k_d: list[float] = _si("Along the rows", "N s/m")
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
    paper: tuple[float, float] = Field(description="k_p and k_d of the paper for this motion")


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
    version: str
    model: str = Field(description="Hash of the model's sources")
    variant: str
    objective: dict[str, float] = Field(description="Weights of the cost")
    window: list[float] = _si("Start and end of the window that is judged", "s")
    warnings: list[str]
