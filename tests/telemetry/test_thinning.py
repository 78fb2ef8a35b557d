"""Thinned columns keep extremes and their order."""

from __future__ import annotations

import numpy as np

from motionlab.telemetry.thinning import thinned


def test_two_samples_of_each_bin_in_the_order_of_their_ticks() -> None:
    columns = np.array([[0, 3, -1, 2, 5, 5, 5, 5], [1, 2, 3, 4, 8, 7, 6, 5]], dtype=np.float32)
    assert thinned(columns, 2).tolist() == [[3, -1, 5, 5], [1, 4, 8, 5]]


def test_a_gap_stays_one() -> None:
    column = np.array([[1, np.nan, 3, 4, 5, 6, 7, 8]], dtype=np.float32)
    samples = thinned(column, 2)
    assert np.isnan(samples[0, :2]).all()
    assert samples[0, 2:].tolist() == [5, 8]
