"""The loops of one axis over its gains: stability, its boundary, margins, without a simulation.

In the force ``u = k_p e + k_d de/dt`` the gains are factors, and everything else of the controller
is linear: the open loop and the closed loop's matrix are affine in k_p and k_d. Three
linearisations therefore give every loop of the plane of gains, at each velocity.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.config.scenario import Scenario
from motionlab.kernel.force_maps import map_digests
from motionlab.lanes.bank import TABLES
from motionlab.loop.linearise import (
    SLIDING,
    Loop,
    Parameters,
    StateSpace,
    controller_about,
    parameters,
    plant_about,
)
from motionlab.loop.margins import GRID, sampled
from motionlab.timing import CONTROL_PERIOD

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

SLOWEST = 0.5
SPEEDS = tuple(np.geomspace(SLOWEST, SLIDING, 11).tolist())
"""Sliding velocities at which margins are looked for, in Stribeck velocities: below SLIDING,
friction falls with velocity. That costs margin, most of all about the Stribeck velocity itself."""
VELOCITIES = (0.0, *SPEEDS)
"""Where margins are looked for, in Stribeck velocities: stuck, where the bristle is a spring, and
sliding."""


class VelocityMargin(NamedTuple):
    """Worst value of a margin over the velocities, and the velocity."""

    value: float
    velocity: float  # m/s; 0: stuck


class Figures(NamedTuple):
    """The worst margins over the velocities, infinite where there is none.

    Attributes
    ----------
    gain_margin : VelocityMargin
        Smallest factor, up or down, by which the gain may change up to the stability boundary.
    phase_margin : VelocityMargin
        rad.
    Ms : VelocityMargin
        Largest abs(1/(1 + L)).
    """

    gain_margin: VelocityMargin
    phase_margin: VelocityMargin
    Ms: VelocityMargin


@dataclass(frozen=True)
class LoopFamily:
    """The loops of one axis of one variant for any gains, at one or several velocities.

    Attributes
    ----------
    velocity : ndarray, shape (v,)
        m/s; the first may be 0, stuck, the others are evenly spaced in their logarithms.
    plants : list of StateSpace
        At each velocity.
    frequency : ndarray, shape (f,)
        Hz, closer where a loop changes fast.
    matrix : ndarray, shape (3, v, n, n)
        Closed loop without gains, and what each N/m and each N s/m adds to it, of the states whose
        poles the gains move.
    fixed : ndarray, shape (v,)
        Largest modulus of the other poles.
    response : ndarray of complex, shape (3, v, f)
        As `matrix`, of the open loop.
    """

    velocity: Array
    plants: list[StateSpace]
    frequency: Array
    matrix: Array
    fixed: Array
    response: Complex

    @classmethod
    def of(
        cls,
        scenario: Scenario,
        variant: str,
        axis: str,
        speeds: tuple[float, ...] = VELOCITIES,
        *,
        like: LoopFamily | None = None,
    ) -> LoopFamily:
        """Return the loops of one axis.

        Parameters
        ----------
        scenario : Scenario
            Motor and controllers.
        variant : str
            Which controller.
        axis : str
            ``x`` or ``y``.
        speeds : tuple of float
            In Stribeck velocities of the motor; the first may be 0, stuck.
        like : LoopFamily, optional
            Loops of the same motor at the same speeds with other numbers in its observers, whose
            plants and frequencies are taken over.

        Raises
        ------
        ConfigError
            For the law ``published-k``, which has no linearisation.
        """
        par = parameters(scenario, variant, axis)
        velocity = par.friction.v_s * np.array(speeds)
        plants = like.plants if like else [plant_about(par, v) for v in velocity]

        def loops(k_p: float, k_d: float) -> list[Loop]:
            with_gains = par._replace(controller=par.controller._replace(k_p=k_p, k_d=k_d))
            at = zip(plants, velocity, strict=True)
            return [Loop(plant, controller_about(with_gains, v)) for plant, v in at]

        corners = [loops(0.0, 0.0), loops(_UNIT, 0.0), loops(0.0, _UNIT)]
        closed = _affine(np.array([[loop.closed() for loop in corner] for corner in corners]))
        moved = _moved(closed)
        kept = np.flatnonzero(~moved)
        frequency = like.frequency if like else _frequencies(loops(_UNIT, _UNIT))
        return cls(
            velocity,
            plants,
            frequency,
            closed[:, :, moved][..., moved],
            _radius(closed[0][:, kept[:, None], kept]),
            _responses(corners, frequency),
        )

    def radii(self, k_p: Array, k_d: Array) -> Array:
        """Return the largest modulus of the poles at each velocity, shape (..., v)."""
        free, p, d = self.matrix
        closed = free + k_p[..., None, None, None] * p + k_d[..., None, None, None] * d
        return np.maximum(_radius(closed), self.fixed)

    def radius(self, k_p: Array, k_d: Array) -> Array:
        """Return the largest modulus at any velocity, shape of `k_p` and `k_d`; stable below 1."""
        return self.radii(k_p, k_d).max(axis=-1)

    def figures(self, k_p: float, k_d: float) -> Figures:
        """Return the worst margins, interpolated between frequencies and between velocities."""
        worst = self._worst(np.array([k_p]), np.array([k_d]))
        return Figures(*(VelocityMargin(float(value[0]), float(at[0])) for value, at in worst))

    def margins_over(self, k_p: Array, k_d: Array) -> dict[str, Array]:
        """Return the worst margins for many gains, as `figures` gives them for one pair.

        Parameters
        ----------
        k_p, k_d : ndarray, shape (n,)
            N/m and N s/m.

        Returns
        -------
        dict of str to ndarray, shape (n,)
            Fields of `Figures`, NaN where a loop is unstable at any of the velocities, infinite
            where nothing crosses.
        """
        margins = {name: np.full(len(k_p), math.nan) for name in Figures._fields}
        stable = np.flatnonzero(self.radius(k_p, k_d) < 1.0)
        for begin in range(0, len(stable), _AT_ONCE):
            part = stable[begin : begin + _AT_ONCE]
            for name, (value, _) in zip(margins, self._worst(k_p[part], k_d[part]), strict=True):
                margins[name][part] = value
        return margins

    def _worst(self, k_p: Array, k_d: Array) -> list[tuple[Array, Array]]:
        """Return value and velocity of each of the `Figures` for n pairs of gains, (n,) each."""
        free, p, d = self.response
        L = free + k_p[:, None, None] * p + k_d[:, None, None] * d
        L = L.reshape(-1, L.shape[-1])
        size = L.real**2 + L.imag**2
        phase = np.full(len(L), math.inf)
        row, at_unity = _between(L, size > 1.0, lambda ends: np.log(np.abs(ends)))
        np.minimum.at(phase, row, np.abs(np.angle(-at_unity)))
        gain = np.full(len(L), math.inf)  # of its logarithm
        row, turns = _between(L, L.imag > 0.0, lambda ends: np.angle(-ends))
        np.minimum.at(gain, row, np.abs(np.log(np.abs(turns))))
        nearest = np.sqrt((1.0 + 2.0 * L.real + size).min(axis=-1))
        every = np.concatenate([gain, phase, nearest]).reshape(-1, len(self.velocity))
        value, velocity = (part.reshape(3, -1) for part in self._least(every))
        worst = np.exp(value[0]), value[1], 1.0 / np.maximum(value[2], _TINY)
        return list(zip(worst, velocity, strict=True))

    def _least(self, values: Array) -> tuple[Array, Array]:
        """Return the least of (n, v) values over the velocities, on the parabola through it."""
        count, last = len(values), len(self.velocity) - 1
        k = values.argmin(axis=1)
        value, velocity = values[np.arange(count), k], self.velocity[k]
        slowest = int(self.velocity[0] == 0.0)  # stuck is no neighbour of sliding
        inside = np.flatnonzero((k > slowest) & (k < last))
        if not len(inside):
            return value, velocity
        middle = k[inside]
        before, after = values[inside, middle - 1], values[inside, middle + 1]
        with np.errstate(invalid="ignore"):
            slope, bend = 0.5 * (after - before), after + before - 2.0 * value[inside]
        bent = np.isfinite(bend) & (bend != 0.0)
        inside, middle, slope, bend = inside[bent], middle[bent], slope[bent], bend[bent]
        step = np.log(self.velocity[middle + 1] / self.velocity[middle])
        value[inside] = np.maximum(value[inside] - 0.5 * slope**2 / bend, 0.0)
        velocity[inside] *= np.exp(-step * slope / bend)
        return value, velocity


@dataclass(frozen=True)
class LoopKey:
    """Loops by the numbers that decide them: results that are kept have these as their key."""

    key: tuple[Parameters, tuple[str, ...]]
    scenario: Scenario = field(compare=False)
    variant: str = field(compare=False)
    axis: str = field(compare=False)


@functools.lru_cache(maxsize=16)
def _family(key: LoopKey) -> LoopFamily:
    return LoopFamily.of(key.scenario, key.variant, key.axis)


@TABLES.lease()
def family_of(scenario: Scenario, variant: str, axis: str) -> LoopFamily:
    """Return the loops of one axis; those of the last few motors and controllers are kept.

    A slider of gains repeats them: only the gains differ.

    Raises
    ------
    ConfigError
        As `LoopFamily.of`.
    """
    par = parameters(scenario, variant, axis)
    without = par._replace(controller=par.controller._replace(k_p=0.0, k_d=0.0))
    return _family(LoopKey((without, map_digests([(0, scenario)])), scenario, variant, axis))


_AT_ONCE = 128
"""Pairs of gains whose open loops are held at once: 6 MB with 11 velocities, 274 frequencies."""
_EVERY, _CHANGE = 4, 0.12
"""Initial stride over the frequency grid, and the largest change of L between neighbours: that of
one such step at 40 dB a decade."""
_UNIT = 1e3
"""Gains large enough for differences: N/m, and N s/m."""
_TINY = 1e-12
"""Numerical floor of the distance from -1."""


def _affine(corners: Array) -> Array:
    """Return the value without gains and its slope over each gain."""
    return np.stack([corners[0], *((corner - corners[0]) / _UNIT for corner in corners[1:])])


def _moved(closed: Array) -> NDArray[np.bool_]:
    """Return the states whose poles gains move: their loop holds an entry with a gain in it.

    States that drive one another in a ring share poles; those of different rings do not.
    """
    from scipy.sparse.csgraph import connected_components

    _, ring = connected_components((closed != 0.0).any(axis=(0, 1)), connection="strong")
    rows, columns = np.nonzero((closed[1:] != 0.0).any(axis=(0, 1)))
    return np.isin(ring, ring[rows[ring[rows] == ring[columns]]])


def _radius(matrix: Array) -> Array:
    return np.abs(np.linalg.eigvals(matrix)).max(axis=-1, initial=0.0)


def _frequencies(loops: list[Loop]) -> Array:
    """Return frequencies, Hz, close enough for each of some loops."""
    begin = np.append(GRID[::_EVERY], GRID[-1])
    grid, _ = sampled(lambda some: np.stack([loop.open(some) for loop in loops]), begin, _CHANGE)
    return grid


def _responses(corners: list[list[Loop]], frequency: Array) -> Complex:
    """Return the open loop without gains and its slope over each gain, at each velocity."""
    plant = np.stack([loop.plant.response(frequency) for loop in corners[0]])
    free, with_p = (
        np.stack([loop.controller.response(frequency) for loop in corner]) for corner in corners[:2]
    )
    p = plant * (with_p - free) / _UNIT
    # k_d acts on the difference of what k_p acts on
    differenced = -np.expm1(-2j * np.pi * frequency * CONTROL_PERIOD) / CONTROL_PERIOD
    return np.stack([plant * free, p, p * differenced])


def with_gains(scenario: Scenario, variant: str, axis: str, k_p: float, k_d: float) -> Scenario:
    """Return a scenario with other gains on one axis of one variant, N/m and N s/m."""
    owner = scenario.variants[variant]
    gains = getattr(owner.controller, axis).model_copy(update={"k_p": k_p, "k_d": k_d})
    changed = owner.model_copy(
        update={"controller": owner.controller.model_copy(update={axis: gains})}
    )
    return scenario.model_copy(update={"variants": scenario.variants | {variant: changed}})


def _between(
    L: Complex, side: NDArray[np.bool_], measure: Callable[[Complex], Array]
) -> tuple[NDArray[np.intp], Complex]:
    """Return the frequencies at which a measure of L is 0, and L there.

    log abs(L) and arg L are straight between neighbours. A phase that jumps from pi to -pi passes
    through no 0.
    """
    v, f = np.nonzero(side[:, 1:] != side[:, :-1])
    before, after = L[v, f], L[v, f + 1]
    begins, ends = measure(before), measure(after)
    real = (begins * ends < 0.0) & (np.abs(ends - begins) < math.pi)
    share = begins[real] / (begins[real] - ends[real])
    return v[real], before[real] * (after[real] / before[real]) ** share
