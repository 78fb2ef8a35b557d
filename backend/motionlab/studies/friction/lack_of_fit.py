"""What a friction model leaves of a record although it depends on something known.

The rest r of a fit is regressed, in all folds of the record but one, on the slopes J of the model
and on columns B for what it has no term for; in that one, by turns, the gain is counted::

    a = r - J p,   b = r - J q - B c,   E^2 = mean(a^2) - mean(b^2)

E is the RMS force that B explains of windows that it was not fitted to. With piecewise linear
functions h, the model's own friction F, and d the distance since the last reversal, B is

    position    h(x), F h(x)
    period      cos and sin of 2 pi k x/P, F times these, k = 1, 2; P by the largest line of a
    time        h(t), F h(t)
    velocity    sign(v) h(abs(v))
    direction   h(abs(v))
    reversal    sign(v) h(log(d))

What explains most joins J, and the others are tried again: one that only resembles it adds nothing.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.studies.friction.choose import clearly_worse, rms
from motionlab.studies.friction.fit import BLOCKS, FOLDS, Fit, Windows

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

_KNOTS = 10
_CREEP = 0.02
"""Share of the largest velocity from which knots are spaced by its logarithm."""
_SIGN = 0.005  # of the largest velocity, within which the sign of the velocity changes
_NEAREST, _FARTHEST = 1e-6, 2e-2  # of the knots about reversals, m

_HARMONICS = 2
_BINS, _FINER = 2048, 32
"""Places along the travel at which lines are sought, and lines per one that the travel holds."""
_FEWEST, _MOST = 2, 200
"""Periods in the travel."""

_FOLD_OF_BLOCK = np.concatenate(
    [np.random.default_rng(k).permutation(FOLDS) for k in range(BLOCKS // FOLDS)]
)
"""In no order: a periodic motion would be at the same places in all blocks of a fold."""

_RIDGE = 1e-6
_TINY = 1e-30

_MATTERS, _ABOUT_REVERSALS = 0.01, 0.03
"""Share of the friction from which a dependence is noted. Models of presliding differ by 2 % from
each other about reversals, and from machines."""
_TOO_MUCH = 0.05
"""Share from which a model does not describe the friction."""

_WORDS = {
    "position": "depends on the position",
    "period": "depends on the position with a period of {period}",
    "time": "changes over time",
    "velocity": "depends on the velocity",
    "direction": "differs between the directions",
    "reversal": "depends on the distance since a reversal",
}


class LackOfFit(NamedTuple):
    """What a model leaves that depends on something.

    Attributes
    ----------
    forces : dict of str to float
        RMS force by what it depends on, N, the largest first; none that does not matter.
    notes : tuple of str
        The same in sentences.
    describes : bool
        Whether the model describes the friction all the same.
    """

    forces: dict[str, float]
    notes: tuple[str, ...]
    describes: bool


def lack_of_fit(windows: Windows, fitted: Fit, friction: float) -> LackOfFit:
    """Return what a model leaves over that depends on position, time, velocity or reversals.

    Parameters
    ----------
    windows : Windows
        The record.
    fitted : Fit
        The model, fitted to all of it.
    friction : float
        RMS friction, N.
    """
    rest = _Rest(windows, fitted)
    base: Array = np.nan_to_num(fitted.jacobian)
    errors = rest.held_out(base)
    total, unit = rms(errors), windows.machine.force
    forces: dict[str, float] = {}
    notes: list[str] = []
    left = [*_WORDS]
    while left:
        trials = {name: rest.held_out(base, name) for name in left}
        name = min(left, key=lambda each: rms(trials[each]))
        if not clearly_worse(errors, trials[name], windows.block):
            break
        force = float(np.sqrt(np.mean(errors**2) - np.mean(trials[name] ** 2)))
        if force > (_ABOUT_REVERSALS if name == "reversal" else _MATTERS) * friction:
            forces[name] = force
            what = _WORDS[name]
            if name == "period":
                what = what.format(period=windows.machine.displacement(rest.period(base)))
            notes.append(
                f"what {fitted.candidate.label} leaves over {what}: "
                f"{force:.2g} of {total:.2g} {unit} RMS, for which no model has a term"
            )
        base = np.concatenate([base, rest.columns(name, base, rest.all)], axis=1)
        errors = trials[name]
        left.remove(name)
    known = float(np.sqrt(sum(force**2 for force in forces.values())))
    return LackOfFit(forces, tuple(notes), known <= _TOO_MUCH * friction)


class _Rest:
    """What a model leaves, and regressions of it."""

    def __init__(self, windows: Windows, fitted: Fit) -> None:
        self.windows, self.rest = windows, fitted.rest
        self.fold = _FOLD_OF_BLOCK[windows.block]
        self.all = np.ones(len(self.rest), dtype=bool)
        path = windows.path
        (own,) = fitted.candidate.forces(path, np.exp(fitted.shape)[None])
        force: Array = fitted.linear[: len(own)] @ np.array(own)
        self.friction = force / max(rms(force), _TINY)
        known = path.position[~path.lost]
        self.start, self.travel = float(known.min()), float(np.ptp(known))

    def held_out(self, base: Array, name: str | None = None) -> Array:
        """Return what is left in each fold by a regression on the others."""
        errors = np.empty(len(self.rest))
        for k in range(FOLDS):
            rows, table = self.fold != k, base
            if name is not None:
                table = np.concatenate([base, self.columns(name, base, rows)], axis=1)
            errors[~rows] = self._left(table, rows)[~rows]
        return errors

    def _left(self, table: Array, rows: Mask) -> Array:
        chosen = table[rows]
        length = np.maximum(np.linalg.norm(chosen, axis=0), _TINY)
        unit = chosen / length
        gram = unit.T @ unit + _RIDGE * np.eye(len(length))
        return self.rest - table @ (np.linalg.solve(gram, unit.T @ self.rest[rows]) / length)

    def columns(self, name: str, base: Array, rows: Mask) -> Array:
        """Return the columns of a dependence, (m, k)."""
        position, velocity = self.windows.path.position, self.windows.path.velocity
        fastest = self.windows.velocity
        sign = np.tanh(velocity / (_SIGN * fastest))
        speed = np.arcsinh(np.abs(velocity) / (_CREEP * fastest)) / np.arcsinh(1.0 / _CREEP)
        one = np.ones(len(position))
        match name:
            case "position":
                place = (position - self.start) / self.travel
                terms, factors = _hats(place), (one, self.friction)
            case "period":
                terms, factors = _harmonics(position / self._line(base, rows)), (one, self.friction)
            case "time":
                terms, factors = _hats(np.linspace(0.0, 1.0, len(one))), (one, self.friction)
            case "velocity":
                terms, factors = _hats(speed), (sign,)
            case "direction":
                terms, factors = _hats(speed), (one,)
            case _:
                decades = np.log(_FARTHEST / _NEAREST)
                since = _since_reversal(position, velocity)
                terms, factors = _hats(np.log1p(since / _NEAREST) / decades), (sign,)
        return self._seen(terms, factors)

    def _seen(self, terms: Iterable[Array], factors: Sequence[Array]) -> Array:
        return np.array([self.windows.seen(f * term) for term in terms for f in factors]).T

    def period(self, base: Array) -> float:
        """Return the period that explains most of what is left, m, near the largest line."""
        place, line = self.windows.path.position, self._line(base, self.all)
        factors = (np.ones(len(place)), self.friction)

        def left(period: float) -> float:
            columns = self._seen(_harmonics(place / period), factors)
            return rms(self._left(np.concatenate([base, columns], axis=1), self.all))

        width = 0.5 * line / self.travel
        for part in (1.0, 0.1):
            line = min(line * (1.0 + part * width * np.linspace(-1.0, 1.0, 21)), key=left)
        return float(line)

    def _line(self, base: Array, rows: Mask) -> float:
        windows = self.windows
        place = windows.motion.of(windows.path.position, 0)[windows.used] - self.start
        at = np.clip((_BINS * place / self.travel).astype(int), 0, _BINS - 1)
        left = np.where(rows, self._left(base, rows), 0.0)
        power = np.zeros(_BINS * _FINER // 2 + 1)
        for column in (windows.weight, windows.seen(self.friction)):
            along = np.bincount(at, column * left, minlength=_BINS)
            power += np.abs(np.fft.rfft(along, _BINS * _FINER)) ** 2 / np.sum(column**2)
        first, last = _FEWEST * _FINER, _MOST * _FINER
        return self.travel * _FINER / (first + int(np.argmax(power[first:last])))


def _hats(place: Array) -> Iterator[Array]:
    """Yield functions of a place from 0 to 1 that are 1 at one knot, linear to 0 at the next."""
    along = (_KNOTS - 1) * np.clip(place, 0.0, 1.0)
    for knot in range(_KNOTS):
        yield np.maximum(0.0, 1.0 - np.abs(along - knot))


def _harmonics(turns: Array) -> Iterator[Array]:
    for k in range(1, _HARMONICS + 1):
        yield np.cos(2.0 * np.pi * k * turns)
        yield np.sin(2.0 * np.pi * k * turns)


def _since_reversal(position: Array, velocity: Array) -> Array:
    """Return the distance since the velocity last changed its sign, m."""
    travelled = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(position)))])
    turned = np.concatenate([[True], velocity[1:] * velocity[:-1] <= 0.0])
    return travelled - np.maximum.accumulate(np.where(turned, travelled, 0.0))
