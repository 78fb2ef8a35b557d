"""Fits of the friction model to measured points, with their confidence intervals.

Residuals of one motion, there and back, are correlated, and those of slow and fast motions have
different variances. Only independence between motions is assumed: the covariance is that of the
jackknife over motions, CR3, and every parameter has its own degrees of freedom, by Satterthwaite.
See Bell and McCaffrey (2002) and Imbens and Kolesar (2016), doi 10.1162/REST_a_00552.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.plant.friction import LuGre, steady_friction, stribeck_fade
from motionlab.studies.identify.presliding import model_response
from motionlab.timing import PLANT_STEP

Array = NDArray[np.float64]


class Scatter(NamedTuple):
    """Covariance of estimates.

    Attributes
    ----------
    errors : ndarray, shape (p,)
        Standard errors; inf where the data do not determine a parameter.
    correlation : ndarray, shape (p, p)
        Of the estimates; 0 with one that is not determined.
    degrees : ndarray, shape (p,)
        Degrees of freedom of each standard error.
    """

    errors: Array
    correlation: Array
    degrees: Array


def scatter(jacobian: Array, residuals: Array, motion: NDArray[np.intp]) -> Scatter:
    """Return the covariance of least-squares estimates.

    ``C = sum u_g u_g^T, u_g = (J^T J)^-1 J_g^T (I - H_gg)^-1 e_g`` over the motions g, with the
    projection ``H = J (J^T J)^-1 J^T``.

    Parameters
    ----------
    jacobian : ndarray, shape (n, p)
        Of the residuals, at the minimum.
    residuals : ndarray, shape (n,)
        At the minimum.
    motion : ndarray of int, shape (n,)
        Motion of each residual.
    """
    length = np.linalg.norm(jacobian, axis=0)
    seen = length > 0.0
    scale = np.where(seen, length, 1.0)
    U, s, vt = np.linalg.svd(jacobian / scale, full_matrices=False)
    determined = s > np.finfo(np.float64).eps * max(jacobian.shape) * s[0]
    # A direction without effect makes every parameter that it holds undetermined.
    lost = (np.abs(vt[~determined]) > 1e-6).any(axis=0) | ~seen
    U, inverse = U[:, determined], vt[determined].T / s[determined]
    moves, scores, lengths = [], [], []
    for g in np.unique(motion):
        rows = U[motion == g]
        # (I - U_g U_g^T)^-1 U_g = U_g (I - U_g^T U_g)^-1, which is small
        part, basis = np.linalg.eigh(np.eye(rows.shape[1]) - rows.T @ rows)
        free = part > 1e-9  # a parameter that one motion alone determines leaves no residual
        left = (basis[:, free] / part[free]) @ basis[:, free].T
        weights = rows @ left @ inverse.T
        moves.append(residuals[motion == g] @ weights)
        scores.append(rows.T @ weights)
        lengths.append(np.sum(weights**2, axis=0))
    covariance = np.sum([np.outer(u, u) for u in moves], axis=0)
    spread = np.sqrt(np.diag(covariance))
    divisor = np.where(spread > 0.0, spread, 1.0)
    return Scatter(
        np.where(lost, np.inf, spread / scale),
        np.where(lost[:, None] | lost, 0.0, covariance / np.outer(divisor, divisor)),
        _degrees(np.array(scores), np.array(lengths)),
    )


def correlation_of(jacobian: Array) -> Array:
    """Return the correlation of least-squares estimates for white noise, shape (p, p)."""
    length = np.linalg.norm(jacobian, axis=0)
    unit = jacobian / np.where(length > 0.0, length, 1.0)
    inverse = np.linalg.pinv(unit.T @ unit, rcond=1e-14, hermitian=True)
    spread = np.sqrt(np.diag(inverse))
    divisor = np.where(spread > 0.0, spread, 1.0)
    return inverse / np.outer(divisor, divisor)


def _degrees(scores: Array, lengths: Array) -> Array:
    """Return ``tr(G)^2/tr(G^2)`` of each parameter, G the covariance of its parts for white noise.

    ``G = diag(w_g^T w_g) - (U_g^T w_g)^T (U_h^T w_h)``
    """
    degrees = np.ones(lengths.shape[1])
    for i, own in enumerate(lengths.T):
        score = scores[:, :, i]
        G = np.diag(own) - score @ score.T
        square = float(np.sum(G * G))
        if square > 0.0:
            degrees[i] = max(1.0, float(np.trace(G)) ** 2 / square)
    return degrees


@dataclass(frozen=True)
class Fitted:
    """Parameters that minimise the sum of squared residuals.

    Attributes
    ----------
    names : tuple of str
        Of the parameters.
    values, errors : ndarray, shape (n,)
        Estimates and standard errors; an error is inf where the data do not determine it.
    half_width : ndarray, shape (n,)
        Half of the 95 % interval, by Student's t.
    residual_rms : float
        Root mean square of the residuals.
    correlation : ndarray, shape (n, n)
        Of the estimates.
    warnings : list of str
        What is not determined.
    edge : tuple of str
        Parameters of a record at the edge of their range.
    """

    names: tuple[str, ...]
    values: Array
    errors: Array
    half_width: Array
    residual_rms: float
    correlation: Array
    warnings: list[str]
    edge: tuple[str, ...] = ()

    def __getitem__(self, name: str) -> float:
        """Return an estimate by name."""
        return float(self.values[self.names.index(name)])

    def half(self, name: str) -> float:
        """Return half of the interval of a parameter by name; inf or NaN where undetermined."""
        return float(self.half_width[self.names.index(name)])

    def determines(self, name: str) -> bool:
        """Return whether a parameter is off its edges and known to less than its own size."""
        return self.half(name) <= abs(self[name]) and name not in self.edge


def stribeck_curve(v: Array, parameters: Sequence[float] | Array) -> Array:
    """Return the force of uniform motion, N, eqs (20) to (22) with dz/dt = 0, and an offset.

    Parameters are F_c, F_s, v_s, sigma_2 and the offset.
    """
    *friction, f_0 = parameters
    return steady_friction(v, *friction) + f_0


def curve_half_width(v: Array, fitted: Fitted) -> Array | None:
    """Return half the width of the 95 % band around a fitted Stribeck curve, N.

    ``h(v)^2 = g(v)^T H g(v)`` with g the gradient of the curve by its parameters and H their
    covariance times the square of Student's t.

    Parameters
    ----------
    v : ndarray, shape (n,)
        Velocities, m/s.
    fitted : Fitted
        From `fit_sliding`.

    Returns
    -------
    ndarray, shape (n,), or None
        None where the data leave a parameter undetermined.
    """
    if not np.isfinite(fitted.half_width).all():
        return None
    F_c, F_s, v_s, _, _ = fitted.values
    falling = stribeck_fade(v, v_s)
    sign = np.sign(v)
    gradient = np.stack(
        [
            sign * (1.0 - falling),
            sign * falling,
            sign * (F_s - F_c) * falling * 2.0 * v**2 / v_s**3,
            v,
            np.ones_like(v),
        ]
    )
    H = fitted.correlation * np.outer(fitted.half_width, fitted.half_width)
    return np.sqrt(np.maximum(np.einsum("in,ij,jn->n", gradient, H, gradient), 0.0))


_CONFIDENCE = 0.95
_CORRELATED = 0.98
_UNSURE = 0.1
"""Half width of the interval, as a share of the value, from which a warning is given."""

_POWERS = (0.5, 0.75, 1.0)
_TINY = 1e-300
_FEW = 2.0
"""Degrees of freedom below which a warning says that they widen an interval."""

_CANDIDATES = 60
_SMALLEST_WAY = 1e-7  # m
_SMALLEST_FORCE = 1e-6  # N, as in the controller's model
_LOWEST_V_S, _HIGHEST_V_S = 1.01e-5, 10.0


def fit_sliding(
    velocity: Array, force: Array, *, motion: NDArray[np.intp], time: Array | None = None
) -> Fitted:
    """Fit F_c, F_s, v_s, sigma_2 and a constant offset f_0 to forces of uniform motion.

    The offset is a force of constant sign at any velocity, as of a cable or an inclined axis.

    Parameters
    ----------
    velocity, force : ndarray, shape (n,)
        Means over whole pole pitches, m/s and N.
    motion : ndarray of int, shape (n,)
        Motion, there and back, of each: errors of one motion may be correlated.
    time : ndarray, shape (n,), optional
        Averaging time of each mean, in any unit, as its weight. Left out: equal weights.
    """
    names = ("F_c", "F_s", "v_s", "sigma_2", "f_0")
    low = np.array([_SMALLEST_FORCE, _SMALLEST_FORCE, _LOWEST_V_S, 0.0, -np.inf])
    high = np.array([np.inf, np.inf, _HIGHEST_V_S, np.inf, np.inf])
    share = np.ones_like(force) if time is None else time / time.max()

    def solve(start: Array, power: float) -> _Solved:
        weight = share**power
        return _solve(
            lambda p: weight * (stribeck_curve(velocity, p) - force), names, start, (low, high)
        )

    solved = solve(np.clip(first_guesses(velocity, force)[0][:5], low, high), _POWERS[0])
    power = _likeliest_power(stribeck_curve(velocity, solved.values) - force, share)
    if power != _POWERS[0]:
        solved = solve(np.clip(solved.values, low, high), power)
    values = solved.values
    errors, correlation, degrees = scatter(solved.jacobian, solved.residuals, motion)
    half_width = student(degrees) * errors
    fitted = Fitted(
        names=names,
        values=values,
        errors=errors,
        half_width=half_width,
        residual_rms=_rms(stribeck_curve(velocity, values) - force),
        correlation=correlation,
        warnings=doubts(
            names, values, half_width, correlation_of(solved.jacobian), solved.edge, degrees
        ),
    )
    return replace(fitted, warnings=about_speeds(fitted, np.abs(velocity)) + fitted.warnings)


def _likeliest_power(residuals: Array, time: Array) -> float:
    """Return the power of time with which errors of means fall, by the likelihood of residuals.

    White noise gives a half, effects of a window's ends one.
    """

    def unlikely(power: float) -> float:
        squares = float(np.sum((residuals * time**power) ** 2))
        return 0.5 * len(time) * np.log(max(squares, _TINY)) - power * float(np.sum(np.log(time)))

    return min(_POWERS, key=unlikely)


def fit_presliding(
    responses: Sequence[Sequence[Array]],
    forces: Sequence[Sequence[Array]],
    signs: Sequence[float],
    sliding: Fitted,
    mass: float,
) -> Fitted:
    """Fit sigma_0, sigma_1 and the moving mass to displacements under force ramps.

    Each place is fitted by itself; the estimates are their means and the errors come from their
    spread, because a LuGre model's residuals along a ramp are no independent draws. The mass is
    free because it, too, is in the newtons of the controller's map.

    Parameters
    ----------
    responses : sequence (places) of sequence (ramps) of ndarray, shape (ticks,)
        Displacement at every tick, m.
    forces : sequence (places) of sequence (ramps) of ndarray, shape (ticks, SUBSTEPS)
        Thrust within every tick, N. Each ramp is its own: noise in a force makes the bristle creep,
        and the mean of two forces has less of it than either.
    signs : sequence (ramps) of float
        Direction of each ramp of a place, 1 or -1.
    sliding : Fitted
        F_c, F_s, v_s, sigma_2 and the constant force f_0, from `fit_sliding`.
    mass : float
        Moving mass of the controller's model, kg: start of the search.

    Returns
    -------
    Fitted
        sigma_0, sigma_1 and M; residuals in m.
    """
    names = ("sigma_0", "sigma_1", "M")

    loads = [-sign * sliding["f_0"] for sign in signs]

    def fit(data: Sequence[Array], thrust: Sequence[Array]) -> _Solved:
        def residuals(p: Array) -> Array:
            friction = LuGre(
                p[0], p[1], sliding["sigma_2"], sliding["F_c"], sliding["F_s"], sliding["v_s"]
            )
            model = model_response(friction, p[2], thrust, loads)
            return np.concatenate([m - d for m, d in zip(model, data, strict=True)])

        top = max(float(displacement.max()) for displacement in data)
        stiffness = max(float(force.max()) for force in thrust) / max(top, _SMALLEST_WAY)
        damping = np.sqrt(stiffness * mass)  # about critical
        start = np.array([stiffness, damping, mass])
        # The model is stepped explicitly but for the bristle: M stays above h sigma_1.
        bounds = (
            np.array([1e-2 * stiffness, 0.0, 0.2 * mass]),
            np.array([1e2 * stiffness, 0.2 * mass / PLANT_STEP, 5.0 * mass]),
        )
        return _solve(residuals, names, start, bounds, scale=_SMALLEST_WAY)

    places = [fit(*place) for place in zip(responses, forces, strict=True)]
    values = np.array([place.values for place in places])
    errors = values.std(axis=0, ddof=1) / np.sqrt(len(places))
    half_width = student(len(places) - 1) * errors
    mean = values.mean(axis=0)
    alike = np.mean([correlation_of(place.jacobian) for place in places], axis=0)
    edge = [name for name in names if any(name in place.edge for place in places)]
    return Fitted(
        names=names,
        values=mean,
        errors=errors,
        half_width=half_width,
        residual_rms=_rms(np.concatenate([place.residuals for place in places])),
        correlation=alike,
        warnings=doubts(
            names, mean, half_width, alike, edge, np.full(len(names), len(places) - 1.0)
        ),
    )


def about_speeds(fitted: Fitted, speed: Array) -> list[str]:
    """Warn of parameters that the range of speeds does not determine."""
    v_s = fitted["v_s"]
    slowest, fastest = float(speed.min()), float(speed.max())
    warnings = []
    if slowest > 0.5 * v_s:
        warnings.append(
            f"no speeds well below v_s = {v_s:.3g} m/s, the slowest is {slowest:.3g} m/s: "
            "F_s and v_s are extrapolated"
        )
    if fastest < 2.0 * v_s:
        warnings.append(
            f"no speeds well above v_s = {v_s:.3g} m/s, the fastest is {fastest:.3g} m/s: "
            "F_c and sigma_2 are extrapolated"
        )
    if fitted["F_s"] < fitted["F_c"]:
        warnings.append(
            f"F_s = {fitted['F_s']:.4g} N is below F_c = {fitted['F_c']:.4g} N: friction does not "
            "fall with velocity, and no LuGre model takes these numbers"
        )
    return warnings


def first_guesses(velocity: Array, force: Array, push: Array | None = None) -> list[Array]:
    """Return F_c, F_s, v_s, sigma_2, f_0 and M of static friction, best first.

    At each of many v_s the others are linear and, f_0 apart, not negative. Each local minimum over
    v_s is a guess.

    Parameters
    ----------
    velocity, force : ndarray, shape (n,)
        m/s and N.
    push : ndarray, shape (n,), optional
        Acceleration, m/s^2, where the force holds the inertia of an unknown mass.
    """
    from scipy.optimize import nnls

    speed, sign = np.abs(velocity), np.sign(velocity)
    guesses, rests = [], []
    for v_s in np.geomspace(0.3 * speed.min(), speed.max(), _CANDIDATES):
        falling = stribeck_fade(velocity, v_s)
        ones = np.ones_like(sign)
        columns = [sign * (1.0 - falling), sign * falling, velocity, ones, -ones]
        table = np.stack([*columns, *(() if push is None else (push,)), force], axis=1)
        R: Array = np.asarray(np.linalg.qr(table, mode="r"))
        linear, _ = nnls(R[:, :-1], R[:, -1])
        rests.append(float(np.sum((R[:, :-1] @ linear - R[:, -1]) ** 2)))
        mass = 0.0 if push is None else linear[5]
        guesses.append(np.array([*linear[:2], v_s, linear[2], linear[3] - linear[4], mass]))
    around = np.concatenate([[np.inf], rests, [np.inf]])
    lowest = (around[1:-1] <= around[:-2]) & (around[1:-1] <= around[2:])
    return [guesses[k] for k in sorted(np.flatnonzero(lowest), key=lambda k: rests[k])]


class _Solved(NamedTuple):
    """A least-squares solution: residuals and Jacobian in the residuals' unit."""

    values: Array
    residuals: Array
    jacobian: Array
    edge: list[str]  # parameters at the edge of their range


def _solve(
    residuals: Callable[[Array], Array],
    names: tuple[str, ...],
    start: Array,
    bounds: tuple[Array, Array],
    scale: float = 1.0,
) -> _Solved:
    """Minimise the sum of squared residuals."""
    from scipy.optimize import least_squares

    size = np.maximum(np.abs(start), 1e-6)
    solved = least_squares(
        lambda q: residuals(q * size) / scale,
        np.clip(start, *bounds) / size,
        bounds=(bounds[0] / size, bounds[1] / size),
        xtol=1e-12,
        ftol=1e-12,
        gtol=1e-12,
    )
    return _Solved(
        solved.x * size,
        solved.fun * scale,
        solved.jac * scale / size,
        [n for n, at in zip(names, solved.active_mask, strict=True) if at],
    )


def _rms(residuals: Array) -> float:
    return float(np.sqrt(np.mean(residuals**2)))


def student(degrees: Array | float) -> Array:
    """Return half of the interval in standard errors."""
    from scipy.special import stdtrit

    return stdtrit(degrees, 0.5 * (1.0 + _CONFIDENCE))


def doubts(  # noqa: PLR0913, PLR0917 - all that is known of a fit
    names: tuple[str, ...],
    values: Array,
    half_width: Array,
    correlation: Array,
    edge: list[str],
    degrees: Array,
) -> list[str]:
    """Return a warning for each parameter or pair that the data do not determine."""
    warnings = [
        f"{name} is at the edge of its range: the data do not determine it" for name in edge
    ]
    few: dict[str, float] = {}
    for name, value, half, free in zip(names, values, half_width, degrees, strict=True):
        if name in {"f_0", *edge}:
            continue
        if not np.isfinite(half):
            warnings.append(f"{name} cannot be identified: the data do not depend on it")
        elif half > _UNSURE * abs(value):
            warnings.append(f"{name} = {value:.4g} is only known to +-{half:.2g}")
        if np.isfinite(half) and free < _FEW:
            few[name] = free
    if few:
        least = min(few.values())
        warnings.append(
            f"the interval of {', '.join(few)} is wide because few measurements determine its "
            f"spread: {least:.1f} degrees of freedom make it {student(least):.1f} standard "
            "errors"
        )
    for i, j in itertools.combinations(range(len(names)), 2):
        if abs(correlation[i, j]) > _CORRELATED:
            warnings.append(
                f"{names[i]} and {names[j]} cannot be distinguished: correlation "
                f"{correlation[i, j]:.4f}"
            )
    return warnings
