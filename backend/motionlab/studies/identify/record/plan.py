"""Run, columns, filter and mass of an identification from a record."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from motionlab.config.controller import AxisModelConfig
from motionlab.config.load import load_scenario
from motionlab.config.scenario import Scenario
from motionlab.errors import Busy, ConfigError, FieldError, Unknown
from motionlab.exchange.measurements.column_guess import si_of
from motionlab.library.run import RunDetail
from motionlab.studies.identify.documents import (
    IdentifyRequest,
    PlanDocument,
    PlannedRecord,
    RecordOptions,
)
from motionlab.studies.identify.results import known_document
from motionlab.studies.identify.rig import Rig

Source = str | Path | dict[str, Any]

CURRENTS = "currents"
PHASES = "abc"
SAMPLES_MAX = 1_000_000
"""Most samples of a record: 500 s at 2 kHz."""

_BANDWIDTH = 50.0
_OF_RATE = 0.075
"""Largest bandwidth, as a share of the sample rate: a window of 12 samples."""

_RATE_MIN = 50.0
_POSITIONS = ("position_measured", "position")
_COMMANDS = (".force_realised", ".force_command")
_FORCES = ("force_realised", "force_command", "thrust")


@dataclass(frozen=True)
class AxisColumns:
    """Columns of one axis.

    Attributes
    ----------
    position : str
        Of the position.
    force : str
        Of the force, or `CURRENTS`.
    names : tuple of str
        Columns that are read: position; force, or three currents and, where there are any, their
        three commands.
    factors : tuple of float
        To SI, of each.
    """

    position: str
    force: str
    names: tuple[str, ...]
    factors: tuple[float, ...]

    @property
    def commanded(self) -> bool:
        """Whether the force is known to be a command, which the currents follow."""
        return self.force.endswith(_COMMANDS)


@dataclass(frozen=True)
class RecordExperiment:
    """An identification from a run that has passed every check.

    Attributes
    ----------
    request : IdentifyRequest
        As validated.
    source : str, Path or dict
        The scenario as given.
    rig : Rig
        Force map of the driving variant, and the model that receives the result.
    run : RunDetail
        The run.
    axes : dict of str to AxisColumns
        What is read.
    bandwidth : float
        Of the filter, Hz.
    """

    request: IdentifyRequest
    source: Source
    rig: Rig
    run: RunDetail
    axes: dict[str, AxisColumns]
    bandwidth: float

    seconds = 0.0
    """Nothing is simulated."""

    @property
    def followed(self) -> Scenario | None:
        """The scenario that was carried out, with the motor that was simulated or assumed."""
        document = self.run.scenario_document
        return None if document is None else load_scenario(document)

    @property
    def true(self) -> Scenario | None:
        """The scenario that the run simulated, unless its motor changed on the way."""
        changed = any(path.startswith("plant") for e in self.run.events for path in e.set)
        simulated = self.run.kind in {"simulation", "live"}
        return self.followed if simulated and not changed else None

    @property
    def thrust_is_commanded(self) -> bool:
        """Whether the motor has no currents: its command is its thrust."""
        return (self.followed or self.rig.scenario).plant.force == "ideal"

    @property
    def read_variant(self) -> str:
        """Variant of the run whose channels are read."""
        return variant_of(self.request, self.run)

    @property
    def delay(self) -> int:
        """Control periods from a command to its effect, by the controller that carried it out."""
        followed = self.followed
        if followed is None:
            return self.rig.controller.delay
        return followed.variants[self.read_variant].controller.delay

    def old_model(self, axis: str) -> AxisModelConfig:
        """Return the old model, with the mass that is given or the driving variant's."""
        known_mass = self.request.record.mass
        mass = self.rig.model(axis).mass if known_mass is None else known_mass
        return self.rig.identified_model(axis).model_copy(update={"mass": mass})

    @property
    def part(self) -> tuple[int, int]:
        """Samples that are read, [first, last)."""
        return part_of(self.request.record, self.run)


def plan_record(request: IdentifyRequest, source: Source | None = None) -> RecordExperiment:
    """Return the checked identification from a run.

    Raises
    ------
    ConfigError
        If there is no such run, it lacks a column, a unit is wrong, or it is sampled too slowly.
    """
    source = request.scenario if source is None else source
    scenario = load_scenario(source, request.set)
    rig = Rig.of(request, scenario)
    assert request.run is not None
    run = kept_run(request.run)
    axes = _columns(request, run, rig.scenario.plant.force)
    bandwidth = bandwidth_of(request.record, run, "record.")
    check_part(request.record, run, bandwidth, loc="record.")
    return RecordExperiment(request, source, rig, run, axes, bandwidth)


def part_of(record: RecordOptions, run: RunDetail) -> tuple[int, int]:
    """Return the samples of a run that are read, [first, last)."""
    end = run.ticks if record.end is None else min(run.ticks, round(record.end / run.period))
    return round(record.start / run.period), end


def check_part(
    record: RecordOptions,
    run: RunDetail,
    bandwidth: float,
    *,
    loc: str = "",
    samples_max: int = SAMPLES_MAX,
) -> None:
    """Refuse a part of a run that is empty, shorter than the filter, or too long.

    Raises
    ------
    ConfigError
        Naming the field below `loc`.
    """
    first, last = part_of(record, run)
    if last <= first:
        raise ConfigError(
            FieldError(
                f"{loc}start",
                "leaves nothing of the run",
                record.start,
                unit="s",
                bounds={"minimum": 0.0, "exclusive_maximum": run.ticks * run.period},
            )
        )
    if (last - first) * run.period < 1.0 / bandwidth:
        raise ConfigError(
            FieldError(
                "run" if (first, last) == (0, run.ticks) else f"{loc}end",
                "leaves less than a period of the filter to identify from",
                float(f"{(last - first) * run.period:.4g}"),
                unit="s",
                bounds={"minimum": 1.0 / bandwidth},
            )
        )
    if last - first > samples_max:
        longest = samples_max * run.period
        raise ConfigError(
            FieldError(
                f"{loc}end",
                "leaves more of the run than one identification takes; give start and end",
                last * run.period,
                f"at most {longest:g} s after start",
                "s",
            )
        )


def record_plan_document(experiment: RecordExperiment, simulated_time_max: float) -> PlanDocument:
    """Return the columns, filters and masses of an identification from a run."""
    first, last = experiment.part
    period = experiment.run.period
    return PlanDocument(
        simulated_time=0.0,
        simulated_time_max=simulated_time_max,
        known={
            axis: known_document(experiment.rig, axis, experiment.true) for axis in experiment.axes
        },
        axes={axis: [] for axis in experiment.axes},
        ramps=0,
        record={
            axis: PlannedRecord(
                position=columns.position,
                force=columns.force,
                rate=1.0 / period,
                bandwidth=experiment.bandwidth,
                duration=(last - first) * period,
            )
            for axis, columns in experiment.axes.items()
        },
    )


def variant_of(request: IdentifyRequest, run: RunDetail) -> str:
    """Return the variant of a run whose channels are read."""
    return request.record.variant or (run.variants[0] if run.variants else "M")


def kept_run(run_id: str) -> RunDetail:
    """Return a run that is complete.

    Raises
    ------
    ConfigError
        If there is none, or it is still recorded.
    """
    from motionlab.library.library import library

    try:
        return library().complete(run_id)
    except (Unknown, Busy) as error:
        raise ConfigError(FieldError("run", str(error), run_id, "a kept run")) from error


def bandwidth_of(record: RecordOptions, run: RunDetail, loc: str = "") -> float:
    """Return the bandwidth of the filter, Hz.

    Raises
    ------
    ConfigError
        If the run is sampled too slowly for it.
    """
    rate = 1.0 / run.period
    if rate < _RATE_MIN * (1.0 - 1e-9):
        raise ConfigError(
            FieldError(
                "run",
                "is sampled too slowly to derive an acceleration from",
                float(f"{rate:.4g}"),
                unit="Hz",
                bounds={"minimum": _RATE_MIN},
            )
        )
    most = _OF_RATE * rate
    bandwidth = record.bandwidth
    if bandwidth is not None and bandwidth > most * (1.0 + 1e-9):
        raise ConfigError(
            FieldError(
                f"{loc}bandwidth",
                f"is too large for a rate of {rate:.4g} Hz",
                bandwidth,
                unit="Hz",
                bounds={"maximum": float(f"{most:.4g}")},
            )
        )
    return min(_BANDWIDTH, most) if bandwidth is None else bandwidth


def _columns(
    request: IdentifyRequest, run: RunDetail, force: Literal["phases", "ideal"] | str
) -> dict[str, AxisColumns]:
    """Return the columns of each requested axis; of both, those that the run has."""
    variant = variant_of(request, run)
    if request.record.variant is not None and variant not in run.variants:
        allowed = "one of " + ", ".join(run.variants)
        raise ConfigError(
            FieldError("record.variant", "is no variant of the run", variant, allowed)
        )
    units = {column["name"]: column["unit"] for column in run.columns}
    if run.scenario_document is not None:
        force = run.scenario_document.get("plant", {}).get("force", force)
    columns: dict[str, AxisColumns] = {}
    refused: list[FieldError] = []
    named = request.record.position is not None or request.record.force is not None
    for axis in request.axes:
        try:
            columns[axis] = _of_axis(request, units, f"{variant}.{axis}.", force != "ideal")
        except ConfigError as error:
            refused += error.errors
    if named and len(request.axes) > 1:
        message = "columns that are named are those of one axis"
        raise ConfigError(FieldError("axis", message, request.axis, "x or y"))
    if refused and (not columns or request.axis != "both"):
        raise ConfigError(*refused)
    return columns


def _of_axis(
    request: IdentifyRequest, units: dict[str, str], prefix: str, with_currents: bool
) -> AxisColumns:
    record = request.record
    position = record.position or _first(units, prefix, _POSITIONS)
    if position is None:
        raise _missing("record.position", prefix, _POSITIONS, units, "m")
    currents = tuple(f"{prefix}current_{phase}" for phase in PHASES)
    force = record.force
    if force is None:
        has = with_currents and all(name in units for name in currents)
        force = CURRENTS if has else _first(units, prefix, _FORCES)
    if force is None:
        raise _missing("record.force", prefix, ("current_a, _b, _c", *_FORCES), units, "N")
    if force != CURRENTS:
        factors = (
            _factor("record.position", position, units, "m"),
            _factor("record.force", force, units, "N"),
        )
        return AxisColumns(position, force, (position, force), factors)
    commands = tuple(f"{prefix}current_command_{phase}" for phase in PHASES)
    read = currents + (commands if all(name in units for name in commands) else ())
    factors = tuple(_factor("record.force", name, units, "A") for name in read)
    first = _factor("record.position", position, units, "m")
    return AxisColumns(position, CURRENTS, (position, *read), (first, *factors))


def _first(units: dict[str, str], prefix: str, names: tuple[str, ...]) -> str | None:
    return next((prefix + name for name in names if prefix + name in units), None)


def _factor(loc: str, name: str, units: dict[str, str], si_unit: str) -> float:
    """Return the factor of a column to SI."""
    if name not in units:
        raise ConfigError(FieldError(loc, "is no column of the run", name, _listed(units, si_unit)))
    factor = si_of(units[name]) if units[name] else None
    if factor is None or factor[0] != si_unit:
        message = f"column {name!r} has a unit other than {si_unit}"
        raise ConfigError(FieldError(loc, message, units[name] or "none", f"a unit of {si_unit}"))
    return factor[1]


def _missing(
    loc: str, prefix: str, names: tuple[str, ...], units: dict[str, str], si_unit: str
) -> ConfigError:
    message = f"the run has none of {', '.join(prefix + name for name in names)}; name a column"
    return ConfigError(FieldError(loc, message, None, _listed(units, si_unit)))


def _listed(units: dict[str, str], si_unit: str) -> str:
    """Return the columns of a unit."""
    fit = [name for name, unit in units.items() if (factor := si_of(unit)) and factor[0] == si_unit]
    more = f" and {len(fit) - 20} more" if len(fit) > 20 else ""
    return f"one of {', '.join(fit[:20])}{more}" if fit else f"none: no column is in {si_unit}"
