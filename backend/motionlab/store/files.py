"""Files that are whole or not there, and where the user's data lie."""

from __future__ import annotations

import errno
import os
import tempfile
from pathlib import Path

from motionlab.errors import StoreError, StoreFull

_FULL = {errno.ENOSPC, errno.EDQUOT}


def data_root() -> Path:
    """Return the folder of the user's data: MOTIONLAB_DATA, or ``data`` where the server runs."""
    return Path(os.environ.get("MOTIONLAB_DATA") or "data")


def replace(path: Path, content: bytes) -> None:
    """Write a file beside its place and move it there; makes its folder when it is missing.

    Raises
    ------
    OSError
        If that cannot be done; what was there is untouched.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    descriptor, made = tempfile.mkstemp(dir=path.parent, prefix=".", suffix=".part")
    try:
        with os.fdopen(descriptor, "wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        Path(made).replace(path)
    except BaseException:
        Path(made).unlink(missing_ok=True)
        raise


def failure(what: str, error: OSError) -> StoreError:
    """Return what to raise for a file that could not be written."""
    reason = f"{what}: {error.strerror or error}"
    return StoreFull(reason) if error.errno in _FULL else StoreError(reason)
