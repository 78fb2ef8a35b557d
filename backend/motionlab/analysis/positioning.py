"""Accuracy and repeatability of positioning one axis, in the style of ISO 230-2:2014.

Targets P_i, i = 1 ... m, are approached n times in each direction; x_ij is the actual less the
target position of approach j. With the mean x_i and the standard deviation s_i of each direction
(up in the positive one, down in the negative one), coverage factor k = 2::

    B_i = x_i(up) - x_i(down)                     B = max abs(B_i)
    R_i(up) = 4 s_i(up)                           R(up) = max R_i(up)
    R_i = max(2 s_i(up) + 2 s_i(down) + abs(B_i), R_i(up), R_i(down))      R = max R_i
    M = max x_i - min x_i, of the means of both directions
    E = max(x_i(up), x_i(down)) - min(x_i(up), x_i(down))
    A = max(x_i(up) + 2 s_i(up), x_i(down) + 2 s_i(down))
        - min(x_i(up) - 2 s_i(up), x_i(down) - 2 s_i(down))

The style of a test, not a test of a machine: no conformance is claimed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

UP, DOWN = 1, -1
"""Direction of an approach."""

READ = 0.1
"""A position is the mean over the last part of a rest: that long, or half of a shorter rest, s."""

REST = 0.05
"""Shortest rest at a target, s."""

SAME = 50e-9
"""Rests no further apart than this are at the same target, m: recorded references are rounded."""

RUNS_MIN = 2
"""Fewest approaches of a target in each direction: with one there is no standard deviation."""

_SHIFT = 0.3  # of the distance of targets, either way: periodic errors are not met in phase
_GOLDEN = 0.6180339887498949


class Rest(NamedTuple):
    """A rest at a target: samples [start, stop), and the direction in which it was approached."""

    start: int
    stop: int
    direction: int
    place: float


@dataclass(frozen=True)
class Target:
    """Deviations of the approaches of one target.

    Attributes
    ----------
    place : float
        Target position P_i, m.
    up, down : ndarray, shape (n,)
        Deviations x_ij in each direction, m; two or more.
    """

    place: float
    up: Array
    down: Array

    @property
    def mean_up(self) -> float:
        """Mean deviation of approaches in the positive direction, m."""
        return float(self.up.mean())

    @property
    def mean_down(self) -> float:
        """Mean deviation of approaches in the negative direction, m."""
        return float(self.down.mean())

    @property
    def mean(self) -> float:
        """Mean of both directions, m."""
        return (self.mean_up + self.mean_down) / 2

    @property
    def reversal(self) -> float:
        """Reversal value B_i, m."""
        return self.mean_up - self.mean_down

    @property
    def s_up(self) -> float:
        """Standard deviation in the positive direction, m."""
        return float(self.up.std(ddof=1))

    @property
    def s_down(self) -> float:
        """Standard deviation in the negative direction, m."""
        return float(self.down.std(ddof=1))

    @property
    def repeatability(self) -> float:
        """Bidirectional repeatability R_i, m."""
        both = 2 * self.s_up + 2 * self.s_down + abs(self.reversal)
        return max(both, 4 * self.s_up, 4 * self.s_down)


@dataclass(frozen=True)
class AxisFigures:
    """Figures of an axis, m; the module has their definitions."""

    A: float
    A_up: float
    A_down: float
    E: float
    E_up: float
    E_down: float
    M: float
    R: float
    R_up: float
    R_down: float
    B: float
    B_mean: float


def figures_of(targets: Sequence[Target]) -> AxisFigures:
    """Return the figures of an axis from its targets, one or more."""
    up = np.array([(target.mean_up, 2 * target.s_up) for target in targets]).T
    down = np.array([(target.mean_down, 2 * target.s_down) for target in targets]).T
    both = np.concatenate([up, down], axis=1)
    mean = [target.mean for target in targets]
    reversal = [target.reversal for target in targets]
    return AxisFigures(
        A=_accuracy(both),
        A_up=_accuracy(up),
        A_down=_accuracy(down),
        E=float(np.ptp(both[0])),
        E_up=float(np.ptp(up[0])),
        E_down=float(np.ptp(down[0])),
        M=float(np.ptp(mean)),
        R=max(target.repeatability for target in targets),
        R_up=2 * float(up[1].max()),
        R_down=2 * float(down[1].max()),
        B=float(np.abs(reversal).max()),
        B_mean=float(np.mean(reversal)),
    )


def _accuracy(means: Array) -> float:
    """Return the largest mean plus 2 s less the smallest mean less 2 s; rows are mean and 2 s."""
    return float((means[0] + means[1]).max() - (means[0] - means[1]).min())


def targets_in(low: float, high: float, count: int) -> list[float]:
    """Return rising target positions, m, ``P_i = low + (i - 1) p + r_i``.

    The distances differ by r_i, up to 0.3 p either way, so that errors that repeat along the axis
    are not met at the same phase each time. ISO 230-2 draws r_i at random; here it is a fixed
    sequence, so that a test can be repeated. The first and the last target are at the ends.
    """
    pitch = (high - low) / (count - 1)
    inner = [low + i * pitch + _SHIFT * pitch * _shift(i) for i in range(1, count - 1)]
    return [low, *inner, high]


def _shift(i: int) -> float:
    return 2 * ((i * _GOLDEN) % 1.0) - 1


def cycle(targets: Sequence[float], overrun: float, runs: int) -> list[float]:
    """Return the positions of the standard test cycle, in the order of the visit.

    From beyond the first target up through all, beyond the last, and down again, `runs` times; the
    axis turns outside of the targets.
    """
    below, above = targets[0] - overrun, targets[-1] + overrun
    once = [*targets, above, *reversed(targets), below]
    return [below, *once * runs]


def rests(reference: Array, period: float) -> list[Rest]:
    """Return the rests of a reference after a move.

    Parameters
    ----------
    reference : ndarray, shape (samples,)
        Position of one axis, m.
    period : float
        Of the samples, s.
    """
    step = np.diff(reference)
    moving = np.flatnonzero(step)
    ends = np.append(moving, len(reference) - 1)
    long = np.flatnonzero(np.diff(ends) * period >= REST)
    return [
        Rest(
            start=int(ends[k]) + 1,
            stop=int(ends[k + 1]) + 1,
            direction=UP if step[ends[k]] > 0 else DOWN,
            place=float(reference[ends[k] + 1]),
        )
        for k in long
    ]


def grouped(rests: Sequence[Rest]) -> list[tuple[float, list[Rest], list[Rest]]]:
    """Return targets with two rests or more in each direction, rising: place, up, down."""
    ordered = sorted(rests, key=lambda rest: rest.place)
    groups: list[list[Rest]] = []
    for rest in ordered:
        if groups and rest.place - groups[-1][0].place <= SAME:
            groups[-1].append(rest)
        else:
            groups.append([rest])
    targets: list[tuple[float, list[Rest], list[Rest]]] = []
    for group in groups:
        up = [rest for rest in sorted(group) if rest.direction == UP]
        down = [rest for rest in sorted(group) if rest.direction == DOWN]
        if min(len(up), len(down)) >= RUNS_MIN:
            targets.append((float(np.median([rest.place for rest in group])), up, down))
    return targets


def read(rest: Rest, values: Array, period: float) -> float:
    """Return the mean of values over the end of a rest.

    Parameters
    ----------
    rest : Rest
        Which samples.
    values : ndarray, shape (samples,)
        What is read.
    period : float
        Of the samples, s.
    """
    long = rest.stop - rest.start
    last = max(1, min(round(READ / period), long // 2))
    return float(values[rest.stop - last : rest.stop].mean())
