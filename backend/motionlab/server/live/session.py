"""A live session: its commands, and its state as the API has it."""

from __future__ import annotations

import asyncio
import functools
import json
import secrets
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import AbstractAsyncContextManager
from dataclasses import replace
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

import numpy as np
from pydantic import TypeAdapter

from motionlab.analysis.latest_metrics import latest_metrics
from motionlab.config.load import epochs, redeclared
from motionlab.config.planar import AXES
from motionlab.config.scenario import Scenario
from motionlab.declarations import Parameter
from motionlab.library.new_run import variants_with
from motionlab.library.run import Event
from motionlab.server.live.change_log import ChangeLog
from motionlab.server.live.clock import Clock
from motionlab.server.live.history import path_of
from motionlab.server.live.paced import Paced
from motionlab.server.live.people import People
from motionlab.server.live.run_recorder import RunRecorder
from motionlab.server.live.session_info import (
    JsonMembers,
    SessionStatus,
    State,
    WrongState,
)
from motionlab.simulation.change import Change, changed
from motionlab.simulation.machine import Machine
from motionlab.simulation.prepare import Prepared
from motionlab.simulation.simulation import ReadyEpoch, ready
from motionlab.telemetry.recording import Recording
from motionlab.timing import CONTROL_PERIOD, to_ticks

METRICS_SECONDS = 10.0
P = ParamSpec("P")
T = TypeVar("T")

_CHANGES: TypeAdapter[tuple[Change, ...]] = TypeAdapter(tuple[Change, ...])
_EVENTS: TypeAdapter[tuple[Event, ...]] = TypeAdapter(tuple[Event, ...])
_PEOPLE: TypeAdapter[tuple[str, ...]] = TypeAdapter(tuple[str, ...])
_SCENARIO: TypeAdapter[Scenario] = TypeAdapter(Scenario)


class Session(Paced):
    """One live scenario, with its commands.

    Commands run on the event loop and take the lock, between two slices, for the moment in which
    they act. What takes longer (checking changes, building lanes, measuring) runs in `threads`
    beside the simulation, and its result is put in place by the event loop. Commands that prepare
    something follow one another in the order in which they came.

    Parameters
    ----------
    prepared, clock, recorder, drive
        As of `Paced`.
    threads : Executor
        Where its slow work is done.
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
        super().__init__(prepared, clock, recorder, drive=drive)
        self.id = secrets.token_urlsafe(9)
        self.touched = time.monotonic()
        self.closed = False
        self.people = People(self._tell_state)
        self._threads = threads
        self._changes = ChangeLog(prepared.scenario)
        self._order = asyncio.Lock()
        self._announced = (-1, "")
        self._members = JsonMembers()

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

    async def _in_thread(self, work: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
        loop = asyncio.get_running_loop()
        return await loop.run_in_executor(self._threads, functools.partial(work, *args, **kwargs))

    def _afresh(self) -> tuple[Machine, tuple[Change, ...]]:
        """Return a simulation at tick 0 with all changes that fit it, and these."""
        scenario, kept = self._changes.replayed()
        simulation = self._machine()
        if scenario is not self.prepared.scenario:
            simulation.adopt(ready(epochs(scenario)))
        return simulation, kept

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

    def in_order(self) -> AbstractAsyncContextManager[None]:
        """Hold back commands that prepare something."""
        return self._order

    def redeclared(self, former: Mapping[str, Parameter]) -> Callable[[], None]:
        """Return what puts its scenarios in place as laws declare them now; while it is held.

        Parameters
        ----------
        former : mapping of str to Parameter
            What they declared before.

        Raises
        ------
        ConfigError
            Naming every value that is no longer allowed.
        """
        simulation, base = self.simulation, redeclared(self.prepared.scenario, former)
        prepared = replace(self.prepared, scenario=base, epochs=epochs(base))
        start = self._changes.redeclared(former)
        changes = ready(epochs(redeclared(simulation.scenario, former), self.tick))

        def put() -> None:
            self.prepared = prepared
            self._changes.begin(start)
            simulation.adopt(changes)
            self._scenario = simulation.scenario
            self.history.laws_changed()

        return put

    def law_changed(self, event: Event) -> None:
        """Log that a law of one's own has another version, or, with a reason, why it has not."""
        event = event.model_copy(update={"tick": self.tick})
        if not event.reason and variants_with(self.simulation.scenario, event.law):
            self._note(event)
        else:
            self.events.note(event)
        self._tell_state()

    def _refuse_when(self, *states: State) -> None:
        if self.state in states:
            raise WrongState(f"the session is {self.state}")

    def _refuse_when_closed(self) -> None:
        if self.closed:
            raise WrongState("the session has ended")
