"""Gains that a report copies into parameters of lanes."""

from __future__ import annotations

from typing import Any

import numpy as np

from motionlab.config.load import load_scenario
from motionlab.config.planar import AXES
from motionlab.reports.lane_copies import copied_gains
from motionlab.simulation.lane_run import Known, LaneRun, lane_run
from motionlab.simulation.prepare import prepare

SCHEDULED = {"schedule": [{"time": 1.0, "set": {"variants.A.controller.x.k_p": 3e5}}]}


def numbers(**changes: Any) -> LaneRun:
    prepared = prepare(load_scenario("circle", SCHEDULED | changes))
    return lane_run(prepared, None, prepared.reference.ticks, Known())


def test_a_copied_gain_changes_its_row_and_nothing_else() -> None:
    before = numbers()
    copies = copied_gains(before.prepared)
    assert len(copies) == 7
    assert "variants.A.controller.x.k_p" not in copies
    for number, (path, place) in enumerate(copies.items()):
        value = place["minimum"] + 0.01 * number * (place["maximum"] - place["minimum"])
        after = numbers(**{path: value})
        expected = before.lanes.copy()
        expected[:, place["variant"], place["row"], AXES.index(place["axis"])] = value
        assert np.array_equal(after.lanes, expected), path
        assert np.array_equal(after.state, before.state)
        assert after.keys == before.keys
