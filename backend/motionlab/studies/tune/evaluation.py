"""Evaluation of a set of gains: cost and violated constraints.

Sets of gains that hold every constraint are compared by their cost; of two that do not, the one
that violates less is the better one, and any that holds is better than any that does not (K. Deb,
"An efficient constraint handling method for genetic algorithms", Computer Methods in Applied
Mechanics and Engineering 186, 2000).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motionlab.loop.family import Figures, LoopFamily
from motionlab.studies.tune.axis_group import Group
from motionlab.studies.tune.cost import on_worst
from motionlab.studies.tune.document import VerdictDocument
from motionlab.studies.tune.request import Constraints
from motionlab.studies.tune.trials import Outcome

Array = NDArray[np.float64]

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
    """Return the verdict on the linearised loops under a set of gains, before it is tried.

    Parameters
    ----------
    group : Group
        Axes that it is for.
    values : dict of str to float
        Its numbers, by path below the controller.
    """
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
    """Return which margins fall short, and by which share."""
    return [
        *_short("gain_margin", *figures.gain_margin, limits.gain_margin),
        *_short("phase_margin", *figures.phase_margin, limits.phase_margin),
        *_over("Ms", *figures.Ms, limits.Ms),
    ]


def outcome_violations(limits: Constraints, outcome: Outcome) -> list[ConstraintViolation]:
    """Return which limits a trial exceeds, and by which share."""
    if outcome.diverged:
        return [ConstraintViolation(_UNSTABLE, "diverges")]
    found = _over("force", outcome.force, None, limits.force)
    saturated = limits.saturated
    if saturated is None or outcome.saturated <= saturated:
        return found
    wanted = f"at most {_number('saturated', saturated)}"
    words = _words("saturated", outcome.saturated, None, wanted)
    return [ConstraintViolation(outcome.saturated - saturated, words), *found]


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


def _words(name: str, value: float, velocity: float | None, wanted: str) -> str:
    where = "" if velocity is None else _at(velocity)
    return f"{name} = {_number(name, value)}{_UNITS.get(name, '')}{where}, {wanted} wanted"


def _at(velocity: float) -> str:
    return f" at {velocity * 1e3:.3g} mm/s" if velocity else " at standstill"


def _number(name: str, value: float) -> str:
    return f"{value:.{_PAST_COMMA[name]}f}"


def _worst(found: Mapping[tuple[str, str], Sequence[ConstraintViolation]]) -> float:
    return max((sum(one.share for one in some) for some in found.values()), default=0.0)
