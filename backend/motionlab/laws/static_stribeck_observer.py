"""Friction compensated by the Stribeck curve: `motionlab.effects.static_stribeck` as a model."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from motionlab.effects.effect import NoState
from motionlab.effects.static_stribeck import EFFECT, SMOOTHING, StaticStribeck, static_stribeck
from motionlab.lanes import Lanes, compiled
from motionlab.laws.effect_observer import observer, over_period
from motionlab.laws.law import Estimate, Seen
from motionlab.laws.lugre_observer import observed_velocity
from motionlab.plant.friction import LuGre


class StaticStribeckObserver(NamedTuple):
    """StaticStribeckObserver of each lane."""

    from_reference: Lanes  # 1: the reference's velocity drives it; 0: the measured one
    smoothing_velocity: Lanes  # v_0, m/s


@compiled
def static_stribeck_observer(
    par: StaticStribeckObserver, state: NoState, seen: Seen
) -> tuple[Estimate, NoState]:
    """Estimate friction by the model alone, driven by the velocity."""
    f = seen.friction
    model = StaticStribeck(f.F_c, f.F_s, f.v_s, f.sigma_2, par.smoothing_velocity, 0.0, 0.0, 1.0)
    v = observed_velocity(par.from_reference, seen)
    resistance, after = static_stribeck(model, state, over_period(seen, v))
    return Estimate(resistance.force, 0.0, 0.0), after


def lane(values: Mapping[str, Any], friction: LuGre) -> StaticStribeckObserver:
    """Return the parameters of one lane."""
    return StaticStribeckObserver(
        float(values["velocity"] == "reference"), values["smoothing_velocity"]
    )


LAW = observer(EFFECT, static_stribeck_observer, StaticStribeckObserver, lane, SMOOTHING)
