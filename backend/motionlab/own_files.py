"""Python files of one's own, of folders and of installed packages, that the lab takes as its own.

A file that cannot be taken is a `DeclarationError` with its place; the others are not concerned.
"""

from __future__ import annotations

import importlib.metadata
import importlib.util
import json
import linecache
import os
import re
import sys
import traceback
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

from motionlab.declarations import DeclarationError, check_owner
from motionlab.errors import FieldError

VARIABLE = "MOTIONLAB_LAWS"
"""Of the environment: folders and files of laws and effects of one's own, joined as in PATH."""
ACCEPTED = "MOTIONLAB_LAWS_ACCEPTED"
"""Of the environment: versions of laws that a server has taken, `motionlab.own_laws.accepted`."""
ENTRY_POINTS = "motionlab.laws"
"""Group of entry points of packages that have laws or effects."""

SIZE_MAX = 2**20
"""Largest file, bytes."""


@dataclass(frozen=True)
class OwnFile:
    """A file that may declare something, and how it is imported.

    Attributes
    ----------
    path : Path
        The file.
    module : str
        Name under which it is imported where it is part of an installed package; empty elsewhere.
    version : str
        What tells another version of the same file from it; empty for that which runs.
    """

    path: Path
    module: str = ""
    version: str = ""

    def declared(self, variable: str, text: str | None = None) -> tuple[Any, str]:
        """Return what the file declares in a variable, and the file's text.

        Parameters
        ----------
        variable : str
            Its name.
        text : str, optional
            What the file held in another version; left out, what it holds.

        Raises
        ------
        DeclarationError
            If it cannot be read, run or used as it is declared; with file and line.
        """
        source = self.text() if text is None else text
        module = self._imported(source)
        if hasattr(module, "LAW") and hasattr(module, "EFFECT"):
            message = "is declared beside EFFECT: a file has one of them"
            raise DeclarationError(FieldError("LAW", message, place=str(self.path)))
        owner = getattr(module, variable, None)
        if owner is None:
            raise DeclarationError(
                FieldError(variable, "is not declared by this file", place=str(self.path))
            )
        check_owner(owner, variable, str(self.path))
        return owner, source

    def declares(self, variable: str) -> bool:
        """Return whether the file's text gives a variable a value; the file is not run."""
        try:
            text = self.text()
        except DeclarationError:
            return False
        pattern = rf"^(?:{variable}\b|from\s.*\bimport\b.*\b{variable}\b)"
        return re.search(pattern, text, re.MULTILINE) is not None

    def text(self) -> str:
        """Return what the file holds now.

        Raises
        ------
        DeclarationError
            If it is too large, or cannot be read.
        """
        try:
            if self.path.exists() and not self.path.is_file():  # such as a pipe, which may wait
                raise self._wrong("is no regular file")
            with self.path.open("rb") as file:
                data = file.read(SIZE_MAX + 1)
            if len(data) > SIZE_MAX:
                raise self._wrong("is too large", len(data), f"at most {SIZE_MAX}", "bytes")
            return data.decode("utf-8")
        except (OSError, UnicodeDecodeError) as error:
            raise self._wrong(f"cannot be read: {error}") from error

    def check_syntax(self) -> None:
        """Compile what the file holds, without running it.

        Raises
        ------
        DeclarationError
            If it cannot be read, or is no Python; with file and line.
        """
        try:
            compile(self.text(), str(self.path), "exec")
        except (SyntaxError, ValueError) as error:
            raise DeclarationError(self.raised(error)) from error

    def imported(self) -> ModuleType:
        """Import what the file holds.

        Raises
        ------
        DeclarationError
            If it cannot be read or run; with file and line.
        """
        return self._imported(self.text())

    def _wrong(self, message: str, *of_value: Any) -> DeclarationError:
        return DeclarationError(
            FieldError(self.path.stem, message, *of_value, place=str(self.path))
        )

    def _imported(self, source: str) -> ModuleType:
        # Whoever looks at the source later has that of the version that runs, whatever the file
        # holds by then: an entry without a time is kept.
        lines = source.splitlines(keepends=True)
        place = f"{self.path}{self.version}"
        linecache.cache[place] = len(source), None, lines, place
        try:
            if self.module:
                return importlib.import_module(self.module)
            # Without a dot: compiled code refers to records of the file by the module's name.
            name = f"motionlab_own_{self.path.stem}_{zlib.crc32(os.fsencode(place)):08x}"
            spec = importlib.util.spec_from_loader(name, loader=None, origin=str(self.path))
            module = importlib.util.module_from_spec(spec)  # pyright: ignore[reportArgumentType]
            module.__file__ = place
            sys.modules[name] = module
            exec(compile(source, place, "exec"), module.__dict__)
            return module
        except DeclarationError:
            raise
        except (Exception, SystemExit) as error:
            raise DeclarationError(self.raised(error)) from error

    def raised(self, error: BaseException) -> FieldError:
        """Return an error of importing or running the file, with the line that it arose in."""
        if isinstance(error, SyntaxError):
            line, reason = error.lineno, error.msg
        else:
            frames = traceback.extract_tb(error.__traceback__)
            lines = [each.lineno for each in frames if each.filename == str(self.path)]
            line, reason = (lines or [None])[-1], str(error)
        place = str(self.path) if line is None else f"{self.path}:{line}"
        return FieldError(self.path.stem, f"{type(error).__name__}: {reason}", place=place)


def own_files(paths: str, group: str) -> Iterator[OwnFile]:
    """Yield the files of folders, and those that installed packages name, in the order of names.

    Parameters
    ----------
    paths : str
        Folders and files, joined as in PATH. Files whose name begins with ``_`` or ``.`` are left
        out, as are folders that do not exist.
    group : str
        Group of entry points whose values name modules.
    """
    yield from map(OwnFile, files_in(paths))
    for point in sorted(importlib.metadata.entry_points(group=group)):
        spec = importlib.util.find_spec(point.module)
        if spec is not None and spec.origin is not None:
            yield OwnFile(Path(spec.origin), point.module)


def files_in(paths: str) -> Iterator[Path]:
    """Yield the files of folders, in the order of names, and files; as `own_files` takes them."""
    for text in filter(None, paths.split(os.pathsep)):
        path = Path(text)
        files = [path] if path.is_file() else sorted(path.glob("*.py"))
        yield from (file for file in files if file.name[0] not in "._")


def accepted_versions() -> dict[str, tuple[str, str, str]]:
    """Return the versions of laws that the server has taken, in the order of the first of each.

    Returns
    -------
    dict of str to (str, str, str)
        By name: text that runs, text of the version before, and path of the file.
    """
    copies: dict[str, list[str]] = json.loads(os.environ.get(ACCEPTED, "{}"))
    return {
        name: (Path(text).read_text("utf-8"), Path(before).read_text("utf-8"), path)
        for name, (text, before, path) in copies.items()
    }
