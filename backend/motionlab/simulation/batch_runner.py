"""Metrics of thousands of movers on one motion, over blocks of lanes and threads.

The movers of a call share what is common to all: reference, load and the draws of every noise
source. Blocks of lanes go to threads; the compiled loop holds no lock meanwhile.
"""

from __future__ import annotations

import functools
import itertools
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass

import numpy as np
from llvmlite import binding
from numba.core import config
from numpy.typing import NDArray

from motionlab.analysis.metrics import DEFINITIONS, error_metrics, needs_errors
from motionlab.config.planar import AXES
from motionlab.executors.executor import cores
from motionlab.kernel.accumulator import new_tally, tally_metrics
from motionlab.kernel.build import LANES_PER_VARIANT, initial_state
from motionlab.kernel.layout import state_row
from motionlab.kernel.score import Block, ScoreWindow, score_ticks
from motionlab.lanes import WIDE, WIDTH
from motionlab.simulation.inputs import inputs_over
from motionlab.simulation.prepare import Prepared
from motionlab.simulation.timeline import Timeline

Array = NDArray[np.float64]
Progress = Callable[[float], None]
"""Takes the share done, 0 to 1, in the caller's thread; what it raises ends the work."""

Watch = Callable[[int, NDArray[np.float32]], None]
"""Takes the first of some movers and their following errors, (movers, axes, ticks), m; called in
the caller's thread, and not in the movers' order."""

_FAILED = state_row("failed")


@dataclass(frozen=True)
class Scores:
    """Metrics of many movers, both axes of each on its own.

    Attributes
    ----------
    metrics : dict of str to ndarray, shape (movers, axes)
        Keys of `motionlab.analysis.metrics.DEFINITIONS`, in SI units, to the last bit what a run
        gives; NaN where a run has none: on an axis that diverged or does not move, without a hold.
    failed : ndarray of int, shape (movers, axes)
        Tick at which an axis diverged; -1 where it has not.
    """

    metrics: dict[str, Array]
    failed: NDArray[np.int64]


class BatchRunner:
    """Scores many movers on one motion, under the same load and noise.

    Parameters
    ----------
    prepared : Prepared
        Source of reference, load, noise, window and settling band, and of the ticks at which lane
        parameters change.
    """

    def __init__(self, prepared: Prepared) -> None:
        reference = prepared.reference
        self.reference = reference
        self.window = prepared.window
        self.settling_band = prepared.scenario.settling_band
        self.starts = tuple(tick for tick, _ in prepared.epochs)
        timeline = Timeline(reference, prepared.load)
        self._inputs = inputs_over(prepared.epochs, timeline, 0, reference.ticks)
        self._target = np.ascontiguousarray(reference.position[slice(*self.window), None, :])

    def score(
        self,
        lanes: Array,
        *,
        threads: int | None = None,
        progress: Progress | None = None,
        watch: Watch | None = None,
    ) -> Scores:
        """Simulate many movers and return their metrics.

        Parameters
        ----------
        lanes : ndarray, shape (epochs, movers, PARAMETER_ROWS, 2)
            Lane parameters of both axes of each mover, from each tick of `starts` on.
        threads : int, optional
            How many threads to use; one for each core when left out.
        progress, watch : callable, optional
            See `Progress` and `Watch`.

        Returns
        -------
        Scores
            The same bits whatever is scored beside a mover, and with any number of threads.
        """
        movers = lanes.shape[1]
        threads = threads or cores()
        size = _block_size(movers, threads)
        errors = watch is not None or needs_errors(self.reference)
        tally = new_tally(movers, len(AXES))
        failed = np.full((movers, len(AXES)), -1, dtype=np.int64)
        of_error = {name: np.full((movers, len(AXES)), np.nan) for name in DEFINITIONS}

        def block(first: int) -> tuple[int, _BlockResult]:
            return first, self._run(lanes[:, first : first + size], errors)

        done = 0
        for first, result in _in_threads(block, range(0, movers, size), threads):
            here = slice(first, first + result.failed.shape[0])
            tally[:, here], failed[here] = result.tally, result.failed
            if watch is not None:
                watch(first, result.errors)
            for name, values in self._error_metrics(result).items():
                of_error[name][here] = values
            done += result.failed.shape[0]
            if progress is not None:
                progress(done / movers)

        metrics = of_error | tally_metrics(tally, self.window[1] - self.window[0])
        still = [axis not in self.reference.moving for axis in AXES]
        for name in metrics:
            metrics[name] = np.where((failed >= 0) | still, np.nan, metrics[name])
        return Scores({name: metrics[name] for name in DEFINITIONS}, failed)

    def _run(self, lanes: Array, keep_errors: bool) -> _BlockResult:
        """Run one block: as many movers as fit side by side, or fewer."""
        count = lanes.shape[1]
        width = WIDTH if count * LANES_PER_VARIANT <= WIDTH else WIDE
        seats = np.arange(width // LANES_PER_VARIANT) % count  # those left over repeat the first
        ticks = self.reference.ticks
        x, y = self.reference.position[0]
        state = initial_state(1, (float(x), float(y)), width=width)[0]
        tally = new_tally(width)
        errors = np.empty((ticks if keep_errors else 0, width), dtype=np.float32)
        ends = (*self.starts[1:], ticks)
        # Compiled code differs for arrays that can be written to, as every unpickled one can.
        target = self._target.view()
        target.flags.writeable = False
        for phase, (start, end) in enumerate(zip(self.starts, ends, strict=True)):
            rows = lanes[phase, seats].transpose(1, 0, 2).reshape(-1, width)
            score_ticks(
                Block(np.ascontiguousarray(rows), state),
                self._inputs[start:end],
                ScoreWindow(target, self.window[0] - start, tally, errors[start:end]),
            )
        used = count * LANES_PER_VARIANT
        failed = state[_FAILED, :used].astype(np.int64)
        for lane in np.flatnonzero(failed >= 0) if keep_errors else ():
            errors[failed[lane] :, lane] = np.nan
        return _BlockResult(
            tally[:, :used].reshape(-1, count, LANES_PER_VARIANT),
            failed.reshape(count, LANES_PER_VARIANT),
            errors[:, :used].T.reshape(count, LANES_PER_VARIANT, -1),
        )

    def _error_metrics(self, block: _BlockResult) -> dict[str, Array]:
        """Return the metrics that are computed from the error, shape (movers, axes)."""
        metrics: dict[str, Array] = {}
        if not needs_errors(self.reference):
            return metrics
        window = self.window
        for mover, axis in np.ndindex(block.failed.shape):
            if block.failed[mover, axis] >= 0:
                continue
            values = error_metrics(
                block.errors[mover, axis, slice(*window)].astype(np.float64),
                self.reference,
                AXES[axis],
                window,
                settling_band=self.settling_band,
            )
            for name, value in values.items():
                column = metrics.setdefault(name, np.full(block.failed.shape, np.nan))
                column[mover, axis] = np.nan if value is None else value
        return metrics


@dataclass(frozen=True)
class _BlockResult:
    """Results of one block: (TALLY_ROWS, movers, axes), (movers, axes), (movers, axes, ticks)."""

    tally: Array
    failed: NDArray[np.int64]
    errors: NDArray[np.float32]


def _block_size(movers: int, threads: int) -> int:
    """Return the movers of a block: narrow blocks where wide ones leave threads idle.

    Without AVX-512 all are narrow: wide ones are hardly faster there, and rounded differently, so
    that a case would depend on how many go beside it.
    """
    wide = WIDE // LANES_PER_VARIANT
    return wide if movers > threads * wide // 2 and _has_avx512() else wide // 2


@functools.cache
def _has_avx512() -> bool:
    """Return whether kernels are compiled for registers of eight numbers."""
    chosen = config.CPU_FEATURES  # pyright: ignore[reportAttributeAccessIssue]
    features = chosen or binding.get_host_cpu_features().flatten()
    return "+avx512f" in features.split(",")


def _in_threads(
    work: Callable[[int], tuple[int, _BlockResult]], items: Iterable[int], threads: int
) -> Iterator[tuple[int, _BlockResult]]:
    """Yield the results of `work` for each item, in order of completion."""
    first, *others = items
    if not others:  # a search scores one block at a time: no thread has to be started for it
        yield work(first)
        return
    items = iter((first, *others))
    with ThreadPoolExecutor(threads, thread_name_prefix="lanes") as pool:
        pending: set[Future[tuple[int, _BlockResult]]] = set()
        while True:
            for item in itertools.islice(items, 2 * threads - len(pending)):
                pending.add(pool.submit(work, item))
            if not pending:
                return
            done, pending = wait(pending, return_when=FIRST_COMPLETED)
            for future in done:
                yield future.result()
