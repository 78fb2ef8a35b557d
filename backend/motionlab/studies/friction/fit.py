"""Least squares of a friction model over the windows of a record, and its held-out errors.

    f + theta df/dt = M a + friction + f_0

Every term has passed the filter of `motionlab.studies.identify.record.motion`. Shape numbers are
found by Levenberg and Marquardt's method in their logarithms; the linear numbers, theta, M and f_0
among them, follow from each set of shape numbers.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from motionlab.errors import ExperimentFailed
from motionlab.lanes import WIDTH
from motionlab.studies.friction.candidates import Candidate, Path
from motionlab.studies.friction.units import Machine
from motionlab.studies.identify.fit import scatter, student
from motionlab.studies.identify.record.motion import Motion, filtered_twice

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

BLOCKS, FOLDS = 40, 5
"""Stretches of the record in whose errors models are compared, and how many in turn are held out
together."""

HIDDEN = 5e-6
"""Displacement that the filter may hide at a reversal, m."""

_MAY_BE_ZERO = frozenset({"f_0", "lag"})
_AT_ALL = 10.0
"""Half of an interval, as a share of any other value, beyond which its figure says nothing."""

_STEP = 0.02  # of a logarithm, for slopes
_ROUNDS, _AGAIN = 20, 2
"""Most steps of a fit, and steps of a fit without a fold, which begins at that of all."""
_FARTHEST = 1.5  # of a step
_SETTLED = 1e-4  # change of the sum of squares that ends it, 1
_ROUGH, _STARTS = 3, 2
"""Steps from each start, and the searches that go on."""
_TRIED = 5
"""Starts of a model without a decisive number from which a search steps."""
_TINY, _STIFFEST = 1e-30, 1e7
_FAINT = 1e-9  # of the largest column; a fainter one gets nothing
_NEIGHBOURS = 41
"""Windows over which what noise makes of the force is averaged."""


@dataclass(frozen=True)
class Windows:
    """A record in its windows.

    Attributes
    ----------
    motion : Motion
        Filter and windows.
    path : Path
        What friction follows.
    used : ndarray of int
        Windows that count.
    weight : ndarray, shape (m,)
        By which all rows are multiplied; its mean square is 1.
    target : ndarray, shape (m,)
        Force, N.
    common : ndarray, shape (m, k)
        Columns of every model.
    names : tuple of str
        Of these: M, where it is sought, f_0, lag, and what lies within a sample.
    velocity : float
        Largest velocity but for outliers, m/s.
    machine : Machine
        Units of what is counted in m and N here.
    """

    motion: Motion
    path: Path
    used: NDArray[np.intp]
    weight: Array
    target: Array
    common: Array
    names: tuple[str, ...]
    velocity: float
    machine: Machine

    @property
    def block(self) -> NDArray[np.intp]:
        """Block of each window."""
        return np.arange(len(self.target)) * BLOCKS // len(self.target)

    def table(self, candidate: Candidate, shapes: Array) -> Array:
        """Return all columns for sets of shape numbers, (sets, m, k)."""
        forces = candidate.forces(self.path, shapes)
        own = np.array([[self.seen(force) for force in each] for each in forces])
        common = np.broadcast_to(self.common, (len(own), *self.common.shape))
        return np.concatenate([own.transpose(0, 2, 1), common], axis=2)

    def seen(self, values: Array) -> Array:
        """Return samples as the windows have them: filtered, and weighted."""
        return self.weight * self.motion.of(values, 0)[self.used]

    def weighted(self, fitted: Fit) -> Windows:
        """Return the windows weighed by what the noise of the position leaves of a fit.

        The noise that the position has is added to it once more. What that changes of the force,
        RMS over neighbours, beside what the fit leaves without it is the scatter of a window:
        about small motions a stiff bristle makes forces of the noise.
        """
        motion, rng = self.motion, np.random.default_rng(0)
        noisy = motion.position + motion.noise * rng.standard_normal(len(motion.position))
        path = self.path._replace(
            position=filtered_twice(noisy, motion.inner, 0),
            velocity=filtered_twice(noisy, motion.inner, 1),
        )
        shapes, count = np.exp(fitted.shape)[None], len(fitted.candidate.linear)
        (noisy_forces,), (forces,) = (
            fitted.candidate.forces(each, shapes) for each in (path, self.path)
        )
        changed = np.subtract(noisy_forces, forces)
        force = motion.of(fitted.linear[:count] @ changed, 0)[self.used]
        made = uniform_filter1d(force**2, _NEIGHBOURS, mode="nearest")
        rest = (fitted.rest / self.weight) ** 2
        left = float(np.mean(rest[made <= np.median(made)]))
        weight = 1.0 / np.sqrt(max(left, _TINY) + made)
        weight /= np.sqrt(np.mean(weight**2))
        change = weight / self.weight
        return replace(
            self,
            weight=weight,
            target=change * self.target,
            common=change[:, None] * self.common,
        )


class Fit(NamedTuple):
    """A model fitted to some windows.

    Attributes
    ----------
    candidate : Candidate
        The model.
    shape : ndarray, shape (s,)
        Logarithms of its shape numbers.
    linear : ndarray, shape (k,)
        Its linear numbers, and the common ones.
    rest : ndarray, shape (m,)
        Force less that of the model in all windows, N.
    jacobian : ndarray, shape (m, k + s)
        Slopes of the model's force by all numbers.
    """

    candidate: Candidate
    shape: Array
    linear: Array
    rest: Array
    jacobian: Array


def _solved(table: Array, target: Array, rows: Mask, whole: bool) -> Array:
    """Return the linear numbers; that of a column which is a force itself is 1."""
    if whole:
        others = _solved(table[:, 1:], target - table[:, 0], rows, whole=False)
        return np.append(1.0, others)
    chosen = table[rows]
    length = np.linalg.norm(chosen, axis=0)
    length = np.maximum(length, _FAINT * length.max())
    gram = (chosen / length).T @ (chosen / length)
    gram[np.diag_indices_from(gram)] += 1e-11
    return np.linalg.solve(gram, (chosen / length).T @ target[rows]) / length


def ends_of(windows: Windows, candidate: Candidate) -> tuple[Array, Array]:
    """Return the ends of the range of the shape numbers' logarithms."""
    scale = _scales(windows, candidate)
    low, high = np.array([(shape.low, shape.high) for shape in candidate.shapes]).T
    return np.log(low * scale), np.log(high * scale)


def _scales(windows: Windows, candidate: Candidate) -> Array:
    scales = {"velocity": windows.velocity, "length": 1.0, "one": 1.0}
    return np.array([scales[shape.scale] for shape in candidate.shapes])


class _Search:
    """Least squares over some windows."""

    def __init__(self, windows: Windows, candidate: Candidate, rows: Mask) -> None:
        self.windows, self.candidate, self.rows = windows, candidate, rows
        self.ends = ends_of(windows, candidate)

    def rests(self, shapes: Array) -> tuple[Array, Array, Array]:
        """Return tables, linear numbers and rests of sets of shape numbers."""
        tables = self.windows.table(self.candidate, np.exp(shapes))
        target, whole = self.windows.target, self.candidate.whole
        linear = np.stack([_solved(table, target, self.rows, whole) for table in tables])
        rests = np.stack([target - t @ x for t, x in zip(tables, linear, strict=True)])
        return tables, linear, rests

    def fit(self, shape: Array, rounds: int) -> Fit:
        """Search from a start."""
        count, damping = len(shape), 1e-3
        low, high = self.ends
        steps = np.concatenate([np.zeros((1, count)), _STEP * np.eye(count)])
        shape = np.clip(shape, low, high - _STEP)
        tables, linear, rests = self.rests(shape + steps)
        before = self._sum(rests[0])
        for _ in range(rounds):
            slopes = np.nan_to_num((rests[1:] - rests[0])[:, self.rows].T / _STEP)
            gram, gradient = slopes.T @ slopes, slopes.T @ rests[0][self.rows]
            size = np.diag(np.maximum(np.diag(gram), 1e-9 * max(before, _TINY)))
            after, tried = np.inf, shape
            while damping < _STIFFEST:
                step = np.linalg.solve(gram + damping * size, -gradient)
                tried = np.clip(shape + np.clip(step, -_FARTHEST, _FARTHEST), low, high - _STEP)
                (after,) = self.squares(tried[None])
                if after <= before:
                    break
                damping *= 10.0
            if after > before:
                break
            damping = max(damping / 10.0, 1e-6)
            gain, shape, before = before - after, tried, after
            tables, linear, rests = self.rests(shape + steps)
            if gain <= _SETTLED * before:
                break
        curves = [(table - tables[0]) @ linear[0] / _STEP for table in tables[1:]]
        jacobian = np.concatenate([tables[0], np.array(curves).T], axis=1)
        return Fit(self.candidate, shape, linear[0], rests[0], jacobian)

    def squares(self, shapes: Array) -> list[float]:
        """Return sums of squares; infinite where shape numbers do not go together."""
        refused = map(self.candidate.refused, np.exp(shapes))
        rests = self.rests(shapes)[2]
        return [np.inf if no else self._sum(r) for no, r in zip(refused, rests, strict=True)]

    def _sum(self, rest: Array) -> float:
        total = float(np.sum(rest[self.rows] ** 2))
        return total if np.isfinite(total) else np.inf


def fit(windows: Windows, candidate: Candidate, like: Fit | None = None) -> Fit:
    """Fit a model to the whole record.

    Parameters
    ----------
    windows : Windows
        The record.
    candidate : Candidate
        The model.
    like : Fit, optional
        Of a simpler model, at whose shape numbers the search begins too.
    """
    search = _Search(windows, candidate, np.ones(len(windows.target), dtype=bool))
    starts = _starts(windows, candidate, like)
    groups = [starts[k : k + WIDTH] for k in range(0, len(starts), WIDTH)]
    squares = [square for group in groups for square in search.squares(group)]
    best = _best(candidate, starts, squares)
    if not np.isfinite([squares[k] for k in best]).any():
        raise ExperimentFailed(f"{candidate.label} gives no finite force along this motion")
    rough = [search.fit(starts[k], _ROUGH) for k in best if np.isfinite(squares[k])]
    rough.sort(key=_sum_of_squares)
    fits = [search.fit(each.shape, _ROUNDS) for each in rough[:_STARTS]]
    return min(fits, key=_sum_of_squares)


def _starts(windows: Windows, candidate: Candidate, like: Fit | None) -> Array:
    """Return logarithms of shape numbers, (sets, shapes)."""
    if candidate.starts is not None:
        return np.log(candidate.starts)
    scale = _scales(windows, candidate)
    known = {} if like is None else dict(zip(_names(like.candidate), like.shape, strict=True))
    lists = []
    for shape, unit in zip(candidate.shapes, scale, strict=True):
        starts = [float(np.log(start * unit)) for start in shape.starts]
        lists.append([known[shape.name]] if shape.name in known else starts)
    return np.array([*itertools.product(*lists)])


def _best(candidate: Candidate, starts: Array, squares: list[float]) -> list[int]:
    """Return the starts that are worth a few steps, best first."""
    order = sorted(range(len(starts)), key=lambda k: squares[k])
    if candidate.starts is not None:
        return order[:_TRIED]
    # The best of each Stribeck velocity: sums of squares have several minima along it.
    names = _names(candidate)
    decisive = names.index("v_s") if "v_s" in names else 0
    best: dict[float, int] = {}
    for k in order:
        best.setdefault(starts[k][decisive], k)
    return [*best.values()]


def _sum_of_squares(fitted: Fit) -> float:
    return float(fitted.rest @ fitted.rest)


def held_out(windows: Windows, fitted: Fit) -> Array:
    """Return the force error of each window by the model fitted without its fold, N, (m,)."""
    fold = windows.block % FOLDS
    errors = np.empty(len(windows.target))
    for k in range(FOLDS):
        rows = fold != k
        without = _Search(windows, fitted.candidate, rows).fit(fitted.shape, _AGAIN)
        errors[~rows] = without.rest[~rows]
    return errors


def _names(candidate: Candidate) -> list[str]:
    return [shape.name for shape in candidate.shapes]


def windows_of(
    motion: Motion, normal: Array | None, mass: float | None, machine: Machine
) -> Windows:
    """Return the windows of a filtered motion for the fits.

    Left out are those about a reversal so fast that the filter hides the displacement.

    Parameters
    ----------
    motion : Motion
        From `motionlab.studies.identify.record.motion`.
    normal : ndarray, shape (n,), or None
        Normal force at the samples, N.
    mass : float or None
        Moving mass, kg; None where it is sought.
    machine : Machine
        Units of the record.
    """
    chosen = np.flatnonzero(motion.sliding | (motion.hidden <= HIDDEN))
    acceleration = motion.of(motion.position, 2)[chosen]
    target = motion.of(motion.force, 0)[chosen]
    columns = {"f_0": np.ones(len(chosen)), "lag": -motion.of(motion.force, 1)[chosen]}
    if mass is None:
        columns["M"] = acceleration
    else:
        target = target - mass * acceleration
    if motion.within is not None:
        columns["within"] = -motion.of(motion.within, 0)[chosen]
    speed = np.abs(motion.of(motion.position, 1)[chosen])
    return Windows(
        motion=motion,
        path=Path(motion.path, motion.velocity, motion.lost, motion.period, normal),
        used=chosen,
        weight=np.ones(len(chosen)),
        target=target,
        common=np.stack([*columns.values()], axis=1),
        names=tuple(columns),
        velocity=float(np.quantile(speed, 0.99)),
        machine=machine,
    )


def rest_at(windows: Windows, candidate: Candidate, shape: Array) -> tuple[Array, Array, Array]:
    """Return table, linear numbers and rest at the logarithms of shape numbers."""
    search = _Search(windows, candidate, np.ones(len(windows.target), dtype=bool))
    tables, linear, rests = search.rests(shape[None])
    return tables[0], linear[0], rests[0]


class Estimate(NamedTuple):
    """A number and half of its 95 % interval; infinite where it is not determined."""

    value: float
    half: float


def parameters_of(windows: Windows, fitted: Fit) -> dict[str, Estimate]:
    """Return the parameters of a model, M, f_0 and the lag among them, with intervals.

    The covariance is the jackknife's over blocks of the record, `motionlab.studies.identify.fit`.
    """
    candidate = fitted.candidate
    first = int(candidate.whole)  # no number goes with a column that is a force itself
    names = [*candidate.linear[first:], *windows.names, *_names(candidate)]
    numbers = np.append(fitted.linear[first:], fitted.shape)
    count = len(fitted.linear) - first

    def named(of: Array) -> dict[str, float]:
        plain = dict(zip(names, [*of[:count], *np.exp(of[count:])], strict=True))
        more = {name: plain[name] for name in windows.names if name != "within"}
        return candidate.parameters(plain) | more

    spread = scatter(fitted.jacobian[:, first:], fitted.rest, windows.block)
    known = np.where(np.isfinite(spread.errors), spread.errors, 0.0)
    covariance = spread.correlation * np.outer(known, known)
    values = named(numbers)
    slopes = np.empty((len(values), len(numbers)))
    for k, number in enumerate(numbers):
        step = np.zeros(len(numbers))
        step[k] = 1e-6 * max(abs(number), 1.0)
        ends = [np.array([*named(numbers + sign * step).values()]) for sign in (1.0, -1.0)]
        slopes[:, k] = (ends[0] - ends[1]) / (2.0 * step[k])
    low, high = ends_of(windows, candidate)
    edge = np.zeros(len(numbers), dtype=bool)
    edge[count:] = (fitted.shape <= low + _STEP) | (fitted.shape >= high - 2.0 * _STEP)
    estimates = {}
    for (name, value), slope in zip(values.items(), slopes, strict=True):
        on = slope != 0.0
        half = np.inf
        if np.isfinite(spread.errors[on]).all() and not edge[on].any():
            parts = np.abs(slope[on] * known[on])
            degrees = spread.degrees[on][int(np.argmax(parts))]
            variance = float(slope[on] @ covariance[np.ix_(on, on)] @ slope[on])
            half = float(student(degrees)) * float(np.sqrt(max(variance, 0.0)))
        if name not in _MAY_BE_ZERO | candidate.may_be_zero and half > _AT_ALL * abs(value):
            half = np.inf
        estimates[name] = Estimate(float(value), half)
    return estimates
