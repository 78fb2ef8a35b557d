"""K from the residual of the filtered force balance: the idea of eq. (25) in explicit form.

The filtered balance gives the error of the bristle estimate, ``e_z = D r/(D^2 + (c sigma_0)^2)``
with ``D = sigma_1 abs(v)/g(v) - sigma_0``; ``K = gain e_z`` while D < 0.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

from motionlab.lanes import Lanes, compiled, select
from motionlab.laws.canudas_de_wit import GAIN
from motionlab.laws.law import Estimate, Law, Parameter, Refusal, Seen
from motionlab.laws.lugre_observer import (
    BRISTLE_LIMIT,
    VELOCITY,
    observed_velocity,
    sliding_bristle,
    step_observer,
    z_limit,
)
from motionlab.plant.friction import LuGre, bristle_decay
from motionlab.timing import CONTROL_PERIOD

RESIDUAL_BANDWIDTH = Parameter(
    "residual_bandwidth",
    "Bandwidth of the filter of the force balance (residual-k, reversed-k)",
    unit="Hz",
    default=30.0,
    gt=0,
    le=1000,
    usual=(1.0, 500.0),
)
REGULARISATION = Parameter(
    "regularisation",
    "What keeps e_z finite where D crosses zero, in units of sigma_0 (residual-k)",
    unit="1",
    default=0.4,
    gt=0,
    le=10,
    usual=(0.05, 5.0),
)
BRISTLES = 1.2
"""Largest bristle estimate where a config gives none, in units of F_s/sigma_0."""

_USUAL, _OF_LIMIT = 40.0, 0.9  # gain, 1/s, and share of the largest one, 1


class ResidualK(NamedTuple):
    """ResidualK of each lane."""

    from_reference: Lanes  # 1: the observer uses the reference's velocity; 0: the measured one
    z_limit: Lanes  # largest bristle estimate, m; inf for none
    gain: Lanes  # of K, 1/s
    alpha: Lanes  # 1 - exp(-2 pi f T_s) of the residual's filter
    regularisation: Lanes  # c in e_z, 1


class ResidualState(NamedTuple):
    """ResidualState of each lane."""

    z: Lanes  # bristle estimate, m
    residual: Lanes  # filtered force balance, N


@compiled
def filtered(residual: Lanes, alpha: Lanes, balance: Lanes, seen: Seen) -> Lanes:
    """Return the next residual ``r += alpha (balance - r)``, N; 0 in the first period."""
    return select(seen.age == 0.0, 0.0, residual + alpha * (balance - residual))


@compiled
def residual_k(par: ResidualK, state: ResidualState, seen: Seen) -> tuple[Estimate, ResidualState]:
    """Estimate friction with ``K = gain e_z``; balance ``M a - (f - f_f*) - sigma_1 K``."""
    model = seen.friction
    known_force = seen.f_acting - seen.estimate_acting
    balance = seen.M * seen.a - known_force - model.sigma_1 * seen.K_acting
    residual = filtered(state.residual, par.alpha, balance, seen)

    v = observed_velocity(par.from_reference, seen)
    D = model.sigma_1 * bristle_decay(model, v) - model.sigma_0
    floor = par.regularisation * model.sigma_0
    e_z = D * residual / (D * D + floor * floor)
    K = select(D < 0.0, par.gain * e_z, 0.0)
    estimate = step_observer(model, par.z_limit, state.z, v, K)
    return estimate, ResidualState(estimate.z, residual)


def low_pass(bandwidth: float) -> float:
    """Return the coefficient of a first-order low-pass filter of `bandwidth`, Hz."""
    return 1.0 - math.exp(-2.0 * math.pi * bandwidth * CONTROL_PERIOD)


def gain_limit(friction: LuGre, regularisation: float) -> float:
    """Return the gain, 1/s, from which on the residual feeds itself; inf for none.

    Between two measurements ``r += alpha (gain sigma_1 d/(sigma_0 (d^2 + c^2)) - 1) r``, where
    ``d = abs(D)/sigma_0`` falls from 1 at rest to 0 with velocity: largest at d = c, or at rest.
    """
    if friction.sigma_1 == 0.0:
        return math.inf
    c = regularisation
    return (2.0 * c if c < 1.0 else 1.0 + c * c) * friction.sigma_0 / friction.sigma_1


def lane(values: Mapping[str, Any], friction: LuGre) -> ResidualK:
    """Return the parameters of one lane."""
    gain, c = values["gain"], values["regularisation"]
    return ResidualK(
        from_reference=float(values["velocity"] == "reference"),
        z_limit=z_limit(values, friction, BRISTLES),
        gain=min(_USUAL, _OF_LIMIT * gain_limit(friction, c)) if gain is None else gain,
        alpha=low_pass(values["residual_bandwidth"]),
        regularisation=c,
    )


def refuse(values: Mapping[str, Any], friction: LuGre) -> Refusal | None:
    """Return why a gain is refused; None where it is not."""
    gain, c = values["gain"], values["regularisation"]
    limit = gain_limit(friction, c)
    if gain is None or gain < limit:  # without one, it is chosen within the limit
        return None
    factor = "2 c" if c < 1.0 else "(1 + c^2)"
    return Refusal(
        "gain",
        gain,
        f"the residual feeds itself from {factor} sigma_0/sigma_1 = {limit:.4g} 1/s on, with "
        f"sigma_0 = {friction.sigma_0:.4g} N/m and sigma_1 = {friction.sigma_1:.4g} N s/m of the "
        f"controller's model and c = {c:g}, its regularisation; lower the gain or raise c",
        limit,
    )


LAW = Law(
    name="residual-k",
    label="K from the residual",
    description="K from the filtered residual of the force balance",
    source="this project's form of eq. (25)",
    step=residual_k,
    Parameters=ResidualK,
    State=ResidualState,
    parameters=(VELOCITY, BRISTLE_LIMIT, GAIN, RESIDUAL_BANDWIDTH, REGULARISATION),
    lane=lane,
    sliding=lambda friction, v: ResidualState(sliding_bristle(friction, v), 0.0),
    limits=("z_limit",),
    refuse=refuse,
)
