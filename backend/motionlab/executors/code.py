"""The code that a process runs: sources and processor, which decide the bits of a result."""

from __future__ import annotations

import functools
import hashlib
from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple

from numba.core.registry import cpu_target

from motionlab import __version__
from motionlab.config.named_configs import config_root
from motionlab.errors import MotionLabError
from motionlab.lanes import model_hash


class OtherCode(MotionLabError):
    """A worker whose sources are not ours, or whose processor is not that of the others."""


class Code(NamedTuple):
    """Hashes of the model, of all sources and shipped configs; the processor compiled for."""

    model: str
    sources: str
    processor: str

    @classmethod
    def here(cls) -> Code:
        """Return that of this process."""
        return cls(model_hash(), _source_hash(), processor())

    def check(self, worker: str, own: Code) -> None:
        """Refuse a worker whose own code is another one.

        Raises
        ------
        OtherCode
            Naming the worker and what differs.
        """
        if own.processor != self.processor:
            raise OtherCode(
                f"worker {worker} compiles for {own.processor}, others for {self.processor}: bits "
                "would differ; set NUMBA_CPU_NAME and NUMBA_CPU_FEATURES alike for all workers"
            )
        if own != self:
            differs = "model" if own.model != self.model else "sources"
            theirs, ours = getattr(own, differs), getattr(self, differs)
            raise OtherCode(
                f"worker {worker} runs another motionlab: hash of its {differs} {theirs}, ours "
                f"{ours}; install motionlab {__version__} of the same sources there and here"
            )


def processor() -> str:
    """Return the processor that code is compiled for, and a hash of its features."""
    context: Any = cpu_target.target_context
    _, name, features = context.codegen().magic_tuple()
    return f"{name} ({hashlib.sha256(features.encode()).hexdigest()[:8]})"


@functools.cache
def _source_hash() -> str:
    package = Path(__file__).resolve().parent.parent
    digest = hashlib.sha256()
    built = package / "_version.py"  # another number does not make it other code
    _add(digest, package, (path for path in package.rglob("*.py") if path != built))
    for pattern in ("*.toml", "maps/*.json"):
        _add(digest, config_root(), config_root().rglob(pattern))
    return digest.hexdigest()[:16]


def _add(digest: Any, root: Path, paths: Iterable[Path]) -> None:
    for path in sorted(paths):
        digest.update(path.relative_to(root).as_posix().encode())
        digest.update(path.read_bytes())
