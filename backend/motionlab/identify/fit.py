"""Nonlinear least squares, and what the Jacobian says of how well parameters are determined."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motionlab.config.timing import PLANT_STEP
from motionlab.identify.presliding import model_response
from motionlab.identify.stribeck import Fitted, stribeck_curve
from motionlab.plant.friction import LuGre

Array = NDArray[np.float64]

_CONFIDENCE = 0.95
_CORRELATED = 0.98
_UNSURE = 0.1
"""Half width of the interval, as a share of the value, from which a warning is given."""

_CANDIDATES = 60
_SMALLEST_WAY = 1e-7  # m
_SMALLEST_FORCE = 1e-6  # N, as in the controller's model
_LOWEST_V_S, _HIGHEST_V_S = 1.01e-5, 10.0


def fit_sliding(velocity: Array, force: Array) -> Fitted:
    """Fit F_c, F_s, v_s, sigma_2 and a constant offset f_0 to forces of uniform motion.

    The offset is what pulls one way at any velocity, such as a cable or an inclined axis.

    Parameters
    ----------
    velocity, force : ndarray, shape (n,)
        Means over whole pole pitches, m/s and N.

    Returns
    -------
    Fitted
        Forces in the newtons of `force`.
    """
    names = ("F_c", "F_s", "v_s", "sigma_2", "f_0")
    low = np.array([_SMALLEST_FORCE, _SMALLEST_FORCE, _LOWEST_V_S, 0.0, -np.inf])
    high = np.array([np.inf, np.inf, _HIGHEST_V_S, np.inf, np.inf])
    fitted = _fit(
        lambda p: stribeck_curve(velocity, p) - force,
        names,
        np.clip(_guess(velocity, force), low, high),
        (low, high),
    )
    return replace(fitted, warnings=_about_speeds(fitted, np.abs(velocity)) + fitted.warnings)


def fit_presliding(
    responses: Sequence[Sequence[Array]],
    forces: Sequence[Sequence[Array]],
    sliding: Fitted,
    mass: float,
) -> Fitted:
    """Fit sigma_0, sigma_1 and the moving mass to displacements under force ramps.

    Each place is fitted by itself; the estimates are their means and the errors come from their
    spread, because a LuGre model's residuals along a ramp are no independent draws. The mass is
    free because it, too, comes out in the newtons of the controller's map.

    Parameters
    ----------
    responses : sequence (places) of sequence (ramps) of ndarray
        Displacement at every tick, m.
    forces : sequence (places) of sequence (ramps) of ndarray
        Mean thrust of every tick, N.
    sliding : Fitted
        F_c, F_s, v_s and sigma_2, from `fit_sliding`.
    mass : float
        Moving mass that the controller believes in, kg: where the search starts.

    Returns
    -------
    Fitted
        sigma_0, sigma_1 and M; residuals in m.
    """
    names = ("sigma_0", "sigma_1", "M")

    def fit(data: Sequence[Array], thrust: Sequence[Array]) -> Fitted:
        def residuals(p: Array) -> Array:
            friction = LuGre(
                p[0], p[1], sliding["sigma_2"], sliding["F_c"], sliding["F_s"], sliding["v_s"]
            )
            model = model_response(friction, p[2], thrust)
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
        return _fit(residuals, names, start, bounds, scale=_SMALLEST_WAY)

    together = fit(over_places(responses), over_places(forces))
    places = [fit(*place) for place in zip(responses, forces, strict=True)]
    values = np.array([place.values for place in places])
    errors = values.std(axis=0, ddof=1) / np.sqrt(len(places))
    half_width = _student(len(places) - 1) * errors
    mean = values.mean(axis=0)
    edge = [n for n in names if any(f"{n} is at the edge" in w for f in places for w in f.warnings)]
    return Fitted(
        names=names,
        values=mean,
        errors=errors,
        half_width=half_width,
        residual_rms=float(np.sqrt(np.mean([place.residual_rms**2 for place in places]))),
        correlation=together.correlation,
        warnings=_doubts(names, mean, half_width, together.correlation, edge),
    )


def over_places(series: Sequence[Sequence[Array]]) -> list[Array]:
    """Return the mean over places of each ramp's series, given (places) of (ramps)."""
    return [np.mean(ramp, axis=0) for ramp in zip(*series, strict=True)]


def _about_speeds(fitted: Fitted, speed: Array) -> list[str]:
    """Say where the speeds leave out what a parameter acts on."""
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


def _guess(velocity: Array, force: Array) -> Array:
    """Return the best of many v_s; all other parameters are linear."""
    speed = np.abs(velocity)
    sign = np.sign(velocity)
    best, guess = np.inf, np.zeros(5)
    for v_s in np.geomspace(0.3 * speed.min(), speed.max(), _CANDIDATES):
        falling = np.exp(-((velocity / v_s) ** 2))
        columns = np.stack([sign * (1.0 - falling), sign * falling, velocity, np.ones_like(sign)])
        linear, *_ = np.linalg.lstsq(columns.T, force, rcond=None)
        rest = float(np.sum((linear @ columns - force) ** 2))
        if rest < best:
            best, guess = rest, np.array([linear[0], linear[1], v_s, linear[2], linear[3]])
    return guess


def _fit(
    residuals: Callable[[Array], Array],
    names: tuple[str, ...],
    start: Array,
    bounds: tuple[Array, Array],
    scale: float = 1.0,
) -> Fitted:
    """Minimise residuals, and read errors and correlations off the Jacobian."""
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
    values = solved.x * size
    count, unknowns = solved.jac.shape
    degrees = count - unknowns
    variance = 2.0 * solved.cost * scale**2 / degrees
    jacobian = solved.jac * scale / size
    errors, correlation = _errors(jacobian, variance)
    half_width = _student(degrees) * errors
    edge = [n for n, at in zip(names, solved.active_mask, strict=True) if at]
    return Fitted(
        names=names,
        values=values,
        errors=errors,
        half_width=half_width,
        residual_rms=float(np.sqrt(2.0 * solved.cost * scale**2 / count)),
        correlation=correlation,
        warnings=_doubts(names, values, half_width, correlation, edge),
    )


def _student(degrees: int) -> float:
    """Return how many standard errors half of the interval is."""
    from scipy.special import stdtrit

    return float(stdtrit(degrees, 0.5 * (1.0 + _CONFIDENCE)))


def _errors(jacobian: Array, variance: float) -> tuple[Array, Array]:
    """Return standard errors and correlations; inf and 0 where nothing depends on a parameter."""
    length = np.linalg.norm(jacobian, axis=0)
    seen = length > 0.0
    unit = jacobian / np.where(seen, length, 1.0)
    _, s, vt = np.linalg.svd(unit, full_matrices=False)
    determined = s > np.finfo(np.float64).eps * max(jacobian.shape) * s[0]
    inverse = np.where(determined, 1.0 / np.where(determined, s, 1.0), 0.0)
    covariance = (vt.T * inverse**2) @ vt
    # A direction without effect makes every parameter that it holds undetermined.
    lost = (np.abs(vt[~determined]) > 1e-6).any(axis=0) | ~seen
    spread = np.sqrt(np.diag(covariance))
    spread = np.where(spread > 0.0, spread, 1.0)
    errors = np.sqrt(variance) * spread / np.where(seen, length, 1.0)
    return np.where(lost, np.inf, errors), covariance / np.outer(spread, spread)


def _doubts(
    names: tuple[str, ...], values: Array, half_width: Array, correlation: Array, edge: list[str]
) -> list[str]:
    """Return a warning for each parameter or pair that the data do not determine."""
    warnings = [
        f"{name} is at the edge of its range: the data do not determine it" for name in edge
    ]
    for name, value, half in zip(names, values, half_width, strict=True):
        if name in {"f_0", *edge}:
            continue
        if not np.isfinite(half):
            warnings.append(f"{name} cannot be identified: the data do not depend on it")
        elif half > _UNSURE * abs(value):
            warnings.append(f"{name} = {value:.4g} is only known to +-{half:.2g}")
    for i, j in itertools.combinations(range(len(names)), 2):
        if abs(correlation[i, j]) > _CORRELATED:
            warnings.append(
                f"{names[i]} and {names[j]} cannot be told apart: correlation "
                f"{correlation[i, j]:.4f}"
            )
    return warnings
