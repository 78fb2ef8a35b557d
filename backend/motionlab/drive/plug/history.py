"""What a drive link has done lately: its faults, and how its loop kept its time."""

from __future__ import annotations

import time
from collections import deque
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, Field

from motionlab.drive.link.link import DriveLink
from motionlab.drive.link.readings import FaultNow
from motionlab.drive.link.shared import Status

_FAULTS_KEPT = 50
_SECONDS = 60
_BIN = 1e-6  # s, of the histogram of the loop
_TOGETHER = 4  # bins of the loop in one of the answer
_NAME_MAX = 40
_SAME_STOP = 1.0  # s within which the page's STOP of drive and session come


class PastFault(FaultNow):
    """A fault that was latched, and when."""

    at: float = Field(description="Wall clock, s since 1970")
    reset_at: float | None = Field(description="When it was reset; null while it is latched")


class LastStop(BaseModel):
    """Who or what switched the torque off by intent; faults have a list of their own."""

    at: float = Field(description="Wall clock, s since 1970")
    cause: str = Field(description="In words: STOP, disarmed, control given up, ...")
    by: str = Field(description="Name that was given; empty where none was")


class Recent(BaseModel):
    """How the loop kept its time over the last minute, or since the link began."""

    seconds: float
    cycles: int
    late: int = Field(description="Cycles that ended after the next should have begun")
    missed: int = Field(description="Cycles without a good answer; the last command was held")
    missed_each_second: list[int] = Field(description="Oldest first")
    p50: float | None = Field(description="Round trip, s; null without one, or beyond 0.5 ms")
    p99: float | None
    p999: float | None
    bin_width: float = Field(description="Of `round_trips`, s")
    round_trips: list[int] = Field(description="Cycles by round trip; the last bin has no end")


class _Moment(NamedTuple):
    """The counters of the loop at one time."""

    time: float  # monotonic, s
    cycles: int
    late: int
    missed: int
    round_trips: NDArray[np.int64]


class DriveHistory:
    """Faults and timing of one link, noted a few times a second."""

    def __init__(self, link: DriveLink) -> None:
        self._faults: deque[PastFault] = deque(maxlen=_FAULTS_KEPT)
        self.stopped: LastStop | None = None
        self._noted = -_SAME_STOP
        self.follow(link)

    def follow(self, link: DriveLink) -> None:
        """Note what another link does, its counters from their beginning."""
        self._link = link
        self._moments = deque([self._now()], maxlen=_SECONDS + 1)

    @property
    def faults(self) -> list[PastFault]:
        """The latest first."""
        return list(reversed(self._faults))

    def note(self) -> None:
        """Take a fault that has come or gone, and once a second the counters."""
        self._note_fault()
        if time.monotonic() - self._moments[-1].time >= 1.0:
            self._moments.append(self._now())

    @property
    def stopped_lately(self) -> bool:
        """Whether a stop was noted a moment ago: another one is most likely the same."""
        return time.monotonic() - self._noted < _SAME_STOP

    def note_stop(self, cause: str, by: str) -> None:
        """Take who or what switches the torque off; of several at once, one with a name."""
        name = "".join(letter for letter in by if letter.isprintable())[:_NAME_MAX]
        if self.stopped_lately and (not name or self.stopped is None or self.stopped.by):
            return
        self._noted = time.monotonic()
        self.stopped = LastStop(at=time.time(), cause=cause, by=name)

    def recent(self) -> Recent:
        """Return the figures of the last minute."""
        first, last = self._moments[0], self._now()
        counts = last.round_trips - first.round_trips
        missed = [moment.missed for moment in self._moments]
        p50, p99, p999 = (_percentile(counts, share) for share in (0.5, 0.99, 0.999))
        return Recent(
            seconds=last.time - first.time,
            cycles=last.cycles - first.cycles,
            late=last.late - first.late,
            missed=last.missed - first.missed,
            missed_each_second=np.diff(missed).tolist(),
            p50=p50,
            p99=p99,
            p999=p999,
            bin_width=_TOGETHER * _BIN,
            round_trips=counts.reshape(-1, _TOGETHER).sum(axis=1).tolist(),
        )

    def _note_fault(self) -> None:
        fault = self._link.fault()
        latched = self._faults[-1] if self._faults else None
        if latched is not None and latched.reset_at is None:
            if fault is not None and _cause(fault) == _cause(latched):
                return
            latched.reset_at = time.time()
        if fault is not None:
            self._faults.append(PastFault(**fault.model_dump(), at=time.time(), reset_at=None))

    def _now(self) -> _Moment:
        status = self._link.status
        return _Moment(
            time.monotonic(),
            status(Status.CYCLES),
            status(Status.LATE),
            status(Status.MISSED),
            self._link.round_trips,
        )


def _cause(fault: FaultNow) -> tuple[int, int, int, float | None]:
    return fault.code, fault.error, fault.place, fault.value


def _percentile(counts: NDArray[np.int64], share: float) -> float | None:
    """Return the time within which a share of all cycles is, s; None where it is not known."""
    reached = np.cumsum(counts)
    if reached[-1] == 0:
        return None
    at = int(np.searchsorted(reached, share * reached[-1]))
    return None if at >= len(counts) - 1 else (at + 1) * _BIN
