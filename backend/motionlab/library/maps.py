"""Force maps: those that ship with the project, and those that were computed."""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import NamedTuple

from motionlab.config.named_configs import is_name
from motionlab.errors import ConfigError, Shipped
from motionlab.files import Summaries
from motionlab.library.named_documents import NamedDocuments, removed_file
from motionlab.motor_design.fem.document import MapEntry, entry
from motionlab.motor_design.fem.force_map import ForceMap
from motionlab.motor_design.kept_maps import folders, map_file, map_in, read_map


class LibraryMap(NamedTuple):
    """A map, and whether it ships with the project."""

    shipped: bool
    force_map: ForceMap


class ForceMaps(NamedDocuments[MapEntry, LibraryMap]):
    """Force maps by name; `motionlab.motor_design.kept_maps` keeps and bounds computed ones."""

    def __init__(self) -> None:
        super().__init__("map", "maps")

    def all(self) -> list[MapEntry]:
        """Return the entries of all maps that can be read, those that ship first, then by name."""
        entries: dict[str, MapEntry] = {}
        for folder, shipped in folders():
            for path in sorted(folder.glob("*.json")):
                if not is_name(path.stem) or path.stem in entries:
                    continue
                with contextlib.suppress(OSError):  # deleted since, or a link to itself
                    if (known := _ENTRIES.of(path)) is not None:
                        entries[path.stem] = known.model_copy(update={"shipped": shipped})
        return list(entries.values())

    def get(self, name: str) -> LibraryMap:
        """Return a map."""
        file = map_file(name)
        if file is None:
            raise self.unknown(name)
        return LibraryMap(file.shipped, read_map(file.path))

    def _removed(self, name: str) -> bool:
        file = map_file(name)
        if file is not None and file.shipped:
            raise Shipped(f"{name!r} ships with the project and cannot be deleted")
        return file is not None and removed_file(file.path)


def _entry(path: Path) -> MapEntry | None:
    try:
        return entry(map_in(path, str(path)), name=path.stem, shipped=False)
    except ConfigError:  # damaged
        return None


_ENTRIES = Summaries(_entry, most=4000)
