"""Selection of a friction model from a run."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from motionlab import __version__
from motionlab.errors import ExperimentFailed
from motionlab.library.columns import of_run
from motionlab.studies.friction.candidates import CANDIDATES, LOADED, LUGRE, STRIBECK, Candidate
from motionlab.studies.friction.choose import Choice, choose, difference, rms
from motionlab.studies.friction.documents import (
    FrictionModel,
    FrictionModelsDocument,
    ModelParameter,
)
from motionlab.studies.friction.fit import (
    Array,
    Estimate,
    Fit,
    Windows,
    fit,
    held_out,
    parameters_of,
    windows_of,
)
from motionlab.studies.friction.lack_of_fit import LackOfFit, lack_of_fit
from motionlab.studies.friction.record import Forces, FrictionPlan, read
from motionlab.studies.identify.record.motion import Motion, Motions, check_sign, motions_of

_ROUNDS = 3
"""Fits at most by which currents within a sample are found."""

_FEWEST_REVERSALS, _FEWEST_WINDOWS = 4, 40
"""Reversals, and windows about them, without which no bristle is tried."""

_STEADY = 1e-6
"""Change of the force, as a share of its largest, within which it is constant."""
_SIGNED = 0.01
"""Share of samples of either sign from which a normal force is doubted."""

_CONSTANT = 0.05
"""Change of the normal force, as a share of its mean, below which it is no cause."""


def select(
    plan: FrictionPlan, progress: Callable[..., None] = lambda *_: None
) -> FrictionModelsDocument:
    """Compare friction models on a run.

    Parameters
    ----------
    plan : FrictionPlan
        From `motionlab.studies.friction.record.plan`.
    progress : callable
        Takes the share done.

    Raises
    ------
    ExperimentFailed
        If the axis moved too little.
    ConfigError
        If the sign of the force is reversed.
    """
    forces = read(plan, of_run(plan.run.id))
    windows = _windows(plan, forces)
    _check_force(windows)
    bristles = _without_bristles(windows)
    notes = _without_load(windows)
    rough = [fit(windows, STRIBECK), fit(windows, LUGRE)]
    if notes is None:
        rough.append(fit(windows, LOADED, rough[-1]))
    windows = windows.weighted(min(rough, key=lambda each: rms(each.rest)))
    tried = [
        each
        for each in CANDIDATES
        if (bristles is None or not _has_bristle(each)) and (notes is None or each is not LOADED)
    ] + [*plan.effects()]
    fits: dict[str, Fit] = {}
    errors: dict[str, Array] = {}
    lugre: Fit | None = None
    for k, candidate in enumerate(tried):
        progress(0.2 + 0.8 * k / len(tried))
        fits[candidate.name] = fit(windows, candidate, lugre)
        errors[candidate.name] = held_out(windows, fits[candidate.name])
        if candidate is LUGRE:
            lugre = fits[LUGRE.name]
    left_out = {c.name: bristles for c in CANDIDATES if bristles and _has_bristle(c)}
    if notes is not None:
        left_out.pop(LOADED.name, None)
    choice = choose(windows, fits, errors, left_out)
    best = errors[choice.best]
    lack = lack_of_fit(windows, fits[choice.selected or choice.best], choice.friction)
    models = [
        _model(windows, fits[name], errors[name], best, choice.explained)
        for name in sorted(fits, key=lambda name: fits[name].candidate.order)
    ]
    remarks = [each for each in (notes, _signed(plan, forces)) if each is not None]
    lack = lack._replace(notes=(*remarks, *lack.notes))
    return _document(plan, windows, models, choice, lack)


def _check_force(windows: Windows) -> None:
    force = windows.motion.of(windows.motion.force, 0)[windows.used]
    if not np.ptp(force) > _STEADY * np.max(np.abs(force)):
        raise ExperimentFailed(
            f"the force is {float(force.mean()):.3g} {windows.machine.force} throughout: there is "
            "no friction to compare models on"
        )


def _windows(plan: FrictionPlan, forces: Forces) -> Windows:
    """Return the windows of a run, with currents between samples as a LuGre fit has them."""
    motion = _motion(plan, forces)
    check_sign(motion, "force_column", _sources(plan)[1])
    mass = plan.request.mass
    if mass is not None:
        mass /= plan.machine.unit_of("M")[1]
    windows = windows_of(motion, forces.normal, mass, plan.machine)
    for _ in range(_ROUNDS):
        if "within" not in windows.names:
            break
        own = len(LUGRE.linear)
        fitted = fit(windows, LUGRE)
        share = float(fitted.linear[own + windows.names.index("within")])
        better = forces.improved(share)
        if better is forces:
            break
        forces = better
        motion = _motion(plan, forces, motion)
        windows = windows_of(motion, forces.normal, mass, plan.machine)
    return windows


def _motion(plan: FrictionPlan, forces: Forces, like: Motion | None = None) -> Motion:
    both = None if like is None else Motions(like, like)
    return motions_of(forces.record, plan.bandwidth, both).turning


def _has_bristle(candidate: Candidate) -> bool:
    return any(shape.name == "x_0" for shape in candidate.shapes)


def _without_bristles(windows: Windows) -> str | None:
    """Return why no model with a bristle is tried, if so."""
    motion = windows.motion
    if motion.reversals < _FEWEST_REVERSALS:
        return (
            f"the record has {motion.reversals} reversals, {_FEWEST_REVERSALS} are needed: only "
            "models of sliding can be compared"
        )
    about = int((~motion.sliding[windows.used]).sum())
    if about >= _FEWEST_WINDOWS:
        return None
    hidden = float(np.median(motion.hidden[~motion.sliding])) if (~motion.sliding).any() else 0.0
    return (
        "reversals are too fast for the sampling, or the encoder is too coarse: the filter hides "
        f"{windows.machine.displacement(hidden)} of them, so only models of sliding can be compared"
    )


def _without_load(windows: Windows) -> str | None:
    """Return why friction by normal force is not tried, if so."""
    normal = windows.path.normal
    if normal is None:
        return f"{LOADED.label} is not tried: the record has no normal force"
    mean, spread = float(np.nanmean(normal)), float(np.nanstd(normal))
    if spread > _CONSTANT * abs(mean):
        return None
    return f"{LOADED.label} is not tried: the normal force, {mean:.3g} N, hardly changes"


def _signed(plan: FrictionPlan, forces: Forces) -> str | None:
    """Return a warning of a normal force of both signs."""
    normal = forces.normal
    if normal is None or not plan.columns:
        return None
    negative = float(np.mean(normal[np.isfinite(normal)] < 0.0))
    if not _SIGNED < negative < 1.0 - _SIGNED:
        return None
    return (
        f"{plan.columns[-1]} is negative in {100.0 * negative:.3g} % of the record, which no "
        "normal force is: if its magnitude loads the guide, set normal_force_magnitude"
    )


def _model(
    windows: Windows, fitted: Fit, errors: Array, best: Array, explained: bool
) -> FrictionModel:
    gap = difference(errors, best, windows.block)
    candidate = fitted.candidate
    return FrictionModel(
        name=candidate.name,
        label=candidate.label,
        complexity=candidate.order,
        error=rms(errors),
        difference=gap.value,
        difference_error=gap.error,
        fitted=rms(fitted.rest),
        parameters={
            key: _parameter(windows, candidate, key, estimate)
            for key, estimate in (parameters_of(windows, fitted) if explained else {}).items()
        },
    )


def _document(
    plan: FrictionPlan,
    windows: Windows,
    models: list[FrictionModel],
    choice: Choice,
    lack: LackOfFit,
) -> FrictionModelsDocument:
    motion = windows.motion
    position, force = _sources(plan)
    return FrictionModelsDocument(
        run=plan.run.id,
        name=plan.run.name,
        axis=plan.request.axis,
        position=position,
        force=force,
        normal_force=_normal_source(plan, windows),
        force_unit=plan.machine.force,
        duration=len(motion.position) * motion.period,
        rate=1.0 / motion.period,
        bandwidth=motion.window.bandwidth,
        reversals=motion.reversals,
        windows=len(windows.used),
        friction=choice.friction,
        models=models,
        best=choice.best,
        selected=choice.selected,
        among=list(choice.among),
        reasons=list(choice.reasons),
        describes=choice.explained and lack.describes,
        notes=list(lack.notes),
        version=__version__,
    )


def _sources(plan: FrictionPlan) -> tuple[str, str]:
    """Return the columns of position and force."""
    if plan.experiment is None:
        return plan.columns[0], plan.columns[1]
    axis = plan.experiment.axes[plan.request.axis]
    return axis.position, axis.force


def _normal_source(plan: FrictionPlan, windows: Windows) -> str | None:
    if windows.path.normal is None:
        return None
    last = plan.columns[-1] if plan.columns else None
    if plan.experiment is None:
        return last
    return last or "currents"


def _parameter(
    windows: Windows, candidate: Candidate, name: str, estimate: Estimate
) -> ModelParameter:
    unit, factor = windows.machine.unit_of(name)
    if name in candidate.units:
        unit, factor = candidate.units[name], 1.0
    value, half = factor * estimate.value, factor * estimate.half
    known = np.isfinite(half)
    return ModelParameter(
        value=value,
        unit=unit,
        low=float(value - half) if known else None,
        high=float(value + half) if known else None,
    )
