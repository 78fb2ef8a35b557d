"""Records of the lab's motor with friction of a kind: an effect of the plant."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tests.simulated import play
from tests.studies.identify.measured_runs import channels

Array = NDArray[np.float64]

_EFFECTS = {"coulomb": "static-stribeck", "stribeck": "static-stribeck", "gms": "gms"}


def recorded(
    kind: str, motor: dict[str, float], parts: list[tuple[float, float, int]], seed: int
) -> dict[str, Array]:
    """Return what a rig logs of the motor: time, position, currents, force command; with noise.

    Parameters
    ----------
    kind : str
        ``coulomb``, ``stribeck``, ``lugre``, ``lugre-load`` or ``gms``.
    motor : dict
        Friction, ``mu``, ``attraction`` and M, SI.
    parts : list of (float, float, int)
        Amplitude, frequency and cycles of sines.
    seed : int
        Of the noise.
    """
    friction = {name: value for name, value in motor.items() if name in _FRICTION}
    if kind == "coulomb":
        friction["F_s"] = friction["F_c"]
    changes: dict[str, Any] = {f"plant.x.friction.{k}": v for k, v in friction.items()}
    changes |= {"plant.x.mass": motor["M"], "seed": seed}
    sines = [
        {"kind": "sine", "amplitude": {"x": a, "y": 0.0}, "frequency": f, "cycles": n}
        for a, f, n in parts
    ]
    changes["trajectory"] = {"kind": "sequence", "parts": sines}
    if kind != "lugre":
        effect: dict[str, Any] = {"effect": _EFFECTS.get(kind, "lugre")}
        if kind == "lugre-load":
            effect["mu"] = motor["mu"]
        if kind == "gms":
            effect["attraction"] = motor["attraction"]
        changes |= {"plant.x.friction.enabled": False, "plant.x.effects": [effect]}
    return channels(seed, play("circle", changes))


_FRICTION = frozenset({"F_c", "F_s", "v_s", "sigma_0", "sigma_1", "sigma_2"})
