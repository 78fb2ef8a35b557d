"""Decimation keeps every extreme."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from motionlab.telemetry.decimate import min_max

finite = st.floats(width=32, allow_nan=False)
columns = arrays.arrays(
    np.float32, st.tuples(st.integers(1, 3), st.integers(1, 200)), elements=finite
)


@given(columns=columns, bins=st.integers(1, 300))
def test_every_bin_holds_the_extremes_of_its_ticks(columns, bins):
    low, high = min_max(columns, bins)
    ticks = columns.shape[1]
    size = -(-ticks // bins)
    assert low.shape == high.shape == (len(columns), -(-ticks // size))
    assert low.shape[1] <= bins
    assert low.dtype == high.dtype == np.float32
    for index in range(low.shape[1]):
        part = columns[:, index * size : (index + 1) * size]
        assert np.array_equal(low[:, index], part.min(axis=1))
        assert np.array_equal(high[:, index], part.max(axis=1))


def test_enough_bins_leave_the_samples_as_they_are():
    columns = np.arange(6, dtype=np.float32).reshape(2, 3)
    low, high = min_max(columns, 3)
    assert np.array_equal(low, columns)
    assert np.array_equal(high, columns)


def test_a_single_spike_survives():
    columns = np.zeros((1, 10_000), dtype=np.float32)
    columns[0, 4321] = 1.0
    low, high = min_max(columns, 100)
    assert high.sum() == 1.0
    assert high[0, 43] == 1.0
    assert not low.any()
