"""The compiled kernel against its plain-Python self, over every law and switch."""

from __future__ import annotations

import os
import subprocess
import sys
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.kernel import every_law
from tests.kernel.lane_runs import channel
from tests.paths import ROOT

Arrays = dict[str, NDArray[Any]]


BOUND = 1e-11
"""Largest difference of a state, relative to the largest such state of the eight lanes.

The compiler fuses multiplications with additions and shares reciprocals, so operations differ by
one rounding, 1e-16. Differencing the position twice multiplies that by 1/(v T_s), about 1e3; the
closed loop forgets it again. 1e-12 was measured. A rounding that moved an encoder count would break
the bound; the odds are one in a million ticks.
"""


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> Arrays:
    file = tmp_path_factory.mktemp("plain") / "samples.npz"
    subprocess.run(
        [sys.executable, "-m", "tests.kernel.every_law", str(file)],
        cwd=ROOT,
        env=os.environ | {"NUMBA_DISABLE_JIT": "1"},
        check=True,
    )
    with np.load(file) as arrays:
        return dict(arrays)


@pytest.fixture(scope="module")
def compiled() -> Arrays:
    return every_law.results()


def test_the_ride_is_rough(compiled: Arrays) -> None:
    """Laws, limits and end stop all have something to do, or the comparison would say little."""
    samples = compiled["exact_samples"]
    assert (channel(samples, "force_saturated") > 0.0).any()
    assert (channel(samples, "current_saturated") > 0.0).any()
    assert (np.abs(channel(samples, "position")[:, 4]) > 0.0148).any()
    assert (np.abs(channel(samples, "K")[:, [0, 2, 3]]).max(axis=0) > 1e-5).all()
    assert np.abs(channel(compiled["published_samples"], "K")).max() > 1e-3
    assert (np.abs(channel(compiled["reversed_samples"], "K")).max(axis=0) > 1e-4).all()
    assert np.isfinite(samples).all()


@pytest.mark.parametrize("case", ["exact", "counts", "published", "reversed", "tables", "effects"])
def test_compiled_kernel_agrees_with_plain_python(
    case: str, plain: Arrays, compiled: Arrays
) -> None:
    state = f"{case}_state"
    scale = np.abs(plain[state]).max(axis=1, keepdims=True)
    assert (np.abs(compiled[state] - plain[state]) <= BOUND * scale).all()

    samples = f"{case}_samples"
    single = np.finfo(np.float32).eps  # samples may round to neighbouring single floats
    scale = np.abs(plain[samples]).max(axis=(0, 2), keepdims=True)
    assert (np.abs(compiled[samples] - plain[samples]) <= single * scale).all()
