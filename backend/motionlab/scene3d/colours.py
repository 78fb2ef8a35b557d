"""Colours of the scene, sRGB."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from motionlab.scene3d.geometry import Array
from motionlab.scene3d.protocol import Values

ACCENTS = ((213, 94, 0), (0, 114, 178))
PHASES = ((0, 158, 115), (230, 159, 0), (86, 180, 233))
FRICTION, LOAD = (134, 142, 150), (148, 87, 178)
STEEL, TOOTH, IRON = (96, 104, 112), (150, 158, 166), (70, 72, 78)
CUT_IRON = (138, 145, 153)
RAIL, BED = (176, 183, 190), (58, 64, 71)
Y_PLATFORM, X_PLATFORM = (120, 130, 142), (206, 211, 216)
PATH = (134, 142, 150)

LEVELS = 24
FULL_CURRENT = 10.0
"""Current of the brightest winding, A: the paper's peak."""


def linear(colours: Array) -> NDArray[np.uint8]:
    """Return sRGB colours, 0 to 255, as viser's batched meshes and arrows take them: linear."""
    return np.rint(255.0 * (np.asarray(colours) / 255.0) ** 2.2).astype(np.uint8)


def current_levels(currents: Values) -> list[int]:
    """Return the level of each phase's colour: 0 without current, LEVELS at 10 A and beyond.

    The root shows the few ampere of a slow motion, too.
    """
    return [min(round(LEVELS * math.sqrt(abs(i) / FULL_CURRENT)), LEVELS) for i in currents]


def _phase_colours() -> NDArray[np.uint8]:
    dim = 0.4 * np.array(PHASES) + 30.0
    share = np.linspace(0.0, 1.0, LEVELS + 1)[:, None, None]
    return linear(dim + share * (np.array(PHASES) - dim))


PHASE_COLOURS = _phase_colours()
"""Colour of each level and phase, uint8 of shape (LEVELS + 1, 3, 3)."""
