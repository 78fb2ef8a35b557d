"""Gains of an axis, or of axes tuned together, judged by cost, loops and constraints.

Sets of gains that hold every constraint are compared by their cost; of two that do not, the one
that violates less is the better one, and any that holds is better than any that does not (K. Deb,
"An efficient constraint handling method for genetic algorithms", Computer Methods in Applied
Mechanics and Engineering 186, 2000).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from motionlab.config.controller import ControllerConfig, GainsConfig
from motionlab.loop.family import Figures, LoopFamily
from motionlab.loop.linearise import NoLinearisation
from motionlab.studies.tune.documents import Constraints, Metric, TuneRequest, VerdictDocument
from motionlab.studies.tune.further_numbers import value_of
from motionlab.studies.tune.problem import Outcome, TuningProblem

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
        return gains | request.also

    @property
    def bounds(self) -> Array:
        """Logarithms of low and high, shape (n, 2)."""
        return np.log(np.array(list(self.fields.values())))

    def values(self, point: Array) -> dict[str, float]:
        """Return the numbers of a point, by path."""
        return dict(zip(self.fields, np.exp(point).tolist(), strict=True))

    def point(self, controller: ControllerConfig) -> Array:
        """Return the point of a controller, moved inside the bounds."""
        low, high = self.bounds.T
        numbers = self.values_of(controller).values()
        return np.clip([math.log(x) if x > 0.0 else -math.inf for x in numbers], low, high)

    def values_of(self, controller: ControllerConfig) -> dict[str, float]:
        """Return a controller's own numbers, by path."""
        numbers: dict[str, float] = {}
        for path in self.fields:
            value = value_of(self.problem.scenario, controller, self.axes[0], path)
            assert value is not None  # `check_further`
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
        families: dict[tuple[str, str], LoopFamily] = {}
        for name, trials in self.problem.setups.items():
            scenario = trials.scenario
            owner = scenario.variants[self.problem.variant]
            changed = owner.model_copy(update={"controller": controller})
            with_it = scenario.model_copy(update={"variants": {self.problem.variant: changed}})
            for axis in self.axes:
                try:
                    families[name, axis] = LoopFamily.of(with_it, self.problem.variant, axis)
                except NoLinearisation:
                    return {}
        self._known[:] = [shared, families]
        return families

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


Values = TypeVar("Values", float, NDArray[np.float64])

SCALES: dict[Metric, float] = {
    "peak": 1e-6,
    "rms": 1e-6,
    "itae": 1e-6,
    "settling": 1e-2,
    "effort": 1.0,
}
"""Units of the weights: um, um, um s^2, 10 ms and N, in SI."""


def cost(objective: Mapping[Metric, float], metrics: Mapping[str, Values]) -> Values:
    """Return ``sum w m/unit`` over the metrics of an objective; infinite after a divergence."""
    terms = [weight * metrics[name] / SCALES[name] for name, weight in objective.items()]
    return sum(terms[1:], start=terms[0])


def on_worst(objective: Mapping[Metric, float], tried: Mapping[tuple[str, str], Outcome]) -> float:
    """Return the cost on the worst motor, summed over axes; `tried` is by motor and axis."""
    motors = {motor for motor, _ in tried}
    return max(
        sum(
            cost(objective, outcome._asdict())
            for (name, _), outcome in tried.items()
            if name == motor
        )
        for motor in motors
    )


Tried = Mapping[tuple[str, str], Outcome]
"""Outcomes of a set of gains, by motor and axis."""

_REFUSED = 1e12
"""Least value of a set of gains that violates a constraint."""

_UNSTABLE = 1e3
"""Violation of one that is unstable or diverges, and more: any other is less."""

_TINY = 1e-12
"""Numerical floor of a margin."""

_PAST_COMMA = {"gain_margin": 3, "phase_margin": 3, "Ms": 3, "saturated": 4, "force": 2}
_UNITS = {"phase_margin": " rad", "force": " N"}


@dataclass(frozen=True)
class ConstraintViolation:
    """A constraint that does not hold on one motor and axis.

    Attributes
    ----------
    share : float
        By how much, > 0: the logarithm of a ratio, or a share of the time.
    words : str
        Required and actual value.
    """

    share: float
    words: str


@dataclass(frozen=True)
class Verdict:
    """Evaluation of a set of gains.

    Attributes
    ----------
    cost : float
        On the worst motor, infinite where it diverged; NaN where it was not tried.
    linear, tried : mapping of (motor, axis) to list of ConstraintViolation
        Constraints violated by the linearised loops, and by the trials.
    """

    cost: float
    linear: Mapping[tuple[str, str], Sequence[ConstraintViolation]]
    tried: Mapping[tuple[str, str], Sequence[ConstraintViolation]]

    @property
    def feasible(self) -> bool:
        """Whether every constraint holds, as far as it was tried."""
        return not (any(self.linear.values()) or any(self.tried.values()))

    @property
    def value(self) -> float:
        """Sort key of the simplex: cost, or the worst violation of a loop, else of a trial."""
        violation = _worst(self.linear) or _worst(self.tried)
        return _REFUSED * (1.0 + violation) if violation > 0.0 else self.cost

    @property
    def reasons(self) -> list[str]:
        """A line for each constraint that does not hold."""
        return [
            f"{axis} on {motor}: {violation.words}"
            for motor, axis in self.tried
            for violation in (*self.linear.get((motor, axis), ()), *self.tried[motor, axis])
        ]

    def document(self) -> VerdictDocument:
        """Return it as the document has it."""
        return VerdictDocument(
            cost=self.cost if math.isfinite(self.cost) else None,
            feasible=self.feasible,
            violations=self.reasons,
        )


def of_loops(group: Group, values: dict[str, float]) -> Verdict:
    """Return the verdict on the linearised loops under a set of gains, before it is tried."""
    limits = group.request.constraints
    return Verdict(
        cost=math.nan,
        linear={
            place: _loop_violations(limits, family, *group.gains(values, place[1]))
            for place, family in group.families(values).items()
        },
        tried={},
    )


def of_trial(loops: Verdict, group: Group, tried: Tried) -> Verdict:
    """Return the verdict on a set of gains that was tried, from that on its loops."""
    limits, objective = group.request.constraints, group.request.objective
    return Verdict(
        cost=on_worst(objective, tried),
        linear=loops.linear,
        tried={place: outcome_violations(limits, one) for place, one in tried.items()},
    )


def _loop_violations(
    limits: Constraints, family: LoopFamily, k_p: Array, k_d: Array
) -> list[ConstraintViolation]:
    radii = family.radii(k_p, k_d)
    worst = int(radii.argmax())
    radius = float(radii[worst])
    if radius >= 1.0:
        words = f"unstable{_at(family.velocity[worst])}, a pole of modulus {radius:.4f}"
        return [ConstraintViolation(_UNSTABLE * radius, words)]
    return margin_violations(limits, family.figures(float(k_p), float(k_d)))


def margin_violations(limits: Constraints, figures: Figures) -> list[ConstraintViolation]:
    """Return the margins that fall short, and by which share."""
    return [
        *_short("gain_margin", *figures.gain_margin, limits.gain_margin),
        *_short("phase_margin", *figures.phase_margin, limits.phase_margin),
        *_over("Ms", *figures.Ms, limits.Ms),
    ]


def outcome_violations(limits: Constraints, outcome: Outcome) -> list[ConstraintViolation]:
    """Return the limits that a trial exceeds, and by which share."""
    if outcome.diverged:
        return [ConstraintViolation(_UNSTABLE, "diverges")]
    violations = _over("force", outcome.force, None, limits.force)
    saturated = limits.saturated
    if saturated is None or outcome.saturated <= saturated:
        return violations
    limit_text = f"at most {_number('saturated', saturated)}"
    words = _words("saturated", outcome.saturated, None, limit_text)
    return [ConstraintViolation(outcome.saturated - saturated, words), *violations]


def _short(
    name: str, value: float, velocity: float | None, least: float | None
) -> list[ConstraintViolation]:
    if least is None or value >= least:
        return []
    share = math.log(least / max(value, _TINY))
    return [
        ConstraintViolation(
            share, _words(name, value, velocity, f"at least {_number(name, least)}")
        )
    ]


def _over(
    name: str, value: float, velocity: float | None, most: float | None
) -> list[ConstraintViolation]:
    if most is None or value <= most:
        return []
    words = _words(name, value, velocity, f"at most {_number(name, most)}")
    return [ConstraintViolation(math.log(value / most), words)]


def _words(name: str, value: float, velocity: float | None, limit_text: str) -> str:
    where = "" if velocity is None else _at(velocity)
    return f"{name} = {_number(name, value)}{_UNITS.get(name, '')}{where}, {limit_text} wanted"


def _at(velocity: float) -> str:
    return f" at {velocity * 1e3:.3g} mm/s" if velocity else " at standstill"


def _number(name: str, value: float) -> str:
    return f"{value:.{_PAST_COMMA[name]}f}"


def _worst(violations: Mapping[tuple[str, str], Sequence[ConstraintViolation]]) -> float:
    return max((sum(one.share for one in some) for some in violations.values()), default=0.0)
