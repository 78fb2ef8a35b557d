"""Validation and preparation of a scenario."""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from motionlab.config.controller import ModelConfig, SharingConfig
from motionlab.config.drawn_path import DrawnPath
from motionlab.config.load import Epochs, epochs
from motionlab.config.planar import AXES
from motionlab.config.planned_motor import PlannedMotor
from motionlab.config.plant import PlantConfig
from motionlab.config.scenario import LoadConfig, Scenario
from motionlab.config.trajectory import TrajectoryConfig
from motionlab.errors import ConfigError, FieldError, Infeasible
from motionlab.executors.progress import watch_compilation
from motionlab.kernel.build import motion_limits
from motionlab.kernel.force_maps import check_maps, map_digests, pole_pitch
from motionlab.kernel.planned_motor import planned_motor
from motionlab.simulation.inputs import load_force
from motionlab.simulation.learnt import check_learnt
from motionlab.telemetry.channels import CHANNELS, REFERENCES
from motionlab.timing import CONTROL_PERIOD, to_ticks
from motionlab.trajectories.cusps import cusp_note
from motionlab.trajectories.feasibility import check
from motionlab.trajectories.motion_limits import MotionLimits, Span
from motionlab.trajectories.reference import Reference, sample

Array = NDArray[np.float64]
_Digests = tuple[str, ...]

watch_compilation()

_SHARED = len(REFERENCES) * len(AXES) * np.float64().itemsize
"""Reference and load of one tick, bytes."""


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
    epochs : tuple of (int, Scenario)
        From which tick on which parameters hold.
    """

    scenario: Scenario
    reference: Reference
    load: Array
    epochs: Epochs

    @property
    def duration(self) -> float:
        """Simulated time, s."""
        return self.reference.ticks * CONTROL_PERIOD

    @property
    def window(self) -> tuple[int, int]:
        """Ticks that metrics are taken over and end."""
        window = self.scenario.window
        if window is None:
            return self.reference.window
        return to_ticks(window.start), to_ticks(window.end)

    @property
    def work(self) -> float:
        """Simulated time summed over variants, s."""
        return self.duration * len(self.scenario.variants)

    @property
    def motion_size(self) -> int:
        """Size of reference and load, bytes."""
        return self.reference.ticks * _SHARED

    def recording_size(self, ticks: int | None = None) -> int:
        """Return the size of a recording of all or some ticks, beside the motion, bytes."""
        variants = len(self.scenario.variants) * len(CHANNELS) * len(AXES) * np.float32().itemsize
        return self.motion_size + (self.reference.ticks if ticks is None else ticks) * (
            variants + _SHARED
        )


def prepare(scenario: Scenario, *, checked: bool = False) -> Prepared:
    """Sample a scenario's trajectory and check that every variant can follow it.

    Parameters
    ----------
    scenario : Scenario
        Validated scenario.
    checked : bool
        Whether to leave the checks out: changes during a session are not held to them, so neither
        is the scenario that it recorded after a reset.

    Returns
    -------
    Prepared
        Ready to run.

    Raises
    ------
    Infeasible
        With the first time and place at which the motion exceeds a limit.
    ConfigError
        If an event, a force step or the window lies outside the run, or the learnt force is of
        another motion.
    """
    scenario = planned(scenario)
    reference = _sampled(scenario.trajectory)
    changes = epochs(scenario)
    if scenario.learnt is not None and any(map(_adds_learnt, changes)):
        pitches = (pole_pitch(each.force_map) for each in (scenario.plant.x, scenario.plant.y))
        if note := check_learnt(scenario.learnt, reference, tuple(pitches)):
            reference = replace(reference, notes=(*reference.notes, note))
    elif any(map(_adds_learnt, changes)):
        note = "a controller adds a learnt force, and the scenario has none"
        reference = replace(reference, notes=(*reference.notes, note))
    if not checked:
        _check_feasibility(scenario.trajectory, changes)
        _refuse_times_outside(scenario, changes, reference.ticks)
    loads = tuple((tick, changed.load) for tick, changed in changes)
    return Prepared(scenario, reference, _load(loads, reference.ticks), changes)


def _adds_learnt(change: tuple[int, Scenario]) -> bool:
    """Return whether a controller adds the force that was learnt of the motion."""
    return any(each.controller.learnt for each in change[1].variants.values())


def planned(scenario: Scenario) -> Scenario:
    """Return a scenario whose time-optimal path, if it has one, is planned for its motor.

    A path that has been planned stays as it is, whatever motor follows it: so a session's changes,
    the cases of a study and runs that are simulated again keep their motion. Changes scheduled for
    later do not count.
    """
    trajectory = scenario.trajectory
    if not needs_plan(trajectory):
        return scenario
    limits = planned_for(scenario)
    return scenario.model_copy(
        update={"trajectory": trajectory.model_copy(update={"planned_for": limits})}
    )


def planned_for(scenario: Scenario) -> PlannedMotor:
    """Return the limits that a scenario's motor has with each of its controllers at 0 s."""
    deciding = _deciding(((0, scenario),))
    maps = deciding[0][2]
    return _planned_for(tuple(decides for _, decides, _ in deciding), maps)


def thrust_reserve(scenario: Scenario) -> float:
    """Return the share of the thrust that is left to feedback: the motion's or the scenario's."""
    own: float | None = getattr(scenario.trajectory, "thrust_reserve", None)
    return scenario.thrust_reserve if own is None else own


def needs_plan(trajectory: TrajectoryConfig) -> bool:
    """Return whether a trajectory is planned for a motor that it does not name yet."""
    return (
        isinstance(trajectory, DrawnPath)
        and trajectory.law == "time_optimal"
        and trajectory.planned_for is None
    )


@functools.lru_cache(maxsize=16)
def _planned_for(deciding: tuple[_Deciding, ...], _maps: _Digests) -> PlannedMotor:
    return planned_motor(
        deciding[0].plant, [(decides.model, decides.limits()) for decides in deciding]
    )


# A slider repeats the same motion, and thousands of cases share one load: the latest of both are
# cached, and the results of their checks.


_sampled = cast("Callable[[TrajectoryConfig], Reference]", functools.lru_cache(maxsize=1)(sample))


@functools.lru_cache(maxsize=1)
def _load(loads: tuple[tuple[int, LoadConfig], ...], ticks: int) -> Array:
    """Return the load force without noise, N, shape (ticks, 2); read-only, for it is shared."""
    force = load_force(loads[0][1], ticks)
    for tick, changed in loads[1:]:
        force[tick:] = load_force(changed, ticks)[tick:]
    force.setflags(write=False)
    return force


class _Deciding(NamedTuple):
    """Inputs of feasibility other than the motion."""

    plant: PlantConfig
    model: ModelConfig
    sharing: SharingConfig
    force_limit: float
    current_limit: float
    reserve: float

    def limits(self) -> MotionLimits:
        return motion_limits(
            self.plant,
            self.model,
            sharing=self.sharing,
            force_limit=self.force_limit,
            current_limit=self.current_limit,
            reserve=self.reserve,
        )


def _check_motion(
    trajectory: TrajectoryConfig, decides: _Deciding, span: Span, _maps: _Digests
) -> None:
    check(_sampled(trajectory), decides.limits(), span=span)


_check = cast("Callable[..., None]", functools.lru_cache(maxsize=16)(_check_motion))


def limit_sets(changes: Epochs) -> list[tuple[Span, MotionLimits]]:
    """Return when which distinct limits hold, of every variant and phase."""
    return [(span, decides.limits()) for span, decides, _ in _deciding(changes)]


def _check_feasibility(trajectory: TrajectoryConfig, changes: Epochs) -> None:
    """Check the motion against the limits of each variant between scheduled changes."""
    for span, decides, maps in _deciding(changes):
        try:
            _check(trajectory, decides, span, maps)
        except Infeasible as error:
            raise error.with_remedy(cusp_note(trajectory)) from None


def _deciding(changes: Epochs) -> list[tuple[Span, _Deciding, _Digests]]:
    """Return all that decides whether a motion is feasible, and when it holds."""
    ended: list[tuple[Span, _Deciding, _Digests]] = []
    lasting: list[tuple[Span, _Deciding, _Digests]] = []  # of the phase before, then of this one
    for tick, scenario in changes:
        before, lasting = lasting, []
        check_maps(scenario)
        maps = map_digests([(tick, scenario)])
        for variant in scenario.variants.values():
            controller = variant.controller
            decides = _Deciding(
                scenario.plant,
                controller.model,
                controller.sharing,
                controller.force_limit,
                controller.current_limit,
                thrust_reserve(scenario),
            )
            if all(decides != other for _, other, _ in lasting):
                start = next((span.start for span, other, _ in before if decides == other), tick)
                lasting.append((Span(start), decides, maps))
        ended += [
            (Span(span.start, tick), decides, digests)
            for span, decides, digests in before
            if all(decides != other for _, other, _ in lasting)
        ]
    return ended + lasting


def _refuse_times_outside(scenario: Scenario, changes: Epochs, ticks: int) -> None:
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
