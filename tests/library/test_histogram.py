"""Histograms of a metric over what a search finds."""

from __future__ import annotations

from pathlib import Path

import pytest

from motionlab.errors import ConfigError
from motionlab.library.histogram import EDGES
from motionlab.library.index import Index
from motionlab.library.search import parse
from tests.library.sample_runs import sample

B_X = "B.x.max_abs_following_error"


@pytest.fixture
def index(tmp_path: Path) -> Index:
    index = Index(f"sqlite:///{tmp_path / 'runs.sqlite'}")
    for k, value in enumerate((1.1e-6, 1.2e-6, 2e-6, 50e-6, 0.0, 1e9)):
        index.put(sample(metrics={B_X: value}, tags=["rig"] if k < 3 else [], pinned=k == 0))
    index.put(sample(metrics={B_X: 1e-6}, deleted=1.8e9), sample())
    return index


def test_each_run_is_in_the_bin_of_its_value(index: Index) -> None:
    found = index.histogram(parse("tag:rig"), "B.x.max")
    assert (found.metric, found.total, sum(found.counts)) == (B_X, 3, 3)
    assert (found.least, found.greatest) == (1.1e-6, 2e-6)
    assert len(found.edges) == len(found.counts) + 1
    for value, count in ((1.15e-6, 2), (2e-6, 1)):
        (place,) = (
            i for i in range(len(found.counts)) if found.edges[i] <= value < found.edges[i + 1]
        )
        assert found.counts[place] == count


def test_bounds_of_the_metric_itself_are_left_out_and_others_hold(index: Index) -> None:
    everything = index.histogram(parse(""), "B.x.max")
    assert everything.total == 6  # deleted ones and those without the metric are not counted
    assert index.histogram(parse("B.x.max<1.5um"), "B.x.max") == everything
    assert index.histogram(parse("B.x.rms<1"), "B.x.max").total == 0
    assert index.histogram(parse("is:pinned"), "B.x.max").total == 1
    assert index.histogram(parse("is:deleted"), "B.x.max").total == 1


def test_values_beyond_the_edges_are_in_the_last_bins(index: Index) -> None:
    found = index.histogram(parse(""), "B.x.max")
    assert found.edges[0] == EDGES[0]
    assert found.edges[-1] == EDGES[-1]
    assert (found.counts[0], found.counts[-1]) == (1, 1)


def test_without_runs_it_is_empty_and_other_metrics_are_refused(index: Index) -> None:
    found = index.histogram(parse("nothing"), "B.x.max")
    assert (found.edges, found.counts, found.total) == ([], [], 0)
    assert (found.least, found.greatest) == (None, None)
    with pytest.raises(ConfigError, match="no metric of that name"):
        index.histogram(parse(""), "B.x.size")
