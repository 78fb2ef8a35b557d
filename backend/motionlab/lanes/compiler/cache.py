"""Where compiled code is kept between runs.

numba's cache notices a change in the file of a compiled function but not in the files of the
functions it calls. So the cache lies in a folder named after the hash of the model: a change
anywhere in it compiles anew.
"""

from __future__ import annotations

import atexit
import contextlib
import os
import shutil
import tempfile
from pathlib import Path
from typing import Any

from numba.core import caching, config

from motionlab.lanes.sources import PACKAGE, model_hash


def use_cache() -> None:
    """Have numba keep compiled code under NUMBA_CACHE_DIR, the package, or the user's cache.

    Where none can be written it goes to a private folder that is removed at exit, never to a shared
    one: numba unpickles what it finds, so another user's file would run as code. Damaged files are
    compiled anew; failures to write are ignored.
    """
    chosen = os.environ.get("NUMBA_CACHE_DIR")
    user = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")
    roots = [Path(chosen)] if chosen else []
    roots += [PACKAGE / "__pycache__", Path(user) / "motionlab"]
    folder = next((path for root in roots if (path := _writable(root)) is not None), None)
    if folder is None:
        folder = Path(tempfile.mkdtemp(prefix="motionlab-"))
        atexit.register(shutil.rmtree, folder, ignore_errors=True)
    config.CACHE_DIR = str(folder)  # pyright: ignore[reportAttributeAccessIssue]
    caching.IndexDataCacheFile = _CacheFile


def cache_folder() -> Path:
    """Return the folder where compiled code is kept."""
    return Path(str(config.CACHE_DIR))  # pyright: ignore[reportAttributeAccessIssue]


class _CacheFile(caching.IndexDataCacheFile):
    """Index and data of one function; numba's own class raises on damaged files."""

    def load(self, key: Any) -> Any:
        """Return the cached entry of a key, or None if unreadable."""
        try:
            return super().load(key)
        except Exception:  # damaged bytes make pickle raise anything
            return None

    def save(self, key: Any, data: Any) -> None:
        """Keep data under a key, with a new index where the old one is damaged."""
        with contextlib.suppress(OSError):  # a full disk costs the next start a compilation
            try:
                super().save(key, data)
            except OSError:
                raise
            except Exception:
                self.flush()
                super().save(key, data)


def _writable(root: Path) -> Path | None:
    """Return the model's folder under `root` if it can be written, and only by its owner."""
    folder = root / f"kernel-{model_hash()}"
    try:
        folder.mkdir(mode=0o755, parents=True, exist_ok=True)
        status = folder.stat()
    except OSError:
        return None
    shared = status.st_mode & 0o022 or status.st_uid not in {0, os.getuid()}
    return None if shared or not os.access(folder, os.W_OK) else folder
