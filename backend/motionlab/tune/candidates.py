"""Sets of gains, tried and put into the document."""

from __future__ import annotations

from typing import Literal

from motionlab.analysis.frequency import margins
from motionlab.simulation.linear import SLIDING, NoLinearisation, linearise
from motionlab.tune.document import Candidate, GainMargins, GainMetrics, TunedAxis
from motionlab.tune.group import Group
from motionlab.tune.trials import Outcome
from motionlab.tune.verdict import Tried, Verdict


def candidate(  # noqa: PLR0913, PLR0917 - a set of gains and what is known of it
    group: Group,
    values: dict[str, float],
    tried: Tried,
    verdict: Verdict,
    origin: Literal["present", "paper", "start"],
    start: int | None = None,
) -> Candidate:
    """Return a set of gains with its metrics on each motor, its margins and the verdict on it.

    Parameters
    ----------
    group : Group
        Axes that it is for.
    values : dict of str to float
        Its numbers, by path below the controller.
    tried : dict
        What came of it.
    verdict : Verdict
        What is thought of it.
    origin : str
        Where it comes from.
    start : int, optional
        Which start led to it.
    """
    problem = group.problem
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
        also={path: values[path] for path in map(str, group.request.also)},
        **vars(verdict.document()),
        set={problem.path(path): value for path, value in values.items()},
    )


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
