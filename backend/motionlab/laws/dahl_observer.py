"""Friction compensated by Dahl's model: `motionlab.effects.dahl` as a model."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from motionlab.effects.dahl import EFFECT, Dahl, DahlState, dahl
from motionlab.lanes import Lanes, compiled
from motionlab.laws.effect_observer import observer, over_period
from motionlab.laws.law import Estimate, Seen
from motionlab.laws.lugre_observer import observed_velocity
from motionlab.plant.friction import LuGre


class DahlObserver(NamedTuple):
    """DahlObserver of each lane."""

    from_reference: Lanes  # 1: the reference's velocity drives it; 0: the measured one


@compiled
def dahl_observer(par: DahlObserver, state: DahlState, seen: Seen) -> tuple[Estimate, DahlState]:
    """Estimate friction by the model alone, driven by the velocity."""
    f = seen.friction
    model = Dahl(f.sigma_0, f.sigma_2, f.F_c, 0.0, 0.0, 1.0)
    v = observed_velocity(par.from_reference, seen)
    resistance, after = dahl(model, state, over_period(seen, v))
    return Estimate(resistance.force, 0.0, 0.0), after


def lane(values: Mapping[str, Any], friction: LuGre) -> DahlObserver:
    """Return the parameters of one lane."""
    return DahlObserver(float(values["velocity"] == "reference"))


LAW = observer(EFFECT, dahl_observer, DahlObserver, lane)
