"""The hash of the model: of every source that goes into the kernel.

It names the model in records of runs, and the folder of compiled code.
"""

from __future__ import annotations

import functools
import hashlib
from pathlib import Path

PACKAGE = Path(__file__).resolve().parent.parent
SOURCES = (
    "timing.py",
    "control/*.py",
    "motor_design/fem/cells.py",
    "force_sharing/*.py",
    "kernel/accumulator.py",
    "kernel/law_calls.py",
    "kernel/layout.py",
    "kernel/score.py",
    "kernel/tick.py",
    "lanes/*.py",
    "lanes/compiler/*.py",
    "laws/*.py",
    "plant/*.py",
    "telemetry/channels.py",
)
"""Patterns of the model's sources, from the package."""


@functools.cache
def model_hash() -> str:
    """Return a hash of the sources of the model, 16 hexadecimal digits."""
    digest = hashlib.sha256()
    for pattern in SOURCES:
        for path in sorted(PACKAGE.glob(pattern)):
            digest.update(path.relative_to(PACKAGE).as_posix().encode())
            digest.update(path.read_bytes())
    return digest.hexdigest()[:16]
