"""Many cases of one scenario: metrics of each, as a run of it alone gives them, to the last bit."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab.config.changes import apply_changes
from motionlab.config.load import load_scenario, validate
from motionlab.config.planar import AXES
from motionlab.config.scenario import Scenario
from motionlab.config.timing import CONTROL_PERIOD
from motionlab.errors import ConfigError, FieldError
from motionlab.kernel.build import mover_parameters
from motionlab.results.metrics import DEFINITIONS
from motionlab.simulation.batch_runner import Course, Progress
from motionlab.simulation.prepare import Prepared, prepare

Array = NDArray[np.float64]

_PREPARING = 0.2
"""Share of the work that is done when every case has been checked; a guess, for progress."""

TICKS_MAX = 600_000
"""Ticks of a case: the inputs of all of them lie in memory while a batch runs."""


@dataclass(frozen=True)
class Batch:
    """Metrics of every case, variant and axis.

    Attributes
    ----------
    variants : tuple of str
        Second axis of the arrays; their third is AXES.
    metrics : dict of str to ndarray, shape (cases, variants, axes)
        Keys of `motionlab.results.metrics.DEFINITIONS`, in SI units; NaN where the run of the case
        has None or nothing: a variant that diverged, an axis that does not move, no hold.
    failed : ndarray of int, shape (cases, variants)
        Tick at which a variant diverged; -1 where it has not.
    """

    variants: tuple[str, ...]
    metrics: dict[str, Array]
    failed: NDArray[np.int64]


def run_batch(
    source: str | Path | Mapping[str, Any] | Scenario,
    cases: Sequence[Mapping[str, Any]],
    *,
    threads: int | None = None,
    progress: Progress | None = None,
) -> Batch:
    """Run many cases of one scenario.

    Cases that share their motion, load and noise, which takes equal seeds where there is noise at
    all, share one preparation of them and run side by side; others take turns.

    Parameters
    ----------
    source : str, Path, mapping or Scenario
        As `load_scenario` takes it, or a scenario.
    cases : sequence of mapping
        Of each case the changes: dotted path to value.
    threads : int, optional
        How many threads to use; one for each core when left out.
    progress : callable, optional
        Takes the share done; what it raises ends the batch.

    Returns
    -------
    Batch
        The same bits for the same case, whatever runs beside it.

    Raises
    ------
    ConfigError
        Naming the case and what is wrong with it; if there are none; if a case adds a variant.
    Infeasible
        If the motor cannot follow the motion of a case.
    """
    base = source if isinstance(source, Scenario) else load_scenario(source)
    document = base.model_dump(mode="json")
    prepared = []
    for index, changes in enumerate(cases):
        prepared.append(_prepared(document, changes, index))
        if progress is not None:
            progress(_PREPARING * (index + 1) / len(cases))
    rest = None if progress is None else lambda share: progress(_PREPARING + 0.8 * share)
    return run_prepared(prepared, threads=threads, progress=rest)


def run_prepared(
    cases: Sequence[Prepared],
    *,
    threads: int | None = None,
    progress: Progress | None = None,
    watch: Callable[[NDArray[np.int64], NDArray[np.float32]], None] | None = None,
) -> Batch:
    """Run many prepared scenarios of the same variants; see `run_batch`.

    Parameters
    ----------
    cases : sequence of Prepared
        At least one.
    threads : int, optional
        How many threads to use; one for each core when left out.
    progress : callable, optional
        Takes the share done; what it raises ends the batch.
    watch : callable, optional
        Takes the numbers of some movers, ``case * len(variants) + variant``, and their following
        errors, (movers, axes, ticks), m, which are NaN from where an axis diverged.
    """
    if not cases:
        raise ConfigError(FieldError("cases", "needs at least one", 0, ">= 1", "1"))
    variants = tuple(cases[0].scenario.variants)
    for index, case in enumerate(cases):
        _check(case, variants, index)
    shape = (len(cases), len(variants), len(AXES))
    metrics = {name: np.full(shape, np.nan) for name in DEFINITIONS}
    failed = np.full(shape, -1, dtype=np.int64)
    groups: dict[object, list[int]] = {}
    for index, case in enumerate(cases):
        groups.setdefault(_shared(case), []).append(index)

    done = 0
    for members in groups.values():

        def part(share: float, done: int = done, size: int = len(members)) -> None:
            if progress is not None:
                progress((done + share * size) / len(cases))

        course = Course(cases[members[0]])
        lanes = np.concatenate([lanes_of(cases[i]) for i in members], axis=1)
        numbers = (np.array(members)[:, None] * len(variants) + np.arange(len(variants))).ravel()

        def look(first: int, errors: NDArray[np.float32], numbers: Any = numbers) -> None:
            if watch is not None:
                watch(numbers[first : first + len(errors)], errors)

        scores = course.score(
            lanes, threads=threads, progress=part, watch=None if watch is None else look
        )
        own = (len(members), *shape[1:])
        failed[members] = scores.failed.reshape(own)
        for name, values in scores.metrics.items():
            metrics[name][members] = values.reshape(own)
        done += len(members)

    ended = np.where(failed < 0, np.iinfo(np.int64).max, failed).min(axis=2)
    first = np.where((failed >= 0).any(axis=2), ended, -1)
    for values in metrics.values():
        values[first >= 0] = np.nan  # a variant ends with either of its axes
    return Batch(variants, metrics, first)


def lanes_of(prepared: Prepared) -> Array:
    """Return the lane parameters of every variant, (epochs, variants, PARAMETER_ROWS, axes)."""
    return np.array(
        [
            [
                mover_parameters(scenario, variant.controller)
                for variant in scenario.variants.values()
            ]
            for _, scenario in prepared.epochs
        ]
    ).transpose(0, 1, 3, 2)


def _prepared(document: dict[str, Any], changes: Mapping[str, Any], index: int) -> Prepared:
    try:
        return prepare(validate(apply_changes(document, changes)))
    except ConfigError as error:
        place = f"cases.{index}."
        raise ConfigError(
            *(FieldError(place + e.loc, e.message, e.value, e.range, e.unit) for e in error.errors)
        ) from None


def _check(case: Prepared, variants: tuple[str, ...], index: int) -> None:
    if tuple(case.scenario.variants) != variants:
        raise ConfigError(
            FieldError(f"cases.{index}", "has other variants", list(case.scenario.variants))
        )
    if case.reference.ticks > TICKS_MAX:
        raise ConfigError(
            FieldError(
                f"cases.{index}.trajectory",
                "is too long for a batch",
                case.duration,
                f"<= {TICKS_MAX * CONTROL_PERIOD:g}",
                "s",
            )
        )


def _shared(case: Prepared) -> object:
    """Return the properties that cases must share to run side by side on the same inputs."""
    return (
        case.scenario.trajectory,
        case.scenario.window,
        case.scenario.settling_band,
        tuple((tick, _acting(scenario)) for tick, scenario in case.epochs),
    )


def _acting(scenario: Scenario) -> object:
    """Return the properties that determine the load and the draws of every noise source."""
    axes = (scenario.plant.x, scenario.plant.y)
    noise = (
        scenario.load.noise,
        *((axis.encoder.noise, axis.amplifiers.noise) for axis in axes),
    )
    noisy = scenario.load.noise > 0.0 or any(
        axis.encoder.noise > 0.0 or axis.amplifiers.noise > 0.0 for axis in axes
    )
    ripple = tuple(
        (axis.amplifiers.ripple_amplitude, axis.amplifiers.ripple_frequency) for axis in axes
    )
    return scenario.load, noise, ripple, scenario.seed if noisy else None
