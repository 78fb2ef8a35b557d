"""Thrust and normal force of three phases read off a table; in place of the analytic map.

A table holds a bicubic polynomial for each cell of position and current. The thrust is the
derivative of the co-energy's, ``dW'/dx``, so that energy is kept; the normal force has cells of
its own. Phase k = 0, 1, 2 (a, b, c) at position p stands at ``turns = (p + offset)/tau - k/3``, of
which the whole part does not matter; 1/2 is aligned. A current counts by its magnitude.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.lanes import Lanes, compiled, load_four, round_down, select
from motionlab.plant.magnetics import AnalyticMap, Phases, normal_force, thrust

Array = NDArray[np.float64]

THRUST_TERMS, NORMAL_TERMS = 12, 16
"""Numbers of a cell: quadratic or cubic in position, cubic in current."""

_HERMITE = np.array([[1, 0, 0, 0], [0, 0, 1, 0], [-3, 3, -2, -1], [2, -2, 1, 1]], dtype=float)
"""Powers of a place in its cell, from values and slopes at the cell's two ends."""


class TableMap(NamedTuple):
    """Where the table of each lane lies among all tables."""

    thrust: Lanes  # first number of its cells of thrust; -1: the lane has the analytic map
    normal: Lanes  # first number of its cells of normal force
    positions: Lanes  # cells in a pole pitch
    currents: Lanes  # cells from 0 A to the largest current
    per_ampere: Lanes  # cells in an ampere
    gain: Lanes  # factor on both forces, 1


class MotorMap(NamedTuple):
    """The force map of each lane: a formula, and the table that may take its place."""

    formula: AnalyticMap
    table: TableMap


ANALYTIC = TableMap(-1.0, -1.0, 1.0, 1.0, 1.0, 1.0)
"""A lane that has no table."""


@compiled
def cell(place: Lanes, cells: Lanes) -> tuple[Lanes, Lanes]:
    """Return the cell, from 0 to `cells` - 1, of a `place` counted in cells, and the place in it.

    A NaN is in cell 0, where nothing is read that is not there, and stays NaN in it.
    """
    index = round_down(place)
    index = select(index > 0.0, index, 0.0)
    index = select(index > cells - 1.0, cells - 1.0, index)
    return index, place - index


@compiled
def phase_turns(force_map: AnalyticMap, position: Lanes) -> Phases:
    """Return the position of each phase in its pole pitch at `position`, m; 0 to 1."""
    turns = (position + force_map.offset) * (1.0 / force_map.tau)
    b, c = turns - 1.0 / 3.0, turns - 2.0 / 3.0
    return Phases(turns - round_down(turns), b - round_down(b), c - round_down(c))


@compiled
def phase_thrust(table: TableMap, tables: Array, turns: Lanes, i: Lanes) -> Lanes:
    """Return the thrust of one phase, N, at `turns` with current `i`, A."""
    u, w, first = _place(table, table.thrust, turns, i, 12.0)
    p = _cubic(load_four(tables, first), w)
    q = _cubic(load_four(tables, first + 4.0), w)
    r = _cubic(load_four(tables, first + 8.0), w)
    return table.gain * (p + u * (q + u * r))


@compiled
def phase_normal(table: TableMap, tables: Array, turns: Lanes, i: Lanes) -> Lanes:
    """Return the normal force of one phase, N, at `turns` with current `i`, A."""
    u, w, first = _place(table, table.normal, turns, i, 16.0)
    p = _cubic(load_four(tables, first), w)
    q = _cubic(load_four(tables, first + 4.0), w)
    r = _cubic(load_four(tables, first + 8.0), w)
    s = _cubic(load_four(tables, first + 12.0), w)
    return table.gain * (p + u * (q + u * (r + u * s)))


@compiled
def thrust_of(motor_map: MotorMap, tables: Array | None, position: Lanes, current: Phases) -> Lanes:
    """Return the thrust of the three phases, N, by each lane's own kind of map.

    Without tables every lane's map is analytic.
    """
    table = motor_map.table
    analytic = thrust(motor_map.formula, position, current)
    if tables is None:
        return analytic
    turns = phase_turns(motor_map.formula, position)
    tabulated = (
        phase_thrust(table, tables, turns.a, current.a)
        + phase_thrust(table, tables, turns.b, current.b)
        + phase_thrust(table, tables, turns.c, current.c)
    )
    return select(table.thrust >= 0.0, tabulated, analytic)


@compiled
def normal_force_of(
    motor_map: MotorMap, tables: Array | None, position: Lanes, current: Phases
) -> Lanes:
    """Return the normal force of the three phases, N, by each lane's own kind of map."""
    table = motor_map.table
    analytic = normal_force(motor_map.formula, position, current)
    if tables is None:
        return analytic
    turns = phase_turns(motor_map.formula, position)
    tabulated = (
        phase_normal(table, tables, turns.a, current.a)
        + phase_normal(table, tables, turns.b, current.b)
        + phase_normal(table, tables, turns.c, current.c)
    )
    return select(table.thrust >= 0.0, tabulated, analytic)


@compiled
def _place(
    table: TableMap, base: Lanes, turns: Lanes, i: Lanes, terms: float
) -> tuple[Lanes, Lanes, Lanes]:
    """Return the place in its cell along position and current, and the cell's first number."""
    column, u = cell(turns * table.positions, table.positions)
    row, w = cell(abs(i) * table.per_ampere, table.currents)
    first = select(base > 0.0, base, 0.0) + terms * (column * table.currents + row)
    return u, w, first


@compiled
def _cubic(terms: tuple[Lanes, Lanes, Lanes, Lanes], w: Lanes) -> Lanes:
    a, b, c, d = terms
    return a + w * (b + w * (c + w * d))


def thrust_cells(hermite: Array, dx: float, di: float) -> Array:
    """Return the cells of dW'/dx.

    Parameters
    ----------
    hermite : ndarray, shape (4, positions + 1, currents + 1)
        ``W', dW'/dx, dW'/di, d2W'/dx di`` at the nodes; J, N, Wb, Wb/m.
    dx, di : float
        Size of a cell, m and A.

    Returns
    -------
    ndarray, shape (positions, currents, THRUST_TERMS)
        Coefficients of ``u**m w**n``, N, m = 0..2 slowest; u and w run from 0 to 1 in the cell.
    """
    powers = _polynomials(hermite, dx, di)
    slopes = powers[:, :, 1:, :] * (np.arange(1.0, 4.0) / dx)[:, None]
    return slopes.reshape(*slopes.shape[:2], THRUST_TERMS)


def normal_cells(hermite: Array, dx: float, di: float) -> Array:
    """Return the cells of a table itself, shape (positions, currents, NORMAL_TERMS)."""
    powers = _polynomials(hermite, dx, di)
    return powers.reshape(*powers.shape[:2], NORMAL_TERMS)


def _polynomials(hermite: Array, dx: float, di: float) -> Array:
    """Return the coefficients of ``u**m w**n`` of each cell, shape (positions, currents, 4, 4)."""
    value, slope_x, slope_i, twist = hermite * np.array([1.0, dx, di, dx * di])[:, None, None]

    def ends(of_value: Array, of_slope: Array) -> list[Array]:
        """Return value and slope at both ends along the current, for both ends of position."""
        return [
            corner
            for quantity in (of_value, of_slope)
            for corner in (quantity[:, :-1], quantity[:, 1:])
        ]

    along = [np.stack(ends(v, s), axis=-1) for v, s in ((value, slope_i), (slope_x, twist))]
    corners = np.stack([along[0][:-1], along[0][1:], along[1][:-1], along[1][1:]], axis=-2)
    return _HERMITE @ corners @ _HERMITE.T
