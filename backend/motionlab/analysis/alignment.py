"""Alignment of two runs: the instants at which their samples are compared."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.analysis.curve_difference import Positions, resampled
from motionlab.config.planar import AXES

Align = Literal["time", "reference", "index"]
Samples = Literal["union", "intersection"]
Reason = Literal["not-aligned", "ranges-differ"]
Array = NDArray[np.floating[Any]]

REFERENCE = tuple(f"{axis}.position_reference" for axis in AXES)
"""Channels that alignment by reference reads."""

COINCIDENT = 1e-3
"""Share of the shorter period within which two samples are at one instant."""

SAME_ARC = 1e-9
"""Difference of arc length within which two samples are at one instant, m."""

PATH_TOLERANCE = 1e-3
"""Distance of two references on one path, as a share of the path's extent; see `by_reference`."""

_ROUNDING = 2e-8  # m: positions of 0.1 m as float32, twice
_LAP_START = 0.01  # of the extent: the chord that gives the direction in which a lap begins
_LAP_WIDTH = 0.02  # of the extent: how far from its first point a lap may end
_LAP_LEAST = 0.1  # of the extent: least length of a lap
_SAME_WAY = 0.9  # cosine between the directions in which two laps begin


class Grid(NamedTuple):
    """Equidistant samples: sample k is at ``first + k period``.

    Attributes
    ----------
    first, period : float
        Time of sample 0 and between two, s.
    ticks : int
        Number of samples, missing ones included.
    """

    first: float
    period: float
    ticks: int


@dataclass(frozen=True)
class Path:
    """Course of a run along its reference.

    Attributes
    ----------
    coordinate : ndarray, shape (instants,)
        Arc length in which each lap is as long as the mean lap of the baseline, m.
    lap, arc : ndarray, shape (instants,)
        Lap, counted from 0, and arc length since its beginning, m.
    lap_length : float or None
        Mean length of the baseline's complete laps, m; None where it completes none.
    standing : float
        Share of the baseline's samples that are left out because the reference stands still.
    """

    coordinate: Array
    lap: NDArray[np.int64]
    arc: Array
    lap_length: float | None
    standing: float


class Alignment(NamedTuple):
    """Instants at which two runs are compared.

    Attributes
    ----------
    instants : int
        Their number.
    baseline, candidate : slice, or ndarray of float64, shape (instants,)
        Place of each instant among the samples of either run; whole numbers are samples.
    path : Path or None
        Where the reference is, where runs are aligned by it.
    reason : str or None
        Why there is no instant.
    note : str
        The same in words.
    """

    instants: int
    baseline: Positions = slice(0, 0)
    candidate: Positions = slice(0, 0)
    path: Path | None = None
    reason: Reason | None = None
    note: str = ""


def between(alignment: Alignment, low: float, high: float) -> Alignment:
    """Return the instants whose place among the baseline's samples is in [low, high]."""
    places, path, count = alignment.baseline, alignment.path, alignment.instants
    if isinstance(places, slice):
        ends = places.start - 1.0, float(places.stop)
        first = max(math.ceil(min(max(low, ends[0]), ends[1])) - places.start, 0)
        stop = min(math.floor(min(max(high, ends[0]), ends[1])) + 1 - places.start, count)
    else:
        first, stop = np.searchsorted(places, low), np.searchsorted(places, high, side="right")
    part = slice(int(first), max(int(first), int(stop)))
    if path is not None:
        path = replace(
            path, coordinate=path.coordinate[part], lap=path.lap[part], arc=path.arc[part]
        )
    own, other = (_part(side, part) for side in (places, alignment.candidate))
    return alignment._replace(
        instants=part.stop - part.start, baseline=own, candidate=other, path=path
    )


def by_index(baseline: Grid, candidate: Grid) -> Alignment:
    """Align sample k of one run with sample k of the other, as far as both go."""
    count = min(baseline.ticks, candidate.ticks)
    if count == 0:
        return _none("ranges-differ", "a run has no samples")
    return Alignment(count, slice(0, count), slice(0, count))


def by_time(baseline: Grid, candidate: Grid, *, offset: float, samples: Samples) -> Alignment:
    """Align time t of the baseline with time t - offset of the candidate.

    Parameters
    ----------
    baseline, candidate : Grid
        Samples of the two runs.
    offset : float
        Time by which the candidate is moved, s.
    samples : str
        union: every sample of either run within the time that both recorded, first and last
        sample included; intersection: those where both have one, closer than `COINCIDENT`.
    """
    period = baseline.period
    far = 2.0 * (period * baseline.ticks + candidate.period * candidate.ticks)  # no overlap there
    shift = min(max(candidate.first + offset - baseline.first, -far), far)
    if not (baseline.ticks and candidate.ticks):
        return _none("ranges-differ", "a run has no samples")
    drift = abs(candidate.period - period) * candidate.ticks
    steps = round(shift / period)
    if drift < COINCIDENT * period and abs(shift - steps * period) < COINCIDENT * period:
        start, other = max(0, steps), max(0, -steps)
        count = min(baseline.ticks - start, candidate.ticks - other)
        if count <= 0:
            return _none("ranges-differ", "the times of the runs do not overlap")
        return Alignment(count, slice(start, start + count), slice(other, other + count))

    same = COINCIDENT * min(period, candidate.period)
    own = np.arange(baseline.ticks) * period
    others = shift + np.arange(candidate.ticks) * candidate.period
    if max(own[0], others[0]) - same > min(own[-1], others[-1]) + same:
        return _none("ranges-differ", "the times of the runs do not overlap")
    times = _merged(own, others, same, samples)
    if not times.size:
        return _none("not-aligned", "no sample of one run is at the time of one of the other")
    return Alignment(
        len(times),
        _snapped(times / period, same / period, baseline.ticks),
        _snapped((times - shift) / candidate.period, same / candidate.period, candidate.ticks),
    )


def by_reference(baseline: Array, candidate: Array, *, samples: Samples) -> Alignment:
    r"""Align two runs by where their reference is: lap and arc length along its path.

    Arc length is :math:`s_k = \sum_{i \le k} |r_i - r_{i-1}|` over the samples of the position
    reference r. A lap ends where the path passes its first point again in the direction in which
    it began. Since chords are shorter than arcs, and the shorter the slower the motion, the laps
    of both runs are scaled to the mean length L of the baseline's: an instant is a value of
    :math:`q = n L + (s - s_n) L / L_n` in lap n. A path without laps has q = s.

    Where the reference stands still, arc length orders nothing: only the last sample before it
    moves on is compared.

    Parameters
    ----------
    baseline, candidate : ndarray, shape (2, ticks)
        Position references, m; NaN where they are missing.
    samples : str
        union: every sample of either run within the arc that both recorded; intersection: those
        where both have one, closer than `SAME_ARC`.

    Returns
    -------
    Alignment
        None is aligned unless the references agree at every instant, to `PATH_TOLERANCE` of the
        extent of the path.
    """
    if baseline.shape[1] == 0 or candidate.shape[1] == 0:
        return _none("ranges-differ", "a run has no samples")
    sides = [_Course.of(reference) for reference in (baseline, candidate)]
    first, second = sides
    extent = first.extent
    if extent == 0.0 or second.extent == 0.0:
        return _none("not-aligned", "a reference does not move")
    origin, direction = first.start()
    for side in sides:
        side.find_laps(origin, direction, extent)
    length = first.lap_length
    own, others = first.coordinate(length), second.coordinate(length)
    instants = _merged(own, others, SAME_ARC, samples)
    if not instants.size:
        return _none("not-aligned", "no sample of one run is where one of the other is")
    places = [
        side.places(values, instants) for side, values in zip(sides, (own, others), strict=True)
    ]
    apart = np.hypot(
        *(
            resampled(baseline[axis], places[0], hold=False)
            - resampled(candidate[axis], places[1], hold=False)
            for axis in range(len(AXES))
        )
    )
    lap, arc = first.laps_at(own, instants)
    parted = np.flatnonzero(apart > PATH_TOLERANCE * extent + _ROUNDING)
    if parted.size:
        at = int(parted[0])
        return _none(
            "not-aligned",
            f"the references part in lap {lap[at]} at {arc[at]:.6g} m: another path",
        )
    standing = 1.0 - len(np.unique(own)) / len(own)
    path = Path(instants, lap, arc, length, standing)
    return Alignment(len(instants), places[0], places[1], path)


class _Course:
    """Arc length and laps of a reference, over its samples that are there."""

    def __init__(self, places: NDArray[np.int64], points: Array) -> None:
        self._places = places
        self._points = points
        steps = np.hypot(*np.diff(points, axis=1))
        self._arc = np.concatenate(([0.0], np.cumsum(steps)))
        self._laps = np.zeros(1)

    @classmethod
    def of(cls, reference: Array) -> _Course:
        places = np.flatnonzero(np.isfinite(reference).all(axis=0))
        if not places.size:
            return cls(np.zeros(1, dtype=np.int64), np.zeros((2, 1)))
        return cls(places, reference[:, places])

    @property
    def extent(self) -> float:
        """Diagonal of the rectangle that holds the path, m."""
        return float(np.hypot(*np.ptp(self._points, axis=1)))

    @property
    def lap_length(self) -> float | None:
        """Mean length of the complete laps, m."""
        laps = len(self._laps) - 1
        return float(self._laps[-1]) / laps if laps else None

    def start(self) -> tuple[Array, Array]:
        """Return the first point and the direction in which the path leaves it."""
        away = self._points - self._points[:, :1]
        far = int(np.argmax(np.hypot(*away) >= _LAP_START * self.extent))
        return self._points[:, 0], away[:, far] / np.hypot(*away[:, far])

    def find_laps(self, origin: Array, direction: Array, extent: float) -> None:
        """Find where the path passes a point in a direction."""
        away = self._points - origin[:, np.newaxis]
        along = direction @ away
        across = np.abs(direction[0] * away[1] - direction[1] * away[0])
        step = np.diff(self._arc)
        here = np.flatnonzero(
            (along[:-1] < 0.0)
            & (along[1:] >= 0.0)
            & (across[1:] <= _LAP_WIDTH * extent)
            & (np.diff(along) >= _SAME_WAY * step)
        )
        share = -along[here] / (along[here + 1] - along[here])
        laps = [0.0]
        for arc in self._arc[here] + share * step[here]:
            if arc - laps[-1] >= _LAP_LEAST * extent:
                laps.append(float(arc))
        self._laps = np.array(laps)

    def coordinate(self, length: float | None) -> Array:
        """Return q at each sample for the baseline's lap length, m."""
        own = self.lap_length
        if length is None or own is None:
            return self._arc
        lap = np.searchsorted(self._laps, self._arc, side="right") - 1
        lengths = np.append(np.diff(self._laps), own)
        return lap * length + (self._arc - self._laps[lap]) * (length / lengths)[lap]

    def laps_at(self, coordinate: Array, instants: Array) -> tuple[NDArray[np.int64], Array]:
        """Return lap and arc length in the lap at some values of q, m."""
        arc = np.interp(instants, coordinate, self._arc)
        lap = np.searchsorted(self._laps, arc + SAME_ARC, side="right") - 1
        return lap, np.maximum(arc - self._laps[lap], 0.0)

    def places(self, coordinate: Array, instants: Array) -> Array:
        """Return the samples at which q takes some values; the last of several at one value."""
        last = len(coordinate) - 1
        before = np.searchsorted(coordinate, instants + SAME_ARC, side="right") - 1
        before = np.clip(before, 0, last)
        after = np.minimum(before + 1, last)
        step = coordinate[after] - coordinate[before]
        ahead = instants - coordinate[before]
        share = np.divide(ahead, step, out=np.zeros_like(ahead), where=step > 0.0)
        share[ahead <= SAME_ARC] = 0.0
        share = np.clip(share, 0.0, 1.0)
        first, second = (self._places[at].astype(np.float64) for at in (before, after))
        return first + share * (second - first)


def _merged(own: Array, others: Array, same: float, samples: Samples) -> Array:
    """Return the values of either sequence where both go, or those in both, in order."""
    start, stop = max(own[0], others[0]) - same, min(own[-1], others[-1]) + same
    own, others = (np.unique(side[(side >= start) & (side <= stop)]) for side in (own, others))
    if samples == "union":
        every = np.sort(np.concatenate((own, others)))
        return every[np.diff(every, prepend=-np.inf) > same]
    if not others.size:
        return others
    after = np.searchsorted(others, own)
    before, after = np.maximum(after - 1, 0), np.minimum(after, len(others) - 1)
    nearest = np.minimum(np.abs(own - others[before]), np.abs(own - others[after]))
    return own[nearest <= same]


def _part(places: Positions, part: slice) -> Positions:
    if isinstance(places, slice):
        return slice(places.start + part.start, places.start + part.stop)
    return places[part]


def _snapped(places: Array, same: float, ticks: int) -> Array:
    """Return places among samples, those next to a sample put on it."""
    whole = np.rint(places)
    return np.clip(np.where(np.abs(places - whole) <= same, whole, places), 0.0, ticks - 1.0)


def _none(reason: Reason, note: str) -> Alignment:
    return Alignment(0, reason=reason, note=note)
