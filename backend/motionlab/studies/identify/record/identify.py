"""Identification from a recorded run, and a motor fitted to it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from datetime import UTC, datetime
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab import __version__
from motionlab.analysis.columns import Columns
from motionlab.config.controller import AxisModelConfig
from motionlab.config.load import load_scenario
from motionlab.config.plant import FrictionConfig, PlantConfig
from motionlab.config.scenario import Scenario
from motionlab.errors import ExperimentFailed, MotionLabError
from motionlab.lanes import model_hash
from motionlab.library.columns import of_run
from motionlab.library.motors import FittedValue, Motor, MotorOrigin, Residual
from motionlab.simulation.prepare import prepare
from motionlab.simulation.result import plant_name
from motionlab.simulation.simulation import Simulation, sample_page, variant_columns
from motionlab.studies.identify.documents import (
    AxisIdentification,
    ExperimentProgress,
    IdentificationDocument,
    PartialIdentification,
    Point,
    RecordEvidence,
)
from motionlab.studies.identify.fit import Fitted, stribeck_curve
from motionlab.studies.identify.record.fit import SLIDING, RecordFit, fit_record
from motionlab.studies.identify.record.force import force_of
from motionlab.studies.identify.record.motion import Motion, Motions, check_sign, motions_of
from motionlab.studies.identify.record.plan import CURRENTS, AxisColumns, RecordExperiment
from motionlab.studies.identify.results import (
    UNITS,
    curve_document,
    fit_document,
    is_a_model,
    known_document,
)
from motionlab.studies.identify.rig import compare_models
from motionlab.telemetry.channels import Sample
from motionlab.timing import CONTROL_PERIOD

_ERROR = Sample._fields.index("following_error")


def fitted_motor(
    experiment: RecordExperiment, fits: Mapping[str, RecordFit], columns: Columns
) -> Motor | None:
    """Return the motor of a run's scenario with what was identified from the run.

    Friction and moving mass are in newtons of the force map of the driving variant, so the axis
    gets that map too: with a thrust `k` times the map's, ``k F = M a + f`` and ``F = (M a + f)/k``
    are one motion.

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
    notes.append(_NO_MODES)
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
    """Return what the record determines of an axis, by path; friction only of a model."""
    old = getattr(plant, axis)
    friction: dict[str, FittedValue] = {}
    for fitted in (fit.sliding, fit.presliding):
        for name in () if fitted is None else fitted.names:
            if name != "f_0" and fitted is not None and fitted.determines(name):
                value = _value(fitted, name, getattr(old.friction, name))
                friction[name] = value
    if not is_a_model({name: each.value for name, each in friction.items()}, old.friction):
        friction = {}
    changes = {f"{axis}.friction.{name}": value for name, value in friction.items()}
    if "M" in fit.further.names and fit.further.determines("M"):
        changes[f"{axis}.mass"] = _value(fit.further, "M", old.mass)
    return changes


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
    """Return the residuals of the following errors of two simulations of the run, by axis."""
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
    page, pages = sample_page(1), []
    while simulation.tick < ticks and (count := simulation.advance(page)):
        pages.append(variant_columns(page, 0, count)[_ERROR].copy())
    (failed,) = simulation.failed_ticks
    if failed is not None:
        raise ExperimentFailed(f"it diverges at t = {failed * CONTROL_PERIOD:.4f} s")
    errors = np.concatenate(pages, axis=1)[:, :ticks]
    return errors[["xy".index(axis) for axis in axes]].astype(np.float64)


Array = NDArray[np.float64]
Progress = Callable[[float, PartialIdentification | None], None]

_BINS = 16
"""Points of a direction: bins of speed, each as wide as the next in ratio."""

_FEWEST = 5
"""Windows that a bin needs."""

_CONDITION = 1000.0
_UNEXPLAINED = 0.5
"""Residual, as a share of the friction, from which a fit explains nothing."""

_ROUNDS = 4
_NO_MODES = (
    "of the machine this motor has masses and friction alone, neither a delay nor a mode, which "
    "`response` measures: where it has them, margins and gains of this motor are too large"
)
"""Fits at most, each with currents that settle as fast as the one before says."""


def identify_record(
    experiment: RecordExperiment, progress: Progress | None = None
) -> IdentificationDocument:
    """Identify friction from a run.

    Parameters
    ----------
    experiment : RecordExperiment
        From `motionlab.studies.identify.record.plan.plan_record`.
    progress : callable, optional
        Called with the share done, and with the axes that are finished.

    Raises
    ------
    ExperimentFailed
        If an axis moved too little to identify anything from.
    ConfigError
        If the sign of a force is reversed.
    """
    rig, true = experiment.rig, experiment.true
    known = {axis: known_document(rig, axis, true) for axis in experiment.axes}
    columns = of_run(experiment.run.id)
    results: dict[str, AxisIdentification] = {}
    failed: list[str] = []
    changes: dict[str, float] = {}
    fits: dict[str, RecordFit] = {}
    count = len(experiment.axes)
    for index, axis in enumerate(experiment.axes):

        def at(share: float, index: int = index, axis: str = axis) -> None:
            if progress is None:
                return
            standing = ExperimentProgress(axis=axis, step="record", done=index, count=count)
            partial = PartialIdentification(
                standing=standing,
                known=known,
                axes={name: each.points for name, each in results.items()},
                found=dict(results),
            )
            progress((index + share) / count, partial)

        at(0.0)
        try:
            results[axis], values, fits[axis] = _axis(experiment, axis, columns, at)
        except ExperimentFailed as error:
            failed.append(f"{axis}: {error}")
            continue
        changes |= values
    if not results:
        raise ExperimentFailed(f"identification from {experiment.run.id}: {'; '.join(failed)}")
    for each in results.values():
        each.warnings.extend(failed)
    _, first, last = experiment.part
    compare = experiment.request.compare and bool(changes)
    return IdentificationDocument(
        scenario=rig.scenario.name,
        seed=rig.scenario.seed,
        plant=plant_name(rig.scenario.plant),
        version=__version__,
        model=model_hash(),
        variant=rig.variant,
        apply_to=rig.apply_to,
        run=experiment.run.id,
        simulated_time=(last - first) * experiment.run.period,
        axes=results,
        set=changes,
        motor=fitted_motor(experiment, fits, columns),
        comparison=compare_models(rig, experiment.source, experiment.request.set, changes)
        if compare
        else None,
    )


def _axis(
    experiment: RecordExperiment, axis: str, columns: Columns, at: Callable[[float], None]
) -> tuple[AxisIdentification, dict[str, float], RecordFit]:
    """Return the document of an axis, the paths to change, and the fit behind both."""
    rig, chosen = experiment.rig, experiment.axes[axis]
    believed = rig.identified_model(axis).friction
    mass_known = experiment.request.record.mass is not None
    model = experiment.old_model(axis)
    motions, fit, doubts = _fitted(experiment, axis, columns, model, at)
    motion = motions.sliding
    velocity = motion.of(motion.position, 1)[motion.sliding]
    points, residuals = _points(fit, velocity, motion)
    warnings = doubts + fit.warnings
    if fit.condition > _CONDITION:
        warnings.append(
            f"parameters can hardly be told apart: the condition number is {fit.condition:.3g}; "
            "record other speeds and accelerations"
        )
    fits = [fitted for fitted in (fit.sliding, fit.presliding) if fitted is not None]
    applied, left_out = to_apply(fits, believed)
    reason = contradiction(fit, applied, believed, points)
    warnings += left_out
    if applied and reason is not None:
        applied = {}
        warnings.append(f"{reason}: no friction of this axis is in `set`")
    path = f"variants.{rig.apply_to}.controller.model.{axis}.friction."
    changes = {path + name: value for name, value in applied.items()}
    true = experiment.true
    sliding = fit_document(rig, axis, fit.sliding, "N", true)
    if not mass_known:
        mass = fit_document(rig, axis, fit.further, "N", true)
        sliding.parameters["M"] = mass.parameters["M"]
        sliding.warnings.extend(w for w in mass.warnings if w.startswith("M "))
    document = AxisIdentification(
        points=points,
        residuals=residuals,
        curve=curve_document(fit.sliding, np.abs([point.velocity for point in points])),
        sliding=sliding,
        presliding=None
        if fit.presliding is None
        else fit_document(rig, axis, fit.presliding, "N", true),
        ramps=[],
        warnings=warnings,
        record=_evidence(experiment, chosen, motion, fit, velocity),
    )
    return document, changes, fit


def _fitted(
    experiment: RecordExperiment,
    axis: str,
    columns: Columns,
    model: AxisModelConfig,
    at: Callable[[float], None],
) -> tuple[Motions, RecordFit, list[str]]:
    """Return motion, fit and doubts of an axis, with the force within samples by turns."""
    find_mass = experiment.request.record.mass is None
    source = force_of(experiment, axis, columns)
    motions = motions_of(source.record, experiment.bandwidth)
    check_sign(motions.sliding, "record.force_column", experiment.axes[axis].force)
    fit = fit_record(motions, model, find_mass=find_mass)
    for count in range(1, _ROUNDS):
        at(count / _ROUNDS)
        better = source.improved(fit.values)
        if better is source:
            break
        source = better
        motions = motions_of(source.record, experiment.bandwidth, motions)
        fit = fit_record(motions, model, find_mass=find_mass, start=fit.values)
    doubts = source.doubts()
    if (normal := experiment.normal_force(axis)) is not None:
        doubts.append(
            f"the normal force of the record, {normal}, takes no part in this fit: "
            "`friction-models` tells whether friction grows with it"
        )
    return motions, fit, doubts


def to_apply(fits: list[Fitted], believed: FrictionConfig) -> tuple[dict[str, float], list[str]]:
    """Return the friction that the old model can take over, and warnings of what it cannot.

    Left out is what the record does not determine: at the edge of its range, without an interval,
    or with half of it beyond the value. If the rest is no model with the old values, all is.

    Parameters
    ----------
    fits : list of Fitted
        Of `RecordFit`.
    believed : FrictionConfig
        The old model.
    """
    values = {name: fit[name] for fit in fits for name in fit.names if name != "f_0"}
    determined = {name for fit in fits for name in fit.names if fit.determines(name)}
    applied = {name: value for name, value in values.items() if name in determined}
    left_out = ", ".join(name for name in values if name not in determined)
    warnings = []
    if left_out:
        warnings.append(f"not applied, because the record does not determine them: {left_out}")
    if is_a_model(applied, believed):
        return applied, warnings
    together = believed.model_copy(update=applied)
    if left_out and together.F_s < together.F_c:
        warnings.append(
            f"F_s would be below F_c with the old model's values for these, {together.F_s:.4g} and "
            f"{together.F_c:.4g} N: no friction of this axis is in `set`"
        )
    else:
        warnings.append("the controller's model cannot take these numbers: none is in `set`")
    return {}, warnings


def contradiction(
    fit: RecordFit, applied: dict[str, float], believed: FrictionConfig, points: list[Point]
) -> str | None:
    """Return why values must not be offered though each has an interval, or None."""
    velocity, force = np.array([(point.velocity, point.force) for point in points]).T
    friction = force - fit.sliding["f_0"]
    rest = float(np.sqrt(np.mean(fit.residuals**2)))
    size = float(np.sqrt(np.mean(friction**2)))
    if rest > _UNEXPLAINED * size:
        return f"the fit leaves {rest:.3g} N rms of a friction of {size:.3g} N rms unexplained"

    def misfit(friction_of: FrictionConfig) -> float:
        known = [getattr(friction_of, name) for name in ("F_c", "F_s", "v_s", "sigma_2")]
        return float(np.sqrt(np.mean((friction - stribeck_curve(velocity, [*known, 0.0])) ** 2)))

    old, new = misfit(believed), misfit(believed.model_copy(update=applied))
    if new > old and not all(fit.sliding.determines(name) for name in SLIDING[:4]):
        return (
            "what the record determines, with the old model's values for the rest, fits it worse "
            f"than the old model, {new:.3g} and {old:.3g} N rms"
        )
    return None


def _evidence(
    experiment: RecordExperiment,
    chosen: AxisColumns,
    motion: Motion,
    fit: RecordFit,
    velocity: Array,
) -> RecordEvidence:
    _, first, last = experiment.part
    half = fit.further.half("lag")
    lag_known = half <= motion.lag_max and "lag" not in fit.further.edge
    return RecordEvidence(
        position=chosen.position,
        force=chosen.force,
        duration=(last - first) * motion.period,
        rate=1.0 / motion.period,
        bandwidth=motion.window.bandwidth,
        noise=motion.noise,
        slowest=float(np.abs(velocity).min()),
        fastest=float(np.abs(velocity).max()),
        reversals=motion.reversals,
        shares=motion.shares,
        condition=fit.condition,
        lag=fit.further["lag"],
        lag_half_width=half if lag_known else None,
        mass_given=experiment.request.record.mass is not None,
    )


def _points(fit: RecordFit, velocity: Array, motion: Motion) -> tuple[list[Point], list[float]]:
    """Return the friction in bins of velocity, and what the fit leaves of it.

    The force of a point is the fitted curve at its mean velocity plus the mean residual of its
    windows: the curve bends within a bin, and the bristle lags behind it.
    """
    speed = np.abs(velocity)
    edges = np.geomspace(speed.min(), speed.max() * (1.0 + 1e-9), _BINS + 1)
    edges[0] = 0.0
    bins = np.searchsorted(edges, speed, "right") - 1
    points, residuals = [], []
    for sign in (1.0, -1.0):
        for k in range(_BINS):
            chosen = (np.sign(velocity) == sign) & (bins == k)
            if int(chosen.sum()) < _FEWEST:
                continue
            mean, rest = float(velocity[chosen].mean()), fit.residuals[chosen]
            left = float(rest.mean())
            curve = float(stribeck_curve(np.array([mean]), fit.sliding.values)[0])
            points.append(
                Point(velocity=mean, force=curve + left, deviation=float(rest.std()), pitches=0)
            )
            residuals.append(left)
    return points, residuals
