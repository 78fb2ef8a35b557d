"""The frequency response of a simulated motor, measured while it slides.

At rest a measurement sees the bristles, not the machine, and the thrust of a command depends on the
place in the pole pitch: so the axis slides to and fro at a constant velocity, over whole pitches in
a period. The multisine is added to the reference, as it can be on any machine; what the controller
makes of it excites the motor, and the response is that from force command to measured position.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from motionlab.config.load import load_scenario
from motionlab.config.scenario import Scenario
from motionlab.errors import ConfigError, FieldError
from motionlab.kernel.force_maps import pole_pitch
from motionlab.loop.linearise import Loop, linearise
from motionlab.simulation.run import run
from motionlab.studies.loop.frequency_sweep import (
    EASE,
    SETTLING,
    ResponseDocument,
    loop_curve,
    loop_table,
    moving,
    response,
)
from motionlab.studies.response.documents import (
    MarginInterval,
    MeasuredPlant,
    MeasuredResponse,
    ResponseRequest,
)
from motionlab.studies.response.estimate import Estimate, Slides, estimate
from motionlab.studies.response.fitted import fitted_plant
from motionlab.studies.response.margins import NAMES, intervals, measured_margins
from motionlab.studies.response.recorded import (
    RecordedEstimate,
    RecordedPlan,
    estimate_recorded,
    plan_recorded,
)
from motionlab.studies.study import Source
from motionlab.timing import CONTROL_PERIOD
from motionlab.trajectories.multisine import Lines

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Progress = Callable[[float, MeasuredResponse | None], None]
_Part = tuple[Complex, Complex, Complex, bool]
"""Excitation, command and position at the lines of a slide, and whether it went forward."""

PERIODS = (2, 8)
"""Least and most periods of a slide."""
SLIDES_MIN = 5
"""Two more than directions, and one to tell how they scatter."""
_STROKE = 0.95  # share of the stroke that slides use
_MODULATION = 0.1  # rms of the velocity's change at one line, over that of the slide, for all lines
_PILOT = 0.2  # of the force, of the slide by which the reference is sized
_LEAST = 0.02  # share of the force that a line has at least in that slide
_SIGNIFICANT = 6
_LIMITED = ("force_saturated", "current_saturated")


@dataclasses.dataclass(frozen=True)
class ResponsePlan:
    """A measurement that has passed every check.

    Attributes
    ----------
    request : ResponseRequest
        As validated.
    scenario : Scenario
        Motor and controllers.
    variant : str
        Whose loop is closed meanwhile.
    loop : Loop
        The same loop, linearised at `velocity`.
    lines : Lines
        Frequencies.
    velocity : float
        Of the slides, m/s: whole pole pitches in a period.
    periods, slides : int
        Periods that are measured in a slide, and slides.
    """

    request: ResponseRequest
    scenario: Scenario
    variant: str
    loop: Loop
    lines: Lines
    velocity: float
    periods: int
    slides: int

    @property
    def seconds(self) -> float:
        """Simulated time, s."""
        ticks = SETTLING + self.periods * self.lines.ticks
        return self.slides * (ticks * CONTROL_PERIOD + EASE)


def plan(request: ResponseRequest, source: Source | None = None) -> ResponsePlan | RecordedPlan:
    """Return the slides of a measurement, or what is read of a run.

    Raises
    ------
    ConfigError
        If the stroke is too short for two periods at the velocity, or the time for the slides that
        an interval takes; if the loop has no linearisation; as `plan_recorded`.
    """
    if request.run is not None:
        return plan_recorded(request, source)
    scenario = load_scenario(request.scenario if source is None else source, request.set)
    variant = request.chosen(scenario)
    plant = getattr(scenario.plant, request.axis)
    ticks = round(1.0 / (request.low * CONTROL_PERIOD))
    period, pitch = ticks * CONTROL_PERIOD, pole_pitch(plant.force_map)
    velocity = max(1, round(request.velocity * period / pitch)) * pitch / period
    around = SETTLING * CONTROL_PERIOD + EASE
    fit = int((2.0 * _STROKE * plant.stroke / velocity - around) / period)
    if fit < PERIODS[0]:
        longest = 2.0 * _STROKE * plant.stroke / (PERIODS[0] * period + around)
        raise ConfigError(
            FieldError(
                "velocity",
                f"leaves the stroke within {PERIODS[0]} periods of {period:g} s; slide slower, or "
                "begin at a higher frequency",
                velocity,
                f"<= {longest:.3g}",
                "m/s",
            )
        )
    periods = min(fit, PERIODS[1])
    slide = around + periods * period
    slides = int(request.seconds / slide)
    if slides < SLIDES_MIN:
        message = f"is too short: {SLIDES_MIN} slides of {slide:.3g} s are needed"
        raise ConfigError(
            FieldError("seconds", message, request.seconds, f">= {SLIDES_MIN * slide:.3g}", "s")
        )
    loop = linearise(scenario, variant, request.axis, v=velocity)
    lines = Lines.between(request.low, request.high, request.lines, ticks)
    return ResponsePlan(request, scenario, variant, loop, lines, velocity, periods, slides)


def measure(
    planned: ResponsePlan | RecordedPlan, progress: Progress | None = None
) -> MeasuredResponse:
    """Carry the slides out, and estimate the response.

    Parameters
    ----------
    planned : ResponsePlan
        From `plan`.
    progress : callable, optional
        Takes the share done and the response so far; what it raises ends the measurement.

    Raises
    ------
    ConfigError
        If the loop diverges, or a force or current reaches its limit.
    """
    if isinstance(planned, RecordedPlan):
        measured = estimate_recorded(planned)
        alike = planned.request.model_copy(update={"variant": planned.variant})
        linearised = response(alike, planned.scenario, v=measured.velocity)
        return _document(planned, measured, linearised, whole=True)
    linearised = response(planned.request, planned.scenario, v=planned.velocity)
    parts: list[_Part] = []
    for part in _slides(planned):
        parts.append(part)
        if progress is not None:
            partial = _result(planned, parts, linearised) if len(parts) >= SLIDES_MIN else None
            progress(len(parts) / planned.slides, partial)
    return _result(planned, parts, linearised)


def _forces(planned: ResponsePlan) -> Array:
    """Return the size of each line of the force, N.

    It is spread evenly over the lines, except where that would change the velocity of the slide
    too much: friction is to be seen about one velocity.
    """
    f, count = planned.lines.frequency, len(planned.lines.cycles)
    force = np.full(count, planned.request.force * math.sqrt(2.0 / count))
    most = _MODULATION * planned.velocity * math.sqrt(2.0 / count)
    return np.minimum(force, most / np.abs(2.0 * np.pi * f * planned.loop.plant.response(f)))


def _slides(planned: ResponsePlan) -> Iterator[_Part]:
    """Yield excitation, commands and positions at the lines of each slide, and its direction.

    What a controller makes of a reference depends on its law: a slide with a part of the force,
    which is not counted, tells how large each line of the reference has to be.
    """
    f, forces = planned.lines.frequency, _forces(planned)
    rng = np.random.default_rng(planned.request.seed)

    def slid(size: Array, *, forward: bool) -> _Part:
        phases = np.exp(2j * np.pi * rng.random(len(size)))
        excitation = np.asarray(size * phases, dtype=np.complex128)
        return excitation, *_slide(planned, excitation, forward=forward), forward

    controller, L = planned.loop.controller.response(f), planned.loop.open(f)
    size = _PILOT * forces * np.abs((1.0 + L) / controller)
    _, command, _, _ = slid(size, forward=False)
    size *= forces / np.maximum(np.abs(command.mean(axis=0)), _LEAST * forces)
    for number in range(planned.slides):
        yield slid(size, forward=number % 2 == 0)


def _slide(planned: ResponsePlan, excitation: Complex, *, forward: bool) -> tuple[Complex, Complex]:
    """Return force commands, N, and positions, m, at the lines, each (periods, lines)."""
    axis, lines = "xy".index(planned.request.axis), planned.lines
    measured = planned.periods * lines.ticks
    velocity = planned.velocity if forward else -planned.velocity
    prepared = moving(planned.scenario, planned.variant, planned.request.axis, velocity, measured)
    base = prepared.reference
    phase = (np.arange(base.ticks) - base.ticks) % lines.ticks
    shaken: dict[str, Array] = {}
    for name, period in zip(
        ("position", "velocity", "acceleration"), lines.motion(excitation), strict=True
    ):
        column = getattr(base, name).copy()
        column[:, axis] += period[phase]
        shaken[name] = column
    recording = run(dataclasses.replace(prepared, reference=dataclasses.replace(base, **shaken)))
    (record,) = recording.variants.values()
    if record.diverged is not None:
        raise ConfigError(
            FieldError("force", "is too much: the loop diverges", planned.request.force)
        )
    here = slice(base.ticks - measured, base.ticks)
    name = planned.request.axis
    if any(record.channel(each, name)[here].any() for each in _LIMITED):
        message = "is too much: command or currents reach their limit"
        raise ConfigError(FieldError("force", message, planned.request.force, unit="N"))
    # Not the recorded position: as float32 it is good to 7 nm, the error of a few um to less.
    error = record.channel("following_error", name)[here].astype(np.float64)
    position = shaken["position"][here, axis] - base.position[here, axis] - error
    command = record.channel("force_command", name)[here].astype(np.float64)
    return lines.amplitudes(command), lines.amplitudes(position)


def _result(
    planned: ResponsePlan, parts: list[_Part], linearised: ResponseDocument
) -> MeasuredResponse:
    """Return the response after some slides; the intervals of margins after the last."""
    excitation, command, position, forward = (np.array(each) for each in zip(*parts, strict=True))
    return _document(
        planned,
        RecordedEstimate(
            planned.lines.frequency,
            estimate(Slides(excitation, command, position, forward)),
            planned.loop,
            planned.velocity,
            len(parts),
            planned.periods,
            planned.seconds * len(parts) / planned.slides,
        ),
        linearised,
        whole=len(parts) == planned.slides,
    )


def _document(
    planned: ResponsePlan | RecordedPlan,
    measured: RecordedEstimate,
    linearised: ResponseDocument,
    *,
    whole: bool,
) -> MeasuredResponse:
    request, loop, f = planned.request, measured.loop, measured.frequency
    measured = dataclasses.replace(measured, of_plant=_of_acting_force(planned, measured))
    of_plant = measured.of_plant
    controller = loop.controller.response(f)
    L, model = of_plant.response * controller, loop.open(f)
    spread, fitted = dict.fromkeys(NAMES), None
    if whole:
        period = CONTROL_PERIOD if isinstance(planned, ResponsePlan) else planned.run.period
        fitted = fitted_plant(request, planned.variant, measured, period)
        spread = intervals(f, L, of_plant.deviation * np.abs(controller), request.seed)
    here, there = measured_margins(f, L), measured_margins(f, model)
    return MeasuredResponse(
        **loop_table(request, planned.variant, measured.velocity, f, L),
        linearised=linearised,
        plant=_measured(of_plant),
        linearised_plant=loop_curve(loop.plant.response(f)),
        margins={
            name: MarginInterval(value=here[name], interval=spread[name], model=there[name])
            for name in NAMES
        },
        fitted=fitted,
        run=request.run,
        slides=measured.slides,
        periods=measured.periods,
        seconds=measured.seconds,
        warnings=list(measured.warnings),
    )


def _of_acting_force(planned: ResponsePlan | RecordedPlan, measured: RecordedEstimate) -> Estimate:
    """Return the response to the force that acts, where the lab's controller sends it late.

    Its delay belongs to the controller, whose response has it already.
    """
    of_plant = measured.of_plant
    if isinstance(planned, RecordedPlan) and not planned.own:
        return of_plant
    periods = planned.scenario.variants[planned.variant].controller.delay
    turned = np.exp(2j * np.pi * measured.frequency * periods * CONTROL_PERIOD)
    return dataclasses.replace(of_plant, response=of_plant.response * turned)


def _measured(of_plant: Estimate) -> MeasuredPlant:
    curve, size = loop_curve(of_plant.response), np.abs(of_plant.response)
    distortion = np.sqrt(np.maximum(0.0, of_plant.deviation**2 - of_plant.noise**2))
    return MeasuredPlant(
        magnitude=curve.magnitude,
        phase=curve.phase,
        interval=_short(of_plant.half_width / size),
        noise=_short(of_plant.noise / size),
        distortion=_short(distortion / size),
        coherence=_short(of_plant.coherence),
    )


def _short(values: Array) -> list[float]:
    return [float(f"{value:.{_SIGNIFICANT}g}") for value in values]
