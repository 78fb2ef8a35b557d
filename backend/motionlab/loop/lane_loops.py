"""The loops of one lane over its gains, compiled for this machine and for WebAssembly.

In the force ``u = k_p e + k_d de/dt`` the gains are factors, and everything else of the controller
is linear: the open loop and the closed loop's matrix are affine in k_p and k_d. Three
linearisations therefore give every loop of the plane of gains, at each velocity.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.lanes import compiled
from motionlab.loop.lane_controller import CONTROLLER_SIZE
from motionlab.loop.lane_plant import PLANT_SIZE
from motionlab.loop.matrices import largest_modulus, reach

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

STATES = CONTROLLER_SIZE + PLANT_SIZE - 2
"""States of a closed loop at most."""
MOST_FREQUENCIES = 1024
"""Frequencies of a family at most; a grid that is full stays as coarse as it is."""
UNIT = 1e3
"""Gains large enough for differences: N/m, and N s/m."""
ALL, MOVED, FREQUENCIES, HALVED, ROWS_OF_SIZES = range(3, 8)
"""Rows of whole numbers; the first three have the states on which responses depend."""
MOST_VELOCITIES = 16
_COARSE, _FINE, _FURTHEST = 1.2, 1e-4, 1e3
"""Factor by which a gain is moved until stability changes, share to which the place is known, and
furthest factor."""


class Loops(NamedTuple):
    """Arrays of the loops of one lane at V velocities.

    Attributes
    ----------
    velocity : ndarray, shape (V,)
        m/s; the first may be 0, stuck, the others are evenly spaced in their logarithms.
    plant : ndarray, shape (V, PLANT_SIZE, PLANT_SIZE)
        Systems of the plant.
    controller : ndarray, shape (3, V, CONTROLLER_SIZE, CONTROLLER_SIZE)
        Systems of the controller without gains, with UNIT N/m, and with UNIT N s/m.
    matrix : ndarray, shape (3, V, STATES, STATES)
        Closed loop without gains, and what each N/m and each N s/m adds to it; first the states
        whose poles gains move, and then the others, which have their poles by themselves.
    fixed : ndarray, shape (V,)
        Largest modulus of the other poles; the first below 0 where they are not known.
    frequency : ndarray, shape (MOST_FREQUENCIES,)
        Hz, closer where a loop changes fast.
    response : ndarray of complex, shape (2, V, MOST_FREQUENCIES)
        Open loop without gains, and what each N/m adds to it.
    sizes : ndarray, shape (ROWS_OF_SIZES, MOST_VELOCITIES)
        Whole numbers, of which ALL are the states of a closed loop, MOVED those whose poles gains
        move, and FREQUENCIES the frequencies; the others are the builder's.
    work : ndarray, shape (2, STATES + 1, STATES + 1)
        For matrices.
    upper : ndarray of complex, shape (STATES, STATES + 1)
        For responses.
    """

    velocity: Array
    plant: Array
    controller: Array
    matrix: Array
    fixed: Array
    frequency: Array
    response: Complex
    sizes: Array
    work: Array
    upper: Complex


def empty_loops(velocity: Array) -> Loops:
    """Return arrays of loops at velocities, to be filled."""
    v, f, s = len(velocity), MOST_FREQUENCIES, STATES
    return Loops(
        velocity,
        np.empty((v, PLANT_SIZE, PLANT_SIZE)),
        np.empty((3, v, CONTROLLER_SIZE, CONTROLLER_SIZE)),
        np.empty((3, v, s, s)),
        np.empty(v),
        np.empty(f),
        np.empty((2, v, f), dtype=np.complex128),
        np.empty((ROWS_OF_SIZES, MOST_VELOCITIES)),
        np.empty((2, s + 1, s + 1)),
        np.empty((s, s + 1), dtype=np.complex128),
    )


@compiled
def close_loops(loops: Loops, plant_states: int, controller_states: int) -> None:
    """Write the closed loops of plants and controllers, the states first whose poles gains move."""
    n, m = plant_states, plant_states + controller_states
    leads, moved = loops.work[0], loops.work[1]
    for i in range(m):
        for j in range(m):
            leads[i, j] = moved[i, j] = 0.0
    for corner in range(3):
        for v in range(len(loops.velocity)):
            plant, controller = loops.plant[v], loops.controller[corner, v]
            closed, free = loops.matrix[corner, v], loops.matrix[0, v]
            for i in range(m):
                for j in range(m):
                    value = _closed(plant, controller, n, controller_states, i, j)
                    if corner > 0:
                        value = (value - free[i, j]) / UNIT
                        moved[i, j] = max(moved[i, j], abs(value))
                    leads[i, j] = max(leads[i, j], abs(value))
                    closed[i, j] = value
    reach(leads, m)
    loops.fixed[0] = -1.0  # not known
    loops.sizes[ALL, 0] = m
    loops.sizes[MOVED, 0] = _moved_first(loops, m, leads, moved)


@compiled
def _closed(plant: Array, controller: Array, n: int, c: int, i: int, j: int) -> float:  # noqa: PLR0913, PLR0917
    """Return an entry of the closed loop's matrix of a plant of n and a controller of c states."""
    if i < n:
        if j < n:
            return plant[i, j] - controller[c, c] * plant[i, n] * plant[n, j]
        return -plant[i, n] * controller[c, j - n]
    if j < n:
        return controller[i - n, c] * plant[n, j]
    return controller[i - n, j - n]


@compiled
def _moved_first(loops: Loops, m: int, leads: Array, moved: Array) -> int:  # noqa: PLR0912
    """Put the states first whose poles gains move: their ring holds an entry with a gain in it.

    States that drive one another in a ring share poles; those of different rings do not.
    """
    rings, order = moved[m], leads[m]
    for k in range(m):
        rings[k] = 0.0
        for i in range(m):
            for j in range(m):
                if moved[i, j] != 0.0 and leads[i, j] * leads[j, i] != 0.0:
                    rings[k] += leads[i, k] * leads[k, i]
    count, others = 0, 0
    for k in range(m):
        if rings[k] > 0.0:
            order[count] = k
            count += 1
    for k in range(m):
        if rings[k] == 0.0:
            order[count + others] = k
            others += 1
    for corner in range(3):
        for v in range(len(loops.velocity)):
            closed = loops.matrix[corner, v]
            for i in range(m):
                for j in range(m):
                    moved[i, j] = closed[int(order[i]), int(order[j])]
            for i in range(m):
                for j in range(m):
                    closed[i, j] = moved[i, j]
    return count


@compiled
def stability(loops: Loops, k_p: Array, k_d: Array, radii: Array, limits: Array) -> None:
    """Write the largest moduli of poles, and gains at which stability changes.

    Parameters
    ----------
    k_p, k_d : ndarray, shape (n,)
        N/m and N s/m.
    radii : ndarray, shape (n, V)
        Overwritten: largest modulus at each velocity.
    limits : ndarray, shape (l, 2)
        Overwritten: of the first pair of gains, the nearest k_p and k_d at which stability changes,
        each moved alone, up from a stable loop and down from an unstable one; NaN where there is
        none up to a thousandfold. At the first velocity; and if l is 2, at the last.
    """
    count, moved = len(loops.velocity), int(loops.sizes[MOVED, 0])
    searches = count * (1 + len(k_p))
    # One job after another calls `largest_modulus` in one place: its code is long.
    for job in range(0 if loops.fixed[0] < 0.0 else count, searches + 2 * len(limits)):
        pair, v, gain = job // count - 1, job % count, 2
        if job >= searches:
            pair, v, gain = 0, (job - searches) // 2 * (count - 1), (job - searches) % 2
        begins, ratio, inside, outside, factor = True, 1.0, 1.0, 0.0, 1.0
        steps, looks = 0, True
        while looks:
            looks = False
            if pair < 0:
                loops.fixed[v] = _modulus(loops, v, moved, int(loops.sizes[ALL, 0]), 0.0, 0.0)
                continue
            p = k_p[pair] * (factor if gain == 0 else 1.0)
            d = k_d[pair] * (factor if gain == 1 else 1.0)
            modulus = max(_modulus(loops, v, 0, moved, p, d), loops.fixed[v])
            if gain == 2:
                radii[pair, v] = modulus
                continue
            row = (job - searches) // 2
            stable = modulus < 1.0
            if steps == 0:
                begins, ratio = stable, _COARSE if stable else 1.0 / _COARSE
            elif stable == begins:
                inside = factor
            else:
                outside = factor
            steps += 1
            if outside == 0.0:
                factor = inside * ratio
                looks = 1.0 / _FURTHEST < inside < _FURTHEST
                limits[row, gain] = math.nan
            else:
                factor = math.sqrt(inside * outside)
                looks = abs(outside / inside - 1.0) > _FINE
                limits[row, gain] = factor * (k_p[0] if gain == 0 else k_d[0])


@compiled
def _modulus(loops: Loops, v: int, first: int, end: int, k_p: float, k_d: float) -> float:  # noqa: PLR0913, PLR0917
    """Return the largest modulus of the poles of states [first, end) at a velocity."""
    closed = loops.work[0]
    for i in range(first, end):
        for j in range(first, end):
            gains = k_p * loops.matrix[1, v, i, j] + k_d * loops.matrix[2, v, i, j]
            closed[i - first, j - first] = loops.matrix[0, v, i, j] + gains
    return largest_modulus(closed, end - first)
