"""Force maps computed: presets, and a whole pitch from half of it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.motor_design.fem.circuit import circuit
from motionlab.motor_design.fem.force_map import (
    ForceMap,
    ForceMapDocument,
    PresetName,
    content_hash,
)
from motionlab.motor_design.fem.geometry import Geometry
from motionlab.motor_design.fem.mesh import Resolution
from motionlab.motor_design.fem.workers import FieldTask, Progress, fields

CURRENTS = 10
"""Steps of current from 0 to the largest."""

POSITIONS = 24
"""Least number of steps of position in a pitch."""

Array = NDArray[np.float64]


class MapPreset(NamedTuple):
    """Resolution and method of a force map."""

    resolution: Resolution | None  # None: magnetic circuit
    method: str


PRESETS: dict[PresetName, MapPreset] = {
    "preview": MapPreset(None, "magnetic circuit with the gap's permeances by finite elements"),
    "default": MapPreset(Resolution(24, 2), "finite elements, quadratic, 24 cells a pitch"),
    "reference": MapPreset(Resolution(48, 2), "finite elements, quadratic, 48 cells a pitch"),
}


def compute(
    geometry: Geometry,
    preset: PresetName = "default",
    *,
    resolution: Resolution | None = None,
    workers: int | None = None,
    progress: Progress | None = None,
) -> ForceMap:
    """Return the force map of a geometry.

    Half a pitch is computed, the other half is its mirror image.

    Parameters
    ----------
    geometry : Geometry
        Of one phase.
    preset : {"preview", "default", "reference"}
        Accuracy and computation time.
    resolution : Resolution, optional
        In place of the preset's; noted in the map's ``method``.
    workers : int, optional
        Processes; as many as there are cores, four at most, when left out. One computes here.
    progress : callable, optional
        Called with the share that is done. What it raises cancels the work and is passed on.

    Raises
    ------
    NoConvergence
        If a field is not found.
    WorkerLost
        If a worker process was killed.
    """
    chosen = PRESETS[preset]
    currents = np.linspace(0.0, geometry.i, CURRENTS + 1)
    resolution = resolution or chosen.resolution
    method = chosen.method
    if resolution is None:
        half = np.linspace(0.0, geometry.tau / 2, POSITIONS // 2 + 1)
        tables = circuit(geometry, half, currents)
    else:
        if resolution != chosen.resolution:
            kind = "linear" if resolution.order == 1 else "quadratic"
            method = f"finite elements, {kind}, {resolution.cells} cells a pitch"
        work = FieldTask(geometry, resolution, currents, _shifts(resolution))
        tables = np.array(fields(work, workers=workers, progress=progress))
    return ForceMap(_document(geometry, preset, method, currents, tables))


def _shifts(resolution: Resolution) -> list[int]:
    """Return the shifts of half a pitch, from aligned to unaligned."""
    half = (resolution.cells + 1) // 2
    stride = max(
        d for d in range(1, half + 1) if half % d == 0 and half // d >= min(half, POSITIONS // 2)
    )
    return list(range(0, half + 1, stride))


def _document(
    geometry: Geometry, preset: PresetName, method: str, currents: Array, half: Array
) -> ForceMapDocument:
    """Return a whole pitch: even in x, but for the thrust, which is odd."""
    tables = np.concatenate([half[:0:-1] * [1, 1, -1, 1], half])
    coenergy, linkage, thrust, normal = (tables[:, :, k].tolist() for k in range(4))
    tau = geometry.tau
    return ForceMapDocument(
        preset=preset,
        method=method,
        content_hash=content_hash(geometry, preset),
        geometry=geometry,
        positions=np.linspace(-tau / 2, tau / 2, len(tables)).tolist(),
        currents=currents.tolist(),
        coenergy=coenergy,
        linkage=linkage,
        thrust=thrust,
        normal_force=normal,
    )
