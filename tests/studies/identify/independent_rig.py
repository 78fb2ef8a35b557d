"""A rig of one axis by an integrator of its own: Runge-Kutta of fourth order, 10 us steps.

It shares no code with the lab's simulation: map, force sharing, current loops, friction, sampling
and noise are written out here.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

PERIOD = 0.5e-3  # s, of control and of the record
STEPS = 50
"""Of the integrator in a period."""

_RESOLUTION, _POSITION_NOISE = 50e-9, 20e-9  # m
_CURRENT_STEP, _CURRENT_NOISE, _FORCE_NOISE = 10e-3, 5e-3, 20e-3  # A, A, N
_F_PK, _I_PK, _I_KNEE, _PITCH = 34.1, 10.0, 5.5, 7.2e-3
_K_P, _K_D = 200300.0, 1530.0
_EACH, _BETWEEN = 12.0, 1.5  # s


class Sine(NamedTuple):
    """A sine from one of its turning points.

    Attributes
    ----------
    amplitude, frequency : float
        m and Hz.
    cycles : int
        Whole ones.
    """

    amplitude: float
    frequency: float
    cycles: int


def sines(rng: np.random.Generator) -> list[Sine]:
    """Return sines of 30, 55 and 4 mm at 0.15 to 0.3 Hz, about 40 s, up to 104 mm/s."""
    frequencies = rng.uniform(0.15, 0.3, 3)
    return [
        Sine(amplitude, float(f), round(_EACH * f))
        for amplitude, f in zip((0.030, 0.055, 0.004), frequencies, strict=True)
    ]


def reference(parts: Sequence[Sine]) -> Array:
    """Return the reference position at every sample, m: the sines, and moves between them."""
    u = np.linspace(0.0, 1.0, round(_BETWEEN / PERIOD))
    gate = u**3 * (10.0 - 15.0 * u + 6.0 * u * u)
    places: list[Array] = []
    end = 0.0
    for part in parts:
        t = np.arange(round(part.cycles / part.frequency / PERIOD)) * PERIOD
        places.append(end + (part.amplitude - end) * gate)
        places.append(part.amplitude * np.cos(2.0 * np.pi * part.frequency * t))
        end = part.amplitude
    return np.concatenate(places)


def recorded(
    motor: Mapping[str, float], wanted: Array, *, seed: int = 0, bandwidth: float = 1000.0
) -> dict[str, Array]:
    """Return what a logger has of an axis under PD control: time, position, currents, force.

    Parameters
    ----------
    motor : mapping
        F_c, F_s, v_s, sigma_0, sigma_1, sigma_2, M and a constant load f_0, SI.
    wanted : ndarray, shape (n,)
        Reference, m.
    seed : int
        Of the noise.
    bandwidth : float
        Of the current loops, Hz.
    """
    names = ("F_c", "F_s", "v_s", "sigma_0", "sigma_1", "sigma_2", "M", "f_0")
    rng = np.random.default_rng(seed)
    read_noise = _POSITION_NOISE * rng.standard_normal(len(wanted))
    values = np.array([motor[name] for name in names])
    position, force, current = _integrated(values, wanted, read_noise, 2.0 * np.pi * bandwidth)
    noisy = current + _CURRENT_NOISE * rng.standard_normal(current.shape)
    reading = _CURRENT_STEP * np.rint(noisy / _CURRENT_STEP)
    columns = {
        "time [s]": np.arange(len(wanted)) * PERIOD,
        "x_act [mm]": 1e3 * position,
        "force_command_x [N]": force + _FORCE_NOISE * rng.standard_normal(len(wanted)),
    }
    return columns | {f"i_{phase} [A]": reading[k] for k, phase in enumerate("abc")}


@numba.njit(error_model="numpy")
def _shapes(position: float) -> tuple[float, float, float]:
    angle = 2.0 * math.pi * position / _PITCH
    third = 2.0 * math.pi / 3.0
    return math.sin(angle), math.sin(angle - third), math.sin(angle - 2.0 * third)


@numba.njit(error_model="numpy")
def _slope(motor: Array, s: Array, command: Array, omega: float) -> Array:
    """Return the time derivative of position, velocity, bristle and three currents."""
    F_c, F_s, v_s, sigma_0, sigma_1, sigma_2, M, f_0 = motor
    b = (_I_PK / _I_KNEE) ** 2
    shapes = _shapes(s[0])
    thrust = 0.0
    for k in range(3):
        q = (s[3 + k] / _I_PK) ** 2
        thrust += _F_PK * (1.0 + b) * q / (1.0 + b * q) * shapes[k]
    level = F_c + (F_s - F_c) * math.exp(-((s[1] / v_s) ** 2))
    bend = s[1] - sigma_0 * abs(s[1]) * s[2] / level
    slope = np.empty(6)
    slope[0] = s[1]
    slope[1] = (thrust - f_0 - sigma_0 * s[2] - sigma_1 * bend - sigma_2 * s[1]) / M
    slope[2] = bend
    slope[3:] = omega * (command - s[3:])
    return slope


@numba.njit(error_model="numpy")
def _commands(position: float, force: float) -> Array:
    """Return the currents whose thrusts are shared by the squares of the shapes, A."""
    b = (_I_PK / _I_KNEE) ** 2
    shapes = _shapes(position)
    pulls = np.zeros(3)
    for k in range(3):
        pulls[k] = max(0.0, shapes[k] if force > 0.0 else -shapes[k])
    y = np.minimum(abs(force) * pulls / (_F_PK * np.sum(pulls * pulls)), 1.0)
    return _I_PK * np.sqrt(y / (1.0 + b * (1.0 - y)))


@numba.njit(error_model="numpy")
def _integrated(
    motor: Array, wanted: Array, noise: Array, omega: float
) -> tuple[Array, Array, Array]:
    n = len(wanted)
    position, force, current = np.empty(n), np.empty(n), np.empty((3, n))
    s, h = np.zeros(6), PERIOD / STEPS
    last, target = 0.0, wanted[0]
    for k in range(n):
        position[k] = _RESOLUTION * np.rint((s[0] + noise[k]) / _RESOLUTION)
        velocity = ((wanted[k] - target) - (position[k] - last)) / PERIOD
        push = _K_P * (wanted[k] - position[k]) + _K_D * velocity
        force[k] = min(max(push, -27.0), 27.0)
        last, target = position[k], wanted[k]
        current[:, k] = s[3:]
        command = _commands(position[k], force[k])
        for _ in range(STEPS):
            a = _slope(motor, s, command, omega)
            b = _slope(motor, s + 0.5 * h * a, command, omega)
            c = _slope(motor, s + 0.5 * h * b, command, omega)
            d = _slope(motor, s + h * c, command, omega)
            s = s + h / 6.0 * (a + 2.0 * b + 2.0 * c + d)
    return position, force, current
