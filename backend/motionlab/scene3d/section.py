"""Shapes of the section through the movers of one axis, m: lengths along the axis are true.

Height is not: the air gap is drawn ten times larger, limbs are shortened. Movers a, b, c stand side
by side, moved by whole pitches where the machine has them elsewhere. The view rides with the
movers, and the stator passes below them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motionlab.scene3d.geometry import (
    TEETH_PER_LIMB,
    TOOTH_HEIGHT,
    Array,
    Mesh,
    box,
    merged,
)
from motionlab.scene3d.protocol import DrawnAxis

GAP_FACTOR = 10.0
"""Factor by which the air gap is drawn larger."""

THRUST_SCALE = 4e-3
"""Length of an arrow of thrust in the section, m/N."""

NORMAL_SCALE = 0.4e-3
"""Length of an arrow of normal force in the section, m/N."""

IN_FRONT = -6e-3
"""Where lines and arrows are drawn, towards the camera, m."""

_DEPTH = 2e-3
_BACK, _FLOOR, _LIMB, _YOKE = 5e-3, 3e-3, 11e-3, 6e-3  # heights
_SPACING = 20 / 3  # pitches from mover to mover, as of the x axis
_HALF_WIDTH = 0.095


@dataclass(frozen=True)
class Section:
    """The section of one axis."""

    axis: DrawnAxis

    @property
    def gap(self) -> float:
        """Height of the air gap as drawn, m."""
        return GAP_FACTOR * self.axis.gap

    @property
    def yoke(self) -> tuple[float, float]:
        """Lower and upper edge of a mover's yoke, m."""
        low = self.gap + TOOTH_HEIGHT + _FLOOR + _LIMB
        return low, low + _YOKE

    @property
    def movers(self) -> Array:
        """Middle of each mover along the axis, m, shape (3,)."""
        return np.array([-1.0, 0.0, 1.0]) * (_SPACING * self.axis.pitch)

    @property
    def poles(self) -> Array:
        """Middle of each tooth of each mover, m, shape (3, 6)."""
        teeth = (np.arange(2 * TEETH_PER_LIMB) - TEETH_PER_LIMB + 0.5) * self.axis.pitch
        return self.movers[:, None] + teeth

    def comb(self) -> Mesh:
        """Return the stator's teeth, one of them at 0."""
        pitch = self.axis.pitch
        reach = int(np.ceil(_HALF_WIDTH / pitch)) + 1
        return merged(
            *(
                _bar((n * pitch - pitch / 4, n * pitch + pitch / 4), (-TOOTH_HEIGHT, 0.0))
                for n in range(-reach, reach + 1)
            )
        )

    def comb_shift(self, position: float) -> float:
        """Return the drawn position of the comb's tooth at 0, m.

        The teeth stand at ``movers[0] - (p + offset) + n tau``.
        """
        return float((self.movers[0] - position - self.axis.offset) % self.axis.pitch)

    def back(self) -> Mesh:
        """Return the iron below the stator's teeth."""
        z = -TOOTH_HEIGHT
        return _bar((-_HALF_WIDTH, _HALF_WIDTH), (z - _BACK, z))

    def iron(self) -> Mesh:
        """Return the iron of one mover: two limbs of three teeth, joined by a yoke."""
        pitch = self.axis.pitch
        limb, gap = TEETH_PER_LIMB * pitch, self.gap
        floor = gap + TOOTH_HEIGHT
        low, high = self.yoke
        teeth = self.poles[1] - self.movers[1]
        parts = [_bar((t - pitch / 4, t + pitch / 4), (gap, floor)) for t in teeth]
        for side in (-limb / 2, limb / 2):
            wide, narrow = (limb - pitch / 2) / 2, 0.225 * limb
            parts.append(_bar((side - wide, side + wide), (floor, floor + _FLOOR)))
            parts.append(_bar((side - narrow, side + narrow), (floor + _FLOOR, low)))
        parts.append(_bar((-0.725 * limb, 0.725 * limb), (low, high)))
        return merged(*parts)

    def windings(self) -> Mesh:
        """Return the cut windings of one mover: both sides of each limb."""
        limb = TEETH_PER_LIMB * self.axis.pitch
        z = (self.gap + TOOTH_HEIGHT + _FLOOR + 1e-3, self.yoke[0] - 1e-3)
        near, far = 0.24 * limb, 0.44 * limb
        return merged(
            *(
                _bar((at + low, at + high), z)
                for at in (-limb / 2, limb / 2)
                for low, high in ((-far, -near), (near, far))
            )
        )

    def flux(self, to_aligned: Array, carrying: np.ndarray) -> Array:
        """Return lines from the teeth of each mover to those of the stator that they are drawn to.

        Parameters
        ----------
        to_aligned : ndarray, shape (3,)
            From each phase to its nearest aligned position, m.
        carrying : ndarray of bool, shape (3,)
            Whether a phase carries current; the others have none.

        Returns
        -------
        ndarray, shape (6 n, 2, 3)
            Both ends of each line, m.
        """
        lines = np.zeros((3, 2 * TEETH_PER_LIMB, 2, 3))
        lines[..., 0, 0] = self.poles
        lines[..., 1, 0] = self.poles + to_aligned[:, None]
        lines[..., :, 1] = IN_FRONT
        lines[..., 0, 2] = self.gap
        return lines[carrying].reshape(-1, 2, 3)

    def to_aligned(self, position: float) -> Array:
        """Return the distance from each phase to its nearest aligned position, m, shape (3,)."""
        turns = (position + self.axis.offset) / self.axis.pitch - np.arange(3) / 3.0
        return (0.5 - (turns - np.floor(turns))) * self.axis.pitch


def _bar(x: tuple[float, float], z: tuple[float, float]) -> Mesh:
    return box(x, (-_DEPTH, _DEPTH), z)
