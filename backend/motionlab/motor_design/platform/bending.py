"""Bending of a ribbed rectangular plate by finite elements.

Kirchhoff's plate with the elements of Bogner, Fox and Schmit: bicubic Hermite polynomials on
rectangles, continuous with their slopes. A plate's rigidity is ``D = E t^3/(12 (1 - nu^2))``; ribs
add their bending and torsion, spread evenly over the strip that they stand on.
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import splu
from skfem import Basis, BilinearForm, ElementQuadBFS, LinearForm, MeshQuad
from skfem.helpers import dd

from motionlab.motor_design.platform.inputs import Load, Shape
from motionlab.motor_design.platform.ribs import Rib, rib

_NEAR = 1e-9  # m, at which lines of the mesh are one
_U, _U_X, _U_Y, _U_XY = range(4)  # unknowns at a node

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


@BilinearForm
def _stiffness(u, v, w):
    a, b = np.asarray(dd(u)), np.asarray(dd(v))
    plate = (a[0, 0] + a[1, 1]) * (b[0, 0] + b[1, 1]) - (1 - w.nu) * (
        a[0, 0] * b[1, 1] + a[1, 1] * b[0, 0] - 2 * a[0, 1] * b[0, 1]
    )
    ribs = w.along_x * a[0, 0] * b[0, 0] + w.along_y * a[1, 1] * b[1, 1]
    return w.D * plate + ribs + w.twist * a[0, 1] * b[0, 1]


@LinearForm
def _pressure(v, w):
    return w.pressure * v


class Surface(NamedTuple):
    """A deflection and its slopes at the nodes of a rectangular grid: a row for each y."""

    x: Array  # m
    y: Array  # m
    unknowns: Array  # shape (4, rows, columns): u, u_x, u_y, u_xy; m, 1, 1, 1/m

    def at(self, x: Array, y: Array) -> Array:
        """Return the deflection, m, on another grid: a row for each y."""
        u, u_x, u_y, u_xy = self.unknowns
        along = CubicHermiteSpline(self.x, u, u_x, axis=1)(x)
        slope = CubicHermiteSpline(self.x, u_y, u_xy, axis=1)(x)
        return CubicHermiteSpline(self.y, along, slope, axis=0)(y)


class Plate:
    """A plate on its supports, ready to be loaded.

    Parameters
    ----------
    shape : Shape
        Plate, ribs, material, supports.
    load : Load
        Where forces act; their magnitudes are given later.
    cells : int
        Elements along the longer edge, at least.
    """

    def __init__(self, shape: Shape, load: Load, *, cells: int) -> None:
        self.shape = shape
        self._load = load
        along_x = rib(shape, shape.ribs_x, along=shape.length, across=shape.width)
        along_y = rib(shape, shape.ribs_y, along=shape.width, across=shape.length)
        step = max(shape.length, shape.width) / cells
        x = _lines(shape.length, step, _edges(load, 0), along_y, shape, shape.span_x)
        y = _lines(shape.width, step, _edges(load, 1), along_x, shape, shape.span_y)
        mesh = MeshQuad.init_tensor(x, y)
        self._basis = Basis(mesh, ElementQuadBFS(), intorder=6)
        self._nodes: Indices = np.asarray(self._basis.nodal_dofs)  # unknown, node
        self._x, self._y, self._places = x, y, np.asarray(mesh.p)
        self._middles: Array = self._places[:, mesh.t].mean(axis=1)
        stiffness = _stiffness.assemble(
            self._basis, nu=shape.nu, **self._rigidities(along_x, along_y)
        )
        free = np.setdiff1d(np.arange(self._basis.N), self._held())
        self._free = free
        self._factored = splu(csc_matrix(stiffness[free][:, free]))
        self._loads = np.array([self._unit(place) for place in load.places])
        self._answers = np.array([self._solved(each) for each in self._loads])

    @property
    def compliance(self) -> Array:
        """Return the deflection of mover j for a force on mover k, m/N, shape (4, 4)."""
        return self._loads @ self._answers.T

    def surface(self, forces: Array) -> Surface:
        """Return the deflection towards the stator under forces on the movers, N."""
        deflections = forces @ self._answers
        order = np.lexsort(self._places)  # rows of growing y, growing x within them
        nodes = self._nodes[:, order]
        shape = (4, len(self._y), len(self._x))
        return Surface(self._x, self._y, deflections[nodes].reshape(shape))

    def _rigidities(self, along_x: Rib, along_y: Rib) -> dict[str, Array]:
        """Return bending rigidities at each element's quadrature points, N m."""
        s = self.shape
        on_x, on_y = (
            np.isclose(self._middles[axis][:, None], each.places, rtol=0, atol=s.rib_width / 2)
            .any(axis=1)
            .astype(float)
            for axis, each in ((1, along_x), (0, along_y))
        )
        full, w = np.ones_like(self._basis.dx), s.rib_width
        twist = on_x * along_x.torsion / w + on_y * along_y.torsion / w
        return {
            "D": full * (s.E * s.thickness**3 / (12 * (1 - s.nu**2))),
            "along_x": full * (on_x * along_x.bending / w)[:, None],
            "along_y": full * (on_y * along_y.bending / w)[:, None],
            "twist": full * twist[:, None],
        }

    def _held(self) -> Indices:
        """Return the unknowns that the supports hold at 0."""
        s, (x, y), nodes = self.shape, self._places, self._nodes

        def at(coordinate: Array, place: float) -> NDArray[np.bool_]:
            return np.abs(np.abs(coordinate) - place) < _NEAR

        left_right, below_above = at(x, s.length / 2), at(y, s.width / 2)
        match s.support:
            case "carriages":
                held = [nodes[_U, at(x, s.span_x / 2) & at(y, s.span_y / 2)]]
            case "guides":
                held = [nodes[[_U, _U_X]][:, at(y, s.span_y / 2)]]
            case "edges":
                held = [nodes[[_U, _U_Y]][:, left_right], nodes[[_U, _U_X]][:, below_above]]
            case "clamped":
                held = [nodes[:, left_right | below_above]]
        return np.unique(np.concatenate([each.ravel() for each in held]))

    def _unit(self, place: tuple[float, float]) -> Array:
        """Return the load of 1 N at a place."""
        (x, y), load = place, self._load
        if load.length == 0:
            unit = np.zeros(self._basis.N)
            node = np.argmin(np.hypot(self._places[0] - x, self._places[1] - y))
            unit[self._nodes[_U, node]] = 1.0
            return unit
        away = np.abs(self._middles - np.array([[x], [y]]))
        within = (away[0] < load.length / 2) & (away[1] < load.width / 2)
        pressure = np.ones_like(self._basis.dx) * within[:, None] / (load.length * load.width)
        return _pressure.assemble(self._basis, pressure=pressure)

    def _solved(self, load: Array) -> Array:
        deflections = np.zeros(self._basis.N)
        deflections[self._free] = self._factored.solve(load[self._free])
        return deflections


def _edges(load: Load, axis: int) -> list[float]:
    """Return where footprints begin and end along an axis, or where points lie."""
    half = (load.length, load.width)[axis] / 2
    return [place[axis] + sign * half for place in load.places for sign in (-1, 1)]


def _lines(  # noqa: PLR0913, PLR0917 - everything that asks for a line
    size: float, step: float, loads: list[float], ribs: Rib, shape: Shape, span: float
) -> Array:
    """Return the lines of a mesh along one axis: where something begins, and between."""
    half = shape.rib_width / 2
    places = [-size / 2, 0.0, size / 2, *loads]
    places += [place + sign * half for place in ribs.places for sign in (-1, 1)]
    if shape.support in {"carriages", "guides"}:
        places += [-min(span, size) / 2, min(span, size) / 2]
    edges: list[float] = []
    for place in sorted(places):
        if not edges or place - edges[-1] > _NEAR:
            edges.append(place)
    parts = [
        np.linspace(a, b, max(1, int(np.ceil((b - a) / step - 1e-9))) + 1)[:-1]
        for a, b in pairwise(edges)
    ]
    return np.append(np.concatenate(parts), edges[-1])
