"""LuGre friction along a measured motion: the bristle is integrated, not guessed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motionlab.lanes import cached
from motionlab.plant.friction import LuGre

Array = NDArray[np.float64]


@cached
def bristle(position: Array, velocity: Array, lost: NDArray[np.bool_], friction: LuGre) -> Array:
    """Return the bristle state z along a motion, m, eq. (21).

    Over the displacement d between two samples, with a steady state of magnitude ``g/sigma_0`` that
    is linear in between, ``dz/dt = v - abs(v) sigma_0 z/g`` has the solution::

        x = sigma_0 sgn(v) d/g;  s = sgn(v)/sigma_0
        z_1 = s g_1 - s (g_1 - g_0) (1 - e^-x)/x + (z_0 - s g_0) e^-x

    Only g and the direction depend on the velocity, so that it may be smoothed. The displacement is
    not: its noise, which may be against the direction, cancels from one sample to the next.

    Parameters
    ----------
    position, velocity : ndarray, shape (n,)
        m and m/s.
    lost : ndarray of bool, shape (n,)
        Where the state is not known, and set to zero.
    friction : LuGre
        Plain numbers.
    """
    n = len(position)
    z = np.zeros(n)
    w = 1.0 / (friction.v_s * friction.v_s)
    stiffness, falls = friction.sigma_0, friction.F_s - friction.F_c
    g_0 = friction.F_c
    for k in range(n):
        g_1 = friction.F_c + falls * np.exp(-velocity[k] * velocity[k] * w)
        if k > 0 and not lost[k]:
            s = 1.0 / stiffness if velocity[k - 1] + velocity[k] > 0.0 else -1.0 / stiffness
            x = 2.0 * stiffness * stiffness * s * (position[k] - position[k - 1]) / (g_0 + g_1)
            e = np.exp(-x)
            part = (1.0 - e) / x if abs(x) > 1e-6 else 1.0 - 0.5 * x
            z[k] = s * g_1 - s * (g_1 - g_0) * part + (z[k - 1] - s * g_0) * e
        g_0 = g_1
    return z
