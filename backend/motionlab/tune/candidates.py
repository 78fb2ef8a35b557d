"""Sets of gains, tried and put into the document."""

from __future__ import annotations

import math
from typing import Literal

from motionlab.analysis.frequency import margins
from motionlab.simulation.linear import SLIDING, NoLinearisation, linearise
from motionlab.tune.cost import margin_violations, on_worst, outcome_violations
from motionlab.tune.document import Candidate, GainMargins, GainMetrics, TunedAxis
from motionlab.tune.group import Group
from motionlab.tune.request import TuneRequest
from motionlab.tune.trials import Outcome

Tried = dict[tuple[str, str], Outcome]
"""What came of a set of gains, by motor and axis."""

_PAST_COMMA = {"gain_margin": 3, "phase_margin": 3, "Ms": 3, "saturated": 4, "force": 2}
_UNITS = {"phase_margin": " rad", "force": " N"}


def candidate(
    group: Group,
    values: dict[str, float],
    tried: Tried,
    origin: Literal["present", "paper", "start"],
    start: int | None = None,
) -> Candidate:
    """Return a set of gains with its metrics on each motor, its margins and what it violates.

    Parameters
    ----------
    group : Group
        Axes that it is for.
    values : dict of str to float
        Its numbers, by path below the controller.
    tried : dict
        What came of it.
    origin : str
        Where it comes from.
    start : int, optional
        Which start led to it.
    """
    problem = group.problem
    request = problem.request
    assert isinstance(request, TuneRequest)
    worst = on_worst(request.objective, tried)
    return Candidate(
        origin=origin,
        start=start,
        axes={
            axis: TunedAxis(
                k_p=values[f"{axis}.k_p"],
                k_d=values[f"{axis}.k_d"],
                metrics={name: _metrics(tried[name, axis]) for name in problem.courses},
                margins=_margins(group, values, axis),
            )
            for axis in group.axes
        },
        also={path: values[path] for path in map(str, request.also)},
        cost=worst if math.isfinite(worst) else None,
        violations=_violations(group, values, tried, request),
        set={problem.path(path): value for path, value in values.items()},
    )


def betters(found: Candidate, present: Candidate) -> bool:
    """Return whether gains hold every constraint while the present ones do not, or cost more."""
    if found.violations or found.cost is None:
        return False
    return bool(present.violations) or present.cost is None or found.cost < present.cost


def _metrics(outcome: Outcome) -> GainMetrics:
    figures = {name: getattr(outcome, name) for name in GainMetrics.model_fields}
    return GainMetrics(**(dict.fromkeys(figures) if outcome.diverged else figures))


def _margins(group: Group, values: dict[str, float], axis: str) -> GainMargins | None:
    problem = group.problem
    owner = problem.scenario.variants[problem.variant]
    changed = owner.model_copy(update={"controller": group.controller(values)})
    scenario = problem.scenario.model_copy(update={"variants": {problem.variant: changed}})
    v = SLIDING * getattr(scenario.plant, axis).friction.v_s
    try:
        loop = linearise(scenario, problem.variant, axis, v=v)
    except NoLinearisation:
        return None
    return GainMargins(stable=loop.stable, **vars(margins(loop.open)))


def _violations(
    group: Group, values: dict[str, float], tried: Tried, request: TuneRequest
) -> list[str]:
    """Return a line for each constraint that does not hold, on each motor and axis."""
    said = []
    limits = request.constraints
    families = group.families(values)
    for (motor, axis), outcome in tried.items():
        where = f"{axis} on {motor}"
        family = families.get((motor, axis))
        if family is not None:
            k_p, k_d = group.gains(values, axis)
            radius = float(family.radius(k_p, k_d))
            if radius >= 1.0:
                said.append(f"{where}: unstable, a pole of modulus {radius:.4f}")
            else:
                figures = family.figures(float(k_p), float(k_d))
                said += [
                    f"{where}: " + _line(name, getattr(figures, name), getattr(limits, name))
                    for name in margin_violations(limits, figures)
                ]
        if outcome.diverged:
            said.append(f"{where}: runs away")
            continue
        said += [
            f"{where}: " + _line(name, getattr(outcome, name), getattr(limits, name))
            for name in outcome_violations(limits, outcome)
        ]
    return said


def _line(name: str, value: float, limit: float) -> str:
    digits, unit = _PAST_COMMA[name], _UNITS.get(name, "")
    word = "at least" if name in {"gain_margin", "phase_margin"} else "at most"
    return f"{name} = {value:.{digits}f}{unit}, {word} {limit:.{digits}f} wanted"
