"""Writing a variant's controller as an FMU: FMI 3.0 for co-simulation, in C99."""

from __future__ import annotations

from collections.abc import Container, Iterator
from dataclasses import replace
from pathlib import Path

from motionlab.config.controller import CompensationConfig, ControllerConfig, GainsConfig
from motionlab.config.planar import AXES
from motionlab.config.scenario import Scenario
from motionlab.config.validation_errors import bounds_of, unit_of_field
from motionlab.export.controller_code import ControllerCode
from motionlab.export.controller_step import Reference, ReferenceAhead, Signals, reference_of
from motionlab.export.export import controller_of_variant
from motionlab.export.fmu import UnitExport, export_unit
from motionlab.export.model_description import PHASES, Model, Variable
from motionlab.export.sources import SOURCE
from motionlab.files import check_target
from motionlab.kernel.build import lane
from motionlab.kernel.law_calls import law_parameters
from motionlab.lanes.bank import TABLES
from motionlab.laws import LAWS, PARAMETERS
from motionlab.simulation.prepare import prepare
from motionlab.telemetry.channels import CHANNELS, REFERENCES, Channel
from motionlab.timing import CONTROL_PERIOD

CONTROLLER_SOURCE = Path(__file__).with_name("controller_source")
"""The unit's files beside those of the exported controller."""

MODEL_IDENTIFIER = "psrm_controller"

_CONTROLLER = ("psrm_controller.c.in", "psrm_controller.h.in", "psrm_parameters.c.in")
_TABLES = "psrm_tables.h.in"
_GAINS = ("k_p", "k_d")
_AHEAD = (
    *(
        replace(each, name=f"{each.name}_{k}", meaning=f"{each.meaning}, {periods}")
        for k, periods in ((1, "a period ahead"), (2, "two periods ahead"))
        for each in REFERENCES[:3]
    ),
    Channel("phase", "1", "share of the lap that is done"),
)
"""Inputs of a law that looks ahead, in the order of `ReferenceAhead`."""
_INPUTS = {
    *(f"{name}_reference" for name in Reference._fields),
    "position_measured",
    *(each.name for each in _AHEAD),
}
_OTHERS = {"velocity", "current_next", "force_saturated", "current_saturated", "healthy"}
"""Signals that are no number, or that a channel of another name holds."""


def export_controller_fmu(scenario: Scenario, variant: str, path: Path) -> UnitExport:
    """Write a variant's controller as an FMU.

    It has sources, and a binary for this platform where a C compiler is found. Its step is a
    control period, or several: measured positions and references in, then current commands out.

    Parameters
    ----------
    scenario : Scenario
        Resolved scenario; exported is the controller that it begins with.
    variant : str
        One of its variants.
    path : Path
        File to write, ``.fmu``.

    Raises
    ------
    ConfigError
        If there is no such variant, the file cannot be, or the law cannot be recorded.
    Infeasible
        If the motor cannot follow the trajectory.
    MotionLabError
        If a compiler is there and fails.
    StoreError
        If the file cannot be written.
    """
    check_target(str(path), ".fmu")
    code = controller_of_variant(scenario, variant)
    model = Model(
        MODEL_IDENTIFIER,
        f"Position controller of variant {variant} of the scenario {scenario.name}, two axes",
        CONTROL_PERIOD,
        any_step=False,
        seconds=prepare(scenario).reference.ticks * CONTROL_PERIOD,
    )
    return export_unit(
        path,
        model,
        list(_variables(scenario, variant, code)),
        scenario=scenario,
        templates=[*CONTROLLER_SOURCE.iterdir(), *(SOURCE / name for name in _files(code.tables))],
        facts={"variant": variant, **code._asdict()},
    )


def _files(tables: str) -> tuple[str, ...]:
    return (*_CONTROLLER, _TABLES) if tables else _CONTROLLER


def _variables(scenario: Scenario, variant: str, code: ControllerCode) -> Iterator[Variable]:
    controller = scenario.variants[variant].controller
    yield Variable("time", "time", "time", "s", "independent")
    for k, axis in enumerate(AXES):
        law = LAWS[controller.compensation.law]
        for channel, member in _members(k, looks_ahead=reference_of(law) is ReferenceAhead):
            known = channel.name in _INPUTS
            yield Variable(
                f"{axis}.{channel.name}",
                member,
                channel.meaning,
                channel.unit,
                "input" if known else "output",
                start=0.0 if known else None,
            )
        yield from _parameters(scenario, controller, k, code.law_parameters)


def _members(k: int, *, looks_ahead: bool) -> Iterator[tuple[Channel, str]]:
    """Yield the channels that the unit has of an axis, and their places in psrm_memory."""
    members = {
        **{f"{name}_reference": f"reference[{k}].{name}" for name in Reference._fields},
        "position_measured": f"position[{k}]",
        **{
            f"current_command_{phase}": f"out.current[{k}][{number}]"
            for number, phase in enumerate(PHASES)
        },
        **{name: f"out.axis[{k}].{name}" for name in Signals._fields if name not in _OTHERS},
        "velocity_measured": f"out.axis[{k}].velocity",
    }
    for channel in (*REFERENCES, *CHANNELS):
        if channel.name in members:
            yield channel, members[channel.name]
    if looks_ahead:
        fields = ReferenceAhead._fields[len(Reference._fields) :]
        for channel, name in zip(_AHEAD, fields, strict=True):
            yield channel, f"reference[{k}].{name}"


def _parameters(
    scenario: Scenario, controller: ControllerConfig, k: int, of_law: Container[str]
) -> Iterator[Variable]:
    """Yield gains, force limit, and of the law those that the C has as it declares them."""
    axis = AXES[k]
    with TABLES.lease():
        par = lane(scenario, controller, axis)
    law = law_parameters(par)._asdict()
    fields = [
        *((name, GainsConfig, "controller", getattr(par.controller, name)) for name in _GAINS),
        ("force_limit", ControllerConfig, "controller", par.controller.force_limit),
        *(
            (name, CompensationConfig, "law", value)
            for name, value in law.items()
            if name in PARAMETERS and name in of_law
        ),
    ]
    for name, config, group, value in fields:
        info = config.model_fields[name]
        yield Variable(
            f"{axis}.{name}",
            f"par.axis[{k}].{group}.{name}",
            info.description or "",
            unit_of_field(info),
            "parameter",
            start=float(value),
            bounds=bounds_of(info),
        )
