"""Request, document and text report of a Monte Carlo study."""

from __future__ import annotations

from collections.abc import Mapping
from math import isinf
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from motionlab.config.quantity import Config, quantity, si
from motionlab.config.validation_errors import checked
from motionlab.declarations import OURS

CASES_MAX = 5000
_PEAK = "max_abs_following_error"
_DECIDING = 5  # parameters of an axis

Kind = Literal["log-normal", "normal", "uniform", "log-uniform", "value"]


class Variation(Config):
    """Distribution of one parameter of each axis of the plant."""

    path: str = Field(
        description="Dotted path below plant.x and plant.y, such as friction.F_s; of a list every "
        "item is drawn on its own",
        pattern=r"^(mass|(friction|force_map|amplifiers|encoder|resonance)\.[A-Za-z0-9_]{1,40})$",
    )
    kind: Kind = Field(
        description="log-normal: times exp(sigma n); normal: plus sigma n, n standard normal; "
        "uniform and log-uniform: from low to high; value: replaced"
    )
    sigma: float | None = Field(
        default=None,
        ge=0.0,
        le=1e9,
        description="Standard deviation: of the logarithm, or in the number's own unit",
    )
    low: float | None = Field(default=None, description="Lower end, in the number's own unit")
    high: float | None = Field(default=None, description="Upper end")
    value: float | None = Field(default=None, description="What it is in every case")

    @model_validator(mode="after")
    def _says_how_much(self) -> Self:
        takes = {
            "log-normal": ("sigma",),
            "normal": ("sigma",),
            "uniform": ("low", "high"),
            "log-uniform": ("low", "high"),
            "value": ("value",),
        }[self.kind]
        for name in ("sigma", "low", "high", "value"):
            if (getattr(self, name) is None) == (name in takes):
                raise ValueError(f"{self.kind} takes {' and '.join(takes)}, and nothing else")
        if self.low is not None and self.high is not None and self.low > self.high:
            raise ValueError(f"low = {self.low:g} is above high = {self.high:g}")
        if self.low is not None and self.high is not None and isinf(self.high - self.low):
            raise ValueError(f"low = {self.low:g} and high = {self.high:g} are too far apart")
        if self.kind == "log-uniform" and self.low is not None and self.low <= 0.0:
            raise ValueError(f"low = {self.low:g} has no logarithm: above 0 for log-uniform")
        if self.kind == "log-normal" and self.sigma is not None and self.sigma > _SIGMA_MAX:
            raise ValueError(f"sigma = {self.sigma:g} of a logarithm: at most {_SIGMA_MAX:g}")
        return self


_SIGMA_MAX = 3.0

DEFAULT = (
    Variation(path="friction.F_s", kind="log-normal", sigma=0.25),
    Variation(path="friction.F_c", kind="log-normal", sigma=0.4),
    Variation(path="friction.v_s", kind="log-normal", sigma=0.4),
    Variation(path="friction.sigma_0", kind="log-normal", sigma=0.2),
    Variation(path="friction.sigma_1", kind="log-normal", sigma=0.4),
    Variation(path="friction.sigma_2", kind="log-normal", sigma=0.3),
    Variation(path="force_map.F_pk", kind="value", value=38.4),
    Variation(path="force_map.h_2", kind="uniform", low=-0.05, high=0.05),
    Variation(path="force_map.h_3", kind="value", value=0.039),
    Variation(path="force_map.offset", kind="normal", sigma=5e-5),
    Variation(path="amplifiers.offset", kind="normal", sigma=0.1),
    Variation(path="amplifiers.gain", kind="normal", sigma=0.03),
    Variation(path="amplifiers.bandwidth", kind="log-uniform", low=300.0, high=2000.0),
    Variation(path="encoder.sde_amplitude", kind="value", value=40e-9),
)
"""Plausible plants: unknown properties of the paper's machine, by this project's judgement; the
thrust is the one that the paper measured."""


class Spec(Config):
    """Largest following error that is allowed."""

    x: float | None = quantity(
        "Largest following error allowed on x; left out: any",
        unit="m",
        source=OURS,
        default=None,
        gt=0,
        le=1,
    )
    y: float | None = quantity(
        "Largest following error allowed on y; left out: any",
        unit="m",
        source=OURS,
        default=None,
        gt=0,
        le=1,
    )


class MonteCarloRequest(Config):
    """Scenario, number of plants, and their variations."""

    scenario: str | dict[str, Any] = Field(
        default="circle", description="Name of a shipped scenario, or its tables"
    )
    set: dict[str, Any] = Field(
        default_factory=dict, max_length=4096, description="Dotted path to value, SI"
    )
    cases: int = quantity(
        "Plants to draw",
        label="number of plants",
        unit="1",
        source=OURS,
        default=300,
        ge=2,
        le=CASES_MAX,
    )
    seed: int | None = quantity(
        "Seed of the draws; left out: the scenario's",
        unit="1",
        source=OURS,
        default=None,
        ge=0,
        le=2**53 - 1,
    )
    vary: Annotated[tuple[Variation, ...], Field(strict=False, min_length=1, max_length=100)] = (
        Field(default=DEFAULT, description="How the plants differ; left out: docs/montecarlo.md")
    )
    spec: Spec = Spec()
    table: bool = Field(
        default=False, description="Whether to answer every metric and drawn number of each case"
    )

    @model_validator(mode="after")
    def _paths_differ(self) -> Self:
        paths = [variation.path for variation in self.vary]
        twice = next((path for path in paths if paths.count(path) > 1), None)
        if twice is not None:
            raise ValueError(f"{twice} is varied twice")
        return self


def read_request(request: Mapping[str, Any]) -> MonteCarloRequest:
    """Return a request, checked; raise ConfigError naming every field that is wrong."""
    return checked(MonteCarloRequest, request, "montecarlo")


class _Document(BaseModel):
    model_config = ConfigDict(extra="forbid")


class Quantiles(_Document):
    """Quantiles of a number over the cases that have it."""

    labels: ClassVar[dict[str, str]] = {"q05": "5 %", "q50": "50 %", "q95": "95 %"}

    min: float
    q05: float = Field(description="5 % of the cases are below")
    q50: float = Field(description="Median")
    q95: float = Field(description="95 % of the cases are below")
    max: float
    cases: int = Field(description="Cases that have the number")


class Band(_Document):
    """Following error over time: quantiles over cases at each time, extremes until the next."""

    min: list[float] = si("Least of all cases until the next time", "m")
    q05: list[float] = si("5 % of the cases are below", "m")
    q25: list[float] = si("25 % of the cases are below", "m")
    q50: list[float] = si("Median", "m")
    q75: list[float] = si("75 % of the cases are below", "m")
    q95: list[float] = si("95 % of the cases are below", "m")
    max: list[float] = si("Greatest of all cases until the next time", "m")


class Histogram(_Document):
    """Counts of the cases of each variant by bins of a metric."""

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
        repr=False,
        description="Largest following error of each case, m; null where it diverged or could not "
        "follow",
    )
    correlations: dict[str, list[float | None]] = Field(
        default_factory=dict,
        description="By metric, Spearman's rho with each of `parameters` over the cases that can "
        "follow; a case without the metric ranks above all others; null where either is the same "
        "in every case",
    )


class Probability(_Document):
    """Share of the cases that meet a spec, with its confidence interval."""

    share: float = si(
        "Of all cases",
        "1",
        "%",
    )
    low: float = si(
        "Lower end of the 95 % interval, after Wilson",
        "1",
        "%",
    )
    high: float = si(
        "Upper end",
        "1",
        "%",
    )


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

    labels: ClassVar[dict[str, str]] = {
        "infeasible": "cannot follow the motion",
        "worst": "worst cases, --case N for what makes one",
    }

    scenario: str
    plant: str
    version: str = Field(repr=False)
    model: str = Field(description="Hash of the model's sources", repr=False)
    cases: int
    seed: int = Field(description="Of the draws")
    vary: list[Variation] = Field(repr=False)
    notes: list[str]
    infeasible: int = Field(description="Cases whose plant cannot follow the motion")
    window: dict[str, float] = si("Of metrics and bands: start and end", "s")
    time: list[float] = si("Times of the bands", "s")
    spec: Spec
    variants: dict[str, MonteCarloVariant]
    histograms: dict[str, dict[str, Histogram | None]] = Field(
        repr=False,
        default_factory=dict,
        description="By axis and metric; null where all values are the same",
    )
    parameters: dict[str, list[DrawnParameter]] = Field(
        repr=False, default_factory=dict, description="By axis: what differs from case to case"
    )
    significant: float = Field(
        repr=False,
        default=1.0,
        description="Size of rho that chance exceeds, for any of the parameters, in one of twenty "
        "studies",
    )
    improvement: dict[str, dict[str, Quantiles | None]] = si(
        "By axis and metric: 1 - B/A of each case, of the first two variants",
        "1",
        "%",
    )
    table: dict[str, list[float | None]] | None = Field(
        repr=False,
        default=None,
        description="Values of each case, SI, where the request wants them: drawn numbers by "
        "dotted path, metrics by variant, axis and name, as in B.x.rms_following_error; null where "
        "a case has no such value",
    )
    worst: list[WorstCase] = Field(
        description="The worst of each variant and axis, the worst first",
    )

    @property
    def foot(self) -> str:
        """What the correlations are."""
        return (
            "Goes with: rank correlation of max |e| with what was drawn, over the drawn range; "
            f"chance exceeds {self.significant:.2f} for any of them once in twenty studies."
        )

    def derived(self) -> dict[str, str]:
        """Return what correlates most with the largest following errors.

        Of value and deviation of a parameter only the one that correlates more.
        """
        decisive = {}
        for name, variant in self.variants.items():
            for axis, part in variant.axes.items():
                rhos = part.correlations[_PEAK]
                strongest: dict[str, tuple[float, str]] = {}
                for parameter, rho in zip(self.parameters[axis], rhos, strict=True):
                    known = abs(strongest.get(parameter.path, (self.significant, ""))[0])
                    if rho is not None and abs(rho) > known:
                        strongest[parameter.path] = rho, parameter.of
                most = sorted(strongest.items(), key=lambda entry: -abs(entry[1][0]))[:_DECIDING]
                decisive[f"max |e| of {name} {axis} goes with"] = ", ".join(
                    f"{'deviation of ' * (of == 'deviation')}{path} {rho:+.2f}"
                    for path, (rho, of) in most
                )
        return {label: text or "none beyond chance" for label, text in decisive.items()}
