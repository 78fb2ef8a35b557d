"""The simulated motor fitted to a machine: what was identified from a run, in the plant."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import UTC, datetime
from typing import Any

import numpy as np

from motionlab.analysis.columns import Columns
from motionlab.config.load import load_scenario
from motionlab.config.plant import PlantConfig
from motionlab.config.scenario import Scenario
from motionlab.config.timing import CONTROL_PERIOD
from motionlab.errors import ExperimentFailed, MotionLabError
from motionlab.library.motors import FittedValue, Motor, MotorOrigin, Residual
from motionlab.simulation.prepare import prepare
from motionlab.simulation.simulation import Simulation, sample_page, variant_columns
from motionlab.studies.identify.evaluate import UNITS, is_a_model
from motionlab.studies.identify.record_fit import RecordFit
from motionlab.studies.identify.record_plan import CURRENTS, RecordExperiment
from motionlab.studies.identify.stribeck import Fitted
from motionlab.telemetry.channels import Sample

_ERROR = Sample._fields.index("following_error")


def fitted_motor(
    experiment: RecordExperiment, fits: Mapping[str, RecordFit], columns: Columns
) -> Motor | None:
    """Return the motor of a run's scenario with what was identified from the run.

    Friction and moving mass are in newtons of the force map of the driving variant, so the axis
    gets that map too: with a thrust `k` times the map's, ``k F = M a + f`` and ``F = (M a + f)/k``
    are one motion.

    Parameters
    ----------
    experiment : RecordExperiment
        What was read; a measurement has the motor of the request's scenario.
    fits : mapping of str to RecordFit
        By axis.
    columns : Columns
        Of the run.

    Returns
    -------
    Motor or None
        None of a simulation, whose motor is known, and where nothing is determined.
    """
    run = experiment.run
    if run.kind in {"simulation", "live"}:
        return None
    followed = experiment.followed
    plant = (followed or experiment.rig.scenario).plant
    values: dict[str, FittedValue] = {}
    notes: list[str] = []
    for axis, fit in fits.items():
        values |= _of_axis(fit, plant, axis)
        notes += _pulls(fit, axis)
    if not values:
        return None
    tables = _with(plant, experiment, values)
    recorded = datetime.fromtimestamp(run.created, UTC).isoformat(timespec="seconds")
    tables["description"] = f"Fitted to {run.name} ({run.id}) of {recorded[:10]}"
    residual = None
    if run.first_tick:  # a simulation begins at tick 0
        notes.append("no simulation is compared with the run, whose beginning has gone")
    elif followed is not None:
        try:
            after = load_scenario(followed.model_dump(mode="json") | {"plant": tables})
            residual = _residuals(experiment, columns, list(fits), followed, after)
        except MotionLabError as error:
            notes.append(f"the run cannot be simulated: {error}")
    origin = MotorOrigin(
        run=run.id,
        run_name=run.name,
        recorded=recorded,
        fits=values,
        residual=residual,
        notes=notes,
    )
    return Motor(plant=tables, origin=origin)


def _of_axis(fit: RecordFit, plant: PlantConfig, axis: str) -> dict[str, FittedValue]:
    """Return what the record determines of an axis, by path; friction only if it is a model."""
    old = getattr(plant, axis)
    friction: dict[str, FittedValue] = {}
    for fitted in (fit.sliding, fit.presliding):
        for name in () if fitted is None else fitted.names:
            if name != "f_0" and fitted is not None and fitted.determines(name):
                value = _value(fitted, name, getattr(old.friction, name))
                friction[name] = value
    if not is_a_model({name: each.value for name, each in friction.items()}, old.friction):
        friction = {}
    found = {f"{axis}.friction.{name}": value for name, value in friction.items()}
    if "M" in fit.further.names and fit.further.determines("M"):
        found[f"{axis}.mass"] = _value(fit.further, "M", old.mass)
    return found


def _value(fitted: Fitted, name: str, before: float) -> FittedValue:
    value, half = fitted[name], fitted.half(name)
    low, high = value - half, value + half
    return FittedValue(value=value, low=low, high=high, before=before, unit=UNITS[name])


def _pulls(fit: RecordFit, axis: str) -> list[str]:
    """Return a note on a constant force, which is no part of a motor."""
    force, half = fit.sliding["f_0"], fit.sliding.half("f_0")
    if not half < abs(force):
        return []
    return [f"a constant force of {force:.3g} N on {axis} is no part of a motor: load.{axis}"]


def _with(
    plant: PlantConfig, experiment: RecordExperiment, values: Mapping[str, FittedValue]
) -> dict[str, Any]:
    """Return the tables of a motor with fitted values, and the force map that they hold in."""
    tables = plant.model_dump(mode="json")
    for path, fitted in values.items():
        axis, *steps = path.split(".")
        table = tables[axis]
        for step in steps[:-1]:
            table = table[step]
        table[steps[-1]] = fitted.value
    for axis in {path[0] for path in values}:
        tables[axis]["friction"]["enabled"] = True
        if experiment.request.record.mass is not None:
            tables[axis]["mass"] = experiment.request.record.mass
        if experiment.axes[axis].force == CURRENTS:
            force_map = experiment.rig.model(axis).force_map
            tables[axis]["force_map"] = force_map.model_dump(mode="json")
    return tables


def _residuals(
    experiment: RecordExperiment,
    columns: Columns,
    axes: list[str],
    before: Scenario,
    after: Scenario,
) -> dict[str, Residual]:
    """Return what two simulations of the run leave of its following errors, by axis."""
    variant = experiment.read_variant
    names = [f"{variant}.{axis}.following_error" for axis in axes]
    measured = columns.read(names)
    ends = [event.tick for event in experiment.run.events]
    ticks = min([measured.shape[1], *ends])  # what follows a STOP is in no scenario
    both = [_errors(scenario, variant, axes, ticks) for scenario in (before, after)]
    rms = [np.sqrt(np.nanmean((measured[:, : e.shape[1]] - e) ** 2, axis=1)) for e in both]
    return {
        axis: Residual(before=float(rms[0][k]), after=float(rms[1][k]))
        for k, axis in enumerate(axes)
        if np.isfinite(rms[0][k]) and np.isfinite(rms[1][k])
    }


def _errors(scenario: Scenario, variant: str, axes: list[str], ticks: int) -> np.ndarray:
    """Return the following errors of a simulation, m, shape (axes, ticks); page by page.

    Raises
    ------
    ExperimentFailed
        If it diverges.
    """
    one = scenario.model_copy(update={"variants": {variant: scenario.variants[variant]}})
    simulation = Simulation(prepare(one, checked=True))
    page, found = sample_page(1), []
    while simulation.tick < ticks and (count := simulation.advance(page)):
        found.append(variant_columns(page, 0, count)[_ERROR].copy())
    (failed,) = simulation.failed_ticks
    if failed is not None:
        raise ExperimentFailed(f"it diverges at t = {failed * CONTROL_PERIOD:.4f} s")
    errors = np.concatenate(found, axis=1)[:, :ticks]
    return errors[["xy".index(axis) for axis in axes]].astype(np.float64)
