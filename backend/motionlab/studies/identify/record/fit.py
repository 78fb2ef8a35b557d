"""Fit of the friction model to the forces of a recorded motion.

    f(t - lag) = M a + sigma_0 z + sigma_1 dz/dt + sigma_2 v + f_0

Every term passes through the same filter. Windows of sliding give F_c, F_s, v_s, sigma_2, f_0, M
and the lag, windows about reversals sigma_0 and sigma_1. Each group takes the other's estimates as
known, in turn, so that a bristle model that does not fit cannot spoil the sliding friction; what is
unsure of one widens the intervals of the other.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from motionlab.config.controller import AxisModelConfig
from motionlab.errors import ExperimentFailed
from motionlab.plant.friction import LuGre
from motionlab.studies.identify.fit import (
    Fitted,
    about_speeds,
    correlation_of,
    doubts,
    first_guesses,
    scatter,
    student,
)
from motionlab.studies.identify.presliding import bristle
from motionlab.studies.identify.record.motion import Motion, Motions

Array = NDArray[np.float64]


Mask = NDArray[np.bool_]
Values = dict[str, float]

SLIDING = ("F_c", "F_s", "v_s", "sigma_2", "f_0")
PRESLIDING = ("sigma_0", "sigma_1")

WITHIN = "within"
"""The share of `Record.within`."""

_BOUNDS = {
    "F_c": (1e-6, np.inf),
    "F_s": (1e-6, np.inf),
    "v_s": (1.01e-5, 10.0),
    "sigma_2": (0.0, np.inf),
    "f_0": (-np.inf, np.inf),
    "M": (1e-3, 1e4),
    "sigma_0": (1.0, 1e10),
    "sigma_1": (0.0, 1e7),
    WITHIN: (-np.inf, np.inf),
}
_SIZES = {"F_c": 1.0, "F_s": 1.0, "v_s": 0.02, "sigma_2": 10.0, "f_0": 0.1, WITHIN: 1.0}
_ROUNDS = 2
_STARTS = 3
"""Stribeck velocities from which the search begins."""

_LEAST_MASS = 0.01
"""Mass at the beginning, as a share of the old model's, at least."""

_BLOCKS = 40
_FEWEST_BLOCKS = 8
_BLOCK_WINDOWS = 20
"""Windows of a block, at least: ten lengths of the filter."""

_FEWEST_PRESLIDING = 40
"""Windows about reversals that sigma_0 and sigma_1 need."""

_RESOLVED = 0.1
"""Displacement that the filter may hide, as a share of F_s/sigma_0."""

_HIDDEN = 0.5
"""Share of the displacement that the filter hides by which the place of a reversal may be off."""

_UNTOLD = 0.5
"""Half of an interval, as a share of the value, beyond which nothing was learnt."""

_AT_ALL = 10.0
"""The same, beyond which its figure says nothing."""

_BELIEVED = 0.5
"""Share by which sigma_0 of the old model may be off where the record does not tell it."""

_SINGULAR = 1e16
"""Largest condition number that is returned."""

_NO_LAG = "they would depend on a lag between position and force that is not found"
_PULL = 3.0
"""Standard deviations by which residuals ask for more lag than there may be."""

_ONE_WAY = 0.01
"""Least share of the windows that a direction needs."""


@dataclass(frozen=True)
class RecordFit:
    """Fit of a record.

    Attributes
    ----------
    sliding : Fitted
        F_c, F_s, v_s, sigma_2, f_0.
    presliding : Fitted or None
        sigma_0 and sigma_1; None where the record does not tell them.
    further : Fitted
        M, unless it was given, and the lag, s.
    values : dict of str to float
        Every parameter.
    residuals : ndarray, shape (windows of sliding,)
        Measured force less that of the fit, N.
    condition : float
        Condition number of the Jacobian with columns of unit length, 1.
    warnings : list of str
        What could not be told, and why.
    """

    sliding: Fitted
    presliding: Fitted | None
    further: Fitted
    values: Values
    residuals: Array
    condition: float
    warnings: list[str]


@dataclass(frozen=True)
class _Solved:
    """Least squares over some of the windows."""

    names: tuple[str, ...]
    chosen: Mask
    values: Array
    residuals: Array
    jacobian: Array
    edge: list[str]


class _Regression:
    """The equation of motion of a record."""

    def __init__(self, motion: Motion, values: Values) -> None:
        self.motion, self.values = motion, values
        self._measured = motion.of(motion.force, 0)
        self._within = None if motion.within is None else motion.of(motion.within, 0)
        # A derivative changes one parameter at a time: most of the force is as it was.
        self._moved = lru_cache(maxsize=4)(self._of_motion)
        self._bent = lru_cache(maxsize=4)(self._of_bristle)
        values.setdefault(WITHIN, 0.0)

    def residuals(self, chosen: Mask) -> Array:
        """Return the force of the model less the measured one, N, in the windows chosen."""
        v = self.values
        acceleration, velocity = self._moved(v["lag"])
        z, rate = self._bent(v["lag"], v["F_c"], v["F_s"], v["v_s"], v["sigma_0"])
        force = v["M"] * acceleration + v["sigma_2"] * velocity + v["f_0"]
        force += v["sigma_0"] * z + v["sigma_1"] * rate
        if self._within is not None:
            force -= v[WITHIN] * self._within
        return (force - self._measured)[chosen]

    def _of_motion(self, lag: float) -> tuple[Array, Array]:
        """Return acceleration and velocity in the windows."""
        motion = self.motion
        return motion.of(motion.position, 2, lag), motion.of(motion.position, 1, lag)

    def _of_bristle(
        self, lag: float, F_c: float, F_s: float, v_s: float, sigma_0: float
    ) -> tuple[Array, Array]:
        """Return the bristle state and its rate in the windows."""
        motion = self.motion
        shape = {"F_c": F_c, "F_s": F_s, "v_s": v_s, "sigma_0": sigma_0}
        friction = LuGre(*(shape.get(name, 0.0) for name in LuGre._fields))
        z = bristle(motion.path, motion.velocity, motion.lost, friction)
        return motion.of(z, 0, lag), motion.of(z, 1, lag)

    def solve(self, names: tuple[str, ...], chosen: Mask) -> _Solved:
        """Minimise the squared residuals of the windows chosen; keep the values found."""
        from scipy.optimize import least_squares

        bounds = _BOUNDS | {"lag": (-self.motion.lag_max, self.motion.lag_max)}
        sizes = _SIZES | {"lag": self.motion.period}
        size = np.array([sizes.get(name, self.values[name]) for name in names])
        low, high = (np.array([bounds[name][end] for name in names]) for end in (0, 1))

        def residuals(q: Array) -> Array:
            self.values |= zip(names, (q * size).tolist(), strict=True)
            return self.residuals(chosen)

        start = np.clip([self.values[name] for name in names], low, high) / size
        solution = least_squares(residuals, start, bounds=(low / size, high / size), x_scale="jac")
        residuals(solution.x)
        edge = [n for n, at in zip(names, solution.active_mask, strict=True) if at]
        return _Solved(names, chosen, solution.x * size, solution.fun, solution.jac / size, edge)

    def best(self, names: tuple[str, ...], chosen: Mask, starts: Sequence[Values]) -> _Solved:
        """Minimise from several starts; keep the values of the least sum."""
        least: tuple[_Solved, Values] | None = None
        for start in starts:
            self.values |= start
            solved = self.solve(names, chosen)
            if least is None or _squares(solved) < _squares(least[0]):
                least = solved, dict(self.values)
        assert least is not None
        self.values |= least[1]
        return least[0]

    def moved(self, solved: _Solved, others: tuple[str, ...]) -> Array:
        """Return by how much estimates move with other parameters, shape (names, others)."""
        values, slopes = dict(self.values), []
        for name in others:
            step = 1e-4 * max(abs(values[name]), _SIZES.get(name, 0.0))
            ends = []
            for sign in (1.0, -1.0):
                self.values[name] = values[name] + sign * step
                ends.append(self.residuals(solved.chosen))
            slopes.append((ends[0] - ends[1]) / (2.0 * step))
            self.values[name] = values[name]
        length = _lengths(solved.jacobian)
        shift = np.linalg.lstsq(solved.jacobian / length, np.transpose(slopes), rcond=1e-9)[0]
        return -shift / length[:, None]


def fit_record(
    motions: Motions,
    model: AxisModelConfig,
    *,
    find_mass: bool = True,
    start: Values | None = None,
    progress: Callable[[float], None] = lambda _: None,
) -> RecordFit:
    """Fit LuGre friction to a record.

    Parameters
    ----------
    motions : Motions
        From `motionlab.studies.identify.record.motion.motions_of`.
    model : AxisModelConfig
        The old one: mass, and bristle where the record does not tell it.
    find_mass : bool
        Whether the mass is found too.
    start : dict of str to float, optional
        Where the search begins: `RecordFit.values` of another fit.
    progress : callable
        Takes the share done.

    Raises
    ------
    ExperimentFailed
        If the record is too short.
    """
    motion, near = motions
    sliding = motion.sliding
    least = _FEWEST_BLOCKS * _BLOCK_WINDOWS
    if int(sliding.sum()) < least:
        seconds = motion.step * motion.period
        raise ExperimentFailed(
            f"the record is too short: {sliding.sum() * seconds:.2g} s of sliding, "
            f"{least * seconds:.2g} s are needed with this filter"
        )
    regression = _Regression(motion, dict(start or {}))
    velocity = motion.of(motion.position, 1)[sliding]
    both = min(float((velocity > 0).mean()), float((velocity < 0).mean())) >= _ONE_WAY
    known = SLIDING if both else SLIDING[:4]
    names = (*known, *(("M",) if find_mass else ()), "lag", "sigma_1")
    names += () if motion.within is None else (WITHIN,)
    warnings = [] if both else [_one_way(velocity)]
    starts = [start] if start else _starts(motion, model, find_mass=find_mass)
    solved = regression.best(names, sliding, starts)
    turning = _Regression(near, regression.values)
    about, why = _about_reversals(near, regression.values)
    presliding: Fitted | None = None
    unsure = _BELIEVED * model.friction.sigma_0
    for each in range(_ROUNDS if why is None else 0):
        progress((each + 0.5) / (_ROUNDS + 0.5))
        outside = {name: regression.values[name] for name in ("lag", "sigma_1")}
        turned = turning.solve((*PRESLIDING, "lag"), about)
        presliding = _fitted(turned, PRESLIDING)
        if each == _ROUNDS - 1:
            rest = _fitted(solved, known)
            presliding = _widened(presliding, rest, turning.moved(turned, known)[:2])
            hidden = _HIDDEN * float(np.median(near.hidden[about]))
            share = hidden * presliding["sigma_0"] / regression.values["F_s"]
            presliding = _doubted(presliding, share * presliding.values)
            unsure = float(presliding.half_width[0])
            why = _NO_LAG if _lag_is_beyond(turned) else _untold(presliding)
        regression.values |= outside
        solved = regression.solve(names, sliding)
    if why is not None:
        warnings.append(f"sigma_0 and sigma_1 cannot be identified from this record: {why}")
        if presliding is not None:
            presliding, unsure = None, _BELIEVED * model.friction.sigma_0
            regression.values["sigma_0"] = model.friction.sigma_0
            solved = regression.solve(names, sliding)
    moves = regression.moved(solved, ("sigma_0",))
    estimates = []
    for part in (known, tuple(n for n in names if n in {"M", "lag"})):
        at = _places(solved, part)
        estimates.append(_doubted(_fitted(solved, part), unsure * moves[at, 0]))
    slides = estimates[0] if both else _without_offset(estimates[0])
    if why == _NO_LAG:
        warnings.append(
            f"position and force are further apart than the {motion.lag_max * 1e3:.3g} ms that a "
            "lag is sought in: shift one of them, or let the same filter pass both"
        )
    told_of = about_speeds(slides, np.abs(velocity))
    return RecordFit(
        sliding=replace(slides, warnings=told_of + slides.warnings),
        presliding=presliding,
        further=estimates[1],
        values=dict(regression.values),
        residuals=-solved.residuals,
        condition=_condition(solved.jacobian),
        warnings=warnings,
    )


def _starts(motion: Motion, model: AxisModelConfig, *, find_mass: bool) -> list[Values]:
    """Return the starts of the search: the best Stribeck velocities of static friction.

    At a Stribeck velocity all other parameters, the mass among them, are linear. Starting from the
    old model's mass would end beside the truth where the mass is unlike it.
    """
    chosen, believed = motion.sliding, model.friction
    velocity, force = motion.of(motion.position, 1)[chosen], motion.of(motion.force, 0)[chosen]
    push = motion.of(motion.position, 2)[chosen]
    one_way = bool((velocity > 0).all() or (velocity < 0).all())
    starts = []
    for guess in first_guesses(
        velocity, force if find_mass else force - model.mass * push, push if find_mass else None
    )[:_STARTS]:
        F_c, F_s, v_s, sigma_2, f_0, M = guess.tolist()
        starts.append(
            {
                "F_c": max(F_c, 1e-3),
                "F_s": max(F_s, 1e-3),
                "v_s": v_s,
                "sigma_2": max(sigma_2, 0.0),
                "f_0": 0.0 if one_way else f_0,
                "M": max(M, _LEAST_MASS * model.mass) if find_mass else model.mass,
                "lag": 0.0,
                "sigma_0": believed.sigma_0,
                "sigma_1": believed.sigma_1,
                WITHIN: 0.0,
            }
        )
    return starts


def _squares(solved: _Solved) -> float:
    return float(solved.residuals @ solved.residuals)


def _about_reversals(motion: Motion, values: Values) -> tuple[Mask, str | None]:
    """Return the windows about reversals that the filter resolves, or why there are too few."""
    distance = values["F_s"] / values["sigma_0"]
    about = ~motion.sliding
    slow = about & (motion.hidden <= _RESOLVED * distance)
    if int(slow.sum()) >= _FEWEST_PRESLIDING:
        return slow, None
    if int(about.sum()) < _FEWEST_PRESLIDING:
        return slow, f"it has too few reversals, {motion.reversals}"
    hidden = float(np.median(motion.hidden[about]))
    return slow, (
        f"its reversals are too fast for its rate or noise: within {motion.inner.half * 1e3:.3g} "
        f"ms of one, which the filter hides, the axis moves {hidden * 1e6:.2g} um, and the old "
        f"model's bristles bend {distance * 1e6:.2g} um"
    )


def _untold(presliding: Fitted) -> str | None:
    """Return why sigma_0 and sigma_1 are not told, if so."""
    for name, value, half in zip(
        presliding.names, presliding.values, presliding.half_width, strict=True
    ):
        if not half <= _UNTOLD * abs(value):
            if not half < _AT_ALL * abs(value):
                return f"{name} would not be known at all"
            return f"{name} would only be known to +-{100 * half / max(value, 1e-9):.0f} %"
    return None


def _one_way(velocity: Array) -> str:
    way = "v > 0" if float(np.median(velocity)) > 0.0 else "v < 0"
    return (
        f"it moves one way only, {way}: a constant force cannot be distinguished from Coulomb "
        "friction, and f_0 is taken for zero"
    )


def _lag_is_beyond(solved: _Solved) -> bool:
    """Return whether the windows ask for a larger lag than any that is sought."""
    if "lag" not in solved.edge:
        return False
    column = solved.jacobian[:, solved.names.index("lag")]
    size = float(np.linalg.norm(column) * np.std(solved.residuals))
    return abs(float(column @ solved.residuals)) > _PULL * size


def _condition(jacobian: Array) -> float:
    """Return the condition number with columns of unit length; finite also where it is not."""
    condition = float(np.linalg.cond(jacobian / _lengths(jacobian)))
    return condition if condition < _SINGULAR else _SINGULAR


def _lengths(jacobian: Array) -> Array:
    length = np.linalg.norm(jacobian, axis=0)
    return np.where(length > 0.0, length, 1.0)


def _places(solved: _Solved, names: tuple[str, ...]) -> list[int]:
    return [solved.names.index(name) for name in names]


def _fitted(solved: _Solved, names: tuple[str, ...]) -> Fitted:
    """Return some of the estimates, with intervals by the jackknife over blocks of the record."""
    count = len(solved.residuals)
    blocks = min(_BLOCKS, max(_FEWEST_BLOCKS, count // _BLOCK_WINDOWS))
    spread = scatter(solved.jacobian, solved.residuals, np.arange(count) * blocks // count)
    half_width = student(spread.degrees) * spread.errors
    chosen = _places(solved, names)
    both = np.ix_(chosen, chosen)
    values, half_width = solved.values[chosen], half_width[chosen]
    white = correlation_of(solved.jacobian)[both]
    edge = [name for name in solved.edge if name in names]
    return Fitted(
        names=names,
        values=values,
        errors=spread.errors[chosen],
        half_width=half_width,
        residual_rms=float(np.sqrt(np.mean(solved.residuals**2))),
        correlation=spread.correlation[both],
        warnings=doubts(names, values, half_width, white, edge, spread.degrees[chosen]),
        edge=tuple(edge),
    )


def _widened(fitted: Fitted, others: Fitted, moves: Array) -> Fitted:
    """Return estimates with what is unsure of `others` in their intervals.

    ``H = H_own + D H_others D^T`` with D of `moves` and H the half widths' products times the
    correlation.
    """
    half = np.where(np.isfinite(others.half_width), others.half_width, 0.0)
    own = np.where(np.isfinite(fitted.half_width), fitted.half_width, 0.0)
    H = fitted.correlation * np.outer(own, own)
    H = H + moves @ (others.correlation * np.outer(half, half)) @ moves.T
    wider = np.sqrt(np.diag(H))
    divisor = np.where(wider > 0.0, wider, 1.0)
    errors = np.where(np.isfinite(fitted.errors), fitted.errors, 0.0)
    errors = errors * wider / np.where(own > 0.0, own, 1.0)
    return replace(
        fitted,
        errors=np.where(np.isfinite(fitted.errors), errors, np.inf),
        half_width=np.where(np.isfinite(fitted.half_width), wider, np.inf),
        correlation=H / np.outer(divisor, divisor),
    )


def _doubted(fitted: Fitted, shifts: Array) -> Fitted:
    """Return estimates whose intervals hold a systematic error too, which shifts them so far."""
    names = ("force",)
    one = np.ones(1)
    other = Fitted(names, one, one, one, 0.0, np.ones((1, 1)), [])
    return _widened(fitted, other, shifts[:, None])


def _without_offset(sliding: Fitted) -> Fitted:
    """Return estimates of motion one way: what holds f_0 is not determined, and f_0 is zero."""
    unknown = np.array([True, True, False, False])
    half, errors = (np.where(unknown, np.inf, a) for a in (sliding.half_width, sliding.errors))
    correlation = np.zeros((5, 5))
    correlation[:4, :4] = sliding.correlation
    return replace(
        sliding,
        names=SLIDING,
        values=np.append(sliding.values, 0.0),
        errors=np.append(errors, np.inf),
        half_width=np.append(half, np.inf),
        correlation=correlation,
    )
