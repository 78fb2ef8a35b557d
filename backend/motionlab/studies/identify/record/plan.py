"""Run, columns, filter and mass of an identification from a record."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from motionlab.config.controller import AxisModelConfig
from motionlab.config.load import load_scenario
from motionlab.config.scenario import Scenario
from motionlab.errors import ConfigError, FieldError
from motionlab.library.run import RunDetail
from motionlab.studies.identify.documents import (
    IdentifyRequest,
    PlanDocument,
    PlannedRecord,
    RecordOptions,
)
from motionlab.studies.identify.results import known_document
from motionlab.studies.identify.rig import Rig
from motionlab.studies.record.columns import (
    FORCE_CHANNELS,
    PHASES,
    POSITION_CHANNELS,
    column_of,
    factor_to,
    in_unit,
    units_of,
    variant_of,
)
from motionlab.studies.record.part import Part, kept_run, part_of

Source = str | Path | dict[str, Any]

CURRENTS = "currents"

SHORT = "leaves less than a period of the filter to identify from"

_BANDWIDTH = 50.0
_OF_RATE = 0.075
"""Largest bandwidth, as a share of the sample rate: a window of 12 samples."""

_RATE_MIN = 50.0
_COMMANDS = (".force_realised", ".force_command")


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
    part : Part
        What is read.
    """

    request: IdentifyRequest
    source: Source
    rig: Rig
    run: RunDetail
    axes: dict[str, AxisColumns]
    bandwidth: float
    part: Part

    seconds = 0.0
    """Nothing is simulated."""

    def normal_force(self, axis: str) -> str | None:
        """Return the column of an axis's normal force, if the run has one."""
        names = (name for name in units_of(self.run) if name.endswith(f".{axis}.normal_force"))
        return next(names, None)

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
        return variant_of(self.request.record.variant, self.run)

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
    part = part_of(request.record, run, loc="record.", seconds_min=1.0 / bandwidth, short=SHORT)
    return RecordExperiment(request, source, rig, run, axes, bandwidth, part)


def record_plan_document(experiment: RecordExperiment, simulated_time_max: float) -> PlanDocument:
    """Return the columns, filters and masses of an identification from a run."""
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
                duration=experiment.part.seconds,
            )
            for axis, columns in experiment.axes.items()
        },
    )


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
    variant = variant_of(request.record.variant, run, "record.variant")
    units = units_of(run)
    if run.scenario_document is not None:
        force = run.scenario_document.get("plant", {}).get("force", force)
    columns: dict[str, AxisColumns] = {}
    refused: list[FieldError] = []
    named = request.record.position_column is not None or request.record.force_column is not None
    for axis in request.axes:
        try:
            columns[axis] = _of_axis(request.record, units, f"{variant}.{axis}.", force != "ideal")
        except ConfigError as error:
            refused += error.errors
    if named and len(request.axes) > 1:
        message = "columns that are named are those of one axis"
        raise ConfigError(FieldError("axis", message, request.axis, "x or y"))
    if refused and (not columns or request.axis != "both"):
        raise ConfigError(*refused)
    return columns


def _of_axis(
    record: RecordOptions, units: dict[str, str], prefix: str, with_currents: bool
) -> AxisColumns:
    position = column_of(
        record.position_column,
        units,
        loc="record.position_column",
        prefix=prefix,
        names=POSITION_CHANNELS,
        fitting=in_unit(units, "m"),
    )
    first = factor_to("m", position, units, "record.position_column")
    currents = tuple(f"{prefix}current_{phase}" for phase in PHASES)
    force = record.force_column
    if force is None and with_currents and all(name in units for name in currents):
        force = CURRENTS
    if force == CURRENTS:
        commands = tuple(f"{prefix}current_command_{phase}" for phase in PHASES)
        read = currents + (commands if all(name in units for name in commands) else ())
        factors = tuple(factor_to("A", name, units, "record.force_column") for name in read)
        return AxisColumns(position, CURRENTS, (position, *read), (first, *factors))
    force = column_of(
        force,
        units,
        loc="record.force_column",
        prefix=prefix,
        names=("current_a", *FORCE_CHANNELS) if with_currents else FORCE_CHANNELS,
        fitting=in_unit(units, "N"),
    )
    factor = factor_to("N", force, units, "record.force_column")
    return AxisColumns(position, force, (position, force), (first, factor))
