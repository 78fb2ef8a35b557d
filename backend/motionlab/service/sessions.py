"""Live scenarios: paced against the clock, changed while they run, watched by many clients."""

from __future__ import annotations

import asyncio
import contextlib
import dataclasses
import secrets
import time
from collections.abc import Mapping
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, Field

from motionlab.analysis.compare import compare
from motionlab.analysis.metrics import variant_metrics
from motionlab.config.load import apply_changes, check_schedulable, phases, validate
from motionlab.config.timing import CONTROL_PERIOD, to_ticks
from motionlab.errors import ConfigError, FieldError
from motionlab.simulation.run import Prepared, Simulation, sample_page, variant_columns
from motionlab.telemetry.channels import CHANNELS, REFERENCES, Channel
from motionlab.telemetry.recording import AXES, Divergence, Recording, VariantRecord
from motionlab.telemetry.ring import Ring

RING_SECONDS = 30.0
FRAME_SECONDS = 1.0 / 60.0
CATCH_UP_SECONDS = 0.25
"""Time that a session may fall behind its clock before it lets go of it."""
METRICS_SECONDS = 10.0
_RELEASE_TICKS = to_ticks(0.05)
"""Ticks from a stop's rest until the currents, commanded to zero, are taken to be gone."""

State = Literal["paused", "playing", "stopping", "stopped", "finished"]


class Change(BaseModel):
    """A change of parameters during a session."""

    tick: int = Field(description="First tick at which it holds")
    set: dict[str, Any] = Field(description="Dotted path to new value")
    previous: dict[str, Any] = Field(description="Dotted path to the value before")


class SessionInfo(BaseModel):
    """What is known of a session."""

    id: str
    revision: int = Field(description="Grows with every change; of two reports the larger is newer")
    state: State
    tick: int
    time: float = Field(description="Simulated time, s")
    speed: float = Field(description="Simulated time per time")
    stream: str = Field(description="Path of its websocket")
    ends: int | None = Field(description="Tick at which it ends; null if it goes on")
    changes: list[Change]
    diverged: dict[str, float | None] = Field(description="Time at which a variant diverged, s")
    base: dict[str, Any] = Field(description="Resolved scenario it was created from")
    scenario: dict[str, Any] = Field(description="Resolved scenario in effect")


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
        self.changes: list[Change] = []
        self.listeners: set[Listener] = set()
        self.touched = time.monotonic()
        self.closed = False
        self.columns = column_names(self.variants)
        self.ring = Ring(len(self.columns), to_ticks(RING_SECONDS))
        self._page = sample_page(len(self.variants))
        self._task: asyncio.Task[None] | None = None
        self._rest_tick = 0
        self._begin()

    @property
    def tick(self) -> int:
        """The next tick to come."""
        return self.simulation.tick

    def info(self) -> SessionInfo:
        """Return what is known of the session."""
        return SessionInfo(
            id=self.id,
            revision=self.revision,
            state=self.state,
            tick=self.tick,
            time=self.tick * CONTROL_PERIOD,
            speed=self.speed,
            stream=f"/api/v1/sessions/{self.id}/stream",
            ends=self.simulation.timeline.end,
            changes=self.changes,
            diverged={
                name: None
                if (tick := self.simulation.failed_tick(i)) is None
                else tick * CONTROL_PERIOD
                for i, name in enumerate(self.variants)
            },
            base=self.prepared.scenario.model_dump(mode="json"),
            scenario=self.simulation.scenario.model_dump(mode="json"),
        )

    def play(self, speed: float | None = None) -> None:
        """Run against the clock, at `speed` times real time."""
        self._refuse_when("stopped", "finished")
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
        self._tell_state()

    def step(self, ticks: int) -> None:
        """Advance a paused session by some ticks."""
        self._refuse_when("playing", "stopping", "stopped", "finished")
        self._advance(ticks)
        self._tell_state()

    def reset(self) -> None:
        """Go back to tick 0 of the scenario in effect."""
        self.state = "paused"
        self._begin()
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
        self._tell_state()
        return self.tick

    def undo(self) -> None:
        """Take back the latest change, as a change of its own at the next tick."""
        if not self.changes:
            raise WrongState("nothing has been changed")
        latest = self.changes.pop()
        self.change(latest.previous)
        self.changes.pop()
        self._tell_state()

    def metrics(self) -> dict[str, Any]:
        """Return metrics of the last two periods, or ten seconds; before the first tick of none."""
        period = self.prepared.reference.period
        length = 2 * period if period else to_ticks(METRICS_SECONDS)
        recording = self.recording(max(self.ring.first, self.ring.end - length))
        start = recording.first_tick
        window = (0, recording.ticks)
        if recording.ticks == 0:
            now = start * CONTROL_PERIOD
            return {"window": {"start": now, "end": now}, "variants": {}, "comparison": {}}
        reference = dataclasses.replace(
            self.prepared.reference,
            position=recording.references[0].T,
            velocity=recording.references[1].T,
            acceleration=recording.references[2].T,
            holds=(),
            edges=(),
            window=window,
        )
        band = self.simulation.scenario.settling_band
        variants = {
            name: variant_metrics(recording, name, reference, window, settling_band=band)
            for name in self.variants
        }
        first, *others = self.variants
        return {
            "window": {
                "start": start * CONTROL_PERIOD,
                "end": (start + recording.ticks) * CONTROL_PERIOD,
            },
            "variants": variants,
            "comparison": compare(variants[first], variants[others[0]]) if others else {},
        }

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
            name: VariantRecord(
                np.ascontiguousarray(samples[i].transpose(1, 0, 2)), self._divergence(i)
            )
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

    def _begin(self) -> None:
        self.simulation = Simulation(self.prepared, endless=True)
        if self.changes:
            document = self.prepared.scenario.model_dump(mode="json")
            for change in self.changes:
                document = apply_changes(document, change.set)
            self.simulation.change(tuple(phases(validate(document))))
        self.ring.clear()

    def _start_pacing(self) -> None:
        if self._task is None or self._task.done():
            self._task = asyncio.create_task(self._pace())

    async def _pace(self) -> None:
        """Advance in frames so that simulated time keeps up with the clock times the speed."""
        last, owed = time.monotonic(), 0.0
        due = last
        while self.state in {"playing", "stopping"}:
            due = max(due + FRAME_SECONDS, last)
            await asyncio.sleep(due - time.monotonic())
            if self.state not in {"playing", "stopping"}:  # paused or reset meanwhile
                break
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
                self.state = "finished"
                self._tell_state()
                break
            self.ring.append(self._columns(room, start, count))
        for listener in self.listeners:
            listener.wake.set()

    def _columns(self, samples: NDArray[np.float32], start: int, count: int) -> NDArray[np.float32]:
        """Return every column of the ring over some ticks, in the order of `column_names`."""
        shared = np.stack(self.simulation.timeline.at(start, start + count))  # (4, ticks, axes)
        columns = np.empty((len(self.columns), count), dtype=np.float32)
        references = shared.transpose(2, 0, 1).reshape(-1, count)
        columns[: len(references)] = references
        size = len(AXES) * len(CHANNELS)
        for variant in range(len(self.variants)):
            first = len(references) + variant * size
            part = variant_columns(samples, variant, count).transpose(1, 0, 2)
            columns[first : first + size] = part.reshape(size, count)
            failed = self.simulation.failed_tick(variant)
            if failed is not None:
                columns[first : first + size, max(0, failed - start) :] = np.nan
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
