"""Running a scenario from its first tick to its last."""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass
from typing import cast

import numpy as np
from numpy.typing import NDArray

from motionlab.build import (
    AXES,
    LANES_PER_VARIANT,
    VARIANTS_PER_BLOCK,
    initial_state,
    lane_parameters,
    motion_limits,
)
from motionlab.config.controller import ModelConfig
from motionlab.config.load import phases
from motionlab.config.plant import PlantConfig
from motionlab.config.scenario import Scenario
from motionlab.config.timing import CONTROL_PERIOD, to_ticks
from motionlab.config.trajectory import TrajectoryConfig
from motionlab.errors import ConfigError, FieldError
from motionlab.lanes import WIDTH
from motionlab.simulation.kernel import FORCE_LIMIT_ROW, SAMPLE_ROWS, State, run_ticks
from motionlab.simulation.noise import PAGE, load_force, page_inputs
from motionlab.simulation.timeline import Timeline
from motionlab.telemetry.channels import CHANNELS
from motionlab.telemetry.recording import Divergence, Recording, VariantRecord
from motionlab.trajectory.feasibility import check
from motionlab.trajectory.reference import Reference, sample

Array = NDArray[np.float64]
Phases = tuple[tuple[int, Scenario], ...]

_FAILED = State._fields.index("failed")
_LAST_STATES = 5
BRAKING = 0.5
"""Share of the largest acceleration with which a stop brakes."""


@dataclass(frozen=True)
class Prepared:
    """A scenario that has passed every check and is ready to move.

    Attributes
    ----------
    scenario : Scenario
        As validated.
    reference : Reference
        The sampled trajectory.
    load : ndarray, shape (ticks, 2)
        External load force without noise, N.
    phases : tuple of (int, Scenario)
        From which tick on which parameters hold.
    """

    scenario: Scenario
    reference: Reference
    load: Array
    phases: Phases


def prepare(scenario: Scenario) -> Prepared:
    """Sample a scenario's trajectory and check that every variant can follow it.

    Parameters
    ----------
    scenario : Scenario
        Validated scenario.

    Returns
    -------
    Prepared
        Ready to run.

    Raises
    ------
    Infeasible
        With the first time and place at which the motion exceeds a limit.
    ConfigError
        If an event, a force step or the window lies outside the run.
    """
    reference = _sampled(scenario.trajectory)
    changes = tuple(phases(scenario))
    _check_feasibility(scenario.trajectory, changes)
    _refuse_times_outside(scenario, changes, reference.ticks)
    load = load_force(scenario.load, reference.ticks)
    for tick, changed in changes[1:]:
        load[tick:] = load_force(changed.load, reference.ticks)[tick:]
    return Prepared(scenario, reference, load, changes)


class Simulation:
    """The running state of a scenario; advances page by page.

    Parameters
    ----------
    prepared : Prepared
        What to run.
    endless : bool
        Whether to go on after the trajectory's end where the motion allows it.
    """

    def __init__(self, prepared: Prepared, *, endless: bool = False) -> None:
        self.prepared = prepared
        self.timeline = Timeline(prepared.reference, prepared.load, endless=endless)
        self.tick = 0
        self._released = False
        self._changes = list(prepared.phases)
        self._apply_changes()
        place = prepared.reference.position[0]
        self._state = initial_state(len(self._parameters), (float(place[0]), float(place[1])))
        self._page = (-1, np.empty(0))

    def advance(self, samples: NDArray[np.float32]) -> int:
        """Advance until the page, the run or the present parameters end, or `samples` is full.

        Parameters
        ----------
        samples : ndarray of float32, shape (blocks, ticks, SAMPLE_ROWS, WIDTH)
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
        if self._changes:
            stop = min(stop, self._changes[0][0])
        count = stop - self.tick
        if count <= 0:
            return 0
        inputs = self._inputs(page)[offset : offset + count]
        for block, parameters in enumerate(self._parameters):
            run_ticks(parameters, self._state[block], inputs, samples[block, :count])
        self.tick = stop
        self._apply_changes()  # now, so that what is asked at this tick finds them in effect
        return count

    @property
    def scenario(self) -> Scenario:
        """The parameters in effect."""
        return self._scenario

    def change(self, changes: Phases) -> None:
        """Replace the parameters from the present tick on.

        Parameters
        ----------
        changes : tuple of (int, Scenario)
            From which tick on which parameters hold; the first is in effect at once.
        """
        if [scenario.load for _, scenario in changes] != [
            self._scenario.load,
            *(scenario.load for _, scenario in self._changes),
        ]:
            for tick, scenario in changes:
                self.timeline.load(tick, functools.partial(load_force, scenario.load))
        self._changes = list(changes)
        self._apply_changes()

    def push(self, axis: int, force: float, ticks: int) -> None:
        """Push the mover of every variant with `force`, N, towards positive positions."""
        self.timeline.push(self.tick, axis=axis, force=-force, ticks=ticks)
        self._page = (-1, np.empty(0))

    def stop(self) -> int:
        """Brake the reference to rest and return the tick at which it stands."""
        plant = self._scenario.plant
        limits = (BRAKING * plant.x.acceleration_max, BRAKING * plant.y.acceleration_max)
        self._page = (-1, np.empty(0))
        return self.timeline.stop(self.tick, limits)

    def release(self) -> None:
        """Command no current from now on."""
        self._released = True
        self._parameters[:, FORCE_LIMIT_ROW] = 0.0

    def failed_tick(self, variant: int) -> int | None:
        """Return the tick at which a variant diverged, or None while it has not."""
        block, lane = _place(variant)
        ticks = self._state[block, _FAILED, lane : lane + LANES_PER_VARIANT]
        return int(ticks[ticks >= 0].min()) if (ticks >= 0).any() else None

    def _apply_changes(self) -> None:
        while self._changes and self._changes[0][0] <= self.tick:
            self._scenario = self._changes.pop(0)[1]
            self._parameters = lane_parameters(self._scenario)
            if self._released:
                self._parameters[:, FORCE_LIMIT_ROW] = 0.0
            self._page = (-1, np.empty(0))

    def _inputs(self, page: int) -> Array:
        if self._page[0] != page:
            self._page = (page, page_inputs(self._scenario, self.timeline, page))
        return self._page[1]


def sample_page(variants: int) -> NDArray[np.float32]:
    """Return room for one page of samples of some variants, as `Simulation.advance` takes it."""
    blocks = -(-variants // VARIANTS_PER_BLOCK)
    return np.empty((blocks, PAGE, SAMPLE_ROWS, WIDTH), dtype=np.float32)


def variant_columns(samples: NDArray[np.float32], variant: int, count: int) -> NDArray[np.float32]:
    """Return the first `count` ticks of one variant, shape (channels, axes, count)."""
    block, lane = _place(variant)
    return samples[block, :count, :, lane : lane + LANES_PER_VARIANT].transpose(1, 2, 0)


def run(prepared: Prepared, progress: Callable[[int], None] | None = None) -> Recording:
    """Run a scenario to its end and record every channel.

    Parameters
    ----------
    prepared : Prepared
        What to run.
    progress : callable, optional
        Called with the number of ticks done since its last call.

    Returns
    -------
    Recording
        The same bits for the same scenario on the same machine. A variant that diverged holds NaN
        from there on; the others are not touched by it.
    """
    names = list(prepared.scenario.variants)
    ticks = prepared.reference.ticks
    simulation = Simulation(prepared)
    page = sample_page(len(names))
    columns = np.empty((len(names), SAMPLE_ROWS, len(AXES), ticks), dtype=np.float32)
    while count := simulation.advance(page):
        done = slice(simulation.tick - count, simulation.tick)
        for variant in range(len(names)):
            columns[variant, :, :, done] = variant_columns(page, variant, count)
        if progress is not None:
            progress(count)

    records = {}
    for variant, name in enumerate(names):
        failed = simulation.failed_tick(variant)
        divergence = None if failed is None else _divergence(columns[variant], failed)
        if failed is not None:
            columns[variant, :, :, failed:] = np.nan
        records[name] = VariantRecord(columns[variant], divergence)
    reference = prepared.reference
    shared = np.stack(
        [reference.position.T, reference.velocity.T, reference.acceleration.T, prepared.load.T]
    )
    return Recording(shared, records)


def _place(variant: int) -> tuple[int, int]:
    """Return the block of a variant and its first lane there."""
    block, place = divmod(variant, VARIANTS_PER_BLOCK)
    return block, place * LANES_PER_VARIANT


def _divergence(columns: NDArray[np.float32], tick: int) -> Divergence:
    """Name the first channel that is not finite at `tick`, else the following error."""
    at = columns[:, :, tick]
    bad = np.argwhere(~np.isfinite(at))
    if len(bad):
        channel, axis = bad[0]
    else:
        channel = [c.name for c in CHANNELS].index("following_error")
        axis = np.argmax(np.abs(at[channel]))
    first = max(0, tick + 1 - _LAST_STATES)
    last = tuple(
        {
            f"{AXES[a]}.{CHANNELS[c].name}": float(columns[c, a, k])
            for a in range(len(AXES))
            for c in range(len(CHANNELS))
        }
        for k in range(first, tick + 1)
    )
    return Divergence(tick, f"{AXES[axis]}.{CHANNELS[channel].name}", last)


# A slider asks for the same motion again and again: the newest is kept, and what was found to fit.


_sampled = cast("Callable[[TrajectoryConfig], Reference]", functools.lru_cache(maxsize=1)(sample))


def _check_motion(  # noqa: PLR0913, PLR0917 - all that decides whether a motion is feasible
    trajectory: TrajectoryConfig,
    plant: PlantConfig,
    model: ModelConfig,
    force_limit: float,
    current_limit: float,
    start: int,
) -> None:
    limits = motion_limits(plant, model, force_limit=force_limit, current_limit=current_limit)
    check(_sampled(trajectory), limits, start=start)


_check = cast("Callable[..., None]", functools.lru_cache(maxsize=16)(_check_motion))


def _check_feasibility(trajectory: TrajectoryConfig, changes: Phases) -> None:
    """Check the motion against what each variant can do from each change on."""
    checked = []
    for tick, scenario in changes:
        for variant in scenario.variants.values():
            controller = variant.controller
            decides = (
                scenario.plant,
                controller.model,
                controller.force_limit,
                controller.current_limit,
            )
            if decides not in checked:
                checked.append(decides)
                _check(trajectory, *decides, tick)


def _refuse_times_outside(scenario: Scenario, changes: Phases, ticks: int) -> None:
    end = ticks * CONTROL_PERIOD
    times = [(f"schedule.{i}.time", e.time) for i, e in enumerate(scenario.schedule)]
    for index, (_, changed) in enumerate(changes):
        place = f"schedule.{index - 1}.set." if index else ""
        times += [(f"{place}load.steps.{i}.time", s.time) for i, s in enumerate(changed.load.steps)]
    if scenario.window is not None:
        times += [("window.start", scenario.window.start)]
    late = [
        FieldError(loc, "lies after the end of the trajectory", time, f"< {end:g}", "s")
        for loc, time in times
        if to_ticks(time) >= ticks
    ]
    if scenario.window is not None and to_ticks(scenario.window.end) > ticks:
        late.append(
            FieldError(
                "window.end",
                "lies after the end of the trajectory",
                scenario.window.end,
                f"<= {end:g}",
                "s",
            )
        )
    if late:
        raise ConfigError(*late)
