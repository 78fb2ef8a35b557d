"""A variant's controller as C: its functions from the kernel's, and its numbers."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple, get_type_hints

from motionlab.config.planar import AXES
from motionlab.config.scenario import Scenario
from motionlab.export.controller_step import (
    AxisState,
    Signals,
    reference_of,
    step_of,
    with_law,
)
from motionlab.export.recording import BANK, call_by_axis, entries_by_axis, fixed_place
from motionlab.export.sources import interface_names
from motionlab.export.tables import Tables
from motionlab.force_sharing.functions import CLOSED_FORM, FUNCTIONS, function_of
from motionlab.force_sharing.share import ForceModel, Sharing, forces_by, phase_forces
from motionlab.force_sharing.tables import INVERSE_CELLS
from motionlab.kernel.build import lane
from motionlab.kernel.law_calls import law_parameters
from motionlab.kernel.layout import Command, ControllerState, Parameters
from motionlab.lanes.bank import TABLES
from motionlab.laws import LAWS
from motionlab.plant.magnetics import Phases
from motionlab.plant.table_map import THRUST_TERMS, TableMap
from motionlab.targets.c_expression import INDENT
from motionlab.targets.c_program import Program
from motionlab.targets.c_values import initial_values
from motionlab.targets.c_words import safe
from motionlab.targets.record import Recorder
from motionlab.targets.record_arguments import zeros
from motionlab.targets.record_values import Constant

_ARGUMENTS = {
    "par": "&parameters->axis[k]",
    "s": "&state->axis[k]",
    "reference": "&reference[k]",
    "position": "position[k]",
    "tables": "TABLES",
}
"""What psrm_step passes on."""


class ControllerCode(NamedTuple):
    """C of a controller."""

    public_types: str
    private_types: str
    functions: str
    reset: str  # statements that clear the state of an axis
    step: str  # statements that advance both axes
    values: str  # the initialiser of psrm_parameters
    tables: str  # definition of an array; empty with formulas alone
    law_parameters: tuple[str, ...]  # fields of the law's parameters that the C reads


def controller_code(scenario: Scenario, variant: str) -> ControllerCode:
    """Return the controller of a variant at the start of a scenario as C.

    Its functions are those of the kernel, recorded for the laws, sharing functions and kinds of
    maps that the variant has; its numbers stay parameters.

    Raises
    ------
    ConfigError
        If a force map is not there, or cannot be read.
    """
    controller = scenario.variants[variant].controller
    tables = Tables()
    with TABLES.lease():
        plain = {axis: _with_tables(lane(scenario, controller, axis), tables) for axis in AXES}
    law = LAWS[controller.compensation.law]
    parameters, state = with_law(Parameters, law.Parameters), with_law(AxisState, law.State)
    lanes = {
        axis: parameters(*par._replace(law=law_parameters(par))) for axis, par in plain.items()
    }
    sharing = FUNCTIONS[controller.sharing.law]
    recorder, step_axis = Recorder({phase_forces: forces_by(sharing)}), step_of(law)
    reference = reference_of(law)
    steps = {
        axis: recorder.record(step_axis, _arguments(par, state, reference))
        for axis, par in lanes.items()
    }
    program = Program(
        entries_by_axis(steps),
        states=(state, law.State, ControllerState, Command),
        whole=(reference,),
        type_names={
            parameters: "psrm_axis_parameters",
            state: "psrm_axis_state",
            reference: "psrm_reference",
            Phases: "psrm_phases",
            Signals: "psrm_signals",
        },
        taken=interface_names(),
    )
    step = call_by_axis(
        program,
        steps,
        _ARGUMENTS,
        "&next",
        "&current",
        "&output->axis[k]",
        index="k",
        indent=2 * INDENT,
    )
    return ControllerCode(
        public_types=program.types(public=True),
        private_types=program.types(public=False),
        functions=program.functions(),
        reset="\n".join(_reset_lines(program, state, f"{2 * INDENT}state->axis[k].")),
        step=step,
        values="\n".join(_value_lines(program, lanes)),
        tables=tables.code(),
        law_parameters=tuple(program.fields(law.Parameters)),
    )


def _with_tables(par: Parameters, tables: Tables) -> Parameters:
    """Return a lane's parameters with the places of its tables among exported ones."""
    table, sharing = par.force_model.map.table, par.force_model.sharing
    cells = (int(table.positions), int(table.currents), THRUST_TERMS)
    own = function_of(sharing.law).table
    table = table._replace(
        thrust=tables.place(table.thrust, cells, "thrust, N, [position][current][term]")
    )
    sharing = sharing._replace(
        inverse=tables.place(
            sharing.inverse, INVERSE_CELLS, "current, A, [position][sqrt(thrust)][corner]"
        ),
        table=tables.place(sharing.table, own.shape, own.about) if own else sharing.table,
    )
    return par._replace(force_model=_with_table(par.force_model, table, sharing))


def _arguments(par: Parameters, state: Any, reference: Any) -> dict[str, Any]:
    """Return what the step of an axis is recorded with."""
    model = par.force_model
    tabled = model.map.table.thrust >= 0.0 or model.sharing.law != CLOSED_FORM
    sharing = model.sharing._replace(
        law=Constant(model.sharing.law, structural=True),
        inverse=fixed_place(model.sharing.inverse),
        table=fixed_place(model.sharing.table),
    )
    table = model.map.table._replace(thrust=fixed_place(model.map.table.thrust))
    fixed = par._replace(force_model=_with_table(model, table, sharing))
    return {
        "par": fixed,
        "s": zeros(state),
        "reference": zeros(reference),
        "position": 0.0,
        "tables": BANK if tabled else None,
    }


def _with_table(model: ForceModel, table: TableMap, sharing: Sharing) -> ForceModel:
    return model._replace(map=model.map._replace(table=table), sharing=sharing)


def _reset_lines(program: Program, kind: Any, path: str) -> Iterator[str]:
    """Yield the statements that clear a state."""
    hints = get_type_hints(kind)
    for name in program.fields(kind):
        if hasattr(hints[name], "_fields"):
            yield from _reset_lines(program, hints[name], f"{path}{safe(name)}.")
        else:
            yield f"{path}{safe(name)} = 0.0;"


def _value_lines(program: Program, lanes: Mapping[str, Parameters]) -> Iterator[str]:
    yield "{"
    yield f"{INDENT}.axis = {{"
    for axis, par in lanes.items():
        yield f"{2 * INDENT}{{ /* {axis} */"
        yield from initial_values(program, par, 3 * INDENT)
        yield f"{2 * INDENT}}},"
    yield f"{INDENT}}},"
    yield "}"
