"""Thrust from recorded currents, smoothed by the known dynamics of their loops.

A drive reports a current in steps and at the samples only. The true current is known better,
because the command is known too: over a control period a current approaches the acting command
``c_k``, apart from amplifier noise ``w_k``::

    i_{k+1} = c_k + r (i_k - c_k) + w_k        var w = q
    y_k     = i_k + n_k                        var n = step^2/12

With r, the share of a deviation left after a period, and q estimated from the records, a
Rauch-Tung-Striebel smoother gives mean and variance of every current from all the readings of its
motion. Without amplifier noise the command determines the current; with much noise, the reading
does.

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

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.config.plant import AmplifierConfig
from motionlab.force_sharing.pole_pitch import forces_over
from motionlab.kernel.force_maps import map_lanes
from motionlab.lanes import cached
from motionlab.plant.table_map import MotorMap
from motionlab.studies.identify.rig import Rig
from motionlab.telemetry.recording import VariantRecord
from motionlab.timing import SUBSTEPS

Array = NDArray[np.float64]

STEP = 0.01
"""Steps in which drives report a current, A: a per mille of their rated 10 A, as CiA 402 has it."""

_READ = STEP**2 / 12.0
"""Variance of a reading, A^2."""

_SAME = 1e-4
"""Difference of two equal readings by rounding, A, at most."""

_SLOWEST = 0.95
"""Largest share of a deviation that a period may leave: 16 Hz of bandwidth."""

_TELLING = 5.0 * STEP
"""Least deviation of a pair of readings used to estimate r."""

_PAIRS = 5000
"""Pairs of readings kept to estimate r."""

_BRACKET = 0.02
"""Distance from the least-squares estimate within which the most likely r is searched."""

_STRAY = 1e-6
"""Likelihood of an outlier, which no r explains."""


class Smoothed(NamedTuple):
    """Currents estimated from all readings of a motion.

    Attributes
    ----------
    mean : ndarray, shape (3, n)
        At the samples, A.
    variance : ndarray, shape (n,)
        Of each phase, A^2.
    covariance : ndarray, shape (n - 1,)
        Of a sample with the next, A^2.
    """

    mean: Array
    variance: Array
    covariance: Array


@dataclass
class CurrentLoops:
    """Estimated parameters of an axis's current loops.

    Pooled, because a slow motion alone holds little information: its currents hardly leave their
    commands. A reading is an interval, half a step either way, and r is the maximum-likelihood
    value for the readings furthest from their commands. Least squares would treat quantisation as
    noise, which it is not without amplifier noise: the same commands are always rounded alike.

    Attributes
    ----------
    delay : int
        Control periods from a command to its effect.
    left_over : float
        Share r of a current's distance from its command left after a control period, 1.
    """

    delay: int
    left_over: float = 0.0
    _before: Array = field(default_factory=lambda: np.zeros(0))
    _after: Array = field(default_factory=lambda: np.zeros(0))
    _surprise: float = 0.0
    _count: int = 0

    def learn(self, command: Array, current: Array) -> None:
        """Take commands and reported currents of one motion into account, A, shape (3, n)."""
        acts = self.acting(command, current)[:, self.delay :]
        before, after = current[:, self.delay : -1] - acts, current[:, self.delay + 1 :] - acts
        telling = np.abs(before) >= _TELLING
        start = np.concatenate([self._before, before[telling]])
        end = np.concatenate([self._after, after[telling]])
        furthest = np.argsort(-np.abs(start), kind="stable")[:_PAIRS]
        self._before, self._after = start[furthest], end[furthest]
        if len(furthest):
            squares = float(np.sum(self._before**2 - _READ))
            slope = float(np.clip(self._before @ self._after / squares, 0.0, _SLOWEST))
            self.left_over = _likeliest(self._before, self._after, slope, self.variance)
        self._surprise += float(np.sum((after - self.left_over * before) ** 2))
        self._count += before.size

    @property
    def variance(self) -> float:
        """Variance q of the amplifier noise per control period, A^2."""
        if self._count == 0:
            return 0.0
        return max(0.0, self._surprise / self._count - (1.0 + self.left_over**2) * _READ)

    def acting(self, command: Array, current: Array) -> Array:
        """Return the command that acts in each period but the last, A, shape (3, n - 1)."""
        before = np.repeat(current[:, :1], self.delay, axis=1)
        return np.concatenate([before, command], axis=1)[:, : command.shape[1] - 1]

    def smooth(self, command: Array, current: Array) -> Smoothed:
        """Return the currents of one motion, given commands and reported currents, A."""
        acts = np.ascontiguousarray(self.acting(command, current))
        return Smoothed(*_smooth(acts, current, self.left_over, self.variance))


def as_sent(command: Array, current: Array) -> Array:
    """Return commands in the steps in which drives take them, those of their readings.

    Parameters
    ----------
    command, current : ndarray, shape (3, n)
        Commands before they were rounded, and readings, A.

    Returns
    -------
    ndarray, shape (3, n)
        A; of a phase whose reading never changes, as it was.
    """
    sent = command.copy()
    for phase, read in enumerate(current):
        values: Array = np.unique(read)
        apart = values[1:] - values[:-1]
        step = np.min(apart, initial=np.inf, where=apart > _SAME)
        if np.isfinite(step):
            sent[phase] = step * np.rint(command[phase] / step)
    return sent


def drive_readings(current: Array, amplifiers: AmplifierConfig) -> Array:
    """Return the drives' readings of true currents, A, shape (3, n).

    An amplifier's gain and offset are its current sensor's: its loop controls the sensor's reading,
    not the current. No experiment can observe them.
    """
    gain, offset = (np.array([*each])[:, None] for each in (amplifiers.gain, amplifiers.offset))
    reading = (current - offset) / np.where(gain > 0.0, gain, 1.0)
    return STEP * np.round(reading / STEP)


def _likeliest(before: Array, after: Array, slope: float, variance: float) -> float:
    """Return the r of largest likelihood for readings `after` deviations `before`: golden section.

    The reading is ``round(r before + w)``, with w normal; its variance includes the uncertainty of
    the reading before.
    """
    from scipy.special import ndtr

    spread = np.sqrt(variance + slope**2 * _READ) + 1e-6
    half = 0.5 * STEP

    def unlikely(r: float) -> float:
        miss = after - r * before
        inside = ndtr((miss + half) / spread) - ndtr((miss - half) / spread)
        return -float(np.sum(np.log(inside + _STRAY)))

    low, high = max(0.0, slope - _BRACKET), min(_SLOWEST, slope + _BRACKET)
    golden = 0.5 * (np.sqrt(5.0) - 1.0)
    left, right = high - golden * (high - low), low + golden * (high - low)
    f_left, f_right = unlikely(left), unlikely(right)
    while high - low > 1e-6:
        if f_left < f_right:
            high, right, f_right = right, left, f_left
            left = high - golden * (high - low)
            f_left = unlikely(left)
        else:
            low, left, f_left = left, right, f_right
            right = low + golden * (high - low)
            f_right = unlikely(right)
    return 0.5 * (low + high)


@cached
def _smooth(acts: Array, read: Array, r: float, q: float) -> tuple[Array, Array, Array]:
    """Filter forwards, smooth backwards; the variances are those of every phase."""
    n = read.shape[1]
    filtered, ahead = np.empty(n), np.empty(n)  # variances with the reading, and before it
    gain = np.zeros(n)
    filtered[0] = _READ
    for k in range(1, n):
        ahead[k] = r * r * filtered[k - 1] + q
        gain[k] = ahead[k] / (ahead[k] + _READ)
        filtered[k] = (1.0 - gain[k]) * ahead[k]
    variance, covariance, back = filtered.copy(), np.empty(n - 1), np.empty(n - 1)
    for k in range(n - 2, -1, -1):
        back[k] = r * filtered[k] / ahead[k + 1] if ahead[k + 1] > 0.0 else 0.0
        variance[k] = filtered[k] + back[k] ** 2 * (variance[k + 1] - ahead[k + 1])
        covariance[k] = back[k] * variance[k + 1]
    mean = np.empty((3, n))
    predicted = np.empty(n)
    for phase in range(3):
        i = mean[phase]
        i[0] = read[phase, 0]
        for k in range(1, n):
            predicted[k] = acts[phase, k - 1] + r * (i[k - 1] - acts[phase, k - 1])
            i[k] = predicted[k] + gain[k] * (read[phase, k] - predicted[k])
        for k in range(n - 2, -1, -1):
            i[k] += back[k] * (i[k + 1] - predicted[k + 1])
    return mean, variance, covariance


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
    return _phases(record, "current_command", axis), drive_readings(current, amplifiers)


def _phases(record: VariantRecord, name: str, axis: str) -> Array:
    return np.stack([record.channel(f"{name}_{k}", axis) for k in "abc"]).astype(np.float64)
