"""The plant of one lane about a velocity, sampled: compiled for this machine and for WebAssembly.

Between two commands the force is held::

    M dv/dt = f - f_f,   df/dt = omega (gain f_command - f)
    f_f = sigma_0 z + sigma_1 dz/dt + sigma_2 v,   dz/dt = lambda g'(v_0) v - lambda z
    d^2y/dt^2 = omega_r^2 (compliance f - y) - 2 zeta omega_r dy/dt,   p_meas = p + y

with ``lambda = abs(v_0)/g(v_0)``; stuck (v_0 = 0), ``dz/dt = v``.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from motionlab.kernel.layout import parameter_row
from motionlab.lanes import compiled
from motionlab.loop.matrices import exponential_less_one
from motionlab.plant.friction import LuGre, stribeck_fade, stribeck_level
from motionlab.plant.resonance import Resonance, natural
from motionlab.timing import CONTROL_PERIOD, PLANT_STEP

Array = NDArray[np.float64]

PLANT_SIZE = 7
"""Rows of the system: position, velocity, bristle, force; deflection and its rate; output."""
CREEP = 1e-3
"""Rate at which a stuck bristle relaxes, 1/s: a mover may rest anywhere, and no pole lies at 1."""
_NO_FRICTION = 1e-30
"""Below this stiction there is no bristle, N."""
_FRICTION, _MASS = parameter_row("friction.sigma_0"), parameter_row("mechanics.M")
_RESONANCE = parameter_row("resonance.compliance")
_HALF_STEP = parameter_row("amplifiers.half_step")
_IDEAL = parameter_row("controller.ideal_force")


@compiled
def friction_of(numbers: Array, first: int) -> LuGre:
    """Return the friction of the first lane of parameters, from a row on, as plain numbers."""
    return LuGre(
        numbers[first, 0],
        numbers[first + 1, 0],
        numbers[first + 2, 0],
        numbers[first + 3, 0],
        numbers[first + 4, 0],
        numbers[first + 5, 0],
    )


@compiled
def sliding_force(f: LuGre, v: float) -> float:
    """Return the friction force of sliding at a velocity, N; the breakaway force at rest."""
    speed = abs(v)
    return stribeck_level(speed, f.F_c, f.F_s, f.v_s) + f.sigma_2 * speed


@compiled
def _bristle(f: LuGre, v: float) -> tuple[float, float]:
    """Return slope and rate of the bristle state about a velocity: ``dz/dt = slope v - rate z``."""
    if f.F_s < _NO_FRICTION:
        return 0.0, 1.0
    if v == 0.0:
        return 1.0, CREEP
    speed = abs(v)
    dip = (f.F_s - f.F_c) * stribeck_fade(speed, f.v_s) / f.sigma_0
    g = f.F_c / f.sigma_0 + dip
    bend = -2.0 * speed / f.v_s**2 * dip  # g'(v_0), s
    return speed / g * bend, speed / g


@compiled
def plant_about(  # noqa: PLR0913, PLR0917 - what it depends on, and where it goes
    numbers: Array,
    v: float,
    gain: float,
    disturbance: bool,
    system: Array,
    A: Array,
    product: Array,
) -> int:
    """Write the sampled plant about a velocity as a system; return the number of its states.

    Parameters
    ----------
    numbers : ndarray, shape (PARAMETER_ROWS, lanes)
        Of the first lane.
    v : float
        Velocity, m/s; 0 is stuck.
    gain : float
        Thrust per newton commanded, 1; see `motionlab.kernel.force_gain`.
    disturbance : bool
        The input, N, is not the command but adds to the thrust.
    system : ndarray, shape (PLANT_SIZE, PLANT_SIZE)
        Overwritten: from the input to the position, m.
    A, product : ndarray, shape of `system`
        Overwritten.
    """
    f, M = friction_of(numbers, _FRICTION), numbers[_MASS, 0]
    compliance = numbers[_RESONANCE, 0]
    n = PLANT_SIZE - 1 if compliance != 0.0 else 4
    for i in range(n + 1):
        for j in range(n + 1):
            A[i, j] = 0.0
    slope, rate = _bristle(f, v)
    A[0, 1] = 1.0
    A[1, 1] = -(f.sigma_1 * slope + f.sigma_2) / M
    A[1, 2] = (f.sigma_1 * rate - f.sigma_0) / M
    A[2, 1], A[2, 2] = slope, -rate
    ideal, rest = numbers[_IDEAL, 0] > 0.0, numbers[_HALF_STEP, 0]
    at_once = disturbance or ideal or rest == 0.0
    # The column of what acts on the mover: the input, or the force that follows it.
    acts = n if at_once else 3
    share = gain if at_once and not disturbance else 1.0
    A[1, acts] = share / M
    if n == PLANT_SIZE - 1:
        mode = Resonance(
            compliance,
            numbers[_RESONANCE + 1, 0],
            numbers[_RESONANCE + 2, 0],
            numbers[_RESONANCE + 3, 0],
            numbers[_RESONANCE + 4, 0],
        )
        stiffness, damping = natural(mode, PLANT_STEP)
        A[4, 5], A[5, 4], A[5, 5] = 1.0, -stiffness, -damping
        A[5, acts] = share * stiffness * compliance
    A[3, 3] = -1.0
    if not at_once:
        omega = -math.log(rest) / (0.5 * PLANT_STEP)
        A[3, 3], A[3, n] = -omega, gain * omega
    for i in range(n + 1):
        for j in range(n + 1):
            A[i, j] *= CONTROL_PERIOD
    exponential_less_one(A, n + 1, system, product)
    for i in range(n):
        system[i, i] += 1.0
        system[n, i] = 1.0 if i == 0 or i == 4 else 0.0  # noqa: PLR1714 - a set is an object
    system[n, n] = 0.0
    return n
