"""Tables of a controller: the inverse of a force map, and its shares of least copper loss."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from motionlab.lanes import Lanes, compiled, load_four

Array = NDArray[np.float64]
Thrust = Callable[[Array, Array], Array]
"""Thrust of one phase, N, over turns of its pole pitch, 1, and current, A; arrays broadcast."""

INVERSE_POSITIONS, INVERSE_LEVELS = 288, 64
"""Cells of the inverse of a table: along a pole pitch, and along sqrt(thrust/largest thrust)."""

INVERSE_CELLS = (INVERSE_POSITIONS, INVERSE_LEVELS, 4)
"""Shape of `inverse_cells`."""

SHARE_POSITIONS, SHARE_LEVELS = 240, 32
"""Cells of the shares of least copper loss: along a pole pitch, and along force/largest force."""

_CURRENTS = 401
_NUDGE = 1e-3 / INVERSE_POSITIONS
_NO_THRUST = 1e-6
"""Share of the largest thrust below which a position counts as one without thrust."""
_SPLITS = 65
_NO_FORCE = 1e-12
"""In place of the force where no phase pulls in the commanded direction, N."""

_LEAST_LEVEL = 1e-3


@compiled
def between(tables: Array, first: Lanes, u: Lanes, w: Lanes) -> Lanes:
    """Return a number of the cell that begins at `first`, at u and w between its corners."""
    low, low_next, high, high_next = load_four(tables, first)
    near = low + w * (low_next - low)
    return near + u * (high + w * (high_next - high) - near)


def inverse_cells(thrust: Thrust, i_max: float) -> Array:
    """Return the current over position and thrust.

    Parameters
    ----------
    thrust : callable
        Of one phase.
    i_max : float
        Largest current, A.

    Returns
    -------
    ndarray, shape (INVERSE_POSITIONS, INVERSE_LEVELS, 4)
        Currents at the corners of each cell, A: at this position and level, at the next level, and
        both at the next position. Level g is ``sqrt(F/F(i_max))``. It is the least current that
        gives the thrust.
    """
    turns = np.arange(INVERSE_POSITIONS) / INVERSE_POSITIONS
    levels = np.arange(INVERSE_LEVELS + 1) / INVERSE_LEVELS
    return _corners(_currents(thrust, i_max, turns, levels))


def share_cells(thrust: Thrust, i_max: float) -> Array:
    """Return the share of a phase in a force that is given with least copper loss.

    At each position the two phases that pull most in the commanded direction share the force; the
    third gives none, as it cannot in a motor whose teeth are symmetric.

    Parameters
    ----------
    thrust : callable
        Of one phase.
    i_max : float
        Largest current, A.

    Returns
    -------
    ndarray, shape (2, SHARE_POSITIONS, SHARE_LEVELS, 4)
        Shares at the corners of each cell, as `inverse_cells`, of positive forces, then of
        negative ones. Level v is the force over what all phases can give at `i_max`.
    """
    third = SHARE_POSITIONS // 3
    nodes = np.arange(third) / SHARE_POSITIONS
    turns = np.mod(nodes - np.arange(3.0)[:, None] / 3.0, 1.0)
    sheets = []
    for sense in (1.0, -1.0):
        most = np.maximum(sense * thrust(turns, np.array(i_max)), 0.0)
        shares = np.zeros((3, third, SHARE_LEVELS + 1))
        order = np.argsort(-most, axis=0)
        at = np.arange(third)
        strong, second = order[0], order[1]
        part = _best_split(
            thrust,
            i_max,
            (turns[strong, at], most[strong, at]),
            (turns[second, at], most[second, at]),
        )
        shares[strong, at] = part
        shares[second, at] = 1.0 - part
        # Phase k at these positions is where phase a is a third of a pitch before.
        sheets.append(_corners(np.concatenate([shares[0], shares[2], shares[1]])))
    return np.stack(sheets)


def _best_split(
    thrust: Thrust, i_max: float, first: tuple[Array, Array], second: tuple[Array, Array]
) -> Array:
    """Return the share of the first of two phases for each position and level of force."""
    fine = np.linspace(0.0, 1.0, 4 * INVERSE_LEVELS + 1)
    tables = [_currents(thrust, i_max, turns, fine) for turns, _ in (first, second)]
    total = (first[1] + second[1])[:, None]
    levels = np.maximum(np.arange(SHARE_LEVELS + 1) / SHARE_LEVELS, _LEAST_LEVEL)
    force = np.maximum(levels * total, _NO_FORCE)
    least = np.maximum(1.0 - second[1][:, None] / force, 0.0)
    most = np.minimum(first[1][:, None] / force, 1.0)

    def loss(part: Array) -> Array:
        """Return the sum of squared currents; `part` has the splits along its last axis."""
        squares = 0.0
        for table, (_, limit), share in zip(
            tables, (first, second), (part, 1.0 - part), strict=True
        ):
            strength = np.maximum(limit, 1e-12)[:, None, None]
            level = np.sqrt(np.clip(share * force[..., None] / strength, 0.0, 1.0))
            place = level * (len(fine) - 1)
            cell = np.minimum(place.astype(np.int64), len(fine) - 2)
            row = np.arange(len(table))[:, None, None]
            low, high = table[row, cell], table[row, cell + 1]
            squares = squares + (low + (place - cell) * (high - low)) ** 2
        return np.asarray(squares)

    low, high = least, most
    part = least
    for _ in range(2):
        steps = np.linspace(0.0, 1.0, _SPLITS)
        tried = low[..., None] + (high - low)[..., None] * steps
        best = loss(tried).argmin(axis=-1)[..., None]
        part = np.take_along_axis(tried, best, axis=-1)[..., 0]
        width = (high - low) / (_SPLITS - 1)
        low, high = np.maximum(part - width, least), np.minimum(part + width, most)
    return part


def _currents(thrust: Thrust, i_max: float, turns: Array, levels: Array) -> Array:
    """Return the least current that gives each level of thrust, shape (turns, levels)."""
    i = np.linspace(0.0, i_max, _CURRENTS)
    curves = np.abs(thrust(turns[:, None], i))
    strength = curves[:, -1].max()
    dead = curves[:, -1] < _NO_THRUST * strength
    if dead.any():  # where no current gives thrust, the neighbours' curves have a common limit
        beside = [np.abs(thrust((turns[dead] + s)[:, None], i)) for s in (-_NUDGE, _NUDGE)]
        curves[dead] = 0.5 * (beside[0] + beside[1])
    curves = np.maximum.accumulate(curves, axis=1)
    thrusts = levels**2
    return np.array([np.interp(thrusts, curve / curve[-1], i) for curve in curves])


def _corners(nodes: Array) -> Array:
    """Return the corners of each cell of a periodic table, shape (positions, levels, 4)."""
    beside = np.roll(nodes, -1, axis=0)
    return np.stack([nodes[:, :-1], nodes[:, 1:], beside[:, :-1], beside[:, 1:]], axis=-1)
