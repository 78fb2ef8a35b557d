"""A machine of one axis that is not the lab's: two masses on a spring, friction, an encoder.

It shares no code with the lab: friction of each kind, a Runge-Kutta integrator with 20 us steps, a
controller, sampling and noise are written out here. The normal force acts in the level g of LuGre's
bristle, which the lab's models do not have, and the Maxwell elements are ten of other stiffnesses.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

PERIOD = 1e-3
_STEPS = 50
_RESOLUTION, _POSITION_NOISE, _FORCE_NOISE = 50e-9, 15e-9, 20e-3
_ELEMENTS = 10
_STATIC, _LUGRE, _GMS = 0, 1, 2
_MODES = {
    "coulomb": _STATIC,
    "stribeck": _STATIC,
    "lugre": _LUGRE,
    "lugre-load": _LUGRE,
    "gms": _GMS,
}


class Machine(NamedTuple):
    """A machine; SI.

    Attributes
    ----------
    kind : str
        Of its friction.
    M : float
        Moving mass, of which a part is on a spring.
    F_c, F_s, v_s, sigma_0, sigma_1, sigma_2, mu, attraction : float
        Its friction.
    preload, wave : float
        Mean normal force, and the relative change of it along the stroke.
    resonance : float
        Frequency of the part on the spring, Hz.
    cogging : float
        Amplitude over a pitch of 7.2 mm, N.
    """

    kind: str
    M: float = 5.0
    F_c: float = 1.0
    F_s: float = 2.0
    v_s: float = 0.01
    sigma_0: float = 1.5e5
    sigma_1: float = 800.0
    sigma_2: float = 15.0
    mu: float = 0.0
    attraction: float = 100.0
    preload: float = 20.0
    wave: float = 0.4
    resonance: float = 180.0
    cogging: float = 0.0


def recorded(machine: Machine, reference: Array, seed: int = 0) -> dict[str, Array]:
    """Return what its logger has: time, position, force command and normal force."""
    rng = np.random.default_rng(seed)
    noise = _POSITION_NOISE * rng.standard_normal(len(reference))
    values = np.array(machine[1:])
    if machine.kind == "coulomb":
        values[2] = machine.F_c
    position, force, normal = _moved(_MODES[machine.kind], values, reference, noise)
    noises: Array = rng.standard_normal((2, len(force)))
    return {
        "time [s]": (np.arange(len(reference)) * PERIOD).astype(np.float64),
        "slide [mm]": 1e3 * position,
        "push [N]": force + _FORCE_NOISE * noises[0],
        "preload [N]": normal * (1.0 + 0.01 * noises[1]),
    }


def sines(parts: list[tuple[float, float, int]]) -> Array:
    """Return a reference of sines, ``(amplitude, frequency, cycles)``, one after another.

    Each begins and ends at a turning point; between two the axis moves over within 1 s.
    """
    u = np.linspace(0.0, 1.0, round(1.0 / PERIOD))
    gate = u**3 * (10.0 - 15.0 * u + 6.0 * u * u)
    places: list[Array] = []
    end = 0.0
    for amplitude, frequency, cycles in parts:
        t = np.arange(round(cycles / frequency / PERIOD)) * PERIOD
        places += [end + (amplitude - end) * gate]
        places += [amplitude * np.cos(2.0 * np.pi * frequency * t)]
        end = amplitude
    return np.concatenate(places)


@numba.njit(error_model="numpy")
def _moved(mode: int, values: Array, reference: Array, noise: Array) -> tuple[Array, Array, Array]:
    M, F_c, F_s, v_s, sigma_0, sigma_1, sigma_2, mu = values[:8]
    preload, wave, resonance, cogging = values[9:]
    light = 0.15 * M
    heavy = M - light
    k = light * (2.0 * math.pi * resonance) ** 2
    d = 2.0 * 0.03 * math.sqrt(k * light)
    stiffness = (1.0 + np.arange(_ELEMENTS)) ** -1.5
    stiffness *= sigma_0 / np.sum(stiffness)
    elements, slips = np.zeros(_ELEMENTS), np.zeros(_ELEMENTS)
    n = len(reference)
    position, force, normal = np.empty(n), np.empty(n), np.empty(n)
    s = np.zeros(5)  # slide, its velocity, part on the spring, its velocity, bristle
    h = PERIOD / _STEPS
    omega = 2.0 * math.pi * 25.0
    k_p, k_d = M * omega * omega, 1.6 * M * omega
    last = 0.0
    for t in range(n):
        seen = _RESOLUTION * np.rint((s[0] + noise[t]) / _RESOLUTION)
        before = reference[t - 1] if t > 0 else reference[0]
        rate = (reference[t] - before - seen + last) / PERIOD
        push = k_p * (reference[t] - seen) + k_d * rate
        last = seen
        position[t], force[t] = seen, push
        normal[t] = preload * (1.0 + wave * math.sin(2.0 * math.pi * s[0] / 0.023))
        for _ in range(_STEPS):
            held = 0.0
            if mode == _GMS:
                held = _slip(elements, slips, stiffness, s[1], values, h)
            slopes = np.empty((4, 5))
            at = s.copy()
            for stage in range(4):
                p, v, q, w, z = at
                N = preload * (1.0 + wave * math.sin(2.0 * math.pi * p / 0.023))
                level = F_c + (F_s - F_c) * math.exp(-((v / v_s) ** 2)) + mu * N
                bend = 0.0
                if mode == _STATIC:
                    friction = level * math.tanh(v / 1e-4)
                elif mode == _LUGRE:
                    bend = v - sigma_0 * abs(v) * z / level
                    friction = sigma_0 * z + sigma_1 * bend
                else:
                    friction = held
                spring = k * (q - p) + d * (w - v)
                net = push - friction - sigma_2 * v + spring
                net -= cogging * math.sin(2.0 * math.pi * p / 7.2e-3)
                slopes[stage, 0] = v
                slopes[stage, 1] = net / heavy
                slopes[stage, 2] = w
                slopes[stage, 3] = -spring / light
                slopes[stage, 4] = bend
                if stage < 3:
                    at = s + (0.5 * h if stage < 2 else h) * slopes[stage]
            s = s + h / 6.0 * (slopes[0] + 2.0 * slopes[1] + 2.0 * slopes[2] + slopes[3])
    return position, force, normal


@numba.njit(error_model="numpy")
def _slip(
    elements: Array, slips: Array, stiffness: Array, v: float, values: Array, h: float
) -> float:
    """Step the Maxwell elements explicitly; return their sum."""
    F_c, F_s, v_s, attraction = values[1], values[2], values[3], values[8]
    level = F_c + (F_s - F_c) * math.exp(-((v / v_s) ** 2))
    share = level / len(elements)
    total = 0.0
    for i in range(len(elements)):
        if slips[i] != 0.0 and slips[i] * v < 0.0:
            slips[i] = 0.0
        if slips[i] != 0.0:
            goal = slips[i] * share
            elements[i] += (goal - elements[i]) * min(1.0, attraction / level * h)
        else:
            elements[i] += stiffness[i] * v * h
            if abs(elements[i]) >= share:
                slips[i] = math.copysign(1.0, elements[i])
                if slips[i] * v > 0.0:
                    elements[i] = slips[i] * share
        total += elements[i]
    return total
