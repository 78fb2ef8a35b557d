"""Step of commissioning: friction, identified from a recorded run of slow motions."""

from __future__ import annotations

import time

from motionlab.config.load import load_scenario
from motionlab.config.planar import AXES
from motionlab.config.scenario import Scenario
from motionlab.drive.commissioning.field import SCENARIO, VARIANT
from motionlab.drive.commissioning.hold import low_gain_changes
from motionlab.drive.commissioning.record import Finding, FoundFigure
from motionlab.drive.commissioning.run import StepRun
from motionlab.drive.motion import held_parameters, on_drives
from motionlab.drive.plug.recorded_step import RecordedStep
from motionlab.studies.identify.documents import (
    AxisIdentification,
    IdentificationDocument,
    Parameter,
)

SPEEDS = (0.001, 0.0025, 0.005, 0.01, 0.02, 0.04, 0.08)
"""Of each axis, m/s."""

DISTANCES = (0.003, 0.005, 0.008, 0.012, 0.02, 0.03, 0.03)
"""Of each axis at each speed, there and back, m."""

_ACCELERATION, _DWELL = 0.4, 0.2  # m/s^2, s
_DIFFERS = 0.1


class FrictionStep(RecordedStep):
    """The step, for a server that records runs."""

    def __call__(self, run: StepRun) -> Finding:
        """Move slowly, record, identify; called in a thread.

        Raises
        ------
        Stopped
            If it was ended before.
        """
        with run.part(0.0, 0.02, "low gains"):
            scenario = slow_motions(run)
            parameters = held_parameters(scenario)
        with run.holding(parameters):
            with run.part(0.02, 0.8, "slow motions of both axes, recorded"):
                identifier = self.recorded(run, scenario)
        with run.part(0.8, 1.0, f"identification from {identifier}"):
            body = {"run": identifier, "axis": "both"}
            document = self.study(run, "identify", body, IdentificationDocument)
        return finding_of(document, identifier)


def slow_motions(run: StepRun) -> Scenario:
    """Return both axes moving there and back at constant speeds, with low gains."""
    start = {
        axis: (config.position_min + config.position_max) / 2
        for axis in AXES
        for config in (getattr(run.config, axis),)
    }
    room = min(
        0.4 * (config.position_max - config.position_min)
        for config in (getattr(run.config, axis) for axis in AXES)
    )
    parts = [
        {
            "kind": "trapezoid",
            "start": start,
            "end": {axis: start[axis] + min(distance, room) for axis in AXES},
            "v_max": 2**0.5 * speed,  # along the diagonal: each axis has its share
            "a_max": 2**0.5 * _ACCELERATION,
            "dwell": _DWELL,
        }
        for speed, distance in zip(SPEEDS, DISTANCES, strict=True)
    ]
    changes = low_gain_changes() | {
        "name": "commissioning",
        "trajectory": {"kind": "sequence", "parts": parts},
    }
    return on_drives(load_scenario(SCENARIO, changes), VARIANT)


def finding_of(document: IdentificationDocument, run: str) -> Finding:
    """Return what was identified beside the model of the controllers."""
    rows, different = [], []
    for axis in AXES:
        identified = document.axes.get(axis)
        if identified is None:
            rows.append(FoundFigure(name=axis, found="nothing", expected="", holds=False))
            continue
        for name, parameter in _parameters(identified):
            rows.append(_row(f"{axis} {name}", parameter))
            believed = parameter.believed
            if believed and abs(parameter.value - believed) > _DIFFERS * believed:
                different.append(f"{axis} {name}")
    unknown = [row.name for row in rows if not row.holds]
    text = f"identified from {run}"
    if unknown:
        text = f"not determined by {run}: {', '.join(unknown)}"
    elif different:
        text += f"; other than in the model of {SCENARIO} by more than 10 %: {', '.join(different)}"
    return Finding(at=time.time(), holds=not unknown, text=text, rows=rows, run=run)


def _parameters(identified: AxisIdentification) -> list[tuple[str, Parameter]]:
    return [
        (name, identified.sliding.parameters[name]) for name in ("F_c", "F_s", "v_s", "sigma_2")
    ]


def _row(name: str, parameter: Parameter) -> FoundFigure:
    known = parameter.low is not None and parameter.high is not None
    span = f"{parameter.low:.4g} to {parameter.high:.4g}" if known else "not determined"
    believed = "" if parameter.believed is None else f"{parameter.believed:.4g} {parameter.unit}"
    return FoundFigure(
        name=name,
        found=f"{parameter.value:.4g} {parameter.unit} ({span})",
        expected=believed,
        holds=known,
    )
