"""Recording functions of both axes, which may have force maps of different kinds."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from motionlab.targets.c_expression import INDENT
from motionlab.targets.c_program import Program
from motionlab.targets.record_statements import RecordedFunction
from motionlab.targets.record_values import TABLE, Constant, Expression, Read, Variable

BANK: Expression = Read(Variable("tables", TABLE))
"""Stands for the array of all tables while a function is recorded."""


def fixed_place(first: float) -> Constant:
    """Return the place of a table, of which only it is fixed whether there is one."""
    if first < 0.0:
        return Constant(-1.0, structural=True)
    return Constant(1.0, structural=True, kept=True)


def entries_by_axis(functions: Mapping[str, RecordedFunction]) -> dict[str, RecordedFunction]:
    """Return functions by name: one for both axes, or one with the axis's name at its end."""
    alike = len(set(functions.values())) == 1
    return {
        each.source.name if alike else f"{each.source.name}_{axis}": each
        for axis, each in functions.items()
    }


def call_by_axis(  # noqa: PLR0913 - a call and where it stands
    program: Program,
    functions: Mapping[str, RecordedFunction],
    arguments: Mapping[str, str],
    *outputs: str,
    target: str = "",
    index: str,
    indent: str,
) -> str:
    """Return the statement that calls the function of an axis, whose number is `index` in C."""

    def statement(function: RecordedFunction, indent: str) -> Iterator[str]:
        head = indent + (f"{target} = " if target else "")
        lines = program.call(function, arguments, *outputs, column=len(head))
        yield from (
            [head + lines[0], *lines[1:-1], f"{lines[-1]};"]
            if len(lines) > 1
            else [f"{head}{lines[0]};"]
        )

    first, *others = dict.fromkeys(functions.values())
    if not others:
        return "\n".join(statement(first, indent))
    return "\n".join(
        [
            f"{indent}if ({index} == 0U) {{",
            *statement(first, indent + INDENT),
            f"{indent}}} else {{",
            *statement(others[0], indent + INDENT),
            f"{indent}}}",
        ]
    )
