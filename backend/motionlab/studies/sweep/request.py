"""Request of a sweep: its fields and how their values are combined, objectives and limits."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import product
from typing import Annotated, Any, Literal, Self, get_args

import numpy as np
from pydantic import Field, model_validator

from motionlab.config.changes import twice
from motionlab.config.quantity import Config, quantity
from motionlab.config.validation_errors import checked
from motionlab.declarations import OURS

CASES_MAX = 10_000
_ROUNDING = 1e-12  # of the values of a range, relative
_Text = Annotated[str, Field(max_length=200)]
Value = bool | int | float | _Text
"""A value of a field; text also names a shipped part, as in ``plant``."""

Sampling = Literal["random", "latin-hypercube", "sobol"]
SAMPLINGS: tuple[str, ...] = get_args(Sampling)
"""Ways to draw cases from the ranges of all fields at once."""
Searcher = Literal["cma-es", "nsga-ii", "tpe", "gp"]
SEARCHERS: tuple[str, ...] = get_args(Searcher)


class Dimension(Config):
    """One swept field: its values one by one, or a range of numbers."""

    path: str = Field(
        min_length=1,
        max_length=200,
        description="Dotted path of a field of the scenario, such as variants.B.controller.x.k_p",
    )
    values: Annotated[tuple[Value, ...], Field(strict=False, min_length=1)] | None = Field(
        default=None, max_length=CASES_MAX, description="Values, or names of shipped parts"
    )
    start: float | None = Field(default=None, description="First value of a range")
    stop: float | None = Field(default=None, description="Last value of a range")
    count: int | None = quantity(
        "Values in a range, ends included; none where samples says how many cases there are",
        unit="1",
        source=OURS,
        default=None,
        ge=2,
        le=CASES_MAX,
    )
    scale: Literal["linear", "log"] = Field(default="linear", description="Spacing of a range")

    @model_validator(mode="after")
    def _is_values_or_range(self) -> Self:
        ends = (self.start, self.stop)
        if self.values is not None:
            if any(end is not None for end in (*ends, self.count)):
                raise ValueError("takes values, or start, stop and count, not both")
        elif self.start is None or self.stop is None:
            raise ValueError("needs values, or start, stop and count")
        elif not math.isfinite(self.stop - self.start):
            raise ValueError("is too wide a range")
        elif self.scale == "log" and (self.start <= 0.0 or self.stop <= 0.0):
            raise ValueError("a logarithmic range needs start and stop above 0")
        return self

    def points(self, *, whole: bool = False) -> list[Any]:
        """Return the values, in order.

        Raises
        ------
        ValueError
            If a range gives `whole` a fraction.
        """
        if self.values is not None:
            return list(self.values)
        start, stop = self.ends
        assert self.count is not None
        if self.scale == "linear":
            points = np.linspace(start, stop, self.count).tolist()
        else:
            inner = np.geomspace(start, stop, self.count).tolist()[1:-1]
            points = [start, *inner, stop]
        return [_whole(value) for value in points] if whole else points

    @property
    def ends(self) -> tuple[float, float]:
        """First and last value of a range."""
        assert self.start is not None and self.stop is not None
        return self.start, self.stop

    def place(self, value: Any) -> str:
        """Return where a value of the field stands below it: ``values.2``, ``start`` or ``stop``.

        Empty inside of a range.
        """
        if self.values is None:
            return {self.start: "start", self.stop: "stop"}.get(value, "")
        texts = [repr(each) for each in self.values]  # true equals 1, and NaN not even itself
        return f"values.{texts.index(repr(value))}"

    def at(self, share: float, *, whole: bool = False) -> Any:
        """Return the value at a share, 0 to 1, of the range or the values.

        Values, and whole numbers of a range, have equal shares.

        Raises
        ------
        ValueError
            If an end of a range is a fraction where the field is `whole`.
        """
        if self.values is not None:
            return self.values[min(int(share * len(self.values)), len(self.values) - 1)]
        start, stop = self.ends
        if whole:
            low, high = sorted((_whole(start), _whole(stop)))
            return min(low + int(share * (high - low + 1)), high)
        if self.scale == "log":
            return float(start * (stop / start) ** share)
        return float(start + (stop - start) * share)


class Limit(Config):
    """A bound on a metric."""

    of: str = Field(max_length=100, description="Metric as in objectives: B.worst.gain_margin")
    at_least: float | None = Field(default=None, description="Least value, SI; margins as factors")
    at_most: float | None = Field(default=None, description="Largest value, SI")

    @model_validator(mode="after")
    def _bounds(self) -> Self:
        low, high = self.at_least, self.at_most
        if low is None and high is None:
            raise ValueError("needs at_least or at_most")
        if low is not None and high is not None and low > high:
            raise ValueError(f"at_least, {low:g}, is above at_most, {high:g}")
        return self


class SweepRequest(Config):
    """A scenario and the fields that are swept."""

    scenario: str | dict[str, Any] = Field(
        default="circle", description="Name of a shipped scenario, or its tables"
    )
    set: dict[str, Any] = Field(
        default_factory=dict, max_length=4096, description="Dotted path to value, SI"
    )
    grid: Annotated[tuple[Dimension, ...], Field(strict=False, min_length=1, max_length=6)] = Field(
        description="Swept fields; of a grid the last one changes fastest"
    )
    combine: Literal["grid", "list", Sampling, "search"] = Field(
        default="grid",
        description="grid: every combination of values; list: first with first, second with "
        "second; random, latin-hypercube, sobol: cases drawn from all ranges at once; search: "
        "cases chosen for the least objectives",
    )
    samples: int | None = quantity(
        "Cases that are drawn or searched; none of a grid or a list",
        unit="1",
        source=OURS,
        default=None,
        ge=1,
        le=CASES_MAX,
    )
    sampling_seed: int | None = quantity(
        "Seed of what is drawn or searched, left out 0; none of a grid or a list",
        unit="1",
        source=OURS,
        default=None,
        ge=0,
        le=2**32 - 1,
    )
    searcher: Searcher | None = Field(
        default=None,
        description="How a search chooses cases; left out, cma-es for one objective over ranges, "
        "tpe over names, nsga-ii for several objectives",
    )
    objectives: Annotated[tuple[str, ...], Field(strict=False)] = Field(
        default=(),
        max_length=4,
        description="Metrics as VARIANT.AXIS.METRIC, AXIS x, y or worst: B.worst.max_abs_force",
    )
    limits: Annotated[tuple[Limit, ...], Field(strict=False)] = Field(
        default=(), max_length=8, description="What a case has to meet"
    )

    @model_validator(mode="after")
    def _is_a_grid(self) -> Self:
        for path, other in twice(dimension.path for dimension in self.grid):
            raise ValueError(f"{path} is swept twice" + (f", also as {other}" * (other != path)))
        if self.drawn:
            self._is_drawn()
            return self
        for name in ("samples", "sampling_seed", "searcher"):
            if getattr(self, name) is not None:
                raise ValueError(f"{name} is for cases that are drawn or searched, not of a grid")
        for index, dimension in enumerate(self.grid):
            if dimension.values is None and dimension.count is None:
                raise ValueError(f"grid.{index} needs values, or start, stop and count")
        sizes = [_size(dimension) for dimension in self.grid]
        if self.combine == "list" and len(set(sizes)) > 1:
            raise ValueError(f"a list needs as many values of each field, not {sizes}")
        cases = math.prod(self.shape)
        if cases > CASES_MAX:
            raise ValueError(f"{cases} cases are more than {CASES_MAX}")
        return self

    def _is_drawn(self) -> None:
        if self.samples is None:
            raise ValueError(f"{self.combine} needs samples, the number of cases")
        for index, dimension in enumerate(self.grid):
            if dimension.count is not None:
                raise ValueError(f"grid.{index}.count is for a grid: samples is the number here")
        if self.combine != "search":
            if self.searcher is not None:
                raise ValueError("searcher is for combine = search")
            return
        if not self.objectives:
            raise ValueError("a search needs objectives")
        if len(self.objectives) > 1 and self.searcher == "cma-es":
            raise ValueError("cma-es takes one objective; nsga-ii, tpe and gp take several")
        if self.searcher == "cma-es" and any(each.values is not None for each in self.grid):
            raise ValueError("cma-es takes ranges of numbers, no values one by one")

    @property
    def drawn(self) -> bool:
        """Whether cases are drawn or searched, not listed."""
        return self.combine not in {"grid", "list"}

    @property
    def seed(self) -> int:
        """Seed of what is drawn or searched."""
        return self.sampling_seed or 0

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values along each dimension of the result; one dimension but for a grid."""
        if self.drawn:
            return (self.samples or 0,)
        sizes = tuple(_size(dimension) for dimension in self.grid)
        return sizes[:1] if self.combine == "list" else sizes

    def place_of(self, field: str, case: Mapping[str, Any]) -> str:
        """Return which part of the request gives a field of a case: ``grid.0.values.2``.

        Of several that belong to it, ``grid``.
        """
        places = [
            (index, dimension.place(case[dimension.path]))
            for index, dimension in enumerate(self.grid)
            if dimension.path in case and _contains(field, dimension.path)
        ]
        if len(places) != 1:
            return "grid"
        index, place = places[0]
        return f"grid.{index}" + (f".{place}" if place else "")

    def cases(self, points: Sequence[Sequence[Any]]) -> list[dict[str, Any]]:
        """Return the changes of each case, dotted path to value, of the values of each field."""
        paths = [dimension.path for dimension in self.grid]
        rows = product(*points) if self.combine == "grid" else zip(*points, strict=True)
        return [dict(zip(paths, row, strict=True)) for row in rows]


def read_request(request: Mapping[str, Any]) -> SweepRequest:
    """Return a request, checked; raise ConfigError naming every field that is wrong."""
    return checked(SweepRequest, request, "sweep")


def _contains(one: str, other: str) -> bool:
    """Return whether one of two dotted paths is the other, or a part of it."""
    short, long = sorted((f"{one}.", f"{other}."), key=len)
    return long.startswith(short)


def _whole(value: float) -> int:
    near = round(value)
    if abs(value - near) > _ROUNDING * max(1.0, abs(value)):
        raise ValueError(f"takes whole numbers, and the range gives {value:.6g}: list its values")
    return near


def _size(dimension: Dimension) -> int:
    return len(dimension.values) if dimension.values is not None else dimension.count or 0
