"""Compare every compensation law on the circle, on the nominal and on the matched motor.

Run with ``.venv/bin/python examples/compare_laws.py``; prints the table of docs/compensation.md.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from motionlab.config.load import load_scenario
from motionlab.simulation.prepare import prepare
from motionlab.simulation.run import run

REFERENCE = {"compensation.velocity": "reference"}
FEEDFORWARD = {"feedforward": True}
OBSERVER = {"disturbance_observer.enabled": True}
FASTER = {"disturbance_observer.bandwidth": 80.0}

ROWS: list[tuple[str, str, dict[str, Any]]] = [
    ("off (PD only)", "off", {}),
    ("LuGre observer, K = 0", "lugre-observer", {}),
    ("K as published, raw", "published-k", {}),
    (
        "K as published, bristle estimate within F_s/sigma_0",
        "published-k",
        {"compensation.bristle_limit": 1.0},
    ),
    ("K from the explicit residual", "residual-k", {}),
    ("K with its sign reversed", "reversed-k", {}),
    ("Canudas de Wit, K = 300/s e", "canudas-de-wit", {}),
    ("disturbance observer 30 Hz alone", "off", OBSERVER),
    ("acceleration feedforward alone", "off", FEEDFORWARD),
    ("LuGre observer + feedforward", "lugre-observer", FEEDFORWARD),
    (
        "LuGre observer + feedforward + disturbance observer 30 Hz",
        "lugre-observer",
        FEEDFORWARD | OBSERVER,
    ),
    ("residual K + both", "residual-k", FEEDFORWARD | OBSERVER),
    ("reversed K + both", "reversed-k", FEEDFORWARD | OBSERVER),
    ("Canudas de Wit + both", "canudas-de-wit", FEEDFORWARD | OBSERVER),
    (
        "LuGre on the reference's velocity + feedforward + disturbance observer 80 Hz",
        "lugre-observer",
        REFERENCE | FEEDFORWARD | OBSERVER | FASTER,
    ),
    (
        "reversed K on the reference's velocity + feedforward + disturbance observer 80 Hz",
        "reversed-k",
        REFERENCE | FEEDFORWARD | OBSERVER | FASTER,
    ),
]


def largest_errors(plant: str, law: str, switches: dict[str, Any]) -> list[float]:
    """Return the largest following errors on x and y, um."""
    changes = {"plant": plant, "variants.B.controller.compensation.law": law}
    changes |= {f"variants.B.controller.{key}": value for key, value in switches.items()}
    prepared = prepare(load_scenario("circle", changes))
    record = run(prepared).variants["B"]
    window = slice(*prepared.reference.window)
    return [
        float(np.abs(record.channel("following_error", axis)[window]).max()) * 1e6 for axis in "xy"
    ]


print("| compensation | x nominal | y nominal | x matched | y matched |")
print("|---|---|---|---|---|")
for title, law, switches in ROWS:
    errors = largest_errors("nominal", law, switches) + largest_errors("matched", law, switches)
    print(f"| {title} | " + " | ".join(f"{error:.3g}" for error in errors) + " |")
