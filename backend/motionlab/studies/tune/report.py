"""Candidates of a search as documents, and the document as text."""

from __future__ import annotations

import math
import textwrap
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.loop.document import WorstMargin
from motionlab.loop.family import LoopFamily, VelocityMargin
from motionlab.studies.tune.documents import (
    Candidate,
    GainMargins,
    GainMetrics,
    TunedAxis,
    TunedGroup,
    TuneDocument,
)
from motionlab.studies.tune.evaluation import Group, Tried, Verdict
from motionlab.studies.tune.problem import Outcome

Array = NDArray[np.float64]


def candidate(  # noqa: PLR0913, PLR0917 - a set of gains and what is known of it
    group: Group,
    values: dict[str, float],
    tried: Tried,
    verdict: Verdict,
    origin: Literal["present", "paper", "start"],
    start: int | None = None,
) -> Candidate:
    """Return a set of gains with its metrics and margins on each motor and the verdict on it."""
    problem = group.problem
    return Candidate(
        origin=origin,
        start=start,
        axes={
            axis: TunedAxis(
                k_p=values[f"{axis}.k_p"],
                k_d=values[f"{axis}.k_d"],
                metrics={name: _metrics(tried[name, axis]) for name in problem.setups},
                margins={
                    motor: _margins(family, *group.gains(values, axis))
                    for (motor, of), family in group.families(values).items()
                    if of == axis
                },
            )
            for axis in group.axes
        },
        also={path: values[path] for path in map(str, group.request.also)},
        **vars(verdict.document()),
        set={problem.path(path): value for path, value in values.items()},
    )


def _metrics(outcome: Outcome) -> GainMetrics:
    figures = {name: getattr(outcome, name) for name in GainMetrics.model_fields}
    return GainMetrics(**(dict.fromkeys(figures) if outcome.diverged else figures))


def _margins(family: LoopFamily, k_p: Array, k_d: Array) -> GainMargins:
    if family.radius(k_p, k_d) >= 1.0:
        return GainMargins(stable=False, gain_margin=None, phase_margin=None, Ms=None)
    figures = family.figures(float(k_p), float(k_d))._asdict()
    return GainMargins(stable=True, **{name: _worst(margins) for name, margins in figures.items()})


def _worst(margin: VelocityMargin) -> WorstMargin | None:
    return WorstMargin(**margin._asdict()) if math.isfinite(margin.value) else None


_HEAD = ("k_p", "k_d", "peak", "rms", "effort", "gain m.", "phase m.", "Ms", "cost")
_UNITS = ("N/mm", "N s/mm", "um", "um", "N", "1", "deg", "1", "")
_WIDTH, _WIDE = 10, 120
_SCALES = {
    "peak": 1e6,
    "rms": 1e6,
    "effort": 1.0,
    "gain_margin": 1.0,
    "phase_margin": 180.0 / math.pi,
    "Ms": 1.0,
}
"""Columns after the gains, and their unit in SI."""


def report(document: TuneDocument) -> str:
    """Return a table of candidates for each axis, warnings below it.

    Parameters
    ----------
    found : TuneDocument
        From `motionlab.studies.tune.search.tune`.
    """
    objective = " + ".join(
        metric if weight == 1.0 else f"{weight:g} {metric}"
        for metric, weight in document.objective.items()
    )
    start, end = document.window
    lines = [
        f"{document.scenario}, gains of {document.variant} on {', '.join(document.plants)}: "
        f"least {objective} "
        f"from {start:g} to {end:g} s, {document.evaluations} sets of gains tried",
    ]
    for group in document.groups:
        lines += ["", *_group(group, document.plants)]
    if document.set:
        lines += ["", "the best of it:"]
        lines += [f"  --set {path}={value:.6g}" for path, value in document.set.items()]
    lines += [f"warning: {warning}" for warning in document.warnings]
    return "\n".join(lines)


def _group(group: TunedGroup, plants: list[str]) -> list[str]:
    worst = ", worst motor" if len(plants) > 1 else ""
    lines = [_row("", _HEAD), _row(f"{' and '.join(group.axes)}{worst}", _UNITS)]
    for candidate in (group.present, group.paper, *group.candidates):
        lines += _candidate(candidate)
    for number, start in enumerate(group.starts):
        lines.append(f"  start {number}: {start.ended} after {len(start.cost)} evaluations")
    return lines


def _candidate(candidate: Candidate) -> list[str]:
    name = candidate.origin if candidate.start is None else f"start {candidate.start}"
    lines = []
    for axis, tuned in candidate.axes.items():
        worst = worst_of(tuned)
        cells = [f"{tuned.k_p / 1e3:.1f}", f"{tuned.k_d / 1e3:.3f}"]
        for quantity, scale in _SCALES.items():
            motor = worst.get(quantity)
            cells.append(_number(motor.value, scale) if motor else "-")
        lines.append(_row(f"  {name} {axis}", [*cells, _number(candidate.cost)]))
        lines += textwrap.wrap(
            _places(worst),
            _WIDE,
            initial_indent="      ",
            subsequent_indent="        ",
        )
    lines += [f"      {path} = {value:.4g}" for path, value in candidate.also.items()]
    lines += [f"      not held: {violation}" for violation in candidate.violations]
    return lines


def _row(name: str, cells: tuple[str, ...] | list[str]) -> str:
    return name.ljust(22) + "".join(cell.rjust(_WIDTH) for cell in cells)


class WorstMotor(NamedTuple):
    """The worst of a quantity over the motors."""

    value: float
    motor: str
    velocity: float | None  # m/s; None for other quantities


def worst_of(tuned: TunedAxis) -> dict[str, WorstMotor]:
    """Return the worst of each quantity over the motors, with the motor.

    Returns
    -------
    dict of str to WorstMotor
        ``peak``, ``rms``, ``effort``, infinite where it diverged, ``gain_margin``,
        ``phase_margin`` and ``Ms``; without the margins that no motor has, and with none of
        them where a loop is unstable.
    """
    worst_motors: dict[str, WorstMotor] = {}
    for quantity in ("peak", "rms", "effort"):
        values = {motor: getattr(metrics, quantity) for motor, metrics in tuned.metrics.items()}
        motor = max(values, key=lambda name: math.inf if values[name] is None else values[name])
        value = values[motor]
        worst_motors[quantity] = WorstMotor(math.inf if value is None else value, motor, None)
    if not all(margins.stable for margins in tuned.margins.values()):
        return worst_motors
    for quantity, worst in (("gain_margin", min), ("phase_margin", min), ("Ms", max)):
        margins = [
            WorstMotor(margin.value, motor, margin.velocity)
            for motor, every in tuned.margins.items()
            if (margin := getattr(every, quantity)) is not None
        ]
        if margins:
            worst_motors[quantity] = worst(margins)
    return worst_motors


def _places(worst: dict[str, WorstMotor]) -> str:
    """Return the motor and the velocity at which each quantity is worst."""
    of: dict[str, list[str]] = {}
    for quantity, (_, motor, velocity) in worst.items():
        where = "" if velocity is None else f" ({velocity * 1e3:.3g} mm/s)"
        where = " (standstill)" if velocity == 0.0 else where
        of.setdefault(motor, []).append(f"{quantity.replace('_', ' ')}{where}")
    return "; ".join(f"worst on {motor}: {', '.join(names)}" for motor, names in of.items())


def _number(value: float | None, scale: float = 1.0) -> str:
    if value is None:
        return "-"
    return f"{value * scale:.4g}" if math.isfinite(value) else "diverged"
