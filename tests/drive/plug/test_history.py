"""Faults and timing of a drive link as they are kept for the Drive screen."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
import pytest

from motionlab.drive.link.readings import FaultNow
from motionlab.drive.link.shared import ROUND_TRIP_BINS, Status
from motionlab.drive.plug.history import DriveHistory

LOST = FaultNow(
    code=0x8700,
    error=0,
    name="link lost",
    subject="link",
    place=0,
    value=10.5,
    limit=10.0,
    unit="ms",
    remedy="Check.",
)


class Loop:
    """What a history reads of a link."""

    def __init__(self) -> None:
        self.counters: dict[Status, int] = dict.fromkeys(Status, 0)
        self.counted = np.zeros(ROUND_TRIP_BINS, np.int64)
        self.latched: FaultNow | None = None

    @property
    def round_trips(self) -> Any:
        return self.counted.copy()

    def status(self, name: Status) -> int:
        return self.counters[name]

    def fault(self) -> FaultNow | None:
        return self.latched


class Clock:
    """Time that a test sets."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now = 100.0
        monkeypatch.setattr(time, "monotonic", lambda: self.now)
        monkeypatch.setattr(time, "time", lambda: 1000.0 + self.now)


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    return Clock(monkeypatch)


def history_of(loop: Any) -> DriveHistory:
    return DriveHistory(loop)


def test_faults_stay_with_when_they_were_reset(clock: Clock) -> None:
    loop = Loop()
    history = history_of(loop)
    history.note()
    assert history.faults == []
    loop.latched = LOST
    history.note()
    clock.now += 0.2
    history.note()
    (fault,) = history.faults
    assert (fault.code, fault.at, fault.reset_at) == (0x8700, 1100.0, None)
    loop.latched = None
    history.note()
    assert history.faults[0].reset_at == pytest.approx(1100.2)
    loop.latched = LOST.model_copy(update={"value": 12.0})
    history.note()
    assert [fault.value for fault in history.faults] == [12.0, 10.5]


def test_another_cause_is_another_fault() -> None:
    loop = Loop()
    history = history_of(loop)
    loop.latched = LOST
    history.note()
    loop.latched = LOST.model_copy(update={"code": 0x8701})
    history.note()
    assert [fault.reset_at is None for fault in history.faults] == [True, False]


def test_figures_are_those_of_the_last_minute(clock: Clock) -> None:
    loop = Loop()
    loop.counted[300] = 10**6  # long ago
    loop.counters[Status.MISSED] = 7
    history = history_of(loop)
    for second in range(90):
        clock.now += 1.0
        loop.counters[Status.CYCLES] += 2000
        loop.counted[39] += 1960
        loop.counted[80] += 39
        loop.counted[-1] += 1
        loop.counters[Status.MISSED] += second == 80
        history.note()
    recent = history.recent()
    assert (recent.seconds, recent.cycles, recent.missed) == (60.0, 120_000, 1)
    assert len(recent.missed_each_second) == 60
    assert recent.missed_each_second.index(1) == 50
    assert (recent.p50, recent.p99, recent.p999) == pytest.approx((40e-6, 81e-6, 81e-6))
    assert sum(recent.round_trips) == 120_000
    assert recent.round_trips[-1] == 60
    assert recent.round_trips[39 // 4] == 60 * 1960


def test_a_percentile_beyond_the_last_bin_is_not_known() -> None:
    loop = Loop()
    history = history_of(loop)
    assert history.recent().p50 is None
    loop.counted[-1] = 5
    assert history.recent().p50 is None
