"""Positions of the stages, and camera presets."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motionlab.scene3d.geometry import STAGE_GAP, TOP, Layout
from motionlab.scene3d.protocol import SceneDescription

FIELD_OF_VIEW = 0.6
"""Of the camera, from top to bottom, rad."""


@dataclass(frozen=True)
class Camera:
    """A preset of the camera.

    Attributes
    ----------
    direction : tuple of float
        From its target to the camera.
    wide, tall : float
        Width and height that must fit into the picture, m.
    middle : tuple of float
        Target, m.
    follows : int or None
        The stage whose tool point stays in the middle.
    """

    direction: tuple[float, float, float]
    wide: float
    tall: float
    middle: tuple[float, float, float] = (0.0, 0.0, 0.0)
    follows: int | None = None

    def position(self, aspect: float) -> tuple[float, float, float]:
        """Return the camera position for a viewport of this width over height, m."""
        direction = np.array(self.direction) / np.linalg.norm(self.direction)
        distance = max(self.tall, self.wide / aspect) / (2.0 * np.tan(FIELD_OF_VIEW / 2.0))
        x, y, z = distance * direction + self.middle
        return float(x), float(y), float(z)


def stage_offsets(stages: int, layout: Layout) -> list[float]:
    """Return the x of each stage's middle: side by side about the origin, m."""
    pitch = 2 * layout.rail + STAGE_GAP
    return [(i - (stages - 1) / 2) * pitch for i in range(stages)]


def presets(start: SceneDescription) -> dict[str, Camera]:
    """Return the camera presets by their names on the buttons."""
    layout = Layout.of(start.axes)
    wide = 2.2 * layout.rail * len(start.variants) + STAGE_GAP
    deep = 2.0 * layout.half[1]
    cameras = {
        "Overview": Camera((-0.12, -1.0, 0.8), 1.25 * wide, 1.2 * deep, middle=(0.0, -0.03, 0.0)),
        "Top": Camera((0.0, -0.002, 1.0), wide, 1.4 * deep),
        "Side by side": Camera((0.0, -1.0, 0.28), 1.15 * wide, 0.6 * deep),
    }
    for index, name in enumerate(start.variants):
        cameras[name] = Camera(
            (-0.25, -1.0, 0.85), 0.3, 0.22, middle=(0.0, 0.0, TOP), follows=index
        )
    return cameras
