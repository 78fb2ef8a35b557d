"""A motor fitted to a recorded stretch: mass, friction, currents, and the disturbance that is left.

With the force f that the controller's map has in effect, in its newtons, and currents i that share
it::

    f + f(p, gain i + offset) - f(p, i) = M a + sigma_0 z + sigma_1 dz/dt + sigma_2 v + f_0 + w

A gain and an offset of each phase are the amplifier's: its own sensor does not show them, but the
thrust does, over the pole pitch and in presliding. Errors of the map, ``f cos, sin(2 pi m p/tau)``,
are fitted beside, lest friction answer for them, and left in w: at the same place the other
controller needs about the same force. Whatever is not explained is the stretch's own disturbance w,
whose spectrum is estimated with the fit: lines are weighed by its inverse, so that a slow drift or
a hum does not hide a reversal.

The loop was closed: f answers to w and to the encoder's noise, and least squares over what was
measured would find too small a mass. So equations are weighed not by the measured motion but by
that of the reference, with the force that the model needs for it, which know of neither:
instrumental variables. Priors about the controller's model keep what the stretch does not tell.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag
from scipy.ndimage import gaussian_filter1d
from scipy.signal import butter, sosfiltfilt
from scipy.signal.windows import tukey

from motionlab.config.controller import AxisModelConfig
from motionlab.force_sharing.pole_pitch import forces_over, share_over
from motionlab.force_sharing.share import ForceModel
from motionlab.kernel.force_maps import pole_pitch
from motionlab.plant.friction import LuGre
from motionlab.studies.identify.presliding import bristle
from motionlab.studies.minute.recorded import EDGE, RecordedAxis
from motionlab.timing import CONTROL_PERIOD

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

PHASES = "abc"
MECHANICAL = ("M", *LuGre._fields, "f_0")
"""All but f_0 by their logarithm."""
ELECTRICAL = tuple(f"{name}_{phase}" for name in ("gain", "offset") for phase in PHASES)
NAMES = MECHANICAL + ELECTRICAL
"""What is fitted; a motor without currents has the first part only."""

_PRIOR = 0.7
"""Standard deviation of the logarithm of a parameter about the controller's model."""
_MASS = 0.2  # the same of the mass: it can be weighed
_OFFSET, _GAIN, _CURRENT = 3.0, 0.03, 0.1  # the same of f_0, N, of gains, 1, and of offsets, A
_HARMONICS, _WRONG = 6, 0.05
"""Of the pole pitch, in errors of the map, and their prior deviation, as a share of the force."""
_COMMON = 0.3
"""Share of that which all phases have in common: the mass, or friction, would hide it."""
_MOTION = 200.0
"""Bandwidth of the motion, Hz: noise of the encoder is small beside presliding."""
_FITTED = 80.0  # highest frequency of the fit, Hz
DISTURBANCE = 50.0
"""Bandwidth of the disturbance, Hz: above, noise of the encoder would be taken for forces."""
_SMOOTHED = 1.0  # resolution of the disturbance's spectrum, Hz
_ROUNDS, _WEIGHED = 30, 8
"""Steps at most, and those after which the weights stay: else both may chase each other."""
_STEP_MOST, _FARTHEST, _SETTLED = 1.0, 4.0, 3e-3
"""Of a step, from the prior, and of the last step, in deviations of the prior."""
_DIFFERENCE = 0.02  # step of a logarithm, and of a current, A, for slopes
_TAPER = 0.05
_LEAST = 1e-9
_UNEXPLAINED = 0.02
"""Power of a line, N^2, that no such model explains: 0.04 N RMS below 80 Hz. Without it a minute
without disturbances would trust what the model has wrong."""


class Motor(NamedTuple):
    """A motor in the newtons of a controller's map."""

    mass: float
    friction: LuGre
    offset: float  # N
    gains: tuple[float, float, float]
    currents: tuple[float, float, float]  # A

    @classmethod
    def of(cls, values: Array) -> Motor:
        """Return the motor of the values of a fit."""
        mass, *friction = np.exp(values[: len(MECHANICAL) - 1]).tolist()
        amplifiers = [0.0] * len(ELECTRICAL)
        amplifiers[: len(values) - len(MECHANICAL)] = values[len(MECHANICAL) :].tolist()
        gains, currents = amplifiers[: len(PHASES)], amplifiers[len(PHASES) :]
        a, b, c = (1.0 + gain for gain in gains)
        d, e, f = currents
        offset = float(values[len(MECHANICAL) - 1])
        return cls(mass, LuGre(*friction), offset, (a, b, c), (d, e, f))


@dataclass(frozen=True)
class MotorFit:
    """A motor fitted to a stretch of one axis.

    Attributes
    ----------
    values : ndarray, shape (n,)
        Of NAMES: logarithms, but for f_0, N; gains less 1, and currents, A.
    covariance : ndarray, shape (n, n)
        Of them.
    prior : ndarray, shape (n,)
        The controller's model, in the same way.
    """

    values: Array
    covariance: Array
    prior: Array
    _equation: _Equation

    def drawn(self, rng: np.random.Generator) -> Array:
        """Return values within the errors of the fit."""
        return rng.multivariate_normal(self.values, self.covariance, method="eigh")

    def disturbance(self, values: Array) -> Array:
        """Return what a motor leaves of the recorded force, f_0 included, N, (ticks,)."""
        return smoothed(self._equation.rest(Motor.of(values)), DISTURBANCE)


def fit_motor(
    axis: RecordedAxis, model: AxisModelConfig, thrust: ForceModel | None, lag: float
) -> MotorFit:
    """Fit a motor to a stretch.

    Parameters
    ----------
    axis : RecordedAxis
        The stretch.
    model : AxisModelConfig
        Of the controller that was recorded: the prior.
    thrust : ForceModel or None
        Its map and its sharing of forces; None for a motor without currents.
    lag : float
        By which the thrust is behind the force in effect, s.
    """
    prior, precision = _prior(model, electrical=thrust is not None)
    measured = _Equation.of(axis.position, axis.force, thrust, lag)
    p, _, acceleration = axis.reference
    needed = _Equation.of(p, axis.force, None, lag).needed(Motor.of(prior), acceleration)
    ideal = _Equation.of(p, needed, thrust, lag)
    normal = _Normal.of(measured, ideal, pole_pitch(model.force_map))
    precision = _beside(precision, np.eye(len(normal.wrong)) * _WRONG**-2.0)
    start = np.append(prior, np.zeros(len(normal.wrong)))
    values = start.copy()
    spread = np.sqrt(np.diag(np.linalg.inv(precision)))
    weight = normal.weight(values)
    for number in range(_ROUNDS):
        if number < _WEIGHED:
            weight = normal.weight(values)
        gradient, slope, _ = normal.at(values, weight)
        gradient = gradient + precision @ (values - start)
        step = np.linalg.solve(slope + precision, -gradient) / spread
        step = spread * np.clip(step, -_STEP_MOST, _STEP_MOST)
        before = values
        values = np.clip(values + step, start - _FARTHEST * spread, start + _FARTHEST * spread)
        if (np.abs(values - before) < _SETTLED * spread).all():
            break
    _, slope, scatter = normal.at(values, normal.weight(values))
    # What noise makes of the instruments, and the prior, which is as sure as it says.
    inverse = np.linalg.inv(slope + precision)
    covariance = inverse @ (scatter + precision) @ inverse.T
    count = len(prior)
    covariance = 0.5 * (covariance + covariance.T)[:count, :count]
    return MotorFit(values[:count], covariance, prior, measured)


def _beside(*blocks: Array) -> Array:
    return np.asarray(block_diag(*blocks), dtype=np.float64)


@dataclass(frozen=True)
class _Normal:
    """The normal equations of instrumental variables, at the lines.

    Attributes
    ----------
    measured, ideal : _Equation
        Along the motion as measured, and along the reference.
    wrong, wrong_ideal : ndarray, shape (errors of the map, lines)
        Of both.
    """

    measured: _Equation
    ideal: _Equation
    wrong: Complex
    wrong_ideal: Complex

    @classmethod
    def of(cls, measured: _Equation, ideal: _Equation, tau: float) -> _Normal:
        return cls(measured, ideal, measured.map_errors(tau), ideal.map_errors(tau))

    def weight(self, values: Array) -> Array:
        """Return the weight of each line: the inverse of what is left there, 1/N^2."""
        return 2.0 / _spectrum(self._rest(values), self.measured.resolution)

    def at(self, values: Array, weight: Array) -> tuple[Array, Array, Array]:
        """Return gradient, its slopes, and the variance that noise gives it."""
        motor = values[: len(values) - len(self.wrong)]
        rest = self._rest(values)
        slopes = np.concatenate([self.measured.slopes(motor), -self.wrong])
        instruments = np.concatenate([self.ideal.slopes(motor), -self.wrong_ideal])
        weighed = np.conj(instruments * weight)
        return (
            np.real(weighed @ rest),
            np.real(weighed @ slopes.T),
            np.real(weighed @ instruments.T),
        )

    def _rest(self, values: Array) -> Complex:
        motor, errors = np.split(values, [len(values) - len(self.wrong)])
        left = self.measured.rest(Motor.of(motor)) - motor[len(MECHANICAL) - 1]
        return self.measured.lines(left) - errors @ self.wrong


def _prior(model: AxisModelConfig, *, electrical: bool) -> tuple[Array, Array]:
    """Return what is believed of a motor, and how surely: the inverse of the covariance."""
    friction = model.friction.model_copy(update={"enabled": True}).parameters()
    known = np.array([model.mass, *friction])
    prior: Array = np.append(np.log(np.maximum(known, _LEAST)), 0.0)
    spread = np.array([_MASS, *(_PRIOR for _ in LuGre._fields), _OFFSET])
    precision = _beside(*spread[:, None] ** -2.0)
    if not electrical:
        return prior, precision
    for spread in (_GAIN, _CURRENT):
        each = np.eye(len(PHASES)) * spread**-2.0
        together = np.full_like(each, (_COMMON * spread) ** -2.0 / len(PHASES))
        precision = _beside(precision, each + together)
    return np.append(prior, np.zeros(len(ELECTRICAL))), precision


def smoothed(values: Array, bandwidth: float) -> Array:
    """Return values without what is above a bandwidth, Hz, and without delay; last axis is time."""
    sections = butter(2, bandwidth, fs=1.0 / CONTROL_PERIOD, output="sos")
    return np.asarray(sosfiltfilt(sections, values, axis=-1), dtype=np.float64)


@dataclass(frozen=True)
class _Equation:
    """The equation of motion along a motion; every term has passed the same filter."""

    position: Array
    velocity: Array
    acceleration: Array
    late: Array
    thrust: ForceModel | None
    current: Array

    @classmethod
    def of(cls, position: Array, force: Array, thrust: ForceModel | None, lag: float) -> _Equation:
        T = CONTROL_PERIOD
        p = smoothed(position, _MOTION)
        velocity = np.gradient(p, T)
        acceleration = np.gradient(velocity, T)
        acceleration[1:-1] = (p[2:] - 2.0 * p[1:-1] + p[:-2]) / (T * T)
        ticks = np.arange(len(force))
        late = np.interp(ticks - lag / T, ticks, force)
        current = np.zeros((len(PHASES), 0))
        if thrust is not None:
            current = share_over(thrust, position=position, force=late).current
        return cls(p, velocity, acceleration, late, thrust, current)

    @property
    def resolution(self) -> float:
        """Distance between two lines, Hz."""
        return 1.0 / ((len(self.position) - 2 * EDGE) * CONTROL_PERIOD)

    def needed(self, motor: Motor, acceleration: Array) -> Array:
        """Return the force that a motor needs for the motion, N."""
        return motor.mass * acceleration + self._friction(motor.friction)

    def rest(self, motor: Motor) -> Array:
        """Return the force that mass, friction and amplifiers leave, f_0 included, N."""
        resisting = motor.mass * self.acceleration + self._friction(motor.friction)
        return smoothed(self.late, _MOTION) + self._more(motor) - resisting

    def slopes(self, values: Array) -> Complex:
        """Return the slopes of `rest` less f_0 over each value, at the lines."""
        columns = [-math.exp(values[0]) * self.acceleration]
        for index in range(1, len(values)):
            if index == len(MECHANICAL) - 1:
                columns.append(-np.ones_like(self.position))
                continue
            ends = []
            for sign in (1.0, -1.0):
                moved = values.copy()
                moved[index] += sign * _DIFFERENCE
                motor = Motor.of(moved)
                electrical = index >= len(MECHANICAL)
                ends.append(self._more(motor) if electrical else -self._friction(motor.friction))
            columns.append((ends[0] - ends[1]) / (2.0 * _DIFFERENCE))
        return self.lines(np.stack(columns))

    def map_errors(self, tau: float) -> Complex:
        """Return forces by errors of the map, of a share of 1, at the lines."""
        angle = 2.0 * np.pi * self.position / tau
        turns = [m * angle for m in range(1, _HARMONICS + 1)]
        shapes = [of(turn) * self.late for turn in turns for of in (np.cos, np.sin)]
        return self.lines(smoothed(np.stack(shapes), _MOTION))

    def lines(self, values: Array) -> Complex:
        """Return the lines of a spectrum up to `_FITTED`, of unit noise for unit noise."""
        inside = values[..., EDGE:-EDGE]
        count = inside.shape[-1]
        whole = np.fft.rfft(inside * tukey(count, _TAPER), axis=-1) / math.sqrt(count)
        return whole[..., : 1 + int(_FITTED / self.resolution)]

    def _friction(self, friction: LuGre) -> Array:
        z = bristle(self.position, self.velocity, np.zeros(len(self.position), bool), friction)
        force = friction.sigma_0 * z + friction.sigma_1 * np.gradient(z, CONTROL_PERIOD)
        return smoothed(force + friction.sigma_2 * self.velocity, _MOTION)

    def _more(self, motor: Motor) -> Array:
        """Return the thrust by errors of the amplifiers, N."""
        if self.thrust is None:
            return np.zeros(len(self.position))
        wrong = np.array(motor.gains)[:, None] * self.current
        wrong += np.array(motor.currents)[:, None]
        over = (
            forces_over(self.thrust.map, position=self.position, current=current).thrust
            for current in (wrong, self.current)
        )
        return smoothed(np.subtract(*over), _MOTION)


def _spectrum(lines: Complex, resolution: float) -> Array:
    """Return the power of lines, each as its neighbours have it, N^2."""
    width = max(3.0, _SMOOTHED / resolution)
    return gaussian_filter1d(np.abs(lines) ** 2, width) + _UNEXPLAINED
