"""The gap over one pitch between ideal iron: its permeance, which Carter's closed form checks."""

from __future__ import annotations

import numpy as np

from motionlab.motor_design.fem.geometry import Geometry
from motionlab.motor_design.fem.halves import HalfBasis, Indices, glued
from motionlab.motor_design.fem.mesh import Columns, Resolution, centroids, in_tooth, stack, toothed


class Cell:
    """One tooth over one tooth, repeated for ever, both of iron without reluctance.

    Parameters
    ----------
    geometry : Geometry
        Pitch, teeth, gap and depths of teeth.
    resolution : Resolution
        Mesh and order of the elements.
    smooth_stator : bool
        Whether the stator has no slots.
    """

    def __init__(
        self, geometry: Geometry, resolution: Resolution, *, smooth_stator: bool = False
    ) -> None:
        from scipy.sparse import block_diag
        from skfem import BilinearForm

        g = geometry
        columns = Columns(g, resolution, pitches=1)
        self.per_pitch = columns.per_pitch
        self._order = resolution.order
        below = toothed(g, columns, g.stator_tooth_depth)
        if smooth_stator:
            below = [line for line in below if line.y < g.g / 2 * (1 + 1e-9)]
        self._lower = HalfBasis(stack([line._replace(y=-line.y) for line in below]), self._order)
        self._upper = HalfBasis(stack(toothed(g, columns, g.tooth_depth)), self._order)
        halves = self._lower, self._upper
        self._iron = [_iron(half, g) for half in halves]
        laplace = BilinearForm(lambda u, v, _: (u.grad * v.grad).sum(axis=0))
        self._stiffness = block_diag([laplace.assemble(half.basis) for half in halves]).tocsr()

    def permeance(self, shift: int) -> float:
        """Return permeance over mu_0 and stack length at ``x = shift tau/per_pitch``, 1.

        Twice the energy of the scalar potential that is 0 on the stator and 1 on the mover.
        """
        from scipy.sparse import csr_matrix
        from scipy.sparse.linalg import spsolve

        owner = glued(self._lower, self._upper, shift * self._order)
        total = len(owner)
        boundary, fixed = np.zeros(total), np.zeros(total, dtype=bool)
        boundary[self._iron[1] + self._lower.size] = 1.0
        fixed[self._iron[0]] = fixed[self._iron[1] + self._lower.size] = True
        free = np.flatnonzero((owner == np.arange(total)) & ~fixed)
        number = np.full(total, -1)
        number[free] = np.arange(len(free))
        number = np.where(fixed, -1, number[owner])
        rows = np.flatnonzero(number >= 0)
        share = csr_matrix((np.ones(len(rows)), (rows, number[rows])), shape=(total, len(free)))
        matrix = (share.T @ self._stiffness @ share).tocsc()
        solution = spsolve(matrix, -share.T @ (self._stiffness @ boundary))
        potential = boundary + share @ solution
        return float(potential @ (self._stiffness @ potential))


def _iron(half: HalfBasis, geometry: Geometry) -> Indices:
    """Return the unknowns of the teeth and of the iron behind them."""
    x, y = centroids(half.mesh)
    solid = (np.abs(y) > geometry.g / 2) & in_tooth(geometry, x)
    return np.union1d(half.basis.element_dofs[:, solid], half.outside)
