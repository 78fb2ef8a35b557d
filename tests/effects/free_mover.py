"""A mover without control under loads and effects, and the same by other means."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab.config.load import load_scenario
from motionlab.effects import EFFECTS, MidStep
from motionlab.lanes import WIDTH
from motionlab.simulation.prepare import prepare
from motionlab.simulation.run import run

Array = NDArray[np.float64]

STEPS = 40
HELD = 0.005  # s for which a load is held
M = 5.9  # kg


def loads(amplitude: float) -> Array:
    """Return a load, N, of growing swings, held over each of the STEPS."""
    t = HELD * np.arange(STEPS)
    return np.asarray(amplitude * (0.4 + 3.0 * t) * np.sin(2.0 * np.pi * 11.0 * t), dtype=float)


def simulated(effects: list[dict[str, Any]], load: Array) -> dict[str, Array]:
    """Return channels of x in the lab, every 0.5 ms."""
    steps = np.diff(load, prepend=0.0)
    changes: dict[str, Any] = {
        "trajectory": {"kind": "point", "duration": HELD * STEPS},
        "plant.force": "ideal",
        "plant.x.friction.enabled": False,
        "plant.x.encoder.resolution": 0.0,
        "plant.x.effects": effects,
        "load.steps": [
            {"time": HELD * k, "x": float(each)} for k, each in enumerate(steps) if each
        ],
        "divergence_error": 1.0,
        "variants.A.controller.x.k_p": 0.0,
        "variants.A.controller.x.k_d": 0.0,
    }
    recording = run(prepare(load_scenario("circle", changes), checked=True))
    names = ("position", "velocity", "acceleration", "friction", "thrust")
    of_a = recording.variants["A"]
    return {name: of_a.channel(name, "x").astype(np.float64) for name in names}


def stepped(
    load: Array, rate: Callable[[float, float, Array], tuple[float, Array]], states: int, h: float
) -> Array:
    """Return positions and velocities every 0.5 ms, (n, 2), of Heun's method with a small step.

    `rate` takes velocity, position and the states of friction, and returns its force and their
    rates.
    """
    every, rows = round(5e-4 / h), []
    p = v = 0.0
    s = np.zeros(states)
    for k in range(round(HELD * STEPS / h)):
        if k % every == 0:
            rows.append((p, v))
        f = load[int(k * h / HELD + 1e-9)]
        force, s_rate = rate(v, p, s)
        a = -(f + force) / M
        v_1, s_1 = v + h * a, s + h * s_rate
        force_1, s_rate_1 = rate(v_1, p + h * v, s_1)
        a_1 = -(f + force_1) / M
        p, v, s = p + h * (v + v_1) / 2, v + h * (a + a_1) / 2, s + h * (s_rate + s_rate_1) / 2
    return np.array(rows)


def pushed(
    name: str, values: dict[str, Any], velocity: Array, h: float, normal: Array | float = 0.0
) -> tuple[Array, Array]:
    """Return the force of an effect at given velocities, one a step, and the positions there.

    The normal force, N, may be another in each step.
    """
    from motionlab.plant.friction import LuGre

    effect = EFFECTS[name]
    friction = LuGre(118913.0, 1162.3, 10.3, 0.24, 3.59, 0.0436)
    every = {each.name: each.default for each in effect.parameters} | values
    par = effect.lane_parameters(every, friction)
    zero = np.zeros(WIDTH)
    state = effect.State(*[zero] * len(effect.State._fields))
    forces, positions, p = [], [], zero
    normals = np.broadcast_to(normal, velocity.shape)
    for k, each in enumerate(velocity):
        v = zero + each
        middle = p + 0.5 * h * v
        seen = MidStep(
            middle, v, zero + k * h, zero, zero, zero, zero + normals[k], zero, zero + M, zero + h
        )
        with np.errstate(all="ignore"):
            resistance, state = effect.step(par, state, seen)
        p = p + h * v
        forces.append((resistance.force + zero)[0])
        positions.append(middle[0])
    return np.array(forces), np.array(positions)
