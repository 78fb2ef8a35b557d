"""The thrust that the currents gave, by the controller's map at the measured position.

The force command is not the thrust: currents lag, and a command is held while the motor moves on,
over a place where its shares no longer fit. A control period between two samples is therefore
filled in. Currents approach where they settle at, and the position goes on evenly::

    i(s) = a i_k + b i_{k+1},   a = (r^s - r)/(1 - r),   b = (1 - r^s)/(1 - r)
    p(s) = p_k + s (p_{k+1} - p_k)

for s from 0 to 1, with r the share of a deviation left after a period and i_k from the smoother.
Thrust grows with the square of a current, so its remaining variance P enters the mean::

    f(s) = (f(i + sqrt P, p) + f(i - sqrt P, p))/2
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motionlab.config.timing import SUBSTEPS
from motionlab.force_sharing.pole_pitch import forces_over
from motionlab.kernel.force_maps import map_lanes
from motionlab.plant.table_map import MotorMap
from motionlab.studies.identify.current_smoother import CurrentLoops, Smoothed, reported
from motionlab.studies.identify.test_bench import Rig
from motionlab.telemetry.recording import VariantRecord

Array = NDArray[np.float64]

PLACES = (np.arange(SUBSTEPS) + 0.5) / SUBSTEPS
"""Where in a period the thrust is taken, as a share of it."""


def thrust_within(
    rig: Rig,
    axis: str,
    record: VariantRecord,
    loops: CurrentLoops,
    draws: np.random.Generator | None = None,
) -> Array:
    """Return the thrust at `PLACES` in every control period but the last, N.

    Parameters
    ----------
    rig : Rig
        Whose controller's map is used.
    axis : str
        ``x`` or ``y``.
    record : VariantRecord
        Of one motion: current commands, currents as the drives report them, and the encoder's
        reading are read.
    loops : CurrentLoops
        Of the axis.
    draws : Generator, optional
        Draws the unknown part of each current instead of averaging over it: the force is as noisy
        as the true one, so that a bristle creeps as far.

    Returns
    -------
    ndarray, shape (ticks - 1, SUBSTEPS)
        In the newtons of the controller's map.
    """
    if rig.scenario.plant.force == "ideal":  # has no currents: the command is the thrust
        force = record.channel("force_command", axis)[:-1].astype(np.float64)
        return np.repeat(force[:, None], SUBSTEPS, axis=1)
    model = map_lanes(rig.model(axis).force_map)
    position = record.channel("position_measured", axis).astype(np.float64)
    smoothed = loops.smooth(*readings(rig, axis, record))
    return thrust_of(model, position, smoothed, loops.left_over, draws)


def thrust_of(
    model: MotorMap,
    position: Array,
    smoothed: Smoothed,
    left_over: float,
    draws: np.random.Generator | None = None,
) -> Array:
    """Return the thrust at `PLACES` between the samples of position and currents, N.

    Parameters
    ----------
    model : MotorMap
        Of the controller.
    position : ndarray, shape (n,)
        Measured, m.
    smoothed : Smoothed
        Currents at the samples.
    left_over : float
        Share r of a current's distance from where it settles left after a sample.
    draws : Generator, optional
        As of `thrust_within`.

    Returns
    -------
    ndarray, shape (n - 1, SUBSTEPS)
    """
    mean, variance, covariance = smoothed
    if draws is not None:
        mean = mean + np.sqrt(variance) * draws.choice((-1.0, 1.0), mean.shape)
        variance, covariance = np.zeros_like(variance), np.zeros_like(covariance)
    r = left_over
    thrust = np.empty((len(position) - 1, SUBSTEPS))
    for column, s in enumerate(PLACES):
        place = position[:-1] + s * np.diff(position)
        a, b = (r**s - r) / (1.0 - r), (1.0 - r**s) / (1.0 - r)
        i = a * mean[:, :-1] + b * mean[:, 1:]
        P = a * a * variance[:-1] + b * b * variance[1:] + 2.0 * a * b * covariance
        deviation = np.sqrt(np.maximum(P, 0.0))
        sides = (deviation, -deviation) if variance.any() else (0.0,)
        thrust[:, column] = sum(
            forces_over(model, position=place, current=i + d).thrust for d in sides
        ) / len(sides)
    return thrust


def readings(rig: Rig, axis: str, record: VariantRecord) -> tuple[Array, Array]:
    """Return current commands, and currents as the drives report them, A, shape (3, ticks)."""
    current = _phases(record, "current", axis)
    amplifiers = getattr(rig.scenario.plant, axis).amplifiers
    return _phases(record, "current_command", axis), reported(current, amplifiers)


def _phases(record: VariantRecord, name: str, axis: str) -> Array:
    return np.stack([record.channel(f"{name}_{k}", axis) for k in "abc"]).astype(np.float64)
