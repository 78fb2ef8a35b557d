"""Computed force maps, by the hash of their inputs."""

from __future__ import annotations

import functools
import json
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import NamedTuple

from motionlab.config.named_configs import config_root, data_root, did_you_mean, is_name
from motionlab.errors import ConfigError, FieldError, StoreFull
from motionlab.files import Stamp, failure, opened, replace, stamp
from motionlab.motor_design.fem.force_map import SIZE_MOST, ForceMap, PresetName, content_hash
from motionlab.motor_design.fem.geometry import Geometry

FOLDER_MOST = 50_000_000
"""Largest size of all kept maps, bytes; one of the presets takes 25 kB."""


class MapStore:
    """A folder of force maps; deleted maps are computed again.

    Parameters
    ----------
    folder : Path
        Made when the first map is kept.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def check_room(self) -> None:
        """Refuse another map, before it is computed, where no more may be kept.

        Raises
        ------
        StoreFull
            If those that are kept take too much.
        """
        taken = sum(_size(path) for path in self.folder.glob("*.json"))
        if taken >= FOLDER_MOST:
            raise StoreFull(
                f"computed force maps take {taken} bytes, {FOLDER_MOST} are the most; "
                "delete some of them"
            )

    def find(self, geometry: Geometry, preset: PresetName) -> ForceMap | None:
        """Return the map of a geometry that ships or was kept; None without one, or if damaged."""
        digest = content_hash(geometry, preset)
        for path in (shipped_file(digest), self.folder / f"{digest}.json"):
            if path is None or not path.is_file():
                continue
            try:
                kept_map = map_in(path, str(path))
            except ConfigError:
                continue
            document = kept_map.document
            # The geometry too: a file may have been put there by hand.
            if (document.content_hash, document.geometry) == (digest, geometry):
                return kept_map
        return None

    def keep(self, force_map: ForceMap) -> Path:
        """Keep a map; return its file.

        Raises
        ------
        StoreFull
            If those that are kept take too much.
        StoreError
            If it cannot be written.
        """
        self.check_room()
        path = self.folder / f"{force_map.document.content_hash}.json"
        save(force_map, path, loc=f"map {path.stem}", mode=0o600)
        return path


def map_names() -> list[str]:
    """Return the names under which scenarios find a map: those that ship, and those kept."""
    return sorted({path.stem for folder, _ in folders() for path in folder.glob("*.json")} - {""})


def named_map(name: str, loc: str = "force_map") -> ForceMap:
    """Return a map by its name: a shipped one, or a file below ``MOTIONLAB_DATA/maps``.

    Parameters
    ----------
    name : str
        File name without ``.json``; of a computed map the content hash.
    loc : str
        Field that names it, for the error.

    Raises
    ------
    ConfigError
        If there is none of that name, or it cannot be read.
    """
    if name in _lent.get():
        return _lent.get()[name]
    file = map_file(name)
    if file is not None:
        try:
            return read_map(file.path)
        except ConfigError as error:
            raise ConfigError(
                *(FieldError(loc, f"map {name!r} cannot be used: {e}") for e in error.errors)
            ) from None
    known = map_names()
    raise ConfigError(
        FieldError(
            loc=f"{loc}.name",
            message=f"no force map of that name{did_you_mean(name, known)}",
            value=name,
            range="one of " + ", ".join(known) + "; `motionlab map` computes more",
        )
    )


_lent: ContextVar[dict[str, ForceMap]] = ContextVar("lent", default={})  # noqa: B039 - never changed


def kept_in(*tables: object) -> dict[str, ForceMap]:
    """Return the maps that do not ship and that tables may name, for tasks to take along."""
    text = json.dumps(tables)
    kept = {path.stem for folder, ships in folders() if not ships for path in folder.glob("*.json")}
    return {name: named_map(name) for name in sorted(kept) if f'"{name}"' in text}


@contextmanager
def lent(maps: dict[str, ForceMap]) -> Iterator[None]:
    """Let `named_map` find these maps within the block, in any process."""
    token = _lent.set(maps)
    try:
        yield
    finally:
        _lent.reset(token)


class MapFile(NamedTuple):
    """File of a map."""

    path: Path
    shipped: bool


def folders() -> tuple[tuple[Path, bool], ...]:
    """Return where maps lie, and whether those there ship with the project; the first goes."""
    return (config_root() / "maps", True), (data_root() / "maps", False)


def map_file(name: str) -> MapFile | None:
    """Return the file of a map by its name; None without one."""
    if not is_name(name):
        return None
    files = (MapFile(folder / f"{name}.json", shipped) for folder, shipped in folders())
    return next((file for file in files if file.path.is_file()), None)


def shipped_file(content_hash: str) -> Path | None:
    """Return the file of the shipped map of a hash; None where none has it."""
    shipped = sorted((config_root() / "maps").glob("*.json"))
    return next((p for p in shipped if read_map(p).document.content_hash == content_hash), None)


def read_map(path: Path) -> ForceMap:
    """Return the map in a file, which is read again only after it has changed.

    Raises
    ------
    ConfigError
        If it cannot be read or is not a map.
    """
    return _read(path, stamp(path))


@functools.lru_cache(maxsize=32)
def _read(path: Path, _stamp: Stamp) -> ForceMap:
    return map_in(path, f"map {path.stem}")


def map_in(path: Path, where: str) -> ForceMap:
    """Return the map in a file, which errors call `where`.

    Raises
    ------
    ConfigError
        If it cannot be read or is not a map.
    """
    try:
        with opened(path) as file:
            text = file.read(SIZE_MOST + 1)
    except OSError as error:
        raise ConfigError(FieldError(where, error.strerror or str(error))) from None
    force_map = ForceMap.from_text(text, where)
    if path.parent != config_root() / "maps":  # those that ship are tested
        force_map.check_tables(where)
    return force_map


def _size(path: Path) -> int:
    try:
        return path.stat().st_size
    except OSError:  # deleted since it was listed, or a link to itself
        return 0


def save(force_map: ForceMap, path: str | Path, *, loc: str = "", mode: int = 0o644) -> None:
    """Write a map to a file, whole or not at all.

    Parameters
    ----------
    force_map : ForceMap
        What is written.
    path : str or Path
        The file; its folder is made when it is missing.
    loc : str
        Its name in errors; its path when left out.
    mode : int
        Its permissions.

    Raises
    ------
    StoreError
        If it cannot be written; `StoreFull` if the disk is full.
    """
    try:
        replace(Path(path), force_map.text().encode(), mode=mode)
    except OSError as error:
        raise failure(f"{loc or path} cannot be written", error) from error
