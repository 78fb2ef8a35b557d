"""Force maps on request: a stored one, or else computed and stored."""

from __future__ import annotations

from motionlab.config.named_configs import data_root
from motionlab.errors import FieldError
from motionlab.motor_design.fem.compute import PRESETS, Progress, compute
from motionlab.motor_design.fem.document import MapEntry, MapRequest, entry
from motionlab.motor_design.fem.force_map import ForceMap, PresetName
from motionlab.motor_design.fem.geometry import Geometry
from motionlab.motor_design.fem.mesh import vertices
from motionlab.motor_design.fem.picture import RESOLUTION
from motionlab.motor_design.kept_maps import MapStore, shipped_file


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
        See `motionlab.motor_design.fem.compute.compute`.
    StoreError
        If it cannot be kept; `StoreFull`, before it is computed, where there is no room.
    """
    kept_map = store.find(geometry, preset)
    if kept_map is not None:
        return kept_map, True
    store.check_room()
    made = compute(geometry, preset, workers=workers, progress=progress)
    store.keep(made)
    return made, False


def kept_maps() -> MapStore:
    """Return the store of computed maps."""
    return MapStore(data_root() / "maps")


def run(plan: MapRequest, progress: Progress | None = None) -> ForceMap:
    """Return the map of a request, which is then kept."""
    return computed_or_kept(kept_maps(), plan.geometry, plan.preset, progress=progress)[0]


def document(force_map: ForceMap) -> MapEntry:
    """Return a map's document without its tables."""
    digest = force_map.document.content_hash
    shipped = shipped_file(digest)
    return entry(force_map, name=shipped.stem if shipped else digest, shipped=shipped is not None)


def too_many_nodes(geometry: Geometry, preset: PresetName, most: int) -> list[FieldError]:
    """Return an error for a geometry whose long thin parts take too many nodes, else none."""
    count = vertices(geometry, PRESETS[preset].resolution or RESOLUTION)
    if count <= most:
        return []
    message = "takes too many nodes of a mesh; its heights are large against tau"
    return [FieldError("geometry", message, count, f"<= {most}")]
