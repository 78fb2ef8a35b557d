"""A simulation that the clock advances, a slice at a time: what it samples is kept and recorded."""

from __future__ import annotations

import time
from contextlib import AbstractAsyncContextManager

from motionlab.library.run import Event
from motionlab.server.live.clock import Clock
from motionlab.server.live.event_log import EventLog
from motionlab.server.live.history import History
from motionlab.server.live.notification import Listener
from motionlab.server.live.run_recorder import RunRecorder
from motionlab.server.live.session_info import RecordState, State
from motionlab.server.live.session_recorder import SessionRecorder
from motionlab.server.live.slice_lock import SliceLock
from motionlab.simulation.machine import Machine
from motionlab.simulation.prepare import Prepared
from motionlab.simulation.simulation import Simulation
from motionlab.timing import CONTROL_PERIOD

CATCH_UP_SECONDS = 0.25
"""Time that may pass between two frames and count; beyond it a session falls behind the clock."""

_SLICE_LANES = 2048
"""Ticks times blocks of lanes that advance at a time: some 2 ms; STOP does not wait for them."""

_TIMELINES = 50  # whose recordings captures are taken from


class Paced:
    """A simulation that follows the clock, with its state, its history and who listens to it.

    The clock's thread advances it under its lock. A stop takes no lock: it leaves word, and the
    clock's thread brakes before its next slice.

    Parameters
    ----------
    prepared : Prepared
        The scenario, checked.
    clock : Clock
        Advances it while it plays.
    recorder : RunRecorder, optional
        Records it as runs, one from each reset to the next.
    drive : str
        Title of the drive link that it moves; empty where it is simulated.
    """

    def __init__(
        self,
        prepared: Prepared,
        clock: Clock,
        recorder: RunRecorder | None = None,
        *,
        drive: str = "",
    ) -> None:
        self.prepared = prepared
        self.variants = list(prepared.scenario.variants)
        self.state: State = "paused"
        self.speed = 1.0
        self.revision = 0
        self.timeline = 0
        self.listeners: set[Listener] = set()
        self.drive = drive
        self.history = History(self.variants)
        self.events = EventLog()
        self.records: dict[int, SessionRecorder] = {}  # by timeline
        self._clock = clock
        self._recorder = recorder
        self._record: SessionRecorder | None = None
        self._told_of_record: RecordState = (None, "", 0)
        self._lock = SliceLock()
        self._last = 0.0  # until when the clock has been followed
        self._owed = 0.0  # ticks that the clock is ahead, less than one
        self._stop_tick = 0
        self._to_brake = False  # a stop has been asked for
        self._stopped_by = ""
        self._untold = False  # whether the state has changed since listeners were notified
        self._adopt(self._machine())

    @property
    def size(self) -> int:
        """Memory of ring and motion, bytes."""
        return self.history.ring.size + self.prepared.motion_size

    @property
    def tick(self) -> int:
        """The next tick."""
        return self.simulation.tick

    @property
    def runs(self) -> bool:
        """Whether the clock advances it."""
        return self.state in {"playing", "stopping"}

    def keep_up(self, now: float) -> None:
        """Advance by the time that has passed, times the speed; the clock's thread does that."""
        state = self.state
        seconds = min(now - self._last, CATCH_UP_SECONDS)
        self._last = now
        self._owed += seconds * (self.speed if state == "playing" else 1.0) / CONTROL_PERIOD
        ticks = int(self._owed)
        self._owed -= ticks
        if self.runs:
            self._advance(ticks, state)

    def publish(self) -> None:
        """Notify all listeners; runs on the event loop."""
        record = self._record_state
        if self._untold or record != self._told_of_record:
            self._untold = False
            self._told_of_record = record
            self._tell_state()
        for listener in self.listeners:
            listener.notify()

    def held(self) -> AbstractAsyncContextManager[None]:
        """Hold it between two slices of time."""
        return self._lock.claimed()

    @property
    def _record_state(self) -> RecordState:
        """The run that is being recorded, why nothing is, and the tick with which it begins."""
        record = self._record
        return (None, "", 0) if record is None else (record.run, record.problem, record.begins)

    def _follow_clock(self) -> None:
        self._last = time.monotonic()
        self._clock.start(self)

    def _machine(self) -> Machine:
        """Return what the session advances, at tick 0."""
        return Simulation(self.prepared, endless=True)

    def _adopt(self, simulation: Machine) -> None:
        self.simulation = simulation
        self._scenario = simulation.scenario
        self._failed = simulation.failed_ticks
        if self._record is not None:
            self._record.end()
        self.history.ring.clear()
        if self._recorder is not None:
            self._record = self.records[self.timeline] = SessionRecorder(
                self._recorder,
                self.history.ring,
                self.history.columns,
                simulation.scenario,
                drive=self.drive,
            )
            self.records.pop(self.timeline - _TIMELINES, None)

    def _advance(self, ticks: int, state: State) -> None:
        """Advance by some ticks in slices, or to the end, or until the state is another."""
        most = max(1, _SLICE_LANES // self.simulation.blocks)
        until = self.tick + ticks
        while True:
            with self._lock.slice:
                left = until - self.tick
                if self._to_brake:
                    self._brake()
                if self.state != state or left <= 0:
                    return
                self._advance_slice(min(left, most))
            self._recorded()
            self._lock.give_way()

    def _brake(self) -> None:
        """Begin what a stop has asked for."""
        self._to_brake = False
        self._stop_tick = self.tick
        self.simulation.stop()
        self._note(Event(tick=self.tick, kind="stop", by=self._stopped_by))
        self._untold = True

    def _advance_slice(self, ticks: int) -> None:
        self.history.record(self.simulation, ticks)
        failed, scenario = self.simulation.failed_ticks, self.simulation.scenario
        if self.simulation.stopped:
            self.state = "stopped"
        elif self.tick == self.simulation.timeline.end:
            self.state = "finished"
            if self._to_brake:  # a stop came meanwhile
                self.state = "stopping"
        elif failed == self._failed and scenario is self._scenario:
            return
        self._failed, self._scenario = failed, scenario
        self._untold = True

    def _recorded(self, *, flush: bool = False) -> None:
        """Record what is new; all of it and no more once the motion has ended."""
        record = self._record  # before the state: a reset changes that first
        if record is None:
            return
        if self.state in {"finished", "stopped"}:
            record.end()
        else:
            record.advanced(flush=flush)

    def _note(self, event: Event) -> None:
        """Log and record an event that samples depend on."""
        event = self.events.note(event)
        if self._record is not None:
            self._record.note(event, self.simulation.scenario)

    def _tell_state(self) -> None:
        self.revision += 1
        for listener in self.listeners:
            listener.state_changed()
