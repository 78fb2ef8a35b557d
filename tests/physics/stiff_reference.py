"""One axis under its controller, solved by scipy's stiff solvers: the truth for the integrator.

Written from eqs (15) to (24) of the paper and nothing else: it imports no part of the simulator.
The plant is an ideal force on a mass with LuGre friction, the encoder is exact, and the force is
held for each control period, at whose start the solver begins afresh.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from tests.physics.nominal import CONTROL_PERIOD, FORCE_LIMIT, Axis

Array = NDArray[np.float64]


def rates(_t: float, y: Array, axis: Axis, force: float) -> tuple[float, float, float]:
    """Return d/dt of displacement, velocity and bristle state: eqs (16), (20) to (22)."""
    v, z = float(y[1]), float(y[2])
    g = (axis.F_c + (axis.F_s - axis.F_c) * math.exp(-((v / axis.v_s) ** 2))) / axis.sigma_0
    dz = v - abs(v) / g * z
    friction = axis.sigma_0 * z + axis.sigma_1 * dz + axis.sigma_2 * v
    return v, (force - friction) / axis.M, dz


def jacobian(_t: float, y: Array, axis: Axis, force: float) -> Array:
    """Return the derivatives of `rates` with respect to the state."""
    v, z = float(y[1]), float(y[2])
    drop = (axis.F_s - axis.F_c) * math.exp(-((v / axis.v_s) ** 2))
    g = (axis.F_c + drop) / axis.sigma_0
    dg = -2.0 * v / axis.v_s**2 * drop / axis.sigma_0
    zz = -abs(v) / g
    zv = 1.0 - z * (math.copysign(1.0, v) * g - abs(v) * dg) / g**2
    vv = -(axis.sigma_1 * zv + axis.sigma_2) / axis.M
    vz = -(axis.sigma_0 + axis.sigma_1 * zz) / axis.M
    return np.array([[0.0, 1.0, 0.0], [0.0, vv, vz], [0.0, zv, zz]])


def hold(
    axis: Axis,
    state: tuple[float, float, float],
    force: float,
    *,
    duration: float = CONTROL_PERIOD,
    method: str = "LSODA",
    tolerance: float = 1e-10,
) -> tuple[float, float, float]:
    """Return position, velocity and bristle state after `duration` seconds of constant `force`.

    The position is solved for as a displacement, so that its tolerance is not one of the whole
    stroke. Absolute tolerances are `tolerance` times 0.1 mm, 1 mm/s and 1 um.
    """
    p, v, z = state
    solution = solve_ivp(
        rates,
        (0.0, duration),
        (0.0, v, z),
        method=method,
        jac=jacobian,
        args=(axis, force),
        rtol=tolerance,
        atol=tolerance * np.array([1e-4, 1e-3, 1e-6]),
        t_eval=(duration,),
    )
    if not solution.success:
        raise RuntimeError(solution.message)
    moved, v, z = (float(value) for value in solution.y[:, -1])
    return p + moved, v, z


@dataclass
class Loop:
    """One axis under PD control, eq. (15), with the LuGre observer, eqs (23), (24), on or off."""

    axis: Axis
    p: float
    v: float = 0.0
    z: float = 0.0
    compensated: bool = False
    method: str = "LSODA"
    _e_last: float | None = field(default=None, init=False)
    _p_last: float = field(default=0.0, init=False)
    _z_hat: float = field(default=0.0, init=False)

    def follow(self, p_ref: Array) -> Array:
        """Follow a reference, one value a control period; return the positions reached after each.

        Parameters
        ----------
        p_ref : ndarray, shape (ticks,)
            Position reference, m.

        Returns
        -------
        ndarray, shape (ticks,)
            True position at the end of each period, m.
        """
        reached = np.empty(len(p_ref))
        for k, reference in enumerate(p_ref):
            force = self._control(float(reference))
            state = (self.p, self.v, self.z)
            self.p, self.v, self.z = hold(self.axis, state, force, method=self.method)
            reached[k] = self.p
        return reached

    def _control(self, reference: float) -> float:
        axis, T = self.axis, CONTROL_PERIOD
        e = reference - self.p
        first = self._e_last is None
        de = 0.0 if self._e_last is None else (e - self._e_last) / T
        v = 0.0 if first else (self.p - self._p_last) / T
        self._e_last, self._p_last = e, self.p
        u = min(max(axis.k_p * e + axis.k_d * de, -FORCE_LIMIT), FORCE_LIMIT)
        if not self.compensated:
            return u
        g = (axis.F_c + (axis.F_s - axis.F_c) * math.exp(-((v / axis.v_s) ** 2))) / axis.sigma_0
        decay = abs(v) / g
        # Exact for a velocity held over the period; expm1 keeps its digits near rest.
        gain = -math.expm1(-decay * T) / decay if decay > 0.0 else T
        z = self._z_hat * math.exp(-decay * T) + v * gain
        force = axis.sigma_0 * z + axis.sigma_1 * (z - self._z_hat) / T + axis.sigma_2 * v
        self._z_hat = z
        return min(max(u + force, -FORCE_LIMIT), FORCE_LIMIT)
