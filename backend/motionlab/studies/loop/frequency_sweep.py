"""Frequency responses of the loop: linearised, and measured by a sweep of the simulation.

Under stiction a sweep at rest measures the stuck machine, so the axis moves at constant velocity,
over whole pole pitches, since the gain changes along them. Two runs at each frequency give what one
cannot: with a sine on the reference, ``P = p/f`` from force command to position; with a sine on the
load, ``C = -f/p`` of the feedback. The open loop is L = C P. From both a third run, the motion
alone, is subtracted: if the controller's map is off, its ripple lies at any frequency.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field

from motionlab.config.changes import apply_changes
from motionlab.config.load import load_scenario, validate
from motionlab.config.plant import OURS
from motionlab.config.quantity import quantity, si
from motionlab.config.scenario import Scenario
from motionlab.errors import ConfigError, FieldError
from motionlab.kernel.force_maps import pole_pitch
from motionlab.loop.linearise import linearise
from motionlab.loop.margins import NYQUIST, sampled
from motionlab.simulation.prepare import Prepared, prepare
from motionlab.simulation.run import run
from motionlab.studies.study import Source
from motionlab.studies.tune.documents import AxisRequest, read_request
from motionlab.timing import CONTROL_PERIOD, to_ticks

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

SETTLING = to_ticks(0.5)
"""Ticks before a measurement, after the axis has come to speed."""
_LEAST, _LEAST_CYCLES = 0.5, 8
"""What a measurement takes at least, s and cycles."""
_PITCH_MOST = 4.0
"""Longest time for a pole pitch that a measurement is rounded up to whole pitches for, s."""
_MODULATION = 0.1
"""Share of the slow velocity that a sine may add to it, so that friction sees small signals."""
EASE = 0.2
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
    for done, f_target in enumerate(frequency):
        cycles = round(_duration(f_target, pitch) * f_target)
        ticks = round(cycles / f_target / CONTROL_PERIOD)
        f = cycles / (ticks * CONTROL_PERIOD)
        prepared = moving(scenario, variant, axis, v, ticks)
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
    """Return the measuring time at a frequency, Hz, where a pole pitch takes `pitch`, s."""
    least = max(_LEAST, _LEAST_CYCLES / frequency)
    return math.ceil(least / pitch) * pitch if pitch <= _PITCH_MOST else least


def moving(scenario: Scenario, variant: str, axis: str, v: float, ticks: int) -> Prepared:
    """Return one variant, moving at constant velocity through mid-stroke while it is measured."""
    duration = (SETTLING + ticks) * CONTROL_PERIOD + EASE
    velocity = {"x": 0.0, "y": 0.0} | {axis: v}
    start = {"x": 0.0, "y": 0.0} | {axis: -0.5 * v * duration}
    document = scenario.model_dump(mode="json")
    document["variants"] = {variant: document["variants"][variant]}
    changes = {
        "learnt": None,
        "trajectory": {
            "kind": "ramp",
            "start": start,
            "velocity": velocity,
            "lead_in": EASE,
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


Progress = Callable[[float, "FrequencySweepDocument | None"], None]

SWEPT = tuple(float(f"{f:.3g}") for f in np.geomspace(4.0, 400.0, 16))
"""Frequencies of a sweep, Hz."""

_Frequency = Annotated[float, Field(ge=1.0, le=0.9 * NYQUIST)]


class _Document(BaseModel):
    model_config = ConfigDict(extra="forbid")


class FrequencySweepRequest(AxisRequest):
    """Request of a frequency sweep."""

    frequencies: Annotated[
        tuple[_Frequency, ...], Field(strict=False, min_length=1, max_length=100)
    ] = quantity("Frequencies", unit="Hz", source=OURS, default=SWEPT)
    velocity: float = quantity(
        "Velocity of the slow motion that goes on meanwhile",
        unit="m/s",
        source=f"{OURS}: at rest a sweep measures the stuck machine",
        default=0.02,
        gt=0,
        le=0.2,
    )


def loaded(request: Mapping[str, Any]) -> tuple[AxisRequest, Scenario]:
    """Return a checked request and its scenario, which has the requested variant."""
    checked = read_request(AxisRequest, request)
    scenario = load_scenario(checked.scenario, checked.set)
    checked.chosen(scenario)
    return checked, scenario


class LoopCurve(_Document):
    """A frequency response."""

    magnitude: list[float] = si("Absolute value", "1")
    phase: list[float] = si("Argument, unwrapped from the lowest frequency on", "rad")


class ResponseDocument(_Document):
    """The linearised loop of one axis over frequency, while it slides at one velocity."""

    variant: str
    axis: str
    velocity: float = si("Sliding velocity", "m/s")
    frequency: list[float] = si("Frequencies", "Hz")
    open: LoopCurve = Field(description="L = C P")
    closed: LoopCurve = Field(description="T = L/(1 + L)")
    sensitivity: LoopCurve = Field(description="S = 1/(1 + L)")


class FrequencySweepDocument(ResponseDocument):
    """The loop of one axis by a frequency sweep of the simulation, or part of it."""

    linearised: ResponseDocument = Field(description="The same loop, linearised at that velocity")


def response(request: AxisRequest, scenario: Scenario, *, v: float) -> ResponseDocument:
    """Return the linearised loop of one axis.

    Parameters
    ----------
    request : AxisRequest
        Which variant and axis.
    scenario : Scenario
        As loaded from it.
    v : float
        Sliding velocity, m/s.

    Raises
    ------
    ConfigError
        For the law ``published-k``, which has no linearisation.
    """
    variant = request.chosen(scenario)
    frequency, L = sampled(linearise(scenario, variant, request.axis, v=v).open)
    return ResponseDocument(**loop_table(request, variant, v, frequency, L))


def plan(
    request: FrequencySweepRequest, source: Source | None = None
) -> tuple[FrequencySweepRequest, Scenario]:
    """Return a request and its scenario, which has a linearisation."""
    scenario = load_scenario(request.scenario if source is None else source, request.set)
    linearise(scenario, request.chosen(scenario), request.axis, v=request.velocity)
    return request, scenario


def swept(
    planned: tuple[FrequencySweepRequest, Scenario], progress: Progress | None = None
) -> FrequencySweepDocument:
    """Return the loop of one axis by a frequency sweep of the simulation.

    Parameters
    ----------
    planned : tuple of FrequencySweepRequest and Scenario
        From `plan`.
    progress : callable, optional
        Called with the share done and the points so far.

    Raises
    ------
    ConfigError
        If a measurement would leave the stroke or the loop diverges.
    """
    request, scenario = planned
    variant = request.chosen(scenario)
    linearised = response(request, scenario, v=request.velocity)
    frequencies = sorted(request.frequencies)
    frequency: list[float] = []
    L: list[complex] = []
    for done, f in enumerate(frequencies):
        measured = frequency_sweep(scenario, variant, request.axis, [f], v=request.velocity)
        frequency += measured.frequency.tolist()
        L += measured.open.tolist()
        if progress is not None:
            so_far = loop_table(
                request, variant, request.velocity, np.array(frequency), np.array(L)
            )
            progress(
                (done + 1) / len(frequencies),
                FrequencySweepDocument(**so_far, linearised=linearised),
            )
    made = loop_table(request, variant, request.velocity, np.array(frequency), np.array(L))
    return FrequencySweepDocument(**made, linearised=linearised)


def loop_table(
    request: AxisRequest, variant: str, v: float, frequency: NDArray[np.float64], L: Complex
) -> dict[str, Any]:
    """Return the fields of `ResponseDocument` of a loop whose open loop is L."""
    return {
        "variant": variant,
        "axis": request.axis,
        "velocity": v,
        "frequency": _figures(frequency),
        "open": loop_curve(L),
        "closed": loop_curve(L / (1.0 + L)),
        "sensitivity": loop_curve(1.0 / (1.0 + L)),
    }


def loop_curve(values: Complex) -> LoopCurve:
    """Return a frequency response, its phase unwrapped."""
    phase = np.unwrap(np.angle(values))
    # An open loop begins at -180 degrees, with integral action at -270; a turn above, it would be
    # compared with others amiss. A closed one begins about 0.
    phase -= 2.0 * np.pi * np.round((phase[0] + 0.75 * np.pi) / (2.0 * np.pi))
    return LoopCurve(magnitude=_figures(np.abs(values)), phase=_figures(phase))


def _figures(values: NDArray[np.float64]) -> list[float]:
    return [float(f"{value:.6g}") for value in values]
