"""A lab whose package has a file more, or several; nothing else of it differs."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

from tests.paths import ROOT


def lab_with(room: str, folder: Path, *files: Path) -> dict[str, str]:
    """Return the environment of a lab that has files in a room of its package."""
    package = folder / "motionlab"
    ignored = shutil.ignore_patterns("__pycache__")
    shutil.copytree(ROOT / "backend" / "motionlab", package, ignore=ignored)
    shutil.copytree(ROOT / "configs", package / "configs")  # as in a wheel
    for file in files:
        shutil.copy(file, package / room)
    paths = f"{folder}{os.pathsep}{ROOT}"
    data = folder / "data"
    data.mkdir()
    own = {"PYTHONPATH": paths, "NUMBA_CACHE_DIR": str(folder), "MOTIONLAB_DATA": str(data)}
    return os.environ | own


def printed(environment: dict[str, str], *words: str) -> str:
    """Return what a command of that lab prints."""
    command = [sys.executable, "-m", *words]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout
