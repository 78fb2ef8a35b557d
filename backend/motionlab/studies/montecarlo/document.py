"""The result of a Monte Carlo study, as REST answers and ``--json`` prints it."""

from __future__ import annotations

from typing import Any

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
        description="Dotted path to value: changes that make the plant of this case"
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
    improvement: dict[str, dict[str, Quantiles | None]] = Field(
        description="By axis and metric: 1 - B/A of each case, of the first two variants"
    )
    worst: list[WorstCase] = Field(
        description="The worst of each variant and axis, the worst first"
    )
