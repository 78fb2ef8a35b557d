"""Live scenarios: paced against the clock, changed while they run, watched by many clients."""

from __future__ import annotations

import asyncio
import contextlib
import secrets
import time
from collections.abc import Mapping
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, Field

from motionlab.config.changes import apply_changes, check_schedulable, labelled
from motionlab.config.load import phases, validate
from motionlab.config.planar import AXES
from motionlab.config.scenario import Scenario
from motionlab.config.timing import CONTROL_PERIOD, to_ticks
from motionlab.errors import ConfigError, FieldError
from motionlab.service.latest import latest_metrics
from motionlab.simulation.prepare import Prepared
from motionlab.simulation.simulation import Simulation, sample_page, variant_columns
from motionlab.telemetry.channels import CHANNELS, REFERENCES, Channel
from motionlab.telemetry.recording import Divergence, Recording, VariantRecord
from motionlab.telemetry.ring import Ring

RING_SECONDS = 30.0
FRAME_SECONDS = 1.0 / 60.0
CATCH_UP_SECONDS = 0.25
"""Time that a session may fall behind its clock before it lets go of it."""
METRICS_SECONDS = 10.0
CHANGES_MAX = 100
"""Changes that can be undone; those before them stay in effect."""
_RELEASE_TICKS = to_ticks(0.05)
"""Ticks from a stop's rest until the currents, commanded to zero, are taken to be gone."""

State = Literal["paused", "playing", "stopping", "stopped", "finished"]


class Change(BaseModel):
    """A change of parameters during a session."""

    tick: int = Field(description="First tick at which it holds; 0 after a reset")
    set: dict[str, Any] = Field(description="Dotted path to new value")
    previous: dict[str, Any] = Field(description="Dotted path to the value before")


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
        self.changes: list[Change] = []
        self.listeners: set[Listener] = set()
        self.touched = time.monotonic()
        self.closed = False
        self.columns = column_names(self.variants)
        self.ring = Ring(len(self.columns), to_ticks(RING_SECONDS))
        self._page = sample_page(len(self.variants))
        self._task: asyncio.Task[None] | None = None
        self._rest_tick = 0
        self._start = prepared.scenario
        self._begin()

    @property
    def size(self) -> int:
        """What it holds in memory, bytes: the ring, and the motion."""
        return self.ring.size + self.prepared.motion_size

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
            changes=self.changes,
            diverged={
                name: None if tick is None else tick * CONTROL_PERIOD
                for name, tick in zip(self.variants, self._failed_ticks(), strict=True)
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
            self._start_pacing()
        self._tell_state()

    def pause(self) -> None:
        """Halt the clock."""
        self._refuse_when("stopped", "stopping")
        if self.state == "playing":
            self.state = "paused"
            self._stop_pacing()
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
        self._stop_pacing()
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
        self._start_pacing()
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
        check_schedulable(changes, "set")
        changes = labelled(changes)
        before = self.simulation.scenario.model_dump(mode="json")
        scenario = validate(apply_changes(before, changes))
        if list(scenario.variants) != self.variants:
            raise ConfigError(FieldError(loc="set", message="adds or takes away a variant"))
        previous = {}
        for path in changes:
            with contextlib.suppress(LookupError, TypeError, ValueError):  # it came with the change
                previous[path] = value_at(before, path.removesuffix(".base"))
        self.simulation.change(tuple(phases(scenario, self.tick)))
        self.changes.append(Change(tick=self.tick, set=dict(changes), previous=previous))
        if len(self.changes) > CHANGES_MAX:
            self._start = _changed(self._start, self.changes.pop(0)) or self._start
        self._tell_state()
        return self.tick

    def undo(self) -> None:
        """Take back the latest change, as a change of its own at the next tick."""
        if not self.changes:
            raise WrongState("nothing has been changed")
        self.change(self.changes[-1].previous)
        del self.changes[-2:]
        self._tell_state()

    async def metrics(self) -> dict[str, Any]:
        """Return metrics of the last two periods, or ten seconds; before the first tick of none.

        Samples are taken now and measured in a thread, so that streams need not wait.
        """
        period = self.prepared.reference.period
        length = 2 * period if period else to_ticks(METRICS_SECONDS)
        recording = self.recording(max(self.ring.first, self.ring.end - length))
        band = self.simulation.scenario.settling_band
        return await asyncio.to_thread(
            latest_metrics, recording, self.prepared.reference, settling_band=band
        )

    def recording(self, start: int | None = None) -> Recording:
        """Return what the ring holds from `start` on, or all of it."""
        start = self.ring.first if start is None else start
        data = self.ring.read(slice(None), start, self.ring.end)
        count = len(REFERENCES)
        shared = data[: count * len(AXES)].reshape(len(AXES), count, -1).transpose(1, 0, 2)
        position, velocity, acceleration, _ = self.simulation.timeline.at(start, self.ring.end)
        exact = np.stack([position.T, velocity.T, acceleration.T, shared[-1]])
        samples = data[count * len(AXES) :].reshape(
            len(self.variants), len(AXES), len(CHANNELS), -1
        )
        records = {
            name: VariantRecord(samples[i].transpose(1, 0, 2), self._divergence(i))
            for i, name in enumerate(self.variants)
        }
        braked = self.state in {"stopping", "stopped"}
        return Recording(exact if not braked else shared.astype(np.float64), records, start)

    async def close(self) -> None:
        """End pacing and every stream."""
        self.closed = True
        self.state = "finished"
        if self._task is not None:
            self._task.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await self._task
        for listener in self.listeners:
            listener.wake.set()

    def _divergence(self, variant: int) -> Divergence | None:
        """Return that a variant has diverged; of when and how, metrics need to know nothing."""
        tick = self.simulation.failed_tick(variant)
        return None if tick is None else Divergence(tick, "", ())

    def _failed_ticks(self) -> list[int | None]:
        return [self.simulation.failed_tick(i) for i in range(len(self.variants))]

    def _begin(self) -> None:
        scenario, kept = self._start, []
        for change in self.changes:
            changed = _changed(scenario, change)
            if changed is not None:
                scenario = changed
                kept.append(change.model_copy(update={"tick": 0}))
        simulation = Simulation(self.prepared, endless=True)
        if scenario is not self.prepared.scenario:
            simulation.change(tuple(phases(scenario)))
        self.simulation, self.changes = simulation, kept
        self._failed = self._failed_ticks()
        self.ring.clear()

    def _start_pacing(self) -> None:
        if self._task is None or self._task.done():
            self._task = asyncio.create_task(self._pace())

    def _stop_pacing(self) -> None:
        """End pacing now; time until another play does not count."""
        if self._task is not None:
            self._task.cancel()
            self._task = None

    async def _pace(self) -> None:
        """Advance in frames so that simulated time keeps up with the clock times the speed."""
        last, owed = time.monotonic(), 0.0
        due = last
        while self.state in {"playing", "stopping"}:
            due = max(due + FRAME_SECONDS, last)
            await asyncio.sleep(due - time.monotonic())
            now = time.monotonic()
            passed = min(now - last, CATCH_UP_SECONDS)
            last = now
            owed += passed * (self.speed if self.state == "playing" else 1.0) / CONTROL_PERIOD
            ticks = int(owed)
            owed -= ticks
            if self.state == "stopping":
                self._come_to_rest(ticks)
            else:
                self._advance(ticks)

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
        """Advance by some ticks, or to the end, and put every sample into the ring."""
        until = self.tick + ticks
        while self.tick < until:
            room = self._page[:, : until - self.tick]
            start = self.tick
            count = self.simulation.advance(room)
            if count == 0:
                break
            self.ring.append(self._columns(room, start, count))
        failed = self._failed_ticks()
        ended = self.tick == self.simulation.timeline.end
        if ended:
            self.state = "finished"
        if ended or failed != self._failed:
            self._failed = failed
            self._tell_state()
        for listener in self.listeners:
            listener.wake.set()

    def _columns(self, samples: NDArray[np.float32], start: int, count: int) -> NDArray[np.float32]:
        """Return every column of the ring over some ticks, in the order of `column_names`."""
        columns = np.empty((len(self.columns), count), dtype=np.float32)
        shared = len(AXES) * len(REFERENCES)
        columns[:shared] = self.simulation.asked(start, start + count)
        own = columns[shared:].reshape(len(self.variants), len(AXES), len(CHANNELS), count)
        for variant, rows in enumerate(own):
            rows[:] = variant_columns(samples, variant, count).transpose(1, 0, 2)
            failed = self.simulation.failed_tick(variant)
            if failed is not None:
                rows[..., max(0, failed - start) :] = np.nan
        return columns

    def _refuse_when(self, *states: State) -> None:
        if self.state in states:
            raise WrongState(f"the session is {self.state}")

    def _tell_state(self) -> None:
        self.revision += 1
        for listener in self.listeners:
            listener.state_changed()


class Listener:
    """What a session has to tell one stream; the stream looks when it is woken."""

    def __init__(self) -> None:
        self.wake = asyncio.Event()
        self.was_reset = False
        self.has_changed = False

    def reset(self) -> None:
        """Tell that the session is back at tick 0."""
        self.was_reset = True
        self.wake.set()

    def state_changed(self) -> None:
        """Tell that state, speed or parameters have changed."""
        self.has_changed = True
        self.wake.set()


def _changed(scenario: Scenario, change: Change) -> Scenario | None:
    """Return a scenario with a change from its first tick on, or None where it does not fit."""
    try:
        return validate(apply_changes(scenario.model_dump(mode="json"), change.set))
    except ConfigError:
        return None


def column_names(variants: list[str]) -> list[tuple[str, Channel]]:
    """Return name and channel of every streamed column, in the order of the ring."""
    shared = [(f"{axis}.{channel.name}", channel) for axis in AXES for channel in REFERENCES]
    return shared + [
        (f"{name}.{axis}.{channel.name}", channel)
        for name in variants
        for axis in AXES
        for channel in CHANNELS
    ]


def value_at(tables: Any, path: str) -> Any:
    """Return what stands at a dotted path."""
    for key in path.split("."):
        tables = tables[int(key)] if isinstance(tables, list) else tables[key]
    return tables
