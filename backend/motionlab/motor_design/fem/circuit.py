"""A magnetic circuit of one phase: a fast, rough force map.

Across a gap two paths lie side by side: between the faces of teeth that overlap, whose tips
saturate, and beside them. Their permeances between ideal teeth come from finite elements over one
pitch, leakage from one coarse field. In series with both gaps lies iron with the air beside it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motionlab.motor_design.fem.field import FieldModel
from motionlab.motor_design.fem.gap_permeance import Cell
from motionlab.motor_design.fem.geometry import Geometry
from motionlab.motor_design.fem.mesh import Resolution
from motionlab.motor_design.fem.steel import MU_0, m19

_CELL = Resolution(24, 1)
_LEAKAGE = Resolution(18, 1)
_SMALL = 0.05  # of the largest current, where steel hardly matters
_NODES = 800
_FLUX_DENSITIES = np.concatenate([np.linspace(0.0, 2.3, 231), np.linspace(2.35, 12.0, 194)])
_NUDGE = 0.01  # of the gap, for the derivative over it

Array = NDArray[np.float64]


def circuit(geometry: Geometry, positions: Array, currents: Array) -> Array:
    """Return the map of a magnetic circuit.

    Parameters
    ----------
    geometry : Geometry
        Of one phase.
    positions : array
        x, m, evenly from 0 (aligned) to half a pitch.
    currents : array
        i, A, from 0.

    Returns
    -------
    array, shape (positions, currents, 4)
        Co-energy J, flux linkage Wb, thrust N, normal force N; forces are derivatives of the
        co-energy over x and over the gap.
    """
    from scipy.interpolate import CubicSpline

    g = geometry
    small = _SMALL * currents[-1]
    field = FieldModel(g, _LEAKAGE).at(_LEAKAGE.cells // 2).solve(small)
    ideal = _permeances(g, g.g, positions)
    alone = _coenergy(g, g.g, positions[-1:], ideal[-1:], np.array([0.0, small]), leakage=0.0)
    leakage = max(field.linkage - alone[0, 1, 1], 0.0) / (g.N**2 * small)
    here = _coenergy(g, g.g, positions, ideal, currents, leakage=leakage)
    wider = g.g * (1 + _NUDGE)
    wide = _coenergy(
        g, wider, positions, _permeances(g, wider, positions), currents, leakage=leakage
    )
    whole = np.concatenate([-positions[:0:-1], positions])
    even = np.concatenate([here[:0:-1, :, 0], here[:, :, 0]])
    even[-1] = even[0]
    thrust = CubicSpline(whole, even, bc_type="periodic")(positions, 1)
    normal = (here - wide)[:, :, 0] / (_NUDGE * g.g)
    return np.stack([here[:, :, 0], here[:, :, 1], thrust, normal], axis=-1)


def _permeances(g: Geometry, gap: float, positions: Array) -> Array:
    """Return the permeance of a pitch over mu_0 and stack length, 1, at x = `positions`, m."""
    from scipy.interpolate import CubicSpline

    cell = Cell(g.model_copy(update={"g": gap}), _CELL)
    half = [cell.permeance(shift) for shift in range(cell.per_pitch // 2 + 1)]
    x = np.linspace(-g.tau / 2, g.tau / 2, cell.per_pitch + 1)
    return CubicSpline(x, [*half[:0:-1], *half], bc_type="periodic")(positions)


def _coenergy(  # noqa: PLR0913 - the gap, and what lies around it
    g: Geometry, gap: float, positions: Array, ideal: Array, currents: Array, *, leakage: float
) -> Array:
    """Return co-energy and flux linkage for a gap of `gap`, m; `leakage` in H a turn squared."""
    from scipy.interpolate import CubicHermiteSpline

    mmf = g.N * currents
    across = np.linspace(0.0, 1.0, _NODES) ** 2 * mmf[-1] / 2  # fine where steel begins to matter
    result = np.empty((len(positions), len(currents), 2))
    for k, position in enumerate(positions):
        overlap = max(g.p - abs(position), 0.0)
        beside = g.n * MU_0 * g.gap_length * max(ideal[k] - overlap / gap, 0.0)
        flux = beside * across + _between_tips(g, gap, overlap, across)
        between_shoes = 2 * across + _iron(flux, _toothed_parts(g))
        flux = flux + leakage * between_shoes
        total = between_shoes + _iron(flux, _core_parts(g))
        area = np.diff(total) * (flux[1:] + flux[:-1]) / 2
        stored = np.concatenate([[0.0], np.cumsum(area)])
        result[k, :, 0] = CubicHermiteSpline(total, stored, flux)(mmf)
        result[k, :, 1] = g.N * np.interp(mmf, total, flux)
    return result


def _between_tips(g: Geometry, gap: float, overlap: float, across: Array) -> Array:
    """Return the flux, Wb, between faces that overlap by `overlap`, m, for each MMF across, A.

    In the iron it spreads at 45 degrees: over half of the length that does not overlap, m, its
    density is that of the gap.
    """
    if overlap <= 0:
        return np.zeros_like(across)
    face = g.n * overlap * g.l_m * g.stacking
    flux = np.linspace(0.0, 1.0, _NODES) * across[-1] * MU_0 * g.n * g.gap_length * overlap / gap
    crowded = (g.p - overlap) / 2
    drop = flux * gap / (MU_0 * g.n * g.gap_length * overlap)
    for share in (1.0, g.post):
        drop += crowded * m19().field(flux / (face * share))
    return np.interp(across, drop, flux)


def _toothed_parts(g: Geometry) -> list[tuple[float, float, float]]:
    """Return area of iron, of iron and air beside it, and length: teeth and stator."""
    iron, pitches = g.l_m * g.stacking, g.n * g.tau * g.l_m
    return [
        (g.n * g.p * iron * g.post, pitches, 2 * g.stator_tooth_depth),
        (g.n * g.p * iron, pitches, 2 * g.tooth_depth),
        (g.stator_back * iron, g.stator_back * g.l_m, g.n * g.tau),
    ]


def _core_parts(g: Geometry) -> list[tuple[float, float, float]]:
    """Return the same for shoes, limbs and yoke, which carry the leakage too."""
    iron = g.l_m * g.stacking
    return [
        (g.shoe_width * iron, g.shoe_width * g.l_m, g.shoe),
        (g.limb * iron, g.limb * g.l_m, g.shoe + 2 * g.window + g.yoke),
        (g.yoke * iron, g.yoke * g.l_m, g.width - g.limb),
    ]


def _iron(flux: Array, parts: list[tuple[float, float, float]]) -> Array:
    """Return the magnetomotive force, A, that parts in series take for a flux, Wb."""
    strengths = m19().field(_FLUX_DENSITIES)
    total = np.zeros_like(flux)
    for area, whole, length in parts:
        through = area * _FLUX_DENSITIES + MU_0 * (whole - area) * strengths
        above = (flux - through[-1]).clip(0) / (MU_0 * whole)
        total += length * (np.interp(flux, through, strengths) + above)
    return total
