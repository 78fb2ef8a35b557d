"""A recorded stretch, checked: what each axis did, and whether that can tell what it would do."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab.analysis.columns import Columns
from motionlab.config.changes import apply_changes
from motionlab.config.load import epochs, load_scenario
from motionlab.config.planar import AXES
from motionlab.config.scenario import LoadConfig, Scenario
from motionlab.errors import ConfigError, FieldError
from motionlab.library.columns import of_run
from motionlab.library.run import RunDetail
from motionlab.studies.minute.documents import SECONDS_MAX, SECONDS_MIN, MinuteRequest
from motionlab.studies.record.columns import variant_of
from motionlab.studies.record.part import (
    Part,
    first_stretch,
    kept_run,
    part_of,
    rounded,
    without_gaps,
)
from motionlab.timing import CONTROL_PERIOD, to_ticks
from motionlab.trajectories.reference import Reference

Array = NDArray[np.float64]

EDGE = to_ticks(0.3)
"""Ticks at either end that no metric is of: there filters and the simulation settle."""
REVERSALS_MIN = 2
_STILL = 2e-4  # m/s: slower references do not move
_REFERENCES = ("position_reference", "velocity_reference", "acceleration_reference")
_CHANNELS = ("following_error", "force_realised", "force_saturated", "current_saturated")


@dataclass(frozen=True)
class RecordedAxis:
    """One axis over a stretch, tick by tick.

    Attributes
    ----------
    reference : ndarray, shape (3, ticks)
        Position, velocity and acceleration, m, m/s, m/s^2.
    error : ndarray, shape (ticks,)
        Following error as measured, m.
    force : ndarray, shape (ticks,)
        In effect by the controller's map, N.
    reversals : int
        Of the reference.
    """

    reference: Array
    error: Array
    force: Array
    reversals: int

    @property
    def position(self) -> Array:
        """As measured, m."""
        return self.reference[0] - self.error


@dataclass(frozen=True)
class MinutePlan:
    """A recorded stretch that can be predicted from, checked.

    Attributes
    ----------
    request : MinuteRequest
        As validated.
    run : RunDetail
        That recorded it.
    first : int
        Its first sample in the run.
    then, now : Scenario
        In effect when it was recorded; the same with the changes of the request.
    variant, other : str
        Whose record is read, and whose controller is tried.
    axes : dict of str to RecordedAxis
        Both.
    reversing_axes : tuple of str
        Axes that move and reverse.
    warnings : tuple of str
        What a reader must know.
    """

    request: MinuteRequest
    run: RunDetail
    first: int
    then: Scenario
    now: Scenario
    variant: str
    other: str
    axes: dict[str, RecordedAxis]
    reversing_axes: tuple[str, ...]
    warnings: tuple[str, ...]

    @property
    def ticks(self) -> int:
        """Of the stretch."""
        return len(self.axes["x"].error)

    @property
    def seconds(self) -> float:
        """Simulated time of all members, s."""
        return self.ticks * CONTROL_PERIOD * (self.request.members + 2)

    @property
    def reference(self) -> Reference:
        """The motion, as it was recorded."""
        position, velocity, acceleration = (
            np.stack([each.reference[row] for each in self.axes.values()], axis=1)
            for row in range(len(_REFERENCES))
        )
        return Reference(
            position=position,
            velocity=velocity,
            acceleration=acceleration,
            end=(float(position[-1, 0]), float(position[-1, 1])),
            moving=self.reversing_axes,
            window=(EDGE, self.ticks - EDGE),
            holds=(),
            edges=(),
            period=0,
            for_ever=False,
        )


def plan(request: MinuteRequest, source: object = None) -> MinutePlan:
    """Return the checked stretch of a request.

    Raises
    ------
    ConfigError
        Naming what is wrong, or why the record cannot tell: no such run or variant, a measurement
        without controllers, a part without samples, of drives that stopped, at a limit, too short
        or without reversals.
    """
    run = kept_run(request.run)
    if not np.isclose(run.period, CONTROL_PERIOD):
        message = "is not sampled once a control period"
        raise ConfigError(FieldError("run", message, run.period, f"{CONTROL_PERIOD:g}", "s"))
    if run.scenario_document is None:
        message = "is a measurement without controllers: only a run of the lab's own has them"
        raise ConfigError(FieldError("run", message, request.run))
    longest = to_ticks(SECONDS_MAX)
    part = part_of(request, run, seconds_min=SECONDS_MIN, samples_max=longest)
    variant = variant_of(request.variant, run)
    part, axes, warnings = _read(part, variant)
    then = scenario_at(run, part.first)
    now = load_scenario(_tables(then), request.set)
    letters = list(now.variants)
    other = _letter(request.other, letters, "other", letters[min(1, len(letters) - 1)])
    if now.variants[other].controller.learnt:
        message = "adds a learnt force, which belongs to laps: the stretch has none"
        raise ConfigError(FieldError(f"variants.{other}.controller.learnt", message, value=True))
    if variant == other and now.variants[other] == then.variants[variant]:
        message = "is the controller that was recorded; change it by `set`, or name another"
        raise ConfigError(FieldError("other", message, other))
    reversing_axes = tuple(axis for axis, each in axes.items() if each.reversals >= REVERSALS_MIN)
    if not reversing_axes:
        message = "reverses too seldom: friction cannot be distinguished from a constant force"
        raise ConfigError(
            FieldError(
                "run",
                message,
                max(each.reversals for each in axes.values()),
                f">= {REVERSALS_MIN} reversals on an axis",
            )
        )
    warnings += [
        f"{axis} moves, but reverses less than {REVERSALS_MIN} times: it is not predicted"
        for axis, each in axes.items()
        if axis not in reversing_axes and np.abs(each.reference[1]).max() > _STILL
    ]
    return MinutePlan(
        request, run, part.first, then, now, variant, other, axes, reversing_axes, tuple(warnings)
    )


def scenario_at(run: RunDetail, first: int) -> Scenario:
    """Return what was in effect at a sample of a run of the lab's own.

    A session's changes until then have been made, and what a schedule had changed.
    """
    tick = run.first_tick + first
    tables: dict[str, Any] = dict(run.scenario_document or {})
    for event in run.events:
        if event.kind == "change" and event.tick <= tick:
            tables = apply_changes(tables, event.set)
    return [changed for begins, changed in epochs(load_scenario(tables)) if begins <= tick][-1]


def _tables(scenario: Scenario) -> dict[str, Any]:
    """Return a scenario that neither changes by itself, nor is loaded."""
    alone = scenario.model_copy(
        update={"schedule": (), "learnt": None, "window": None, "load": LoadConfig()}
    )
    return alone.model_dump(mode="json")


def _letter(letter: str | None, letters: list[str], loc: str, default: str) -> str:
    if letter is not None and letter not in letters:
        allowed = "one of " + ", ".join(letters)
        raise ConfigError(FieldError(loc, "is no variant of the run", letter, allowed))
    return letter or default


def _read(part: Part, variant: str) -> tuple[Part, dict[str, RecordedAxis], list[str]]:
    """Return the stretch without gaps, both axes, and warnings; refuse what spoils a stretch."""
    columns = of_run(part.run.id)
    names = {axis: _names(columns, variant, axis) for axis in AXES}
    every = list(dict.fromkeys(name for each in names.values() for name in each))
    samples = columns.read(every)[:, part.first : part.stop].astype(np.float64)
    stretch, warnings = without_gaps(part, samples, SECONDS_MIN)
    begin = stretch.first - part.first
    samples = samples[:, begin : begin + stretch.samples]
    first = part.run.first_tick + stretch.first
    last = first + stretch.samples
    for event in part.run.events:
        if event.kind == "stop" and first <= event.tick < last:
            at = rounded((event.tick - part.run.first_tick) * CONTROL_PERIOD)
            message = "was stopped at this time: choose a part by start and end"
            raise ConfigError(FieldError("run", message, at, unit="s"))
    if any(e.kind in {"change", "law"} and first < e.tick < last for e in part.run.events):
        warnings.append(
            "controllers were changed within the stretch: the recorded one is simulated as it was "
            "at the beginning"
        )
    rows = {name: samples[k] for k, name in enumerate(every)}
    axes = {
        axis: _axis(stretch, axis, np.stack([rows[name] for name in names[axis]])) for axis in AXES
    }
    return stretch, axes, warnings


def _names(columns: Columns, variant: str, axis: str) -> list[str]:
    names = [f"{axis}.{name}" for name in _REFERENCES]
    names += [f"{variant}.{axis}.{name}" for name in _CHANNELS]
    for name in names:
        if name not in columns.units:
            raise ConfigError(FieldError("run", f"has no column {name}", columns.name))
    return names


def _axis(part: Part, axis: str, samples: Array) -> RecordedAxis:
    limited: NDArray[np.bool_] = np.logical_or(*(samples[-2:] > 0.0))
    if limited.any():
        message = (
            f"has force or currents of {axis} at their limit, where the force says nothing of the "
            f"motor, in {100 * limited.mean():.3g} % of the stretch, first from "
            f"{part.interval(*first_stretch(limited))}: choose a part by start and end"
        )
        raise ConfigError(FieldError("run", message))
    reference = samples[: len(_REFERENCES)]
    error, force = samples[len(_REFERENCES) : len(_REFERENCES) + 2]
    way = np.sign(reference[1][np.abs(reference[1]) > _STILL])
    return RecordedAxis(reference, error, force, int(np.count_nonzero(np.diff(way))))
