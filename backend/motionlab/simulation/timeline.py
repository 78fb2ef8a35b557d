"""Reference and load at any tick, also beyond a trajectory's end, through pushes and a stop."""

from __future__ import annotations

import functools
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from motionlab.config.learnt_force import LearntForce
from motionlab.kernel.motion import AHEAD
from motionlab.simulation.learnt import Lap, lap_of, over_lap
from motionlab.timing import CONTROL_PERIOD
from motionlab.trajectories.reference import Reference

Array = NDArray[np.float64]

_SAME_PLACE = 1e-12  # m


class Timeline:
    """Reference and load, tick by tick.

    Parameters
    ----------
    reference : Reference
        The sampled trajectory.
    load : ndarray, shape (ticks, 2)
        External load force without noise, N.
    endless : bool
        Whether to go on after the end where the motion is for ever and allows it: a motion with
        laps repeats its last lap, one that ends where it started begins again. The load keeps its
        last value.
    """

    def __init__(self, reference: Reference, load: Array, *, endless: bool = False) -> None:
        self._reference = reference
        self._load = load
        self._loads: list[tuple[int, Callable[[int, int], Array]]] = []
        self._pushes: list[tuple[int, int, int, float]] = []
        self._stop: tuple[int, Array, Array, Array] | None = None
        self._repeats_from = _repeats_from(reference) if endless and reference.for_ever else None
        self.end = reference.ticks if self._repeats_from is None else None

    def at(self, start: int, stop: int) -> tuple[Array, Array, Array, Array]:
        """Return position, velocity, acceleration reference and load over [start, stop), (n, 2)."""
        ticks = np.arange(start, stop)
        position, velocity, acceleration = self._motion(ticks)
        load = self._load[np.minimum(ticks, len(self._load) - 1)]  # a copy, added to below
        for tick, force in self._loads:
            if tick < stop:
                load[max(tick - start, 0) :] = force(stop, max(tick, start))
        for begin, end, axis, force in self._pushes:
            if begin < stop and end > start:
                load[max(begin - start, 0) : end - start, axis] += force
        return position, velocity, acceleration, load

    def _motion(self, ticks: NDArray[np.int64]) -> tuple[Array, Array, Array]:
        """Return position, velocity and acceleration reference of ticks in a row, (n, 2)."""
        reference, index = self._reference, self._index(ticks)
        position = reference.position[index]
        velocity = reference.velocity[index]
        acceleration = reference.acceleration[index]
        if self._stop is not None and ticks.size and ticks[-1] >= self._stop[0]:
            braked = ticks >= self._stop[0]
            position, velocity, acceleration = position.copy(), velocity.copy(), acceleration.copy()
            position[braked], velocity[braked], acceleration[braked] = self._braking(ticks[braked])
        return position, velocity, acceleration

    def ahead(self, start: int, stop: int, out: Array) -> Array:
        """Write the motion to come over [start, stop), fields of `Ahead`, (n, fields, 2).

        It is what is known at the time: of a stop only from its first tick on, which keeps the
        phase, too, `lap_phase`.
        """
        motion = self._motion(np.arange(start, stop + AHEAD))
        for k in range(AHEAD):
            for row, values in enumerate(motion, 3 * k):
                out[:, row] = values[k + 1 : k + 1 + stop - start]
        ticks = np.arange(start, stop)
        if self._stop is not None:
            ticks = np.minimum(ticks, self._stop[0])
        reference = self._reference
        phase = lap_phase(self._places(ticks), reference.ticks, reference.period)
        out[:, 3 * AHEAD] = phase[:, None]
        return out

    def learnt(self, force: LearntForce, start: int, stop: int) -> Array:
        """Return what was learnt of the motion over [start, stop), N, (n, 2): 0 beside its laps."""
        ticks = np.arange(start, stop)
        index = self._places(ticks)
        lap = self._lap
        values = over_lap(force, lap)[(index - lap.first) % max(lap.ticks, 1)]
        out = index < lap.first
        if self._repeats_from is None:
            out |= ticks >= self._reference.ticks
        if self._stop is not None:
            out |= ticks >= self._stop[0]
        values[out] = 0.0
        return values

    @functools.cached_property
    def _lap(self) -> Lap:
        return lap_of(self._reference)

    def load(self, tick: int, force: Callable[[int, int], Array]) -> None:
        """Replace the load from `tick` on by the values of `force(start, stop)`, N."""
        self._loads = [entry for entry in self._loads if entry[0] < tick]
        self._loads.append((tick, force))

    def push(self, tick: int, *, axis: int, force: float, ticks: int) -> None:
        """Add a load force, N, on one axis from `tick` on for some ticks."""
        self._pushes = [p for p in self._pushes if p[1] > tick]
        self._pushes.append((tick, tick + ticks, axis, force))

    def stop(self, tick: int, deceleration: tuple[float, float]) -> int:
        """Brake each axis from `tick` on at its deceleration, m/s^2.

        Returns
        -------
        int
            The tick at which the reference is at rest.
        """
        position, velocity, _, _ = self.at(tick, tick + 1)
        limits = np.array(deceleration)
        self._stop = (tick, position[0].copy(), velocity[0].copy(), limits)
        seconds = float(np.max(np.abs(velocity[0]) / limits))
        self.end = None
        return tick + int(np.ceil(seconds / CONTROL_PERIOD)) + 1

    def _index(self, ticks: NDArray[np.int64]) -> NDArray[np.int64] | slice:
        """Return the indices of ticks in the trajectory; a slice where possible, as faster."""
        last, count = self._reference.ticks, len(ticks)
        first = int(ticks[0]) if count else 0
        if self._repeats_from is not None and first >= last:
            first = self._repeats_from + (first - last) % (last - self._repeats_from)
        if first + count <= last:
            return slice(first, first + count)
        if self._repeats_from is None:
            return np.minimum(ticks, last - 1)
        lap = last - self._repeats_from
        return np.where(ticks < last, ticks, self._repeats_from + (ticks - last) % lap)

    def _places(self, ticks: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the indices of ticks in the trajectory as numbers."""
        index = self._index(ticks)
        return np.arange(index.start, index.stop) if isinstance(index, slice) else index

    def _braking(self, ticks: NDArray[np.int64]) -> tuple[Array, Array, Array]:
        assert self._stop is not None
        tick, position, velocity, limits = self._stop
        t = (ticks - tick)[:, None] * CONTROL_PERIOD
        rest = np.abs(velocity) / limits
        way = np.sign(velocity)
        moving = np.minimum(t, rest)
        return (
            position + velocity * moving - way * limits * moving**2 / 2,
            velocity - way * limits * moving,
            np.where(t < rest, -way * limits, 0.0),
        )


def lap_phase(index: NDArray[np.int64], ticks: int, period: int) -> Array:
    """Return the share of its lap that is done at ticks of a motion, from 0 on, below 1.

    Laps are those before the motion's end, of `period` ticks each; what comes before the first
    whole one is the end of a lap. A motion without laps is one.
    """
    lap = period or ticks
    return ((index - ticks) % lap) / lap


def _repeats_from(reference: Reference) -> int | None:
    """Return the tick from which a motion repeats after its end, or None."""
    end = np.array(reference.end)
    if reference.period:
        again = reference.ticks - reference.period
        return (
            again if np.allclose(reference.position[again], end, rtol=0, atol=_SAME_PLACE) else None
        )
    closed = np.allclose(reference.position[0], end, rtol=0, atol=_SAME_PLACE)
    still = not reference.velocity[0].any() and not reference.velocity[-1].any()
    return 0 if closed and still else None
