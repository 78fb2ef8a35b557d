"""A frequency response from a kept run: a multisine that it followed, or whatever excited it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motionlab.analysis.columns import Columns
from motionlab.config.load import load_scenario
from motionlab.config.multisine import Multisine
from motionlab.config.scenario import Scenario
from motionlab.errors import ConfigError, FieldError
from motionlab.library.columns import of_run
from motionlab.library.run import RunDetail
from motionlab.loop.linearise import Loop, linearise
from motionlab.studies.identify.record.force import CLIPPED, share_at_largest
from motionlab.studies.minute.recorded import scenario_at
from motionlab.studies.record.columns import (
    FORCE_CHANNELS,
    POSITION_CHANNELS,
    column_of,
    factor_to,
    first_of,
    in_unit,
    listed,
    units_of,
    variant_of,
)
from motionlab.studies.record.part import (
    Part,
    first_stretch,
    kept_run,
    part_of,
    rounded,
    without_gaps,
)
from motionlab.studies.response.controller_check import controller_notes
from motionlab.studies.response.documents import ResponseRequest
from motionlab.studies.response.estimate import Estimate, Slides, estimate
from motionlab.studies.response.spectral import Signals, lines_between, local_estimate
from motionlab.studies.study import Source
from motionlab.timing import CONTROL_PERIOD
from motionlab.trajectories.multisine import Slide, lines_of, slides

Array = NDArray[np.float64]

SLIDES_MIN = 5
COHERENT = 0.5
"""Least coherence of a frequency that is kept."""
LINES_MIN = 8
"""Least number of frequencies that are kept."""
_MOVING = 0.1  # of the largest velocity
_SLOWEST = 1e-4  # m/s
_DIRECT = (
    "without a reference or another column of what excited the loop, the estimate divides position "
    "by force: where the coherence is low, feedback draws it towards the inverse of the controller"
)
_LIMITED = ("force_saturated", "current_saturated")


@dataclass(frozen=True)
class RecordedPlan:
    """A measurement from a run that has passed every check.

    Attributes
    ----------
    request : ResponseRequest
        As validated.
    scenario : Scenario
        Motor and controllers: the run's own, or of a measurement the requested one.
    variant : str
        Whose loop is examined.
    part : Part
        The run, and what is read of it.
    columns : tuple of str
        Excitation or "", then what `factors` are of: command and position, or of a run of the lab's
        own command and following error.
    factors : tuple of float
        To SI, of command and position.
    slides : tuple of Slide
        Whole slides of a multisine within the samples, ticks counted from `first`; else none.
    """

    request: ResponseRequest
    scenario: Scenario
    variant: str
    part: Part
    columns: tuple[str, str, str]
    factors: tuple[float, float]
    slides: tuple[Slide, ...]

    seconds = 0.0
    """Nothing is simulated."""

    @property
    def run(self) -> RunDetail:
        """The run."""
        return self.part.run

    @property
    def own(self) -> bool:
        """Whether it is a run of the lab's own, with reference and following error."""
        return self.run.scenario_document is not None


@dataclass(frozen=True)
class RecordedEstimate:
    """What a run tells.

    Attributes
    ----------
    frequency : ndarray, shape (lines,)
        Hz.
    of_plant : Estimate
        Command to position.
    loop : Loop
        The loop linearised at `velocity`.
    velocity : float
        m/s.
    slides, periods : int
        Slides of a multisine and measured periods of each; 1 and 1 of any other record.
    seconds : float
        Length of what was read, s.
    warnings : tuple of str
        What a reader must know.
    own_loop : (ndarray, Estimate), optional
        Of a measurement with its reference: frequencies and following error to position, which is
        the open loop under whatever controller it had.
    """

    frequency: Array
    of_plant: Estimate
    loop: Loop
    velocity: float
    slides: int
    periods: int
    seconds: float
    warnings: tuple[str, ...] = ()
    own_loop: tuple[Array, Estimate] | None = None


def plan_recorded(request: ResponseRequest, source: Source | None = None) -> RecordedPlan:
    """Return the checked measurement from a run.

    Raises
    ------
    ConfigError
        If there is no such run, it lacks a column, is too long, or has too few whole slides.
    """
    run = kept_run(str(request.run))
    part = part_of(request, run)
    _, first, stop = part
    if run.scenario_document is None:
        return _of_measurement(request, source, part)
    for event in run.events:
        at = event.tick - run.first_tick
        if event.kind in {"change", "law"} and first < at < stop:
            when = rounded(at * run.period)
            message = "has a controller or motor that is changed at this time; take a part before"
            raise ConfigError(FieldError("run", f"{message} or after it", when, unit="s"))
    scenario = load_scenario(scenario_at(run, first).model_dump(mode="json"), request.set)
    variant = variant_of(request.variant, run)
    linearise(scenario, variant, request.axis, v=_SLOWEST)
    axis, motion = request.axis, scenario.trajectory
    columns = (
        f"{axis}.position_reference",
        f"{variant}.{axis}.force_command",
        f"{variant}.{axis}.following_error",
    )
    here: tuple[Slide, ...] = ()
    if isinstance(motion, Multisine) and motion.axis == axis:
        here = _slides_within(motion, run.first_tick + first, run.first_tick + stop)
    return RecordedPlan(request, scenario, variant, part, columns, (1.0, 1.0), here)


def estimate_recorded(planned: RecordedPlan) -> RecordedEstimate:
    """Return the response that a run tells.

    Raises
    ------
    ConfigError
        If command or currents were at their limit, samples are missing, or nothing excited it.
    """
    columns = of_run(planned.run.id)
    _refuse_limited(planned, columns)
    return _of_slides(planned, columns) if planned.slides else _of_any(planned, columns)


def _of_measurement(request: ResponseRequest, source: Source | None, part: Part) -> RecordedPlan:
    run = part.run
    scenario = load_scenario(request.scenario if source is None else source, request.set)
    variant = request.chosen(scenario)
    linearise(scenario, variant, request.axis, v=_SLOWEST)
    units, prefix = units_of(run), f"{variant_of(None, run)}.{request.axis}."
    chosen: list[tuple[str, float]] = []
    for loc, named, names, unit in (
        ("force_column", request.force_column, FORCE_CHANNELS, "N"),
        ("position_column", request.position_column, POSITION_CHANNELS, "m"),
    ):
        fitting = in_unit(units, unit)
        name = column_of(named, units, loc=loc, prefix=prefix, names=names, fitting=fitting)
        chosen.append((name, factor_to(unit, name, units, loc)))
    excitation = request.excitation_column
    if excitation is None:
        excitation = first_of(units, f"{request.axis}.", ("position_reference",)) or ""
    elif excitation not in units:
        allowed = listed(list(units))
        raise ConfigError(
            FieldError("excitation_column", "is no column of the run", excitation, allowed)
        )
    names, factors = zip(*chosen, strict=True)
    if excitation in names or excitation.endswith(".following_error"):
        message = (
            "is the column of force, position or following error, which depend on the loop: an "
            "excitation does not, such as its reference"
        )
        raise ConfigError(FieldError("excitation_column", message, excitation))
    return RecordedPlan(request, scenario, variant, part, (excitation, *names), factors, ())


def _slides_within(motion: Multisine, first: int, stop: int) -> tuple[Slide, ...]:
    """Return the slides that lie within ticks of their motion, counted from the first of them."""
    there = [each for each in slides(motion) if first <= each.start and each.stop <= stop]
    if len(there) < SLIDES_MIN:
        message = "has too few whole slides of its multisine"
        raise ConfigError(
            FieldError("run", message, len(there), bounds={"minimum": float(SLIDES_MIN)})
        )
    return tuple(
        Slide(each.start - first, each.stop - first, each.forward, each.amplitudes)
        for each in there
    )


def _refuse_limited(planned: RecordedPlan, columns: Columns) -> None:
    if not planned.own:
        return
    names = [f"{planned.variant}.{planned.request.axis}.{each}" for each in _LIMITED]
    there = [name for name in names if name in columns.units]
    part = planned.part
    limited = columns.read(there)[:, part.first : part.stop] > 0.0
    if limited.any():
        when = part.interval(*first_stretch(np.asarray(limited.any(axis=0))))
        message = (
            "has command or currents at their limit, where a loop has no linear response, first "
            f"from {when}: choose a part by start and end"
        )
        raise ConfigError(FieldError("run", message))


def _read(planned: RecordedPlan, columns: Columns) -> Array:
    """Return excitation, command, and position or following error, SI, (3, samples)."""
    for name in planned.columns:
        if name and name not in columns.units:
            raise ConfigError(FieldError("run", f"has no column {name}", columns.name))
    excitation, command, position = planned.columns
    names = [excitation or command, command, position]
    samples = columns.read(names)[:, planned.part.first : planned.part.stop].astype(np.float64)
    samples[1:] *= np.array(planned.factors)[:, None]
    return samples


def coherent_lines(frequency: Array, of_plant: Estimate) -> tuple[Array, Estimate]:
    """Return the frequencies, Hz, whose coherence is at least `COHERENT`, and the plant there."""
    kept = of_plant.coherence >= COHERENT
    columns = ["response", "deviation", "noise", "coherence"]
    columns += [] if of_plant.shared is None else ["shared"]
    return frequency[kept], replace(
        of_plant, **{name: getattr(of_plant, name)[kept] for name in columns}
    )


def _not_exciting(coherent: int, lines: int, period: float) -> FieldError:
    """Return the error of a run of which too few frequencies are coherent."""
    message = (
        f"is not exciting enough: its coherence reaches {COHERENT:g} at this many of {lines} "
        f"frequencies, at {1.0 / period:.4g} samples a second; record a multisine, noise or a "
        "chirp that ends below half of that rate, in one piece"
    )
    return FieldError("run", message, coherent, bounds={"minimum": float(LINES_MIN)})


def _of_slides(planned: RecordedPlan, columns: Columns) -> RecordedEstimate:
    motion = planned.scenario.trajectory
    assert isinstance(motion, Multisine)
    lines, parts = lines_of(motion), []
    _, command, error = _read(planned, columns)
    for each in planned.slides:
        here = slice(each.start, each.stop)
        if not (np.isfinite(command[here]).all() and np.isfinite(error[here]).all()):
            continue  # a gap of the record
        shaken = np.tile(lines.motion(each.amplitudes)[0], motion.periods)
        position = lines.amplitudes(shaken - error[here])
        parts.append((each.amplitudes, lines.amplitudes(command[here]), position, each.forward))
    if len(parts) < SLIDES_MIN:
        message = "has too few slides of its multisine without a gap"
        raise ConfigError(
            FieldError("run", message, len(parts), bounds={"minimum": float(SLIDES_MIN)})
        )
    excitation, U, Y, forward = (np.array(each) for each in zip(*parts, strict=True))
    loop = linearise(planned.scenario, planned.variant, planned.request.axis, v=motion.velocity)
    seconds = planned.part.seconds
    reported = lines.reported(motion.lines)
    frequency = lines.frequency[[k for k, _ in reported]]
    kept = coherent_lines(frequency, estimate(Slides(excitation, U, Y, forward), reported))
    if len(kept[0]) < LINES_MIN:
        raise ConfigError(_not_exciting(len(kept[0]), len(frequency), planned.run.period))
    return RecordedEstimate(
        *kept,
        loop,
        motion.velocity,
        len(parts),
        motion.periods,
        seconds,
    )


def _of_any(planned: RecordedPlan, columns: Columns) -> RecordedEstimate:
    request, period = planned.request, planned.run.period
    samples = _read(planned, columns)
    stretch, notes = without_gaps(planned.part, samples)
    begin = stretch.first - planned.part.first
    excitation, command, third = samples[:, begin : begin + stretch.samples]
    position = excitation - third if planned.own else third
    signals = Signals(excitation, command, position, period, _is_reference(planned))
    frequency = lines_between(request.low, request.high, request.lines, signals)
    lines = None
    if frequency.size:
        lines = coherent_lines(frequency, local_estimate(signals, frequency))
    if lines is None or len(lines[0]) < LINES_MIN:
        coherent = 0 if lines is None else len(lines[0])
        raise ConfigError(_not_exciting(coherent, len(frequency), period))
    velocity = _typical_velocity(position, period)
    notes = (*notes, *_reversing(position, stretch))
    loop = linearise(planned.scenario, planned.variant, request.axis, v=velocity)
    seconds = len(position) * period
    warnings = (*notes,) if planned.columns[0] else (*notes, _DIRECT)
    own_loop = None
    if not planned.own:
        if (clipped := share_at_largest(command)) >= CLIPPED:
            warnings += (
                f"{planned.columns[1]} is at its largest value, {np.abs(command).max():.4g} N, in "
                f"{100.0 * clipped:.3g} % of the samples: a force at its limit has no linear "
                "response",
            )
        if signals.referred:
            warnings += (*controller_notes(signals, frequency, loop),)
            error = replace(signals, command=excitation - position)
            own_loop = coherent_lines(frequency, local_estimate(error, frequency))
        warnings += (
            f"a measurement has no controller: margins are those of {planned.variant} of the "
            f"scenario {planned.scenario.name}",
        )
        if not np.isclose(period, CONTROL_PERIOD):
            warnings += (
                f"it is sampled at {1.0 / period:.4g} Hz; the controller is that of "
                f"{1.0 / CONTROL_PERIOD:g} Hz",
            )
    return RecordedEstimate(*lines, loop, velocity, 1, 1, seconds, warnings, own_loop)


def _is_reference(planned: RecordedPlan) -> bool:
    return planned.own or planned.columns[0].endswith("position_reference")


def _reversing(position: Array, stretch: Part) -> list[str]:
    """Return a note where the motion reverses: friction answers there, not the machine."""
    apart = max(1, round(0.1 / stretch.run.period))
    speed = position[apart:] - position[:-apart]
    if not speed.size or not np.abs(speed).max():
        return []
    sure = np.flatnonzero(np.abs(speed) > _MOVING * np.abs(speed).max())
    turned = np.flatnonzero(np.diff(np.sign(speed[sure])))
    if not turned.size:
        return []
    # From where it moves for sure to where it does so no longer.
    begins, ends = sure[np.append(0, turned + 1)], sure[np.append(turned, len(sure) - 1)] + apart
    k = int(np.argmax(ends - begins))
    part = stretch.interval(int(begins[k]), int(ends[k]))
    return [
        f"it reverses {len(turned)} times, where friction answers in the machine's place; the "
        f"longest part without a reversal is from {part}"
    ]


def _typical_velocity(position: Array, period: float) -> float:
    """Return the median speed while it moves, over tenths of a second, m/s."""
    apart = max(1, round(0.1 / period))
    speed = np.abs(position[apart:] - position[:-apart]) / (apart * period)
    moving = speed[speed > _MOVING * speed.max()] if speed.size else speed
    return max(_SLOWEST, float(f"{np.median(moving):.3g}")) if moving.size else _SLOWEST
