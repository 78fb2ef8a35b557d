"""A live scenario: what can be done with it, and in which state it is."""

from __future__ import annotations

import asyncio
import secrets
import time
from collections.abc import Mapping
from typing import Any, Literal

from pydantic import BaseModel, Field

from motionlab.config.load import phases
from motionlab.config.scenario import Scenario
from motionlab.config.timing import CONTROL_PERIOD, to_ticks
from motionlab.service.changes import Change, Changes, changed
from motionlab.service.history import History
from motionlab.service.latest import latest_metrics
from motionlab.service.listener import Listener
from motionlab.service.pace import Pace
from motionlab.simulation.prepare import Prepared
from motionlab.simulation.simulation import Simulation
from motionlab.telemetry.recording import Recording

METRICS_SECONDS = 10.0
_RELEASE_TICKS = to_ticks(0.05)
"""Ticks from a stop's rest until the currents, commanded to zero, are taken to be gone."""

State = Literal["paused", "playing", "stopping", "stopped", "finished"]


class SessionInfo(BaseModel):
    """What is known of a session."""

    id: str
    revision: int = Field(description="Grows with every change; of two reports the larger is newer")
    timeline: int = Field(description="Counts resets; ticks of another timeline are other ticks")
    state: State
    tick: int
    time: float = Field(description="Simulated time, s")
    speed: float = Field(description="Simulated time per time")
    stream: str = Field(description="Path of its websocket")
    watchers: int = Field(description="Streams and stages that are open")
    ends: int | None = Field(description="Tick at which it ends; null if it goes on")
    changes: list[Change] = Field(description="The latest, oldest first; undo takes back the last")
    diverged: dict[str, float | None] = Field(description="Time at which a variant diverged, s")
    base: Scenario = Field(description="What it was created from")
    scenario: Scenario = Field(description="What is in effect")


class WrongState(Exception):
    """What was asked does not fit the state of the session."""


class Session:
    """One live scenario.

    All its methods run on the event loop: 16 ms of a simulation take some 30 us, less than handing
    them to a thread would.

    Parameters
    ----------
    prepared : Prepared
        The scenario, checked.
    """

    def __init__(self, prepared: Prepared) -> None:
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
        self.history = History(self.variants)
        self._changes = Changes(prepared.scenario)
        self._pace = Pace(self._keep_up)
        self._owed = 0.0  # ticks that the clock is ahead, less than one
        self._rest_tick = 0
        self._begin()

    @property
    def size(self) -> int:
        """What it holds in memory, bytes: the ring, and the motion."""
        return self.history.ring.size + self.prepared.motion_size

    @property
    def tick(self) -> int:
        """The next tick to come."""
        return self.simulation.tick

    def info(self) -> SessionInfo:
        """Return what is known of the session."""
        return SessionInfo(
            id=self.id,
            revision=self.revision,
            timeline=self.timeline,
            state=self.state,
            tick=self.tick,
            time=self.tick * CONTROL_PERIOD,
            speed=self.speed,
            stream=f"/api/v1/sessions/{self.id}/stream",
            watchers=len(self.listeners),
            ends=self.simulation.timeline.end,
            changes=self._changes.latest,
            diverged={
                name: None if tick is None else tick * CONTROL_PERIOD
                for name, tick in zip(self.variants, self.simulation.failed_ticks, strict=True)
            },
            base=self.prepared.scenario,
            scenario=self.simulation.scenario,
        )

    def play(self, speed: float | None = None) -> None:
        """Run against the clock, at `speed` times real time."""
        self._refuse_when("stopping", "stopped", "finished")
        if speed is not None:
            self.speed = speed
        if self.state == "paused":
            self.state = "playing"
            self._pace.start()
        self._tell_state()

    def pause(self) -> None:
        """Halt the clock."""
        self._refuse_when("stopped", "stopping")
        if self.state == "playing":
            self.state = "paused"
            self._pace.stop()
        self._tell_state()

    def step(self, ticks: int) -> None:
        """Advance a paused session by some ticks."""
        self._refuse_when("playing", "stopping", "stopped", "finished")
        self._advance(ticks)
        self._tell_state()

    def reset(self) -> None:
        """Go back to tick 0 with all changes, but for those that only fit a later schedule.

        Raises
        ------
        ConfigError
            If a force map is not there any more; nothing has changed then.
        """
        self._begin()
        self.state = "paused"
        self._pace.stop()
        self.timeline += 1
        for listener in self.listeners:
            listener.reset()
        self._tell_state()

    def stop(self) -> None:
        """Brake the reference to rest, then switch the currents off; only a reset leaves that."""
        if self.state in {"stopping", "stopped"}:
            return
        self._rest_tick = self.simulation.stop()
        self.state = "stopping"
        self._pace.start()
        self._tell_state()

    def push(self, axis: int, force: float, seconds: float) -> int:
        """Push the mover of every variant and return the tick at which it begins."""
        self.simulation.push(axis, force, max(1, to_ticks(seconds)))
        return self.tick

    def change(self, changes: Mapping[str, Any]) -> int:
        """Change parameters at the next tick, all or none.

        Parameters
        ----------
        changes : mapping of str to value
            Dotted path to value, as with ``--set``.

        Returns
        -------
        int
            The first tick at which they hold.

        Raises
        ------
        ConfigError
            If a value is refused or the field cannot change during a run.
        """
        scenario, change = changed(self.simulation.scenario, changes, self.tick)
        self.simulation.change(tuple(phases(scenario, self.tick)))
        self._changes.keep(change)
        self._tell_state()
        return self.tick

    def undo(self) -> None:
        """Take back the latest change, as a change of its own at the next tick."""
        if not self._changes.latest:
            raise WrongState("nothing has been changed")
        self.change(self._changes.latest[-1].previous)
        del self._changes.latest[-2:]
        self._tell_state()

    async def metrics(self) -> dict[str, Any]:
        """Return metrics of the last two periods, or ten seconds; before the first tick of none.

        Samples are taken now and measured in a thread, so that streams need not wait.
        """
        period = self.prepared.reference.period
        length = 2 * period if period else to_ticks(METRICS_SECONDS)
        ring = self.history.ring
        recording = self.recording(max(ring.first, ring.end - length))
        band = self.simulation.scenario.settling_band
        return await asyncio.to_thread(
            latest_metrics, recording, self.prepared.reference, settling_band=band
        )

    def recording(self, start: int | None = None) -> Recording:
        """Return what the history holds from tick `start` on, or all of it."""
        start = self.history.ring.first if start is None else start
        braked = self.state in {"stopping", "stopped"}
        return self.history.recording(self.simulation, start, braked=braked)

    def close(self) -> None:
        """End pacing and every stream."""
        self.closed = True
        self.state = "finished"
        self._pace.stop()
        for listener in self.listeners:
            listener.wake.set()

    def _begin(self) -> None:
        scenario, kept = self._changes.replayed()
        simulation = Simulation(self.prepared, endless=True)
        if scenario is not self.prepared.scenario:
            simulation.change(tuple(phases(scenario)))
        self.simulation, self._changes.latest = simulation, kept
        self._failed = simulation.failed_ticks
        self.history.ring.clear()

    def _keep_up(self, seconds: float) -> bool:
        """Advance by the time that has passed, times the speed; return whether it goes on."""
        speed = self.speed if self.state == "playing" else 1.0
        self._owed += seconds * speed / CONTROL_PERIOD
        ticks = int(self._owed)
        self._owed -= ticks
        if self.state == "stopping":
            self._come_to_rest(ticks)
        else:
            self._advance(ticks)
        return self.state in {"playing", "stopping"}

    def _come_to_rest(self, ticks: int) -> None:
        """Advance a stop: brake until the reference rests, then let the currents die away."""
        until = min(self.tick + ticks, self._rest_tick + _RELEASE_TICKS)
        self._advance(min(until, self._rest_tick) - self.tick)
        if self.tick >= self._rest_tick:
            self.simulation.release()
            self._advance(until - self.tick)
        if self.tick == self._rest_tick + _RELEASE_TICKS:
            self.state = "stopped"
            self._tell_state()

    def _advance(self, ticks: int) -> None:
        """Advance by some ticks, or to the end, and tell who listens."""
        self.history.record(self.simulation, ticks)
        failed = self.simulation.failed_ticks
        ended = self.tick == self.simulation.timeline.end
        if ended:
            self.state = "finished"
        if ended or failed != self._failed:
            self._failed = failed
            self._tell_state()
        for listener in self.listeners:
            listener.wake.set()

    def _refuse_when(self, *states: State) -> None:
        if self.state in states:
            raise WrongState(f"the session is {self.state}")

    def _tell_state(self) -> None:
        self.revision += 1
        for listener in self.listeners:
            listener.state_changed()
