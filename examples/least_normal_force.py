"""How much normal force a force-sharing function could save at most on the nominal motor, in um.

On the analytic map a phase has the normal force ``N_pk/F_pk tan(theta/2)/2`` for each newton of
thrust, whatever its current: least of all is what the phase gives that stands at the smaller angle,
to its current limit, and the other one only the rest. No function that ships does so. Run with
``.venv/bin/python examples/least_normal_force.py``; docs/sharing.md has what it prints.
"""

from __future__ import annotations

import numpy as np

from motionlab.config.force_map import ForceMapConfig
from motionlab.config.load import load_scenario
from motionlab.force_sharing.functions import FUNCTIONS
from motionlab.simulation.prepare import prepare
from motionlab.simulation.run import run
from motionlab.studies.sharing.sharing import SharingRequest, sharing

FORCES = 2.0, 5.0, 10.0, 20.0  # N
COEFFICIENTS = 0.003, 0.01, 0.03


def least(force: float, points: int = 360) -> np.ndarray:
    """Return the least normal force at each position of a pole pitch, N, where it can be given."""
    own = load_scenario("circle").plant.x.force_map
    assert isinstance(own, ForceMapConfig)
    angle = 2.0 * np.pi * (np.arange(points) + 0.5) / points
    angles = np.sort(np.mod(angle - 2.0 * np.pi * np.arange(3)[:, None] / 3.0, 2.0 * np.pi), axis=0)
    normal, left = np.zeros(points), np.full(points, force)
    for theta in angles:  # from the phase that is nearest to unaligned
        most = np.maximum(own.F_pk * np.sin(theta), 0.0)  # at 10 A, N
        given = np.minimum(left, most)
        normal += given * own.N_pk / own.F_pk * 0.5 * np.tan(0.5 * theta)
        left = left - given
    return np.where(left < 1e-9, normal, np.nan)


def errors(mu: float) -> list[float]:
    """Return B's largest following errors with friction mu N besides, x and y, um."""
    effects = {
        f"plant.{axis}.{name}": value
        for axis in "xy"
        for name, value in (
            ("effects", [{"effect": "lugre", "mu": mu}]),
            ("friction.enabled", False),
        )
    }
    controller = {"variants.B.controller": "lugre-reference-notch"}
    prepared = prepare(load_scenario("circle-resonant", controller | effects))
    record = run(prepared).variants["B"]
    window = slice(*prepared.reference.window)
    channels = (record.channel("following_error", axis)[window] for axis in "xy")
    return [1e6 * float(np.abs(each).max()) for each in channels]


heads = [*(f"`{name}`" for name in FUNCTIONS), "least"]
print(f"| thrust | {' | '.join(heads)} | saved |")
print("|---" * (len(heads) + 2) + "|")
shares = []
for force in FORCES:
    normals = [
        np.array(sharing(SharingRequest(law=name, force=force)).curves.normal_force)
        for name in FUNCTIONS
    ]
    best = least(force)
    normals.append(best)
    default = normals[list(FUNCTIONS).index("least-norm")]
    shares.append(1.0 - float(best.mean() / default.mean()))
    cells = " | ".join(f"{each.mean():.1f}, {each.max():.1f} N" for each in normals)
    print(f"| {force:g} N | {cells} | {100.0 * shares[-1]:.0f} % |")

print("\n| mu | error now, x, y | with the least normal force |")
print("|---|---|---|")
for mu in COEFFICIENTS:
    now, then = errors(mu), errors((1.0 - max(shares)) * mu)
    print(f"| {mu:g} | {now[0]:.2f}, {now[1]:.2f} um | {then[0]:.2f}, {then[1]:.2f} um |")
