"""A frequency sweep of the simulated loop during a slow motion, as measured on a machine.

Under stiction a sweep at rest measures the stuck machine, so the axis moves at constant velocity,
over whole pole pitches, since the gain changes along them. Two runs at each frequency give what one
cannot: with a sine on the reference, ``P = p/f`` from force command to position; with a sine on the
load, ``C = -f/p`` of the feedback. The open loop is L = C P. From both a third run, the motion
alone, is subtracted: if the controller's map is off, its ripple lies at any frequency.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motionlab.config.changes import apply_changes
from motionlab.config.load import validate
from motionlab.config.scenario import Scenario
from motionlab.config.timing import CONTROL_PERIOD, to_ticks
from motionlab.errors import ConfigError, FieldError
from motionlab.kernel.force_maps import pole_pitch
from motionlab.loop.linearise import linearise
from motionlab.simulation.prepare import Prepared, prepare
from motionlab.simulation.run import run

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

_SETTLING = to_ticks(0.5)
"""Ticks before a measurement, after the axis has come to speed."""
_LEAST, _LEAST_CYCLES = 0.5, 8
"""What a measurement takes at least, s and cycles."""
_PITCH_MOST = 4.0
"""Longest time for a pole pitch that a measurement is rounded up to whole pitches for, s."""
_MODULATION = 0.1
"""Share of the slow velocity that a sine may add to it, so that friction sees small signals."""
_EASE = 0.2
"""Time in which the axis comes to speed, s."""


@dataclass(frozen=True)
class FrequencyResponse:
    """A measured frequency response.

    Attributes
    ----------
    frequency : ndarray, shape (n,)
        Hz; each rounded so that whole cycles fill a measurement.
    plant : ndarray of complex, shape (n,)
        Force command to position, m/N.
    controller : ndarray of complex, shape (n,)
        Position to the opposite of the force command, N/m.
    """

    frequency: Array
    plant: Complex
    controller: Complex

    @property
    def open(self) -> Complex:
        """The open loop L = C P."""
        return self.plant * self.controller


def frequency_sweep(  # noqa: PLR0913 - what a sweep is made of
    scenario: Scenario,
    variant: str,
    axis: str,
    frequency: Sequence[float],
    *,
    v: float = 0.02,
    force: float = 5.0,
    progress: Callable[[float], None] | None = None,
) -> FrequencyResponse:
    """Measure the loop of one axis of one variant.

    Parameters
    ----------
    scenario : Scenario
        Motor and controllers; its motion and load are replaced.
    variant : str
        Which controller.
    axis : str
        ``x`` or ``y``.
    frequency : sequence of float
        Frequencies, Hz, below half the control rate.
    v : float
        Velocity of the slow motion, m/s.
    force : float
        Largest amplitude of the force, N: of the load, and about what the reference's sine takes.
    progress : callable, optional
        Called with the share done.

    Raises
    ------
    ConfigError
        If a measurement would leave the stroke or a variant diverges.
    """
    index = "xy".index(axis)
    loop = linearise(scenario, variant, axis, v=v)
    pitch = pole_pitch(getattr(scenario.plant, axis).force_map) / v
    points: list[tuple[float, complex, complex]] = []
    for done, wanted in enumerate(frequency):
        cycles = round(_duration(wanted, pitch) * wanted)
        ticks = round(cycles / wanted / CONTROL_PERIOD)
        f = cycles / (ticks * CONTROL_PERIOD)
        prepared = _moving(scenario, variant, axis, v, ticks)
        at = np.array([f])
        compliance = abs(loop.plant.response(at)[0])
        size = min(force, _MODULATION * v / (2.0 * math.pi * f * compliance))
        gain = abs(loop.controller.response(at)[0] / (1.0 + loop.open(at)[0]))
        alone = _measure(prepared, index, f, ticks)
        by_reference = _measure(prepared, index, f, ticks, (size / gain, 0.0)) - alone
        by_load = _measure(prepared, index, f, ticks, (0.0, size)) - alone
        P = by_reference[0] / by_reference[1]
        C = -by_load[1] / by_load[0]
        points.append((f, complex(P), complex(C)))
        if progress is not None:
            progress((done + 1) / len(frequency))
    columns = list(zip(*points, strict=True))
    return FrequencyResponse(np.array(columns[0]), np.array(columns[1]), np.array(columns[2]))


def _duration(frequency: float, pitch: float) -> float:
    """Return how long to measure at a frequency, Hz, where a pole pitch takes `pitch`, s."""
    least = max(_LEAST, _LEAST_CYCLES / frequency)
    return math.ceil(least / pitch) * pitch if pitch <= _PITCH_MOST else least


def _moving(scenario: Scenario, variant: str, axis: str, v: float, ticks: int) -> Prepared:
    """Return one variant, moving at constant velocity through mid-stroke while it is measured."""
    duration = (_SETTLING + ticks) * CONTROL_PERIOD + _EASE
    velocity = {"x": 0.0, "y": 0.0} | {axis: v}
    start = {"x": 0.0, "y": 0.0} | {axis: -0.5 * v * duration}
    document = scenario.model_dump(mode="json")
    document["variants"] = {variant: document["variants"][variant]}
    changes = {
        "trajectory": {
            "kind": "ramp",
            "start": start,
            "velocity": velocity,
            "lead_in": _EASE,
            "duration": duration,
        },
        "schedule": [],
        "window": None,
        "load": {},
    }
    return prepare(validate(apply_changes(document, changes)))


def _measure(
    prepared: Prepared,
    axis: int,
    frequency: float,
    ticks: int,
    sines: tuple[float, float] = (0.0, 0.0),
) -> Complex:
    """Return position and force command at one frequency, m and N, as complex amplitudes, (2,).

    `sines` are the amplitudes of what is added to the reference and to the load, m and N.
    """
    reference, load = sines
    base = prepared.reference
    w = 2.0 * math.pi * frequency
    time = np.arange(base.ticks) * CONTROL_PERIOD
    position, velocity, acceleration = (
        column.copy() for column in (base.position, base.velocity, base.acceleration)
    )
    position[:, axis] += reference * np.sin(w * time)
    velocity[:, axis] += reference * w * np.cos(w * time)
    acceleration[:, axis] -= reference * w**2 * np.sin(w * time)
    pushed = prepared.load.copy()
    pushed[:, axis] += load * np.sin(w * time)
    shaken = dataclasses.replace(
        base, position=position, velocity=velocity, acceleration=acceleration
    )
    recording = run(dataclasses.replace(prepared, reference=shaken, load=pushed))
    (record,) = recording.variants.values()
    if record.diverged is not None:
        raise ConfigError(
            FieldError(
                loc=f"frequency of {frequency:g} Hz",
                message=f"the loop diverges at {record.diverged.time:g} s of its measurement",
            )
        )
    here = slice(base.ticks - ticks, base.ticks)
    name = "xy"[axis]
    # Not the recorded position: as float32 it is good to 7 nm, the error of a few um to less.
    error = record.channel("following_error", name)[here]
    moved = position[here, axis] - base.position[here, axis] - error
    command = record.channel("force_command", name)[here].astype(np.float64)
    turning = np.exp(-1j * w * time[here]) * (2.0 / ticks)
    return np.array([(moved * turning).sum(), (command * turning).sum()])
