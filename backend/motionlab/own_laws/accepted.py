"""Versions of files of laws that a server has taken, for the processes that compute for it.

A variable of the environment, which goes with every call of a worker, names a copy of each: a
worker has the versions that the server has, whatever the files hold by then.
"""

from __future__ import annotations

import atexit
import hashlib
import json
import os
import shutil
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from motionlab.errors import FieldError
from motionlab.own_files import ACCEPTED, VARIABLE, OwnFile, accepted_versions, files_in
from motionlab.own_laws.check import check_file

_AT_ONCE = 2


LINKS: set[Path] = set()
"""Files that links in folders lead to: the page does not write them."""
REFUSED: list[FieldError] = []
"""Why files could not be taken when this process began."""
WATCHED: list[str] = []
"""Folders and files that the server looks at, joined as in PATH."""


def accept_files(paths: str) -> list[FieldError]:
    """Check files, and name in MOTIONLAB_LAWS those that can be taken.

    It has to come before anything that imports laws.

    Parameters
    ----------
    paths : str
        Folders and files, joined as in PATH.

    Returns
    -------
    list of FieldError
        Why the others cannot be taken: `REFUSED`.
    """
    WATCHED[:] = [paths]
    named = list(files_in(paths))
    LINKS.update(path.resolve() for path in named if path.is_symlink())
    files = [path.resolve() for path in named]
    with ThreadPoolExecutor(_AT_ONCE) as pool:
        results = dict(zip(files, pool.map(check_file, files), strict=True))
    os.environ[VARIABLE] = os.pathsep.join(
        str(path) for path, result in results.items() if not result.problems
    )
    REFUSED[:] = [problem for result in results.values() for problem in result.problems]
    return REFUSED


def accept(name: str, text: str, before: str, path: Path) -> str:
    """Note that the server has taken a version of a law's file, and which is the one before.

    Returns
    -------
    str
        What `accept_again` takes to go back.
    """
    if not _COPIES:
        _COPIES.append(Path(tempfile.mkdtemp(prefix="motionlab-")))
        atexit.register(shutil.rmtree, _COPIES[0], ignore_errors=True)
    former = os.environ.get(ACCEPTED, "{}")
    versions = [_copy(text), _copy(before), str(path)]
    accept_again(json.dumps(json.loads(former) | {name: versions}))
    return former


def accept_again(versions: str) -> None:
    """Have processes that compute take what `accept` has returned."""
    os.environ[ACCEPTED] = versions


def _copy(text: str) -> str:
    copy = _COPIES[0] / f"{hashlib.sha256(text.encode()).hexdigest()[:16]}.py"
    if not copy.exists():
        copy.write_text(text, encoding="utf-8")
    return str(copy)


def renew_accepted(*, compiles: bool = True) -> None:
    """Take the versions of laws that the server has, in place of those that this process read.

    Parameters
    ----------
    compiles : bool
        Whether to compile them now, rather than when a lane first has them.
    """
    if (versions := os.environ.get(ACCEPTED, "")) == _RENEWED[0]:
        return
    # Only with laws of one's own.
    from motionlab.kernel.law_renewal import LawVersion, Renewal  # noqa: PLC0415
    from motionlab.laws import SOURCES, before_of  # noqa: PLC0415

    others = [
        LawVersion(name, text, before, OwnFile(Path(path)))
        for name, (text, before, path) in accepted_versions().items()
        if (text, before) != (SOURCES.get(name), SOURCES.get(before_of(name)))
    ]
    if others:
        Renewal(others, compiles=compiles).take()
    _RENEWED[0] = versions


_RENEWED = [""]
"""The versions that this process has."""
_COPIES: list[Path] = []
"""The folder of the copies, where there is one."""
