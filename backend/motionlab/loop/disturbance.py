"""Response of the closed loop of one axis to disturbances of its thrust and of its encoder."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.config.scenario import Scenario
from motionlab.lanes.bank import TABLES
from motionlab.loop.linearise import Loop, controller_about, parameters, plant_about
from motionlab.loop.margins import sampled

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


class DisturbanceResponse(NamedTuple):
    """Absolute responses of the measured following error, over frequency.

    Attributes
    ----------
    frequency : ndarray, shape (n,)
        Hz, closer where a response changes fast.
    force : ndarray, shape (n,)
        ``abs(P_d / (1 + L))``, of a force that adds to the thrust, m/N.
    encoder : ndarray, shape (n,)
        ``abs(1 / (1 + L))``, of what the encoder reads besides the position, 1.
    stable : bool
        Whether the loop is; the responses of one that is not mean nothing.
    """

    frequency: Array
    force: Array
    encoder: Array
    stable: bool


@TABLES.lease()
def disturbance_response(
    scenario: Scenario, variant: str, axis: str, *, v: float
) -> DisturbanceResponse:
    """Return the response of the following error of one axis to disturbances of its loop.

    With the plant P_d from the thrust to the position and the open loop L = C P,
    ``e = -(P_d d + n) / (1 + L)``.

    Parameters
    ----------
    scenario : Scenario
        Motor and controllers.
    variant : str
        Which controller.
    axis : str
        ``x`` or ``y``.
    v : float
        Velocity about which the loop is linearised, m/s; 0 is stuck.

    Raises
    ------
    ConfigError
        As `linearise`.
    """
    par = parameters(scenario, variant, axis)
    loop = Loop(plant_about(par, v), controller_about(par, v))
    moved = plant_about(par, v, disturbance=True)

    def responses(frequency: Array) -> Complex:
        sensitivity = 1.0 / (1.0 + loop.open(frequency))
        return np.stack([moved.response(frequency) * sensitivity, sensitivity])

    frequency, values = sampled(responses)
    force, encoder = np.abs(values)
    return DisturbanceResponse(frequency, force, encoder, loop.stable)
