"""Running scenarios in tests the way a user does: load with changes, prepare, run."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.config.load import load_scenario
from motionlab.config.planar import AXES
from motionlab.simulation.prepare import Prepared, prepare
from motionlab.simulation.run import run
from motionlab.telemetry.recording import Recording

FRICTIONLESS: dict[str, Any] = {
    f"{part}.{axis}.friction.enabled": False
    for part in ("plant", "variants.A.controller.model", "variants.B.controller.model")
    for axis in AXES
}
"""Changes to `circle`: no friction, neither true nor believed."""

IDEAL: dict[str, Any] = FRICTIONLESS | {
    "plant.force": "ideal",
    "plant.x.encoder.resolution": 0.0,
    "plant.y.encoder.resolution": 0.0,
}
"""Changes to `circle`: the plant of eqs (39) to (42), a mass under the commanded force."""

SHORT: dict[str, Any] = {"trajectory.laps": 1, "trajectory.lead_in": 0.5}
"""Changes to `circle`: one lap, to be quick."""


def true_map(plant: str) -> dict[str, Any]:
    """Return changes to `circle` that give variant A the force map of a shipped motor."""
    motor = load_scenario("circle", {"plant": plant}).plant
    return {
        f"variants.A.controller.model.{axis}.force_map": getattr(motor, axis).force_map.model_dump()
        for axis in AXES
    }


class Played(NamedTuple):
    """A scenario that has been run."""

    prepared: Prepared
    recording: Recording

    def channel(self, variant: str, name: str, axis: str) -> NDArray[np.float64]:
        """Return one channel in double precision, shape (ticks,)."""
        return self.recording.variants[variant].channel(name, axis).astype(np.float64)

    def samples(self, variant: str) -> NDArray[np.float32]:
        """Return all channels of a variant as recorded, shape (channels, axes, ticks)."""
        return self.recording.variants[variant].samples

    def largest_error(self, variant: str, axis: str) -> float:
        """Return the largest following error over the metrics window, m."""
        window = slice(*self.prepared.reference.window)
        return float(np.abs(self.channel(variant, "following_error", axis)[window]).max())


def play(
    source: str | Mapping[str, Any] = "circle", changes: Mapping[str, Any] | None = None
) -> Played:
    """Load a scenario with changes, prepare it and run it to its end."""
    prepared = prepare(load_scenario(source, changes))
    return Played(prepared, run(prepared))


def same_bits(first: NDArray[Any], second: NDArray[Any]) -> bool:
    """Return whether two arrays hold the same bytes; NaN equals NaN, -0 differs from 0."""
    return first.dtype == second.dtype and first.tobytes() == second.tobytes()
