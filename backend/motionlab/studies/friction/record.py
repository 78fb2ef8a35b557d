"""Position, force and normal force of a run, of the lab's motors or of any machine of one axis."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab.analysis.columns import Columns
from motionlab.config.load import load_scenario
from motionlab.errors import ConfigError
from motionlab.force_sharing.pole_pitch import forces_over
from motionlab.kernel.force_maps import map_lanes
from motionlab.library.run import RunDetail
from motionlab.plant.friction import LuGre
from motionlab.studies.friction.candidates import Candidate
from motionlab.studies.friction.documents import FrictionModelsRequest
from motionlab.studies.friction.own import candidates_of
from motionlab.studies.friction.units import FORCES, LENGTHS, NEWTONS, Machine, factor_of
from motionlab.studies.identify.documents import IdentifyRequest, RecordOptions
from motionlab.studies.identify.record.force import RecordForce, force_of
from motionlab.studies.identify.record.motion import Record
from motionlab.studies.identify.record.plan import (
    CURRENTS,
    SHORT,
    RecordExperiment,
    bandwidth_of,
    plan_record,
)
from motionlab.studies.record.columns import (
    FORCE_CHANNELS,
    PHASES,
    POSITION_CHANNELS,
    column_of,
    units_of,
    variant_of,
)
from motionlab.studies.record.part import kept_run, part_of

Array = NDArray[np.float64]

_COLUMNS = {"position_column": POSITION_CHANNELS, "force_column": FORCE_CHANNELS}
_NORMAL = "normal_force"


@dataclass(frozen=True)
class FrictionPlan:
    """A checked selection.

    Attributes
    ----------
    request : FrictionModelsRequest
        As validated.
    run : RunDetail
        The run.
    bandwidth : float
        Of the filter, Hz.
    machine : Machine
        Units of position and force.
    experiment : RecordExperiment or None
        Of a motor of the lab, whose forces come from its currents; None where a force is read.
    columns : tuple of str
        Position, force, and the normal force where it is a column.
    factors : tuple of float
        Of each, to m, N or what stands for them.
    friction : LuGre
        Of the scenario, plain numbers: where parameters of effects begin that have no default.
    """

    request: FrictionModelsRequest
    run: RunDetail
    bandwidth: float
    machine: Machine
    experiment: RecordExperiment | None
    columns: tuple[str, ...]
    factors: tuple[float, ...]
    friction: LuGre

    def effects(self) -> tuple[Candidate, ...]:
        """Return the effects of friction that are compared too."""
        return candidates_of(self.request.effects, self.friction, self.machine)


def plan(request: FrictionModelsRequest, source: Any = None) -> FrictionPlan:
    """Return the checked selection.

    Raises
    ------
    ConfigError
        If there is no such run, it lacks a column, a unit is wrong, it is sampled too slowly, or an
        effect cannot be compared.
    """
    checked = _plan(request, source)
    checked.effects()
    return checked


def _plan(request: FrictionModelsRequest, source: Any) -> FrictionPlan:
    run = kept_run(request.run)
    bandwidth = bandwidth_of(request, run)
    least = 1.0 / bandwidth
    part_of(request, run, seconds_min=least, short=SHORT)
    units = units_of(run)
    prefix = f"{variant_of(request.variant, run)}.{request.axis}."
    normal = request.normal_force_column
    if normal is None and prefix + _NORMAL in units:
        normal = prefix + _NORMAL
    beside = () if normal is None else (normal,)
    friction = _friction(request, source)
    newtons = tuple(factor_of("normal_force_column", name, units, NEWTONS)[1] for name in beside)
    if request.force_column in {None, CURRENTS} and _is_lab(run, units, prefix):
        experiment = _experiment(request, source)
        lab = Machine("m", "N")
        return FrictionPlan(request, run, bandwidth, lab, experiment, beside, newtons, friction)
    names = tuple(
        column_of(getattr(request, loc), units, loc=loc, prefix=prefix, names=channels)
        for loc, channels in _COLUMNS.items()
    )
    length, force = (
        factor_of(loc, name, units, known)
        for loc, name, known in zip(_COLUMNS, names, (LENGTHS, FORCES), strict=True)
    )
    machine = Machine(length[0], force[0])
    factors = (length[1] * machine.metres, force[1], *newtons)
    columns = (*names, *beside)
    return FrictionPlan(request, run, bandwidth, machine, None, columns, factors, friction)


def _friction(request: FrictionModelsRequest, source: Any) -> LuGre:
    if not request.effects:
        return LuGre(*[0.0] * len(LuGre._fields))
    scenario = load_scenario(request.scenario if source is None else source, request.set)
    friction = getattr(scenario.plant, request.axis).friction
    return LuGre(**friction.model_dump(exclude={"enabled"}))


def _is_lab(run: RunDetail, units: dict[str, str], prefix: str) -> bool:
    """Return whether a run has currents of the lab's motor, or followed a scenario."""
    currents = all(f"{prefix}current_{phase}" in units for phase in PHASES)
    return currents or run.scenario_document is not None


def _experiment(request: FrictionModelsRequest, source: Any) -> RecordExperiment:
    record = RecordOptions(**{n: getattr(request, n) for n in RecordOptions.model_fields})
    identify = IdentifyRequest(
        scenario=request.scenario,
        set=request.set,
        run=request.run,
        axis=request.axis,
        record=record,
    )
    try:
        return plan_record(identify, source)
    except ConfigError as error:
        errors = [replace(e, loc=e.loc.removeprefix("record.")) for e in error.errors]
        raise ConfigError(*errors) from error


@dataclass(frozen=True)
class Forces:
    """What is read of a run.

    Attributes
    ----------
    record : Record
        Position and force.
    normal : ndarray, shape (n,), or None
        Normal force, N.
    source : RecordForce or None
        Of currents, which settle as fast as a fit says.
    """

    record: Record
    normal: Array | None
    source: RecordForce | None

    def improved(self, within: float) -> Forces:
        """Return the forces with currents that settle as a fit says; itself if as before."""
        if self.source is None:
            return self
        better = self.source.improved({"within": within})
        return self if better is self.source else Forces(better.record, self.normal, better)


def read(plan: FrictionPlan, columns: Columns) -> Forces:
    """Return position, force and normal force of a run."""
    _, first, last = part_of(plan.request, plan.run)
    values = np.empty((0, last - first))
    if plan.columns:
        values = columns.read(plan.columns)[:, first:last].astype(np.float64)
        values *= np.array(plan.factors)[:, None]
    if plan.experiment is None:
        record = Record(plan.run.period, values[0], values[1])
        return Forces(record, _sized(plan, values[2] if len(values) > 2 else None), None)
    source = force_of(plan.experiment, plan.request.axis, columns)
    normal = values[0] if len(values) else _normal(plan.experiment, source)
    return Forces(source.record, _sized(plan, normal), source)


def _sized(plan: FrictionPlan, normal: Array | None) -> Array | None:
    """Return a normal force, or its magnitude where that is meant."""
    if normal is None or not plan.request.normal_force_magnitude:
        return normal
    return np.abs(normal)


def _normal(experiment: RecordExperiment, source: RecordForce) -> Array | None:
    """Return the normal force of recorded currents by the map, N; None without currents."""
    if experiment.axes[source.axis].force != CURRENTS:
        return None
    position, *currents = np.nan_to_num(source.samples[:4])
    model = map_lanes(experiment.rig.model(source.axis).force_map)
    return forces_over(model, position=position, current=np.stack(currents)).normal
