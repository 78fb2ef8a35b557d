"""What a comparison looks at and tolerates by default, and its verdict as a sentence."""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab.analysis.comparison_document import ChannelComparison, Comparison
from motionlab.analysis.comparison_options import Tolerance

CHANNELS_MAX = 8
"""Channels that are compared where none are named."""

RANGE = 0.02
"""Share of the baseline's range that is tolerated."""

NOISE = 6.0
"""Standard deviations of noise that are tolerated: two runs of minutes differ by so much."""

TIME = 1e-3
"""Tolerance in time, s: two control periods."""

_TELLING = (
    ("following_error",),
    ("position_measured", "position"),
    ("force_command", "thrust", "force"),
    ("current_a",),
    ("current_b",),
)
"""Channels that tell how a motion was, each the first that is there; positions without errors."""
_FEW = 20  # instants that say little of a motion
_GAUSS = 0.6745  # median of the absolute values of noise of standard deviation 1
_SECOND = np.sqrt(6.0)  # standard deviation of second differences of such noise
_PREFIXES = ((1.0, ""), (1e-3, "m"), (1e-6, "\N{MICRO SIGN}"), (1e-9, "n"))
_SYMBOLS = {
    "following_error": "e",
    "position_measured": "position",
    "force_command": "F",
    "thrust": "F",
}


def telling(names: Sequence[str]) -> list[str]:
    """Return the channels that tell how a motion was: errors, forces, currents; all if none do."""
    owners = list(dict.fromkeys(name.rpartition(".")[0] for name in names))
    rows = [
        [
            next((f"{owner}.{each}" for each in kinds if f"{owner}.{each}" in names), "")
            for owner in owners
        ]
        for kinds in _TELLING
    ]
    errors = any(rows[0])
    columns = [
        name for i, row in enumerate(rows) for name in row if name and not (errors and i == 1)
    ]
    return columns or list(names)


def sensible(
    own: NDArray[np.floating[Any]], other: NDArray[np.floating[Any]], count: float = 0.0
) -> Tolerance:
    """Return the tolerance of a channel: 2 % of its range, noise, a count of the encoder; 1 ms.

    Parameters
    ----------
    own, other : ndarray, shape (samples,)
        The channel of baseline and candidate.
    count : float
        What the encoder resolves, where the channel is of its unit.
    """
    noise = max(_noise(own), _noise(other))
    return Tolerance(absolute=RANGE * spread(own) + NOISE * noise + count, time=TIME)


def spread(values: NDArray[np.floating[Any]]) -> float:
    """Return the largest less the least finite value; 0 without any."""
    finite = values[np.isfinite(values)]
    return float(np.ptp(finite)) if finite.size else 0.0


def _noise(values: NDArray[np.floating[Any]]) -> float:
    """Return the standard deviation of white noise on a smooth curve."""
    second = np.diff(values.astype(np.float64), 2)
    second = second[np.isfinite(second)]
    return float(np.median(np.abs(second)) / (_GAUSS * _SECOND)) if second.size else 0.0


def verdict(comparison: Comparison) -> str:
    """Return what a comparison found, as a sentence without its full stop."""
    channels = comparison.channels
    count = f"{comparison.within} of {len(channels)}"
    if comparison.instants < _FEW:
        plural = "" if comparison.instants == 1 else "s"
        count += f", in {comparison.instants} instant{plural} only"
    if comparison.holds:
        if not any(each.largest for each in channels):
            return f"identical on {count}"
        share = max(_share(each) for each in channels)
        return f"agrees within {100 * share:.2g} % RMS on {count}"
    beyond = [each for each in channels if each.verdict == "out-of-tolerance"]
    unread = len(channels) - comparison.within - len(beyond)
    if unread == len(channels):
        reason = f": {comparison.note}" if comparison.note else ""
        return f"nothing could be compared{reason}"
    parts = [f"{unread} of {len(channels)} could not be compared"] if unread else []
    if not beyond:
        return f"incomplete: agrees on {count}, {parts[0]}"
    worst = max(beyond, key=_excess)
    letters = {each.name.partition(".")[0] for each in channels}
    by = _quantity(abs(worst.largest or 0.0), worst.unit or "1")
    sentence = f"differs: {short_name(worst.name, letters)} by {by}{_place(comparison, worst)}"
    return ", ".join(
        [sentence, f"{len(beyond)} of {len(channels)} channels beyond tolerance", *parts]
    )


def short_name(name: str, letters: Collection[str] = ()) -> str:
    """Return how a channel is called: e_y, or e_y of B among several variants."""
    match = re.fullmatch(r"([A-Z])\.([xy])\.(\w+)", name)
    if match is None:
        return name
    variant, axis, kind = match.groups()
    current = re.fullmatch(r"current_([abc])", kind)
    symbol = f"i_{current[1]} {axis}" if current else _SYMBOLS.get(kind, kind.replace("_", " "))
    text = symbol if current else f"{symbol}_{axis}" if len(symbol) == 1 else f"{symbol} {axis}"
    return f"{text} of {variant}" if len(letters) > 1 else text


def _share(channel: ChannelComparison) -> float:
    return (channel.rms or 0.0) / channel.range if channel.range else 0.0


def _excess(channel: ChannelComparison) -> float:
    allowed = max(channel.tolerance.absolute, RANGE * (channel.range or 0.0))
    return abs(channel.largest or 0.0) / allowed if allowed else np.inf


def _place(comparison: Comparison, channel: ChannelComparison) -> str:
    if channel.at is None:
        return ""
    if channel.at.arc is not None and comparison.lap_length:
        degrees = 360.0 * channel.at.arc / comparison.lap_length
        return f" at {degrees:.0f}\N{DEGREE SIGN} of lap {(channel.at.lap or 0) + 1}"
    return f" at {channel.at.time:.4g} s"


def _quantity(value: float, unit: str) -> str:
    if unit == "1":
        return f"{value:.3g}"
    size, prefix = next((each for each in _PREFIXES if value >= each[0]), _PREFIXES[-1])
    return f"{value / size:.3g} {prefix}{unit}"
