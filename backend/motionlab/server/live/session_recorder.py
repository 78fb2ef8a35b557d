"""The recording of one session: its samples are copied as they come, for the thread that writes."""

from __future__ import annotations

import logging
import threading
import time
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from motionlab.config.scenario import Scenario
from motionlab.errors import MotionLabError
from motionlab.library.new_run import own_laws_of
from motionlab.library.run import Event, new_id
from motionlab.reports.problems import plain
from motionlab.telemetry.channels import Channel
from motionlab.telemetry.ring import Ring

if TYPE_CHECKING:
    from motionlab.library.spool import Spool
    from motionlab.server.live.run_recorder import RunRecorder

_PERIOD = 0.4  # s between two batches, so that less than a second is lost by a kill
_SHARE = 4  # of the ring: a batch is taken at the latest when so much of it is new

_LOG = logging.getLogger(__name__)


@dataclass(eq=False)
class Record:
    """What the thread knows of a recording."""

    scenario: Scenario
    channels: list[tuple[str, Channel]]
    drive: str = ""  # title of the drive link that moves
    id: str = field(default_factory=new_id)
    created: float = field(default_factory=time.time)
    spool: Spool | None = None
    events: list[Event] = field(default_factory=list)  # that are not yet written
    end: int = 0  # the tick after the latest
    lost: int = 0  # of the latest ticks, so many in a row could not be written
    problem: str = ""
    unwritten: str = ""  # what will never be
    rolling: bool = False  # whether its beginning has gone
    changes_wait: bool = False  # a call that lists its changes is queued

    def failed(self, error: Exception) -> None:
        """Note why it is not written, and say so in the log when that is new."""
        known = isinstance(error, OSError | MotionLabError)
        reason = (isinstance(error, OSError) and error.strerror) or str(error)
        if not known:
            reason = f"the recorder failed, {type(error).__name__}: {error}"
        reason = plain(reason)
        if not self.problem:
            _LOG.warning(
                "%s is not being recorded: %s", self.id, reason, exc_info=None if known else error
            )
        self.problem = reason


@dataclass
class Item:
    """What the thread is handed: samples, an event, or the end of a recording."""

    record: Record
    first: int = 0
    samples: NDArray[np.float32] | None = None
    event: Event | None = None
    end: bool = False
    lost: int = 0


class SessionRecorder:
    """Records one timeline of one session, from its first tick.

    Parameters
    ----------
    recorder : RunRecorder
        Whose thread writes.
    ring : Ring
        Where the session's samples are.
    channels : list of (str, Channel)
        Its columns.
    scenario : Scenario
        What is in effect at tick 0.
    drive : str
        Title of the drive link that moves; empty for a simulated session.
    """

    def __init__(
        self,
        recorder: RunRecorder,
        ring: Ring,
        channels: list[tuple[str, Channel]],
        scenario: Scenario,
        *,
        drive: str = "",
    ) -> None:
        self._recorder = recorder
        self._ring = ring
        self._channels = channels
        self._scenario = scenario
        self._texts = own_laws_of(scenario)
        self._drive = drive
        self._lock = threading.Lock()
        self._record: Record | None = None
        self._early: list[Event] = []  # before the first sample
        self._taken = 0
        self._due = 0.0
        self._ended = False

    @property
    def run(self) -> str | None:
        """Identifier of the run that is being recorded; none while nothing could be written."""
        record = self._record
        if record is None or self._ended or (record.spool is None and record.problem):
            return None
        return record.id

    @property
    def kept(self) -> str | None:
        """Identifier of the run, also once it is complete; none while nothing was written."""
        record = self._record
        return None if record is None or record.spool is None else record.id

    @property
    def begins(self) -> int:
        """Tick with which the recording begins; above 0 once its beginning has gone."""
        record = self._record
        return 0 if record is None or record.spool is None else record.spool.begins

    @property
    def problem(self) -> str:
        """Why nothing can be recorded at the moment; empty when all is well."""
        record = self._record
        return "" if record is None else record.problem or record.unwritten

    def advanced(self, *, flush: bool = False) -> None:
        """Take what is new when it is time for it, or at once with `flush`."""
        new = self._ring.end - self._taken
        due = flush or new * _SHARE > self._ring.capacity or time.monotonic() >= self._due
        if new > 0 and due:
            with self._lock:
                self._take()

    def note(self, event: Event, scenario: Scenario) -> None:
        """Record an event, after the ticks before it; `scenario` is what is in effect now."""
        if event.kind in {"law", "change"}:
            texts = own_laws_of(scenario)
            new = {name: text for name, text in texts.items() if self._texts.get(name) != text}
            event = event.model_copy(update={"texts": new})
            self._texts = texts
        with self._lock:
            self._take()
            if self._record is None:
                self._early.append(event)
            elif not self._ended:
                self._recorder.put(Item(self._record, event=event))

    def end(self) -> None:
        """Record the rest, and make it a run."""
        with self._lock:
            self._take()
            if not self._ended and self._record is not None:
                self._recorder.put(Item(self._record, end=True))
            self._ended = True

    def _take(self) -> None:
        """Take what is new; whatever that raises, the session and its stop go on."""
        try:
            self._take_new()
        except Exception as error:
            if self._record is not None:
                self._record.failed(error)
            else:
                _LOG.exception("a session is not being recorded")

    def _take_new(self) -> None:
        self._due = time.monotonic() + _PERIOD
        if self._ended or self._ring.end <= self._taken:
            return
        if self._record is None:
            record = Record(self._scenario, self._channels, self._drive, events=self._early)
            self._recorder.announce(record.id)
            self._record = record
        record = self._record
        while self._taken < (end := self._ring.end):
            start = max(self._taken, self._ring.first)
            try:
                samples = self._ring.read(slice(None), start, end)
            except IndexError:  # overwritten meanwhile
                continue
            self._recorder.put(Item(record, start, samples, lost=start - self._taken))
            self._taken = end
