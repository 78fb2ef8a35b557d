"""``python -m tests.own_laws.documented_effects``: how far docs/own-effect.md's effects are off."""

from __future__ import annotations

import json

import numpy as np

from motionlab.timing import CONTROL_PERIOD
from tests.effects.free_mover import STEPS, simulated
from tests.simulated import FRICTIONLESS, play

SINE = {"kind": "sine", "amplitude": {"x": 0.02, "y": 0.0}, "frequency": 1.0, "cycles": 1}


def main() -> None:
    """Print the largest difference of a friction, N, and of a velocity, of its largest."""
    changes = FRICTIONLESS | {"trajectory": SINE}
    played = play("circle", changes | {"plant.x.effects": [{"effect": "run-in"}]})
    v, friction = (played.channel("A", name, "x") for name in ("velocity", "friction"))
    travelled = np.concatenate([[0.0], np.cumsum(np.abs(v[1:] + v[:-1]) / 2.0)]) * CONTROL_PERIOD
    run_in = (2.0 + np.exp(-travelled / 0.2)) * np.tanh(v / 2e-4)

    free = simulated([{"effect": "floor", "amplitude": 1.0}], np.zeros(STEPS))
    omega = 2.0 * np.pi * 12.0
    floor = -(1.0 - np.cos(omega * CONTROL_PERIOD * np.arange(len(free["velocity"])))) / omega
    misses = {
        "run-in": np.abs(friction - run_in).max(),
        "floor": np.abs(free["velocity"] - floor).max() / np.abs(floor).max(),
    }
    print(json.dumps({name: float(each) for name, each in misses.items()}))


if __name__ == "__main__":
    main()
