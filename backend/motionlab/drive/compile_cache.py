"""Where compiled code of the drive link is kept: beside the kernels, under a hash of its own.

What it compiles calls the model, so its folder lies in the model's; the hash that names the model
in records of runs does not depend on it.
"""

from __future__ import annotations

import contextlib
import hashlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numba
from numba.core import config

from motionlab.lanes.compiler.cache import cache_folder

_PACKAGE = Path(__file__).resolve().parent


def source_hash(*patterns: str) -> str:
    """Return a hash of the files of this package that match, 16 hexadecimal digits."""
    digest = hashlib.sha256()
    for pattern in patterns:
        for path in sorted(_PACKAGE.glob(pattern)):
            digest.update(path.relative_to(_PACKAGE).as_posix().encode())
            digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


class Kept:
    """Decorators of functions whose compiled code is kept.

    `patterns` name the files of this package whose change compiles anew: all that hold what the
    functions call.
    """

    def __init__(self, name: str, *patterns: str) -> None:
        self._folder = str(cache_folder() / f"{name}-{source_hash(*patterns)}")

    def function(self, function: Any) -> Any:
        """Compile a function for Python to call, which then runs without Python's lock."""
        with self._cache():
            return numba.njit(error_model="numpy", nogil=True, cache=True)(function)

    def callback(self, signature: Any) -> Callable[[Any], Any]:
        """Return a decorator that compiles a function for compiled code to call by its address."""

        def decorate(function: Any) -> Any:
            with self._cache():
                return numba.cfunc(signature, error_model="numpy", cache=True)(function)

        return decorate

    @contextlib.contextmanager
    def _cache(self) -> Iterator[None]:
        model: Any = config
        before = model.CACHE_DIR
        model.CACHE_DIR = self._folder  # numba reads it when it decorates, and not again
        try:
            yield
        finally:
            model.CACHE_DIR = before
