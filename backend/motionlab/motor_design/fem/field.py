"""The nonlinear magnetostatic field of one phase, and force, flux linkage and co-energy from it.

The unknown is the flux phi (Wb) between a point and the outer boundary, so that ``B = abs(grad
phi)/d`` with the depth d of each material. The field minimizes ``J = int d w(B) dA - i int t phi
dA`` with the energy density w and the turns per area t; its minimum is minus the co-energy W'.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.errors import MotionLabError
from motionlab.motor_design.fem import mesh as meshes
from motionlab.motor_design.fem.geometry import Geometry
from motionlab.motor_design.fem.halves import HalfBasis, Indices, glued
from motionlab.motor_design.fem.mesh import Columns, Resolution
from motionlab.motor_design.fem.steel import MU_0, Steel, m19

_STEPS_MOST = 60
_HALVINGS_MOST = 30
_TOLERANCE = 1e-9  # of the energy that the last Newton step still gained
_ARMIJO = 1e-4
_B_LEAST = 1e-9  # T

Array = NDArray[np.float64]


class NoConvergence(MotionLabError):
    """Newton's method has not converged to the field of a geometry."""


class Solution(NamedTuple):
    """Results of one field, for one phase."""

    coenergy: float  # J
    linkage: float  # Wb
    thrust: float  # N, positive towards growing x
    normal_force: float  # N, positive where mover and stator attract each other


class FieldModel:
    """The field of a geometry at any position on the mesh and any current.

    Parameters
    ----------
    geometry : Geometry
        Cross-section, turns and depth.
    resolution : Resolution
        Mesh and order of the elements.
    steel : Steel, optional
        Magnetization curve; M-19 when left out.
    """

    def __init__(
        self, geometry: Geometry, resolution: Resolution, steel: Steel | None = None
    ) -> None:
        columns = Columns(geometry, resolution)
        stator, mover = meshes.stator(geometry, columns), meshes.mover(geometry, columns)
        self.geometry = geometry
        self.steel = steel or m19()
        self.cells_per_pitch = columns.per_pitch
        self._order = resolution.order
        self._lower = HalfBasis(stator.mesh, resolution.order)
        self._upper = HalfBasis(mover.mesh, resolution.order)
        self.length = columns.length
        self.corners = np.concatenate(  # x or y, corner, triangle; the stator's first
            [half.mesh.p[:, half.mesh.t] for half in (stator, mover)], axis=2
        )
        self.stator_triangles = stator.mesh.nelements
        halves = [half.basis for half in (self._lower, self._upper)]
        # gradients: unknown, x or y, triangle, point
        self.gradients = np.concatenate(
            [np.array([f[0].grad for f in basis.basis]) for basis in halves], axis=2
        )
        self.weights = np.concatenate([basis.dx for basis in halves])
        self.dofs = np.concatenate(
            [halves[0].element_dofs, halves[1].element_dofs + self._lower.size], axis=1
        )
        region = np.concatenate([stator.region, mover.region])
        g = geometry
        iron = g.l_m * g.stacking
        self.depth = np.array([g.gap_length, iron, iron * g.post, g.l_m, g.l_m, g.l_m])[region]
        self.iron = np.flatnonzero(np.isin(region, [meshes.IRON, meshes.STATOR_TEETH]))
        self.gap = np.flatnonzero(region == meshes.GAP)
        self.turns = self._turns(region)
        scale = self.weights / (MU_0 * self.depth[:, None])
        self.air_stiffness = _products(self.gradients, scale)

    def at(self, shift: int) -> FieldSystem:
        """Return the field at ``x = shift tau/cells_per_pitch``; 0 is the aligned position."""
        owner = glued(self._lower, self._upper, shift * self._order)
        free = np.ones(len(owner), dtype=bool)
        free[self._lower.outside] = False
        free[self._upper.outside + self._lower.size] = False
        standing = np.flatnonzero((owner == np.arange(len(owner))) & free)
        number = np.full(len(owner), -1)
        number[standing] = np.arange(len(standing))
        return FieldSystem(self, number[owner][self.dofs], owner[self.dofs])

    def _turns(self, region: Indices) -> Array:
        """Return the integral of turns per area times each triangle's functions."""
        halves = [half.basis for half in (self._lower, self._upper)]
        values = np.concatenate(
            [
                np.array([np.broadcast_to(np.asarray(f[0]), basis.dx.shape) for f in basis.basis])
                for basis in halves
            ],
            axis=1,
        )
        area = self.weights.sum(axis=1)
        density = np.zeros(len(region))
        for side, sign in ((meshes.COIL_IN, 1.0), (meshes.COIL_OUT, -1.0)):
            density[region == side] = sign * self.geometry.N / area[region == side].sum()
        return np.einsum("aeq,eq,e->ae", values, self.weights, density)


class FieldSystem:
    """System of equations at one position; each current starts from the fields of the last ones."""

    def __init__(self, model: FieldModel, dofs: Indices, nodes: Indices) -> None:
        self._model = model
        self._dofs = dofs  # -1 on the outer boundary, where phi is 0
        self.nodes = nodes  # what stands for each triangle's unknowns, also on the boundary
        self._count = int(dofs.max()) + 1
        shape = (len(dofs), *dofs.shape)
        rows = np.broadcast_to(dofs[:, None, :], shape)
        columns = np.broadcast_to(dofs[None, :, :], shape)
        self._kept = (rows >= 0) & (columns >= 0)
        keys = columns[self._kept] * np.int64(self._count) + rows[self._kept]
        unique, self._slot = np.unique(keys, return_inverse=True)
        self._rows = (unique % self._count).astype(np.int32)
        starts = np.searchsorted(unique // self._count, np.arange(self._count + 1))
        self._starts = starts.astype(np.int32)
        used = dofs >= 0
        self._load = np.bincount(dofs[used], model.turns[used], minlength=self._count)
        self._past: list[tuple[float, Array]] = [(0.0, np.zeros(self._count))]

    def solve(self, current: float) -> Solution:
        """Return forces, flux linkage and co-energy at `current`, A.

        Newton's method with a line search on J, from the fields at the last two currents.

        Raises
        ------
        NoConvergence
            If the field is not found.
        """
        phi = self._extrapolated(current)
        energy, residual, stiffness = self._system(phi, current)
        for _ in range(_STEPS_MOST):
            step = -self._factored(stiffness).solve(residual)
            gain = float(residual @ step)
            for _ in range(_HALVINGS_MOST):
                trial_energy = self._energy(phi + step) - current * float(self._load @ (phi + step))
                if trial_energy <= energy + _ARMIJO * gain + 1e-12 * abs(energy):
                    break
                step, gain = 0.5 * step, 0.5 * gain
            phi = phi + step
            energy, residual, stiffness = self._system(phi, current)
            if -gain <= _TOLERANCE * abs(energy):
                self._past = [*self._past[-1:], (current, phi)]
                return self._solution(phi, energy)
        raise NoConvergence(
            f"the field at {current:g} A was not found in {_STEPS_MOST} Newton steps"
        )

    def triangles(self) -> tuple[Array, Array]:
        """Return flux at the corners of triangles, Wb, and mean flux density, T, last found."""
        phi = self._past[-1][1]
        at_corners = np.append(phi, 0.0)[self._dofs[:3]]
        return at_corners, self._flux_density(self._gradient(phi)).mean(axis=1)

    def _extrapolated(self, current: float) -> Array:
        (i_1, phi_1) = self._past[-1]
        if len(self._past) < 2:
            return phi_1.copy()
        i_0, phi_0 = self._past[0]
        return phi_1 + (phi_1 - phi_0) * ((current - i_1) / (i_1 - i_0))

    def _gradient(self, phi: Array) -> Array:
        """Return grad phi at each point: xy, triangle, point."""
        local = np.append(phi, 0.0)[self._dofs]
        return np.einsum("ae,axeq->xeq", local, self._model.gradients)

    def _energy(self, phi: Array) -> float:
        b = self._flux_density(self._gradient(phi))
        density = 0.5 * b * b / MU_0
        iron = self._model.iron
        density[iron] = self._model.steel.energy(b[iron])
        return float(np.sum(self._model.weights * self._model.depth[:, None] * density))

    def _flux_density(self, gradient: Array) -> Array:
        return np.hypot(gradient[0], gradient[1]) / self._model.depth[:, None]

    def _system(self, phi: Array, current: float) -> tuple[float, Array, Array]:
        """Return J, its derivative, and the entries of its second derivative."""
        m, iron = self._model, self._model.iron
        gradient = self._gradient(phi)
        b = self._flux_density(gradient)
        nu = np.full(b.shape, 1 / MU_0)
        nu[iron], slope = m.steel.reluctivity(b[iron])
        depth = m.depth[:, None]
        force = m.weights * nu / depth * gradient
        local = np.einsum("axeq,xeq->ae", m.gradients, force)
        used = self._dofs >= 0
        residual = np.bincount(self._dofs[used], local[used], minlength=self._count)
        residual -= current * self._load
        shapes = m.gradients[:, :, iron]
        scale = m.weights[iron] / depth[iron]
        along = np.einsum("axeq,xeq->aeq", shapes, gradient[:, iron])[:, None]
        bend = scale * slope / (np.maximum(b[iron], _B_LEAST) * depth[iron] ** 2)
        entries = m.air_stiffness.copy()
        entries[:, :, iron] = _products(shapes, scale * nu[iron]) + _products(along, bend)
        energy = self._energy(phi) - current * float(self._load @ phi)
        return energy, residual, entries

    def _factored(self, entries: Array):
        from scipy.sparse import csc_matrix
        from scipy.sparse.linalg import splu

        data = np.bincount(self._slot, entries[self._kept], minlength=len(self._rows))
        matrix = csc_matrix((data, self._rows, self._starts), shape=(self._count, self._count))
        return splu(
            matrix,
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )

    def _solution(self, phi: Array, energy: float) -> Solution:
        m = self._model
        d_x, d_y = self._gradient(phi)[:, m.gap]
        area = m.weights[m.gap] / m.depth[m.gap][:, None] / (MU_0 * m.geometry.g)
        thrust = float(np.sum(area * d_x * d_y))  # -B_x B_y/mu_0
        normal = 0.5 * float(np.sum(area * (d_x**2 - d_y**2)))
        return Solution(-energy, float(self._load @ phi), thrust, normal)


def _products(vectors: Array, scale: Array) -> Array:
    """Return the integrals of products of functions' vectors: unknown, unknown, triangle."""
    return np.einsum("axeq,bxeq,eq->abe", vectors, vectors, scale, optimize=True)
