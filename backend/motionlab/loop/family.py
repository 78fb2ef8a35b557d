"""The loops of one axis over its gains: stability, its boundary, margins, without a simulation."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.config.scenario import Scenario
from motionlab.executors.progress import watch_compilation
from motionlab.kernel.force_gain import lanes_of
from motionlab.kernel.force_maps import map_digests
from motionlab.kernel.layout import Parameters
from motionlab.lanes import cached
from motionlab.lanes.bank import TABLES
from motionlab.laws import SOURCES
from motionlab.loop.lane_loops import UNIT, Loops, close_loops, empty_loops, stability
from motionlab.loop.lane_margins import sample_responses, short_systems, worst_margins
from motionlab.loop.linearise import (
    SLIDING,
    parameters,
    plant_gains,
    write_controller,
    write_plants,
)

Array = NDArray[np.float64]

watch_compilation()

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


class GainLimits(NamedTuple):
    """Nearest gains at which stability changes; None beyond a factor of 1000."""

    k_p: float | None  # N/m
    k_d: float | None  # N s/m


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


class LoopFamily:
    """The loops of one axis of one variant for any gains, at one or several velocities.

    Attributes
    ----------
    velocity : ndarray, shape (v,)
        m/s; the first may be 0, stuck, the others are evenly spaced in their logarithms.
    """

    def __init__(self, velocity: Array) -> None:
        self.velocity = velocity
        self._loops = empty_loops(velocity)

    @classmethod
    def of(
        cls, scenario: Scenario, variant: str, axis: str, speeds: tuple[float, ...] = VELOCITIES
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

        Raises
        ------
        ConfigError
            For the law ``published-k``, which has no linearisation.
        """
        par = parameters(scenario, variant, axis)
        family = cls(par.friction.v_s * np.array(speeds))
        velocity, loops, numbers = family.velocity, family._loops, lanes_of(par)
        gains = plant_gains(par, velocity)
        plant_states = write_plants(numbers, velocity, gains, loops.plant, False)
        controller_states = 0
        for corner, (k_p, k_d) in enumerate(((0.0, 0.0), (UNIT, 0.0), (0.0, UNIT))):
            for v, system in zip(velocity, loops.controller[corner], strict=True):
                controller_states = write_controller(numbers, k_p, k_d, v, system)
        _join(loops, plant_states, controller_states)
        return family

    def radii(self, k_p: Array, k_d: Array) -> Array:
        """Return the largest modulus of the poles at each velocity, shape (..., v)."""
        p, d = np.broadcast_arrays(np.asarray(k_p, dtype=float), np.asarray(k_d, dtype=float))
        radii = np.empty((p.size, len(self.velocity)))
        _stability(self._loops, p.ravel(), d.ravel(), radii, np.empty((0, 2)))
        return radii.reshape(*p.shape, -1)

    def radius(self, k_p: Array, k_d: Array) -> Array:
        """Return the largest modulus at any velocity, shape of `k_p` and `k_d`; stable below 1."""
        return self.radii(k_p, k_d).max(axis=-1)

    def limits(self, k_p: float, k_d: float) -> tuple[GainLimits, GainLimits]:
        """Return the nearest gains at which stability changes, at the first and last velocity.

        Each gain is moved alone, up from a stable loop and down from an unstable one.
        """
        limits = np.empty((2, 2))
        gains = np.array([k_p]), np.array([k_d])
        _stability(self._loops, *gains, np.empty((1, len(self.velocity))), limits)
        known = [[None if math.isnan(each) else each for each in row] for row in limits.tolist()]
        return GainLimits(*known[0]), GainLimits(*known[1])

    def figures(self, k_p: float, k_d: float) -> Figures:
        """Return the worst margins, interpolated between frequencies and between velocities."""
        (worst,) = self._worst(np.array([k_p]), np.array([k_d])).tolist()
        return Figures(*(VelocityMargin(*each) for each in worst))

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
        values = np.full((len(k_p), len(Figures._fields)), math.nan)
        stable = np.flatnonzero(self.radius(k_p, k_d) < 1.0)
        values[stable] = self._worst(k_p[stable], k_d[stable])[..., 0]
        return dict(zip(Figures._fields, values.T, strict=True))

    def _worst(self, k_p: Array, k_d: Array) -> Array:
        """Return value and velocity of each of the `Figures` for n pairs of gains, (n, 3, 2)."""
        worst = np.empty((len(k_p), len(Figures._fields), 2))
        _worst(self._loops, k_p, k_d, worst)
        return worst


@cached
def _join(loops: Loops, plant_states: int, controller_states: int) -> None:
    close_loops(loops, plant_states, controller_states)
    short_systems(loops, plant_states, controller_states)
    sample_responses(loops)


@cached
def _stability(loops: Loops, k_p: Array, k_d: Array, radii: Array, limits: Array) -> None:
    stability(loops, k_p, k_d, radii, limits)


@cached
def _worst(loops: Loops, k_p: Array, k_d: Array, worst: Array) -> None:
    for n in range(len(k_p)):
        worst_margins(loops, k_p[n], k_d[n], worst[n])


@TABLES.lease()
def stability_limits(
    scenario: Scenario, variant: str, axis: str, speed: float = SLIDING
) -> dict[str, float | None]:
    """Return the nearest gains of one axis at which its loop changes between stable and unstable.

    Each gain is moved alone, up from a stable loop and down from an unstable one.

    Parameters
    ----------
    scenario : Scenario
        Motor and controllers.
    variant : str
        Which controller.
    axis : str
        ``x`` or ``y``.
    speed : float
        Sliding velocity, in Stribeck velocities of the motor; 0 is stuck.

    Returns
    -------
    dict of str to float or None
        ``k_p``, N/m, and ``k_d``, N s/m; None where no such gain is found up to a thousandfold.

    Raises
    ------
    ConfigError
        As `linearise`.
    """
    gains = getattr(scenario.variants[variant].controller, axis)
    family = LoopFamily.of(scenario, variant, axis, (speed,))
    return family.limits(gains.k_p, gains.k_d)[0]._asdict()


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
    versions = (*map_digests([(0, scenario)]), *SOURCES.values())
    return _family(LoopKey((without, versions), scenario, variant, axis))


def with_gains(scenario: Scenario, variant: str, axis: str, k_p: float, k_d: float) -> Scenario:
    """Return a scenario with other gains on one axis of one variant, N/m and N s/m."""
    owner = scenario.variants[variant]
    gains = getattr(owner.controller, axis).model_copy(update={"k_p": k_p, "k_d": k_d})
    changed = owner.model_copy(
        update={"controller": owner.controller.model_copy(update={axis: gains})}
    )
    return scenario.model_copy(update={"variants": scenario.variants | {variant: changed}})
