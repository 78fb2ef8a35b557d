"""Trials of sets of gains: movers side by side in lanes, each axis of each on its own."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.config.controller import ControllerConfig
from motionlab.config.planar import AXES
from motionlab.config.scenario import Scenario, WindowConfig
from motionlab.config.timing import CONTROL_PERIOD
from motionlab.kernel.build import mover_parameters
from motionlab.kernel.layout import parameter_row
from motionlab.simulation.batch_runner import BatchRunner, Scores
from motionlab.simulation.prepare import Prepared

Array = NDArray[np.float64]


class Outcome(NamedTuple):
    """Metrics of one axis under one set of gains, over the window.

    Attributes
    ----------
    peak, rms : float
        Of the following error, m.
    itae : float
        Integral of time times abs(e), m s^2.
    settling : float
        Longest settling time of a hold, s; the window's length where it never settles or none is.
    effort : float
        Root mean square of the thrust, N.
    force : float
        Largest thrust, N.
    saturated : float
        Share of ticks with force or current at its limit.
    diverged : bool
        Whether it diverged; then the others are infinite.
    """

    peak: float
    rms: float
    itae: float
    settling: float
    effort: float
    force: float
    saturated: float
    diverged: bool


DIVERGED = Outcome(*[math.inf] * 7, diverged=True)

METRICS = {
    "peak": "max_abs_following_error",
    "rms": "rms_following_error",
    "itae": "itae",
    "settling": "settling_time",
    "effort": "rms_force",
    "force": "max_abs_force",
    "saturated": "saturated_fraction",
}
"""Names in `motionlab.analysis.metrics`."""

_K_P, _K_D = parameter_row("controller.k_p"), parameter_row("controller.k_d")


class TrialSetup:
    """Trial setup of gain sets: motor, motion, window.

    Parameters
    ----------
    prepared : Prepared
        Motor, motion, load and noise, in effect all the time; its variants do not matter.
    window : tuple of int
        Ticks [start, end); a trial ends with it.
    """

    def __init__(self, prepared: Prepared, window: tuple[int, int]) -> None:
        self._given = prepared, window
        start, end = window
        whole = prepared.reference
        self.scenario: Scenario = prepared.scenario.model_copy(
            update={
                "window": WindowConfig(start=start * CONTROL_PERIOD, end=end * CONTROL_PERIOD),
                "schedule": (),
            }
        )
        self.window = window
        self.reference = dataclasses.replace(
            whole,
            position=whole.position[:end],
            velocity=whole.velocity[:end],
            acceleration=whole.acceleration[:end],
            holds=tuple((a, b) for a, b in whole.holds if a < end),
        )
        load = prepared.load[:end]
        self._runner = BatchRunner(
            Prepared(self.scenario, self.reference, load, epochs=((0, self.scenario),))
        )

    def __reduce__(self) -> tuple[Any, ...]:
        """Return its pickled form: another process computes the inputs again."""
        return TrialSetup, self._given

    @property
    def seconds(self) -> float:
        """Simulated time of a trial, s."""
        return self.window[1] * CONTROL_PERIOD

    def run(self, controllers: Sequence[ControllerConfig]) -> list[dict[str, Outcome]]:
        """Return the outcome of each axis under each controller."""
        movers = np.array([mover_parameters(self.scenario, one) for one in controllers])
        scores = self._runner.score(movers.transpose(0, 2, 1)[None])
        return [
            {axis: self._outcome(scores, mover, a) for a, axis in enumerate(AXES)}
            for mover in range(len(controllers))
        ]

    def over_gains(
        self,
        controller: ControllerConfig,
        k_p: Array,
        k_d: Array,
        progress: Callable[[float], None] | None = None,
        *,
        threads: int | None = None,
    ) -> dict[str, Array]:
        """Return metrics, shape (n, 2), of both axes under n pairs of gains, the same for both.

        Parameters
        ----------
        controller : ControllerConfig
            All but its gains.
        k_p, k_d : ndarray, shape (n,)
            N/m and N s/m.
        progress : callable, optional
            Takes the share done; what it raises ends the work.
        threads : int, optional
            How many threads to use; one for each core when left out.

        Returns
        -------
        dict of str to ndarray
            Keys of `METRICS`, infinite where an axis diverged.
        """
        one = np.array(mover_parameters(self.scenario, controller)).T
        movers = np.repeat(one[None], len(k_p), axis=0)
        movers[:, _K_P], movers[:, _K_D] = k_p[:, None], k_d[:, None]
        scores = self._runner.score(movers[None], threads=threads, progress=progress)
        found = {name: scores.metrics[metric] for name, metric in METRICS.items()}
        found["settling"] = np.where(np.isnan(found["settling"]), self._never, found["settling"])
        return {
            name: np.where(scores.failed >= 0, math.inf, values) for name, values in found.items()
        }

    @property
    def _never(self) -> float:
        return (self.window[1] - self.window[0]) * CONTROL_PERIOD

    def _outcome(self, scores: Scores, mover: int, axis: int) -> Outcome:
        if scores.failed[mover, axis] >= 0:
            return DIVERGED
        found = {name: float(scores.metrics[m][mover, axis]) for name, m in METRICS.items()}
        if math.isnan(found["settling"]):
            found["settling"] = self._never
        return Outcome(**found, diverged=False)
