"""The same law and experiment as people write it with other tools, beside the lab.

One axis, two seconds, a minimum-jerk move of 20 mm under PD and super-twisting sliding mode, the
nominal motor with an ideal force. python-control and motulator are measured where they are
installed: ``pip install control motulator``.
"""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

from tests.bench.table import Row
from tests.paths import ROOT

_LAW = ROOT / "tests" / "fixtures" / "laws" / "super_twisting.py"
_SCRIPTS = Path(__file__).parent / "own_law"
_NEEDS = {"python_control": "control", "motulator_style": "motulator"}
_LAB = "in_the_lab"
_ROUNDS = 5
_ALIKE = 0.01


def elsewhere() -> Iterator[Row]:
    """Measure each way, and compare its largest error with the lab's."""
    error, seconds = _measured(_LAB)
    yield Row(
        f"own law in the lab, A and B, two axes: {_lines(_LAW)} + {_lines(_file(_LAB))} lines",
        "",
        f"{1e3 * seconds:.1f} ms",
        f"max error {error:.3f} um",
        "1.0",
        True,
    )
    for file in sorted(_SCRIPTS.glob("*.py")):
        if file.stem == _LAB or not _is_there(file.stem):
            continue
        other, other_seconds = _measured(file.stem)
        yield Row(
            f"own law, {file.stem.replace('_', ' ')}, one controller, one axis: "
            f"{_lines(file)} lines",
            "the same error",
            f"{1e3 * other_seconds:.1f} ms",
            f"max error {other:.3f} um",
            f"{other_seconds / seconds:.1f}",
            abs(other / error - 1.0) < _ALIKE,
        )


def _file(name: str) -> Path:
    return _SCRIPTS / f"{name}.py"


def _is_there(name: str) -> bool:
    return name not in _NEEDS or importlib.util.find_spec(_NEEDS[name]) is not None


def _lines(file: Path) -> int:
    """Return the lines that a person writes: neither empty nor comments."""
    lines = map(str.strip, file.read_text(encoding="utf-8").splitlines())
    return sum(bool(line) and not line.startswith("#") for line in lines)


def _measured(name: str) -> tuple[float, float]:
    """Return the largest following error, um, and the least time of an experiment, s."""
    results = [
        subprocess.run(
            [sys.executable, str(_file(name))],
            env=os.environ | {"MOTIONLAB_LAWS": str(_LAW)},
            capture_output=True,
            text=True,
            check=True,
        ).stdout.split()
        for _ in range(_ROUNDS)
    ]
    return float(results[0][0]), min(float(seconds) for _, seconds in results)
