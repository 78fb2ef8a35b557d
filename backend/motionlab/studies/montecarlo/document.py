"""The result of a Monte Carlo study, as REST answers and ``--json`` prints it."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from motionlab.studies.montecarlo.request import Spec, Variation


def _si(description: str, unit: str) -> Any:
    return Field(description=description, json_schema_extra={"unit": unit})


class _Document(BaseModel):
    model_config = ConfigDict(extra="forbid")


class Quantiles(_Document):
    """Quantiles of a number over the cases that have it."""

    min: float
    q05: float = Field(description="5 % of the cases are below")
    q50: float = Field(description="Median")
    q95: float = Field(description="95 % of the cases are below")
    max: float
    cases: int = Field(description="Cases that have the number")


class Band(_Document):
    """Following error over time: quantiles over cases at each time, extremes until the next."""

    min: list[float] = _si("Least of all cases until the next time", "m")
    q05: list[float] = _si("5 % of the cases are below", "m")
    q25: list[float] = _si("25 % of the cases are below", "m")
    q50: list[float] = _si("Median", "m")
    q75: list[float] = _si("75 % of the cases are below", "m")
    q95: list[float] = _si("95 % of the cases are below", "m")
    max: list[float] = _si("Greatest of all cases until the next time", "m")


class Histogram(_Document):
    """How many cases of each variant lie in which bin of a metric."""

    edges: list[float] = Field(description="SI; a bin takes its lower edge, the last one both")
    log: bool = Field(description="Whether the bins are equally wide in logarithm")
    counts: dict[str, list[int]] = Field(
        description="By variant; a case without the metric is in no bin"
    )


class DrawnParameter(_Document):
    """A number of an axis of the plant that differs from case to case."""

    path: str = Field(description="Dotted path below plant.x or plant.y")
    of: Literal["value", "deviation"] = Field(
        description="deviation: size of its difference from the scenario's own, of what is drawn "
        "in logarithm of their ratio's logarithm"
    )


class MonteCarloAxis(_Document):
    """One axis of one variant over all cases."""

    metrics: dict[str, Quantiles | None] = Field(
        description="Metrics of a run by name, SI; null where no case has it"
    )
    band: Band | None = Field(description="null where every case diverged")
    peaks: list[float | None] = Field(
        description="Largest following error of each case, m; null where it diverged or could not "
        "follow"
    )
    correlations: dict[str, list[float | None]] = Field(
        default_factory=dict,
        description="By metric, Spearman's rho with each of `parameters` over the cases that can "
        "follow; a case without the metric ranks above all others; null where either is the same "
        "in every case",
    )


class Probability(_Document):
    """Share of the cases that meet a spec, with its confidence interval."""

    share: float
    low: float = Field(description="Lower end of the 95 % interval, after Wilson")
    high: float = Field(description="Upper end")


class MonteCarloVariant(_Document):
    """One controller over all cases."""

    label: str
    law: str
    enabled: bool
    diverged: int = Field(description="Cases in which it diverged")
    axes: dict[str, MonteCarloAxis]
    meets: Probability | None = Field(description="Of the spec; null without one")


class WorstCase(_Document):
    """A case among the worst, ready to be run again."""

    variant: str
    axis: str
    case: int
    value: float | None = Field(description="Largest following error, m; null where it diverged")
    set: dict[str, Any] = Field(
        description="Dotted path to value: changes that make the plant of this case, and what a "
        "time-optimal path is planned for, where the scenario leaves that out"
    )


class MonteCarloDocument(_Document):
    """Many plausible plants under the same controllers."""

    scenario: str
    plant: str
    version: str
    model: str = Field(description="Hash of the model's sources")
    cases: int
    seed: int = Field(description="Of the draws")
    vary: list[Variation]
    notes: list[str]
    infeasible: int = Field(description="Cases whose plant cannot follow the motion")
    window: dict[str, float] = _si("Of metrics and bands: start and end", "s")
    time: list[float] = _si("Times of the bands", "s")
    spec: Spec
    variants: dict[str, MonteCarloVariant]
    histograms: dict[str, dict[str, Histogram | None]] = Field(
        default_factory=dict,
        description="By axis and metric; null where all values are the same",
    )
    parameters: dict[str, list[DrawnParameter]] = Field(
        default_factory=dict, description="By axis: what differs from case to case"
    )
    significant: float = Field(
        default=1.0,
        description="Size of rho that chance exceeds, for any of the parameters, in one of twenty "
        "studies",
    )
    improvement: dict[str, dict[str, Quantiles | None]] = Field(
        description="By axis and metric: 1 - B/A of each case, of the first two variants"
    )
    table: dict[str, list[float | None]] | None = Field(
        default=None,
        description="Values of each case, SI, where the request wants them: drawn numbers by "
        "dotted path, metrics by variant, axis and name, as in B.x.rms_following_error; null where "
        "a case has no such value",
    )
    worst: list[WorstCase] = Field(
        description="The worst of each variant and axis, the worst first"
    )
