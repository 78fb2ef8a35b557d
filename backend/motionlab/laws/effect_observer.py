"""Observers whose model of friction is an effect of `motionlab.effects`, stepped once a period.

The effect's own step runs over the period at the velocity that drives the observer, with the
friction of the controller's model; normal force and position are left out.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from motionlab.effects.effect import Effect, MidStep
from motionlab.lanes import Lanes, compiled
from motionlab.laws.law import Law, Parameter, Seen
from motionlab.laws.lugre_observer import VELOCITY
from motionlab.timing import CONTROL_PERIOD


@compiled
def over_period(seen: Seen, v: Lanes) -> MidStep:
    """Return a control period at velocity v, m/s, as a step of an effect."""
    none = 0.0 * seen.M
    return MidStep(none, v, none, none, none, none, none, none, seen.M, none + CONTROL_PERIOD)


def observer(
    effect: Effect,
    step: Callable[..., Any],
    parameters: Any,
    lane: Callable[..., Any],
    *own: Parameter,
) -> Law:
    """Return the law of an effect.

    Parameters
    ----------
    effect : Effect
        Whose state the law has.
    step : callable
        `Law.step`: that of the effect at `over_period`.
    parameters : type
        `Law.Parameters`.
    lane : callable
        `Law.lane`.
    own : Parameter
        Parameters of the effect that the controller's model of friction does not have.
    """
    return Law(
        name=f"{effect.name}-observer",
        label=f"{effect.label}, observed",
        description=f"The plant's effect {effect.name} as a model, driven by the velocity alone",
        source=effect.source,
        step=step,
        Parameters=parameters,
        State=effect.State,
        parameters=(VELOCITY, *own),
        lane=lane,
        sliding=effect.sliding,
    )
