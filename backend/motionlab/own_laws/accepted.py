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
from motionlab.own_files import VARIABLE, own_files
from motionlab.own_laws.check import check_file

ACCEPTED = "MOTIONLAB_LAWS_ACCEPTED"
_AT_ONCE = 2


REFUSED: list[FieldError] = []
"""Why files could not be taken when this process began."""


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
    files = [file.path.resolve() for file in own_files(paths, "")]
    with ThreadPoolExecutor(_AT_ONCE) as pool:
        results = dict(zip(files, pool.map(check_file, files), strict=True))
    os.environ[VARIABLE] = os.pathsep.join(
        str(path) for path, result in results.items() if not result.problems
    )
    REFUSED[:] = [problem for result in results.values() for problem in result.problems]
    return REFUSED


def accept(name: str, text: str) -> None:
    """Note that the server has taken a version of a law's file."""
    if not _COPIES:
        _COPIES.append(Path(tempfile.mkdtemp(prefix="motionlab-")))
        atexit.register(shutil.rmtree, _COPIES[0], ignore_errors=True)
    copy = _COPIES[0] / f"{hashlib.sha256(text.encode()).hexdigest()[:16]}.py"
    copy.write_text(text, encoding="utf-8")
    os.environ[ACCEPTED] = json.dumps(_accepted() | {name: str(copy)})


def renew_accepted() -> None:
    """Take the versions of laws that the server has, in place of those that this process read."""
    if not (copies := _accepted()):
        return
    from motionlab.kernel.law_calls import renew_law  # noqa: PLC0415 - only with laws of one's own
    from motionlab.laws import SOURCES  # noqa: PLC0415

    for name, copy in copies.items():
        text = Path(copy).read_text(encoding="utf-8")
        if text != SOURCES[name]:
            renew_law(name, text)


_COPIES: list[Path] = []
"""The folder of the copies, where there is one."""


def _accepted() -> dict[str, str]:
    """Return the path of a copy for each law that has changed since the server began."""
    return json.loads(os.environ.get(ACCEPTED, "{}"))
