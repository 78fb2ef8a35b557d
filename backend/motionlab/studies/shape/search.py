"""The search for gains and filters on a measured plant.

The compliance ``abs(P/(1 + L))`` below the lowest present crossover falls as far as margins allow,
which are read off the *open* loop at the unfavourable end of its interval. That the loop stays
stable is counted on the measurement: it was taken in closed loop, so the present loop is stable,
and another one is too if ``(1 + L)/(1 + L_0)`` does not encircle the origin. Filters that act are
kept; what is added has to make the loop stiffer by at least `WORTH`, or it is not proposed.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from motionlab.studies.response.margins import measured_margins
from motionlab.studies.shape.controllers import FREQUENCY_MAX, AddedFilter, Controllers, Shape
from motionlab.studies.shape.documents import Resonance

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

WORTH = 0.5
"""Least gain in stiffness of an added filter, dB."""
_EVALUATIONS = 240
_LEAST_BELOW = 3  # frequencies over which the compliance is averaged
GAIN_MARGIN = "the gain margin up"
"""As `Search.worst` names it."""
_PENALTY = 400.0  # dB for a margin that is missed by its whole size
_ROOM = 0.005  # share of a margin that is kept beside it, or the search would end just beyond
_DECIBEL = 20.0 / math.log(10.0)


@dataclass(frozen=True)
class Limits:
    """What a proposal has to keep.

    Attributes
    ----------
    phase_margin : float
        rad.
    gain_margin : float
        Factor, up and down.
    step : float
        Largest factor of a gain.
    filters : int
        Most filters that are added.
    distance : float, optional
        Least distance of L from -1; by default what the phase margin leaves, at most 0.5.
    """

    phase_margin: float
    gain_margin: float
    step: float
    filters: int
    distance: float | None = None


class Proposal(NamedTuple):
    """The result of a search.

    Attributes
    ----------
    shape : Shape
        The best one.
    compliance : float
        Over that before, dB; infinite where nothing keeps the limits.
    worth : tuple of float
        By how much the loop would be less stiff without each filter, dB.
    """

    shape: Shape
    compliance: float
    worth: tuple[float, ...]


class Search:
    """The search on one measured plant.

    Parameters
    ----------
    controllers : Controllers
        Whose responses are tried.
    plant : ndarray of complex, shape (lines,)
        As measured, m/N.
    deviation : ndarray, shape (lines,)
        Its standard deviation as a complex number.
    before : Shape
        In effect during the measurement.
    limits : Limits
        To keep.
    progress : callable
        Called with the share done; what it raises ends the search.
    """

    def __init__(  # noqa: PLR0913 - what a search depends on
        self,
        controllers: Controllers,
        plant: Complex,
        deviation: Array,
        before: Shape,
        limits: Limits,
        *,
        progress: Callable[[float], None],
    ) -> None:
        self._controllers, self._plant, self._deviation = controllers, plant, deviation
        self.before, self._limits, self._progress = before, limits, progress
        self._L_0 = self.open(before)
        above = np.abs(self._L_0) < 1.0
        first = int(above.argmax()) if above.any() else len(above)
        self._below = np.arange(len(above)) < max(first, _LEAST_BELOW)
        self._compliance_0 = self._compliance(self._L_0)

    def open(self, shape: Shape) -> Complex:
        """Return L of a shape on the measured plant."""
        return self._plant * self._controllers.response(shape)

    def stiffer(self, shape: Shape) -> float:
        """Return the mean compliance over that before, dB."""
        return self._compliance(self.open(shape)) - self._compliance_0

    def keeps(self, shape: Shape) -> bool:
        """Return whether a shape keeps every limit."""
        return self._missed(self.open(shape)) <= 0.0

    def worst(self, shape: Shape) -> str:
        """Return which limit a shape misses most."""
        shares = self._shares(self.open(shape))
        return max(shares, key=lambda name: shares[name])

    def without_gain_margin_up_to(self, shape: Shape) -> float | None:
        """Return the highest frequency, Hz, if the phase reaches -180 degrees at none."""
        f = self._controllers.frequency
        unknown = measured_margins(f, self.open(shape))["gain_margin"] is None
        return float(f[-1]) if unknown else None

    def best(self, resonances: list[Resonance], places: list[str]) -> Proposal:
        """Return the best gains with the filters that are worth adding.

        They are added one at a time, each time the one that helps most; what the loop then does as
        well without is left out again.
        """
        shape, cost = self._tuned(self.before)
        tried, most = 0, 1 + self._limits.filters * (len(resonances) + 2)
        while len(shape.filters) < min(self._limits.filters, len(places)):
            further: list[tuple[Shape, float]] = []
            for added in self._candidates(shape, resonances, places[len(shape.filters)]):
                tried += 1
                self._progress(min(1.0, tried / most))
                further.append(self._tuned(replace(shape, filters=(*shape.filters, added))))
            better = min(further, key=lambda each: each[1], default=(shape, math.inf))
            if not better[1] < cost - WORTH:
                break
            shape, cost = better
        while True:
            without = [self._tuned(_without(shape, k)) for k in range(len(shape.filters))]
            worth = tuple(each[1] - cost for each in without)
            if not worth or min(worth) >= WORTH:
                return Proposal(shape, cost, worth)
            shape, cost = without[worth.index(min(worth))]

    def _candidates(
        self, shape: Shape, resonances: list[Resonance], place: str
    ) -> list[AddedFilter]:
        """Return the filters that may be added: against each resonance once, one of other kinds."""
        there = {each.reason for each in shape.filters}
        # No narrower than what the measurement has seen between two frequencies.
        apart = float(np.median(np.diff(np.log(self._controllers.frequency))))
        candidates = []
        for each in resonances:
            f = each.frequency
            if f > FREQUENCY_MAX / 1.1:
                continue
            reason = f"resonance at {f:.4g} Hz, {each.height:g} dB above its neighbourhood"
            limits = ((f / 1.1, f * 1.1), (max(0.05, apart), 1.5), (0.03, 0.9))
            candidates.append(AddedFilter("notch", place, (f, 0.4, 0.15), reason, limits))
        if place != "notch":
            top = min(FREQUENCY_MAX, float(self._controllers.frequency[-1]))
            candidates += [
                AddedFilter(
                    "low-pass",
                    place,
                    (0.8 * top,),
                    "gain above the crossover that the loop does not need",
                    ((0.15 * top, FREQUENCY_MAX),),
                ),
                AddedFilter(
                    "lead",
                    place,
                    (self._crossover(shape), 1.5),
                    "phase at the crossover",
                    ((10.0, 500.0), (1.05, 4.0)),
                ),
            ]
        return [each for each in candidates if each.reason not in there]

    def _crossover(self, shape: Shape) -> float:
        f = self._controllers.frequency
        return measured_margins(f, self.open(shape))["crossover"] or float(np.median(f))

    def _tuned(self, start: Shape) -> tuple[Shape, float]:
        """Return the best numbers of a shape, and its compliance; infinite where none keeps."""
        bounds = self._bounds(start)
        results = []
        for factor in (1.0, 0.8):
            x = start.numbers.copy()
            x[:2] += math.log(factor)
            x = np.clip(x, bounds[:, 0], bounds[:, 1])
            simplex = np.repeat(x[None], len(x) + 1, axis=0)
            for k in range(len(x)):
                wide = 0.3 if x[k] + 0.3 <= bounds[k, 1] else -0.3
                simplex[k + 1, k] = np.clip(x[k] + wide, *bounds[k])
            ended = minimize(
                lambda numbers: self._cost(start.with_numbers(numbers)),
                x,
                method="Nelder-Mead",
                bounds=bounds,
                options={"maxfev": _EVALUATIONS, "initial_simplex": simplex, "xatol": 1e-3},
            )
            results.append(start.with_numbers(np.clip(ended.x, bounds[:, 0], bounds[:, 1])))
        kept = [each for each in results if self.keeps(each)]
        if not kept:
            return start, math.inf
        costs = [self.stiffer(each) for each in kept]
        best = int(np.argmin(costs))
        return kept[best], costs[best]

    def _bounds(self, shape: Shape) -> Array:
        before, step = self.before, self._limits.step
        numbers = [before.k_p, before.k_d]
        limits = [(value / step, value * step) for value in numbers]
        if shape.bandwidth > 0.0:
            limits.append((before.bandwidth / step, min(500.0, before.bandwidth * step)))
        limits += [pair for each in shape.filters for pair in each.limits]
        return np.log(np.array(limits))

    def _cost(self, shape: Shape) -> float:
        L = self.open(shape)
        return self._compliance(L) + _PENALTY * max(0.0, self._missed(L) + _ROOM)

    def _compliance(self, L: Complex) -> float:
        return float(_DECIBEL * np.log(np.abs(self._plant / (1.0 + L))[self._below]).mean())

    def _missed(self, L: Complex) -> float:
        """Return by what share the worst margin is missed; at most 0 where all are kept."""
        return max(self._shares(L).values())

    def _shares(self, L: Complex) -> dict[str, float]:
        """Return by what share each margin is missed."""
        f, limits = self._controllers.frequency, self._limits
        turned = np.unwrap(np.angle((1.0 + L) / (1.0 + self._L_0)))
        if abs(turned[-1] - turned[0]) > math.pi:
            return {"stability": 2.0}
        # Within its 95 % interval, towards the point -1: by that much smaller is every distance.
        doubt = 2.0 * self._deviation / np.abs(self._plant)
        at = measured_margins(f, L)
        missed = {"a crossover": 0.0 if at["crossover"] is not None else 1.0}
        if (phase := at["phase_margin"]) is not None:
            here = float(np.interp(at["crossover"] or f[-1], f, doubt))
            missed["the phase margin"] = 1.0 - (phase - here) / limits.phase_margin
        least = math.log(limits.gain_margin)
        for name, title, sign in (
            ("gain_margin", GAIN_MARGIN, 1.0),
            ("gain_reduction", "the gain margin down", -1.0),
        ):
            if name == "gain_margin" and at[name] is None:
                missed[title] = 1.0  # not known: the record ends before the phase reaches -180 deg
            if (gain := at[name]) is not None:
                around = np.abs(np.abs(L) - 1.0 / gain).argmin()
                missed[title] = 1.0 - (sign * math.log(gain) - float(doubt[around])) / least
        distance = float((np.abs(1.0 + L) - doubt * np.abs(L)).min())
        least_distance = limits.distance or min(0.5, 2.0 * math.sin(0.5 * limits.phase_margin))
        # Filters count too: a lead raises all that lies above it.
        raised = float(np.log(np.abs(L / self._L_0)).max())
        missed["the step"] = raised / (math.log(limits.step) + 1e-9) - 1.0 - 2.0 * _ROOM
        missed["the distance of L from -1"] = 1.0 - distance / least_distance
        return missed


def _without(shape: Shape, k: int) -> Shape:
    """Return a shape without one of its filters; those after it move up."""
    places = [each.place for each in shape.filters]
    rest = [each for n, each in enumerate(shape.filters) if n != k]
    moved = [replace(each, place=place) for each, place in zip(rest, places, strict=False)]
    return replace(shape, filters=tuple(moved))
