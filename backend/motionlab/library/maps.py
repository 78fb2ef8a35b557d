"""The list of force maps: those that ship with the project, and those that were computed."""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import NamedTuple

from motionlab.config.shipped import is_name
from motionlab.errors import ConfigError
from motionlab.files import Summaries, failure
from motionlab.motor_design.fem.document import MapEntry, entry
from motionlab.motor_design.fem.force_map import ForceMap
from motionlab.motor_design.kept_maps import folders, map_file, map_in, read_map


class LibraryMap(NamedTuple):
    """A map, and whether it ships with the project."""

    shipped: bool
    force_map: ForceMap


def map_entries() -> list[MapEntry]:
    """Return all maps that can be read, those that ship first, then by name."""
    found: dict[str, MapEntry] = {}
    for folder, shipped in folders():
        for path in sorted(folder.glob("*.json")):
            if not is_name(path.stem) or path.stem in found:
                continue
            with contextlib.suppress(OSError):  # deleted since this instant, or a link to itself
                known = _ENTRIES.of(path)
                if known is not None:
                    found[path.stem] = known.model_copy(update={"shipped": shipped})
    return list(found.values())


def find_map(name: str) -> LibraryMap | None:
    """Return a map by name; None without one.

    Raises
    ------
    ConfigError
        If its file is damaged.
    """
    file = map_file(name)
    return None if file is None else LibraryMap(file.shipped, read_map(file.path))


def delete_computed(name: str) -> bool:
    """Delete a computed map; return whether there was one.

    Raises
    ------
    StoreError
        If it cannot be deleted.
    """
    file = map_file(name)
    if file is None or file.shipped:
        return False
    try:
        file.path.unlink()
    except FileNotFoundError:
        return False
    except OSError as error:
        raise failure(f"{name} cannot be deleted", error) from error
    return True


def _entry(path: Path) -> MapEntry | None:
    try:
        return entry(map_in(path, str(path)), name=path.stem, shipped=False)
    except ConfigError:  # damaged
        return None


_ENTRIES = Summaries(_entry, most=4000)
