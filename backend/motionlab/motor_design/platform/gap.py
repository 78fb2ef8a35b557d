"""The air gap under a platform that bends: the force that bends it grows as the gap closes."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.errors import ConfigError, FieldError
from motionlab.motor_design.fem.circuit import circuit
from motionlab.motor_design.fem.force_map import ForceMap
from motionlab.motor_design.fem.geometry import Geometry

if TYPE_CHECKING:
    from motionlab.motor_design.platform.bending import Plate

_GAPS = (1.0, 0.75, 0.5)
"""Shares of the gap at which the circuit is evaluated; a parabola is drawn through the results."""

_TOLERANCE = 1e-12  # m
_STEPS_MOST = 200
_HALF_PITCH = 13  # positions of the circuit

Array = NDArray[np.float64]


class Gaps(NamedTuple):
    """Air gaps of four movers below a platform."""

    forces: Array  # N, towards the stator
    closed: Array  # m, by which each gap is smaller
    steps: int  # of the iteration


class Ratio(NamedTuple):
    """Forces over their value at the full gap, as parabolas in the share of it that has closed."""

    normal: Array  # 1, coefficients, highest first
    thrust: Array  # of the largest thrust


def ratio(geometry: Geometry, position: float, current: float) -> Ratio:
    """Return how normal force and largest thrust grow as a gap closes, by the magnetic circuit.

    Parameters
    ----------
    geometry : Geometry
        Of one phase, its gap open.
    position : float
        x, m, at which the normal force is meant.
    current : float
        A, above 0.
    """
    x = abs(position - geometry.tau * round(position / geometry.tau))
    text = geometry.model_dump_json()
    forces = np.array([_forces(text, share, x, current) for share in _GAPS])
    closed = 1 - np.array(_GAPS)
    normal, thrust = (np.polyfit(closed, forces[:, k] / forces[0, k], 2) for k in range(2))
    return Ratio(normal, thrust)


@functools.lru_cache(maxsize=64)
def _forces(
    geometry_text: str, share: float, position: float, current: float
) -> tuple[float, float]:
    """Return normal force at a position and largest thrust, N, with a share of the gap."""
    geometry = Geometry.model_validate_json(geometry_text)
    half = np.linspace(0.0, geometry.tau / 2, _HALF_PITCH)
    narrow = geometry.model_copy(update={"g": geometry.g * share})
    tables = circuit(narrow, half, np.array([0.0, current / 2, current]))
    normal = float(np.interp(position, half, tables[:, -1, 3]))
    return normal, float(np.max(np.abs(tables[:, -1, 2])))


def closing(  # noqa: PLR0913 - the platform, and what pulls at it
    plate: Plate, force_map: ForceMap, grows: Ratio, *, position: float, current: float, name: str
) -> Gaps:
    """Return forces and gaps at which platform and movers are in balance.

    Fixed-point iteration of ``delta = C F(g - delta)`` with the plate's compliance C and the map's
    normal force, which follows the gap as the magnetic circuit's does.

    Parameters
    ----------
    plate : Plate
        The platform.
    force_map : ForceMap
        Of one phase; each mover pulls with its normal force.
    grows : Ratio
        See `ratio`.
    position, current : float
        Where on the map, m and A.
    name : str
        Field of the platform, for errors.

    Raises
    ------
    ConfigError
        If the gap closes further than the circuit was evaluated for.
    """
    gap = force_map.document.geometry.g
    open_force = float(force_map.normal_force(position, current))
    compliance, closed = plate.compliance, np.zeros(4)
    deepest = 1 - _GAPS[-1]
    forces: Array = np.zeros(4)
    steps = 0
    while steps < _STEPS_MOST:
        steps += 1
        forces = np.asarray(open_force * np.polyval(grows.normal, closed / gap), dtype=float)
        deflections = compliance @ forces
        if np.max(deflections) > deepest * gap:
            raise ConfigError(
                FieldError(
                    name,
                    "is too soft: under the movers' normal forces the gap closes by",
                    float(np.max(deflections)),
                    unit="m",
                    bounds={"maximum": float(deepest * gap)},
                )
            )
        change, closed = float(np.max(np.abs(deflections - closed))), deflections
        if change < _TOLERANCE:
            break
    return Gaps(forces, closed, steps)
