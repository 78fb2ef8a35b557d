"""Shapes of the stage, m, as meshes of vertices and triangles; the origin is at mid-stroke.

Teeth stand on the plane z = 0 with their tops; the movers hang above them. What the paper prints
(Huang et al., IEEE Access 2019, section II) is named here; beams, rails and plates are this
project's drawing and carry no figures.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.scene3d.protocol import DrawnAxis

Array = NDArray[np.float64]

AIR_GAP = 0.3e-3
MOVER_HEIGHT = 36.0e-3
STACK = 42.3e-3
TEETH_PER_LIMB = 3

TOOTH_HEIGHT = 3.6e-3
BEAM = 14e-3
ARM = 16e-3
TOP = AIR_GAP + MOVER_HEIGHT
"""Height of the movers' tops above the teeth, m."""

STAGE_GAP = 0.06
"""Between two stages side by side, m."""

TEETH_MAX = 12_000
"""Teeth of one stage that are still drawn one by one."""


class Mesh(NamedTuple):
    """Vertices, shape (n, 3), and triangles, shape (m, 3)."""

    vertices: Array
    faces: NDArray[np.int64]


_UNDERSIDE = [(0, 2, 1), (1, 2, 3)]
_TOP_AND_SIDES = [
    *((4, 5, 6), (5, 7, 6), (0, 1, 4), (1, 5, 4), (2, 6, 3), (3, 6, 7)),
    *((0, 4, 2), (2, 4, 6), (1, 3, 5), (3, 7, 5)),
]


def box(x: tuple[float, float], y: tuple[float, float], z: tuple[float, float]) -> Mesh:
    """Return a box between two bounds on each axis."""
    corners = np.array([[x[i & 1], y[i >> 1 & 1], z[i >> 2]] for i in range(8)])
    return Mesh(corners, np.array([*_UNDERSIDE, *_TOP_AND_SIDES]))


def centred(x: float, y: float, z: tuple[float, float], at: tuple[float, float] = (0, 0)) -> Mesh:
    """Return a box of lengths x and y about a point of the plane."""
    return box((at[0] - x / 2, at[0] + x / 2), (at[1] - y / 2, at[1] + y / 2), z)


def merged(*meshes: Mesh) -> Mesh:
    """Return several meshes as one."""
    starts = np.cumsum([0] + [len(mesh.vertices) for mesh in meshes[:-1]])
    faces = [mesh.faces + start for mesh, start in zip(meshes, starts, strict=True)]
    return Mesh(np.concatenate([mesh.vertices for mesh in meshes]), np.concatenate(faces))


def turned(mesh: Mesh) -> Mesh:
    """Return a mesh of the x axis for the y axis: a quarter turn about z."""
    x, y, z = mesh.vertices.T
    return Mesh(np.stack([-y, x, z], axis=1), mesh.faces)


def core(pitch: float) -> Mesh:
    """Return the iron of a mover along x: a U of two limbs with three teeth each."""
    tooth = pitch / 2
    limb = TEETH_PER_LIMB * pitch
    floor = AIR_GAP + TOOTH_HEIGHT
    parts = [
        centred(tooth, STACK, (AIR_GAP, floor), ((i - 2.5) * pitch, 0))
        for i in range(2 * TEETH_PER_LIMB)
    ]
    for side in (-limb / 2, limb / 2):
        parts.append(centred(limb - tooth, STACK, (floor, floor + 3e-3), (side, 0)))
        parts.append(centred(0.45 * limb, STACK, (floor + 3e-3, TOP - 8e-3), (side, 0)))
    parts.append(centred(1.45 * limb, STACK, (TOP - 8e-3, TOP)))
    return merged(*parts)


def coils(pitch: float) -> Mesh:
    """Return the windings round both limbs of a mover along x."""
    limb = TEETH_PER_LIMB * pitch
    z = (AIR_GAP + TOOTH_HEIGHT + 4e-3, TOP - 9e-3)
    return merged(
        *(centred(0.88 * limb, STACK + 0.5 * limb, z, (side, 0)) for side in (-limb / 2, limb / 2))
    )


@dataclass(frozen=True)
class Layout:
    """Positions of the parts of one stage, m.

    A phase's thrust is sin(2 pi (p + offset)/tau - 2 pi k/3) for k = 0, 1, 2, so mover k sits a
    third of a pitch before mover k - 1, whole pitches aside, and its teeth face those of the
    stator half a pitch later than its thrust crosses zero upwards.

    Attributes
    ----------
    axes : tuple of DrawnAxis
        x and y.
    movers : ndarray, shape (2, 3, 2)
        Centre of each mover on its platform: axis, phase, (x, y).
    half : tuple of float
        Half lengths of the toothed plane.
    x_platform : float
        Half length of the x platform.
    rail : float
        Distance of the y rails from the middle.
    """

    axes: tuple[DrawnAxis, DrawnAxis]
    movers: Array
    half: tuple[float, float]
    x_platform: float
    rail: float

    @classmethod
    def of(cls, axes: tuple[DrawnAxis, DrawnAxis]) -> Layout:
        """Lay a stage out for two axes."""
        x, y = axes
        spacing = 20 / 3 * x.pitch
        along = np.array([[(k - 1) * spacing, 0.0] for k in range(3)])
        x_platform = spacing + 2.9 * x.pitch + ARM
        reach = x.stroke + x_platform
        # The y movers hang below the two beams: a and c in front, b behind.
        row = STACK / 2 + 3 * x.pitch / 2 + 3.4 * y.pitch
        behind = -row - y.pitch / 3 + round(2 * row / y.pitch) * y.pitch
        aside = 0.4 * reach
        across = np.array([[-aside, -row], [0.0, behind], [aside, -row + y.pitch / 3]])
        return cls(
            axes,
            np.stack([along, across]),
            (reach + 0.006, y.stroke + row + 3.4 * y.pitch),
            x_platform,
            reach + 0.022,
        )

    def teeth(self) -> Mesh:
        """Return the stator's teeth as one mesh without undersides; none where they are too many.

        Teeth are square posts, so that both axes see the same pitch and duty.
        """
        places = [self.tooth_places(axis) for axis in (0, 1)]
        grid = np.stack(np.meshgrid(*places, indexing="ij"), axis=-1).reshape(-1, 2)
        if len(grid) > TEETH_MAX:
            grid = grid[:0]
        x, y = (axis.pitch / 2 for axis in self.axes)
        tooth = centred(x, y, (-TOOTH_HEIGHT, 0.0))
        vertices = tooth.vertices + np.pad(grid, ((0, 0), (0, 1)))[:, None]
        faces = np.array(_TOP_AND_SIDES) + 8 * np.arange(len(grid))[:, None, None]
        return Mesh(vertices.reshape(-1, 3), faces.reshape(-1, 3))

    def tooth_places(self, axis: int) -> Array:
        """Return the middles of the teeth along an axis, m."""
        pitch, half = self.axes[axis].pitch, self.half[axis]
        first = self.movers[axis, 0, axis] - self.axes[axis].offset
        n = np.arange(np.ceil((-half - first) / pitch + 0.5), (half - first) / pitch - 0.5)
        return first + n * pitch

    def plate(self) -> Mesh:
        """Return the plane that the teeth stand on."""
        x, y = self.half
        return centred(2 * x, 2 * y, (-TOOTH_HEIGHT - 10e-3, -TOOTH_HEIGHT))

    def bed(self) -> Mesh:
        """Return the bed below it."""
        z = -TOOTH_HEIGHT - 10e-3
        return centred(2 * self.rail + 0.036, 2 * self.half[1] + 0.03, (z - 22e-3, z))

    def y_rails(self) -> Mesh:
        """Return the rails of the y platform, which stand on the bed."""
        z = (-TOOTH_HEIGHT - 10e-3, 4e-3)
        length = 2 * self.half[1] + 0.01
        return merged(*(centred(0.012, length, z, (s * self.rail, 0)) for s in (-1, 1)))

    def y_platform(self) -> Mesh:
        """Return the outer platform: two beams, two end blocks and their carriages."""
        row = abs(float(self.movers[1, 0, 1]))
        z = (TOP, TOP + BEAM)
        parts = []
        for side in (-1, 1):
            parts.append(centred(2 * self.rail, 0.026, z, (0, side * row)))
            parts.append(centred(0.026, 2 * row + 0.026, z, (side * self.rail, 0)))
            for end in (-1, 1):
                at = (side * self.rail, end * (row - 0.014))
                parts.append(centred(0.03, 0.05, (-2e-3, TOP), at))
        return merged(*parts)

    def x_rails(self) -> Mesh:
        """Return the rails of the x platform, which the outer platform carries."""
        inner = abs(float(self.movers[1, 0, 1])) - 0.013
        z = (TOP + 3e-3, TOP + 11e-3)
        return merged(
            *(centred(2 * self.rail, 0.008, z, (0, side * (inner - 0.004))) for side in (-1, 1))
        )

    def x_platform_mesh(self) -> Mesh:
        """Return the inner platform: a spine over the movers and the arms that ride the rails."""
        inner = abs(float(self.movers[1, 0, 1])) - 0.013
        x = self.x_platform
        z = (TOP, TOP + 10e-3)
        ends = [(side * (x - ARM / 2), 0.0) for side in (-1, 1)]
        arms = [centred(ARM, 2 * inner - 2e-3, (z[1] + 1e-3, z[1] + 7e-3), at) for at in ends]
        blocks = [centred(ARM, 0.022, (z[1], z[1] + 1e-3), at) for at in ends]
        table = centred(0.03, 0.03, (z[1], z[1] + 10e-3))
        return merged(centred(2 * x, 0.022, z), *arms, *blocks, table)

    @property
    def tool(self) -> float:
        """Height of the tool point, at which path and trace are drawn, m."""
        return TOP + 26e-3
