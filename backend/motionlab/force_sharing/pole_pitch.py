"""Force sharing on arrays: what the kernel does, over many positions at once."""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np
from numpy.typing import ArrayLike, NDArray

from motionlab.force_sharing.functions import LEAST_NORM, Sharing, share_by_law
from motionlab.force_sharing.least_norm import share_force
from motionlab.lanes import WIDTH, Lanes, pack, select, unpack
from motionlab.lanes.bank import TABLES
from motionlab.plant.magnetics import ForceMap, Phases
from motionlab.plant.table_map import TableMap, normal_force_of, thrust_of

Array = NDArray[np.float64]


class Shared(NamedTuple):
    """What sharing gives at each of n positions."""

    current: Array  # current commands, A, shape (3, n)
    force: Array  # force that they give on the controller's map, N, shape (n,)
    limited: NDArray[np.bool_]  # the current limit keeps the force from what was asked, shape (n,)


class Forces(NamedTuple):
    """What currents give at each of n positions."""

    thrust: Array  # N, shape (n,)
    normal: Array  # N, shape (n,)


class _Asked(NamedTuple):
    current_limit: Lanes
    position: Lanes
    force: Lanes


class _Answer(NamedTuple):
    a: Lanes
    b: Lanes
    c: Lanes
    force: Lanes
    limited: Lanes


class _At(NamedTuple):
    position: Lanes
    a: Lanes
    b: Lanes
    c: Lanes


class _Sum(NamedTuple):
    thrust: Lanes
    normal: Lanes


_MAP, _TABLE = len(ForceMap._fields), len(TableMap._fields)


def share_over(  # noqa: PLR0913 - map, law and limit
    force_map: ForceMap,
    table: TableMap,
    sharing: Sharing,
    *,
    current_limit: float,
    position: ArrayLike,
    force: ArrayLike,
) -> Shared:
    """Share forces among the phases at many positions.

    Parameters
    ----------
    force_map, table, sharing
        Of the controller, plain numbers; the table lies in `motionlab.lanes.bank.TABLES`.
    current_limit : float
        Largest current command, A.
    position : array_like, shape (n,)
        Measured positions, m.
    force : array_like, shape (n,) or ()
        Commanded forces, N.

    Returns
    -------
    Shared
        To the last bit what the kernel commands where it stands at that position.
    """
    place, wanted = np.broadcast_arrays(np.asarray(position, dtype=float), force)
    asked = _blocks(np.full(place.shape, current_limit), place, wanted)
    answers = np.empty((len(asked), len(_Answer._fields), WIDTH))
    tabled = table.thrust >= 0.0 or sharing.law != LEAST_NORM
    _share(_rows(*force_map, *table, *sharing), asked, answers, TABLES.values if tabled else None)
    flat = _columns(answers, place.size)
    return Shared(flat[:3], flat[3], flat[4] > 0.0)


def forces_over(
    force_map: ForceMap, table: TableMap, *, position: ArrayLike, current: ArrayLike
) -> Forces:
    """Return thrust and normal force at many positions.

    Parameters
    ----------
    force_map, table
        Of the plant or the controller, plain numbers.
    position : array_like, shape (n,)
        Positions, m.
    current : array_like, shape (3, n)
        Phase currents, A.
    """
    place = np.asarray(position, dtype=float)
    at = _blocks(place, *np.asarray(current, dtype=float))
    sums = np.empty((len(at), len(_Sum._fields), WIDTH))
    tables = TABLES.values if table.thrust >= 0.0 else None
    _forces(_rows(*force_map, *table), at, sums, tables)
    return Forces(*_columns(sums, place.size))


def _rows(*values: float) -> Array:
    return np.repeat(np.array(values, dtype=np.float64)[:, None], WIDTH, axis=1)


def _blocks(*columns: Array) -> Array:
    """Return columns of n values as blocks of lanes, shape (blocks, columns, WIDTH)."""
    values = np.array(columns, dtype=np.float64)
    spare = -values.shape[1] % WIDTH
    values = np.concatenate([values, np.repeat(values[:, -1:], spare, axis=1)], axis=1)
    return np.ascontiguousarray(values.reshape(len(values), -1, WIDTH).transpose(1, 0, 2))


def _columns(blocks: Array, count: int) -> Array:
    return blocks.transpose(1, 0, 2).reshape(blocks.shape[1], -1)[:, :count]


@numba.njit(error_model="numpy", nogil=True, cache=True)
def _share(model: Array, asked: Array, answers: Array, tables: Array | None) -> None:
    force_map = unpack(ForceMap, model, 0)
    table = unpack(TableMap, model, _MAP)
    sharing = unpack(Sharing, model, _MAP + _TABLE)
    for k in range(asked.shape[0]):
        q = unpack(_Asked, asked[k], 0)
        if tables is None:
            share = share_force(force_map, q.current_limit, q.position, q.force)
        else:
            share = share_by_law(
                force_map, table, sharing, tables, q.current_limit, q.position, q.force
            )
        i = share.current
        answer = _Answer(i.a, i.b, i.c, share.force, select(share.limited, 1.0, 0.0))
        pack(answer, answers[k])


@numba.njit(error_model="numpy", nogil=True, cache=True)
def _forces(model: Array, at: Array, sums: Array, tables: Array | None) -> None:
    force_map = unpack(ForceMap, model, 0)
    table = unpack(TableMap, model, _MAP)
    for k in range(at.shape[0]):
        q = unpack(_At, at[k], 0)
        current = Phases(q.a, q.b, q.c)
        thrust = thrust_of(force_map, table, tables, q.position, current)
        pack(_Sum(thrust, normal_force_of(force_map, table, tables, q.position, current)), sums[k])
