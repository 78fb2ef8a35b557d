"""Friction estimation: the LuGre observer of eqs (23) and (24), and the laws for its term K.

Six laws share one observer, ``dz*/dt = v - abs(v)/g(v) z* + K``, stepped by its exact exponential
(an explicit step at 0.5 ms diverges above 46 mm/s):

* ``OFF`` and ``OBSERVER``: K = 0; with OFF the estimate runs but is never added.
* ``PUBLISHED``: eq. (25) as printed. It does not work in discrete time: it needs an acceleration
  that K itself causes, its denominator crosses zero, and V of eq. (37) is only semidefinite.
* ``RESIDUAL``: the same idea in explicit-residual form. The filtered force balance gives the
  estimate's error, e_z = D r/(D^2 + (c sigma_0)^2), D = sigma_1 abs(v)/g - sigma_0; K = gain e_z
  while D < 0.
* ``REVERSED``: eq. (25) with the opposite sign and its force balance filtered,
  K = -r/(sigma_1 + c k_d D e/u), r = M a - u; c is a share of k_d, and c = 0 leaves
  K = -r/sigma_1, which has no pole.
* ``CANUDAS_DE_WIT``: K = gain e, after Canudas de Wit et al., IEEE Trans. Autom. Control 40(3),
  1995.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from motionlab.control.position import MeasuredMotion
from motionlab.lanes import Lanes, compiled, select
from motionlab.lanes.functions import clip, decay
from motionlab.plant.friction import LuGre, bristle_decay
from motionlab.timing import CONTROL_PERIOD

OFF, OBSERVER, PUBLISHED, RESIDUAL, CANUDAS_DE_WIT, REVERSED = 0.0, 1.0, 2.0, 3.0, 4.0, 5.0
"""Values of Compensation.law."""

_SMALLEST_DENOMINATOR = 1e-12  # the paper's rho: (25) is 0/0 at rest on the reference


class Compensation(NamedTuple):
    """Parameters of each lane."""

    law: Lanes  # OFF, OBSERVER, PUBLISHED, RESIDUAL, CANUDAS_DE_WIT or REVERSED
    enabled: Lanes  # 1: add the estimate to the command; 0: only run it
    from_reference: Lanes  # 1: the observer uses the reference's velocity; 0: the measured one
    gain: Lanes  # of K, 1/s
    residual_alpha: Lanes  # 1 - exp(-2 pi f T_s) of the residual's filter
    regularisation: Lanes  # c in e_z, 1
    z_limit: Lanes  # largest bristle estimate, m; inf for none
    k_d_share: Lanes  # c in the denominator of the reversed K, 1


class Observer(NamedTuple):
    """A friction observer of each lane."""

    law: Compensation
    model: LuGre


class Balance(NamedTuple):
    """Force balance of one tick, N."""

    u: Lanes  # PD force
    inertia: Lanes  # M a
    residual: Lanes  # residual of the filtered balance


class Estimate(NamedTuple):
    """The friction estimate of one tick."""

    force: Lanes  # f_f*, N
    z: Lanes  # bristle estimate at the end of the tick, m


@compiled
def residual_force(
    observer: Observer, residual: Lanes, inertia: Lanes, known_force: Lanes, K_last: Lanes
) -> Lanes:
    """Return the filtered balance ``r += alpha (M a - (f - f_f*) - sigma_1 K - r)``, N.

    For the reversed K, as in eq. (25), the term ``sigma_1 K`` is left out.
    """
    law = observer.law
    balance = inertia - known_force
    balance = select(law.law == REVERSED, balance, balance - observer.model.sigma_1 * K_last)
    return residual + law.residual_alpha * (balance - residual)


@compiled
def adaptation(
    observer: Observer, motion: MeasuredMotion, v: Lanes, k_d: Lanes, balance: Balance
) -> Lanes:
    """Return K, m/s, by the law of each lane."""
    law, model = observer.law, observer.model
    u, residual = balance.u, balance.residual
    D = model.sigma_1 * bristle_decay(model, v) - model.sigma_0

    denominator = model.sigma_1 * u + motion.error * k_d * D
    tiny = abs(denominator) < _SMALLEST_DENOMINATOR
    published = u * (balance.inertia - u) / select(tiny, _SMALLEST_DENOMINATOR, denominator)

    tiny = abs(u) < _SMALLEST_DENOMINATOR
    per_u = law.k_d_share * k_d * motion.error / select(tiny, _SMALLEST_DENOMINATOR, u)
    slope = model.sigma_1 + per_u * D
    reversed_K = -residual / select(abs(slope) < _SMALLEST_DENOMINATOR, np.inf, slope)

    floor = law.regularisation * model.sigma_0
    e_z = D * residual / (D * D + floor * floor)
    explicit = select(D < 0.0, law.gain * e_z, 0.0)

    K = select(law.law == PUBLISHED, published, 0.0)
    K = select(law.law == RESIDUAL, explicit, K)
    K = select(law.law == REVERSED, reversed_K, K)
    return select(law.law == CANUDAS_DE_WIT, law.gain * motion.error, K)


@compiled
def estimate_friction(observer: Observer, z: Lanes, v: Lanes, K: Lanes) -> Estimate:
    """Step the observer over one period and return its friction estimate, eq. (23).

    With ``l = abs(v)/g(v)``::

        z_n = z* e^-lT + T (v + K) phi1(lT)
        f_f* = sigma_0 z_n + sigma_1 (z_n - z*)/T + sigma_2 v
    """
    law, model, T_s = observer.law, observer.model, CONTROL_PERIOD
    x = bristle_decay(model, v) * T_s
    e, phi_1 = decay(x, 1.0 / x)
    z_new = clip(z * e + T_s * (v + K) * phi_1, -law.z_limit, law.z_limit)
    z_rate = (z_new - z) * (1.0 / T_s)
    force = model.sigma_0 * z_new + model.sigma_1 * z_rate + model.sigma_2 * v
    return Estimate(force, z_new)
