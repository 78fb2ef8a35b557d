"""Driving the plant's integrator alone: eight movers under forces, compiled, on arrays."""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray

from motionlab.lanes import WIDTH, Lanes, pack, unpack
from motionlab.plant.friction import LuGre
from motionlab.plant.mechanics import Mechanics, Mover, advance
from tests.nominal_motor import Axis

Array = NDArray[np.float64]


class Push(NamedTuple):
    """Net force."""

    force: Lanes


def mechanics_rows(axis: Axis) -> Array:
    """Return Mechanics of eight equal lanes; the end stops are out of reach."""
    return np.tile(np.array([Mechanics(axis.M, 1e9, 0.0, 0.0)]).T, WIDTH)


def friction_rows(axis: Axis) -> Array:
    """Return LuGre of eight equal lanes."""
    one = LuGre(axis.sigma_0, axis.sigma_1, axis.sigma_2, axis.F_c, axis.F_s, axis.v_s)
    return np.tile(np.array([one]).T, WIDTH)


@numba.njit(error_model="numpy")
def push(
    mechanics: Array, friction: Array, state: Array, forces: Array, h: float, history: Array
) -> None:
    """Advance eight movers by ``len(forces)`` steps of `h` seconds.

    Parameters
    ----------
    mechanics, friction : ndarray, shape (fields, WIDTH)
        Rows of Mechanics and LuGre.
    state : ndarray, shape (3, WIDTH)
        Rows of Mover; overwritten.
    forces : ndarray, shape (steps, WIDTH)
        Net force of each step, N.
    h : float
        Step, s.
    history : ndarray, shape (steps, 3, WIDTH)
        Overwritten by the state after each step.
    """
    m = unpack(Mechanics, mechanics, 0)
    f = unpack(LuGre, friction, 0)
    s = unpack(Mover, state, 0)
    for k in range(len(forces)):
        force = unpack(Push, forces, k).force
        s = advance(m, f, s, force, h)
        pack(s, history[k])
    pack(s, state)


def pushed(axis: Axis, start: Array, forces: Array, h: float) -> Array:
    """Return the states before the first and after every step, shape (steps + 1, 3, WIDTH)."""
    history = np.empty((len(forces) + 1, 3, WIDTH))
    history[0] = start
    push(mechanics_rows(axis), friction_rows(axis), start.copy(), forces, h, history[1:])
    return history


def steady_bristle(axis: Axis, v: Array) -> Array:
    """Return the bristle state of steady sliding at velocity `v`, m."""
    level = axis.F_c + (axis.F_s - axis.F_c) * np.exp(-((v / axis.v_s) ** 2))
    return np.sign(v) * level / axis.sigma_0


def friction_force(axis: Axis, v: Array, z: Array) -> Array:
    """Return f_f of eqs (20) to (22), N, in plain numpy."""
    level = axis.F_c + (axis.F_s - axis.F_c) * np.exp(-((v / axis.v_s) ** 2))
    z_rate = v - axis.sigma_0 * np.abs(v) / level * z
    return axis.sigma_0 * z + axis.sigma_1 * z_rate + axis.sigma_2 * v
