"""What of a recording an exported program needs, found from what it puts out.

A field that nothing reads, the parameter that would have filled it and the statements behind them
are left out. So is a state that only its own next value depends on.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from motionlab.targets.record_statements import (
    Assignment,
    CallStatement,
    Carried,
    Loop,
    RecordedFunction,
    Return,
    Statement,
)
from motionlab.targets.record_values import (
    Call,
    Expression,
    Member,
    Read,
    Structure,
    Variable,
    operands_of,
)


class Liveness:
    """Fields, parameters, outputs and assignments that are needed.

    Parameters
    ----------
    entries : iterable of RecordedFunction
        Functions whose results are all needed, but for fields of the classes in `states`.
    states : iterable of class
        NamedTuple classes of which only those fields are needed that are read.
    whole : iterable of class
        NamedTuple classes of which every field is needed, whether it is read or not.
    """

    def __init__(
        self,
        entries: Iterable[RecordedFunction],
        states: Iterable[Any] = (),
        whole: Iterable[Any] = (),
    ) -> None:
        self.functions: dict[RecordedFunction, None] = {}
        self._facts: set[Any] = set()
        self._states = set(states)
        self._grown = True
        for kind in whole:
            self._facts |= {("field", kind, name) for name in kind._fields}
        entries = list(entries)
        for entry in entries:
            for place, value in enumerate(_returned(entry).values):
                self._add(("output", entry, place))
                self._need_whole(value)
            self._add(("parameters", entry))
        while self._grown:
            self._grown = False
            for entry in entries:
                self._function(entry)

    def has_field(self, kind: Any, name: str) -> bool:
        """Tell whether a field of a NamedTuple class is read."""
        return ("field", kind, name) in self._facts

    def has_parameter(self, function: RecordedFunction, parameter: Variable) -> bool:
        """Tell whether a function reads a parameter."""
        return ("parameter", function, parameter) in self._facts

    def has_output(self, function: RecordedFunction, place: int) -> bool:
        """Tell whether somebody needs one of several results of a function."""
        return ("output", function, place) in self._facts

    def has_value(self, variable: Variable, version: int) -> bool:
        """Tell whether a variable's value after so many assignments is read."""
        return ("value", variable, version) in self._facts

    def has_call(self, statement: CallStatement) -> bool:
        """Tell whether some result of a call is read."""
        return any(self.has_value(each.variable, each.version) for each in statement.targets)

    def _add(self, fact: Any) -> None:
        if fact not in self._facts:
            self._facts.add(fact)
            self._grown = True

    def _need_whole(self, value: Expression) -> None:
        """Need every field of what an entry puts out, and of the structures in it."""
        kind = value.kind
        if not hasattr(kind, "_fields") or kind in self._states:
            return
        for name in kind._fields:
            self._add(("field", kind, name))
        if isinstance(value, Structure):
            for each in value.fields.values():
                self._need_whole(each)

    def _function(self, function: RecordedFunction) -> None:
        """Go through a function from its end, and need what its needed results are made of."""
        self.functions.setdefault(function)
        for statement in reversed(function.body):
            self._statement(function, statement)

    def _statement(self, function: RecordedFunction, statement: Statement) -> None:
        match statement:
            case Return(values):
                for place, value in enumerate(values):
                    if not function.outputs or self.has_output(function, place):
                        self._read(function, value)
            case Assignment(variable, version, value):
                if self.has_value(variable, version):
                    self._read(function, value)
            case CallStatement():
                if self.has_call(statement):
                    self._call(function, statement.function, statement.arguments)
                    for place, target in enumerate(statement.targets):
                        if self.has_value(target.variable, target.version):
                            self._add(("output", statement.function, place))
            case Loop():
                self._loop(function, statement)

    def _loop(self, function: RecordedFunction, loop: Loop) -> None:
        for each in loop.carried:
            if any(self.has_value(each.variable, version) for version in _versions(each)):
                for version in (each.before, each.within, each.last):
                    self._add(("value", each.variable, version))
        for statement in reversed(loop.body):
            self._statement(function, statement)

    def _read(self, function: RecordedFunction, value: Expression) -> None:
        match value:
            case Read(variable, version):
                if variable.parameter:
                    self._add(("parameter", function, variable))
                self._add(("value", variable, version))
            case Member(base, name):
                self._add(("field", base.kind, name))
                self._read(function, base)
            case Call(called, arguments):
                self._call(function, called, arguments)
            case Structure(kind, fields):
                for name, each in fields.items():
                    if self.has_field(kind, name):
                        self._read(function, each)
            case _:
                for each in operands_of(value):
                    self._read(function, each)

    def _call(self, function: RecordedFunction, called: RecordedFunction, arguments: Any) -> None:
        self._function(called)
        for parameter, value in arguments.items():
            if self.has_parameter(called, parameter):
                self._read(function, value)


def _returned(function: RecordedFunction) -> Return:
    last = function.body[-1]
    assert isinstance(last, Return)
    return last


def _versions(carried: Carried) -> range:
    return range(carried.before + 1, carried.last + 1)
