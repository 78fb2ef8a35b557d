"""Configs by kind and name: those that ship, and motors and trajectories of one's own."""

from __future__ import annotations

import difflib
import functools
import os
import re
import tomllib
from pathlib import Path
from typing import Any, Literal

from motionlab.config.bounds import FILE_MAX, check_depth, check_text, check_toml
from motionlab.errors import ConfigError, FieldError

Kind = Literal["motors", "controllers", "trajectories", "scenarios"]

_KINDS: dict[Kind, str] = {
    "motors": "motor",
    "controllers": "shipped controller",
    "trajectories": "trajectory",
    "scenarios": "shipped scenario",
}
_NAME = re.compile("[a-z0-9-]{1,64}")
OWN: tuple[Kind, ...] = ("motors", "trajectories")
"""Kinds that the folder of data holds too; shipped ones win."""

ORIGIN = "origin"
"""Table of a motor's file that tells where its numbers come from; no part of the motor."""

SERVER_LOCK = ".server"
"""File of the folder of data, which a server locks."""

_LISTED_MAX = 40  # names in an error
_WORD_MAX = 100  # characters of a word that is compared with others
_PACKAGE = Path(__file__).resolve().parent.parent


def config_root() -> Path:
    """Return the folder of shipped configs: MOTIONLAB_CONFIGS, the package's, the checkout's.

    Raises
    ------
    ConfigError
        If MOTIONLAB_CONFIGS is no folder.
    """
    override = os.environ.get("MOTIONLAB_CONFIGS")
    if override:
        if not Path(override).is_dir():
            raise ConfigError(FieldError("MOTIONLAB_CONFIGS", "is no folder", override))
        return Path(override)
    installed = _PACKAGE / "configs"
    return installed if installed.is_dir() else _PACKAGE.parent.parent / "configs"


def data_root() -> Path:
    """Return the folder of the user's data.

    MOTIONLAB_DATA; ``data`` in a checkout, and where a server has used it before; elsewhere the
    folder of the user's data that the platform defines.

    Raises
    ------
    ConfigError
        If its name is no text: databases and files of runs have it in their addresses.
    """
    if folder := os.environ.get("MOTIONLAB_DATA"):
        check_text(folder, loc="MOTIONLAB_DATA")
        return Path(folder)
    here = Path("data")
    if _PACKAGE.parent.parent == Path.cwd() or (here / SERVER_LOCK).exists():
        return here
    import platformdirs  # noqa: PLC0415 - most commands do without

    return Path(platformdirs.user_data_dir("motionlab", appauthor=False))


def is_name(text: str) -> bool:
    """Return whether `text` can be the name of a config; a name is never a path."""
    return _NAME.fullmatch(text) is not None


def names(kind: Kind) -> list[str]:
    """Return the names that ship for one kind, sorted."""
    return sorted(path.stem for path in (config_root() / kind).glob("*.toml"))


def own_motors() -> list[str]:
    """Return the names of the motors of one's own that no shipped one has, sorted."""
    return own_names("motors")


def own_names(kind: Kind) -> list[str]:
    """Return the names of one's own of a kind that no shipped one has, sorted."""
    if kind not in OWN:
        return []
    own = {path.stem for path in (data_root() / kind).glob("*.toml") if is_name(path.stem)}
    return sorted(own - set(names(kind)))


def read(kind: Kind, name: str, *, loc: str) -> dict[str, Any]:
    """Return a config, unresolved: a shipped one, or a motor or trajectory of one's own.

    The tables in it are shared and must not be changed.

    Raises
    ------
    ConfigError
        If there is nothing of that name, at `loc`.
    """
    path = config_root() / kind / f"{name}.toml"
    if kind in OWN and is_name(name) and not path.is_file():
        path = data_root() / kind / path.name
    if not is_name(name) or not path.is_file():
        known = names(kind) + own_names(kind)
        raise ConfigError(
            FieldError(
                loc=loc,
                message=f"no {_KINDS[kind]} of that name{did_you_mean(name, known)}",
                value=name,
                range="one of "
                + ", ".join(known[:_LISTED_MAX])
                + (", ..." if len(known) > _LISTED_MAX else ""),
            )
        )
    tables = _parsed(path, path.stat().st_mtime_ns)
    return {key: value for key, value in tables.items() if key != ORIGIN}


@functools.lru_cache(maxsize=64)
def _parsed(path: Path, _changed: int) -> dict[str, Any]:
    return parse(path, loc=f"{path.parent.name}/{path.name}")


def parse(path: Path, *, loc: str = "", size_max: int = FILE_MAX) -> dict[str, Any]:
    """Return the tables of a TOML file of at most `size_max` bytes.

    Raises
    ------
    ConfigError
        If the file cannot be read, is too large or is not TOML, naming `loc` or its path.
    """
    loc = loc or str(path)
    try:
        with path.open("rb") as file:
            text = file.read(size_max + 1)
    except OSError as error:
        message = f"cannot be read: {error.strerror or error}"
        raise ConfigError(FieldError(loc=loc, message=message)) from None
    return parse_text(text, loc=loc, size_max=size_max)


def parse_text(text: bytes, *, loc: str, size_max: int) -> dict[str, Any]:
    """Return the tables of a TOML text in UTF-8.

    Raises
    ------
    ConfigError
        If it is too large or is not TOML, naming `loc`.
    """
    if len(text) > size_max:
        raise ConfigError(
            FieldError(loc, "is too large", unit="bytes", bounds={"maximum": size_max})
        )
    try:
        content = text.decode("utf-8-sig")
        check_toml(content, loc=loc)
        tables = tomllib.loads(content)
    except UnicodeDecodeError as error:
        message = f"is not UTF-8 text: {error.reason} at byte {error.start}"
    except ValueError as error:  # also Python's error on a number of thousands of digits
        message = f"is not TOML: {error}"
    except RecursionError:
        message = "is nested too deeply"
    else:
        check_depth(tables, loc=loc)
        return tables
    raise ConfigError(FieldError(loc=loc, message=message))


def nearest(word: str, known: list[str]) -> str | None:
    """Return the known word that is most alike, if one is alike at all."""
    close = difflib.get_close_matches(word, known, n=1) if len(word) <= _WORD_MAX else []
    return close[0] if close else None


def did_you_mean(word: str, known: list[str]) -> str:
    """Return a hint at the closest known word, or nothing."""
    close = nearest(word, known)
    return f", did you mean {close!r}?" if close else ""
