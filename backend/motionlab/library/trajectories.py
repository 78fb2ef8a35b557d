"""Named trajectories as TOML files in one folder."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from motionlab.config.bounds import FILE_MAX
from motionlab.config.shipped import data_root, names, parse_text, read
from motionlab.errors import ConfigError, FieldError
from motionlab.files import Summaries, opened
from motionlab.library.named_tables import FILES_MAX, SIZE_MAX, NamedTables

_HEAD = 4096  # bytes: what is saved begins with its kind
_KIND = re.compile(r"kind *= *[\"']([a-z-]*)[\"']")


def kind_in(path: Path) -> str:
    """Return the kind of motion of a trajectory's file; empty where the file does not say."""
    if path.stat().st_size > SIZE_MAX:
        return ""
    with opened(path) as file:
        text = file.read(SIZE_MAX + 1)
    found = _KIND.match(text[:_HEAD].decode("utf-8", "replace"))
    if found:
        return found[1]
    try:
        return str(parse_text(text, loc=path.stem, size_max=SIZE_MAX).get("kind", ""))
    except ConfigError:
        return ""


KINDS = Summaries(kind_in, most=2 * FILES_MAX)
"""Kinds of motion, by file."""


class TrajectoryStore(NamedTables):
    """Trajectories by name.

    Parameters
    ----------
    folder : Path
        Made when the first trajectory is saved.
    files_max : int
        How many there may be.
    """

    def __init__(self, folder: Path, *, files_max: int = FILES_MAX) -> None:
        super().__init__(folder, "trajectories", files_max=files_max)

    def kind(self, name: str) -> str:
        """Return the kind of motion saved under a name; empty where the file does not say.

        Raises
        ------
        FileNotFoundError
            If nothing is saved under the name, perhaps since this instant.
        """
        return KINDS.of(self.path(name))


def trajectory_table(source: str, loc: str) -> dict[str, Any]:
    """Return the table of a trajectory: a shipped or saved name, or a ``.toml`` file.

    Raises
    ------
    ConfigError
        If there is no such thing, or it cannot be read, naming `loc`.
    """
    if "\0" in source:
        raise ConfigError(FieldError(loc, "holds a zero byte", source))
    if source.endswith(".toml"):
        try:
            with opened(Path(source)) as file:
                return parse_text(file.read(FILE_MAX + 1), loc=loc, size_max=FILE_MAX)
        except OSError as error:
            text = f"cannot be read: {error.strerror}"
            raise ConfigError(FieldError(loc, text, source)) from None
    store = TrajectoryStore(data_root() / "trajectories")
    if source not in names("trajectories") and store.has(source):
        return store.read(source)
    return read("trajectories", source, loc=loc)
