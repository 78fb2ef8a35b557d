"""Presliding: open-loop force ramps below stiction, and the displacement they cause."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.kernel.build import AXES
from motionlab.kernel.force_maps import pole_pitch
from motionlab.lanes import WIDTH, Lanes, cached, pack, unpack
from motionlab.plant.friction import LuGre
from motionlab.plant.mechanics import Mechanics, Mover, advance
from motionlab.simulation.inputs import load_force
from motionlab.simulation.prepare import Prepared
from motionlab.studies.identify.rig import Rig
from motionlab.studies.identify.thrust_from_currents import CurrentLoops, thrust_within
from motionlab.telemetry.recording import VariantRecord
from motionlab.timing import CONTROL_PERIOD, PLANT_STEP, SUBSTEPS, to_ticks
from motionlab.trajectories.reference import Reference

Array = NDArray[np.float64]

SETTLE = to_ticks(0.2)
"""Ticks without command before a ramp, in which the bristles take up a constant load."""

REST = to_ticks(0.1)
"""Ticks at the top of a ramp and after it."""

_BASELINE = to_ticks(0.05)
SLOWEST = 20.0
"""Rate below which ripple and drift spoil a ramp, N/s."""

_CREPT = 0.7
"""Share of the largest displacement that may remain when the force is gone; LuGre keeps 0.42."""


@dataclass(frozen=True)
class MeasuredRamp:
    """One force ramp: up, a rest at the top, down again.

    Attributes
    ----------
    rate : float
        Rate of the force, N/s.
    place : int
        Index of the place in the pole pitch.
    sign : float
        1 towards positive positions, -1 towards negative ones.
    prepared : Prepared
        Ready to run.
    """

    rate: float
    place: int
    sign: float
    prepared: Prepared


def force_ramp(force_max: float, rate: float) -> Array:
    """Return the force command of every tick, N: rest, up, rest, down, rest."""
    ticks = _rise(force_max, rate)
    rise = force_max * np.arange(1, ticks + 1) / ticks
    top = np.full(REST, force_max)
    return np.concatenate([np.zeros(SETTLE), rise, top, rise[::-1], np.zeros(REST)])


def ramp_ticks(force_max: float, rate: float) -> int:
    """Return the duration of a force ramp, ticks."""
    return SETTLE + 2 * REST + 2 * _rise(force_max, rate)


def _rise(force_max: float, rate: float) -> int:
    return max(1, round(force_max / (rate * CONTROL_PERIOD)))


def plan_ramps(
    rig: Rig, axis: str, *, force_max: float, rates: Sequence[float], places: int
) -> list[MeasuredRamp]:
    """Return every ramp of the experiment: each rate, at each place, in both directions."""
    scenario = rig.open_loop(axis)
    model = rig.model(axis)
    column = AXES.index(axis)
    ramps: list[MeasuredRamp] = []
    for rate in rates:
        force = force_ramp(force_max, rate)
        for place in range(places):
            for sign in (1.0, -1.0):
                position, still, acceleration = (np.zeros((len(force), 2)) for _ in range(3))
                position[:, column] = place / places * pole_pitch(model.force_map)
                acceleration[:, column] = sign * force / model.mass
                start = (float(position[0, 0]), float(position[0, 1]))
                reference = Reference(
                    position=position,
                    velocity=still,
                    acceleration=acceleration,
                    end=start,
                    moving=(axis,),
                    window=(0, len(force)),
                    holds=(),
                    edges=(),
                    period=0,
                )
                seeded = scenario.model_copy(
                    update={"seed": rig.seed(axis, "presliding", len(ramps))}
                )
                load = load_force(seeded.load, len(force))
                prepared = Prepared(seeded, reference, load, ((0, seeded),))
                ramps.append(MeasuredRamp(rate, place, sign, prepared))
    return ramps


def ramp_thrust(
    rig: Rig, ramp: MeasuredRamp, record: VariantRecord, axis: str, loops: CurrentLoops
) -> Array:
    """Return the thrust along a ramp, N, by the measured currents, shape (ticks, SUBSTEPS)."""
    draws = np.random.default_rng(ramp.prepared.scenario.seed)
    thrust = ramp.sign * thrust_within(rig, axis, record, loops, draws)
    return np.vstack([thrust, thrust[-1:]])  # beyond the last reading, where nothing is read


def displacement(ramp: MeasuredRamp, record: VariantRecord, axis: str) -> tuple[Array, str | None]:
    """Return the displacement from the rest before the ramp, m, along it, and warnings.

    Only the encoder is read.
    """
    position = record.channel("position_measured", axis).astype(np.float64)
    way = ramp.sign * _from_rest(position)
    if way[-_BASELINE:].mean() > _CREPT * way.max():
        return way, (
            f"at place {ramp.place} the ramp of {ramp.rate:g} N/s left the axis "
            f"{way[-1] * 1e6:.3g} um away: it slid, crept under a load, or was pushed by "
            "something else"
        )
    return way, None


def _from_rest(position: Array) -> Array:
    """Return positions relative to the mean position before the ramp, m."""
    return position - position[SETTLE - _BASELINE : SETTLE].mean()


class _Force(NamedTuple):
    f: Lanes


@cached
def _respond(
    mechanics: Array, friction: Array, start: Array, forces: Array, position: Array
) -> None:
    """Move eight masses on LuGre friction; writes their positions, shape (ticks, 1, WIDTH)."""
    m = unpack(Mechanics, mechanics, 0)
    f = unpack(LuGre, friction, 0)
    s = unpack(Mover, start, 0)
    for k in range(len(forces)):
        pack(_Force(s.p), position[k])
        for j in range(SUBSTEPS):
            force = unpack(_Force, forces[k, j], 0).f
            s = advance(m, f, s, force, PLANT_STEP)


def model_response(
    friction: LuGre, mass: float, forces: Sequence[Array], loads: Sequence[float]
) -> list[Array]:
    """Return the motion of a mass on LuGre friction from rest under a load and a force ramp.

    At rest the bristles hold the load: ``z = load/sigma_0``.

    Parameters
    ----------
    friction : LuGre
        Plain numbers.
    mass : float
        Moving mass, kg.
    forces : sequence of ndarray, shape (ticks, SUBSTEPS)
        Thrust along each ramp in every step of the plant, N.
    loads : sequence of float
        Constant load along each ramp, N.

    Returns
    -------
    list of ndarray, shape (ticks,)
        Displacement from the rest before the ramp at the start of every tick, m.
    """
    free = Mechanics(mass, 1e9, 0.0, 0.0)  # the end stops are out of reach
    rows = [np.tile(np.array([group], dtype=np.float64).T, WIDTH) for group in (free, friction)]
    positions: list[Array] = []
    for first in range(0, len(forces), WIDTH):
        beside = forces[first : first + WIDTH]
        longest = max(len(force) for force in beside)
        lanes, start = np.zeros((longest, SUBSTEPS, 1, WIDTH)), np.zeros((3, WIDTH))
        for lane, force in enumerate(beside):
            load = loads[first + lane]
            lanes[: len(force), :, 0, lane] = force + load
            start[Mover._fields.index("z"), lane] = load / friction.sigma_0
        position = np.empty((longest, 1, WIDTH))
        _respond(rows[0], rows[1], start, lanes, position)
        positions += [
            _from_rest(position[: len(force), 0, lane]) for lane, force in enumerate(beside)
        ]
    return positions


@cached
def bristle(position: Array, velocity: Array, lost: NDArray[np.bool_], friction: LuGre) -> Array:
    """Return the bristle state z along a motion, m, eq. (21).

    Over the displacement d between two samples, with a steady state of magnitude ``g/sigma_0`` that
    is linear in between, ``dz/dt = v - abs(v) sigma_0 z/g`` has the solution::

        x = sigma_0 sgn(v) d/g;  s = sgn(v)/sigma_0
        z_1 = s g_1 - s (g_1 - g_0) (1 - e^-x)/x + (z_0 - s g_0) e^-x

    Only g and the direction depend on the velocity, so that it may be smoothed. The displacement is
    not: its noise, which may be against the direction, cancels from one sample to the next.

    Parameters
    ----------
    position, velocity : ndarray, shape (n,)
        m and m/s.
    lost : ndarray of bool, shape (n,)
        Where the state is not known, and set to zero.
    friction : LuGre
        Plain numbers.
    """
    n = len(position)
    z = np.zeros(n)
    w = 1.0 / (friction.v_s * friction.v_s)
    stiffness, falls = friction.sigma_0, friction.F_s - friction.F_c
    g_0 = friction.F_c
    for k in range(n):
        g_1 = friction.F_c + falls * np.exp(-velocity[k] * velocity[k] * w)
        if k > 0 and not lost[k]:
            s = 1.0 / stiffness if velocity[k - 1] + velocity[k] > 0.0 else -1.0 / stiffness
            x = 2.0 * stiffness * stiffness * s * (position[k] - position[k - 1]) / (g_0 + g_1)
            e = np.exp(-x)
            part = (1.0 - e) / x if abs(x) > 1e-6 else 1.0 - 0.5 * x
            z[k] = s * g_1 - s * (g_1 - g_0) * part + (z[k - 1] - s * g_0) * e
        g_0 = g_1
    return z
