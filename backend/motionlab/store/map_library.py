"""The list of force maps: those that ship with the project, and those that were computed."""

from __future__ import annotations

import functools
from pathlib import Path
from typing import NamedTuple

from motionlab.config.shipped import is_name
from motionlab.design.fem.document import MapEntry, entry
from motionlab.design.fem.force_map import ForceMap
from motionlab.errors import ConfigError, StoreError
from motionlab.store.maps import Stamp, folders, map_file, read_map, stamp


class Found(NamedTuple):
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
            try:
                found[path.stem] = _entry(path, stamp(path), shipped=shipped)
            except (ConfigError, FileNotFoundError):  # damaged, or deleted since this instant
                continue
    return list(found.values())


def find_map(name: str) -> Found | None:
    """Return a map by name; None without one.

    Raises
    ------
    ConfigError
        If its file is damaged.
    """
    file = map_file(name)
    return None if file is None else Found(file.shipped, read_map(file.path))


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
        raise StoreError(f"{name} cannot be deleted: {error.strerror or error}") from error
    return True


@functools.lru_cache(maxsize=2000)
def _entry(path: Path, _stamp: Stamp, *, shipped: bool) -> MapEntry:
    return entry(ForceMap.read(path), name=path.stem, shipped=shipped)
