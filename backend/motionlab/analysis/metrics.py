"""Metrics of a recording, each with its definition; all in SI units and double precision."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.analysis.contouring import contour_error, prolonged
from motionlab.config.planar import AXES
from motionlab.kernel.accumulator import (
    MEASURED_ROWS,
    MeasuredChannels,
    count_ticks,
    new_tally,
    tally_metrics,
)
from motionlab.lanes import WIDTH
from motionlab.telemetry.recording import Recording, VariantRecord
from motionlab.timing import CONTROL_PERIOD
from motionlab.trajectories.reference import Interval, Reference

Array = NDArray[np.float64]

STEADY_TAIL = 0.2
"""Share of a hold, at its end, over which the steady-state error is taken."""

_ROUNDING = 1e-12
"""Below a picometre a move or an error at rest is rounding, m."""


class Hold(NamedTuple):
    """A standstill after a move of one axis: ticks from the window's start, length of the move."""

    start: int
    end: int
    move: float


class ErrorWindow(NamedTuple):
    """The following error of one axis over a window, shape (ticks,), m, and its holds.

    A move counts as settled below `settling_band`, m.
    """

    error: Array
    holds: list[Hold]
    settling_band: float


@dataclass(frozen=True)
class Definition:
    """A metric: unit, meaning, formula, name on the screen, and its computation.

    Attributes
    ----------
    unit : str
        SI.
    meaning, formula, label : str
        `$` of the label stands for the axis.
    lower_is_better : bool
        Whether a comparison calls less an improvement.
    compute : callable, optional
        From an `ErrorWindow` to the value, or None where there is none. Left out, it is a running
        sum or extreme that the kernel keeps (`motionlab.kernel.accumulator.tally_metrics`).
    of_holds : bool
        Whether `compute` needs holds: without any, the error is not even kept.
    ratio : bool
        Whether B/A means something, and stands in a comparison.
    printed : str
        Row of tables on a terminal; empty where they leave it out.
    rank : str
        Whether tables show it at once, on demand, or not.
    scale : str
        Metrics of one scale are shown in one unit.
    """

    unit: str
    meaning: str
    formula: str
    label: str = ""
    lower_is_better: bool = False
    compute: Callable[[ErrorWindow], float | None] | None = None
    of_holds: bool = False
    ratio: bool = False
    printed: str = ""
    rank: Literal["main", "other", "hidden"] = "other"
    scale: str = ""


def _steady_state_error(window: ErrorWindow) -> float | None:
    tails = [window.error[b - max(1, round(STEADY_TAIL * (b - a))) : b] for a, b, _ in window.holds]
    return max((_peak(tail) for tail in tails), default=None)


def _settling_time(window: ErrorWindow) -> float | None:
    longest = None
    for a, b, _ in window.holds:
        outside = np.flatnonzero(np.abs(window.error[a:b]) > window.settling_band)
        ticks = int(outside[-1]) + 1 if len(outside) else 0
        if ticks == b - a:
            return None
        longest = max(longest or 0.0, ticks * CONTROL_PERIOD)
    return longest


def _overshoot(window: ErrorWindow) -> float | None:
    return max((distance for distance, _ in _excursions(window)), default=None)


def _relative_overshoot(window: ErrorWindow) -> float | None:
    return max((distance / move for distance, move in _excursions(window)), default=None)


def _excursions(window: ErrorWindow) -> list[tuple[float, float]]:
    """Return the overshoot of each hold, and the length of its move, m."""
    return [
        (max(0.0, float((-np.sign(move) * window.error[a:b]).max())), abs(move))
        for a, b, move in window.holds
        if abs(move) > _ROUNDING
    ]


def _peak(values: Array) -> float:
    return float(np.abs(values).max())


DEFINITIONS: dict[str, Definition] = {
    "max_abs_following_error": Definition(
        "m",
        "largest following error e = reference - measured position",
        "max abs(e)",
        "max |e_$|",
        lower_is_better=True,
        rank="main",
        scale="following",
        ratio=True,
        printed="max abs following error",
    ),
    "min_following_error": Definition(
        "m",
        "lower end of the range of e",
        "min e",
        "min e_$",
        rank="hidden",
    ),
    "max_following_error": Definition(
        "m",
        "upper end of the range of e",
        "max e",
        "max e_$",
        rank="hidden",
    ),
    "mean_following_error": Definition(
        "m",
        "mean of e over the N ticks of the window",
        "sum(e)/N",
        "mean e_$",
        rank="hidden",
    ),
    "rms_following_error": Definition(
        "m",
        "root mean square of e",
        "sqrt(sum(e^2)/N)",
        "RMS e_$",
        lower_is_better=True,
        rank="main",
        scale="following",
        ratio=True,
        printed="RMS following error",
    ),
    "itae": Definition(
        "m s^2",
        "integral of time times abs(e), t = 0 at the start of the window",
        "sum(t abs(e)) T_s",
        "ITAE $",
        lower_is_better=True,
        ratio=True,
    ),
    "max_abs_position_error": Definition(
        "m",
        "largest error of the true position p, recorded to 7 nm at 145 mm",
        "max abs(p_ref - p)",
        "max |p_$ error|",
        lower_is_better=True,
        rank="hidden",
        ratio=True,
    ),
    "steady_state_error": Definition(
        "m",
        "largest abs(e) over the last fifth of each hold; null without a hold",
        "max abs(e), last 20 % of holds",
        "steady e_$",
        lower_is_better=True,
        compute=_steady_state_error,
        rank="main",
        scale="hold",
        ratio=True,
        printed="largest error at rest",
        of_holds=True,
    ),
    "settling_time": Definition(
        "s",
        "time from the end of command until abs(e) stays within settling_band, "
        "the longest of all holds",
        "(last k with abs(e_k) > band, + 1 - k_end) T_s",
        "settling $",
        lower_is_better=True,
        compute=_settling_time,
        rank="main",
        ratio=True,
        printed="settling time",
        of_holds=True,
    ),
    "overshoot": Definition(
        "m",
        "largest excursion past the target during a hold, in the direction of the move before it",
        "max(0, -sgn(move) e)",
        "overshoot $",
        lower_is_better=True,
        compute=_overshoot,
        scale="hold",
        of_holds=True,
    ),
    "relative_overshoot": Definition(
        "1",
        "overshoot as a share of the length of its move, the largest of all holds",
        "max(0, -e/move)",
        "overshoot $, share",
        lower_is_better=True,
        compute=_relative_overshoot,
        rank="hidden",
        of_holds=True,
    ),
    "max_abs_velocity": Definition("m/s", "largest true speed", "max abs(v)", "peak |v_$|"),
    "rms_force": Definition(
        "N",
        "root mean square of the true thrust f",
        "sqrt(sum(f^2)/N)",
        "RMS F_$",
        ratio=True,
        printed="RMS force",
    ),
    "max_abs_force": Definition(
        "N",
        "largest true thrust",
        "max abs(f)",
        "peak F_$",
        ratio=True,
    ),
    "rms_current": Definition(
        "A",
        "root mean square of the three phase currents together, which the copper loss follows",
        "sqrt(sum(i_a^2 + i_b^2 + i_c^2)/N)",
        "RMS i_$",
        ratio=True,
        printed="RMS current",
    ),
    "max_current": Definition(
        "A",
        "largest current of any phase",
        "max abs(i)",
        "peak i_$",
        rank="main",
        ratio=True,
    ),
    "saturated_fraction": Definition(
        "1",
        "share of ticks with the force command or a current command at its limit",
        "(saturated ticks)/N",
        "saturated $",
        lower_is_better=True,
        printed="saturated",
    ),
}
"""Metrics of one axis over a window; docs/metrics.md prints this table."""

CONTOUR_DEFINITIONS: dict[str, Definition] = {
    "max": Definition(
        "m",
        "largest distance d from the measured position to the path",
        "max d",
        "contour max",
        lower_is_better=True,
        rank="main",
        scale="following",
    ),
    "rms": Definition(
        "m",
        "root mean square of that distance",
        "sqrt(sum(d^2)/N)",
        "contour RMS",
        lower_is_better=True,
        scale="following",
    ),
}
"""Metrics of a variant's contour, both axes together."""


_OF_CHANNEL = {
    "max_abs_position_error": "position",
    "max_abs_velocity": "velocity",
    "rms_force": "thrust",
    "max_abs_force": "thrust",
}
"""Metrics of channels that only a simulation has."""


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
        Ticks [start, end), all of them recorded.
    settling_band : float
        Following error below which a move counts as settled, m.

    Returns
    -------
    dict
        ``axes``, with one entry for each axis that moves, and ``contour``. Every value is a finite
        number or None: None where a drive does not measure its channel, and all of them for a
        variant that diverged or of which no following error was measured. Between samples that
        were not measured the metrics take straight lines.
    """
    record = recording.variants[name]
    diverged = record.diverged is not None
    record = record.cut(window[0] - recording.first_tick, window[1] - recording.first_tick)
    errors = np.stack([_channel(record, "following_error", axis) for axis in AXES], axis=1)
    if diverged or not np.isfinite(errors).any(axis=0).all():
        nothing = dict.fromkeys(DEFINITIONS)
        return {
            "axes": {axis: dict(nothing) for axis in reference.moving},
            "contour": dict.fromkeys(CONTOUR_DEFINITIONS),
        }
    plain = tally_metrics(_tally(record, reference.position[slice(*window)]), window[1] - window[0])
    axes = {}
    for axis in reference.moving:
        index = AXES.index(axis)
        figures = {name: float(values[index]) for name, values in plain.items()} | error_metrics(
            errors[:, index], reference, axis, window, settling_band=settling_band
        )
        absent = {
            each for each, channel in _OF_CHANNEL.items() if not _is_measured(record, channel, axis)
        }
        axes[axis] = {name: None if name in absent else figures[name] for name in DEFINITIONS}
    distance = contour_error(*prolonged(reference.position, window), errors)
    contour = {"max": float(distance.max()), "rms": float(np.sqrt(np.mean(distance**2)))}
    return {"axes": axes, "contour": contour}


def error_metrics(
    error: Array, reference: Reference, axis: str, window: Interval, *, settling_band: float
) -> dict[str, float | None]:
    """Return the metrics of one axis that are computed from its following error; None without one.

    Parameters
    ----------
    error : ndarray, shape (ticks,)
        Following error over the window, as recorded, m.
    reference : Reference
        What was to be followed.
    axis : str
        ``x`` or ``y``.
    window : tuple of int
        Ticks [start, end).
    settling_band : float
        Following error below which a move counts as settled, m.
    """
    holds = holds_within(reference, AXES.index(axis), window)
    error = np.where(np.abs(error) < _ROUNDING, 0.0, error)
    of = ErrorWindow(error, holds, settling_band)
    return {name: each.compute(of) for name, each in DEFINITIONS.items() if each.compute}


def needs_errors(reference: Reference) -> bool:
    """Return whether `error_metrics` has any on a reference: else errors need not be kept."""
    return any(
        each.compute is not None and (bool(reference.holds) or not each.of_holds)
        for each in DEFINITIONS.values()
    )


def holds_within(reference: Reference, index: int, window: Interval) -> list[Hold]:
    """Return the holds of an axis, x or y by its index, that begin in a window, cut at its end."""
    start, end = window
    position = reference.position[:, index]
    from_tick = {edge_end: edge_start for edge_start, edge_end in reference.edges}
    return [
        # A true step is no edge: it happens between two ticks.
        Hold(a - start, min(b, end) - start, float(position[a] - position[from_tick.get(a, a - 1)]))
        for a, b in reference.holds
        if start <= a < end
    ]


def _tally(record: VariantRecord, target: Array) -> Array:
    """Return the tally of a record's two axes, shape (TALLY_ROWS, 2)."""
    samples = np.zeros((len(target), MEASURED_ROWS, WIDTH), dtype=np.float32)
    for row, name in enumerate(MeasuredChannels._fields):
        for lane, axis in enumerate(AXES):
            samples[:, row, lane] = (
                np.maximum(
                    record.channel("force_saturated", axis),
                    record.channel("current_saturated", axis),
                )
                if name == "saturated"
                else _whole(record.channel(name, axis))
            )
    tally = new_tally(WIDTH)
    count_ticks(samples, np.ascontiguousarray(target[:, None, :]), 0, tally)
    return tally[:, : len(AXES)]


def _channel(record: VariantRecord, name: str, axis: str) -> Array:
    return _whole(record.channel(name, axis)).astype(np.float64)


def _is_measured(record: VariantRecord, name: str, axis: str) -> bool:
    return bool(np.isfinite(record.channel(name, axis)).any())


def _whole(values: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return values with straight lines where a sample is NaN, or as they are if all are."""
    known = np.flatnonzero(np.isfinite(values))
    if len(known) in {0, len(values)}:
        return values
    return np.interp(np.arange(len(values)), known, values[known]).astype(np.float32)
