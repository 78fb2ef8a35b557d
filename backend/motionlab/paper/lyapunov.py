"""The paper's stability argument, eqs (25) to (38), evaluated along a run.

With ``beta = e e_z``, ``e_z = z - z*`` the paper takes ``V = beta^2/2`` of eq. (37) and argues that
(25) makes ``dV/dt = -(k_p/k_d + abs(v)/g) beta^2 <= 0``, eq. (38). Along a simulated run every term
is known, the true bristle state z among them, so that V, its derivative by the argument and its
true derivative can be compared.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motionlab.config.plant import FrictionConfig
from motionlab.config.timing import CONTROL_PERIOD
from motionlab.plant.friction import stribeck_level
from motionlab.telemetry.recording import VariantRecord

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Lyapunov:
    """The terms of the argument along a run; all arrays of shape (ticks,).

    Attributes
    ----------
    time : ndarray
        From the first tick on, s.
    speed : ndarray
        Measured speed, m/s.
    error, bristle_error : ndarray
        e and e_z of eq. (27), m.
    V : ndarray
        Eq. (37), m^4.
    argued : ndarray
        dV/dt by the argument, eq. (38), m^4/s: never above 0.
    rate : ndarray
        dV/dt by central differences of V, m^4/s.
    denominator : ndarray
        Of K in eq. (25), N^2 s/m.
    """

    time: Array
    speed: Array
    error: Array
    bristle_error: Array
    V: Array
    argued: Array
    rate: Array
    denominator: Array

    @property
    def rising_share(self) -> float:
        """Share of the ticks at which V rises; zero by (38)."""
        return float((self.rate > 0.0).mean())

    @property
    def singular_places(self) -> NDArray[np.int_]:
        """Ticks after which the denominator of (25) has another sign: K has no bound there."""
        signs = np.sign(self.denominator)
        moves = np.flatnonzero(signs != 0.0)  # at rest on the reference it is 0/0, not a crossing
        return moves[np.flatnonzero(np.diff(signs[moves]) != 0.0)]

    @property
    def singular_rate(self) -> float:
        """How often the denominator crosses zero, 1/s."""
        return len(self.singular_places) / (len(self.time) * CONTROL_PERIOD)

    @property
    def singular_speeds(self) -> Array:
        """Speeds at which it does, m/s."""
        return self.speed[self.singular_places]

    @property
    def zero_error_bristle(self) -> float:
        """Largest abs(e_z) at zero crossings of e, m; zero by (34).

        V is 0 there although the state is not: V is only semidefinite.
        """
        signs = np.sign(self.error)
        crossings = np.flatnonzero(signs[1:] * signs[:-1] < 0.0)
        at_rest = np.flatnonzero(signs == 0.0)
        places = np.concatenate([crossings, at_rest])
        return float(np.abs(self.bristle_error[places]).max()) if len(places) else 0.0


def lyapunov(
    record: VariantRecord, axis: str, *, friction: FrictionConfig, k_p: float, k_d: float
) -> Lyapunov:
    """Return the terms of the argument along one axis of a run.

    Parameters
    ----------
    record : VariantRecord
        Samples of a window, at least three ticks.
    axis : str
        ``x`` or ``y``.
    friction : FrictionConfig
        Of the controller's model.
    k_p, k_d : float
        Gains, N/m and N s/m.

    Returns
    -------
    Lyapunov
        With measured e and v, as in the controller, and true z.

    Raises
    ------
    ValueError
        If the window is shorter than three ticks or holds samples that are not finite.
    """
    e, z, z_hat, v, u = (
        record.channel(name, axis).astype(np.float64)
        for name in (
            "following_error",
            "bristle",
            "bristle_estimate",
            "velocity_measured",
            "pd_force",
        )
    )
    if len(e) < 3 or not np.isfinite([e, z, z_hat, v, u]).all():
        raise ValueError("a window needs three ticks, all of them before a divergence")
    steady = stribeck_level(v, friction.F_c, friction.F_s, friction.v_s)
    decay = friction.sigma_0 * np.abs(v) / steady
    e_z = z - z_hat
    beta = e * e_z
    V = 0.5 * beta**2
    return Lyapunov(
        time=np.arange(float(len(e))) * CONTROL_PERIOD,
        speed=np.abs(v),
        error=e,
        bristle_error=e_z,
        V=V,
        argued=-(k_p / k_d + decay) * beta**2,
        rate=np.gradient(V, CONTROL_PERIOD),
        denominator=friction.sigma_1 * u + e * k_d * (friction.sigma_1 * decay - friction.sigma_0),
    )
