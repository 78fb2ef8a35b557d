"""Plates without ribs whose deflection a textbook has, for tests and benchmarks."""

from __future__ import annotations

import numpy as np

from motionlab.motor_design.platform.bending import Plate
from motionlab.motor_design.platform.inputs import Load, Shape

SIZE, THICKNESS, E, NU = 0.4, 8e-3, 70e9, 0.3
RIGIDITY = E * THICKNESS**3 / (12 * (1 - NU**2))
POINT = Load(spacing_x=0, spacing_y=0, length=0, width=0, forces=(25, 25, 25, 25))

# support, long over short side, load, w D/(P a^2) or w D/(q a^4) in the middle; Timoshenko and
# Woinowsky-Krieger, Theory of Plates and Shells, tables 8, 23, 35 and section 44
TEXTBOOK: dict[str, tuple[str, float, str, float]] = {
    "simply supported, point": ("edges", 1, "point", 0.01160),
    "simply supported, uniform": ("edges", 1, "uniform", 0.00406),
    "clamped, point": ("clamped", 1, "point", 0.00560),
    "clamped, uniform": ("clamped", 1, "uniform", 0.00126),
    "two to one, point": ("edges", 2, "point", 0.01651),
    "two to one, uniform": ("edges", 2, "uniform", 0.01013),
    "two to one clamped, uniform": ("clamped", 2, "uniform", 0.00254),
}


def flat(**changes) -> Shape:
    """Return a plate without ribs."""
    base = {"length": SIZE, "width": SIZE, "thickness": THICKNESS, "E": E, "nu": NU}
    return Shape(**{**base, "ribs_x": 0, "ribs_y": 0, "span_x": 0.02, "span_y": 0.02, **changes})


def coefficient(support: str, longer: float, load: str, cells: int = 16) -> float:
    """Return the deflection in the middle over P a^2/D or q a^4/D."""
    shape = flat(length=SIZE * longer, support=support)
    over = {"length": shape.length, "width": SIZE, "spacing_x": 0, "spacing_y": 0}
    force = POINT if load == "point" else Load(**over, forces=(25, 25, 25, 25))
    surface = Plate(shape, force, cells=cells).surface(np.array(force.forces))
    middle = float(surface.at(np.zeros(1), np.zeros(1))[0, 0])
    area = shape.length * SIZE
    return middle * RIGIDITY / (100 * SIZE**2 * (1 if load == "point" else SIZE**2 / area))
