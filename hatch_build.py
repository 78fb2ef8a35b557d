"""Build hook: wheel and sdist hold what is built by other tools than Python's.

The sdist holds each part where the checkout has it, so a wheel is built from either alike. An
editable install has none: the server finds them in the checkout.
"""

from __future__ import annotations

import os
import subprocess
from pathlib import Path
from typing import Any, NamedTuple

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class Part(NamedTuple):
    """A folder of the package that is built from sources of its own.

    Attributes
    ----------
    name : str
        In messages.
    folder : str
        Where it is built, from the top of the checkout.
    target : str
        Its folder in the package.
    sources : tuple of str
        What it is built from; with `folder` or packages of npm in one, these do not count.
    command : tuple of str
        What builds it.
    remedy : str
        What to do where that fails.
    optional : bool
        Whether it is left out where its sources are not there, as in the image.
    """

    name: str
    folder: str
    target: str
    sources: tuple[str, ...]
    command: tuple[str, ...]
    remedy: str
    optional: bool = False


# The model, which is also compiled for browsers; `make` has the same list file by file.
_MODEL = tuple(
    f"backend/motionlab/{room}"
    for room in ("control", "effects", "force_sharing", "kernel", "lanes", "laws", "plant")
)
PARTS = (
    Part(
        name="page",
        folder="frontend/dist",
        target="motionlab/page",
        sources=("frontend", *_MODEL),
        # The kernel in it is compiled by numba, so it needs more than a build has.
        command=("make", "--silent", "frontend/dist/index.html"),
        remedy="see what `make frontend/dist/index.html` says",
    ),
    Part(
        name="help",
        folder="build/help",
        target="motionlab/help",
        sources=("docs",),
        # It documents the program by importing it, so it needs more than a build has.
        command=("make", "--silent", "docs"),
        remedy="see what `make docs` says",
        optional=True,
    ),
)


class BuiltParts(BuildHookInterface):
    """Add every part to the wheel or the sdist, built anew if its sources are newer."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Name the folders to include; end the build with one line where a part cannot be had."""
        if version == "editable":
            return
        root = Path(self.root)
        for part in PARTS:
            built = (root / part.folder / "index.html").is_file()
            if part.optional and not built and not (root / part.sources[0]).is_dir():
                continue
            problem = None if _is_current(root, part) else _build(root, part)
            if problem:
                self.app.abort(f"motionlab: no {part.name}: {problem}; {part.remedy}")
            target = part.target if self.target_name == "wheel" else part.folder
            build_data["force_include"][str(root / part.folder)] = target


def _is_current(root: Path, part: Part) -> bool:
    index = root / part.folder / "index.html"
    if not index.is_file():
        return False
    built = index.stat().st_mtime
    folders = [root / name for name in part.sources]
    passed_over = {root / part.folder, *(folder / "node_modules" for folder in folders)}
    passed_over |= {path for folder in folders for path in folder.rglob("__pycache__")}
    return all(
        path.stat().st_mtime <= built
        for folder in folders
        for path in folder.rglob("*")
        if path.is_file() and passed_over.isdisjoint(path.parents)
    )


def _build(root: Path, part: Part) -> str | None:
    """Build a part; return why that failed, in a line, or None."""
    # What pip tells the processes of an isolated build is not for the environments that these make.
    foreign = ("PYTHON", "VIRTUAL_ENV", "_PYPROJECT", "PEP517_", "PIP_BUILD_TRACKER")
    environment = {k: v for k, v in os.environ.items() if not k.startswith(foreign)}
    try:
        done = subprocess.run(
            part.command, cwd=root, env=environment, capture_output=True, text=True, check=False
        )
    except OSError as error:
        return f"{part.command[0]}: {error.strerror}"
    if done.returncode == 0 and (root / part.folder / "index.html").is_file():
        return None
    said = (done.stderr or done.stdout).strip().splitlines() or [f"exit code {done.returncode}"]
    reason = next((line for line in said if "rror" in line), said[-1])
    return f"`{' '.join(part.command)}` failed: {reason.strip()}"
