"""Accumulated sums behind the metrics, tick by tick, for one run and for batches.

Extremes and sums of the channels that metrics use. Runs, which record every channel, and batches,
which record none, use the same compiled loop in the same order and precision, so that their metrics
agree to the last bit.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.lanes import (
    Lanes,
    axes_at,
    cached,
    compiled,
    flush_subnormals,
    pack,
    recorded,
    restore_mode,
    select,
    unpack,
)
from motionlab.timing import CONTROL_PERIOD

Array = NDArray[np.float64]


class MeasuredChannels(NamedTuple):
    """The recorded channels that enter the metrics."""

    following_error: Lanes
    position: Lanes
    velocity: Lanes
    thrust: Lanes
    current_a: Lanes
    current_b: Lanes
    current_c: Lanes
    saturated: Lanes  # 1 while the force command or a current command is at its limit


class Target(NamedTuple):
    """Reference data of a sample."""

    position: Lanes  # m


class Tally(NamedTuple):
    """Extremes and sums over the ticks of a window."""

    error_min: Lanes  # of the following error, m
    error_max: Lanes
    error_sum: Lanes
    error_squares: Lanes
    error_times: Lanes  # sum of t abs(e), m s
    true_error_max: Lanes  # of abs(reference - true position), m
    velocity_max: Lanes  # of the magnitude, m/s
    thrust_squares: Lanes
    thrust_max: Lanes  # of the magnitude, N
    current_squares: Lanes  # of the three phases together
    current_max: Lanes  # of the magnitude of any phase, A
    saturated: Lanes  # ticks


MEASURED_ROWS = len(MeasuredChannels._fields)
TALLY_ROWS = len(Tally._fields)


def new_tally(*shape: int) -> Array:
    """Return a tally of no ticks, shape (TALLY_ROWS, *shape)."""
    tally = np.zeros((TALLY_ROWS, *shape))
    tally[Tally._fields.index("error_min")] = np.inf
    tally[Tally._fields.index("error_max")] = -np.inf
    return tally


@compiled
def _larger(x: Lanes, y: Lanes) -> Lanes:
    return select(y > x, y, x)


@compiled
def one_more(tally: Tally, at: MeasuredChannels, target: Target, time: float) -> Tally:
    """Return a tally with one more tick, `time` seconds after the start of its window."""
    e = at.following_error
    size = abs(e)
    a, b, c = at.current_a, at.current_b, at.current_c
    largest = _larger(_larger(abs(a), abs(b)), abs(c))
    return Tally(
        error_min=select(e < tally.error_min, e, tally.error_min),
        error_max=_larger(tally.error_max, e),
        error_sum=tally.error_sum + e,
        error_squares=tally.error_squares + e * e,
        error_times=tally.error_times + time * size,
        true_error_max=_larger(tally.true_error_max, abs(target.position - at.position)),
        velocity_max=_larger(tally.velocity_max, abs(at.velocity)),
        thrust_squares=tally.thrust_squares + at.thrust * at.thrust,
        thrust_max=_larger(tally.thrust_max, abs(at.thrust)),
        current_squares=tally.current_squares + (a * a + b * b + c * c),
        current_max=_larger(tally.current_max, largest),
        saturated=tally.saturated + at.saturated,
    )


@compiled
def add_ticks(
    samples: NDArray[np.float32], target: Array, first: int, tally: Array, width: Lanes
) -> None:
    """Add consecutive ticks of as many lanes as `width` has to their tally; see `count_ticks`."""
    total = unpack(Tally, tally, 0, width)
    for k in range(samples.shape[0]):
        at = recorded(MeasuredChannels, samples, k, width)
        time = (first + k) * CONTROL_PERIOD
        total = one_more(total, at, axes_at(Target, target, k, width), time)
    pack(total, tally)


@cached
def count_ticks(samples: NDArray[np.float32], target: Array, first: int, tally: Array) -> None:
    """Add consecutive ticks of eight lanes to their tally.

    Parameters
    ----------
    samples : ndarray of float32, shape (ticks, MEASURED_ROWS, WIDTH)
        Fields of `MeasuredChannels`.
    target : ndarray, shape (ticks, 1, 2)
        Position reference of x, for even lanes, and of y, for odd ones.
    first : int
        Ticks of the window that were added before.
    tally : ndarray, shape (TALLY_ROWS, WIDTH)
        Fields of `Tally`; overwritten.
    """
    mode = flush_subnormals()
    add_ticks(samples, target, first, tally, unpack(Tally, tally, 0).error_sum)
    restore_mode(mode)


def tally_metrics(tally: Array, ticks: int) -> dict[str, Array]:
    """Return the metrics that follow from a tally.

    Parameters
    ----------
    tally : ndarray, shape (TALLY_ROWS, ...)
        Fields of `Tally` over `ticks` ticks of each lane.
    ticks : int
        Ticks in the window, at least one.

    Returns
    -------
    dict of str to ndarray, shape (...)
        Keys of `motionlab.analysis.metrics.DEFINITIONS`, in SI units.
    """
    t = Tally(*tally)
    return {
        "max_abs_following_error": np.maximum(-t.error_min, t.error_max),
        "min_following_error": t.error_min,
        "max_following_error": t.error_max,
        "mean_following_error": t.error_sum / ticks,
        "rms_following_error": np.sqrt(t.error_squares / ticks),
        "itae": t.error_times * CONTROL_PERIOD,
        "max_abs_position_error": t.true_error_max,
        "max_abs_velocity": t.velocity_max,
        "rms_force": np.sqrt(t.thrust_squares / ticks),
        "max_abs_force": t.thrust_max,
        "rms_current": np.sqrt(t.current_squares / ticks),
        "max_current": t.current_max,
        "saturated_fraction": t.saturated / ticks,
    }
