"""Statements of recorded functions."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from motionlab.targets.record_source import FunctionSource
from motionlab.targets.record_structures import expression_of
from motionlab.targets.record_values import Expression, Read, Variable


@dataclass(eq=False)
class Assignment:
    """A variable gets a value; `line` is that of the Python source."""

    variable: Variable
    version: int
    value: Expression
    line: int


@dataclass(eq=False)
class CallStatement:
    """A call that returns several values, each to a variable."""

    function: RecordedFunction
    arguments: Mapping[Variable, Expression]
    targets: list[Read]
    line: int


@dataclass(eq=False)
class Carried:
    """A variable that each turn of a loop takes over from the one before."""

    variable: Variable
    before: int
    within: int
    last: int = 0


@dataclass(eq=False)
class Loop:
    """A block that is repeated."""

    count: Expression
    line: int
    carried: list[Carried] = field(default_factory=list)
    body: list[Statement] = field(default_factory=list)


@dataclass(eq=False)
class Return:
    """The values of a function, one or several."""

    values: list[Expression]
    line: int


Statement = Assignment | CallStatement | Loop | Return


@dataclass(eq=False)
class RecordedFunction:
    """A lane function as it runs for arguments of certain kinds and structural constants."""

    source: FunctionSource
    parameters: list[Variable] = field(default_factory=list)
    body: list[Statement] = field(default_factory=list)
    outputs: list[Variable] = field(default_factory=list)
    result: Any = None
    names: set[str] = field(default_factory=set)

    @property
    def kind(self) -> Any:
        """Kind of the one value that it returns; None where it returns several."""
        return None if self.outputs else expression_of(self.result).kind


def walk(body: Sequence[Statement]) -> Iterator[Statement]:
    """Yield the statements of a block and of the blocks in it."""
    for statement in body:
        yield statement
        if isinstance(statement, Loop):
            yield from walk(statement.body)


def assigned(statement: Statement) -> list[tuple[Variable, int]]:
    """Return the variables that a statement gives a value, with their versions."""
    match statement:
        case Assignment(variable, version):
            return [(variable, version)]
        case CallStatement():
            return [(each.variable, each.version) for each in statement.targets]
        case _:
            return []
