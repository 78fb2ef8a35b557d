"""What is checked of a file of studies or views before a server takes it, by a process of its own.

A file is code: it may loop for ever, take all memory or end its process. A child with bounds of
time and memory runs it first: ``python -m motionlab.studies.own_check FILE`` prints JSON.
"""

from __future__ import annotations

import faulthandler
import functools
import importlib
import os
import resource
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from motionlab.errors import FieldError
from motionlab.own_files import own_files
from motionlab.own_laws.check import MEMORY, Checked, as_json, from_json, no_answer
from motionlab.own_studies import VARIABLE

_AT_ONCE = 2
SECONDS = 30.0
"""Time that a file may take to be imported, s."""

REFUSED: list[FieldError] = []
"""Why files could not be taken when this process began."""


def accept_studies(paths: str, *, seconds: float = SECONDS) -> list[FieldError]:
    """Check files, and name in MOTIONLAB_STUDIES those that can be taken.

    It has to come before anything that imports studies or views.

    Parameters
    ----------
    paths : str
        Folders and files, joined as in PATH.
    seconds : float
        Time that each may take, s.

    Returns
    -------
    list of FieldError
        Why the others cannot be taken: `REFUSED`.
    """
    files = [file.path.resolve() for file in own_files(paths, "")]
    with ThreadPoolExecutor(_AT_ONCE) as pool:
        results = pool.map(functools.partial(check_file, seconds=seconds), files)
        problems = {path: each.problems for path, each in zip(files, results, strict=True)}
    taken = (str(path) for path, wrong in problems.items() if not wrong)
    os.environ[VARIABLE] = os.pathsep.join(taken)
    REFUSED[:] = [each for wrong in problems.values() for each in wrong]
    return REFUSED


def check_file(path: Path, *, seconds: float = SECONDS) -> Checked:
    """Check a file in a child process; one that has to be ended is a problem too."""
    done = subprocess.run(
        [sys.executable, "-m", __spec__.name, str(path), str(seconds)],
        env=os.environ | {VARIABLE: str(path)},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        check=False,
    )
    try:
        return from_json(done.stdout)
    except ValueError:
        return no_answer(path, seconds, done.stderr.decode("utf-8", "replace"))


def _main(path: Path, seconds: float) -> None:
    # The lab itself first: its time is none of the file's.
    os.environ[VARIABLE] = ""
    for name in ("studies.study", "config.scenario", "simulation.run"):
        importlib.import_module(f"motionlab.{name}")
    os.environ[VARIABLE] = str(path)
    resource.setrlimit(resource.RLIMIT_DATA, (MEMORY, MEMORY))
    faulthandler.dump_traceback_later(seconds, exit=True)
    stdout, sys.stdout = sys.stdout, sys.stderr  # what the file prints is no answer
    for name in ("studies.table", "analysis.views.table"):
        importlib.import_module(f"motionlab.{name}")
    own: Any = importlib.import_module("motionlab.own_studies")
    problems = (each for each in own.PROBLEMS if each.place.startswith(str(path)))
    print(as_json(Checked("", tuple(problems))), file=stdout)


if __name__ == "__main__":
    _main(Path(sys.argv[1]), float(sys.argv[2]))
