"""Axes that are tuned together: searched parameters, points of the search."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from motionlab.config.controller import ControllerConfig, GainsConfig
from motionlab.kernel.build import lane
from motionlab.loop.family import LoopFamily
from motionlab.loop.linearise import NoLinearisation
from motionlab.studies.tune.problem import TuningProblem
from motionlab.studies.tune.request import TuneRequest

Array = NDArray[np.float64]

_DRAWS = 100
"""Draws of a start until one is stable; then the last is taken as it is."""


@dataclass(frozen=True)
class Group:
    """Axes that are tuned together; points are logarithms of the searched parameters.

    Attributes
    ----------
    problem : TuningProblem
        Of a `TuneRequest`.
    axes : tuple of str
        One axis; both where they share a number that is searched.
    """

    problem: TuningProblem
    axes: tuple[str, ...]

    @property
    def request(self) -> TuneRequest:
        """The request."""
        request = self.problem.request
        assert isinstance(request, TuneRequest)
        return request

    @cached_property
    def fields(self) -> dict[str, tuple[float, float]]:
        """Searched fields by path below the controller: low and high."""
        request = self.request
        gains = {
            f"{axis}.{name}": getattr(request.bounds, name)
            for axis in self.axes
            for name in ("k_p", "k_d")
        }
        return gains | {str(path): ends for path, ends in request.also.items()}

    @property
    def bounds(self) -> Array:
        """Logarithms of low and high, shape (n, 2)."""
        return np.log(np.array(list(self.fields.values())))

    def values(self, point: Array) -> dict[str, float]:
        """Return the numbers of a point, by path."""
        return dict(zip(self.fields, np.exp(point).tolist(), strict=True))

    def point(self, controller: ControllerConfig) -> Array:
        """Return where a controller lies, moved inside the bounds."""
        low, high = self.bounds.T
        numbers = self.values_of(controller).values()
        return np.clip([math.log(x) if x else -math.inf for x in numbers], low, high)

    def values_of(self, controller: ControllerConfig) -> dict[str, float]:
        """Return a controller's own numbers, by path."""
        numbers: dict[str, float] = {}
        for path in self.fields:
            part, field = path.split(".")
            value = getattr(getattr(controller, part), field)
            if value is None:  # the gain of K, which then depends on the law
                value = lane(self.problem.scenario, controller, self.axes[0]).compensation.gain
            numbers[path] = value
        return numbers

    @staticmethod
    def gains(values: dict[str, float], axis: str) -> tuple[Array, Array]:
        """Return k_p and k_d of an axis as arrays without dimensions."""
        return np.array(values[f"{axis}.k_p"]), np.array(values[f"{axis}.k_d"])

    def controller(
        self, values: dict[str, float], base: ControllerConfig | None = None
    ) -> ControllerConfig:
        """Return the controller, or another one, with the numbers of a point."""
        changed = self.problem.controller if base is None else base
        for path, value in values.items():
            part, field = path.split(".")
            inside = getattr(changed, part).model_copy(update={field: value})
            changed = changed.model_copy(update={part: inside})
        return changed

    def families(self, values: dict[str, float]) -> dict[tuple[str, str], LoopFamily]:
        """Return the loops of each motor and axis; none where the law has no linearisation."""
        shared = tuple(item for item in values.items() if item[0] not in self._gains)
        if shared == self._known[0]:
            return self._known[1]
        controller = self.controller(dict(shared))
        before: dict[tuple[str, str], LoopFamily] = self._known[1]
        found: dict[tuple[str, str], LoopFamily] = {}
        for name, trials in self.problem.setups.items():
            scenario = trials.scenario
            owner = scenario.variants[self.problem.variant]
            changed = owner.model_copy(update={"controller": controller})
            with_it = scenario.model_copy(update={"variants": {self.problem.variant: changed}})
            for axis in self.axes:
                try:
                    found[name, axis] = LoopFamily.of(
                        with_it, self.problem.variant, axis, like=before.get((name, axis))
                    )
                except NoLinearisation:
                    return {}
        self._known[:] = [shared, found]
        return found

    def starts(self, count: int, generator: np.random.Generator) -> list[Array]:
        """Return the present gains and drawn ones, stable where some are found."""
        low, high = self.bounds.T
        starts = [self.point(self.problem.controller)]
        while len(starts) < count:
            drawn = [generator.uniform(low, high) for _ in range(_DRAWS)]
            starts.append(next(filter(self._stable, drawn), drawn[-1]))
        return starts

    def _stable(self, point: Array) -> bool:
        values = self.values(point)
        return all(
            family.radius(*self.gains(values, axis)) < 1.0
            for (_, axis), family in self.families(values).items()
        )

    @cached_property
    def _gains(self) -> frozenset[str]:
        return frozenset(f"{axis}.{name}" for axis in self.axes for name in ("k_p", "k_d"))

    @cached_property
    def _known(self) -> list:
        """Cache of the latest loops and their keys."""
        return [None, {}]


def with_published(problem: TuningProblem, axes: tuple[str, ...]) -> ControllerConfig:
    """Return the controller with the paper's gains."""
    gains: dict[str, GainsConfig] = {axis: problem.published(axis) for axis in axes}
    return problem.controller.model_copy(update=gains)
