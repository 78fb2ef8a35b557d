"""The loops of one axis over its gains: stability, margins and the edge, without a simulation.

In the force ``u = k_p e + k_d de/dt`` the gains are factors, and everything else of the controller
is linear: the open loop and the closed loop's matrix are affine in k_p and k_d. Three
linearisations therefore give every loop of the plane of gains.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.analysis.frequency import GRID, sampled
from motionlab.config.controller import GainsConfig
from motionlab.config.scenario import Scenario
from motionlab.simulation.linear import SLIDING, Loop, linearise

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


class Figures(NamedTuple):
    """Margins, infinite where there is none.

    Attributes
    ----------
    gain_margin : float
        Smallest factor, up or down, by which the gain may change to the edge.
    phase_margin : float
        rad.
    Ms : float
        Largest abs(1/(1 + L)).
    """

    gain_margin: float
    phase_margin: float
    Ms: float


@dataclass(frozen=True)
class LoopFamily:
    """The loops of one axis of one variant for any gains.

    Attributes
    ----------
    matrix : ndarray, shape (3, n, n)
        Closed loop without gains, and what each N/m and each N s/m adds to it.
    response : ndarray of complex, shape (3, frequencies)
        The same of the open loop, close in frequency where it changes fast.
    """

    matrix: Array
    response: Complex

    @classmethod
    def of(cls, scenario: Scenario, variant: str, axis: str) -> LoopFamily:
        """Return the loops of one axis while it slides at `SLIDING` Stribeck velocities.

        Raises
        ------
        ConfigError
            For the law ``published-k``, which has no linearisation.
        """
        v = SLIDING * getattr(scenario.plant, axis).friction.v_s

        def loop(k_p: float, k_d: float) -> Loop:
            return linearise(with_gains(scenario, variant, axis, k_p, k_d), variant, axis, v=v)

        loops = [loop(0.0, 0.0), loop(_UNIT, 0.0), loop(0.0, _UNIT)]
        matrix = np.stack([member.closed() for member in loops])
        grid, _ = sampled(loop(_UNIT, _UNIT).open, GRID[::_EVERY], _CHANGE)
        plant = loops[0].plant.response(grid)
        response = np.stack([plant * member.controller.response(grid) for member in loops])
        for affine in (matrix, response):
            affine[1:] = (affine[1:] - affine[0]) / _UNIT
        return cls(matrix, response)

    def radius(self, k_p: Array, k_d: Array) -> Array:
        """Return the largest modulus of the poles, shape of `k_p` and `k_d`; stable below 1."""
        free, p, d = self.matrix
        closed = free + k_p[..., None, None] * p + k_d[..., None, None] * d
        return np.abs(np.linalg.eigvals(closed)).max(axis=-1)

    def open(self, k_p: float, k_d: float) -> Complex:
        """Return the open loop at the frequencies of `response`."""
        free, p, d = self.response
        return free + k_p * p + k_d * d

    def figures(self, k_p: float, k_d: float) -> Figures:
        """Return margins, interpolated between frequencies at most 4.4 % apart."""
        L = self.open(k_p, k_d)
        at_unity = _between(L, np.log(np.abs(L)))
        gains = np.abs(_between(L, np.angle(-L)))  # where L is real and negative
        phases = np.abs(np.angle(-at_unity))
        return Figures(
            gain_margin=float(np.exp(np.abs(np.log(gains)).min())) if len(gains) else math.inf,
            phase_margin=float(phases.min()) if len(phases) else math.inf,
            Ms=float((1.0 / np.abs(1.0 + L)).max()),
        )


_EVERY, _CHANGE = 4, 0.12
"""Every which frequency of the grid to begin with, and what L may change between neighbours: as it
does in one such step where it falls by 40 dB a decade."""
_UNIT = 1e3
"""Gain that is large enough to tell by: N/m, and N s/m."""


def with_gains(scenario: Scenario, variant: str, axis: str, k_p: float, k_d: float) -> Scenario:
    """Return a scenario with other gains on one axis of one variant, N/m and N s/m."""
    owner = scenario.variants[variant]
    controller = owner.controller.model_copy(update={axis: GainsConfig(k_p=k_p, k_d=k_d)})
    changed = owner.model_copy(update={"controller": controller})
    return scenario.model_copy(update={"variants": scenario.variants | {variant: changed}})


def _between(L: Complex, measure: Array) -> Complex:
    """Return L where a real measure of it passes through 0; log abs(L) and arg L are straight.

    A phase that jumps from pi to -pi passes through no 0.
    """
    step = np.diff(measure)
    places = np.flatnonzero((measure[1:] * measure[:-1] < 0.0) & (np.abs(step) < math.pi))
    share = -measure[places] / step[places]
    return np.asarray(L[places] * (L[places + 1] / L[places]) ** share)
