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
    cogging, pitch : float
        Amplitude of a force of the position, and its period.
    cable : float
        Force of a cable 30 mm from the middle.
    tight : float
        Relative change of the friction over a pitch.
    warming, settling : float
        Share of the friction that is lost by warming, and its time constant.
    power : float
        Friction of the 0.3th power of the velocity, at 100 mm/s.
    hump : float
        Friction more about 50 mm/s.
    skew : float
        Relative difference of viscous friction, and of stiction, between the directions.
    memory, length : float
        Friction of a second bristle, and its displacement before sliding.
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
    pitch: float = 7.2e-3
    cable: float = 0.0
    tight: float = 0.0
    warming: float = 0.0
    settling: float = 5.0
    power: float = 0.0
    hump: float = 0.0
    skew: float = 0.0
    memory: float = 0.0
    length: float = 1e-3


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
    preload, wave, resonance = values[9:12]
    skew, length = values[20], values[22]
    light = 0.15 * M
    heavy = M - light
    k = light * (2.0 * math.pi * resonance) ** 2
    d = 2.0 * 0.03 * math.sqrt(k * light)
    stiffness = (1.0 + np.arange(_ELEMENTS)) ** -1.5
    stiffness *= sigma_0 / np.sum(stiffness)
    elements, slips = np.zeros(_ELEMENTS), np.zeros(_ELEMENTS)
    n = len(reference)
    position, force, normal = np.empty(n), np.empty(n), np.empty(n)
    s = np.zeros(6)  # slide, its velocity, part on the spring, its velocity, bristle, second one
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
            slopes = np.empty((4, 6))
            at = s.copy()
            for stage in range(4):
                p, v, q, w, z, y = at
                N = preload * (1.0 + wave * math.sin(2.0 * math.pi * p / 0.023))
                side = 1.0 + skew * math.copysign(1.0, v)
                level = F_c + side * (F_s - F_c) * math.exp(-((v / v_s) ** 2)) + mu * N
                bend = 0.0
                if mode == _STATIC:
                    friction = level * math.tanh(v / 1e-4)
                elif mode == _LUGRE:
                    bend = v - sigma_0 * abs(v) * z / level
                    friction = sigma_0 * z + sigma_1 * bend
                else:
                    friction = held
                friction = _beside(friction, at, t, values) + sigma_2 * side * v
                spring = k * (q - p) + d * (w - v)
                net = push - friction + spring
                again = (v - abs(v) * y) / length
                slopes[stage] = np.array([v, net / heavy, w, -spring / light, bend, again])
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


@numba.njit(error_model="numpy")
def _beside(friction: float, state: Array, tick: int, values: Array) -> float:
    """Return friction with what no model has a term for, and forces of the position."""
    cogging, pitch, cable, tight, warming, settling, power, hump = values[12:20]
    memory, p, v = values[21], state[0], state[1]
    smooth = math.tanh(v / 1e-4)
    friction += smooth * power * (abs(v) / 0.1) ** 0.3
    friction += smooth * hump * math.exp(-(((abs(v) - 0.05) / 0.02) ** 2))
    friction *= 1.0 + tight * math.sin(2.0 * math.pi * p / pitch)
    friction *= 1.0 - warming * (1.0 - math.exp(-tick * PERIOD / settling))
    friction += memory * state[5]
    friction += cogging * math.sin(2.0 * math.pi * p / pitch)
    return friction + cable * (p / 0.03 + (p / 0.03) ** 2) / 2.0
