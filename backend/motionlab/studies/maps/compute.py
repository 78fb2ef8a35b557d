"""Force maps on request: the one that was kept, or else computed and kept."""

from __future__ import annotations

from motionlab.design.fem.compute import Progress, compute
from motionlab.design.fem.force_map import ForceMap, PresetName
from motionlab.design.fem.geometry import Geometry
from motionlab.store.maps import MapStore


def computed_or_kept(
    store: MapStore,
    geometry: Geometry,
    preset: PresetName,
    *,
    workers: int | None = None,
    progress: Progress | None = None,
) -> tuple[ForceMap, bool]:
    """Return a map and whether it was kept before; one that has to be computed is kept.

    Raises
    ------
    NoConvergence, WorkerLost
        See `motionlab.design.fem.compute.compute`.
    StoreError
        If it cannot be kept; `StoreFull`, before it is computed, where there is no room.
    """
    found = store.find(geometry, preset)
    if found is not None:
        return found, True
    store.check_room()
    made = compute(geometry, preset, workers=workers, progress=progress)
    store.keep(made)
    return made, False
