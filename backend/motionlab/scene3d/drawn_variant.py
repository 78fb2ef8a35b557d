"""One variant's numbers at one moment."""

from __future__ import annotations

import math

import numpy as np

from motionlab.scene3d.protocol import CURRENTS, OWN, SHARED, Values


class DrawnVariant:
    """The numbers of one variant in a pose.

    Parameters
    ----------
    pose : ndarray, shape (width,)
        One pose, as `motionlab.scene3d.protocol` orders it.
    index : int
        Which variant.
    forces : ndarray, shape (variants, 2, 2, 3)
        Thrust and normal force of each variant, axis and phase, N.
    """

    def __init__(self, pose: Values, index: int, forces: Values) -> None:
        first = self.first(index)
        self.position, self.thrust, self.friction = pose[first : first + 6].reshape(3, 2)
        self.currents = pose[first + 6 : first + 12].reshape(2, 3)
        self.reference = pose[:2]
        self.load = pose[2:4]
        self.phase_thrust, self.phase_normal = forces[index, :, 0], forces[index, :, 1]

    @staticmethod
    def first(index: int) -> int:
        """Return the first index of a variant's numbers."""
        return 2 * len(SHARED) + index * 2 * (len(OWN) + len(CURRENTS))

    @property
    def holds(self) -> bool:
        """Whether there is anything to show: a variant that diverged has no numbers."""
        return math.isfinite(self.position[0]) and math.isfinite(self.position[1])

    def drawn_position(self, magnification: float, reach: tuple[float, float]) -> list[float]:
        """Return the drawn platform positions: reference less magnified error, within reach.

        Parameters
        ----------
        magnification : float
            Factor on the error; 1 draws the true position.
        reach : tuple of float
            Largest distance from the middle of each axis, m.
        """
        if magnification == 1.0:
            return self.position.tolist()
        drawn = self.reference + magnification * (self.position - self.reference)
        return np.clip(drawn, np.negative(reach), reach).tolist()
