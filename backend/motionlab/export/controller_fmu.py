"""Writing a variant's controller as an FMU: FMI 3.0 for co-simulation, in C99."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from motionlab.config.controller import (
    CompensationConfig,
    ControllerConfig,
    GainsConfig,
)
from motionlab.config.planar import AXES
from motionlab.config.scenario import Scenario
from motionlab.config.validation_errors import bounds_of, unit_of_field
from motionlab.export.controller_step import Signals
from motionlab.export.export import controller_of_variant
from motionlab.export.fmu import SOURCE, UnitExport, export_unit
from motionlab.export.model_description import PHASES, Model, Variable
from motionlab.files import check_target
from motionlab.kernel.build import lane
from motionlab.kernel.law_calls import law_parameters
from motionlab.lanes.bank import TABLES
from motionlab.laws import PARAMETERS
from motionlab.simulation.prepare import prepare
from motionlab.targets.record_source import field_comments
from motionlab.timing import CONTROL_PERIOD

CONTROLLER_SOURCE = Path(__file__).with_name("controller_source")
"""The unit's files beside those of the exported controller."""

MODEL_IDENTIFIER = "psrm_controller"

_CONTROLLER = ("psrm_controller.c.in", "psrm_controller.h.in", "psrm_parameters.c.in")
_TABLES = "psrm_tables.h.in"
_GAINS = ("k_p", "k_d")
_REFERENCE = (("position", "m"), ("velocity", "m/s"), ("acceleration", "m/s^2"))
_NOT_NUMBERS = {"current_next", "force_saturated", "current_saturated", "healthy"}


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
        list(_variables(scenario, variant, code.public_types)),
        scenario=scenario,
        templates=[*CONTROLLER_SOURCE.iterdir(), *(SOURCE / name for name in _files(code.tables))],
        facts={"variant": variant, **code._asdict()},
    )


def _files(tables: str) -> tuple[str, ...]:
    return (*_CONTROLLER, _TABLES) if tables else _CONTROLLER


def _variables(scenario: Scenario, variant: str, types: str) -> Iterator[Variable]:
    """Yield the variables; parameters of the law as it declares them, where C has them as such."""
    controller = scenario.variants[variant].controller
    yield Variable("time", "time", "time", "s", "independent")
    for k, axis in enumerate(AXES):
        for name, unit in _REFERENCE:
            yield Variable(
                f"{axis}.{name}_reference",
                f"reference[{k}].{name}",
                f"{name} reference",
                unit,
                "input",
                start=0.0,
            )
        yield Variable(
            f"{axis}.position_measured",
            f"position[{k}]",
            "measured position",
            "m",
            "input",
            start=0.0,
        )
        for number, phase in enumerate(PHASES):
            yield Variable(
                f"{axis}.current_command_{phase}",
                f"out.current[{k}][{number}]",
                f"current command of phase {phase}, in effect now",
                "A",
                "output",
            )
        for name, about in field_comments(Signals).items():
            if name not in _NOT_NUMBERS:
                described, _, unit = about.rpartition(", ")
                yield Variable(
                    f"{axis}.{name}",
                    f"out.axis[{k}].{name}",
                    described or name.replace("_", " "),
                    unit,
                    "output",
                )
        yield from _parameters(scenario, controller, k, types)


def _parameters(
    scenario: Scenario, controller: ControllerConfig, k: int, types: str
) -> Iterator[Variable]:
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
            if name in PARAMETERS and f"    double {name};" in types
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
