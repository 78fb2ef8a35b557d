"""Force sharing over one pole pitch: currents, forces, ripple, copper loss, reachable force."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.force_sharing.pole_pitch import forces_over, share_over
from motionlab.force_sharing.share import ForceModel
from motionlab.plant.table_map import MotorMap

Array = NDArray[np.float64]

_HALVINGS = 40


@dataclass(frozen=True)
class OverPitch:
    """Response to a force command at each of n positions.

    Attributes
    ----------
    position : ndarray, shape (n,)
        Evenly over one pole pitch of the controller's map, its end excluded, m.
    current : ndarray, shape (3, n)
        Phase currents, A.
    phase_thrust : ndarray, shape (3, n)
        Thrust of each phase on the plant's map, N.
    thrust : ndarray, shape (n,)
        Their sum, N.
    normal_force : ndarray, shape (n,)
        Normal force on the plant's map, N.
    believed : ndarray, shape (n,)
        Thrust on the controller's map, N.
    reachable : ndarray, shape (n,)
        Largest command of this direction that the currents can carry out there, as a magnitude, N.
    """

    position: Array
    current: Array
    phase_thrust: Array
    thrust: Array
    normal_force: Array
    believed: Array
    reachable: Array

    @property
    def loss(self) -> Array:
        """Copper loss over the resistance of a phase, sum of squared currents, A^2."""
        return (self.current**2).sum(axis=0)


class Ripple(NamedTuple):
    """How a thrust varies over the pole pitch."""

    mean: float  # N
    peak_to_peak: float  # N
    rms: float  # of what it differs from its mean, N

    @property
    def relative(self) -> float | None:
        """Peak to peak over the magnitude of the mean; None without a mean."""
        return None if self.mean == 0.0 else self.peak_to_peak / abs(self.mean)


def share_over_pitch(
    controller: ForceModel, plant: MotorMap, *, force: float, points: int
) -> OverPitch:
    """Return the response to a commanded `force`, N, over one pole pitch.

    Parameters
    ----------
    controller : ForceModel
        Determines the currents.
    plant : MotorMap
        Determines the forces.
    force : float
        Command, N.
    points : int
        Positions.
    """
    position = np.arange(points) / points * controller.map.formula.tau
    shared = share_over(controller, position=position, force=force)
    forces = forces_over(plant, position=position, current=shared.current)
    alone = [np.where(np.eye(3)[:, [k]] > 0.0, shared.current, 0.0) for k in range(3)]
    phases = [forces_over(plant, position=position, current=i).thrust for i in alone]
    return OverPitch(
        position=position,
        current=shared.current,
        phase_thrust=np.array(phases),
        thrust=forces.thrust,
        normal_force=forces.normal,
        believed=shared.force,
        reachable=reachable_over(controller, position=position, forward=force >= 0.0),
    )


def reachable_over(controller: ForceModel, *, position: Array, forward: bool) -> Array:
    """Return the largest command that the current limit does not reduce, at each position, N.

    Beyond it the force is smaller than the command.
    """
    sign = 1.0 if forward else -1.0

    def whole(force: Array) -> NDArray[np.bool_]:
        return ~share_over(controller, position=position, force=sign * force).limited

    low, high = np.zeros_like(position), np.ones_like(position)
    while (growing := whole(high) & (high < 1e6)).any():
        low, high = np.where(growing, high, low), np.where(growing, 2.0 * high, high)
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        fits = whole(middle)
        low, high = np.where(fits, middle, low), np.where(fits, high, middle)
    return low


def ripple(thrust: Array) -> Ripple:
    """Return how a thrust, N, shape (n,), varies."""
    return Ripple(float(thrust.mean()), float(np.ptp(thrust)), float(thrust.std()))
