"""Trajectories: those that ship, and those of one's own."""

from __future__ import annotations

import contextlib
import hashlib
import re
from pathlib import Path
from typing import Any

from pydantic import BaseModel, Field

from motionlab.config.bounds import FILE_MAX
from motionlab.config.load import validate_trajectory
from motionlab.config.named_configs import parse_text, read
from motionlab.config.trajectory import TrajectoryConfig
from motionlab.errors import ConfigError, FieldError
from motionlab.files import Summaries, opened
from motionlab.library.named_documents import COUNT_MAX, SIZE_MAX, TomlDocuments

_HEAD = 4096  # bytes: what is saved begins with its kind
_KIND = re.compile(r"kind *= *[\"']([a-z-]*)[\"']")


class TrajectoryEntry(BaseModel):
    """One trajectory that is kept."""

    name: str = Field(description="Name")
    shipped: bool = Field(description="Whether it ships with the project and cannot be changed")
    kind: str = Field(description="Kind of motion; empty where the file does not say")


class KeptTrajectory(TrajectoryEntry):
    """A trajectory with its numbers."""

    trajectory: dict[str, Any] = Field(description="As a scenario takes it, every field given")


class Trajectories(TomlDocuments[TrajectoryEntry, KeptTrajectory]):
    """Trajectories that ship, and trajectories of one's own."""

    def __init__(self, count_max: int = COUNT_MAX) -> None:
        super().__init__("trajectories", "trajectory", count_max)

    def entry(self, name: str, *, shipped: bool) -> TrajectoryEntry | None:
        """Return name and kind of a trajectory; None of one that is gone or unreadable."""
        try:
            kind = _KINDS.of(self.path(name))
        except OSError:
            return None
        return TrajectoryEntry(name=name, shipped=shipped, kind=kind)

    def get(self, name: str) -> KeptTrajectory:
        """Return a trajectory, every field given."""
        return self._kept(name, validate_trajectory(self.read(name)))

    def put(self, name: str, table: dict[str, Any]) -> KeptTrajectory:
        """Save a trajectory in the place of the one of its name."""
        self.check_own(name)
        trajectory = validate_trajectory(table)
        self.write(name, trajectory.model_dump(mode="json", exclude_none=True))
        return self._kept(name, trajectory)

    def _kept(self, name: str, trajectory: TrajectoryConfig) -> KeptTrajectory:
        return KeptTrajectory(
            name=name,
            shipped=self.is_shipped(name),
            kind=trajectory.kind,
            trajectory=trajectory.model_dump(mode="json"),
        )


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
    return read("trajectories", source, loc=loc)


def known_path(trajectory: TrajectoryConfig) -> str:
    """Return the name of the shipped or saved trajectory that this one is; empty of another."""
    paths = Trajectories()
    for each in paths.all():
        if each.kind == trajectory.kind:
            with contextlib.suppress(OSError):  # deleted since
                if _SUMS.of(paths.path(each.name)) == _sum(trajectory):
                    return each.name
    return ""


def path_words(trajectory: TrajectoryConfig) -> str:
    """Return what a trajectory without a name is: its kind, and how many points it has."""
    points = getattr(trajectory, "points", None)
    return (
        f"{trajectory.kind} of {len(points)} points"
        if isinstance(points, tuple)
        else trajectory.kind
    )


def _sum(trajectory: TrajectoryConfig) -> str:
    return hashlib.sha256(trajectory.model_dump_json().encode()).hexdigest()


def _sum_in(path: Path) -> str:
    try:
        with opened(path) as file:
            tables = parse_text(file.read(SIZE_MAX + 1), loc=path.stem, size_max=SIZE_MAX)
        return _sum(validate_trajectory(tables))
    except ConfigError:
        return ""


_SUMS = Summaries(_sum_in, most=2 * COUNT_MAX)
"""Sums of the numbers of files."""


def _kind_in(path: Path) -> str:
    """Return the kind of motion of a trajectory's file; empty where the file does not say."""
    if path.stat().st_size > SIZE_MAX:
        return ""
    with opened(path) as file:
        text = file.read(SIZE_MAX + 1)
    kind = _KIND.match(text[:_HEAD].decode("utf-8", "replace"))
    if kind:
        return kind[1]
    try:
        return str(parse_text(text, loc=path.stem, size_max=SIZE_MAX).get("kind", ""))
    except ConfigError:
        return ""


_KINDS = Summaries(_kind_in, most=2 * COUNT_MAX)
