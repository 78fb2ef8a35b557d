"""Hashes of sources: of the model, which is the kernel, and of the kernel for browsers.

That of the model stands in records of runs, and names the folder of compiled code.
"""

from __future__ import annotations

import functools
import hashlib
from pathlib import Path

PACKAGE = Path(__file__).resolve().parent.parent
SOURCES = (
    "timing.py",
    "control/*.py",
    "effects/*.py",
    "motor_design/fem/cells.py",
    "force_sharing/*.py",
    "force_sharing/functions/*.py",
    "kernel/accumulator.py",
    "kernel/effect_calls.py",
    "kernel/force_gain.py",
    "kernel/law_calls.py",
    "kernel/layout.py",
    "kernel/motion.py",
    "kernel/move.py",
    "kernel/row_calls.py",
    "kernel/score.py",
    "kernel/tick.py",
    "lanes/*.py",
    "lanes/compiler/*.py",
    "laws/*.py",
    "loop/lane_*.py",
    "loop/matrices.py",
    "plant/*.py",
    "telemetry/channels.py",
)
"""Patterns of the model's sources, from the package."""


MODULE_SOURCES = (
    *SOURCES,
    "analysis/contouring.py",
    "targets/wasm*.py",
    "telemetry/decimate.py",
)
"""Patterns of what the kernel for browsers is made of."""


def model_hash() -> str:
    """Return a hash of the sources of the model, 16 hexadecimal digits."""
    return _hash(SOURCES)


def module_hash() -> str:
    """Return a hash of the sources of the kernel for browsers, 16 hexadecimal digits."""
    return _hash(MODULE_SOURCES)


@functools.cache
def _hash(patterns: tuple[str, ...]) -> str:
    digest = hashlib.sha256()
    for pattern in patterns:
        for path in sorted(PACKAGE.glob(pattern)):
            digest.update(path.relative_to(PACKAGE).as_posix().encode())
            digest.update(path.read_bytes())
    return digest.hexdigest()[:16]
