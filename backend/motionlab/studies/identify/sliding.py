"""Sliding: uniform motions at many speeds, the force averaged over whole pole pitches."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.config.planar import PlanarLength
from motionlab.config.scenario import Scenario
from motionlab.config.trajectory import Trapezoid
from motionlab.errors import ConfigError, FieldError
from motionlab.force_sharing.pole_pitch import share_over
from motionlab.kernel.build import AXES
from motionlab.kernel.force_maps import force_model, pole_pitch
from motionlab.lanes.bank import TABLES
from motionlab.studies.identify.documents import Point
from motionlab.studies.identify.rig import Rig
from motionlab.studies.identify.thrust_from_currents import CurrentLoops, readings, thrust_within
from motionlab.telemetry.recording import VariantRecord
from motionlab.timing import CONTROL_PERIOD, to_ticks
from motionlab.trajectories.reference import Reference

Array = NDArray[np.float64]

_PUSH = 0.3
"""Share of the sure thrust that speeds up and brakes; friction is not known yet."""

_POSITIONS_PER_PITCH = 361
_SURE = 0.99
"""Share by which the thrust between these positions may fall below that at them."""

_SETTLED = 10.0
"""Slowest time constants of the loop after which its transient is taken to be over."""

_LOSS_OF_MEMORY = 0.5e-3
"""Distance after which friction is independent of its start, m: over ten times usual presliding."""

_DWELL = 0.1
_OFF_SPEED = 0.01
"""Share by which the measured speed may miss the wanted one without a warning."""

_STUCK = 0.5
"""Share by which it may miss and still be a point of a curve."""

_SWINGING = 0.2
"""Deviation of the command, as a share of its limit, that no friction or ripple causes."""

_AROUND = to_ticks(0.01)
"""Ticks before and after an end of the window over which it is moved."""

_PEAK = 1.0 - 1e-9
_ROUNDED_DOWN = 0.999


@dataclass(frozen=True)
class UniformMotion:
    """One speed, run there and back.

    Attributes
    ----------
    speed : float
        Wanted speed, m/s.
    pitches : int
        Whole pole pitches that the force is averaged over.
    way : float
        Their length, m.
    scenario : Scenario
        The motion.
    ticks : int
        About how long it takes.
    """

    speed: float
    pitches: int
    way: float
    scenario: Scenario
    ticks: int


def plan_motions(
    rig: Rig,
    axis: str,
    speeds: tuple[float, ...],
    *,
    time_max: float,
    pitches_max: int | None = None,
) -> list[UniformMotion]:
    """Return a motion for each speed, with as many whole pole pitches as fit.

    Parameters
    ----------
    rig : Rig
        Motor and loop.
    axis : str
        ``x`` or ``y``.
    speeds : tuple of float
        Speeds, m/s.
    time_max : float
        Time after which no further pitch is taken, s.
    pitches_max : int, optional
        Most pitches that are averaged over.

    Raises
    ------
    ConfigError
        Naming every speed whose run-up, transient and one pole pitch do not fit the stroke.
    """
    stroke = 2.0 * getattr(rig.scenario.plant, axis).stroke
    tau = pole_pitch(rig.model(axis).force_map)
    acceleration = _acceleration(rig, axis)
    settling = _SETTLED * _slowest(rig, axis)
    uncompensated = rig.uncompensated()
    v_max = getattr(rig.scenario.plant, axis).velocity_max
    motions, refused = [], []
    for index, speed in enumerate(speeds):
        ends = speed**2 / acceleration + speed * settling + _LOSS_OF_MEMORY
        room = stroke - ends
        if speed > v_max:
            refused.append(
                FieldError(
                    loc=f"speeds.{index}",
                    message=f"exceeds plant.{axis}.velocity_max",
                    value=speed,
                    bounds={"maximum": v_max},
                    unit="m/s",
                )
            )
            continue
        if room < tau:
            refused.append(
                FieldError(
                    loc=f"speeds.{index}",
                    message=f"needs {1e3 * (ends + tau):.1f} mm on {axis} to speed up, settle, "
                    f"slide over one pole pitch of {1e3 * tau:.4g} mm and brake; the stroke of "
                    f"{axis} is {1e3 * stroke:.4g} mm",
                    value=speed,
                    **_speeds_that_fit(stroke - tau - _LOSS_OF_MEMORY, acceleration, settling),
                    unit="m/s",
                )
            )
            continue
        pitches = min(math.floor(room / tau), math.floor(time_max * speed / tau))
        pitches = max(1, pitches if pitches_max is None else min(pitches, pitches_max))
        half = 0.5 * (ends + pitches * tau)
        scenario = uncompensated.model_copy(
            update={
                "trajectory": _there_and_back(axis, half, speed, acceleration),
                "learnt": None,
                "seed": rig.seed(axis, "sliding", index),
            }
        )
        seconds = 3.0 * _DWELL + 2.0 * (2.0 * half / speed + speed / acceleration)
        motions.append(UniformMotion(speed, pitches, pitches * tau, scenario, to_ticks(seconds)))
    if refused:
        raise ConfigError(*refused)
    return motions


class Doubt(NamedTuple):
    """A problem of a motion."""

    kind: Literal["does not follow", "is left out", "force limit", "left away"]
    text: str


def measure(  # noqa: PLR0913, PLR0917 - a motion, its record, and what earlier ones told
    rig: Rig,
    motion: UniformMotion,
    reference: Reference,
    record: VariantRecord,
    axis: str,
    loops: CurrentLoops,
) -> tuple[list[Point], list[Doubt]]:
    """Return the mean friction of both directions where the axis followed, and warnings.

    Only commands, the currents that the drives report and the encoder are read.
    """
    mass = rig.model(axis).mass
    velocity = reference.velocity[:, AXES.index(axis)]
    command = record.channel("force_command", axis).astype(np.float64)
    loops.learn(*readings(rig, axis, record))
    thrust = thrust_within(rig, axis, record, loops).mean(axis=1)
    position = record.channel("position_measured", axis).astype(np.float64)
    saturated = record.channel("force_saturated", axis) + record.channel("current_saturated", axis)
    points: list[Point] = []
    doubts: list[Doubt] = []
    count = round(motion.way / (motion.speed * CONTROL_PERIOD))
    for way in (1.0, -1.0):
        stop = _end_of_cruise(velocity * way) - _AROUND
        start = stop - count
        window = slice(start - _AROUND, stop + _AROUND - 1)
        moved = position[stop] - position[start]
        speed = float(moved / (count * CONTROL_PERIOD))
        target = way * motion.speed
        miss = abs(speed - target) / motion.speed
        if miss > _OFF_SPEED:
            text = f"at {target:.4g} m/s the axis moved at {speed:.4g} m/s on average: it does not "
            left_out = miss > _STUCK
            doubts.append(
                Doubt("is left out", text + "follow, and the point is left out")
                if left_out
                else Doubt("does not follow", text + "follow")
            )
        if saturated[window].any():
            doubts.append(
                Doubt("force limit", f"at {target:.4g} m/s the force command is at its limit")
            )
        if miss <= _STUCK:
            points.append(
                Point(
                    velocity=speed,
                    force=_mean_friction(mass, thrust, position, start, stop),
                    deviation=float(command[window].std()),
                    pitches=motion.pitches,
                )
            )
    return points, doubts


def in_words(doubts: list[Doubt]) -> list[str]:
    """Return a warning for each kind of problem: the first of them, and the number of others."""
    warnings = []
    for kind in dict.fromkeys(doubt.kind for doubt in doubts):
        first, *others = (doubt.text for doubt in doubts if doubt.kind == kind)
        more = f"; the same in {len(others)} more motions" if others else ""
        warnings.append(first + more)
    return warnings


def oscillates(points: list[Point], doubts: list[Doubt], force_limit: float) -> bool:
    """Return whether the loop swings between its limits instead of holding a speed.

    Parameters
    ----------
    points : list of Point
        Measured so far.
    doubts : list of Doubt
        Problems of these motions.
    force_limit : float
        Of the controller, N.
    """
    limited = sum(doubt.kind == "force limit" for doubt in doubts)
    return limited >= len(points) > 0 and all(
        point.deviation > _SWINGING * force_limit for point in points
    )


def _end_of_cruise(velocity: NDArray[np.float64]) -> int:
    """Return the last tick at the largest velocity."""
    return int(np.flatnonzero(velocity >= _PEAK * velocity.max())[-1])


def _mean_friction(mass: float, thrust: Array, position: Array, start: int, stop: int) -> float:
    """Return the mean over a window whose two ends move over 2 `_AROUND` ticks, N.

    The mean of a force over each of these windows is that of friction but for the momentum gained;
    averaged over all of them, that is the mass times a difference of mean velocities, which the
    encoder measures far better than a velocity at an instant.
    """
    count, wide = stop - start, 2 * _AROUND
    rising = np.arange(1, count + wide)
    weights = np.minimum(rising, rising[::-1]).clip(max=min(count, wide)) / (count * wide)
    # Not by BLAS, whose sums of this length depend on the number of its threads.
    total = float(np.sum(weights * thrust[start - _AROUND : stop + _AROUND - 1]))
    end, begin = (position[k + _AROUND] - position[k - _AROUND] for k in (stop, start))
    return total - mass * (end - begin) / (wide * count * CONTROL_PERIOD**2)


def _there_and_back(axis: str, half: float, speed: float, acceleration: float) -> Trapezoid:
    return Trapezoid(
        start=PlanarLength(**{axis: -half}),
        end=PlanarLength(**{axis: half}),
        v_max=speed,
        a_max=acceleration,
        dwell=_DWELL,
    )


def _acceleration(rig: Rig, axis: str) -> float:
    """Return an acceleration, m/s^2, that leaves most of the thrust to friction."""
    controller = rig.controller
    most: float = getattr(rig.scenario.plant, axis).acceleration_max
    thrust = controller.force_limit
    if rig.scenario.plant.force != "ideal":
        with TABLES.lease():
            config = rig.model(axis).force_map
            model = force_model(config, controller.sharing, controller.current_limit)
            pitch = np.linspace(0.0, model.map.formula.tau, _POSITIONS_PER_PITCH)
            forces = [share_over(model, position=pitch, force=s * thrust).force for s in (-1, 1)]
        thrust = float(np.abs(forces).min())
    return min(_PUSH * (_SURE * thrust) / rig.model(axis).mass, most)


def _slowest(rig: Rig, axis: str) -> float:
    """Return the slowest time constant of ``M s^2 + k_d s + k_p``, s."""
    gains, M = getattr(rig.controller, axis), rig.model(axis).mass
    root = cmath.sqrt(gains.k_d**2 - 4.0 * M * gains.k_p)
    slowest = min((gains.k_d - root).real, (gains.k_d + root).real) / (2.0 * M)
    if gains.k_p == 0.0 or slowest <= 0.0:
        name = "k_p" if gains.k_p == 0.0 else "k_d"
        raise ConfigError(
            FieldError(
                loc=f"variants.{rig.variant}.controller.{axis}.{name}",
                message="a loop without it cannot hold a speed",
                value=getattr(gains, name),
                bounds={"exclusive_minimum": 0.0},
                unit="N/m" if name == "k_p" else "N s/m",
            )
        )
    return 1.0 / slowest


def _speeds_that_fit(room: float, acceleration: float, settling: float) -> dict[str, Any]:
    """Return the range of speeds whose run fits: ``v^2/a + settling v <= room``."""
    if room <= 0.0:
        return {"range": "none on this stroke"}
    half = 0.5 * acceleration * settling
    fastest = math.sqrt(half * half + acceleration * room) - half
    return {"bounds": {"maximum": float(f"{_ROUNDED_DOWN * fastest:.4g}")}}
