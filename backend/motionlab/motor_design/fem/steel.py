"""M-19 steel: field strength over flux density as a monotone spline."""

from __future__ import annotations

import functools

import numpy as np
from numpy.typing import NDArray

MU_0 = 4e-7 * np.pi
"""Permeability of vacuum, H/m."""

_H = (
    *(0, 15.120714, 22.718292, 27.842733, 31.871434, 35.365044, 38.600588, 41.736202, 44.873979),
    *(48.087807, 51.437236, 54.975221, 58.752993, 62.823644, 67.245285, 72.084406, 77.4201),
    *(83.350021, 89.999612, 97.537353, 106.201406, 116.348464, 128.547329, 143.765431, 163.754169),
    *(191.868158, 234.833507, 306.509769, 435.255202, 674.911968, 1108.325569, 1813.085468),
    *(2801.217421, 4053.653117, 5591.10689, 7448.318413, 9708.81567, 12486.931615, 16041.483644),
    *(21249.420624, 31313.495878, 53589.446877, 88477.484601, 124329.41054, 159968.5693),
    *(197751.604272, 234024.751347),
)
"""H in A/m at B = 0, 0.05 .. 2.3 T: M-19 steel of FEMM's library of materials (D. Meeker)."""

_B_END = 2.3
_B_LEAST = 1e-9  # T; below it the reluctivity is that at zero


class Steel:
    """An isotropic magnetization curve without losses.

    ``H(B)`` is a monotone cubic through the data up to 2.3 T and rises with 1/mu_0 above: the steel
    is saturated. A monotone H makes the energy convex, so that the field has one solution.
    """

    def __init__(self, flux_density: NDArray[np.float64], strength: NDArray[np.float64]) -> None:
        from scipy.interpolate import PchipInterpolator, PPoly

        spline = PchipInterpolator(flux_density, strength)
        self._end = float(flux_density[-1])
        self._field = PPoly(spline.c, spline.x)
        self._slope = self._field.derivative()
        self._energy = self._field.antiderivative()
        self._field_end = float(strength[-1])
        self._energy_end = float(self._energy(self._end))

    def field(self, flux_density: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return H, A/m, at `flux_density`, T, not negative."""
        within = np.minimum(flux_density, self._end)
        return self._field(within) + (flux_density - within) / MU_0

    def energy(self, flux_density: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the energy density, the integral of H over B, J/m^3."""
        within = np.minimum(flux_density, self._end)
        above = flux_density - within
        return self._energy(within) + above * (self._field_end + 0.5 * above / MU_0)

    def reluctivity(
        self, flux_density: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return nu = H/B, m/H, and its derivative over B, m/(H T)."""
        b = np.maximum(flux_density, _B_LEAST)
        nu = self.field(b) / b
        slope = np.where(b < self._end, self._slope(np.minimum(b, self._end)), 1 / MU_0)
        return nu, (slope - nu) / b


@functools.cache
def m19() -> Steel:
    """Return M-19, the non-oriented silicon steel of the default geometry."""
    return Steel(np.linspace(0.0, _B_END, len(_H)), np.array(_H))
