"""Laps of a simulated motor, and what is learnt from each for the next."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab.config.controller import ControllerConfig
from motionlab.config.learnt_force import FORCE_MAX, LearntForce, encoded
from motionlab.config.planar import AXES
from motionlab.config.scenario import Scenario
from motionlab.simulation.learnt import Lap, checked_lap, places
from motionlab.simulation.prepare import Prepared
from motionlab.simulation.simulation import Simulation, ready, sample_page, variant_columns
from motionlab.studies.learn.encoder_error import EncoderErrorFit
from motionlab.studies.learn.learning_filter import LearningFilter
from motionlab.telemetry.channels import CHANNELS

Array = NDArray[np.float64]

FULL_LAPS = 8
"""Laps with the whole gain; after them it falls, so that noise is averaged."""
_LEAST_GAIN = 0.1
_WORSE, _FLOOR = 1.5, 60e-9
"""A lap is worse than the best so far by that factor, and worse than that, m: go back."""
_ENCODER_FROM = 2
"""First lap, from 0, that an error of the encoder is looked for in."""

_COLUMN = {channel.name: column for column, channel in enumerate(CHANNELS)}
_POSITION, _MEASURED, _ERROR, _REALISED = (
    _COLUMN[name] for name in ("position", "position_measured", "following_error", "force_realised")
)


@dataclass(frozen=True)
class LapFigures:
    """What a lap was like on one axis.

    Attributes
    ----------
    peak, rms : float
        Following error as it is measured, m.
    true_peak, true_rms : float
        Distance of the mover from the reference, m.
    force : float
        Largest force that had been learnt before it, N.
    gain : float
        With which the force was corrected after it.
    went_back : bool
        Whether it was so much worse than the best that its force was given up.
    """

    peak: float
    rms: float
    true_peak: float
    true_rms: float
    force: float
    gain: float
    went_back: bool


@dataclass
class AxisLearning:
    """What one axis learns.

    Attributes
    ----------
    filter : LearningFilter
        Of the controller's model.
    encoder : EncoderErrorFit or None
        Where its error is learnt, too.
    gain : float
        Learning gain of the first laps.
    force : ndarray, shape (ticks,)
        Learnt so far, N.
    known : tuple of float
        Sine and cosine of the encoder's error, known so far, m.
    laps : list of LapFigures
        What they were like.
    error : ndarray, shape (ticks,)
        Following error of the latest lap, m.
    """

    filter: LearningFilter
    encoder: EncoderErrorFit | None
    gain: float
    force: Array
    known: tuple[float, float]
    laps: list[LapFigures] = field(default_factory=list)
    error: Array = field(default_factory=lambda: np.zeros(0))
    _best: float = math.inf
    _best_force: Array | None = None
    _fits: int = 0

    def learn(self, error: Array, true_error: Array, position: Array, velocity: Array) -> None:
        """Learn from a lap, whose errors, m, and motion are given tick by tick."""
        self.error = error
        rms = _rms(error)
        gain = self._gain_now()
        again = self.force is self._best_force  # after going back: what that lap is like by now
        back = rms > _WORSE * self._best and rms > _FLOOR and not again
        self.laps.append(
            LapFigures(
                float(np.abs(error).max()),
                rms,
                float(np.abs(true_error).max()),
                _rms(true_error),
                float(np.abs(self.force).max()),
                gain,
                back,
            )
        )
        if back and self._best_force is not None:
            self.force = self._best_force
            self.gain *= 0.5
            return
        if rms < self._best or again:
            self._best, self._best_force = rms, self.force
        if self.encoder is not None and len(self.laps) > _ENCODER_FROM:
            self._learn_encoder(error, position, velocity)
        self.force = np.clip(self.force + self.filter.update(error, gain), -FORCE_MAX, FORCE_MAX)

    def _gain_now(self) -> float:
        lap = len(self.laps)
        if lap < FULL_LAPS:
            return self.gain
        return max(_LEAST_GAIN, self.gain * FULL_LAPS / (lap + 1))

    def _learn_encoder(self, error: Array, position: Array, velocity: Array) -> None:
        assert self.encoder is not None
        amplitudes = self.encoder.amplitudes(error, position, velocity)
        if amplitudes is None:
            return
        self._fits += 1
        self.known = (
            self.known[0] + amplitudes[0] / self._fits,
            self.known[1] + amplitudes[1] / self._fits,
        )


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


@dataclass
class Learning:
    """Laps of one variant of a scenario, each with what the laps before have taught.

    Attributes
    ----------
    prepared : Prepared
        The scenario.
    variant : str
        Which controller learns.
    axes : dict of str to AxisLearning
        Of the axes that move.
    """

    prepared: Prepared
    variant: str
    axes: dict[str, AxisLearning]

    def __post_init__(self) -> None:
        """Make the motor ready, at rest before its first lap."""
        self.lap: Lap = checked_lap(self.prepared.reference)
        self._places = places(self.prepared.reference, self.lap)
        self.laps = 0
        known = self.prepared.scenario.learnt
        uses = self.prepared.scenario.variants[self.variant].controller.learnt
        self._laps_before = known.laps if known is not None and uses else 0
        reference = replace(self.prepared.reference, for_ever=True)
        scenario = self._scenario()
        alone = replace(
            self.prepared, scenario=scenario, reference=reference, epochs=((0, scenario),)
        )
        self._simulation = Simulation(alone, endless=True)
        self._samples = sample_page(1)

    def run(self, laps: int) -> Iterator[int]:
        """Run laps, and yield the number of each after it was learnt from; ends if it diverges.

        Where a force is known, one lap goes before: coming from rest, it says little of that force.
        """
        self.approach(any(each.force.any() for each in self.axes.values()))
        for _ in range(laps):
            columns = np.concatenate(list(self._advanced(self.lap.ticks)), axis=2)
            if columns.shape[2] < self.lap.ticks or self._simulation.failed_ticks[0] is not None:
                return
            start = self._simulation.tick - self.lap.ticks
            reference, velocity, *_ = self._simulation.timeline.at(start, self._simulation.tick)
            for number, axis in enumerate(AXES):
                if axis not in self.axes:
                    continue
                self.axes[axis].learn(
                    columns[_ERROR, number],
                    reference[:, number] - columns[_POSITION, number],
                    columns[_MEASURED, number],
                    velocity[:, number],
                )
            self.laps += 1
            self.take_up()
            yield self.laps

    def approach(self, lap: bool) -> None:
        """Come to the first lap, and run one with nothing learnt, if so asked."""
        if self._simulation.tick == 0:
            for _ in self._advanced(self.lap.first + self.lap.ticks * lap):
                pass

    def take_up(self) -> None:
        """Put in effect, from the next tick on, what the axes know by now."""
        self._simulation.adopt(ready(((self._simulation.tick, self._scenario()),)))

    def needed(self, laps: int) -> Array:
        """Return the force that a lap takes, mean of some more laps, N, (ticks, 2)."""
        forces = [
            np.concatenate(list(self._advanced(self.lap.ticks)), axis=2)[_REALISED].T
            for _ in range(laps)
        ]
        return np.mean(forces, axis=0)

    def load(self, force: dict[str, Array]) -> None:
        """Load axes in each lap with a force, N, (ticks,), against positive positions."""
        first, ticks = self.lap

        def over(stop: int, start: int) -> Array:
            tick = np.arange(start, stop)
            load = np.zeros((stop - start, len(AXES)))
            for axis, values in force.items():
                within = values[(tick - first) % ticks]
                load[:, AXES.index(axis)] = np.where(tick < first, 0.0, within)
            return load

        self._simulation.timeline.load(0, over)

    def learnt(self) -> LearntForce:
        """Return what was learnt so far."""
        force = {
            axis: self.axes[axis].force if axis in self.axes else np.zeros(self.lap.ticks)
            for axis in AXES
        }
        encodings = {axis: encoded(values) for axis, values in force.items()}
        return LearntForce(laps=self._laps_before + self.laps, places=self._places, **encodings)

    def changes(self) -> dict[str, Any]:
        """Return what was learnt as changes of the scenario, dotted path to value."""
        place = f"variants.{self.variant}.controller"
        changes: dict[str, Any] = {
            "learnt": self.learnt().model_dump(mode="json"),
            f"{place}.learnt": True,
        }
        for axis, learning in self.axes.items():
            if learning.encoder is not None:
                known = f"{place}.model.{axis}.subdivision"
                changes |= {
                    f"{known}.sine": learning.known[0],
                    f"{known}.cosine": learning.known[1],
                }
        return changes

    def _scenario(self) -> Scenario:
        scenario = self.prepared.scenario
        owner = scenario.variants[self.variant]
        controller = owner.controller
        model = controller.model.model_copy(
            update={
                axis: self._with_known(getattr(controller.model, axis), learning)
                for axis, learning in self.axes.items()
            }
        )
        changed: ControllerConfig = controller.model_copy(update={"learnt": True, "model": model})
        variants = {self.variant: owner.model_copy(update={"controller": changed})}
        return scenario.model_copy(
            update={"variants": variants, "learnt": self.learnt(), "schedule": ()}
        )

    @staticmethod
    def _with_known(model: Any, learning: AxisLearning) -> Any:
        sine, cosine = learning.known
        known = model.subdivision.model_copy(update={"sine": sine, "cosine": cosine})
        return model.model_copy(update={"subdivision": known})

    def _advanced(self, ticks: int) -> Iterator[Array]:
        """Advance by some ticks and yield samples of the variant, (channels, 2, n)."""
        left = ticks
        while left:
            count = self._simulation.advance(self._samples[:, :left])
            if count == 0:
                return
            left -= count
            yield variant_columns(self._samples, 0, count).astype(np.float64)
