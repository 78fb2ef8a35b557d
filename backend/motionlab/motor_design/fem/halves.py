"""Finite elements on the two halves of a mesh, and how their unknowns meet in mid-gap."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from skfem import MeshTri

_NEAR = 1e-9  # of the mesh's length

Indices = NDArray[np.int64]


class HalfBasis:
    """Elements of one half, and which unknowns lie where.

    Parameters
    ----------
    mesh : MeshTri
        Between y = 0 and an outer edge on either side of it.
    order : int
        1 or 2.

    Attributes
    ----------
    line, left, right, outside : array of int
        Unknowns in mid-gap from left to right, without the last; those of the left and the right
        end, in the same order from mid-gap outwards; those on the outer edge.
    """

    def __init__(self, mesh: MeshTri, order: int) -> None:
        from skfem import Basis, ElementTriP1, ElementTriP2

        self.mesh = mesh
        self.basis = Basis(mesh, ElementTriP1() if order == 1 else ElementTriP2(), intorder=2)
        self.size = int(self.basis.N)
        x, y = self.basis.doflocs
        away = np.abs(y)
        near = _NEAR * (x.max() - x.min())
        line = np.flatnonzero(away < near)
        self.line: Indices = line[np.argsort(x[line])][:-1]
        left, right = np.flatnonzero(x < x.min() + near), np.flatnonzero(x > x.max() - near)
        self.left: Indices = left[np.argsort(away[left])]
        self.right: Indices = right[np.argsort(away[right])]
        self.outside: Indices = np.flatnonzero(away > away.max() - near)


def glued(lower: HalfBasis, upper: HalfBasis, shift: int) -> Indices:
    """Return the representative of each unknown, those of `lower` first.

    The right end is the left one, and the upper half's mid-gap line lies `shift` unknowns further
    on the lower one's.
    """
    owner = np.arange(lower.size + upper.size)
    owner[lower.right] = lower.left
    owner[upper.right + lower.size] = upper.left + lower.size
    owner[upper.line + lower.size] = np.roll(lower.line, -shift)
    owner[upper.right[0] + lower.size] = owner[upper.line[0] + lower.size]
    return owner
