"""Vectorised force sharing over many positions, as in the kernel."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from motionlab.force_sharing.functions import CLOSED_FORM, SharingParameters
from motionlab.force_sharing.share import ForceModel, Sharing, share_force
from motionlab.lanes import WIDTH, Lanes, cached, compiled, pack, select, unpack
from motionlab.lanes.bank import TABLES
from motionlab.plant.magnetics import AnalyticMap, Phases
from motionlab.plant.table_map import MotorMap, TableMap, normal_force_of, thrust_of

Array = NDArray[np.float64]


class Shared(NamedTuple):
    """Results of force sharing at each of n positions."""

    current: Array  # current commands, A, shape (3, n)
    force: Array  # force that they give on the controller's map, N, shape (n,)
    limited: NDArray[np.bool_]  # the current limit reduces the force, shape (n,)


class Forces(NamedTuple):
    """Forces of given currents at each of n positions."""

    thrust: Array  # N, shape (n,)
    normal: Array  # N, shape (n,)


class _Query(NamedTuple):
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


_MAP, _TABLE = len(AnalyticMap._fields), len(TableMap._fields)
_OWN = _MAP + _TABLE + len(Sharing._fields)


def share_over(model: ForceModel, *, position: ArrayLike, force: ArrayLike) -> Shared:
    """Share forces among the phases at many positions.

    Parameters
    ----------
    model : ForceModel
        Of the controller, plain numbers; tables lie in `motionlab.lanes.bank.TABLES`.
    position : array_like, shape (n,)
        Measured positions, m.
    force : array_like, shape (n,) or ()
        Commanded forces, N.

    Returns
    -------
    Shared
        Bit-identical to the kernel's commands at these positions.
    """
    place, command = np.broadcast_arrays(np.asarray(position, dtype=float), force)
    queries = _blocks(place, command)
    answers = np.empty((len(queries), len(_Answer._fields), WIDTH))
    tabled = model.map.table.thrust >= 0.0 or model.sharing.law != CLOSED_FORM
    rows = _rows(*model.map.formula, *model.map.table, *model.sharing, *model.parameters)
    _share(rows, queries, answers, TABLES.values if tabled else None)
    flat = _columns(answers, place.size)
    return Shared(flat[:3], flat[3], flat[4] > 0.0)


def forces_over(motor_map: MotorMap, *, position: ArrayLike, current: ArrayLike) -> Forces:
    """Return thrust and normal force at many positions.

    Parameters
    ----------
    motor_map : MotorMap
        Of the plant or the controller, plain numbers.
    position : array_like, shape (n,)
        Positions, m.
    current : array_like, shape (3, n)
        Phase currents, A.
    """
    place = np.asarray(position, dtype=float)
    at = _blocks(place, *np.asarray(current, dtype=float))
    sums = np.empty((len(at), len(_Sum._fields), WIDTH))
    tables = TABLES.values if motor_map.table.thrust >= 0.0 else None
    _forces(_rows(*motor_map.formula, *motor_map.table), at, sums, tables)
    return Forces(*_columns(sums, place.size))


def forces_of_phases(
    motor_map: MotorMap, *, position: ArrayLike, current: ArrayLike
) -> tuple[Array, Array]:
    """Return thrust and normal force of each phase alone; the map has no coupling between phases.

    Parameters
    ----------
    motor_map : MotorMap
        Of the plant or the controller, plain numbers.
    position : array_like, shape (n,)
        Positions, m.
    current : array_like, shape (n, 3)
        Phase currents, A.

    Returns
    -------
    thrust, normal : ndarray, shape (n, 3)
        N; their sums over the phases are those of `forces_over`.
    """
    place = np.repeat(np.asarray(position, dtype=float), 3)
    alone = np.asarray(current, dtype=float)[:, :, None] * np.eye(3)
    forces = forces_over(motor_map, position=place, current=alone.reshape(-1, 3).T)
    return forces.thrust.reshape(-1, 3), forces.normal.reshape(-1, 3)


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


@compiled
def _map(rows: Array) -> MotorMap:
    return MotorMap(unpack(AnalyticMap, rows, 0), unpack(TableMap, rows, _MAP))


@cached
def _share(rows: Array, queries: Array, answers: Array, tables: Array | None) -> None:
    model = ForceModel(
        _map(rows), unpack(Sharing, rows, _MAP + _TABLE), unpack(SharingParameters, rows, _OWN)
    )
    for k in range(queries.shape[0]):
        q = unpack(_Query, queries[k], 0)
        share = share_force(model, tables, q.position, q.force)
        i = share.current
        answer = _Answer(i.a, i.b, i.c, share.force, select(share.limited, 1.0, 0.0))
        pack(answer, answers[k])


@cached
def _forces(rows: Array, at: Array, sums: Array, tables: Array | None) -> None:
    motor_map = _map(rows)
    for k in range(at.shape[0]):
        q = unpack(_At, at[k], 0)
        current = Phases(q.a, q.b, q.c)
        thrust = thrust_of(motor_map, tables, q.position, current)
        normal = normal_force_of(motor_map, tables, q.position, current)
        pack(_Sum(thrust, normal), sums[k])
