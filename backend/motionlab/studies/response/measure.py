"""The frequency response of a simulated motor, measured while it slides.

At rest a measurement sees the bristles, not the machine: so the axis slides to and fro, at a
constant velocity. The thrust of a command depends on the place in the pole pitch, which makes
sidebands of every line, and the encoder errs over the period of its scale: in the periods of a
slide both have whole turns, but not in each period, so that they cancel in the mean. The multisine
is added to the reference, as it can be on any machine; what the controller makes of it excites the
motor, and the response is that from force command to measured position.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterable, Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from motionlab.config.load import load_scenario
from motionlab.config.multisine import Signal
from motionlab.config.scenario import Scenario
from motionlab.errors import ConfigError, FieldError
from motionlab.kernel.force_maps import pole_pitch
from motionlab.loop.lane_plant import sliding_force
from motionlab.loop.linearise import Loop, linearise, parameters
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
from motionlab.studies.response.controller_check import with_own_margins
from motionlab.studies.response.documents import (
    Crossing,
    HalfForce,
    MarginInterval,
    MeasuredPlant,
    MeasuredResponse,
    ResponseRequest,
)
from motionlab.studies.response.estimate import Estimate, Quiet, Slides, estimate
from motionlab.studies.response.fitted import NO_MODEL, fitted_plant
from motionlab.studies.response.margins import (
    NAMES,
    crossings,
    far_apart,
    intervals,
    measured_margins,
    own_margins,
    refined,
)
from motionlab.studies.response.recorded import (
    COHERENT,
    LINES_MIN,
    RecordedEstimate,
    RecordedPlan,
    coherent_lines,
    estimate_recorded,
    plan_recorded,
)
from motionlab.studies.study import Source
from motionlab.timing import CONTROL_PERIOD
from motionlab.trajectories.multisine import Lines, excitation

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Progress = Callable[[float, MeasuredResponse | None], None]
_Part = tuple[Complex, Complex, Complex, bool]
"""Excitation, command and position at the lines of a slide, and whether it went forward."""

PERIODS = (2, 5)
"""Least and most periods of a slide: sidebands up to the fourth cancel over five."""
SLIDES_MIN = 5
"""Two more than directions, and one to tell how they scatter."""
_FURTHER, _SMALLER = 2, 0.5  # one in each direction, and its share of the force
_STROKE = 0.95  # share of the stroke that slides use
_MODULATION = 0.1  # rms of the velocity's change at one line, over that of the slide, for all lines
_PILOT = 0.2  # of the force, of the slide by which the reference is sized
_LEAST = 0.02  # share of the force that a line has at least in that slide
_NEIGHBOURS = 15
_CORNER = 250.0  # Hz, above which the force grows, since noise hides what answers it
_GROWTH = 1.5  # its power of frequency there
_SLOWEST = 0.5  # share of the slowest slide that is taken for it
_FORCE = 0.9, 0.5  # of the sliding friction, and N at least
_SIGNIFICANT = 6
_NORMAL = 1.96
_MISFIT = 3.0  # from which a model has no terms for what was measured
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
        Of the slides, m/s: whole pole pitches and periods of the encoder in a slide, no whole ones
        in a period.
    force, friction : float
        Of the signal, RMS, and that which the slide overcomes, N.
    periods, slides : int
        Periods that are measured in a slide, and slides.
    """

    request: ResponseRequest
    scenario: Scenario
    variant: str
    loop: Loop
    lines: Lines
    velocity: float
    force: float
    friction: float
    periods: int
    slides: int

    @property
    def further(self) -> int:
        """Slides with half of the force, which do not count for the response."""
        return 0 if self.request.signal == "stepped-sine" else _FURTHER

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
        If the stroke is too short for two periods at the velocity, the velocity too low for whole
        pole pitches, or the time too short for the slides that an interval takes; if the loop has
        no linearisation; as `plan_recorded`.
    """
    if request.run is not None:
        return plan_recorded(request, source)
    scenario = load_scenario(request.scenario if source is None else source, request.set)
    variant = request.chosen(scenario)
    plant = getattr(scenario.plant, request.axis)
    ticks = round(1.0 / (request.low * CONTROL_PERIOD))
    period, velocity = ticks * CONTROL_PERIOD, request.velocity
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
    turns = pole_pitch(plant.force_map), plant.encoder.sde_period
    least_velocity = _SLOWEST * _rounded(0.0, period, turns, periods)
    if velocity < least_velocity:
        message = "is too slow: a slide takes whole pole pitches"
        raise ConfigError(
            FieldError("velocity", message, velocity, f">= {_up(least_velocity):g}", "m/s")
        )
    velocity = _rounded(velocity, period, turns, periods)
    slide = around + periods * period
    lines = Lines.of(request.signal, request.low, request.high, request.lines, ticks)
    slides = int(request.seconds / slide)
    least = 2 * len(lines.cycles) if request.signal == "stepped-sine" else SLIDES_MIN
    if slides < least:
        message = f"is too short: {least} slides of {slide:.3g} s are needed"
        raise ConfigError(
            FieldError("seconds", message, request.seconds, f">= {math.ceil(least * slide)}", "s")
        )
    loop = linearise(scenario, variant, request.axis, v=velocity)
    friction = sliding_force(parameters(scenario, variant, request.axis).friction, velocity)
    force, (share, at_least) = request.force, _FORCE
    if force is None:
        force = max(at_least, share * float(friction))
    return ResponsePlan(
        request,
        scenario,
        variant,
        loop,
        lines,
        velocity,
        force,
        float(friction),
        periods,
        slides,
    )


def _rounded(velocity: float, period: float, turns: Iterable[float], periods: int) -> float:
    """Return a velocity whose slides take whole `turns`, m/s: of 0 the slowest."""
    for turn in turns:
        velocity = _turned(velocity * period, turn, periods) / period
    return velocity


def _up(value: float) -> float:
    """Return a bound to three digits that is none too low."""
    unit = 10.0 ** (math.floor(math.log10(value)) - 2)
    return math.ceil(value / unit) * unit


def _turned(distance: float, turn: float, periods: int) -> float:
    """Return a distance of a period with whole turns in `periods`, in no fewer."""
    whole = round(distance * periods / turn)
    nearest = (whole + sign * step for step in range(periods + 1) for sign in (1, -1))
    return next(n for n in nearest if n > 0 and math.gcd(n, periods) == 1) * turn / periods


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
        If the loop diverges, a force or current reaches its limit, or fewer than `LINES_MIN`
        frequencies are coherent.
    """
    if isinstance(planned, RecordedPlan):
        measured = estimate_recorded(planned)
        alike = planned.request.model_copy(update={"variant": planned.variant})
        linearised = response(alike, planned.scenario, v=measured.velocity)
        return _document(planned, measured, linearised, whole=True)
    linearised = response(planned.request, planned.scenario, v=planned.velocity)
    quiet, slides = _slides(planned)
    parts: list[_Part] = []
    for part in slides:
        parts.append(part)
        if progress is not None:
            enough = SLIDES_MIN <= len(parts) < planned.slides
            partial = _result(planned, quiet, parts, linearised) if enough else None
            progress(len(parts) / (planned.slides + planned.further), partial)
    return _result(planned, quiet, parts, linearised)


def _forces(planned: ResponsePlan) -> Array:
    """Return the size of each line of the force, N.

    It is even up to the corner, and grows from there, but for low frequencies, where that would
    change the velocity of the slide too much: friction is to be seen about one velocity.
    """
    f, share = planned.lines.frequency, math.sqrt(2.0) * planned.lines.share
    shape = np.maximum(1.0, f / _CORNER) ** _GROWTH
    force = planned.force * share * shape / np.linalg.norm(planned.lines.share * shape)
    most = _MODULATION * planned.velocity * share
    return np.minimum(force, most / np.abs(2.0 * np.pi * f * planned.loop.plant.response(f)))


def _slides(planned: ResponsePlan) -> tuple[Quiet, Iterator[_Part]]:
    """Return what a slide without a multisine shows, and the slides with one.

    What a controller makes of a reference depends on its law: a slide with a part of the force
    tells how large each line of the reference has to be. Neither of these two is counted, nor are
    those that follow with half of the force.
    """
    f, forces = planned.lines.frequency, _forces(planned)
    rng = np.random.default_rng(planned.request.seed)

    def slid(reference: Complex, *, forward: bool) -> Array:
        return _slide(planned, reference, int(rng.integers(2**31)), forward=forward)

    def part(size: Array, number: int, signal: Signal) -> _Part:
        reference, forward = excitation(signal, planned.lines, size, number, rng), number % 2 == 0
        command, position = map(planned.lines.amplitudes, slid(reference, forward=forward))
        return reference, command, position, forward

    silent = slid(np.zeros(len(f), dtype=np.complex128), forward=True)
    quiet = Quiet.about(planned.lines.cycles * planned.periods, *silent)
    controller, L = planned.loop.controller.response(f), planned.loop.open(f)
    size = _PILOT * forces * np.abs((1.0 + L) / controller)
    _, command, _, _ = part(size, 1, "multisine")
    became = np.abs(command.mean(axis=0)) / forces
    if planned.lines.every:  # too many for a line to tell much by itself
        became = median_filter(became, _NEIGHBOURS, mode="nearest")
    size /= np.maximum(became, _LEAST)
    signal = planned.request.signal
    share = np.repeat([1.0, _SMALLER], [planned.slides, planned.further])
    return quiet, (part(share[k] * size, k, signal) for k in range(len(share)))


def _slide(planned: ResponsePlan, reference: Complex, seed: int, *, forward: bool) -> Array:
    """Return force commands, N, and positions, m, of the measured ticks, less the slide."""
    axis, lines = "xy".index(planned.request.axis), planned.lines
    measured = planned.periods * lines.ticks
    velocity = planned.velocity if forward else -planned.velocity
    scenario = planned.scenario.model_copy(update={"seed": seed})
    prepared = moving(scenario, planned.variant, planned.request.axis, velocity, measured)
    base = prepared.reference
    phase = (np.arange(base.ticks) - base.ticks) % lines.ticks
    shaken: dict[str, Array] = {}
    for name, period in zip(
        ("position", "velocity", "acceleration"), lines.motion(reference), strict=True
    ):
        column = getattr(base, name).copy()
        column[:, axis] += period[phase]
        shaken[name] = column
    recording = run(dataclasses.replace(prepared, reference=dataclasses.replace(base, **shaken)))
    (record,) = recording.variants.values()
    if record.diverged is not None:
        raise ConfigError(
            FieldError("force", "is too much: the loop diverges", planned.force, unit="N")
        )
    here = slice(base.ticks - measured, base.ticks)
    name = planned.request.axis
    if any(record.channel(each, name)[here].any() for each in _LIMITED):
        message = "is too much: command or currents reach their limit"
        raise ConfigError(FieldError("force", message, planned.force, unit="N"))
    # Not the recorded position: as float32 it is good to 7 nm, the error of a few um to less.
    error = record.channel("following_error", name)[here].astype(np.float64)
    position = shaken["position"][here, axis] - base.position[here, axis] - error
    return np.stack([record.channel("force_command", name)[here].astype(np.float64), position])


def _result(
    planned: ResponsePlan, quiet: Quiet, parts: list[_Part], linearised: ResponseDocument
) -> MeasuredResponse:
    """Return the response after some slides; the intervals of margins after the last."""
    R, U, Y, forward = (np.array(each) for each in zip(*parts, strict=True))
    lines, whole = planned.lines, len(parts) == planned.slides + planned.further
    # A stepped sine comes to its lines one after another.
    reported = [each for each in lines.reported(planned.request.lines) if R[:, each[0]].any()]
    if not reported:  # less than a number can be
        message = "is too small: nothing is shaken"
        raise ConfigError(FieldError("force", message, planned.force, unit="N"))
    frequency = lines.frequency[[k for k, _ in reported]]
    smaller = np.arange(len(parts)) >= planned.slides if planned.further and whole else None
    of_plant = estimate(Slides(R, U, Y, forward, quiet, smaller), reported)
    slides = min(len(parts), planned.slides)
    if whole:
        count = len(frequency)
        frequency, of_plant = coherent_lines(frequency, of_plant)
        if len(frequency) < LINES_MIN:
            message = (
                f"is too small: the coherence reaches {COHERENT:g} at {len(frequency)} of {count} "
                f"frequencies, {LINES_MIN} are needed"
            )
            raise ConfigError(FieldError("force", message, planned.force, unit="N"))
    return _document(
        planned,
        RecordedEstimate(
            frequency,
            of_plant,
            planned.loop,
            planned.velocity,
            slides,
            planned.periods,
            planned.seconds * slides / planned.slides,
            _changing_sign(planned),
        ),
        linearised,
        whole=whole,
    )


def _changing_sign(planned: ResponsePlan) -> tuple[str, ...]:
    """Return a note where the force is more than the friction that the slide overcomes."""
    if planned.force <= planned.friction or planned.scenario.plant.force == "ideal":
        return ()
    return (
        f"the command keeps changing its sign, since a force of {planned.force:.3g} N RMS is more "
        f"than the friction of {round(planned.friction, 6):.3g} N: phases hand over and currents "
        "lag behind, so the response is that for this force",
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
    L = of_plant.response * controller
    spread, fitted, notes = dict.fromkeys(NAMES), None, list(measured.warnings)
    if whole:
        period = CONTROL_PERIOD if isinstance(planned, ResponsePlan) else planned.run.period
        fitted = fitted_plant(request, planned.variant, measured, period)
        if fitted is None:
            notes.append(NO_MODEL)
        elif fitted.misfit > _MISFIT:
            notes.append(
                f"the fitted model misses the plant by {fitted.misfit:.2g} times its standard "
                "deviation, so its values are off by more than their errors"
            )
        notes += far_apart(f, L)
    fine, P, deviation = refined(f, of_plant.response, of_plant.deviation, fitted)
    C = loop.controller.response(fine)
    if whole:
        lines = np.isin(fine, f)
        spread = intervals(
            fine, C * P, np.abs(C) * deviation, request.seed, of_plant.smaller, lines
        )
    here, there = measured_margins(fine, C * P), measured_margins(fine, loop.open(fine))
    own = None
    if measured.own_loop is not None and len(measured.own_loop[0]) >= LINES_MIN:
        own = own_margins(measured.own_loop, f, fine, C * P, request.seed)
        notes = with_own_margins(notes, own)
    return MeasuredResponse(
        **loop_table(request, planned.variant, measured.velocity, f, L),
        linearised=linearised,
        plant=_measured(of_plant),
        linearised_plant=loop_curve(loop.plant.response(f)),
        margins={
            name: MarginInterval(value=here[name], interval=spread[name], model=there[name])
            for name in NAMES
        },
        own_margins=own,
        half_force=_half_force(of_plant),
        crossings=[Crossing(frequency=f, phase_margin=m) for f, m in crossings(fine, C * P)],
        fitted=fitted,
        run=request.run,
        slides=measured.slides,
        periods=measured.periods,
        seconds=measured.seconds,
        warnings=notes,
    )


def _half_force(of_plant: Estimate) -> HalfForce | None:
    smaller = of_plant.smaller
    if smaller is None:
        return None
    gain, phase = abs(smaller.ratio), float(np.angle(smaller.ratio))
    half = float(_NORMAL * smaller.error / np.sqrt(2.0))
    return HalfForce(gain=gain, phase=phase, interval=half)


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
