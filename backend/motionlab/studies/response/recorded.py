"""A frequency response from a kept run: a multisine that it followed, or whatever excited it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab.analysis.columns import Columns
from motionlab.config.load import load_scenario
from motionlab.config.multisine import Multisine
from motionlab.config.scenario import Scenario
from motionlab.errors import Busy, ConfigError, FieldError, Unknown
from motionlab.library.columns import of_run
from motionlab.library.library import library
from motionlab.library.run import RunDetail
from motionlab.loop.linearise import Loop, linearise
from motionlab.studies.identify.documents import IdentifyRequest
from motionlab.studies.identify.record.plan import CURRENTS, SAMPLES_MAX, plan_record
from motionlab.studies.minute.recorded import scenario_at
from motionlab.studies.response.documents import ResponseRequest
from motionlab.studies.response.estimate import Estimate, Slides, estimate
from motionlab.studies.response.spectral import Signals, lines_between, local_estimate
from motionlab.studies.study import Source
from motionlab.timing import CONTROL_PERIOD
from motionlab.trajectories.multisine import Slide, lines_of, slides

Array = NDArray[np.float64]

SLIDES_MIN = 5
COHERENT = 0.5
"""Least coherence of a frequency that is kept, of a record without a multisine of the lab's."""
_LINES_MIN = 8
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
    run : RunDetail
        The run.
    first, stop : int
        Its samples that are read, [first, stop).
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
    run: RunDetail
    first: int
    stop: int
    columns: tuple[str, str, str]
    factors: tuple[float, float]
    slides: tuple[Slide, ...]

    seconds = 0.0
    """Nothing is simulated."""

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
    """

    frequency: Array
    of_plant: Estimate
    loop: Loop
    velocity: float
    slides: int
    periods: int
    seconds: float
    warnings: tuple[str, ...] = ()


def plan_recorded(request: ResponseRequest, source: Source | None = None) -> RecordedPlan:
    """Return the checked measurement from a run.

    Raises
    ------
    ConfigError
        If there is no such run, it lacks a column, is too long, or has too few whole slides.
    """
    try:
        run = library().complete(str(request.run))
    except (Unknown, Busy) as error:
        raise ConfigError(FieldError("run", str(error), request.run, "a kept run")) from error
    first, stop = _part(request, run)
    if run.scenario_document is None:
        return _of_measurement(request, source, run, first, stop)
    for event in run.events:
        at = event.tick - run.first_tick
        if event.kind in {"change", "law"} and first < at < stop:
            when = float(f"{at * run.period:.4g}")
            message = "has a controller or motor that is changed at this time; take a part before"
            raise ConfigError(FieldError("run", f"{message} or after it", when, unit="s"))
    scenario = load_scenario(scenario_at(run, first).model_dump(mode="json"), request.set)
    variant = request.variant or run.variants[0]
    if variant not in run.variants:
        allowed = "one of " + ", ".join(run.variants)
        raise ConfigError(FieldError("variant", "is no variant of the run", variant, allowed))
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
    return RecordedPlan(request, scenario, variant, run, first, stop, columns, (1.0, 1.0), here)


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


def _part(request: ResponseRequest, run: RunDetail) -> tuple[int, int]:
    """Return the samples that are read, [first, stop)."""
    first = round(request.start / run.period)
    stop = run.ticks if request.end is None else min(run.ticks, round(request.end / run.period))
    if stop - first < 2:
        bounds = {"minimum": 0.0, "exclusive_maximum": run.ticks * run.period}
        message = "leaves nothing of the run"
        raise ConfigError(FieldError("start", message, request.start, unit="s", bounds=bounds))
    if stop - first > SAMPLES_MAX:
        longest = SAMPLES_MAX * run.period
        message = "leaves more of the run than one estimate takes; give start and end"
        raise ConfigError(
            FieldError("end", message, stop * run.period, f"at most {longest:g} s after start", "s")
        )
    return first, stop


def _of_measurement(
    request: ResponseRequest, source: Source | None, run: RunDetail, first: int, stop: int
) -> RecordedPlan:
    scenario = load_scenario(request.scenario if source is None else source, request.set)
    variant = request.chosen(scenario)
    linearise(scenario, variant, request.axis, v=_SLOWEST)
    record: dict[str, Any] = {"position": request.position_column, "force": request.force_column}
    identified = IdentifyRequest.model_validate(
        {"run": run.id, "axis": request.axis, "record": record}
    )
    read = plan_record(identified, scenario.model_dump(mode="json")).axes[request.axis]
    if read.force == CURRENTS:
        message = "the run has currents only, and a response needs a force; name its column"
        raise ConfigError(FieldError("force_column", message))
    units = {column["name"]: column["unit"] for column in run.columns}
    excitation = request.excitation_column
    if excitation is None:
        reference = f"{request.axis}.position_reference"
        excitation = reference if reference in units else ""
    elif excitation not in units:
        allowed = "one of " + ", ".join(list(units)[:20])
        raise ConfigError(
            FieldError("excitation_column", "is no column of the run", excitation, allowed)
        )
    columns = (excitation, read.names[1], read.names[0])
    factors = (read.factors[1], read.factors[0])
    return RecordedPlan(request, scenario, variant, run, first, stop, columns, factors, ())


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
    limited = columns.read(there)[:, planned.first : planned.stop] > 0.0
    if limited.any():
        at = float(f"{int(limited.any(axis=0).argmax()) * planned.run.period:.4g}")
        message = (
            "has command or currents at their limit, where a loop has no linear response; first at "
            "this time: take a part by start and end"
        )
        raise ConfigError(FieldError("run", message, at, unit="s"))


def _read(planned: RecordedPlan, columns: Columns) -> Array:
    """Return excitation, command, and position or following error, SI, (3, samples)."""
    for name in planned.columns:
        if name and name not in columns.units:
            raise ConfigError(FieldError("run", f"has no column {name}", columns.name))
    excitation, command, position = planned.columns
    names = [excitation or command, command, position]
    samples = columns.read(names)[:, planned.first : planned.stop].astype(np.float64)
    samples[1:] *= np.array(planned.factors)[:, None]
    return samples


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
    seconds = (planned.stop - planned.first) * CONTROL_PERIOD
    return RecordedEstimate(
        lines.frequency,
        estimate(Slides(excitation, U, Y, forward)),
        loop,
        motion.velocity,
        len(parts),
        motion.periods,
        seconds,
    )


def _of_any(planned: RecordedPlan, columns: Columns) -> RecordedEstimate:
    request, period = planned.request, planned.run.period
    excitation, command, third = samples = _read(planned, columns)
    missing = ~np.isfinite(samples).all(axis=0)
    if missing.any():
        at = float(f"{int(missing.argmax()) * period:.4g}")
        message = "lacks samples: first at this time; take a part by start and end"
        raise ConfigError(FieldError("run", message, at, unit="s"))
    position = excitation - third if planned.own else third
    signals = Signals(excitation, command, position, period, _is_reference(planned))
    frequency = lines_between(request.low, request.high, request.lines, signals)
    of_plant = local_estimate(signals, frequency) if frequency.size else None
    coherent = np.zeros(0) >= 0.0 if of_plant is None else of_plant.coherence >= COHERENT
    if of_plant is None or coherent.sum() < _LINES_MIN:
        message = (
            f"is not exciting enough: its coherence reaches {COHERENT:g} at this many of "
            f"{len(frequency)} frequencies; record a multisine, noise or a chirp"
        )
        raise ConfigError(
            FieldError("run", message, int(coherent.sum()), bounds={"minimum": float(_LINES_MIN)})
        )
    velocity = _typical_velocity(position, period)
    kept = Estimate(
        of_plant.response[coherent],
        of_plant.deviation[coherent],
        of_plant.noise[coherent],
        of_plant.coherence[coherent],
        of_plant.freedom,
    )
    loop = linearise(planned.scenario, planned.variant, request.axis, v=velocity)
    seconds = len(position) * period
    warnings = () if planned.columns[0] else (_DIRECT,)
    if not planned.own:
        warnings += (
            f"a measurement has no controller: margins are those of {planned.variant} of the "
            f"scenario {planned.scenario.name}",
        )
        if not np.isclose(period, CONTROL_PERIOD):
            warnings += (
                f"it is sampled at {1.0 / period:.4g} Hz; the controller is that of "
                f"{1.0 / CONTROL_PERIOD:g} Hz",
            )
    return RecordedEstimate(frequency[coherent], kept, loop, velocity, 1, 1, seconds, warnings)


def _is_reference(planned: RecordedPlan) -> bool:
    return planned.own or planned.columns[0].endswith("position_reference")


def _typical_velocity(position: Array, period: float) -> float:
    """Return the median speed while it moves, over tenths of a second, m/s."""
    apart = max(1, round(0.1 / period))
    speed = np.abs(position[apart:] - position[:-apart]) / (apart * period)
    moving = speed[speed > _MOVING * speed.max()] if speed.size else speed
    return max(_SLOWEST, float(f"{np.median(moving):.3g}")) if moving.size else _SLOWEST
