"""Periodic signals of several kinds: sums of sines that fill a period with whole cycles.

As a motion they are slides to and fro: eased from rest to a constant velocity and back, with the
multisine faded in and out where that is eased, and rests between. When which period of which slide
is measured follows from the motion's config alone, so that a record of it needs nothing besides.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from motionlab.config.multisine import Multisine, Signal
from motionlab.timing import CONTROL_PERIOD, to_ticks
from motionlab.trajectories.motion import Piece, refuse_too_long
from motionlab.trajectories.motion_profile import smooth_start

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


AROUND = 0.015  # share of a frequency, on either side, over which a response is smooth


@dataclass(frozen=True)
class Lines:
    """The frequencies of a multisine.

    Attributes
    ----------
    ticks : int
        Control periods of one period of the multisine.
    cycles : ndarray of int, shape (lines,)
        Whole cycles of each in a period.
    every : bool
        Whether they are all of whole cycles, not spread over the logarithm of frequency.
    """

    ticks: int
    cycles: NDArray[np.int64]
    every: bool = False

    @classmethod
    def between(cls, low: float, high: float, count: int, ticks: int) -> Lines:
        """Return lines between two frequencies, Hz, evenly over their logarithm.

        Where lines of whole cycles lie further apart than that, there are fewer than `count`.
        """
        seconds = ticks * CONTROL_PERIOD
        cycles = np.round(np.geomspace(low, high, count) * seconds).astype(np.int64)
        return cls(ticks, np.unique(cycles))

    @property
    def share(self) -> Array:
        """Return the size of each line, even over octaves; the sum of their squares is 1."""
        size = np.sqrt(1.0 / self.cycles) if self.every else np.ones(len(self.cycles))
        return np.asarray(size / np.linalg.norm(size), dtype=np.float64)

    @property
    def frequency(self) -> Array:
        """Of each line, Hz."""
        return self.cycles / (self.ticks * CONTROL_PERIOD)

    @classmethod
    def of(cls, signal: Signal, low: float, high: float, count: int, ticks: int) -> Lines:
        """Return the lines of a signal: of noise and of a chirp all of whole cycles."""
        if signal in {"multisine", "stepped-sine"}:
            return cls.between(low, high, count, ticks)
        seconds = ticks * CONTROL_PERIOD
        return cls(ticks, np.arange(round(low * seconds), round(high * seconds) + 1), every=True)

    def reported(self, count: int) -> list[tuple[int, int]]:
        """Return which lines a response has, and how many on either side of each tell it, too.

        Every line tells its own; of `every` frequency `count` at most, spread evenly over their
        logarithm, with those around.
        """
        last = len(self.cycles) - 1
        if not self.every:
            return [(k, 0) for k in range(last + 1)]
        ends = self.cycles[0], self.cycles[-1]
        chosen = np.unique(np.round(np.geomspace(*ends, count)).astype(np.int64)) - ends[0]
        halves = np.maximum(2, np.round(AROUND * self.cycles[chosen])).astype(np.int64)
        halves = np.minimum(halves, np.minimum(chosen, last - chosen))
        return list(zip(chosen.tolist(), halves.tolist(), strict=True))

    def motion(self, amplitudes: Complex) -> tuple[Array, Array, Array]:
        """Return a period of the sum of sines, and of its first and second derivative in time.

        Parameters
        ----------
        amplitudes : ndarray of complex, shape (lines,)
            Of each sine, with the phase as argument.
        """
        rate = 2j * np.pi * self.frequency
        spectra = np.zeros((3, self.ticks // 2 + 1), dtype=np.complex128)
        spectra[:, self.cycles] = [0.5 * self.ticks * amplitudes * rate**n for n in range(3)]
        value, first, second = np.fft.irfft(spectra, self.ticks)
        return value, first, second

    def amplitudes(self, signal: Array) -> Complex:
        """Return the complex amplitudes at the lines of each whole period, (periods, lines).

        Parameters
        ----------
        signal : ndarray, shape (periods * ticks,)
            Tick by tick.
        """
        spectra = np.fft.rfft(signal.reshape(-1, self.ticks))[:, self.cycles]
        return np.asarray(spectra * (2.0 / self.ticks), dtype=np.complex128)


def excitation(
    signal: Signal, lines: Lines, size: Array, number: int, rng: np.random.Generator
) -> Complex:
    """Return the amplitudes of the lines in one slide.

    Parameters
    ----------
    signal : str
        ``multisine``: phases are random. ``noise``: sizes, too, as normal noise has them.
        ``chirp``: the phases of Schroeder (IEEE Trans. Information Theory 16, 1970) for a constant
        acceleration, through all frequencies in a period, from a random instant on.
        ``stepped-sine``: one line with the power of all, the next one in every second slide.
    lines : Lines
        Frequencies.
    size : ndarray, shape (lines,)
        Of each line, RMS over slides times the root of 2.
    number : int
        Of the slide.
    rng : Generator
        Of the phases.
    """
    count = len(size)
    phases = np.exp(2j * np.pi * rng.random(count))
    if signal == "noise":
        phases *= np.sqrt(rng.exponential(size=count))
    elif signal == "chirp":
        power = (size * lines.cycles**2) ** 2
        power /= power.sum()
        before = np.cumsum(np.cumsum(power)) - np.cumsum(power)
        phases = np.exp(-2j * np.pi * before + 1j * np.angle(phases[0]) * lines.cycles)
    elif signal == "stepped-sine":
        phases *= np.where(np.arange(count) == number // 2 % count, np.sqrt(count), 0.0)
    return np.asarray(size * phases, dtype=np.complex128)


SETTLING = to_ticks(0.5)
"""Ticks of a slide at full velocity before it is measured."""
EASE = to_ticks(0.2)
"""Ticks in which its velocity, and with it the multisine, is eased in; and out again."""
_REST = to_ticks(0.1)
_MODULATION = 0.1  # rms of the velocity's change by all sines, over the velocity


@dataclass(frozen=True)
class Slide:
    """One slide of a motion.

    Attributes
    ----------
    start, stop : int
        Ticks of the motion that are measured, whole periods.
    forward : bool
        Its direction.
    amplitudes : ndarray of complex, shape (lines,)
        Of the sines in the reference, m, their phase that at `start`.
    """

    start: int
    stop: int
    forward: bool
    amplitudes: Complex


def lines_of(config: Multisine) -> Lines:
    """Return the frequencies of a motion."""
    ticks = to_ticks(1.0 / config.low)
    return Lines.of(config.signal, config.low, config.high, config.lines, ticks)


def slide_seconds(config: Multisine) -> float:
    """Return the time from one slide to the next, s."""
    return _ticks(config, lines_of(config)) * CONTROL_PERIOD


def slides(config: Multisine) -> Iterator[Slide]:
    """Yield the slides of a motion in their order."""
    lines, rng = lines_of(config), np.random.default_rng(config.seed)
    f = lines.frequency
    w = 2.0 * np.pi * f
    share = math.sqrt(2.0) * lines.share
    size = share * config.acceleration * np.sqrt(1.0 + (f / config.corner) ** 2) / w**2
    size = np.minimum(size, share * _MODULATION * config.velocity / w)
    measured = config.periods * lines.ticks
    for number in range(config.slides):
        start = number * _ticks(config, lines) + EASE + SETTLING
        amplitudes = excitation(config.signal, lines, size, number, rng)
        yield Slide(start, start + measured, number % 2 == 0, amplitudes)


def multisine_motion(config: Multisine) -> Piece:
    """Return the slides as one piece that begins and ends at rest."""
    lines = lines_of(config)
    ticks, axis = _ticks(config, lines), "xy".index(config.axis)
    refuse_too_long(config.slides * ticks)
    moved = ticks - _REST
    travel = config.velocity * (moved - EASE) * CONTROL_PERIOD
    columns = np.zeros((3, config.slides * ticks + 1, 2))
    columns[0] = config.center.x, config.center.y
    fade = _fade(moved)
    for number, slide in enumerate(slides(config)):
        here = slice(number * ticks, (number + 1) * ticks)
        way, speed, change = _base(moved, config.velocity)
        direction = 1.0 if slide.forward else -1.0
        base = [direction * (way - 0.5 * travel), direction * speed, direction * change]
        shaken = _product(fade, _repeated(lines, slide, moved))
        for k in range(3):
            rest = direction * 0.5 * travel if k == 0 else 0.0
            columns[k, here, axis] += np.append(base[k] + shaken[k], np.full(_REST, rest))
    columns[0, -1, axis] = columns[0, -2, axis]
    stretches = ((moved, False), (_REST, True)) * config.slides
    law = partial(smooth_start, lead_in=0)
    return Piece(partial(_looked_up, columns), law, config.slides * ticks, stretches=stretches)


def _ticks(config: Multisine, lines: Lines) -> int:
    """Return the ticks from one slide to the next."""
    return 2 * EASE + SETTLING + config.periods * lines.ticks + _REST


def _smooth(ticks: int) -> tuple[Array, Array, Array]:
    """Return the quintic from 0 to 1 over some ticks, and its derivatives by time."""
    u, T = np.arange(ticks) / ticks, ticks * CONTROL_PERIOD
    value = u**3 * (10.0 - 15.0 * u + 6.0 * u**2)
    first = 30.0 * u**2 * (1.0 - u) ** 2 / T
    second = 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u) / T**2
    return value, first, second


def _fade(moved: int) -> list[Array]:
    """Return the size of the multisine over a slide, and its derivatives by time."""
    rise = _smooth(EASE)
    between = moved - 2 * EASE
    size = np.concatenate([rise[0], np.ones(between), 1.0 - rise[0]])
    first = np.concatenate([rise[1], np.zeros(between), -rise[1]])
    second = np.concatenate([rise[2], np.zeros(between), -rise[2]])
    return [size, first, second]


def _base(moved: int, velocity: float) -> tuple[Array, Array, Array]:
    """Return way, velocity and acceleration of a slide without its multisine."""
    u = (np.arange(EASE) / EASE).astype(np.float64)
    T, between = EASE * CONTROL_PERIOD, moved - 2 * EASE
    eased = T * (u**4 * (2.5 - 3.0 * u + u**2))  # of the quintic, its integral
    time = np.arange(between) * CONTROL_PERIOD
    last = 0.5 * T + between * CONTROL_PERIOD
    way = np.concatenate([eased, 0.5 * T + time, last + u * T - eased])
    size, change, _ = _fade(moved)
    return (velocity * way).astype(np.float64), velocity * size, velocity * change


def _repeated(lines: Lines, slide: Slide, moved: int) -> list[Array]:
    """Return the multisine of a slide and its derivatives, whose periods begin at its start."""
    phase = (np.arange(moved) - EASE - SETTLING) % lines.ticks
    return [period[phase] for period in lines.motion(slide.amplitudes)]


def _product(a: list[Array], b: list[Array]) -> list[Array]:
    """Return the product of two functions of time and its derivatives."""
    return [
        a[0] * b[0],
        a[1] * b[0] + a[0] * b[1],
        a[2] * b[0] + 2.0 * a[1] * b[1] + a[0] * b[2],
    ]


def _looked_up(columns: Array, ticks: Array) -> tuple[Array, Array, Array]:
    """Return places and their derivatives by ticks."""
    k = np.asarray(ticks, dtype=np.int64)
    return columns[0][k], columns[1][k] * CONTROL_PERIOD, columns[2][k] * CONTROL_PERIOD**2
