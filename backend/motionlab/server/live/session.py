"""A live session: its commands and its state."""

from __future__ import annotations

import asyncio
import functools
import json
import secrets
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

import numpy as np
from pydantic import TypeAdapter

from motionlab.analysis.latest_metrics import latest_metrics
from motionlab.config.load import epochs
from motionlab.config.planar import AXES
from motionlab.config.scenario import Scenario
from motionlab.library.run import Event
from motionlab.server.live.change_log import ChangeLog
from motionlab.server.live.clock import Clock
from motionlab.server.live.event_log import EventLog
from motionlab.server.live.history import History, path_of
from motionlab.server.live.notification import Listener
from motionlab.server.live.people import People
from motionlab.server.live.run_recorder import RunRecorder
from motionlab.server.live.session_info import (
    JsonMembers,
    RecordState,
    SessionStatus,
    State,
    WrongState,
)
from motionlab.server.live.session_recorder import SessionRecorder
from motionlab.server.live.slice_lock import SliceLock
from motionlab.simulation.change import Change, changed
from motionlab.simulation.machine import Machine
from motionlab.simulation.prepare import Prepared
from motionlab.simulation.simulation import ReadyEpoch, Simulation, ready
from motionlab.telemetry.recording import Recording
from motionlab.timing import CONTROL_PERIOD, to_ticks

METRICS_SECONDS = 10.0
CATCH_UP_SECONDS = 0.25
"""Time that may pass between two frames and count; beyond it a session falls behind the clock."""

_SLICE_LANES = 2048
"""Ticks times blocks of lanes that advance at a time: some 2 ms; STOP does not wait for them."""

_TIMELINES = 50  # whose recordings captures are taken from
P = ParamSpec("P")
T = TypeVar("T")

_CHANGES: TypeAdapter[tuple[Change, ...]] = TypeAdapter(tuple[Change, ...])
_EVENTS: TypeAdapter[tuple[Event, ...]] = TypeAdapter(tuple[Event, ...])
_PEOPLE: TypeAdapter[tuple[str, ...]] = TypeAdapter(tuple[str, ...])
_SCENARIO: TypeAdapter[Scenario] = TypeAdapter(Scenario)


class Session:
    """One live scenario.

    The clock's thread advances it, a slice at a time, under its lock. Commands run on the event
    loop and take the lock, between two slices, for the moment in which they act. A stop takes no
    lock: it leaves word, and the clock's thread brakes before its next slice.
    What takes longer (checking changes, building lanes, measuring) runs in `threads` beside the
    simulation, and its result is put in place by the event loop. Commands that prepare something
    follow one another in the order in which they came.

    Parameters
    ----------
    prepared : Prepared
        The scenario, checked.
    clock : Clock
        Advances it while it plays.
    threads : Executor
        Where its slow work is done.
    recorder : RunRecorder, optional
        Records it as runs, one from each reset to the next.
    drive : str
        Title of the drive link that it moves; empty where it is simulated.
    """

    def __init__(
        self,
        prepared: Prepared,
        clock: Clock,
        threads: Executor,
        recorder: RunRecorder | None = None,
        *,
        drive: str = "",
    ) -> None:
        self.id = secrets.token_urlsafe(9)
        self.prepared = prepared
        self.variants = list(prepared.scenario.variants)
        self.state: State = "paused"
        self.speed = 1.0
        self.revision = 0
        self.timeline = 0
        self.listeners: set[Listener] = set()
        self.touched = time.monotonic()
        self.closed = False
        self.drive = drive
        self.history = History(self.variants)
        self.people = People(self._tell_state)
        self._clock = clock
        self._threads = threads
        self._recorder = recorder
        self._record: SessionRecorder | None = None
        self.records: dict[int, SessionRecorder] = {}  # by timeline
        self._told_of_record: RecordState = (None, "", 0)
        self._changes = ChangeLog(prepared.scenario)
        self.events = EventLog()
        self._lock = SliceLock()
        self._order = asyncio.Lock()
        self._last = 0.0  # until when the clock has been followed
        self._owed = 0.0  # ticks that the clock is ahead, less than one
        self._stop_tick = 0
        self._to_brake = False  # a stop has been asked for
        self._stopped_by = ""
        self._announced = (-1, "")
        self._members = JsonMembers()
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
    def status(self) -> SessionStatus:
        """Status of the session."""
        run, unrecorded, begins = self._record_state
        return SessionStatus(
            id=self.id,
            revision=self.revision,
            timeline=self.timeline,
            state=self.state,
            tick=self.tick,
            time=self.tick * CONTROL_PERIOD,
            speed=self.speed,
            stream=f"/api/v1/sessions/{self.id}/stream",
            run=run,
            recorded_from=begins * CONTROL_PERIOD,
            unrecorded=unrecorded,
            watchers=len(self.listeners),
            ends=self.simulation.timeline.end,
            diverged={
                name: None if tick is None else tick * CONTROL_PERIOD
                for name, tick in zip(self.variants, self._failed, strict=True)
            },
            drive=self.drive,
        )

    def info(self) -> str:
        """Return the session's `SessionInfo` as JSON."""
        texts = [
            self._members.text(name, value, adapter)
            for name, value, adapter in (
                ("people", self.people.names, _PEOPLE),
                ("events", self.events.latest, _EVENTS),
                ("changes", self._changes.latest, _CHANGES),
                ("base", self.prepared.scenario, _SCENARIO),
                ("scenario", self.simulation.scenario, _SCENARIO),
            )
        ]
        return f"{self.status.model_dump_json()[:-1]},{','.join(texts)}}}"

    def announcement(self) -> str:
        """Return the message of the present revision, the same for all streams."""
        if self._announced[0] != self.revision:
            self._announced = (self.revision, f'{{"type":"session","session":{self.info()}}}')
        return self._announced[1]

    async def play(self, speed: float | None = None, by: str = "") -> None:
        """Run against the clock, at `speed` times real time."""
        async with self._lock.claimed():
            self._refuse_when("stopping", "stopped", "finished")
            other = None if speed == self.speed else speed
            self.speed = speed or self.speed
            if self.state == "paused":
                self.state = "playing"
                self._follow_clock()
                self.events.note(Event(tick=self.tick, kind="play", by=by, speed=other))
            elif other is not None:
                self.events.note(Event(tick=self.tick, kind="speed", by=by, speed=other))
        self._tell_state()

    async def pause(self, by: str = "") -> None:
        """Halt the clock."""
        async with self._lock.claimed():
            self._refuse_when("stopped", "stopping")
            if self.state == "playing":
                self.state = "paused"
                self._clock.stop(self)
                self.events.note(Event(tick=self.tick, kind="pause", by=by))
        self._recorded(flush=True)
        self._tell_state()

    async def step(self, ticks: int) -> None:
        """Advance a paused session by some ticks; a command that comes meanwhile ends the step."""
        async with self._order:
            self._refuse_when("playing", "stopping", "stopped", "finished")
            await self._in_thread(self._advance, ticks, "paused")
            self._recorded(flush=True)
            self._tell_state()
            self.publish()

    async def reset(self, by: str = "") -> None:
        """Go back to tick 0 with all changes, but for those that only fit a later schedule.

        Raises
        ------
        ConfigError
            If a force map has been deleted since; nothing has changed then.
        """
        async with self._order:
            simulation, kept = await self._in_thread(self._afresh)
            async with self._lock.claimed():
                self._refuse_when_closed()
                self._clock.stop(self)
                self._to_brake = False
                self.events.note(Event(tick=0, kind="reset", by=by))
                self.state = "paused"
                self.timeline += 1
                self._changes.latest = kept
                self._adopt(simulation)
        for listener in self.listeners:
            listener.reset()
        self._tell_state()

    def stop(self, by: str = "") -> None:
        """Brake the reference to rest, then switch the currents off; only a reset leaves that."""
        if self.state in {"stopping", "stopped"}:
            return
        self._stop_tick = self.tick
        self._stopped_by = by
        self._to_brake = True
        self.state = "stopping"  # after that: a motion that ends meanwhile finds it
        self._follow_clock()  # always: the clock may just have dropped a motion that ended
        self._tell_state()

    async def push(self, axis: int, force: float, seconds: float, by: str = "") -> int:
        """Push the mover of every variant and return the tick at which it begins."""
        async with self._lock.claimed():
            self._refuse_when("stopping", "stopped", "finished")
            ticks = max(1, to_ticks(seconds))
            self.simulation.push(axis, force, ticks)
            tick, name = self.tick, AXES[axis]
            self._note(Event(tick=tick, kind="push", by=by, axis=name, force=force, ticks=ticks))
        self._tell_state()
        return tick

    def authorise(self, lease: str) -> None:
        """Refuse who may not change parameters; of a simulation everybody may."""

    async def change(self, changes: Mapping[str, Any], by: str = "") -> int:
        """Change parameters at the next tick, all or none.

        Parameters
        ----------
        changes : mapping of str to value
            Dotted path to value, as with ``--set``.
        by : str
            Name of who changes them; empty where none was given.

        Raises
        ------
        ConfigError
            If a value is refused or the field cannot change during a run.
        """
        async with self._order:
            tick = await self._change(changes, by=by)
        self._tell_state()
        return tick

    async def undo(self, by: str = "") -> None:
        """Take back the latest change, as a change of its own at the next tick."""
        async with self._order:
            if not self._changes.latest:
                raise WrongState("nothing has been changed")
            await self._change(self._changes.latest[-1].previous, by=by, undo=True)
            self._changes.latest = self._changes.latest[:-2]
        self._tell_state()

    async def metrics(self) -> bytes:
        """Return metrics of the last two periods, or ten seconds, as JSON; none before a tick.

        They end where a stop began: its braking leaves the trajectory. Of a motion that has
        finished after its laps they are those of a run.
        """
        reference = self.prepared.reference
        length = 2 * reference.period if reference.period else to_ticks(METRICS_SECONDS)
        end = None
        if self.state in {"stopping", "stopped"}:
            end = self._stop_tick
        elif self.state == "finished" and not reference.for_ever:
            length, end = reference.window[1] - reference.window[0], reference.window[1]
        return await self._in_thread(self._measure, length, end)

    def recording(self, length: int | None = None) -> Recording:
        """Return the latest `length` ticks that the history holds, or all of them.

        Slow; other threads may call it while the session advances.
        """
        braked = self.state in {"stopping", "stopped"}
        return self.history.recording(self.simulation, length, braked=braked)

    async def save(self, path: Path) -> tuple[int, dict[str, int | None]]:
        """Write what the history holds to a file, as numpy does; made a recording elsewhere.

        Returns
        -------
        int, dict of str to int or None
            First tick, and of each variant the tick at which it diverged, for `as_recording`.
        """

        def saved() -> tuple[int, dict[str, int | None]]:
            start, data = self.history.latest(None)
            np.save(path, data)
            return start, dict(zip(self.variants, self._failed, strict=True))

        return await self._in_thread(saved)

    def close(self) -> None:
        """End pacing and every stream."""
        self.closed = True
        self.state = "finished"
        self._clock.stop(self)
        if self._record is not None:
            self._record.end()
        self.publish()

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

    @property
    def _record_state(self) -> RecordState:
        """The run that is being recorded, why nothing is, and the tick with which it begins."""
        record = self._record
        return (None, "", 0) if record is None else (record.run, record.problem, record.begins)

    def publish(self) -> None:
        """Notify all listeners; runs on the event loop."""
        record = self._record_state
        if self._untold or record != self._told_of_record:
            self._untold = False
            self._told_of_record = record
            self._tell_state()
        for listener in self.listeners:
            listener.notify()

    async def _in_thread(self, work: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
        loop = asyncio.get_running_loop()
        return await loop.run_in_executor(self._threads, functools.partial(work, *args, **kwargs))

    def _follow_clock(self) -> None:
        self._last = time.monotonic()
        self._clock.start(self)

    def _afresh(self) -> tuple[Machine, tuple[Change, ...]]:
        """Return a simulation at tick 0 with all changes that fit it, and these."""
        scenario, kept = self._changes.replayed()
        simulation = self._machine()
        if scenario is not self.prepared.scenario:
            simulation.adopt(ready(epochs(scenario)))
        return simulation, kept

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

    async def _change(self, changes: Mapping[str, Any], *, by: str, undo: bool = False) -> int:
        def prepared(scenario: Scenario, tick: int) -> tuple[Change, list[Any]]:
            after, change = changed(scenario, changes, tick)
            return change, ready(epochs(after, tick))

        async with self._lock.claimed():  # parameters and the tick at which they hold
            scenario, checked = self.simulation.scenario, self.tick
        change, made_ready = await self._in_thread(prepared, scenario, checked)
        facts = change.model_dump(include={"set", "previous"})
        event = Event(tick=checked, kind="change", by=by, undo=undo, checked=checked, **facts)
        tick = await self._put_in_effect(made_ready, event)
        await self._in_thread(self._changes.keep, change.model_copy(update={"tick": tick}))
        return tick

    async def _put_in_effect(self, changes: Sequence[ReadyEpoch], event: Event) -> int:
        """Put changes in effect at the next tick, note the event for it, and return the tick."""
        async with self._lock.claimed():
            self._refuse_when_closed()
            tick = self.simulation.adopt(changes)
            self._scenario = self.simulation.scenario
            self._note(event.model_copy(update={"tick": tick}))
            return tick

    def _measure(self, length: int, end: int | None) -> bytes:
        recording = self.history.recording(self.simulation, length, braked=False, end=end)
        band, path = self.simulation.scenario.settling_band, path_of(recording, self.simulation)
        measured = latest_metrics(recording, self.prepared.reference, path, settling_band=band)
        return json.dumps(measured, allow_nan=False, separators=(",", ":")).encode()

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

    def _recorded(self, *, flush: bool = False) -> None:
        """Record what is new; all of it and no more once the motion has ended."""
        record = self._record  # before the state: a reset changes that first
        if record is None:
            return
        if self.state in {"finished", "stopped"}:
            record.end()
        else:
            record.advanced(flush=flush)

    def law_changed(self, event: Event) -> None:
        """Log that a law of one's own has another version, or, with a reason, why it has not."""
        variants = self.simulation.scenario.variants.values()
        runs = any(each.controller.compensation.law == event.law for each in variants)
        if runs and not event.reason:
            self._note(event)
        else:
            self.events.note(event)
        self._tell_state()

    def _note(self, event: Event) -> None:
        """Log and record an event that samples depend on."""
        event = self.events.note(event)
        if self._record is not None:
            self._record.note(event)

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

    def _refuse_when(self, *states: State) -> None:
        if self.state in states:
            raise WrongState(f"the session is {self.state}")

    def _refuse_when_closed(self) -> None:
        if self.closed:
            raise WrongState("the session has ended")

    def _tell_state(self) -> None:
        self.revision += 1
        for listener in self.listeners:
            listener.state_changed()
