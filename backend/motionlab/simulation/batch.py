"""Many cases of one scenario: metrics of each, as a run of it alone gives them, to the last bit."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.analysis.metrics import DEFINITIONS
from motionlab.config.changes import apply_changes, reapplied
from motionlab.config.load import Epochs, validate
from motionlab.config.planar import AXES
from motionlab.config.scenario import Scenario
from motionlab.errors import ConfigError, FieldError, Infeasible, shown
from motionlab.executors.executor import current
from motionlab.kernel.build import mover_parameters
from motionlab.motor_design.fem.force_map import ForceMap
from motionlab.motor_design.kept_maps import kept_in, lent
from motionlab.simulation.batch_runner import BatchRunner, Progress
from motionlab.simulation.prepare import Prepared, prepare
from motionlab.timing import CONTROL_PERIOD

Array = NDArray[np.float64]

Watch = Callable[[NDArray[np.int64], NDArray[np.float32]], None]

_PREPARING = 0.3
"""Share of the work that is done when every case has been checked; a guess, for progress."""

_NAMED_MAX = 6  # values that an error lists
_TOGETHER = 1000  # cases of a task, at most
_MOTION_SIZE = 100_000_000  # bytes of references and loads that cases side by side may hold

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
        Keys of `motionlab.analysis.metrics.DEFINITIONS`, in SI units; NaN where the run of the case
        has None or nothing: a variant that diverged, an axis that does not move, no hold.
    failed : ndarray of int, shape (cases, variants)
        Tick at which a variant diverged; -1 where it has not.
    feasible : ndarray of bool, shape (cases,)
        Whether the motor can follow the motion.
    """

    variants: tuple[str, ...]
    metrics: dict[str, Array]
    failed: NDArray[np.int64]
    feasible: NDArray[np.bool_]


class CaseTask(NamedTuple):
    """Some cases of a scenario: a task that can be sent to another process.

    Attributes
    ----------
    scenario : dict
        Tables of the scenario that all of them change.
    first : int
        Number of the first case, for errors.
    changes : sequence of mapping
        Of each case: dotted path to value.
    threads : int or None
        How many threads to use; None for one on each core.
    maps : dict of str to ForceMap
        Force maps that do not ship.
    shared : mapping of str to value
        What the tables have been changed by, for `motionlab.config.changes.reapplied`.
    """

    scenario: dict[str, Any]
    first: int
    changes: Sequence[Mapping[str, Any]]
    threads: int | None
    maps: dict[str, ForceMap]
    shared: Mapping[str, Any]


def tasks(
    scenario: Scenario, changes: Sequence[Mapping[str, Any]], shared: Mapping[str, Any]
) -> list[CaseTask]:
    """Return all cases of a scenario as tasks for the current executor; see `CaseTask`."""
    executor, document = current(), scenario.model_dump(mode="json")
    parts = [changes[part] for part in executor.parts(len(changes), _TOGETHER)]
    firsts = itertools.accumulate(map(len, parts), initial=0)
    return [
        CaseTask(document, first, part, executor.threads, kept_in(document, part), shared)
        for first, part in zip(firsts, parts, strict=False)
    ]


def run_batch(
    cases: CaseTask, progress: Progress | None = None, watch: Watch | None = None
) -> Batch:
    """Run some cases of a scenario.

    Cases that share their motion, load and noise, which takes equal seeds where there is noise at
    all, share one preparation of them and run side by side; others take turns.

    Parameters
    ----------
    cases : CaseTask
        At least one.
    progress : callable, optional
        Takes the share done; what it raises ends the batch.
    watch : callable, optional
        See `run_prepared`.

    Returns
    -------
    Batch
        The same bits for the same case, whatever runs beside it; NaN for a case whose motor cannot
        follow the motion.

    Raises
    ------
    ConfigError
        Naming the case and what is wrong with it; if a case adds or removes a variant.
    """
    count, variants = len(cases.changes), tuple(cases.scenario["variants"])
    shape = (count, len(variants), len(AXES))
    metrics = {name: np.full(shape, np.nan) for name in DEFINITIONS}
    failed = np.full(shape[:2], -1, dtype=np.int64)
    feasible = np.zeros(count, dtype=bool)
    ready = done = 0

    def tell(share: float = 0.0, size: int = 0) -> None:
        if progress is not None:
            ran = done + share * size
            progress((_PREPARING * ready + (1.0 - _PREPARING) * ran) / count)

    def prepared_one() -> None:
        nonlocal ready
        ready += 1
        tell()

    with lent(cases.maps):
        for parcel in _parcels(cases, prepared_one):
            numbers, size = np.array(list(parcel)), len(parcel)

            def look(
                movers: NDArray[np.int64], errors: NDArray[np.float32], numbers: Any = numbers
            ) -> None:
                if watch is not None:
                    case, variant = np.divmod(movers, len(variants))
                    watch(numbers[case] * len(variants) + variant, errors)

            parcel_metrics = run_prepared(
                list(parcel.values()),
                threads=cases.threads,
                progress=lambda share, size=size: tell(share, size),
                watch=None if watch is None else look,
            )
            feasible[numbers] = True
            failed[numbers] = parcel_metrics.failed
            for name, values in parcel_metrics.metrics.items():
                metrics[name][numbers] = values
            done += size
    return Batch(variants, metrics, failed, feasible)


def changed(
    document: dict[str, Any], changes: Mapping[str, Any], shared: Mapping[str, Any]
) -> Scenario:
    """Return the scenario of a case, of tables that `shared` has been applied to.

    Raises
    ------
    ConfigError
        If it is not valid, or adds or removes a variant.
    """
    scenario = validate(apply_changes(document, reapplied(shared, changes)))
    if list(scenario.variants) != list(document["variants"]):
        message = "a case cannot add or remove a variant"
        raise ConfigError(FieldError("variants", message, list(scenario.variants)))
    return scenario


@contextmanager
def naming(where: str, changes: Mapping[str, Any] | None = None) -> Iterator[None]:
    """Have errors be of a place of the request, and name their field and the changes there."""
    try:
        yield
    except ConfigError as error:
        raise ConfigError(*(at_case(where, changes or {}, e) for e in error.errors)) from None


def at_case(where: str, changes: Mapping[str, Any], error: FieldError) -> FieldError:
    """Return an error of a scenario as one of a place of the request; see `naming`."""
    message = f"{error.loc}: {error.message}"
    if 0 < len(changes) <= _NAMED_MAX:
        values = ", ".join(f"{path} = {shown(value)}" for path, value in changes.items())
        message += f", with {values}"
    return replace(error, loc=where, message=message)


def check_length(ticks: int) -> None:
    """Refuse a motion that is too long for a batch.

    Raises
    ------
    ConfigError
        If it takes more than `TICKS_MAX`.
    """
    if ticks > TICKS_MAX:
        most = {"maximum": TICKS_MAX * CONTROL_PERIOD}
        message, value = "is too long for a batch", ticks * CONTROL_PERIOD
        raise ConfigError(FieldError("trajectory", message, value, unit="s", bounds=most))


def _parcels(cases: CaseTask, tell: Callable[[], None]) -> Iterator[dict[int, Prepared]]:
    """Yield cases that are feasible, by place; as many at once as memory may hold."""
    parcel: dict[int, Prepared] = {}
    motions: dict[int, int] = {}
    for place, changes in enumerate(cases.changes):
        try:
            with naming(f"cases.{cases.first + place}", changes):
                case = prepare(changed(cases.scenario, changes, cases.shared))
                check_length(case.reference.ticks)
        except Infeasible:
            continue
        finally:
            tell()
        parcel[place] = case
        motions[id(case.reference)] = case.motion_size
        if sum(motions.values()) > _MOTION_SIZE:
            yield parcel
            parcel, motions = {}, {}
    if parcel:
        yield parcel


def run_prepared(
    cases: Sequence[Prepared],
    *,
    threads: int | None = None,
    progress: Progress | None = None,
    watch: Watch | None = None,
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
        if tuple(case.scenario.variants) != variants:
            theirs = list(case.scenario.variants)
            raise ConfigError(FieldError(f"cases.{index}", "has other variants", theirs))
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

        runner = BatchRunner(cases[members[0]])
        lanes = np.concatenate([lanes_of(cases[i].epochs) for i in members], axis=1)
        numbers = (np.array(members)[:, None] * len(variants) + np.arange(len(variants))).ravel()

        def look(first: int, errors: NDArray[np.float32], numbers: Any = numbers) -> None:
            if watch is not None:
                watch(numbers[first : first + len(errors)], errors)

        # All movers start alike: of those with the same parameters, such as the variants that no
        # case changes, one runs.
        run, alike = _different(lanes) if watch is None else (slice(None), slice(None))
        scores = runner.score(
            lanes[:, run], threads=threads, progress=part, watch=None if watch is None else look
        )
        own = (len(members), *shape[1:])
        failed[members] = scores.failed[alike].reshape(own)
        for name, values in scores.metrics.items():
            metrics[name][members] = values[alike].reshape(own)
        done += len(members)

    ended = np.where(failed < 0, np.iinfo(np.int64).max, failed).min(axis=2)
    first = np.where((failed >= 0).any(axis=2), ended, -1)
    for values in metrics.values():
        values[first >= 0] = np.nan  # a variant ends with either of its axes
    return Batch(variants, metrics, first, np.ones(len(cases), dtype=bool))


def lanes_of(epochs: Epochs) -> Array:
    """Return the lane parameters of every variant, (epochs, variants, PARAMETER_ROWS, axes)."""
    return np.array(
        [
            [
                mover_parameters(scenario, variant.controller)
                for variant in scenario.variants.values()
            ]
            for _, scenario in epochs
        ]
    ).transpose(0, 1, 3, 2)


def _different(lanes: Array) -> tuple[list[int], list[int]]:
    """Return one mover of each set of parameters, and for each mover which of those it is like."""
    known: dict[bytes, int] = {}
    first: list[int] = []
    alike: list[int] = []
    for mover in range(lanes.shape[1]):
        number = known.setdefault(lanes[:, mover].tobytes(), len(first))
        if number == len(first):
            first.append(mover)
        alike.append(number)
    return first, alike


def _shared(case: Prepared) -> object:
    """Return the properties that cases must share to run side by side on the same inputs."""
    return (
        case.scenario.trajectory,
        case.scenario.window,
        case.scenario.settling_band,
        tuple((tick, acting(scenario)) for tick, scenario in case.epochs),
    )


def acting(scenario: Scenario) -> tuple[Any, ...]:
    """Return the fields that determine inputs but for the motion; the seed last, if it matters."""
    axes = (scenario.plant.x, scenario.plant.y)
    noise = (
        scenario.load.noise,
        *((axis.encoder.noise, axis.encoder.jitter, axis.amplifiers.noise) for axis in axes),
    )
    noisy = scenario.load.noise > 0.0 or any(
        max(axis.encoder.noise, axis.encoder.jitter, axis.amplifiers.noise) > 0.0 for axis in axes
    )
    ripple = tuple(
        (axis.amplifiers.ripple_amplitude, axis.amplifiers.ripple_frequency) for axis in axes
    )
    seed = scenario.seed if noisy else None
    return scenario.load, noise, ripple, scenario.learnt, seed
