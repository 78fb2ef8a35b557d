"""Recording of lane functions: each runs once, on expressions instead of lanes.

What Python decides meanwhile, such as ``if tables is None`` or a comparison with a structural
constant, is not in the recording. A call of another lane function is recorded as a call.
"""

from __future__ import annotations

import inspect
import math
import traceback
from collections.abc import Callable, Iterable, Iterator, Mapping
from types import FunctionType
from typing import Any

from motionlab.targets.record_arguments import (
    MATHS,
    PRIMITIVES,
    parameter_of,
    signature_of,
    value_like,
)
from motionlab.targets.record_source import HOOK, plain, source_of
from motionlab.targets.record_statements import (
    Assignment,
    CallStatement,
    Carried,
    Loop,
    RecordedFunction,
    Return,
    Statement,
)
from motionlab.targets.record_structures import (
    expression_of,
    is_structural,
    snake,
)
from motionlab.targets.record_values import (
    Call,
    Constant,
    Expression,
    LocatedError,
    Member,
    Read,
    RecordError,
    Structure,
    Variable,
    value_of,
)

LOOP_MAX = 100_000
"""Turns of a loop that is recorded once, where their number is known."""
TURNS_MAX = 10_000
"""Most turns of loops in a recording, but for those whose turns are all alike."""


class _Several(tuple[Any, ...]):
    """What a call returns that returns several values, until they are named."""

    statement: CallStatement
    like: tuple[Any, ...]


class _Frame:
    """A function while it is recorded."""

    def __init__(self, function: RecordedFunction) -> None:
        self.function = function
        self.blocks: list[list[Statement]] = [function.body]
        self.loops: list[Loop] = []
        self.variables: dict[str, Variable] = {each.name: each for each in function.parameters}
        self.names = function.names
        self.names |= set(self.variables)

    def new_variable(self, label: str, kind: Any, *, pointer: bool = False) -> Variable:
        name, number = label, 2
        while name in self.names:
            name, number = f"{label}_{number}", number + 1
        self.names.add(name)
        return Variable(name, kind, pointer)

    def free_name(self, label: str) -> str:
        """Return a name of an output."""
        return f"{label}_out" if label in self.names else label

    def target(self, label: str, kind: Any) -> tuple[Variable, int]:
        """Return the variable of a name that holds values of such a kind, and its next version."""
        variable = self.variables.get(label)
        if variable is None or variable.kind is not kind or variable.pointer:
            variable = self.variables[label] = self.new_variable(label, kind)
        else:
            variable.versions += 1
        return variable, variable.versions - 1


class Recorder:
    """Records functions, each once for each kind of arguments.

    Parameters
    ----------
    replaced : mapping of callable to callable, optional
        Functions, and others that are recorded in their place.
    squares : bool
        Whether ``x**2`` is recorded as a product; compiled lanes have no powers at all.
    """

    def __init__(self, replaced: Mapping[Any, Any] | None = None, *, squares: bool = True) -> None:
        self._squares, self._turns = squares, 0
        self._replaced = {plain(one): plain(other) for one, other in (replaced or {}).items()}
        self.functions: dict[Any, RecordedFunction] = {}
        self._frames: list[_Frame] = []

    def record(self, function: Any, arguments: Mapping[str, Any]) -> RecordedFunction:
        """Return a function as it runs for arguments like these: their kinds and constants count.

        Raises
        ------
        RecordError
            If it does something that lanes cannot, naming the function and its file.
        """
        written = plain(function)
        key = (written, tuple(signature_of(each) for each in arguments.values()))
        if key in self.functions:
            return self.functions[key]
        try:
            source = source_of(written)
        except RecordError as error:
            where = f"{written.__name__} in {written.__module__}"
            raise LocatedError(f"{where}: {error}") from error
        recorded = RecordedFunction(source)
        values = {name: parameter_of(recorded, name, value) for name, value in arguments.items()}
        self._frames.append(_Frame(recorded))
        names: dict[str, Any] = self._globals(written)
        try:
            exec(source.code, names)  # the function's own source, with hooks
            names[source.name](**values)
        except RecursionError:
            raise LocatedError(f"{source.name} in {source.module}: calls itself") from None
        except Exception as error:  # what lanes do not have, or what the function's author missed
            if isinstance(error, LocatedError):
                raise
            line = _line(error, source.code.co_filename)
            raise LocatedError(f"{source.name} in {source.module}: {line}{error}") from error
        finally:
            self._frames.pop()
        self.functions[key] = recorded
        return recorded

    def call(self, function: Callable[..., Any], *args: Any, **keywords: Any) -> Any:
        """Record a call and return what stands for its result."""
        bound = inspect.signature(function).bind(*args, **keywords)
        bound.apply_defaults()
        recorded = self.record(function, bound.arguments)
        by_name = {each.name: each for each in recorded.parameters}
        arguments = {
            by_name[name]: expression_of(value)
            for name, value in bound.arguments.items()
            if name in by_name
        }
        if not recorded.outputs:
            if isinstance(recorded.result, Constant):
                return recorded.result
            match recorded.result:
                case Read(Variable(parameter=True) as variable, version=0):  # not assigned anew
                    return bound.arguments[variable.name]
                case _:
                    pass
            made = Call(recorded, arguments, recorded.kind)
            return value_like(made, recorded.result)
        frame = self._frames[-1]
        statement = CallStatement(recorded, arguments, [], 0)
        frame.blocks[-1].append(statement)
        several = _Several(self._receive(frame, statement, each) for each in recorded.result)
        several.statement, several.like = statement, recorded.result
        return several

    def _receive(self, frame: _Frame, statement: CallStatement, like: Any) -> Any:
        """Return a result of a call in a variable that has no name in the source."""
        label = statement.function.outputs[len(statement.targets)].name or "result"
        read = Read(frame.new_variable(label, expression_of(like).kind))
        statement.targets.append(read)
        return value_like(read, like)

    # -- what the copy of a function calls --

    def turns(self, values: Iterable[Any], line: int) -> Iterator[Any]:
        """Yield what a loop goes through, each turn of which is recorded."""
        for value in values:
            self._turns += 1
            if self._turns > TURNS_MAX:
                reason = f"loops turn more than {TURNS_MAX} times; for _ in range(n) is one loop"
                raise RecordError(f"line {line}: {reason}")
            yield value

    def power(self, base: Any, exponent: Any) -> Any:
        """Return a power: of numbers, or a square."""
        of_lanes = any(isinstance(e, Expression) and value_of(e) is None for e in (base, exponent))
        if of_lanes and not self._squares:
            raise RecordError("lanes have no powers, not even squares: write a product")
        return base**exponent

    def name(self, pattern: Any, value: Any, line: int) -> Any:
        """Record an assignment to one name or several, and return what they stand for."""
        if isinstance(pattern, str):
            return self._assign(pattern, value, line)
        if isinstance(value, _Several) and not value.statement.line:
            return self._name_results(pattern, value, line)
        parts = list(value)
        if len(parts) != len(pattern):
            raise RecordError(f"line {line} unpacks {len(parts)} values to {len(pattern)} names")
        return tuple(self.name(*pair, line) for pair in zip(pattern, parts, strict=True))

    def _name_results(self, pattern: Any, value: _Several, line: int) -> Any:
        frame, statement = self._frames[-1], value.statement
        statement.line = line
        for target in statement.targets:
            frame.names.discard(target.variable.name)
        targets, results = [], []
        for output, label in zip(statement.function.outputs, pattern, strict=True):
            taken = statement.function.names
            output.name = output.name or (f"{label}_out" if label in taken else label)
        for label, target, like in zip(pattern, statement.targets, value.like, strict=True):
            name = "unused" if label == "_" else label
            read = Read(*frame.target(name, target.kind))
            targets.append(read)
            results.append(value_like(read, like))
        statement.targets = targets
        return tuple(results)

    def _assign(self, label: str, value: Any, line: int) -> Any:
        frame = self._frames[-1]
        if is_structural(value):
            return value
        expression = expression_of(value)
        if isinstance(expression, Read) and expression.variable is frame.variables.get(label):
            return value
        if hasattr(value, "_fields") and isinstance(expression, (Read, Member)):
            variable, version = frame.new_variable(label, expression.kind, pointer=True), 0
            frame.variables[label] = variable
        else:
            variable, version = frame.target(label, expression.kind)
        frame.blocks[-1].append(Assignment(variable, version, expression, line))
        return value_like(Read(variable, version), value)

    def returned(self, value: Any, names: tuple[str, ...], line: int) -> Any:
        """Record what a function returns."""
        function, frame = self._frames[-1].function, self._frames[-1]
        origin = _origin(value, function.body)
        value = function.result = value if origin is None else origin
        if isinstance(value, tuple) and not hasattr(value, "_fields"):
            values = [expression_of(each) for each in value]
            labels = names if len(names) == len(values) else [""] * len(values)
            for label, each in zip(labels, values, strict=True):
                function.outputs.append(self._output(frame, label, each))
        else:
            values = [expression_of(value)]
        frame.blocks[-1].append(Return(values, line))
        return value

    def _output(self, frame: _Frame, label: str, value: Expression) -> Variable:
        label = label or (snake(value.kind) if isinstance(value, Structure) else "")
        return Variable(frame.free_name(label) if label else "", value.kind, pointer=True)

    def loop_begin(self, count: Any, line: int) -> None:
        """Record the begin of a loop, which must not take longer than a control period."""
        if isinstance(count, int) and count > LOOP_MAX:
            raise RecordError(f"line {line}: a loop of {count} turns, of which {LOOP_MAX} may be")
        frame = self._frames[-1]
        loop = Loop(expression_of(count), line)
        frame.blocks[-1].append(loop)
        frame.blocks.append(loop.body)
        frame.loops.append(loop)

    def carried(self, label: str, value: Any) -> Any:
        """Record that a loop takes over a variable from turn to turn."""
        frame = self._frames[-1]
        expression = expression_of(value)
        loop = frame.loops[-1]
        variable = frame.variables.get(label)
        fits = isinstance(expression, Read) and expression.variable is variable
        if variable is None or not fits or variable.pointer:
            inside = frame.blocks.pop()
            loop_statement = frame.blocks[-1].pop()
            variable, version = frame.target(label, expression.kind)
            frame.blocks[-1].append(Assignment(variable, version, expression, loop.line))
            frame.blocks[-1].append(loop_statement)
            frame.blocks.append(inside)
        before = variable.versions - 1
        variable.versions += 1
        loop.carried.append(Carried(variable, before, before + 1))
        return value_like(Read(variable, before + 1), value)

    def loop_end(self) -> None:
        """Record the end of a loop."""
        frame = self._frames[-1]
        frame.blocks.pop()
        for each in frame.loops.pop().carried:
            each.last = each.variable.versions - 1

    def _globals(self, function: Callable[..., Any]) -> dict[str, Any]:
        """Return the names that a function sees, with recorders in place of functions."""
        names = dict(function.__globals__)
        names |= dict(inspect.getclosurevars(function).nonlocals)
        seen = {name: self._seen(name, each, function.__module__) for name, each in names.items()}
        return seen | {HOOK: self}

    def _seen(self, name: str, value: Any, module: str) -> Any:
        if isinstance(value, (int, float)) and not isinstance(value, bool):
            return Constant(value, name, module)
        if value is math:
            return MATHS
        written = plain(value)
        if isinstance(written, FunctionType):
            written = self._replaced.get(written, written)
            if written in PRIMITIVES:
                return PRIMITIVES[written]
            return lambda *args, **keywords: self.call(written, *args, **keywords)
        return value


def _origin(value: Any, body: list[Statement]) -> Any:
    """Return the number or the parameter that a variable was assigned, else the value itself."""
    for statement in reversed(body):
        match statement:
            case Assignment(variable, version, Constant() | Read() as assigned):
                same = isinstance(value, Read) and value.variable is variable
                if same and value.version == version:
                    value = assigned
            case _:
                pass
    plain = isinstance(value, Read) and (value.version or not value.variable.parameter)
    return None if plain else value


def _line(error: Exception, file: str) -> str:
    """Return the line of a file that an error arose in, where its text does not begin with one."""
    if str(error).startswith("line "):
        return ""
    lines = [
        each.lineno
        for each in traceback.extract_tb(error.__traceback__)
        if each.filename == file and each.name != "<module>"
    ]
    return f"line {lines[-1]}: " if lines else ""
