"""A rational model of a measured plant: mass, friction, delay, lag and modes, with errors.

From force to position, continuous in time::

    P(s) = e^(-s tau)/(1 + s T_l) (1/(M s^2 + c s + k) + sum_i (kappa_i/M)/D_i(s))
    D_i(s) = s^2 + 2 zeta_i w_i s + w_i^2

The command is held over a control period T and the position sampled, so a measurement sees the sum
over all aliases ``s_n = j (w + 2 pi n/T)``::

    P_T(w) = (1 - e^(-j w T))/T sum_n P(s_n)/s_n

Parameters minimise ``S = sum |P_measured - P_T|^2/deviation^2``. Terms are added one at a time
while they lower the Bayesian information criterion with unknown scale, ``2 n ln(S/n) + p ln(2 n)``
for n lines and p parameters (Schwarz 1978, doi 10.1214/aos/1176344136), by 10, which Kass and
Raftery (1995, doi 10.1080/01621459.1995.10476572) call very strong evidence, with all lines and
without the one that the term improves most. The scale is free, so that intervals that are too short
everywhere bring about no modes.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

MODES = 3
"""Most modes of a model."""
LINES_MIN = 8
"""Fewest lines that a model is fitted to."""
PARAMETERS = {
    "mass": ("mass", "delay"),
    "lag": ("lag",),
    "damping": ("damping",),
    "stiffness": ("stiffness",),
    "mode": ("mode_frequency", "mode_damping", "mode_coupling"),
}
"""Parameters of each term, SI; frequencies in Hz."""
_ALIASES = np.arange(-8, 9)
_PLACES = 120  # frequencies at which a mode is looked for
_DAMPINGS = (0.01, 0.05, 0.2)
_TRIED = 3  # places from which a mode is fitted
_PRECISION = 1e-6  # least deviation, over the magnitude
_CONVINCING = 10.0  # by which a term lowers the criterion


@dataclass(frozen=True)
class FittedModel:
    """A model of a plant.

    Attributes
    ----------
    terms : tuple of str
        Keys of `PARAMETERS`: ``mass`` first, ``mode`` once for each.
    values, errors : ndarray, shape (parameters,)
        Of all terms in their order; standard errors, which grow with the residual where that
        exceeds the deviations.
    period : float
        Control period, s.
    residual : ndarray of complex, shape (lines,)
        Measured less modelled, over the deviation of the line.
    criterion : float
        Bayesian information criterion; only differences count.
    """

    terms: tuple[str, ...]
    values: Array
    errors: Array
    period: float
    residual: Complex
    criterion: float

    @property
    def misfit(self) -> float:
        """RMS of the residual for each degree of freedom; 1 where deviations explain it."""
        free = 2 * len(self.residual) - len(self.values)
        return float(np.sqrt(2.0 * (np.abs(self.residual) ** 2).sum() / free))

    def response(self, frequency: Array) -> Complex:
        """Return the sampled response at `frequency`, Hz, shape (n,)."""
        return _sampled(self.terms, self.values, frequency, self.period)

    def parts(self) -> Iterator[tuple[str, dict[str, tuple[float, float]]]]:
        """Yield each term with value and standard error of its parameters."""
        first = 0
        for term in self.terms:
            names = PARAMETERS[term]
            here = slice(first, first + len(names))
            pairs = zip(self.values[here].tolist(), self.errors[here].tolist(), strict=True)
            yield term, dict(zip(names, pairs, strict=True))
            first = here.stop

    def zeros_poles_gain(self) -> tuple[Complex, Complex, float]:
        """Return zeros and poles, rad/s, and gain of the model without its delay."""
        value, modes = _parts(self.terms, self.values)
        mass = value["mass"]
        terms = [value.get("damping", 0.0) / mass, value.get("stiffness", 0.0) / mass]
        # Each of the parallel parts: numerator over denominator, mass apart.
        parts = [(np.ones(1), np.array([1.0, *terms]))]
        for f, ratio, coupling in modes:
            w = 2.0 * np.pi * f
            parts.append((np.array([coupling]), np.array([1.0, 2.0 * ratio * w, w**2])))
        numerator = np.zeros(1)
        for i, (over, _) in enumerate(parts):
            product = over
            for _, under in parts[:i] + parts[i + 1 :]:
                product = np.convolve(product, under)
            numerator = np.polyadd(numerator, product)
        poles = [np.roots(under) for _, under in parts]
        gain = float(numerator[0]) / mass
        if "lag" in self.terms:
            poles.append(np.array([-1.0 / value["lag"]]))
            gain /= value["lag"]
        zeros = np.roots(numerator).astype(np.complex128)
        return zeros, np.concatenate(poles).astype(np.complex128), gain


def fit(frequency: Array, plant: Complex, deviation: Array, period: float) -> FittedModel | None:
    """Return the model that describes a measured plant best; None if there are too few lines.

    Parameters
    ----------
    frequency, plant, deviation : ndarray, shape (lines,)
        Hz, m/N, and the standard deviation of the plant as a complex number.
    period : float
        Control period, s.
    """
    if len(frequency) < LINES_MIN:
        return None
    least = _PRECISION * np.abs(plant)  # what is noiseless has no deviation
    fitting = _Fitting(frequency, plant, np.maximum(deviation, least), period)
    best = fitting.begin()
    while True:
        larger = [each for each in fitting.larger(best) if each is not None]
        tried = [each for each in larger if _apart(each) and _on_several_lines(best, each)]
        more = min(tried, key=lambda each: each.criterion, default=best)
        if more.criterion > best.criterion - _CONVINCING:
            return best
        best = more


def _apart(model: FittedModel) -> bool:
    """Return whether no peak of a mode overlaps that of another: such two cannot be told apart."""
    _, modes = _parts(model.terms, model.values)
    spans = sorted((f * (1.0 - ratio), f * (1.0 + ratio)) for f, ratio, _ in modes)
    return all(low > high for (_, high), (low, _) in itertools.pairwise(spans))


def _on_several_lines(model: FittedModel, larger: FittedModel) -> bool:
    """Return whether a term convinces without the line that it improves most.

    A mode much narrower than the distance of the lines would describe any single bad one.
    """
    before, after = np.abs(model.residual) ** 2, np.abs(larger.residual) ** 2
    rest = np.arange(len(before)) != np.argmax(before - after)
    count = 2 * int(rest.sum())
    spent = (len(larger.values) - len(model.values)) * np.log(count)
    fell = count * np.log(max(after[rest].sum(), 1e-12) / max(before[rest].sum(), 1e-12))
    return bool(fell + spent < -_CONVINCING)


def fit_alike(
    like: FittedModel, frequency: Array, plant: Complex, deviation: Array
) -> FittedModel | None:
    """Return a model of the same terms, fitted to another plant with the same weights."""
    deviation = np.maximum(deviation, _PRECISION * np.abs(plant))
    return _Fitting(frequency, plant, deviation, like.period).solve(like.terms, like.values)


@dataclass(frozen=True)
class _Fitting:
    frequency: Array
    plant: Complex
    deviation: Array
    period: float

    def begin(self) -> FittedModel:
        """Return the best mass with a delay."""
        w = 2.0 * np.pi * self.frequency
        weight = np.abs(self.plant) / self.deviation
        size = np.exp(np.average(np.log(np.abs(self.plant) * w**2), weights=weight))
        turned = np.angle(-self.plant * np.exp(0.5j * w * self.period))  # of a mass alone: 0
        delay = -np.average(turned / w, weights=weight * w**2)
        made = self.solve(("mass",), np.array([1.0 / size, delay]))
        assert made is not None
        return made

    def larger(self, model: FittedModel) -> Iterator[FittedModel | None]:
        """Yield models with one term more."""
        begun = {"lag": 0.3 * self.period, "damping": 0.0, "stiffness": 0.0}
        for term, first in begun.items():
            if term not in model.terms:
                yield self.solve((*model.terms, term), np.append(model.values, first))
        if model.terms.count("mode") < MODES:
            for first in self._places(model):
                yield self.solve((*model.terms, "mode"), np.append(model.values, first))

    def _places(self, model: FittedModel) -> Iterator[Array]:
        """Yield parameters of a mode that explain most of the residual."""
        terms, rest, present = (
            (*model.terms, "mode"),
            model.residual,
            model.response(self.frequency),
        )
        begun: list[tuple[float, Array]] = []
        for f in np.geomspace(2.0 * self.frequency[0], self.frequency[-1], _PLACES):
            for ratio in _DAMPINGS:
                values = np.append(model.values, [f, ratio, 1.0])
                there = _sampled(terms, values, self.frequency, self.period) - present
                column = there / self.deviation
                share = float((column.conj() @ rest).real / (column.conj() @ column).real)
                left = float((np.abs(rest - share * column) ** 2).sum())
                begun.append((left, np.array([f, ratio, share])))
        begun.sort(key=lambda each: each[0])
        yield from (first for _, first in begun[:_TRIED])

    def solve(self, terms: tuple[str, ...], first: Array) -> FittedModel | None:
        """Return the best parameters of some terms, from some values on; None if it fails."""
        names = [name for term in terms for name in PARAMETERS[term]]
        bounds = self._bounds(float(first[0]))
        below, above, scale = (np.array(each) for each in zip(*map(bounds.get, names), strict=True))

        def rest(values: Array) -> Array:
            of = _sampled(terms, values, self.frequency, self.period)
            return ((self.plant - of) / self.deviation).view(np.float64)

        inside = np.clip(first, below + 1e-6 * scale, above - 1e-6 * scale)
        solution = least_squares(rest, inside, bounds=(below, above), x_scale=scale, max_nfev=80)
        if not np.isfinite(solution.fun).all():
            return None
        count, free = len(solution.fun), len(solution.fun) - len(first)
        total = 2.0 * float(solution.fun @ solution.fun)  # each part has half of the variance
        jacobian = solution.jac * scale
        covariance = np.linalg.pinv(jacobian.T @ jacobian) * 0.5 * max(1.0, total / free)
        criterion = count * np.log(max(total / count, 1e-12)) + len(first) * np.log(count)
        return FittedModel(
            terms,
            solution.x,
            np.sqrt(np.diag(covariance)) * scale,
            self.period,
            solution.fun.view(np.complex128),
            float(criterion),
        )

    def _bounds(self, mass: float) -> dict[str, tuple[float, float, float]]:
        """Return least, most and typical size of each parameter."""
        T, (low, high) = self.period, self.frequency[[0, -1]].tolist()
        size = 2.0 * np.pi * mass
        return {
            "mass": (1e-3 * mass, 1e3 * mass, mass),
            "delay": (-2.0 * T, 40.0 * T, 0.1 * T),
            "lag": (1e-3 * T, 1.0 / low, 0.1 * T),
            "damping": (-np.inf, np.inf, size * low),
            "stiffness": (-np.inf, np.inf, size * low**2),
            "mode_frequency": (low, high, 0.01 * high),
            "mode_damping": (5e-4, 0.5, 0.02),
            "mode_coupling": (-np.inf, np.inf, 0.1),
        }


def _parts(
    terms: tuple[str, ...], values: Array
) -> tuple[dict[str, float], list[tuple[float, ...]]]:
    """Return parameters by their names, and those of each mode."""
    known: dict[str, float] = {}
    modes: list[tuple[float, ...]] = []
    first = 0
    for term in terms:
        names = PARAMETERS[term]
        here = values[first : first + len(names)].tolist()
        first += len(names)
        if term == "mode":
            modes.append(tuple(here))
        else:
            known.update(zip(names, here, strict=True))
    return known, modes


def _sampled(terms: tuple[str, ...], values: Array, frequency: Array, period: float) -> Complex:
    value, modes = _parts(terms, values)
    s = 2j * np.pi * (frequency + _ALIASES[:, None] / period)
    mass = value["mass"]
    P = 1.0 / ((mass * s + value.get("damping", 0.0)) * s + value.get("stiffness", 0.0))
    for f, ratio, coupling in modes:
        w = 2.0 * np.pi * f
        P += (coupling / mass) / (s**2 + 2.0 * ratio * w * s + w**2)
    P *= np.exp(-s * value["delay"]) / (1.0 + s * value.get("lag", 0.0))
    held = (1.0 - np.exp(-s[len(s) // 2] * period)) / period
    return np.asarray(held * (P / s).sum(axis=0), dtype=np.complex128)
