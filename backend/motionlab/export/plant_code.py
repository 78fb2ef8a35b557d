"""A scenario's motor as C: its functions from the kernel's, and its tables."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from motionlab.config.planar import AXES
from motionlab.config.scenario import Scenario
from motionlab.export.plant_step import (
    PlantInput,
    PlantParameters,
    Step,
    measure_axis,
    reset_axis,
    sample_axis,
    step_axis,
)
from motionlab.export.recording import BANK, call_by_axis, entries_by_axis, fixed_place
from motionlab.export.tables import Tables
from motionlab.kernel.force_maps import map_lanes
from motionlab.kernel.layout import PlantState
from motionlab.lanes.bank import TABLES
from motionlab.plant.table_map import NORMAL_TERMS, THRUST_TERMS, TableMap
from motionlab.targets.c_expression import INDENT
from motionlab.targets.c_program import Program
from motionlab.targets.c_values import initial_values
from motionlab.targets.record import Recorder
from motionlab.targets.record_arguments import zeros
from motionlab.targets.record_statements import RecordedFunction

_ARGUMENTS = {
    "par": "par",
    "h": "h",
    "sampled_step": "step",
    "table": "&TABLE[axis]",
    "at": "input",
    "s": "state",
    "tables": "TABLES",
}
"""What the functions of psrm_plant.c pass on."""

_NAMES = {Step: "psrm_plant_sampled"}


class PlantCode(NamedTuple):
    """C of a motor."""

    public_types: str
    private_types: str
    functions: str
    reset: str  # statement that gives the state at the start
    sample: str  # statement that gives the coefficients of steps
    step: str  # statement that gives the next state
    measure: str  # statement that gives the outputs
    tables: str  # definitions of arrays; empty with formulas alone


def plant_code(scenario: Scenario) -> PlantCode:
    """Return the motor of a scenario as C, recorded for the kinds of force maps that it has.

    Raises
    ------
    ConfigError
        If a force map is not there, or cannot be read.
    """
    tables = Tables()
    with TABLES.lease():
        maps = {axis: _placed(scenario, axis, tables) for axis in AXES}
    recorder = Recorder()
    par, state = zeros(PlantParameters), zeros(PlantState)
    sampling = {axis: recorder.record(sample_axis, {"par": par, "h": 0.0}) for axis in AXES}
    resets = {axis: recorder.record(reset_axis, {"par": par}) for axis in AXES}
    steps: dict[str, RecordedFunction] = {}
    measures: dict[str, RecordedFunction] = {}
    for axis, table in maps.items():
        fixed = table._replace(thrust=fixed_place(table.thrust), normal=fixed_place(table.normal))
        reads = {
            "table": fixed,
            "at": zeros(PlantInput),
            "s": state,
            "tables": BANK if table.thrust >= 0.0 else None,
        }
        step = {"par": par, "sampled_step": zeros(Step), **reads}
        steps[axis] = recorder.record(step_axis, step)
        measures[axis] = recorder.record(measure_axis, {"par": par, **reads})
    entries: dict[str, RecordedFunction] = {}
    for functions in (resets, sampling, steps, measures):
        entries |= entries_by_axis(functions)
    program = Program(entries, type_names=_NAMES)

    def call(functions: Mapping[str, RecordedFunction], target: str) -> str:
        code = call_by_axis(
            program, functions, _ARGUMENTS, target=target, index="axis", indent=INDENT
        )
        return code if "axis" in code.replace("_axis(", "") else f"{INDENT}(void)axis;\n{code}"

    return PlantCode(
        public_types=program.types(public=True),
        private_types=program.types(public=False),
        functions=program.functions(),
        reset=call(resets, "*state"),
        sample=call(sampling, "*step"),
        step=call(steps, "*state"),
        measure=call(measures, "*output"),
        tables=_tables(program, maps, tables),
    )


def _placed(scenario: Scenario, axis: str, tables: Tables) -> TableMap:
    """Return the table of an axis's force map at its place among exported ones."""
    table = map_lanes(getattr(scenario.plant, axis).force_map).table
    cells = (int(table.positions), int(table.currents))
    thrust, normal = (
        f"{quantity}, N, [position][current][term]" for quantity in ("thrust", "normal force")
    )
    return table._replace(
        thrust=tables.place(table.thrust, (*cells, THRUST_TERMS), thrust),
        normal=tables.place(table.normal, (*cells, NORMAL_TERMS), normal),
    )


def _tables(program: Program, maps: Mapping[str, TableMap], tables: Tables) -> str:
    array = tables.code()
    if not array:
        return ""
    lines = [array, "", f"static const {program.type_name(TableMap)} TABLE[] = {{"]
    for axis, table in maps.items():
        lines += [f"{INDENT}{{ /* {axis} */", *initial_values(program, table, 2 * INDENT)]
        lines.append(f"{INDENT}}},")
    return "\n".join([*lines, "};", ""])
