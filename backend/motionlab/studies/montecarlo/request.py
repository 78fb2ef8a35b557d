"""Requests of Monte Carlo studies: number of plants and their distributions."""

from __future__ import annotations

from collections.abc import Mapping
from math import isinf
from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from motionlab.config.quantity import OURS, Config, quantity
from motionlab.config.validation_errors import checked

CASES_MAX = 5000

Kind = Literal["log-normal", "normal", "uniform", "log-uniform", "value"]


class Variation(Config):
    """How one number of each axis of the plant differs from case to case."""

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
    cases: int = quantity("Plants to draw", unit="1", source=OURS, default=300, ge=2, le=CASES_MAX)
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
