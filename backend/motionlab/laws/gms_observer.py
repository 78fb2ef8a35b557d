"""Friction compensated by generalised Maxwell slip: `motionlab.effects.gms` as a model."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from motionlab.effects.gms import ATTRACTION, EFFECT, Gms, GmsState, gms
from motionlab.lanes import Lanes, compiled
from motionlab.laws.effect_observer import observer, over_period
from motionlab.laws.law import Estimate, Seen
from motionlab.laws.lugre_observer import observed_velocity
from motionlab.plant.friction import LuGre


class GmsObserver(NamedTuple):
    """GmsObserver of each lane."""

    from_reference: Lanes  # 1: the reference's velocity drives it; 0: the measured one
    attraction: Lanes  # C, N/s


@compiled
def gms_observer(par: GmsObserver, state: GmsState, seen: Seen) -> tuple[Estimate, GmsState]:
    """Estimate friction by the model alone, driven by the velocity."""
    f = seen.friction
    model = Gms(f.sigma_0, f.sigma_2, f.F_c, f.F_s, f.v_s, par.attraction, 0.0, 0.0, 1.0)
    v = observed_velocity(par.from_reference, seen)
    resistance, after = gms(model, state, over_period(seen, v))
    return Estimate(resistance.force, 0.0, 0.0), after


def lane(values: Mapping[str, Any], friction: LuGre) -> GmsObserver:
    """Return the parameters of one lane."""
    return GmsObserver(float(values["velocity"] == "reference"), values["attraction"])


LAW = observer(EFFECT, gms_observer, GmsObserver, lane, ATTRACTION)
