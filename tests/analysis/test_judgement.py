"""What comparisons look at and tolerate where nobody says so, and their verdicts as sentences."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from motionlab.analysis.comparison_document import Comparison
from motionlab.analysis.comparison_options import Comparing
from motionlab.analysis.judgement import sensible, short_name, telling
from motionlab.analysis.run_comparison import compare
from tests.library.test_compare import file_of

T = 0.0005
TIMES = np.arange(8000) * T
ERROR = 10e-6 * np.sin(2 * np.pi * TIMES)


def noise(seed: int, sigma: float) -> NDArray[np.float64]:
    return np.random.default_rng(seed).normal(0.0, sigma, len(TIMES))


def compared(folder: Path, second: NDArray[Any], **how: Any) -> Comparison:
    columns = {"B.x.following_error": ERROR + noise(1, 0.1e-6), "B.x.thrust": 10 * TIMES}
    other = columns | {"B.x.following_error": second}
    a, b = (
        file_of(folder / name, each)
        for name, each in (("a.parquet", columns), ("b.parquet", other))
    )
    return compare(a, b, Comparing(**how))


def test_two_runs_of_the_same_agree_in_spite_of_noise(tmp_path: Path) -> None:
    found = compared(tmp_path, ERROR + noise(2, 0.1e-6))
    assert found.holds
    assert found.headline.startswith("agrees within 0.")
    assert found.headline.endswith("% RMS on 2 of 2")
    assert not compared(tmp_path, ERROR + noise(2, 0.1e-6), exact=True).holds


def test_a_bump_is_named_with_size_and_place(tmp_path: Path) -> None:
    bump = 3.9e-6 * (np.abs(TIMES - 2.0) < 0.01)
    found = compared(tmp_path, ERROR + bump)
    assert not found.holds
    assert found.headline.startswith("differs: e_x by 4")
    assert found.headline.endswith("s, 1 of 2 channels beyond tolerance")
    assert found.channels[0].at is not None
    assert found.channels[0].at.time == pytest.approx(2.0, abs=0.01)


def test_equal_runs_are_identical(tmp_path: Path) -> None:
    found = compared(tmp_path, ERROR + noise(1, 0.1e-6))
    assert found.headline == "identical on 2 of 2"
    first = compared(tmp_path, ERROR + noise(1, 0.1e-6), end=0.0)
    assert first.headline == "identical on 2 of 2, in 1 instant only"


def test_a_tolerance_follows_range_noise_and_count() -> None:
    smooth = sensible(ERROR, ERROR)
    assert smooth.absolute == pytest.approx(0.02 * 20e-6, rel=0.01)
    assert sensible(ERROR, ERROR + noise(3, 1e-6)).absolute == pytest.approx(6.4e-6, rel=0.05)
    assert sensible(ERROR, ERROR, 50e-9).absolute - smooth.absolute == pytest.approx(50e-9)


def test_channels_that_tell_come_first_and_others_are_left_out() -> None:
    kinds = ("position", "following_error", "K", "force_command", "thrust", "current_a")
    names = [f"B.{axis}.{kind}" for axis in "xy" for kind in kinds]
    assert telling(names) == [
        *("B.x.following_error", "B.y.following_error"),
        *("B.x.force_command", "B.y.force_command"),
        *("B.x.current_a", "B.y.current_a"),
    ]
    assert telling(["M.x.position", "speed"]) == ["M.x.position"]
    assert telling(["speed", "torque"]) == ["speed", "torque"]


@pytest.mark.parametrize(
    ("name", "letters", "short"),
    [
        ("B.y.following_error", {"B"}, "e_y"),
        ("B.y.following_error", {"A", "B"}, "e_y of B"),
        ("A.x.current_b", {"A"}, "i_b x"),
        ("A.x.velocity", {"A"}, "velocity x"),
        ("speed", {"speed"}, "speed"),
    ],
)
def test_channels_have_short_names(name: str, letters: set[str], short: str) -> None:
    assert short_name(name, letters) == short
