"""Forces as arrows."""

from __future__ import annotations

import numpy as np
import viser

from motionlab.scene3d.colours import linear
from motionlab.scene3d.geometry import Array
from motionlab.scene3d.protocol import Values

THRUST_SCALE = 8e-3
"""Length of an arrow along an axis, m/N."""

NORMAL_SCALE = 0.8e-3
"""Length of an arrow of normal force, m/N: that force is about ten times larger."""

_AWAY = np.array([[0.0, 0.0, -100.0], [0.0, 0.0, -100.1]], np.float32)
"""Beyond what any camera shows."""


class ForceArrows:
    """Some arrows in one node; what is shorter than its head is left out.

    Parameters
    ----------
    scene : viser.SceneApi
        The client's own.
    name : str
        Of the node.
    colours : array_like, shape (n, 3)
        sRGB of each arrow.
    size : float
        Length of a head, m.
    """

    def __init__(self, scene: viser.SceneApi, name: str, colours: Array, size: float) -> None:
        self._size = size
        self._node = scene.add_arrows(
            name,
            np.tile(_AWAY, (len(colours), 1, 1)),
            linear(colours),
            shaft_radius=0.26 * size,
            head_radius=0.64 * size,
            head_length=size,
            visible=False,
        )

    def draw(self, starts: Values, vectors: Values, drawn: np.ndarray) -> None:
        """Draw the arrows from their starts, shape (n, 3), for those that are wanted."""
        with np.errstate(invalid="ignore"):
            long = drawn & (np.abs(vectors).sum(axis=1) > self._size)
        visible = bool(long.any())
        if visible != self._node.visible:
            self._node.visible = visible
        if visible:
            points = np.stack([starts, starts + vectors], axis=1)
            # Their number stays: viser takes colours and points in turn, and refuses a mismatch.
            self._node.points = np.where(long[:, None, None], points, _AWAY).astype(np.float32)
