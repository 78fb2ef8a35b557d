"""Metrics of a recording, each with its definition; all in SI units and double precision."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab.analysis.contour import contour_error
from motionlab.config.timing import CONTROL_PERIOD
from motionlab.telemetry.recording import AXES, Recording, VariantRecord
from motionlab.trajectory.reference import Interval, Reference

Array = NDArray[np.float64]

STEADY_TAIL = 0.2
"""Share of a hold, at its end, over which the steady-state error is taken."""


@dataclass(frozen=True)
class Definition:
    """Unit and meaning of a metric."""

    unit: str
    meaning: str


DEFINITIONS: dict[str, Definition] = {
    "max_abs_following_error": Definition("m", "largest abs(e), e = reference - measured position"),
    "min_following_error": Definition("m", "smallest e; the paper prints ranges"),
    "max_following_error": Definition("m", "largest e"),
    "mean_following_error": Definition("m", "mean of e"),
    "rms_following_error": Definition("m", "square root of the mean of e^2"),
    "itae": Definition("m s^2", "integral of t abs(e), t from the start of the window"),
    "max_abs_position_error": Definition("m", "largest abs(reference - true position)"),
    "steady_state_error": Definition(
        "m", "largest abs(e) over the last fifth of each hold; null without a hold"
    ),
    "settling_time": Definition(
        "s",
        "from the end of a command until abs(e) stays within settling_band to the end of the hold; "
        "the longest of all holds; null without a hold or where it never settles",
    ),
    "overshoot": Definition(
        "m",
        "how far the measured position goes past the target during a hold, in the direction of the "
        "move before it; the largest of all holds; null without a hold",
    ),
    "max_abs_velocity": Definition("m/s", "largest true speed"),
    "rms_force": Definition("N", "square root of the mean of thrust^2"),
    "max_abs_force": Definition("N", "largest abs(thrust)"),
    "rms_current": Definition("A", "square root of the mean of i_a^2 + i_b^2 + i_c^2"),
    "max_current": Definition("A", "largest abs(current) of any phase"),
    "saturated_fraction": Definition(
        "1", "share of ticks with the force command or a current command at its limit"
    ),
}
"""Metrics of one axis over a window."""

CONTOUR_DEFINITIONS: dict[str, Definition] = {
    "max": Definition("m", "largest distance from the measured position to the reference path"),
    "rms": Definition("m", "square root of the mean of that distance squared"),
}
"""Metrics of a variant's contour, both axes together."""


def variant_metrics(
    recording: Recording,
    name: str,
    reference: Reference,
    window: Interval,
    *,
    settling_band: float,
) -> dict[str, Any]:
    """Return the metrics of one variant over a window.

    Parameters
    ----------
    recording : Recording
        The run.
    name : str
        Which variant.
    reference : Reference
        What it was to follow.
    window : tuple of int
        Ticks [start, end).
    settling_band : float
        Following error below which a move counts as settled, m.

    Returns
    -------
    dict
        ``axes``, with one entry for each axis that moves, and ``contour``. Every value is a finite
        number or None; all are None for a variant that diverged.
    """
    record = recording.variants[name]
    if record.diverged is not None:
        nothing = dict.fromkeys(DEFINITIONS)
        return {
            "axes": {axis: dict(nothing) for axis in reference.moving},
            "contour": dict.fromkeys(CONTOUR_DEFINITIONS),
        }
    axes = {
        axis: _axis_metrics(record, axis, reference, window, settling_band)
        for axis in reference.moving
    }
    errors = np.stack([_channel(record, "following_error", axis, window) for axis in AXES], axis=1)
    distance = contour_error(reference.position, errors, window)
    contour = {"max": float(distance.max()), "rms": _rms(distance)}
    return {"axes": axes, "contour": contour}


def _axis_metrics(
    record: VariantRecord, axis: str, reference: Reference, window: Interval, band: float
) -> dict[str, float | None]:
    index = AXES.index(axis)
    error = _channel(record, "following_error", axis, window)
    position = _channel(record, "position", axis, window)
    true_error = reference.position[slice(*window), index] - position
    thrust = _channel(record, "thrust", axis, window)
    currents = np.stack([_channel(record, f"current_{phase}", axis, window) for phase in "abc"])
    saturated = np.maximum(
        _channel(record, "force_saturated", axis, window),
        _channel(record, "current_saturated", axis, window),
    )
    time = np.arange(len(error)) * CONTROL_PERIOD
    holds = _holds_within(reference.holds, window)
    return {
        "max_abs_following_error": _peak(error),
        "min_following_error": float(error.min()),
        "max_following_error": float(error.max()),
        "mean_following_error": float(error.mean()),
        "rms_following_error": _rms(error),
        "itae": float(np.sum(time * np.abs(error)) * CONTROL_PERIOD),
        "max_abs_position_error": _peak(true_error),
        "steady_state_error": _steady_state_error(error, holds),
        "settling_time": _settling_time(error, holds, band),
        "overshoot": _overshoot(error, holds, reference.position[slice(*window), index]),
        "max_abs_velocity": _peak(_channel(record, "velocity", axis, window)),
        "rms_force": _rms(thrust),
        "max_abs_force": _peak(thrust),
        "rms_current": float(np.sqrt(np.mean((currents**2).sum(axis=0)))),
        "max_current": _peak(currents),
        "saturated_fraction": float(saturated.mean()),
    }


def _channel(record: VariantRecord, name: str, axis: str, window: Interval) -> Array:
    return record.channel(name, axis)[slice(*window)].astype(np.float64)


def _peak(values: Array) -> float:
    return float(np.abs(values).max())


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _holds_within(holds: tuple[Interval, ...], window: Interval) -> list[Interval]:
    """Return the holds that begin in a window, cut at its end and counted from its start."""
    start, end = window
    return [(a - start, min(b, end) - start) for a, b in holds if start <= a < end]


def _steady_state_error(error: Array, holds: list[Interval]) -> float | None:
    tails = [error[b - max(1, round(STEADY_TAIL * (b - a))) : b] for a, b in holds]
    return max((_peak(tail) for tail in tails), default=None)


def _settling_time(error: Array, holds: list[Interval], band: float) -> float | None:
    longest = None
    for a, b in holds:
        outside = np.flatnonzero(np.abs(error[a:b]) > band)
        ticks = int(outside[-1]) + 1 if len(outside) else 0
        if ticks == b - a:
            return None
        longest = max(longest or 0.0, ticks * CONTROL_PERIOD)
    return longest


def _overshoot(error: Array, holds: list[Interval], reference: Array) -> float | None:
    worst = None
    before = 0
    for a, b in holds:
        way = np.sign(reference[a] - reference[before])
        past = float((-way * error[a:b]).max()) if way else 0.0
        worst = max(worst or 0.0, past)
        before = b - 1
    return worst
