"""Warnings about runs whose figures mean nothing."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from motionlab.config.scenario import Scenario
from motionlab.effects import EFFECTS
from motionlab.errors import ConfigError
from motionlab.loop.linearise import SLIDING, is_stable

_SATURATED = 0.05
"""Share of the time at a limit that is worth a word; friction reversals reach a limit at times."""


def warnings_of(scenario: Scenario, name: str, result: Mapping[str, Any]) -> Iterator[str]:
    """Yield warnings of one variant: that it diverged, is unstable, or at its limits.

    Parameters
    ----------
    scenario : Scenario
        Parameters at the end of the window.
    name : str
        The variant.
    result : mapping
        ``diverged`` and ``axes`` of its result.
    """
    if result["diverged"]:
        where = result["diverged"]
        yield f"diverged at t = {where['time']:.4f} s: {where['channel']}"
        return
    for axis, metrics in result["axes"].items():
        causes = _instability(scenario, name, axis)
        config = getattr(scenario.plant, axis)
        if config.friction.enabled and any(_resists(each.effect) for each in config.effects):
            causes.append(f"friction acts twice: that of plant.{axis}.friction, and of its effects")
        share = metrics["saturated_fraction"] or 0.0
        if share > _SATURATED:
            causes.append(f"its command is at a limit {100 * share:.3g} % of the time")
        if causes:
            yield f"on {axis}: {' and '.join(causes)}"


def _resists(name: str) -> bool:
    """Return whether an effect is a whole friction: one that has a level of its own."""
    return EFFECTS[name].friction and EFFECTS[name].level is not None


def _instability(scenario: Scenario, name: str, axis: str) -> list[str]:
    """Return the velocities at which the linearised loop of an axis is known to be unstable."""
    own = getattr(scenario.plant, axis)
    if any(EFFECTS[each.effect].friction for each in own.effects):
        return []  # which the linearised loop does not have
    v_s = own.friction.v_s
    speeds = {"while it slides": SLIDING * v_s, "at standstill": 0.0}
    try:
        where = [words for words, v in speeds.items() if not is_stable(scenario, name, axis, v=v)]
    except ConfigError:  # the law has no linearisation, or its map no gain at this force
        return []
    return [f"its linearised loop is unstable {' and '.join(where)}"] if where else []
