"""Figures that cases are compared by: objectives, limits, and the front between objectives."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motionlab.analysis.metrics import DEFINITIONS
from motionlab.config.planar import AXES
from motionlab.config.scenario import Scenario
from motionlab.errors import ConfigError, FieldError
from motionlab.loop.family import family_of
from motionlab.studies.sweep.request import Limit, SweepRequest

Array = NDArray[np.float64]

MARGIN_UNITS = {"gain_margin": "1", "phase_margin": "rad"}
"""Metrics of the linearised loop, over standstill and sliding: `motionlab.loop.family`."""
WORST = "worst"
_SIGNED = ("min_following_error", "max_following_error", "mean_following_error")
METRICS = (*DEFINITIONS, *MARGIN_UNITS)
"""What a figure may be of."""
_DIRECTED = tuple(name for name in METRICS if name not in _SIGNED)  # less, or more, is better
_PARTS = 3


@dataclass(frozen=True)
class Figure:
    """A metric of one controller, of one axis or of the worse one.

    Attributes
    ----------
    variant : str
        Which controller.
    axis : str
        ``x``, ``y`` or ``worst``.
    metric : str
        Of `DEFINITIONS` or `MARGIN_UNITS`.
    """

    variant: str
    axis: str
    metric: str

    @property
    def name(self) -> str:
        """As it is written in a request: ``B.worst.gain_margin``."""
        return f"{self.variant}.{self.axis}.{self.metric}"

    @property
    def is_margin(self) -> bool:
        """Whether it comes from the loop, not from a run."""
        return self.metric in MARGIN_UNITS

    @property
    def unit(self) -> str:
        """SI unit."""
        return MARGIN_UNITS[self.metric] if self.is_margin else DEFINITIONS[self.metric].unit

    @property
    def falls(self) -> bool:
        """Whether less is better."""
        return not self.is_margin

    def of(self, metrics: Mapping[str, Array], variants: Sequence[str]) -> Array:
        """Return its value in each case, NaN where a case has none.

        Parameters
        ----------
        metrics : mapping of str to ndarray, shape (cases, variants, axes)
            Metrics of all cases.
        variants : sequence of str
            Second axis of the arrays.
        """
        values = metrics[self.metric][:, list(variants).index(self.variant)]
        if self.axis != WORST:
            return values[:, AXES.index(self.axis)]
        none = np.isnan(values).all(axis=1)
        worse = np.fmax if self.falls else np.fmin
        return np.where(none, math.nan, worse.reduce(values, axis=1))


def figure(name: str, scenario: Scenario, loc: str, metrics: Sequence[str] = METRICS) -> Figure:
    """Return the figure that a name stands for, of some metrics.

    Raises
    ------
    ConfigError
        If the scenario has no such controller, or there is no such axis or metric.
    """
    parts = name.split(".")
    if len(parts) != _PARTS:
        raise ConfigError(FieldError(loc, "is no metric", name, "VARIANT.AXIS.METRIC"))
    variant, axis, metric = parts
    known = {
        "controller": (variant, list(scenario.variants)),
        "axis": (axis, [*AXES, WORST]),
        "metric": (metric, metrics),
    }
    for what, (value, allowed) in known.items():
        if value in allowed:
            continue
        message = f"names no {what}"
        if value in _SIGNED:
            message = "has a sign: neither less of it nor more is better"
        raise ConfigError(FieldError(loc, message, value, "one of " + ", ".join(allowed)))
    return Figure(variant, axis, metric)


@dataclass(frozen=True)
class Criteria:
    """What cases are compared by.

    Attributes
    ----------
    objectives : tuple of Figure
        What is to be least, or largest.
    limits : tuple of (Figure, Limit)
        What a case has to meet.
    """

    objectives: tuple[Figure, ...] = ()
    limits: tuple[tuple[Figure, Limit], ...] = ()

    @classmethod
    def of(cls, request: SweepRequest, scenario: Scenario) -> Criteria:
        """Return those of a request; raise ConfigError naming one that means nothing."""
        objectives = tuple(
            figure(name, scenario, f"objectives.{index}", _DIRECTED)
            for index, name in enumerate(request.objectives)
        )
        for index, each in enumerate(objectives):
            if each in objectives[:index]:
                raise ConfigError(FieldError(f"objectives.{index}", "is there twice", each.name))
        limits = tuple(
            (figure(limit.of, scenario, f"limits.{index}.of"), limit)
            for index, limit in enumerate(request.limits)
        )
        return cls(objectives, limits)

    @property
    def figures(self) -> tuple[Figure, ...]:
        """All of them, each once."""
        return tuple(dict.fromkeys((*self.objectives, *(each for each, _ in self.limits))))

    @property
    def loops(self) -> tuple[tuple[str, str], ...]:
        """Controllers and axes whose margins are needed."""
        return tuple(
            dict.fromkeys(
                (each.variant, axis)
                for each in self.figures
                if each.is_margin
                for axis in (AXES if each.axis == WORST else (each.axis,))
            )
        )

    def excess(self, metrics: Mapping[str, Array], variants: Sequence[str]) -> Array:
        """Return by how much each case exceeds each limit, shape (cases, limits).

        In shares of the bound; at most 0 where it is met, infinite where a case has no value.
        """
        columns = []
        for each, limit in self.limits:
            values = each.of(metrics, variants)
            over = np.full(len(values), -math.inf)
            for bound, sign in ((limit.at_most, 1.0), (limit.at_least, -1.0)):
                if bound is not None:
                    over = np.fmax(over, sign * (values - bound) / (abs(bound) or 1.0))
            over[np.isnan(values)] = math.inf
            columns.append(over)
        count = len(next(iter(metrics.values())))
        return np.column_stack(columns) if columns else np.empty((count, 0))

    def costs(self, metrics: Mapping[str, Array], variants: Sequence[str]) -> Array:
        """Return the objectives as numbers of which less is better, shape (cases, objectives)."""
        columns = [
            (1.0 if each.falls else -1.0) * each.of(metrics, variants) for each in self.objectives
        ]
        count = len(next(iter(metrics.values())))
        return np.column_stack(columns) if columns else np.empty((count, 0))


def front_of(costs: Array, met: NDArray[np.bool_]) -> list[int]:
    """Return the cases that no other is better than in one objective and as good in the rest.

    Parameters
    ----------
    costs : ndarray, shape (cases, objectives)
        Less is better; a case with NaN is none.
    met : ndarray of bool, shape (cases,)
        Whether a case meets all limits.

    Returns
    -------
    list of int
        By the first objective; of equal cases the first.
    """
    if costs.shape[1] == 0:
        return []
    able = np.flatnonzero(met & np.isfinite(costs).all(axis=1))
    order = able[np.lexsort((able, *costs[able].T[::-1]))]
    front: list[int] = []
    for case in order.tolist():
        others = costs[front]
        if not front or not (others <= costs[case]).all(axis=1).any():
            front.append(case)
    return front


def margins_of_case(scenario: Scenario, loops: Sequence[tuple[str, str]]) -> dict[str, Array]:
    """Return the least margins of some loops, shape (variants, axes), NaN of the others.

    They are those that a run keeps: at standstill and from 0.5 to 4 Stribeck velocities; NaN, too,
    of a loop that is unstable or has no linearisation, infinite where nothing crosses.
    """
    variants = list(scenario.variants)
    margins = {name: np.full((len(variants), len(AXES)), math.nan) for name in MARGIN_UNITS}
    for variant, axis in loops:
        try:
            family = family_of(scenario, variant, axis)
        except ConfigError:
            continue
        gains = getattr(scenario.variants[variant].controller, axis)
        worst = family.margins_over(np.array([gains.k_p]), np.array([gains.k_d]))
        for name, values in margins.items():
            values[variants.index(variant), AXES.index(axis)] = worst[name][0]
    return margins
