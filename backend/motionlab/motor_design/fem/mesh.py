"""Structured meshes of mover and stator that meet on a line in the middle of the gap.

All edges are parallel to the axes, so a mesh is a stack of lines with triangles between them. On
the line in mid-gap both halves have the same, evenly spaced nodes: the mover moves by an index
shift, and no mesh noise gets into the force. Away from the gap lines have fewer nodes. Diagonals
alternate, so that the mesh is its own mirror image wherever the geometry is.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.motor_design.fem.geometry import Geometry

if TYPE_CHECKING:
    from skfem import MeshTri

GAP, IRON, STATOR_TEETH, AIR, COIL_OUT, COIL_IN = range(6)
"""What a triangle is made of; the coil sides carry current towards and away from the viewer."""

_MARGIN_PITCHES = 3
_GROWTH = 1.6
_NEAREST = 1e-8  # m, that an edge may lie to the middle


@dataclass(frozen=True)
class Resolution:
    """Mesh density and element order.

    Attributes
    ----------
    cells : int
        Cells a pole pitch along the gap; the geometry's teeth get an even number of them.
    order : int
        1 or 2, of the elements' polynomials.
    """

    cells: int
    order: int


class HalfMesh(NamedTuple):
    """One side of the mid-gap line."""

    mesh: MeshTri
    region: NDArray[np.int64]  # one of the constants above for each triangle


class NodeRow(NamedTuple):
    """Nodes at one height: their columns, of which the mid-gap line has all, and where they are."""

    y: float
    columns: NDArray[np.int64]
    x: NDArray[np.float64]


class Columns:
    """Columns of the mid-gap line, and which of them the geometry's edges lie on.

    Parameters
    ----------
    geometry : Geometry
        What to mesh.
    resolution : Resolution
        Cells a pitch, made even for teeth and for slots.
    pitches : int, optional
        Length of the mesh; the whole mover and air on both sides of it when left out.
    """

    def __init__(
        self, geometry: Geometry, resolution: Resolution, pitches: int | None = None
    ) -> None:
        g = geometry
        self.per_pitch = 2 * math.ceil(resolution.cells / 2)
        tooth = 2 * round(self.per_pitch * g.p / g.tau / 2)
        tooth = min(max(tooth, 2), self.per_pitch - 2)
        margin = max(_MARGIN_PITCHES, 2 * math.ceil(1.25 * g.coil / g.tau))
        self.pitches = pitches or 2 * g.n + margin + (margin + 1) % 2
        self.count = self.per_pitch * self.pitches
        self.length = g.tau * self.pitches
        self._middle = self.count // 2
        number = np.arange(-self.pitches, self.pitches + 1)[:, None]
        first = self._middle + (self.per_pitch - tooth) // 2
        columns = number * self.per_pitch + [first, first + tooth]
        where = number * g.tau + [g.s / 2, g.s / 2 + g.p]
        self._tooth_edges = columns.ravel(), where.ravel()

    @property
    def all(self) -> NDArray[np.int64]:
        """Return every column."""
        return np.arange(self.count + 1)

    def even(self, columns: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return evenly spaced x, 0 in the middle."""
        return np.asarray(columns - self._middle, dtype=float) * (self.length / self.count)

    def along_teeth(self, columns: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return x with the edges of teeth on columns."""
        return np.interp(columns, *self._tooth_edges)

    def quarters(self) -> NDArray[np.int64]:
        """Return tooth edges, and the middles of teeth and slots."""
        edges = self._tooth_edges[0]
        quarters = np.unique(np.concatenate([edges, (edges[1:] + edges[:-1]) // 2]))
        return np.union1d(quarters[(quarters > 0) & (quarters < self.count)], [0, self.count])

    def anchored(
        self, edges: list[float], step: float
    ) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]:
        """Return columns of about `step` apart, and those of `edges`, all mirrored about 0.

        The second and third are the columns of the edges and where these are.
        """
        right = np.unique(np.round([e for e in edges if e > _NEAREST], 9))
        at = np.round(right / self.length * self.count).astype(np.int64)
        for k in range(len(at)):  # two edges may not share a column
            at[k] = max(at[k], (at[k - 1] if k else 0) + 1)
        at, right = np.append(at, self._middle), np.append(right, self.length / 2)
        for k in range(len(at) - 2, -1, -1):
            at[k] = min(at[k], at[k + 1] - 1)
        at, right = np.concatenate([[0], at]), np.concatenate([[0.0], right])
        fill = [
            np.round(np.linspace(a, b, max(1, math.ceil((d - c) / step)) + 1)).astype(np.int64)
            for a, b, c, d in zip(at[:-1], at[1:], right[:-1], right[1:], strict=True)
        ]
        half = np.unique(np.concatenate(fill))
        mirrored = np.unique(np.concatenate([self._middle - half, self._middle + half]))
        anchors = np.concatenate([self._middle - at[:0:-1], self._middle + at])
        return mirrored, anchors, np.concatenate([-right[:0:-1], right])


def vertices(geometry: Geometry, resolution: Resolution) -> int:
    """Return how many nodes the mesh of a geometry has, without making it."""
    g = geometry
    columns = Columns(g, resolution)
    depths = g.tooth_depth, g.stator_tooth_depth
    count = sum(len(toothed(g, columns, depth)) for depth in depths) * (columns.count + 1)
    coarse = columns.anchored(_edges(g), g.tau / 5)[0]
    for lines, chosen in ((_back(g), columns.quarters()), (_above(g), coarse)):
        count += len(np.union1d(columns.all[::2], chosen)) + (len(lines) - 1) * len(chosen)
    return count


def stator(geometry: Geometry, columns: Columns) -> HalfMesh:
    """Return the stator and the lower half of the gap; the line in mid-gap is y = 0."""
    g = geometry
    tip, root = g.g / 2, g.g / 2 + g.stator_tooth_depth
    lines = toothed(g, columns, g.stator_tooth_depth)
    quarters = columns.quarters()
    half = np.union1d(columns.all[::2], quarters)
    for k, y in enumerate(_back(g)):
        chosen = half if k == 0 else quarters
        lines.append(NodeRow(y, chosen, columns.along_teeth(chosen)))
    mesh = stack([line._replace(y=-line.y) for line in lines])
    x, y = centroids(mesh)
    region = np.select(
        [y > -tip, y < -root, in_tooth(g, x)], [GAP, IRON, STATOR_TEETH], default=AIR
    )
    return HalfMesh(mesh, region)


def mover(geometry: Geometry, columns: Columns) -> HalfMesh:
    """Return the mover and the upper half of the gap, its middle at x = 0."""
    g = geometry
    tip, root = g.g / 2, g.g / 2 + g.tooth_depth
    window, yoke = root + g.shoe, root + g.shoe + g.window
    top = yoke + g.yoke
    half_width, opening = g.width / 2, g.window_width / 2
    shoe_edge = g.s / 2
    coarse, anchors, where = columns.anchored(_edges(g), g.tau / 5)
    half = np.union1d(columns.all[::2], coarse)
    lines = toothed(g, columns, g.tooth_depth)
    for k, y in enumerate(_above(g)):
        chosen = half if k == 0 else coarse
        lines.append(NodeRow(y, chosen, np.interp(chosen, anchors, where)))
    mesh = stack(lines)
    x, y = centroids(mesh)
    distance = np.abs(x)
    in_coil = (y > window) & (y < yoke)
    region = np.select(
        [
            y < tip,
            (y < root) & in_tooth(g, x) & (distance < half_width),
            (y > root) & (y < window) & (distance > shoe_edge) & (distance < half_width),
            in_coil & (distance > opening) & (distance < half_width),
            (y > yoke) & (y < top) & (distance < half_width),
            in_coil & (distance > opening - g.coil) & (distance < opening),
            in_coil & (distance > half_width) & (distance < half_width + g.coil),
        ],
        [GAP, IRON, IRON, IRON, IRON, COIL_IN, COIL_OUT],
        default=AIR,
    )
    return HalfMesh(mesh, region)


def _back(g: Geometry) -> list[float]:
    """Return heights of the lines behind the stator's teeth, downwards from mid-gap."""
    root = g.g / 2 + g.stator_tooth_depth
    return _graded(root, root + g.stator_back, g.tau / 8, g.tau / 3)


def _above(g: Geometry) -> list[float]:
    """Return heights of the lines above the mover's teeth."""
    root = g.g / 2 + g.tooth_depth
    window, yoke = root + g.shoe, root + g.shoe + g.window
    top = yoke + g.yoke
    return [
        *_graded(root, window, g.tau / 10, g.tau / 4),
        *_even(window, yoke, g.tau / 3.5),
        *_even(yoke, top, g.tau / 4.5),
        *_graded(top, top + g.yoke, g.tau / 3, g.tau),
    ]


def _edges(g: Geometry) -> list[float]:
    """Return where shoes, coils and limbs begin and end, right of the middle."""
    opening = g.window_width / 2
    return [g.s / 2, opening - g.coil, opening, g.width / 2, g.width / 2 + g.coil]


def toothed(geometry: Geometry, columns: Columns, depth: float) -> list[NodeRow]:
    """Return lines from mid-gap to the root of teeth of some depth."""
    tip, every = geometry.g / 2, columns.all
    heights = [
        *_even(0, tip, columns.length / columns.count),
        *_graded(tip, tip + depth, tip, geometry.tau / 6),
    ]
    lines = [NodeRow(0.0, every, columns.even(every))]
    return lines + [NodeRow(y, every, columns.along_teeth(every)) for y in heights]


def in_tooth(geometry: Geometry, x: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return where there are teeth, if the row of them has no end."""
    return np.abs((x / geometry.tau) % 1.0 - 0.5) < 0.5 * geometry.p / geometry.tau


def centroids(mesh: MeshTri) -> NDArray[np.float64]:
    """Return x and y of the middle of each triangle."""
    return mesh.p[:, mesh.t].mean(axis=1)


def stack(lines: list[NodeRow]) -> MeshTri:
    """Return triangles between lines of nodes, from first to last."""
    from skfem import MeshTri

    first = np.cumsum([0, *(len(line.x) for line in lines)])
    points = np.hstack([np.vstack([line.x, np.full(len(line.x), line.y)]) for line in lines])
    triangles: list[tuple[int, int, int]] = []
    for k, (a, b) in enumerate(pairwise(lines)):
        _strip(a.columns, b.columns, int(first[k]), int(first[k + 1]), triangles)
    return MeshTri(points, np.ascontiguousarray(np.array(triangles).T))


def _strip(
    a: NDArray[np.int64],
    b: NDArray[np.int64],
    at_a: int,
    at_b: int,
    out: list[tuple[int, int, int]],
) -> None:
    """Fill the strip between two lines; every other stretch between shared columns is mirrored."""
    shared = np.intersect1d(a, b)
    in_a = at_a + np.searchsorted(a, shared)
    in_b = at_b + np.searchsorted(b, shared)
    for k in range(len(shared) - 1):
        u = list(range(in_a[k], in_a[k + 1] + 1))
        v = list(range(in_b[k], in_b[k + 1] + 1))
        if k % 2:
            u, v = u[::-1], v[::-1]
        i, j, i_end, j_end = 0, 0, len(u) - 1, len(v) - 1
        while i < i_end or j < j_end:
            if i < i_end and ((i + 1) * j_end <= (j + 1) * i_end or j == j_end):
                out.append((u[i], u[i + 1], v[j]))
                i += 1
            else:
                out.append((u[i], v[j], v[j + 1]))
                j += 1


def _even(start: float, end: float, step: float) -> list[float]:
    count = max(1, math.ceil((end - start) / step - 1e-9))
    return [float(y) for y in np.linspace(start, end, count + 1)[1:]]


def _graded(start: float, end: float, first: float, most: float) -> list[float]:
    """Return heights whose steps grow from `first` to `most`, the last at `end`."""
    steps = [min(first, end - start)]
    while sum(steps) < (end - start) * (1 - 1e-9):
        steps.append(min(steps[-1] * _GROWTH, most))
    return [float(y) for y in start + np.cumsum(steps) * ((end - start) / sum(steps))]
