"""Thrust of the plant per newton commanded: the gain of the loop."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.force_sharing.share import share_force
from motionlab.kernel.layout import Parameters, column, groups
from motionlab.lanes import WIDTH, Lanes, cached, compiled, pack, select, unpack
from motionlab.lanes.bank import TABLES
from motionlab.plant.current import Amplifiers
from motionlab.plant.magnetics import Phases
from motionlab.plant.table_map import thrust_of

Array = NDArray[np.float64]

_GAIN_AT = 0.5
"""Least force at which the loop's gain is taken, N: at zero force, offset currents dominate."""
_GAIN_STEP = 0.1
"""Half of the difference by which the gain is taken, as a share of the force."""
_BEYOND = 1e9
"""A force that no motor gives, N."""
_GAIN_POSITIONS = 144


class Force(NamedTuple):
    """A force of each lane, or a gain."""

    force: Lanes


@compiled
def force_gains(par: Parameters, tables: Array | None, forces: Array, gains: Array) -> None:
    """Write the plant's thrust per newton commanded, as a small-signal gain of the loop, 1.

    ``(T(f + d) - T(f - d))/(2 d)`` with T the mean over a pole pitch of the thrust that a command
    settles at, through sharing, amplifiers and the plant's map; the mean of both directions. Of two
    analytic maps of one knee, with ideal amplifiers, it does not depend on f.

    Parameters
    ----------
    par : Parameters
        Of lanes.
    tables : ndarray or None
        None where all maps are analytic and share by the closed form.
    forces : ndarray, shape (n, 1, lanes)
        Magnitude of the command about which the loop moves, N; at most half of the controller's
        largest force is used, since a linear loop has no limits.
    gains : ndarray, shape of `forces`
        Overwritten.
    """
    amplifiers, width = par.amplifiers, par.amplifiers.limit
    step = par.force_map.formula.tau * (1.0 / _GAIN_POSITIONS)
    reach, none = width * 0.0 + _BEYOND, width * 0.0
    # The largest forces come first: `share_force` stands in one place, as its code is long.
    for row in range(-1, forces.shape[0]):
        f = unpack(Force, forces[max(row, 0)], 0, width).force
        f = select(f < _GAIN_AT, _GAIN_AT, f)
        f = select(f > 0.5 * reach, 0.5 * reach, f)
        f = none + _BEYOND if row < 0 else f
        T = none
        for k in range(4 * _GAIN_POSITIONS):
            sense, more = 1.0 - 2.0 * (k % 2), 1.0 - 2.0 * (k // 2 % 2)
            position = step * (k // 4)
            command = f * (sense * (1.0 + more * _GAIN_STEP))
            share = share_force(par.force_model, tables, position, command)
            if row < 0:
                reach = select(abs(share.force) < reach, abs(share.force), reach)
                continue
            i = share.current
            current = Phases(
                amplifiers.gain_a * i.a + amplifiers.offset_a,
                amplifiers.gain_b * i.b + amplifiers.offset_b,
                amplifiers.gain_c * i.c + amplifiers.offset_c,
            )
            T = T + (sense * more) * thrust_of(par.force_map, tables, position, current)
        if row >= 0:
            pack(Force(T / ((4.0 * _GAIN_STEP * _GAIN_POSITIONS) * f)), gains[row])


def force_gain(par: Parameters, force: Array) -> Array:
    """Return the plant's thrust per newton commanded about forces, 1.

    Parameters
    ----------
    par : Parameters
        Of one lane, plain numbers.
    force : ndarray, shape (n,)
        Magnitudes, N, as `force_gains` takes them.
    """
    rows = -(-len(force) // WIDTH)
    forces = np.resize(force, (rows, 1, WIDTH)).astype(np.float64)
    gains = np.empty_like(forces)
    _gains(lanes_of(par), TABLES.values, forces, gains)
    return gains.ravel()[: len(force)]


def lanes_of(par: Parameters) -> Array:
    """Return the numbers of one lane in every lane of a vector, shape (PARAMETER_ROWS, WIDTH)."""
    return np.repeat(np.array(column(par))[:, None], WIDTH, axis=1)


@cached
def _gains(numbers: Array, tables: Array, forces: Array, gains: Array) -> None:
    width = unpack(Amplifiers, numbers, 0).limit
    force_gains(groups(numbers, width), tables, forces, gains)
