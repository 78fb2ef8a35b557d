"""Files in the conventions of other programs: right lengths, notes, refusals."""

from __future__ import annotations

import tomllib
import warnings
from pathlib import Path

import numpy as np
import pytest

from motionlab.config.drawn_path import DrawnPath
from motionlab.config.samples import Samples
from motionlab.config.trajectory import Sequence
from motionlab.errors import ConfigError
from motionlab.exchange.paths.reading import ReadOptions, read_trajectory
from motionlab.trajectories.spline import cubics

FOLDER = Path(__file__).parent.parent / "fixtures" / "foreign" / "trajectories"
EXPECTED = tomllib.loads((FOLDER / "expected.toml").read_text(encoding="utf-8"))
FILES = sorted(path.name for path in FOLDER.iterdir() if path.name != "expected.toml")
TOLERANCE = 1e-4  # of the length: the path leaves the drawing by 5 um at most


def length(trajectory: DrawnPath | Sequence) -> float:
    if isinstance(trajectory, Sequence):
        return sum(length(part) for part in trajectory.parts if isinstance(part, DrawnPath))
    control = cubics(trajectory.points, closed=trajectory.closed, corners=trajectory.corners)
    u = np.linspace(0.0, 1.0, 501)[:, None, None]
    w = 1.0 - u
    a, b, c, d = (control[:, i] for i in range(4))
    places = w**3 * a + 3 * w**2 * u * b + 3 * w * u**2 * c + u**3 * d
    return float(np.hypot(*np.moveaxis(np.diff(places, axis=0), 2, 0)).sum())


def test_every_file_has_its_values() -> None:
    assert sorted(EXPECTED) == FILES


@pytest.mark.parametrize("name", FILES)
def test_a_file_of_another_program(name: str) -> None:
    expected = EXPECTED[name]
    content = (FOLDER / name).read_bytes()
    # Cases about a length do not depend on where the drawing lies.
    options = ReadOptions(placement="file" if "first" in expected else "centre")
    if "refused" in expected:
        with pytest.raises(ConfigError, match=expected["refused"]):
            read_trajectory(content, options, name=name)
        return
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = read_trajectory(content, options, name=name)
    if "same" in expected:
        other = read_trajectory((FOLDER / expected["same"]).read_bytes(), options, name=name)
        assert found.trajectory == other.trajectory
    else:
        tolerance = expected.get("tol", TOLERANCE)
        assert not isinstance(found.trajectory, Samples)
        assert 1e3 * length(found.trajectory) == pytest.approx(expected["length"], rel=tolerance)
    for note in expected.get("notes", []):
        assert note in "; ".join(found.notes)
    path = found.trajectory
    if isinstance(path, DrawnPath):
        assert path.v_max == pytest.approx(expected.get("speed", path.v_max))
        first = expected.get("first", np.multiply(1e3, path.points[0]))
        assert np.multiply(1e3, path.points[0]) == pytest.approx(first)
