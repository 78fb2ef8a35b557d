"""Curves of runs: what the pyramid gives is what all samples give."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pyarrow import parquet

from motionlab.errors import ConfigError
from motionlab.library.files import RunFiles
from motionlab.library.window import FACTOR, Pyramid, Pyramids, grid, window

RUN = "r-" + "a" * 12
TICKS = 140_001  # more than two pieces, and no multiple of a bin
COLUMNS = ["noise", "gap"]


@pytest.fixture(scope="module")
def samples() -> dict[str, np.ndarray]:
    noise = np.random.default_rng(2019).normal(size=TICKS).astype(np.float32)
    gap = noise[::-1].copy()
    gap[70_000:70_003] = np.nan
    return {"noise": noise, "gap": gap}


@pytest.fixture(scope="module")
def files(samples: dict[str, np.ndarray], tmp_path_factory: pytest.TempPathFactory) -> RunFiles:
    files = RunFiles(str(tmp_path_factory.mktemp("runs")))
    source = Path(files.path(RUN)).with_suffix(".part")
    # Row groups that are no multiple of a piece, as other programs write them.
    parquet.write_table(pa.table(samples), source, row_group_size=50_000)
    files.put(RUN, source)
    return files


@given(data=st.data(), points=st.integers(1, 5000))
def test_every_bin_has_the_extremes_of_its_samples(
    data: st.DataObject, points: int, files: RunFiles, samples: dict[str, np.ndarray]
) -> None:
    start = data.draw(st.integers(0, TICKS - 1))
    stop = data.draw(st.integers(start + 1, TICKS))
    bins = grid(start, stop, points, TICKS)
    assert bins.bins <= points
    assert start - bins.bin < bins.first <= start
    assert stop <= bins.stop < stop + bins.bin
    found = window(files, RUN, COLUMNS, bins)
    for row, name in enumerate(COLUMNS):
        all_of_them = samples[name][bins.first : bins.stop]
        edges = np.arange(0, len(all_of_them), bins.bin)
        assert np.array_equal(found.low[row], np.minimum.reduceat(all_of_them, edges), True)
        assert np.array_equal(found.high[row], np.maximum.reduceat(all_of_them, edges), True)


@given(at=st.integers(0, TICKS - 1), points=st.integers(1, 3000))
def test_a_spike_is_in_every_view_of_the_whole(at: int, points: int) -> None:
    level = np.zeros(-(-TICKS // FACTOR), dtype=np.float32)
    level[at // FACTOR] = 1.0
    upper = np.zeros(-(-len(level) // FACTOR), dtype=np.float32)
    upper[at // FACTOR**2] = 1.0
    zero = np.zeros_like(level), np.zeros_like(upper)
    spiked = Pyramids()
    spiked.put(RUN, "spike", Pyramid(zero, (level, upper)))
    bins = grid(0, TICKS, points, TICKS)
    high = window(RunFiles("nowhere"), RUN, ["spike"], bins, spiked).high[0]
    assert np.flatnonzero(high).tolist() == [at // bins.bin]


def test_pyramids_stay_within_their_bound() -> None:
    one = Pyramid((np.zeros(10, np.float32),), (np.zeros(10, np.float32),))
    pyramids = Pyramids(3 * one.size)
    for name in "abc":
        pyramids.put(RUN, name, one)
    assert pyramids.get(RUN, "a")  # used again: b is the oldest
    pyramids.put(RUN, "d", one)
    assert [name for name in "abcd" if pyramids.get(RUN, name)] == ["a", "c", "d"]
    assert pyramids.size == 3 * one.size
    pyramids.put(RUN, "huge", Pyramid((np.zeros(99, np.float32),), ()))
    assert pyramids.get(RUN, "huge") is None


def test_columns_are_checked_also_where_all_are_in_memory(files: RunFiles) -> None:
    bins = grid(0, TICKS, 100, TICKS)
    window(files, RUN, COLUMNS, bins)
    for wrong in (["noise", "noise"], ["noise", "none"]):
        with pytest.raises(ConfigError, match=r"columns\.1"):
            window(files, RUN, wrong, bins)
