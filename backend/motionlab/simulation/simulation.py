"""The running state of a scenario, common to complete runs and live sessions."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motionlab.config.scenario import Scenario
from motionlab.kernel.build import (
    LANES_PER_VARIANT,
    VARIANTS_PER_BLOCK,
    initial_state,
    lane_parameters,
)
from motionlab.kernel.force_maps import check_maps
from motionlab.kernel.law_calls import laws_of
from motionlab.kernel.law_renewal import Renewal
from motionlab.kernel.layout import FORCE_LIMIT_ROW, SAMPLE_ROWS, LawState, reads_tables, state_row
from motionlab.kernel.tick import run_lanes, run_ticks
from motionlab.lanes import WIDTH
from motionlab.simulation.inputs import PAGE, input_rows, load_force, page_inputs
from motionlab.simulation.prepare import Epochs, Prepared
from motionlab.simulation.timeline import Timeline
from motionlab.telemetry.channels import Sample
from motionlab.timing import to_ticks

Array = NDArray[np.float64]
ReadyEpoch = tuple[int, Scenario, Array]
"""First tick, parameters that hold from there, and the numbers of their lanes."""

_FAILED = state_row("failed")
_FORCE = Sample._fields.index("force_command")
BRAKING = 0.5
"""Share of the largest acceleration with which a stop brakes."""

_RELEASE_TICKS = to_ticks(0.05)
"""Ticks from a stop's rest until the currents, commanded to zero, are taken to be gone."""


@dataclass(frozen=True)
class Snapshot:
    """A resumable state of a simulation.

    Attributes
    ----------
    tick : int
        The next tick.
    state : ndarray, shape (blocks, STATE_ROWS, WIDTH)
        State of plants and controllers.
    """

    tick: int
    state: Array


class Simulation:
    """The running state of a scenario; advances page by page.

    Parameters
    ----------
    prepared : Prepared
        What to run.
    endless : bool
        Whether to go on after the trajectory's end where the motion allows it.
    start : Snapshot, optional
        Where to begin, with the parameters in effect there; at rest at tick 0 when left out.
    """

    def __init__(
        self, prepared: Prepared, *, endless: bool = False, start: Snapshot | None = None
    ) -> None:
        self.prepared = prepared
        self.timeline = Timeline(prepared.reference, prepared.load, endless=endless)
        self.tick = 0 if start is None else start.tick
        self._rest: int | None = None  # tick at which the reference of a stop is at rest
        self._released = False
        self._forget_pages()
        self._changes = ready(prepared.epochs)
        if endless:  # beyond the trajectory's end too
            self._load(self._changes)
        self._apply_changes()
        if start is None:
            x, y = prepared.reference.position[0]
            self._state = initial_state(len(self._parameters), (float(x), float(y)))
        else:
            self._state = start.state.copy()

    def advance(self, samples: NDArray[np.float32]) -> int:
        """Advance until the page, the run or the present parameters end, or `samples` is full.

        A stop ends the run when the currents are gone.

        Parameters
        ----------
        samples : ndarray of float32, shape (blocks, ticks, SAMPLE_ROWS or more, WIDTH)
            Overwritten by the samples of as many ticks as were advanced.

        Returns
        -------
        int
            Number of ticks; 0 at the end of the run.
        """
        page, offset = divmod(self.tick, PAGE)
        stop = min((page + 1) * PAGE, self.tick + samples.shape[1])
        if self.timeline.end is not None:
            stop = min(stop, self.timeline.end)
        if self._rest is not None:
            if self.tick >= self._rest:
                self._release()
            stop = min(stop, self._rest + _RELEASE_TICKS if self._released else self._rest)
        if self._changes:
            stop = min(stop, self._changes[0][0])
        count = stop - self.tick
        if count <= 0:
            return 0
        inputs = self._inputs(page)[offset : offset + count]
        for block, (parameters, tabled) in enumerate(
            zip(self._parameters, self._tabled, strict=True)
        ):
            run_ticks(parameters, self._state[block], inputs, samples[block, :count], tabled)
        self.tick = stop
        self._apply_changes()  # now, so that they are in effect for commands at this tick
        return count

    def snapshot(self) -> Snapshot:
        """Return the present state."""
        return Snapshot(self.tick, self._state.copy())

    @property
    def blocks(self) -> int:
        """Blocks of lanes, which advance one after another."""
        return len(self._parameters)

    @property
    def scenario(self) -> Scenario:
        """The parameters in effect."""
        return self._scenario

    def adopt(self, changes: Sequence[ReadyEpoch]) -> int:
        """Replace the parameters from the present tick on, and return it.

        Parameters
        ----------
        changes : sequence of (int, Scenario, ndarray)
            From `ready`: from which tick on which parameters hold. The first is in effect at once,
            and so are those whose ticks have passed since they were made ready.
        """
        loads = [scenario.load for _, scenario, _ in changes]
        if loads != [self._scenario.load, *(scenario.load for _, scenario, _ in self._changes)]:
            self._load(changes)
        self._changes = list(changes)
        self._apply_changes()
        return self.tick

    def force_commands(self) -> NDArray[np.float32] | None:
        """Return the force that each controller is about to command, N; nothing advances.

        Returns
        -------
        ndarray of float32, shape (variants, axes), or None
            None at the end of the motion, and where the kernel has not been loaded.
        """
        end = self.timeline.end
        if (end is not None and self.tick >= end) or not _kernel_is_loaded():
            return None
        page, offset = divmod(self.tick, PAGE)
        inputs = self._inputs(page)[offset : offset + 1]
        samples = np.empty((self.blocks, 1, SAMPLE_ROWS, WIDTH), dtype=np.float32)
        for block, (parameters, tabled) in enumerate(
            zip(self._parameters, self._tabled, strict=True)
        ):
            run_ticks(parameters, self._state[block].copy(), inputs, samples[block], tabled)
        forces = samples[:, 0, _FORCE].reshape(-1, LANES_PER_VARIANT)
        return forces[: len(self._scenario.variants)]

    def law_taken(self, renewal: Renewal) -> None:
        """Carry the states of laws over to other versions, once those are in place."""
        renewal.carry(self._state)

    def push(self, axis: int, force: float, ticks: int) -> None:
        """Push the mover of every variant with `force`, N, towards positive positions."""
        self.timeline.push(self.tick, axis=axis, force=-force, ticks=ticks)
        self._forget_pages()

    def stop(self) -> None:
        """Brake the reference to rest, then command no current."""
        plant = self._scenario.plant
        limits = (BRAKING * plant.x.acceleration_max, BRAKING * plant.y.acceleration_max)
        self._forget_pages()
        self._rest = self.timeline.stop(self.tick, limits)

    @property
    def stopped(self) -> bool:
        """Whether a stop has come to its end."""
        return self._rest is not None and self.tick >= self._rest + _RELEASE_TICKS

    def references(self, start: int, stop: int) -> NDArray[np.float32]:
        """Return the reference over some ticks of one page; a view.

        Returns
        -------
        ndarray of float32, shape (2 * 4, ticks)
            Position, velocity and acceleration reference and load force of x, then those of y.
        """
        page, first = divmod(start, PAGE)
        if self._reference_page[0] != page:
            values = np.stack(self.timeline.at(page * PAGE, (page + 1) * PAGE))
            columns = values.transpose(2, 0, 1).reshape(-1, PAGE)
            self._reference_page = (page, columns.astype(np.float32))
        return self._reference_page[1][:, first : first + stop - start]

    @property
    def failed_ticks(self) -> list[int | None]:
        """Of each variant the tick at which it diverged, or None while it has not."""
        lanes = self._state[:, _FAILED].reshape(-1, LANES_PER_VARIANT).tolist()
        return [
            min((int(tick) for tick in ticks if tick >= 0.0), default=None)
            for ticks in lanes[: len(self._scenario.variants)]
        ]

    def _apply_changes(self) -> None:
        while self._changes and self._changes[0][0] <= self.tick:
            _, self._scenario, self._parameters = self._changes.pop(0)
            self._tabled = [reads_tables(parameters) for parameters in self._parameters]
            if self._released:
                self._parameters[:, FORCE_LIMIT_ROW] = 0.0
            self._forget_pages()

    def _load(self, changes: Sequence[ReadyEpoch]) -> None:
        for tick, scenario, _ in changes:
            force = functools.partial(load_force, scenario.load)
            self.timeline.load(max(tick, self.tick), force)

    def _release(self) -> None:
        self._released = True
        self._parameters[:, FORCE_LIMIT_ROW] = 0.0

    def _forget_pages(self) -> None:
        self._page = (-1, np.empty((0, 0, 2)))
        self._reference_page = (-1, np.empty((0, 0), dtype=np.float32))

    def _inputs(self, page: int) -> Array:
        held, inputs = self._page
        # Or a law that may look ahead has come meanwhile.
        if held != page or inputs.shape[1] < input_rows():
            self._page = (page, page_inputs(self._scenario, self.timeline, page))
        return self._page[1]


def ready(changes: Epochs) -> list[ReadyEpoch]:
    """Return parameter sets with the numbers of their lanes, for `Simulation.adopt`.

    This is the slow part of a change: force maps are read, tables are computed and, once the kernel
    is loaded, laws compiled where they are used for the first time. It touches no simulation, so it
    can run beside one.

    Parameters
    ----------
    changes : tuple of (int, Scenario)
        From which tick on which parameters hold, in order of time.

    Raises
    ------
    ConfigError
        If a force map is not there.
    """
    for _, scenario in changes:
        check_maps(scenario)
    sets = [(tick, scenario, lane_parameters(scenario)) for tick, scenario in changes]
    if _kernel_is_loaded():
        for _, _, parameters in sets:
            laws_of(parameters)  # not first in a session's slice of time
    return sets


def _kernel_is_loaded() -> bool:
    """Return whether a tick would not have to wait for the kernel, which takes longer than laws."""
    return bool(getattr(run_lanes, "signatures", True))


def sample_page(variants: int, *, states: bool = False) -> NDArray[np.float32]:
    """Return room for one page of samples of some variants, as `Simulation.advance` takes it.

    With `states` it has rows for those of laws, too.
    """
    blocks = -(-variants // VARIANTS_PER_BLOCK)
    rows = SAMPLE_ROWS + (len(LawState._fields) if states else 0)
    return np.empty((blocks, PAGE, rows, WIDTH), dtype=np.float32)


def variant_columns(samples: NDArray[np.float32], variant: int, count: int) -> NDArray[np.float32]:
    """Return the first `count` ticks of one variant, shape (channels, axes, count)."""
    block, lane = _place(variant)
    return samples[block, :count, :, lane : lane + LANES_PER_VARIANT].transpose(1, 2, 0)


def variant_lanes(state: Array, variant: int) -> Array:
    """Return the state of one variant, shape (STATE_ROWS, axes)."""
    block, lane = _place(variant)
    return state[block, :, lane : lane + LANES_PER_VARIANT]


def _place(variant: int) -> tuple[int, int]:
    """Return the block of a variant and its first lane there."""
    block, place = divmod(variant, VARIANTS_PER_BLOCK)
    return block, place * LANES_PER_VARIANT
