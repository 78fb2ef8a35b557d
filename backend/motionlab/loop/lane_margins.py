"""Open-loop responses of one lane and its margins, compiled for this machine and WebAssembly."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab.lanes import compiled
from motionlab.loop.lane_loops import FREQUENCIES, HALVED, UNIT, Loops
from motionlab.loop.matrices import path_from_input, response
from motionlab.timing import CONTROL_PERIOD

Array = NDArray[np.float64]

LOWEST = 0.05
HIGHEST = 0.5 / CONTROL_PERIOD * (1.0 - 1e-6)
"""Hz"""

GRID_POINTS = 1000
"""Frequencies from LOWEST to HIGHEST, evenly spaced in their logarithms."""
_EVERY, _CHANGE, _HALVINGS = 4, 0.12, 8
"""Initial stride over the frequency grid, the largest change of L between neighbours, that of one
such step at 40 dB a decade, and how often a gap is halved."""
_GAPS = -(-(GRID_POINTS - 1) // _EVERY)
_TINY = 1e-12
"""Numerical floor of the distance from -1."""


@compiled
def on_unit_circle(frequency: float) -> Any:
    """Return ``z = exp(2 pi i f T_s)`` of a frequency, Hz."""
    angle = 2.0 * math.pi * frequency * CONTROL_PERIOD
    return math.cos(angle) + 1j * math.sin(angle)


@compiled
def difference(z: Any) -> Any:
    """Return the response of what k_d acts on: the difference of what k_p acts on, 1/s."""
    return (1.0 - 1.0 / z) * (1.0 / CONTROL_PERIOD)


@compiled
def short_systems(loops: Loops, plant_states: int, controller_states: int) -> None:
    """Reduce the systems to the states on which their responses depend.

    The closed loops, which need all, have been made.
    """
    for k in range(3 * len(loops.velocity)):
        v, which = k // 3, k % 3
        system = loops.plant[v] if which == 0 else loops.controller[which - 1, v]
        n = plant_states if which == 0 else controller_states
        used = path_from_input(system, n, loops.work[0], loops.work[1])
        loops.sizes[which, v] = used
        for i in range(used + 1):
            for j in range(used + 1):
                system[i, j] = loops.work[0][i, j]


@compiled
def respond(loops: Loops, place: int, frequency: float) -> None:
    """Write the open loops at a frequency into a place of the responses."""
    z = on_unit_circle(frequency)
    loops.frequency[place] = frequency
    for v in range(len(loops.velocity)):
        plant, free = 0j, 0j
        for which in range(3):
            system = loops.plant[v] if which == 0 else loops.controller[max(which - 1, 0), v]
            value = response(system, int(loops.sizes[which, v]), z, loops.upper)
            if which == 0:
                plant = value
            elif which == 1:
                free = value
                loops.response[0, v, place] = plant * free
            else:
                loops.response[1, v, place] = plant * (value - free) * (1.0 / UNIT)


@compiled
def _is_coarse(loops: Loops, before: int, after: int) -> bool:
    """Whether a loop with gains of UNIT changes by more than _CHANGE between two places."""
    both = 1.0 + difference(on_unit_circle(loops.frequency[before]))
    also = 1.0 + difference(on_unit_circle(loops.frequency[after]))
    for v in range(len(loops.velocity)):
        a = loops.response[0, v, before] + UNIT * loops.response[1, v, before] * both
        b = loops.response[0, v, after] + UNIT * loops.response[1, v, after] * also
        least = min(_square(a), _square(b))
        if _square(b - a) > _CHANGE * _CHANGE * least:
            return True
    return False


@compiled
def _square(value: Any) -> float:
    return value.real * value.real + value.imag * value.imag


@compiled
def sample_responses(loops: Loops) -> None:
    """Write frequencies close enough for each loop with gains of UNIT, and responses there.

    A gap is halved, in logarithms, until no loop changes by more than _CHANGE in it. Ends of gaps
    wait at the arrays' end.
    """
    last, halved = loops.frequency.shape[0] - 1, loops.sizes[HALVED]
    count, waiting, gap = 0, 0, 0
    while waiting > 0 or gap <= _GAPS:
        top = last + 1 - waiting
        if waiting == 0:
            share = min(_EVERY * gap, GRID_POINTS - 1) / (GRID_POINTS - 1)
            frequency = LOWEST * math.exp(share * math.log(HIGHEST / LOWEST))
            halved[0] = 0.0
            gap += 1
        elif (
            count > 0
            and halved[waiting - 1] < _HALVINGS
            and count + waiting + _GAPS - gap + 1 < last
            and _is_coarse(loops, count - 1, top)
        ):
            frequency = math.sqrt(loops.frequency[count - 1] * loops.frequency[top])
            halved[waiting - 1] += 1.0
            halved[waiting] = halved[waiting - 1]
        else:
            loops.frequency[count] = loops.frequency[top]
            for v in range(len(loops.velocity)):
                loops.response[0, v, count] = loops.response[0, v, top]
                loops.response[1, v, count] = loops.response[1, v, top]
            count, waiting = count + 1, waiting - 1
            continue
        waiting += 1
        respond(loops, last + 1 - waiting, frequency)
    loops.sizes[FREQUENCIES, 0] = count


@compiled
def worst_margins(loops: Loops, k_p: float, k_d: float, worst: Array) -> None:
    """Write the worst margins of a pair of gains, infinite where nothing crosses.

    Parameters
    ----------
    worst : ndarray, shape (3, 2)
        Overwritten: value and velocity of gain margin, phase margin and Ms.
    """
    each = loops.work[0]
    for v in range(len(loops.velocity)):
        _margins_at(loops, v, k_p, k_d, each)
    for k in range(3):
        value, velocity = _least(loops.velocity, each[k])
        if k == 0:
            value = math.exp(value) if value < math.inf else value
        worst[k, 0] = 1.0 / max(value, _TINY) if k == 2 else value
        worst[k, 1] = velocity


@compiled
def _margins_at(loops: Loops, v: int, k_p: float, k_d: float, each: Array) -> None:
    """Write the margins at a velocity, interpolated between frequencies, into a column of `each`.

    Rows: logarithm of the gain margin, phase margin, nearest distance from -1.

    log abs(L) and arg L are straight between neighbours. A phase that jumps from pi to -pi passes
    through no 0.
    """
    gain, phase, nearest = math.inf, math.inf, math.inf
    before = 0j
    for k in range(int(loops.sizes[FREQUENCIES, 0])):
        z = on_unit_circle(loops.frequency[k])
        L = loops.response[0, v, k] + (k_p + k_d * difference(z)) * loops.response[1, v, k]
        size = _square(L)
        nearest = min(nearest, max(1.0 + 2.0 * L.real + size, 0.0))
        if k > 0:
            size_before = _square(before)
            if (size > 1.0) != (size_before > 1.0):
                a, b = 0.5 * math.log(size_before), 0.5 * math.log(size)
                angle, turn = _angle(-before), _turn(before, L)
                if a * b < 0.0:
                    phase = min(phase, abs(_wrapped(angle + turn * (a / (a - b)))))
            if (L.imag > 0.0) != (before.imag > 0.0):
                a, b = _angle(-before), _angle(-L)
                if a * b < 0.0 and abs(b - a) < math.pi:
                    begin, end = 0.5 * math.log(size_before), 0.5 * math.log(size)
                    gain = min(gain, abs(begin + (end - begin) * (a / (a - b))))
        before = L
    each[0, v], each[1, v], each[2, v] = gain, phase, math.sqrt(nearest)


@compiled
def _angle(value: Any) -> float:
    return math.atan2(value.imag, value.real)


@compiled
def _turn(before: Any, after: Any) -> float:
    """Return by how much the argument changes, in (-pi, pi]."""
    cross = before.real * after.imag - before.imag * after.real
    return math.atan2(cross, before.real * after.real + before.imag * after.imag)


@compiled
def _wrapped(angle: float) -> float:
    if angle > math.pi:
        return angle - 2.0 * math.pi
    return angle + 2.0 * math.pi if angle < -math.pi else angle


@compiled
def _least(velocity: Array, values: Array) -> tuple[float, float]:
    """Return the least of values over the velocities, on the parabola through it, and where."""
    k = 0
    for v in range(len(velocity)):
        if values[v] < values[k]:
            k = v
    value, at = values[k], velocity[k]
    slowest = 1 if velocity[0] == 0.0 else 0  # stuck is no neighbour of sliding
    if slowest < k < len(velocity) - 1:
        before, after = values[k - 1], values[k + 1]
        slope, bend = 0.5 * (after - before), after + before - 2.0 * value
        if abs(bend) < math.inf and bend != 0.0:
            value = max(value - 0.5 * slope * slope / bend, 0.0)
            at *= math.exp(-math.log(velocity[k + 1] / velocity[k]) * slope / bend)
    return value, at
