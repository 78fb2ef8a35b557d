"""A run simulated again from its record, and every sample compared bit for bit."""

from __future__ import annotations

import hashlib
import itertools
import sys
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from copy import deepcopy
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, Field

from motionlab import __version__
from motionlab.config.controller import CompensationConfig
from motionlab.config.load import epochs, load_scenario
from motionlab.config.planar import AXES
from motionlab.config.scenario import Scenario
from motionlab.errors import ConfigError, NotReplayable
from motionlab.executors.code import processor
from motionlab.kernel.force_maps import check_maps, maps_of
from motionlab.lanes import model_hash
from motionlab.laws import LAWS
from motionlab.library.new_run import own_laws_of
from motionlab.library.replayed_errors import ErrorChange, ErrorChanges
from motionlab.library.run import Event, RunDetail
from motionlab.simulation.change import changed
from motionlab.simulation.prepare import Prepared, prepare
from motionlab.simulation.record import record
from motionlab.simulation.simulation import ReadyEpoch, Simulation, ready, sample_page
from motionlab.telemetry.channels import stream_columns
from motionlab.telemetry.law_channels import StateColumn, any_law, state_columns
from motionlab.telemetry.parquet import read_ticks
from motionlab.telemetry.recorder import ROWS

if TYPE_CHECKING:
    from pyarrow import parquet

_COPIES = 4  # of a row group: as Arrow has it, recorded, simulated, and what differs


class FirstDifference(BaseModel):
    """The first sample that is not the recorded one."""

    tick: int
    time: float = Field(description="s")
    channel: str
    unit: str
    recorded: float | str | None = Field(description="null: the variant had diverged")
    simulated: float | str | None = Field(description="null: diverged, or the motion had ended")
    difference: float | None = Field(description="Simulated minus recorded; null without a number")


class Replay(BaseModel):
    """Whether a run is bit-identical to its record simulated again."""

    identical: bool
    channels: int = Field(description="Channels that were compared")
    ticks: int = Field(description="Recorded ticks that were compared, of each channel")
    missing: int = Field(description="Ticks without a record: gaps, or the end of a simulation")
    first: FirstDifference | None = Field(description="Where the first difference is")
    samples: int = Field(description="Samples that differ")
    differing: list[str] = Field(description="Channels of which some do")
    errors: list[ErrorChange] = Field(
        description="Following errors, recorded and simulated, over the window of the run's "
        "metrics, else over all of it; empty where none of it is recorded"
    )
    reasons: list[str] = Field(description="What may be why; empty where nothing differs")


class Again(NamedTuple):
    """A run that can be simulated again.

    Attributes
    ----------
    run : RunDetail
        The run.
    prepared : Prepared
        Its scenario.
    size : int
        Memory that its replay takes, bytes.
    """

    run: RunDetail
    prepared: Prepared
    size: int

    @property
    def work(self) -> float:
        """Simulated time summed over variants, s."""
        return self.run.duration * len(self.run.variants)


def again(run: RunDetail) -> Again:
    """Prepare a run to be simulated again.

    Raises
    ------
    NotReplayable
        If it is of a real machine, or its scenario is no longer valid.
    """
    if run.scenario_document is None:
        raise NotReplayable(f"{run.id} has no scenario: there is nothing to simulate again")
    if run.kind == "drive":
        raise NotReplayable(f"{run.id} was measured on drives: they do not repeat it bit for bit")
    tables = _without_other_laws(run.id, run.scenario_document)
    try:
        prepared = prepare(load_scenario(tables), checked=True)
        for _, scenario in prepared.epochs:
            check_maps(scenario)
    except ConfigError as error:
        raise NotReplayable(
            f"{run.id}, kept by {run.version}, cannot be simulated by {__version__}: {error}"
        ) from error
    size = samples_size(len(run.columns), run.ticks)
    return Again(run, prepared, size + prepared.motion_size)


def samples_size(columns: int, ticks: int) -> int:
    """Return the memory of samples that are compared at once, bytes."""
    return _COPIES * columns * min(ticks, ROWS) * np.dtype(np.float32).itemsize


def _without_other_laws(run: str, document: Mapping[str, Any]) -> dict[str, Any]:
    """Return a scenario without parameters of laws that are not here, where it does not use them.

    Raises
    ------
    NotReplayable
        If it uses one that is not here.
    """
    tables = deepcopy(dict(document))
    for variant in tables.get("variants", {}).values():
        compensation = variant.get("controller", {}).get("compensation", {})
        if (law := compensation.get("law", "off")) not in LAWS:
            raise NotReplayable(
                f"{run} has the law {law}, whose file is not here: --laws names its folder"
            )
        for name in [name for name in compensation if name not in CompensationConfig.model_fields]:
            del compensation[name]
    return tables


def replay(
    again: Again,
    file: parquet.ParquetFile,
    progress: Callable[[float], None] = lambda _: None,
) -> Replay:
    """Simulate a run again and compare every channel with its record, bit for bit.

    A live run is simulated with its changes, pushes and its stop at their ticks. A value that is
    missing, after a divergence, equals one that is missing. Ticks that were not recorded are
    simulated and not compared. Memory is that of a row group, whatever the length.

    Parameters
    ----------
    wanted : Again
        From `again`.
    file : ParquetFile
        Its telemetry.
    progress : callable
        Called with the share that is done.

    Raises
    ------
    NotReplayable
        If a recorded change is no longer valid.
    """
    run = again.run
    there = set(file.schema_arrow.names)
    states = [each for each in state_columns(any_law(run.variants)) if each.name in there]
    units = {name: channel.unit for name, channel in stream_columns(run.variants)}
    units |= {each.name: each.channel.unit for each in states}
    names = list(units)
    rows = [row for row, name in enumerate(names) if name in there]
    names = [names[row] for row in rows]
    player = _Player(run, again.prepared, states)
    errors = ErrorChanges(names, _window(run))
    totals = np.zeros(len(names), dtype=np.int64)
    first: FirstDifference | None = None
    compared = 0
    for start, recorded in _pieces(file, names):
        player.go(start)
        simulated = player.samples(recorded.shape[1])[rows]
        differs = _differs(recorded, simulated)
        if first is None and differs.any():
            tick = int(np.argmax(differs.any(axis=0)))
            row = int(np.argmax(differs[:, tick]))
            values = (recorded[row, tick], simulated[row, tick])
            first = _difference(start + tick, run.period, names[row], units[names[row]], *values)
        totals += np.count_nonzero(differs, axis=1)
        errors.add(start, recorded, simulated)
        compared += recorded.shape[1]
        progress(compared / max(1, run.ticks))
    expected = player.simulation.tick
    if run.kind == "simulation":
        expected = again.prepared.reference.ticks
    missing = max(0, expected - compared)
    complete = len(names) == len(units) == len(there - {"tick", "time"})
    whole = complete and (run.kind == "live" or missing == 0)
    identical = first is None and whole
    return Replay(
        identical=identical,
        channels=len(names),
        ticks=compared,
        missing=missing,
        first=first,
        samples=int(totals.sum()),
        differing=[name for name, total in zip(names, totals, strict=True) if total],
        errors=errors.changes(),
        reasons=[] if identical else _reasons(run, again.prepared.scenario, whole=whole),
    )


def _window(run: RunDetail) -> tuple[int, int]:
    """Return first tick of the metrics and the one after the last, of all where there are none."""
    window = run.result.get("window")
    if window is None:
        return 0, sys.maxsize
    return round(window["start"] / run.period), round(window["end"] / run.period)


class _Player:
    """Simulates a run as it was: live ones with what happened to them."""

    def __init__(self, run: RunDetail, prepared: Prepared, states: list[StateColumn]) -> None:
        self.simulation = Simulation(prepared, endless=run.kind == "live")
        self._page = sample_page(len(run.variants), states=bool(states))
        self._states = states
        self._columns = len(stream_columns(run.variants)) + len(states)
        self._made: list[ReadyEpoch] = []
        self._acts = deque(sorted(_acts(run.events), key=lambda act: act[0]))

    def go(self, tick: int) -> None:
        """Simulate up to a tick."""
        while (left := tick - self.simulation.tick) > 0:
            most = min(left, self._page.shape[1])
            if not self._advance(np.empty((self._columns, most), dtype=np.float32)):
                return

    def samples(self, ticks: int) -> NDArray[np.float32]:
        """Simulate some ticks and return their samples; NaN after the end of the motion."""
        columns = np.full((self._columns, ticks), np.nan, dtype=np.float32)
        done = 0
        while done < ticks and (count := self._advance(columns[:, done:])):
            done += count
        return columns

    def _advance(self, columns: NDArray[np.float32]) -> int:
        while self._acts and self._acts[0][0] <= self.simulation.tick:
            _, act, event = self._acts.popleft()
            act(self, event)
        if self._acts:
            columns = columns[:, : self._acts[0][0] - self.simulation.tick]
        return record(self.simulation, self._page, columns, self._states)

    def check(self, event: Event) -> None:
        """Make a change ready, as the session did before the tick at which it held."""
        tick = self.simulation.tick
        try:
            after, _ = changed(self.simulation.scenario, event.set, tick)
            self._made = ready(epochs(after, tick))
        except ConfigError as error:
            raise NotReplayable(
                f"the change at tick {event.tick} is no longer valid: {error}"
            ) from error

    def adopt(self, _: Event) -> None:
        """Let a change take effect."""
        self.simulation.adopt(self._made)

    def push(self, event: Event) -> None:
        """Push the mover."""
        assert event.axis is not None
        assert event.force is not None
        assert event.ticks is not None
        self.simulation.push(AXES.index(event.axis), event.force, event.ticks)

    def stop(self, _: Event) -> None:
        """Brake to rest."""
        self.simulation.stop()


_Act = tuple[int, Callable[[_Player, Event], None], Event]


def _acts(events: Sequence[Event]) -> Iterator[_Act]:
    """Yield what happened at which tick."""
    for event in events:
        match event.kind:
            case "change":
                yield event.tick if event.checked is None else event.checked, _Player.check, event
                yield event.tick, _Player.adopt, event
            case "push":
                yield event.tick, _Player.push, event
            case "stop":
                yield event.tick, _Player.stop, event
            case "gap" | "play" | "pause" | "speed" | "reset" | "law":
                pass


def _pieces(
    file: parquet.ParquetFile, names: Sequence[str]
) -> Iterator[tuple[int, NDArray[np.float32]]]:
    """Yield first tick and samples of consecutive ticks, a row group at most."""
    row = 0
    for group in range(file.num_row_groups):
        ticks = file.read_row_group(group, columns=["tick"])["tick"].to_numpy()
        samples = read_ticks(file, names, row, row + len(ticks))
        row += len(ticks)
        cuts = [0, *(np.flatnonzero(np.diff(ticks) != 1) + 1).tolist(), len(ticks)]
        for start, stop in itertools.pairwise(cuts):
            if stop > start:
                yield int(ticks[start]), samples[:, start:stop]


def _differs(recorded: NDArray[np.float32], simulated: NDArray[np.float32]) -> NDArray[np.bool_]:
    differs = np.ascontiguousarray(recorded).view(np.uint32) != simulated.view(np.uint32)
    return differs & ~(np.isnan(recorded) & np.isnan(simulated))


def _difference(
    tick: int, period: float, channel: str, unit: str, *values: np.float32
) -> FirstDifference:
    recorded, simulated = (float(value) for value in values)
    difference = simulated - recorded
    return FirstDifference(
        tick=tick,
        time=tick * period,
        channel=channel,
        unit=unit,
        recorded=_finite(recorded),
        simulated=_finite(simulated),
        difference=difference if np.isfinite(difference) else None,
    )


def _finite(value: float) -> float | str | None:
    if np.isnan(value):
        return None
    return value if np.isfinite(value) else str(value)


def _reasons(run: RunDetail, scenario: Scenario, *, whole: bool) -> list[str]:
    """Return how record and replay are known to differ."""
    facts: list[tuple[str, Any, Any]] = [
        ("version", run.version, __version__),
        ("model's sources", run.model, model_hash()),
        ("processor", run.processor, processor()),
        ("force maps", run.maps, maps_of(scenario)),
        ("law of one's own", _digests(run.laws), _digests(own_laws_of(scenario))),
    ]
    reasons = [
        f"other {what}: kept with {_short(then)}, simulated with {_short(now)}"
        for what, then, now in facts
        if then != now
    ]
    for event in run.events:
        if event.kind == "law":
            reasons.append(f"the file of law {event.law} changed at tick {event.tick}")
    if not whole:
        reasons.append("the record does not hold every tick and every channel")
    return reasons or ["none is known: version, model, processor and maps are the same"]


def _digests(sources: dict[str, str]) -> dict[str, dict[str, str]]:
    """Return a hash of each text, as `_short` shows it."""
    return {
        name: {"digest": hashlib.sha256(text.encode()).hexdigest()[:12]}
        for name, text in sources.items()
    }


def _short(value: Any) -> str:
    if not isinstance(value, dict):
        return str(value)
    return ", ".join(f"{loc} {entry['digest']}" for loc, entry in value.items()) or "none"
