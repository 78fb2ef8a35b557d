"""Cogging: a force that depends on the position alone, harmonics over a pitch.

``f = sum A_n sin(2 pi n p/pitch + phi_n)``, n = 1, 2, 3; it does no work over a pitch.
"""

from __future__ import annotations

from typing import NamedTuple

from motionlab.effects.effect import PAPER, Effect, MidStep, NoState, Parameter, Resistance
from motionlab.lanes import Lanes, compiled
from motionlab.lanes.functions import sine_cosine

_TURN = 0.15915494309189535  # 1/(2 pi)


class Cogging(NamedTuple):
    """Parameters of each lane."""

    pitch: Lanes  # period of the first harmonic, m
    amplitude_1: Lanes  # N
    amplitude_2: Lanes
    amplitude_3: Lanes
    phase_1: Lanes  # at mid-stroke, rad
    phase_2: Lanes
    phase_3: Lanes


@compiled
def cogging(par: Cogging, state: NoState, seen: MidStep) -> tuple[Resistance, NoState]:
    """Return the sum of the harmonics."""
    turns = seen.position / par.pitch
    one, _ = sine_cosine(turns + _TURN * par.phase_1)
    two, _ = sine_cosine(2.0 * turns + _TURN * par.phase_2)
    three, _ = sine_cosine(3.0 * turns + _TURN * par.phase_3)
    force = par.amplitude_1 * one + par.amplitude_2 * two + par.amplitude_3 * three
    return Resistance(force, 0.0), state


def _amplitude(n: int) -> Parameter:
    what = f"Amplitude of the force at {n} periods a pitch"
    return Parameter(f"amplitude_{n}", what, unit="N", default=0.1 if n == 1 else 0.0, ge=0, le=100)


def _phase(n: int) -> Parameter:
    what = f"Phase of the force at {n} periods a pitch, at mid-stroke"
    return Parameter(f"phase_{n}", what, unit="rad", shown="°", default=0.0, ge=-6.2832, le=6.2832)


EFFECT = Effect(
    name="cogging",
    label="cogging",
    description="A force over the position: three harmonics of a pitch",
    source="this project's choice of harmonics",
    step=cogging,
    Parameters=Cogging,
    parameters=(
        Parameter(
            "pitch",
            "Period of the first harmonic",
            unit="m",
            shown="mm",
            default=7.2e-3,
            ge=1e-5,
            le=1,
            source=f"{PAPER}: the pole pitch",
        ),
        *(_amplitude(n) for n in (1, 2, 3)),
        *(_phase(n) for n in (1, 2, 3)),
    ),
    friction=False,
)
