"""The inverse of a loop as learning filter, and whether learning with it converges.

After each lap a force is corrected by what the lap's error asks for, in its own frequencies::

    U = -gamma Q E conj(G)/abs(G)**2 = -gamma Q E/G

with G the response of the following error to the force, of the loop that the controller's model
gives. Of a loop that answers with G* instead, the error that repeats is multiplied from lap to lap
by ``rho = abs(1 - gamma Q G*/G)``: below 1 at every frequency, learning converges. Q is on the
update, not on the force: what is learnt does not leak away where Q < 1.

Longman, "Iterative learning control and repetitive control for engineering practice", Int. J.
Control 73(10), 2000; Bristow, Tharayil, Alleyne, "A survey of iterative learning control", IEEE
Control Systems 26(3), 2006.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motionlab.config.controller import AxisModelConfig, NotchConfig
from motionlab.config.plant import AmplifierConfig, AxisConfig, PlantConfig, ResonanceConfig
from motionlab.config.scenario import Scenario
from motionlab.effects import EFFECTS
from motionlab.loop.linearise import linearise
from motionlab.timing import CONTROL_PERIOD

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

BANDWIDTH = 150.0
"""Hz, where nothing resonates."""
BELOW_NOTCH = 0.6
"""Of the frequency of a notch: a mode that the model does not have is not learnt in."""
SLIDING = 4.0
"""Velocity about which the filter's loop is linearised, in Stribeck velocities."""
SPEEDS = (0.0, 0.5, 1.0, 4.0)
"""Velocities at which convergence is predicted, in Stribeck velocities; 0 is stuck."""

_ORDER = 8
_LEAST = 0.02
"""Of Q: where it would be less, nothing is learnt, for the loop is least known there."""
_LOWEST = 0.02  # Hz; a stuck mover has no response at 0


def bandwidth_of(notch: NotchConfig) -> float:
    """Return the bandwidth of learning where none is given, Hz."""
    return BELOW_NOTCH * notch.frequency if notch.gain < 1.0 else BANDWIDTH


def modelled(scenario: Scenario, variant: str) -> Scenario:
    """Return a scenario with the motor that a variant's controller takes it to be: exact."""
    model = scenario.variants[variant].controller.model
    axes = {"x": (scenario.plant.x, model.x), "y": (scenario.plant.y, model.y)}
    plant = scenario.plant.model_copy(
        update={axis: _as_known(own, known) for axis, (own, known) in axes.items()}
    )
    assert isinstance(plant, PlantConfig)
    return scenario.model_copy(update={"plant": plant})


def _as_known(axis: AxisConfig, model: AxisModelConfig) -> AxisConfig:
    exact = {"resolution": 0.0, "sde_amplitude": 0.0, "noise": 0.0, "jitter": 0.0}
    return axis.model_copy(
        update={
            "encoder": axis.encoder.model_copy(update=exact),
            "mass": model.mass,
            "friction": model.friction,
            "force_map": model.force_map,
            "amplifiers": AmplifierConfig(limit=axis.amplifiers.limit),
            "resonance": ResonanceConfig(),
            "effects": (),
        }
    )


def _with_guide(scenario: Scenario, axis: str) -> Scenario:
    """Return a scenario whose axis has the friction of its guide in place of effects of friction.

    No loop is linearised with effects, and without any friction nothing would hold a mover at rest.
    """
    own = getattr(scenario.plant, axis)
    if own.friction.enabled or not any(EFFECTS[each.effect].friction for each in own.effects):
        return scenario
    guided = own.model_copy(update={"friction": own.friction.model_copy(update={"enabled": True})})
    plant = scenario.plant.model_copy(update={axis: guided})
    return scenario.model_copy(update={"plant": plant})


def lap_frequencies(ticks: int) -> Array:
    """Return the multiples of one over a lap of some control periods, Hz, up to half the rate."""
    return np.asarray(np.fft.rfftfreq(ticks, CONTROL_PERIOD), dtype=np.float64)


def to_error(
    scenario: Scenario, variant: str, axis: str, speed: float, frequency: Array
) -> Complex:
    """Return the response of the following error, m, to a force that is added, N.

    Parameters
    ----------
    scenario, variant, axis
        Motor and controller.
    speed : float
        Velocity about which the loop is linearised, in Stribeck velocities of the motor.
    frequency : ndarray, shape (n,)
        Hz.
    """
    v_s = getattr(scenario.plant, axis).friction.v_s
    loop = linearise(_with_guide(scenario, axis), variant, axis, v=speed * v_s)
    delay = scenario.variants[variant].controller.delay > 0
    return loop.to_error(np.maximum(frequency, _LOWEST), delay=delay)


@dataclass(frozen=True)
class LearningFilter:
    """The learning filter of one axis over the frequencies of a lap.

    Attributes
    ----------
    frequency : ndarray, shape (n,)
        Multiples of one over the lap, up to half the control rate, Hz.
    response : ndarray, shape (n,)
        G, m/N.
    q : ndarray, shape (n,)
        ``1/(1 + (f/f_Q)**8)``, and 0 where that is below 0.02.
    """

    frequency: Array
    response: Complex
    q: Array

    @classmethod
    def of(
        cls, scenario: Scenario, variant: str, axis: str, ticks: int, bandwidth: float
    ) -> LearningFilter:
        """Return the filter of a controller's model for laps of some control periods.

        Raises
        ------
        ConfigError
            If the controller cannot be linearised.
        """
        frequency = lap_frequencies(ticks)
        known = modelled(scenario, variant)
        response = to_error(known, variant, axis, SLIDING, frequency)
        q = 1.0 / (1.0 + (frequency / bandwidth) ** _ORDER)
        return cls(frequency, response, np.where(q < _LEAST, 0.0, q))

    def update(self, error: Array, gain: Array | float) -> Array:
        """Return what a lap's error, m, (ticks,), adds to the force, N, (ticks,)."""
        corrected = -self.q * np.fft.rfft(error) / self.response
        return gain * np.fft.irfft(corrected, len(error))

    def factor(self, response: Complex, gain: float) -> Array:
        """Return rho over `frequency` of a loop with another response, m/N, (n,)."""
        return np.abs(1.0 - gain * self.q * response / self.response)

    @property
    def band(self) -> NDArray[np.bool_]:
        """Where something is learnt."""
        return self.q > 0.0


def thinned(frequency: Array, count: int) -> NDArray[np.intp]:
    """Return at most `count` indices of frequencies above 0, evenly in their logarithm."""
    places = np.geomspace(frequency[1], frequency[-1], count)
    return np.unique(np.searchsorted(frequency, places).clip(1, len(frequency) - 1))
