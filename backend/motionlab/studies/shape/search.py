"""The search for gains and filters on a measured plant.

The compliance ``abs(P/(1 + L))`` below the present crossover falls as far as margins allow, which
are read off the *open* loop at the unfavourable end of its interval. That the loop stays stable is
counted on the measurement: it was taken in closed loop, so the present loop is stable, and another
one is too if ``(1 + L)/(1 + L_0)`` does not encircle the origin. Filters that act are kept; what is
added has to make the loop stiffer by at least `WORTH`, or it is not proposed.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

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
    """

    phase_margin: float
    gain_margin: float
    step: float
    filters: int


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
        crossover = measured_margins(controllers.frequency, self._L_0)["crossover"]
        low = crossover or float(np.median(controllers.frequency))
        self._below = controllers.frequency <= low
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

    def best(self, resonances: list[Resonance], places: list[str]) -> list[tuple[Shape, float]]:
        """Return the best gains, and then with each filter that is worth adding, and stiffness.

        The first is of the gains alone; its compliance is infinite where nothing keeps the limits.
        """
        rounds = [self._tuned(self.before)]
        tried = 0
        most = 1 + self._limits.filters * (len(resonances) + 2)
        while len(rounds[-1][0].filters) < min(self._limits.filters, len(places)):
            so_far, cost = rounds[-1]
            place = places[len(so_far.filters)]
            further: list[tuple[Shape, float]] = []
            for added in self._candidates(so_far, resonances, place):
                tried += 1
                self._progress(min(1.0, tried / most))
                start = replace(so_far, filters=(*so_far.filters, added))
                further.append(self._tuned(start))
            if not further:
                break
            next_one = min(further, key=lambda each: each[1])
            if not next_one[1] < cost - WORTH:
                break
            rounds.append(next_one)
        return rounds

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
        f, limits = self._controllers.frequency, self._limits
        turned = np.unwrap(np.angle((1.0 + L) / (1.0 + self._L_0)))
        if abs(turned[-1] - turned[0]) > math.pi:
            return 2.0
        # Within its 95 % interval, towards the point -1: by that much smaller is every distance.
        doubt = 2.0 * self._deviation / np.abs(self._plant)
        at = measured_margins(f, L)
        missed = [0.0 if at["crossover"] is not None else 1.0]
        if (phase := at["phase_margin"]) is not None:
            here = float(np.interp(at["crossover"] or f[-1], f, doubt))
            missed.append(1.0 - (phase - here) / limits.phase_margin)
        least = math.log(limits.gain_margin)
        for name, sign in (("gain_margin", 1.0), ("gain_reduction", -1.0)):
            if (gain := at[name]) is not None:
                around = np.abs(np.abs(L) - 1.0 / gain).argmin()
                missed.append(1.0 - (sign * math.log(gain) - float(doubt[around])) / least)
        distance = float((np.abs(1.0 + L) - doubt * np.abs(L)).min())
        missed.append(1.0 - distance / min(0.5, 2.0 * math.sin(0.5 * limits.phase_margin)))
        return max(missed)
