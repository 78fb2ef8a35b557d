"""Positions of the stages, and camera presets."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motionlab.scene3d.geometry import STAGE_GAP, TOP, Layout
from motionlab.scene3d.protocol import SceneDescription
from motionlab.scene3d.view_settings import ViewSettings

FIELD_OF_VIEW = 0.6
"""Of the camera, from top to bottom, rad."""

_FLAT = 0.08  # nearly parallel rays, rad
_LABEL = 0.035  # from the stator to the name of a machine, m
_GHOST_LABEL = 0.075  # from there to the name of a ghost, m


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
    field_of_view : float
        From top to bottom, rad.
    """

    direction: tuple[float, float, float]
    wide: float
    tall: float
    middle: tuple[float, float, float] = (0.0, 0.0, 0.0)
    field_of_view: float = FIELD_OF_VIEW

    def position(self, aspect: float) -> tuple[float, float, float]:
        """Return the camera position for a viewport of this width over height, m."""
        direction = np.array(self.direction) / np.linalg.norm(self.direction)
        half = max(self.tall, self.wide / aspect) / 2.0
        x, y, z = half / np.tan(self.field_of_view / 2.0) * direction + self.middle
        return float(x), float(y), float(z)


def stage_offsets(stages: int, layout: Layout, *, ghost: bool = False) -> list[float]:
    """Return the x of each stage's middle, m: side by side about the origin, or all there."""
    pitch = 0.0 if ghost else 2 * layout.rail + STAGE_GAP
    return [(i - (stages - 1) / 2) * pitch for i in range(stages)]


def label_place(layout: Layout, *, ghost: bool = False) -> float:
    """Return the y of a machine's name, m: in front of its stator, a ghost's below the other's."""
    return -layout.half[1] - _LABEL - (_GHOST_LABEL if ghost else 0.0)


def camera_of(settings: ViewSettings, start: SceneDescription) -> Camera:
    """Return the preset that a viewer has chosen."""
    layout = Layout.of(start.axes)
    stages = 1 if settings.ghost else len(start.variants)
    wide = 2.2 * layout.rail * stages + STAGE_GAP
    lower = _GHOST_LABEL if settings.ghost else 0.0
    deep = 2.0 * layout.half[1] + lower
    match settings.camera:
        case "overview":
            direction = (-0.12, -1.0, 0.8)
            return Camera(direction, 1.25 * wide, 1.06 * deep, middle=(0.0, -0.06 - lower / 2, 0.0))
        case "top":
            middle = (0.0, -0.02 - lower / 2, 0.0)
            return Camera((0.0, -0.002, 1.0), wide, 1.25 * deep, middle)
        case "side":
            return Camera((0.0, -1.0, 0.1), 1.1 * wide, 0.36, middle=(0.0, 0.0, TOP))
        case "section":
            middle = (0.0, 0.0, 0.012)
            return Camera((0.0, -1.0, 0.0), 0.18, 0.068, middle, field_of_view=_FLAT)
        case "follow":
            return Camera((-0.25, -1.0, 0.85), 0.3, 0.22, middle=(0.0, 0.0, TOP))
