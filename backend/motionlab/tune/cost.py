"""What a set of gains costs: a weighted sum of metrics where every constraint holds.

Sets of gains that hold every constraint are compared by their cost; of two that do not, the one
that violates less is the better one, and any that holds is better than any that does not (K. Deb,
"An efficient constraint handling method for genetic algorithms", Computer Methods in Applied
Mechanics and Engineering 186, 2000).
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from motionlab.simulation.family import Figures
from motionlab.tune.request import Constraints, Metric
from motionlab.tune.trials import Outcome

SCALES: dict[Metric, float] = {
    "peak": 1e-6,
    "rms": 1e-6,
    "itae": 1e-6,
    "settling": 1e-2,
    "effort": 1.0,
}
"""What one unit of weight stands for: um, um, um s^2, 10 ms and N, in SI."""

REFUSED = 1e12
"""Least value of a set of gains that violates a constraint."""

UNSTABLE = 1e3
"""Violation of one that is unstable or runs away, and more: any other is less."""

_TINY = 1e-12
"""Least margin that is told from none."""


def cost(objective: Mapping[Metric, float], outcome: Outcome) -> float:
    """Return ``sum w m/unit`` over the metrics of an objective; infinite where it ran away."""
    return sum(
        weight * getattr(outcome, metric) / SCALES[metric] for metric, weight in objective.items()
    )


def margin_violations(constraints: Constraints, figures: Figures) -> dict[str, float]:
    """Return which margins fall short, and by which share."""
    wanted = {
        "gain_margin": _short(figures.gain_margin, constraints.gain_margin),
        "phase_margin": _short(figures.phase_margin, constraints.phase_margin),
        "Ms": _over(figures.Ms, constraints.Ms),
    }
    return {name: share for name, share in wanted.items() if share > 0.0}


def outcome_violations(constraints: Constraints, outcome: Outcome) -> dict[str, float]:
    """Return which limits a trial exceeds, and by which share."""
    if outcome.diverged:
        return {"diverged": UNSTABLE}
    saturated = constraints.saturated
    wanted = {
        "saturated": 0.0 if saturated is None else max(0.0, outcome.saturated - saturated),
        "force": _over(outcome.force, constraints.force),
    }
    return {name: share for name, share in wanted.items() if share > 0.0}


def _short(value: float, least: float | None) -> float:
    if least is None or value >= least:
        return 0.0
    return math.log(least / max(value, _TINY))


def _over(value: float, most: float | None) -> float:
    return 0.0 if most is None or value <= most else math.log(value / most)


def refused(violation: float) -> float:
    """Return the value of a set of gains that violates constraints by that much; 0 for none."""
    return REFUSED * (1.0 + violation) if violation > 0.0 else 0.0


def on_worst(objective: Mapping[Metric, float], tried: Mapping[tuple[str, str], Outcome]) -> float:
    """Return the cost on the worst motor, summed over axes; `tried` is by motor and axis."""
    motors = {motor for motor, _ in tried}
    return max(
        sum(cost(objective, outcome) for (name, _), outcome in tried.items() if name == motor)
        for motor in motors
    )
