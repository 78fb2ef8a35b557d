"""One variant of a scenario on drives: what a session advances in place of a simulation."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab.config.planar import AXES
from motionlab.config.scenario import EventConfig, Scenario
from motionlab.drive.faults import DIVERGED, NOT_A_NUMBER
from motionlab.drive.link.carrier import LinkError
from motionlab.drive.link.link import DriveLink
from motionlab.drive.link.readings import FaultNow
from motionlab.drive.link.shared import RUN_TICKS_MAX, Figure, State
from motionlab.drive.loop_parameters import LoopParameters, loop_parameters
from motionlab.errors import ConfigError, FieldError
from motionlab.kernel.build import lane_parameters
from motionlab.kernel.force_maps import check_maps
from motionlab.simulation.prepare import Prepared
from motionlab.simulation.simulation import ReadyEpoch, ready
from motionlab.simulation.timeline import Timeline
from motionlab.timing import CONTROL_PERIOD, to_ticks

Array = NDArray[np.float64]

_APPROACH = 0.1  # of the largest speed and acceleration, on the way to the start
_APPROACH_LEAST = 0.5  # s
_LEAST = 0.1  # s
"""Between changes of a schedule: the loop has one ahead, and the next comes after that."""
_AT_THIS_MOMENT = "a scheduled change takes effect at this moment: try again"
_PEAK_VELOCITY, _PEAK_ACCELERATION = 15 / 8, 10 / 3**0.5
"""Of a minimum-jerk motion of unit distance and duration."""
_WITH_TORQUE = {State.MOVING, State.STOPPING}
_NOT_STOPPED = {State.MOVING, State.HOLDING}


def on_drives(scenario: Scenario, variant: str | None) -> Scenario:
    """Return a scenario of one variant, as drives carry it out; its schedule is by time.

    Raises
    ------
    ConfigError
        If drives cannot carry it out.
    """
    names = list(scenario.variants)
    if variant is None and len(names) > 1:
        wrong = FieldError("variant", "say which one is to run: drives run one at a time", names)
        raise ConfigError(wrong)
    name = names[0] if variant is None else variant
    if name not in names:
        raise ConfigError(FieldError("variant", "is not in the scenario", name, ", ".join(names)))
    if scenario.plant.force == "ideal":
        raise ConfigError(FieldError("plant.force", "drives have currents, not ideal forces"))
    if scenario.learnt is not None and scenario.variants[name].controller.learnt:
        place = f"variants.{name}.controller.learnt"
        raise ConfigError(FieldError(place, "the loop of drives adds no learnt force", True))
    chosen = scenario.variants[name]
    late = chosen.controller.model_copy(update={"delay": 1})
    return scenario.model_copy(
        update={
            "variants": {name: chosen.model_copy(update={"controller": late})},
            "schedule": _schedule_on_drives(scenario.schedule, name),
        }
    )


class DriveMotion:
    """One motion on drives, tick by tick as it comes; its scenario is from `on_drives`.

    `number` grows from one motion to the next.
    """

    def __init__(self, prepared: Prepared, link: DriveLink, number: int) -> None:
        self.prepared = prepared
        self.timeline = Timeline(prepared.reference, np.zeros_like(prepared.load))
        self.tick = 0
        self._link = link
        self._number = number
        self._begun = self._stopping = False
        self._ended = False
        self._fault: FaultNow | None = None
        (_, self._scenario, lanes), *later = ready(prepared.epochs)
        self._parameters = loop_parameters(self._scenario, lanes[0])
        self._later = _fitting(later)  # the loop has the first of them, and puts it in effect
        self._set = 0  # number of the latest set that the loop has of this motion

    @property
    def blocks(self) -> int:
        """One block: eight lanes, of which two are the axes."""
        return 1

    @property
    def scenario(self) -> Scenario:
        """The parameters in effect at `tick`."""
        later = self._later
        return later[0][1] if later and later[0][0] <= self.tick else self._scenario

    @property
    def stopped(self) -> bool:
        """Whether the motion ended before its end, and all its samples have been taken."""
        self._note_end()
        early = self._stopping or self.tick != self.timeline.end
        return self._ended and early and self.available == 0

    @property
    def braking(self) -> bool:
        """Whether a stop, from whomever, has begun and not yet ended."""
        return self._begun and self._link.state == State.STOPPING

    @property
    def available(self) -> int:
        """Ticks that have been recorded and not yet taken; the braking after its end is not."""
        number, end = self._link.recorded
        if not self._begun or number != self._number:
            return 0
        return min(end, self.prepared.reference.ticks) - self.tick

    @property
    def failed_ticks(self) -> list[int | None]:
        """The tick at which the controller diverged, or None; other faults end a motion too."""
        fault = self.fault if self.stopped else None
        diverged = fault is not None and fault.code in {DIVERGED, NOT_A_NUMBER}
        return [self.tick if diverged else None]

    @property
    def fault(self) -> FaultNow | None:
        """The fault that ended the motion; None without one."""
        self._note_end()
        return self._fault

    def begin(self, stops: int | None = None) -> None:
        """Approach the start of the trajectory, follow it, and brake where it ends at speed.

        `stops` is as of `DriveLink.order`.

        Raises
        ------
        LinkError
            If the drives do not hold their position, or the motion is too long.
        """
        self._link.check_holding()
        here = np.array(self._link.figure(Figure.REFERENCE))
        plant = self._scenario.plant
        approach = minimum_jerk(
            here,
            self.prepared.reference.position[0],
            velocity=_APPROACH * np.array([plant.x.velocity_max, plant.y.velocity_max]),
            acceleration=_APPROACH * np.array([plant.x.acceleration_max, plant.y.acceleration_max]),
        )
        reference = self.prepared.reference
        position, velocity, acceleration, _ = self.timeline.at(0, reference.ticks)
        motion = np.stack((position, velocity, acceleration), axis=1)
        config = self._link.config
        deceleration = np.array([getattr(config, axis).deceleration for axis in AXES])
        whole = np.concatenate((approach, motion, braking(motion[-1], deceleration)))
        self._link.check_holding()  # before the gains of what moves now are replaced
        self._set = self._link.load(self._parameters).number
        self._schedule(self._later)
        lap = (reference.ticks, reference.period or reference.ticks)
        self._link.start(whole, len(approach), self._number, stops, lap=lap)
        self._begun = True

    def advance(self, samples: NDArray[np.float32]) -> int:
        """Take what has been recorded, as `Simulation.advance` computes it.

        Raises
        ------
        LinkError
            If samples were lost, or a scheduled change came too late.
        """
        count = min(self.available, samples.shape[1])
        if count:
            self._note_switch()
            if self._later:
                count = min(count, self._later[0][0] - self.tick)
            taken = self._link.samples(self.tick, self.tick + count)
            samples[0, :count, :, : len(AXES)] = taken[:, : samples.shape[2]]
            self.tick += count
        return count

    def references(self, start: int, stop: int) -> NDArray[np.float32]:
        """Return the reference over some ticks, as `Simulation.references`."""
        values = np.stack(self.timeline.at(start, stop))
        return values.transpose(2, 0, 1).reshape(-1, stop - start).astype(np.float32)

    def switches_within(self, seconds: float) -> bool:
        """Return whether a scheduled change takes effect within some s, or has since `tick`."""
        later, (_, end) = self._later, self._link.recorded
        near = bool(later) and later[0][0] - end < to_ticks(seconds)
        return near and self._link.state in _NOT_STOPPED

    def adopt(self, changes: Sequence[ReadyEpoch]) -> int:
        """Put parameters in effect at the drives' next tick, and return that.

        It is the tick of the motion that the loop itself reports; 0 on the way to the start, the
        motion's end where the position is held after it. Changes after the first are in effect at
        their own ticks.

        Raises
        ------
        ConfigError
            If their tables are too large for the loop.
        LinkError
            If the drives move or hold with other parameters than this motion's, or are without
            torque, or a scheduled change takes effect at this moment. They keep what they have.
        """
        (_, scenario, lanes), *others = changes
        parameters, later = loop_parameters(scenario, lanes[0]), _fitting(others)
        if self.switches_within(_LEAST) or (self._later and not self._link.withdraw()):
            raise LinkError(_AT_THIS_MOMENT)
        self._set, tick = self._link.load(parameters, after=self._set)
        self._scenario, self._later = scenario, later
        self._schedule(later)
        return min(max(tick, 0), self.prepared.reference.ticks)

    def push(self, axis: int, force: float, ticks: int) -> None:
        """Refuse: only a hand can push a real mover."""
        raise LinkError("only a hand can push the mover of a drive")

    def stop(self) -> None:
        """Brake to rest and switch the torque off."""
        self._stopping = True
        self._link.stop()

    def _schedule(self, later: Sequence[ReadyEpoch]) -> None:
        """Give the loop the first of later changes; it has room for one ahead."""
        if later:
            tick, scenario, lanes = later[0]
            parameters = loop_parameters(scenario, lanes[0])
            self._set = self._link.schedule(parameters, tick, after=self._set)

    def _note_switch(self) -> None:
        """Follow the loop in a scheduled change, where `tick`, now recorded, is its first."""
        if not self._later or self.tick < self._later[0][0]:
            return
        (tick, scenario, _), *others = self._later
        if self._link.taken == tick:
            self._schedule(others)
            self._scenario, self._later = scenario, tuple(others)  # last: `adopt` may wait for it
        elif self._link.state in _NOT_STOPPED:
            at = tick * CONTROL_PERIOD
            raise LinkError(f"the change scheduled at {at:g} s came too late: the server hung")
        else:  # after a stop nothing that waits takes effect
            self._later = ()

    def _note_end(self) -> None:
        """Keep how the motion ended: a fault may be reset later, or another one come."""
        if self._begun and not self._ended and not self._moving:
            self._ended, self._fault = True, self._link.fault()

    @property
    def _moving(self) -> bool:
        return self._link.state in _WITH_TORQUE


def held_parameters(scenario: Scenario) -> LoopParameters:
    """Return the parameters with which the loop holds a position; see `on_drives`.

    Raises
    ------
    ConfigError
        If a force map is not there, or its tables are too large for the loop.
    """
    check_maps(scenario)
    lanes = lane_parameters(scenario)[0]
    return loop_parameters(scenario, lanes)


def _fitting(later: Sequence[ReadyEpoch]) -> tuple[ReadyEpoch, ...]:
    """Return later changes, all of which the loop has room for."""
    for _, scenario, lanes in later:
        loop_parameters(scenario, lanes[0])
    return tuple(later)


def _schedule_on_drives(schedule: Sequence[EventConfig], variant: str) -> tuple[EventConfig, ...]:
    """Return what a schedule changes of one variant, by time.

    Raises
    ------
    ConfigError
        Naming every field that is not of its controller, and times too close together.
    """
    kept: list[EventConfig] = []
    wrong: list[FieldError] = []
    earliest = _LEAST
    for index, event in sorted(enumerate(schedule), key=lambda item: item[1].time):
        # Drives run one variant: changes of the others are left out, not refused.
        others = re.compile(rf"variants\.(?!{variant}\b)")
        changes = {path: value for path, value in event.set.items() if not others.match(path)}
        if not changes:
            continue
        try:
            changes = changes_on_drives(changes, variant, f"schedule.{index}.set")
        except ConfigError as error:
            wrong += error.errors
        if to_ticks(event.time) < to_ticks(earliest):
            text = "drives need some time after the start and from one change to the next"
            bounds = {"minimum": earliest}
            place = f"schedule.{index}.time"
            wrong.append(FieldError(place, text, event.time, bounds=bounds, unit="s"))
        earliest = event.time + _LEAST
        kept.append(event.model_copy(update={"set": changes}))
    if wrong:
        raise ConfigError(*wrong)
    return tuple(kept)


def changes_on_drives(changes: Mapping[str, Any], variant: str, loc: str = "set") -> dict[str, Any]:
    """Return changes of a motion as drives carry them out: a controller acts a period later.

    Raises
    ------
    ConfigError
        Naming every field that is not of its controller.
    """
    own = f"variants.{variant}"
    wrong = [
        FieldError(f"{loc}.{path}", reason, value)
        for path, value in changes.items()
        if (reason := _why_not(path, value, own))
    ]
    if wrong:
        raise ConfigError(*wrong)
    swapped = any(path in {own, f"{own}.controller", f"{own}.controller.base"} for path in changes)
    return dict(changes) | ({f"{own}.controller.delay": 1} if swapped else {})


def _why_not(path: str, value: Any, own: str) -> str:
    """Return why a field cannot change while drives move; empty where it can."""
    first, *_ = path.split(".")
    if first in {"plant", "load"}:
        return "is of the simulated machine: the drives have their own"
    if first == "variants" and path != own and not path.startswith(f"{own}."):
        return f"is not what the drives run: they run {own.removeprefix('variants.')} now"
    if path == f"{own}.controller.delay" and value != 1:
        return "is 1 on drives: a command acts one period after the position that it is from"
    return ""


def braking(last: Array, deceleration: Array) -> Array:
    """Return the reference that brings each axis to rest at its deceleration.

    Parameters
    ----------
    last : ndarray, shape (3, 2)
        Position, velocity, acceleration of x and y at the tick before.
    deceleration : ndarray, shape (2,)
        Of each axis, m/s^2.

    Returns
    -------
    ndarray, shape (ticks, 3, 2)
        As `minimum_jerk`; at rest at its last tick.
    """
    position, velocity, _ = last
    rest = np.abs(velocity) / deceleration
    ticks = int(np.ceil(np.max(rest) / CONTROL_PERIOD)) + 1
    t = CONTROL_PERIOD * np.arange(1, ticks + 1)[:, None]
    moved = np.minimum(t, rest)
    slowing = np.sign(velocity) * deceleration
    return np.stack(
        (
            position + velocity * moved - slowing * moved**2 / 2,
            velocity - slowing * moved,
            np.where(t < rest, -slowing, 0.0),
        ),
        axis=1,
    )


def minimum_jerk(start: Array, end: Array, *, velocity: Array, acceleration: Array) -> Array:
    """Return the reference of a motion from rest to rest within limits of each axis.

    ``s(u) = 10 u^3 - 15 u^4 + 6 u^5`` over the time in which no axis exceeds its limits.

    Parameters
    ----------
    start, end : ndarray, shape (2,)
        Positions, m.
    velocity, acceleration : ndarray, shape (2,)
        Limits, m/s and m/s^2.

    Returns
    -------
    ndarray, shape (ticks, 3, 2)
        Position, velocity, acceleration of x and y; its last tick is one before `end`.

    Raises
    ------
    LinkError
        If it takes longer than any motion may.
    """
    way = np.abs(end - start)
    seconds = max(
        _APPROACH_LEAST,
        float(np.max(_PEAK_VELOCITY * way / velocity)),
        float(np.max(np.sqrt(_PEAK_ACCELERATION * way / acceleration))),
    )
    most = RUN_TICKS_MAX * CONTROL_PERIOD
    if seconds > most:
        raise LinkError(f"the way to the start takes {seconds:.0f} s; at most {most:.0f} s")
    # Rounded up to whole ticks, so that the limits hold.
    ticks = int(np.ceil(seconds / CONTROL_PERIOD))
    seconds = ticks * CONTROL_PERIOD
    u = (np.arange(ticks) / ticks)[:, None]
    shape = np.stack(
        (
            10 * u**3 - 15 * u**4 + 6 * u**5,
            (30 * u**2 - 60 * u**3 + 30 * u**4) / seconds,
            (60 * u - 180 * u**2 + 120 * u**3) / seconds**2,
        ),
        axis=1,
    )
    reference = shape * (end - start)
    reference[:, 0] += start
    return reference
