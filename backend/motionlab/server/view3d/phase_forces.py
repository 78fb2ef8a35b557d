"""Forces of each phase of a session's movers, from positions and currents by the plant's map."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from motionlab.config.force_map import AnyForceMapConfig, TableMapConfig
from motionlab.config.planar import AXES
from motionlab.config.plant import PlantConfig
from motionlab.force_sharing.pole_pitch import forces_of_phases
from motionlab.kernel.force_maps import map_lanes, pole_pitch
from motionlab.motor_design.kept_maps import named_map
from motionlab.scene3d.geometry import AIR_GAP
from motionlab.server.live.session import Session
from motionlab.telemetry.ring import Ring

Array = NDArray[np.float64]

READ = (
    "position",
    "following_error",
    "thrust",
    "normal_force",
    "friction",
    "current_a",
    "current_b",
    "current_c",
)
"""Channels of an axis that `newest` reads, in its order."""


class Newest(NamedTuple):
    """The newest sample of a session, of each variant and axis."""

    tick: int
    values: Array  # of `READ`, shape (variants, axes, 8)
    forces: Array  # thrust and normal force of each phase, N, shape (variants, axes, 2, 3)
    to_aligned: Array  # m, shape (variants, axes, 3)


class PhaseForces:
    """Forces of each phase of a plant.

    Parameters
    ----------
    plant : PlantConfig
        Its force maps; an ideal plant has no phases, and no forces of any.
    """

    def __init__(self, plant: PlantConfig) -> None:
        self._ideal = plant.force == "ideal"
        configs = [getattr(plant, axis).force_map for axis in AXES]
        self._maps = [map_lanes(config) for config in configs]
        self._pitch = [pole_pitch(config) for config in configs]
        self._offset = [config.offset for config in configs]

    def at(self, position: ArrayLike, current: ArrayLike) -> Array:
        """Return thrust and normal force of each phase, N, shape (variants, axes, 2, 3).

        Parameters
        ----------
        position : array_like, shape (variants, axes)
            True positions, m.
        current : array_like, shape (variants, axes, 3)
            Phase currents, A.
        """
        p, i = np.asarray(position, dtype=float), np.asarray(current, dtype=float)
        forces = np.zeros((*p.shape, 2, 3))
        if not self._ideal:
            for axis, motor_map in enumerate(self._maps):
                of_axis = forces_of_phases(motor_map, position=p[:, axis], current=i[:, axis])
                forces[:, axis, 0], forces[:, axis, 1] = of_axis
        return forces

    def to_aligned(self, position: ArrayLike) -> Array:
        """Return how far each phase is from its nearest aligned position, m.

        Positive where that lies at a larger position; a current pulls towards it. Half a pitch off,
        where both are equally far, it is positive.

        Parameters
        ----------
        position : array_like, shape (variants, axes)
            True positions, m.
        """
        pitch = np.array(self._pitch)[:, None]
        place = np.asarray(position, dtype=float)[..., None] + np.array(self._offset)[:, None]
        turns = place / pitch - np.arange(3) / 3.0
        return (0.5 - (turns - np.floor(turns))) * pitch


def air_gap(config: AnyForceMapConfig) -> float:
    """Return the air gap that a force map holds for, m: a table's own, else the paper's."""
    table = isinstance(config, TableMapConfig)
    return named_map(config.name).document.geometry.g if table else AIR_GAP


def newest(session: Session) -> Newest | None:
    """Return the newest sample of a session with the forces of its phases; None before any."""
    ring: Ring = session.history.ring
    end = ring.end
    if end == ring.first:
        return None
    rows = [
        session.history.rows[f"{name}.{axis}.{channel}"]
        for name in session.variants
        for axis in AXES
        for channel in READ
    ]
    shape = (len(session.variants), len(AXES), len(READ))
    try:
        values = ring.read(rows, end - 1, end).astype(float).reshape(shape)
    except IndexError:  # reset meanwhile
        return None
    model = PhaseForces(session.simulation.scenario.plant)
    position = values[..., 0]
    return Newest(end - 1, values, model.at(position, values[..., 5:]), model.to_aligned(position))
