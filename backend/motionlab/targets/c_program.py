"""Recorded functions as C99: their structures, constants and functions."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping
from typing import Any, NamedTuple

from motionlab.targets.c_body import Body
from motionlab.targets.c_comments import comment, heading, inside_comment
from motionlab.targets.c_expression import WIDTH, ExpressionPrinter, call_lines, number
from motionlab.targets.c_function import LiveFunction
from motionlab.targets.c_liveness import Liveness
from motionlab.targets.c_types import Types
from motionlab.targets.c_words import free_name, safe, safe_outside
from motionlab.targets.record_source import (
    constant_comment,
    constant_origin,
    module_docstring,
)
from motionlab.targets.record_statements import CallStatement, RecordedFunction, walk
from motionlab.targets.record_values import (
    Call,
    Constant,
    Expression,
    Variable,
)


class Program:
    """Functions and what they call, as C99.

    Parameters
    ----------
    entries : mapping of str to RecordedFunction
        Functions that others call, by their name in C.
    states : iterable of class
        NamedTuple classes of which the entries return only those fields that are read again.
    whole : iterable of class
        NamedTuple classes with all of their fields, whatever the functions read: an interface.
    prefix : str
        Of the names of structures.
    type_names : mapping, optional
        Names of some structures, by class.
    taken : iterable of str
        Names that are no structure's, beside those.
    """

    def __init__(  # noqa: PLR0913 - what is printed, and names
        self,
        entries: Mapping[str, RecordedFunction],
        *,
        states: Iterable[Any] = (),
        whole: Iterable[Any] = (),
        prefix: str = "psrm_",
        type_names: Mapping[Any, str] | None = None,
        taken: Iterable[str] = (),
    ) -> None:
        self._live = Liveness(entries.values(), states, whole)
        self._types = Types(self._live, prefix=prefix, names=type_names, taken=taken)
        self._entries = {function: name for name, function in entries.items()}
        self._functions = {
            each: LiveFunction(each, self._live) for each in _ordered(entries.values(), self._live)
        }
        self._constants: dict[tuple[str, str], _NamedConstant] = {}
        self._constant_names: dict[tuple[str, str], str] = {}
        self._locals = {safe(name) for each in self._functions.values() for name in each.names}
        self._module = ""  # of the function that is printed
        self._names: dict[RecordedFunction, str] = {}
        self._merge_equal()
        self._names |= self._function_names()
        self._constants.clear()
        self._texts: dict[RecordedFunction, list[str]] = {}
        for module, functions in self._modules().items():
            self._module = module
            self._texts |= {each: self._function(each) for each in functions}

    # -- what is printed --

    def types(self, *, public: bool) -> str:
        """Return the structures in the entries' parameters and results, or all others."""
        entries = [self._functions[each] for each in self._entries]
        return self._types.code(entries, self._functions.values(), public=public)

    def functions(self) -> str:
        """Return constants and functions, by the Python module that they come from."""
        lines: list[str] = []
        for module, functions in self._modules().items():
            constants = [
                line
                for constant in self._constants.values()
                if constant.section == module
                for line in constant.lines()
            ]
            lines += heading(module, module_docstring(module))
            lines += [*constants, ""] if constants else []
            for each in functions:
                lines += [*self._texts[each], ""]
        return "\n".join(lines)

    def fields(self, kind: Any) -> list[str]:
        """Return the fields of a NamedTuple class that are read."""
        return self._types.fields(kind)

    def type_name(self, kind: Any) -> str:
        """Return the name of a structure."""
        return self._types.name(kind)

    def call(
        self,
        function: RecordedFunction,
        arguments: Mapping[str, str],
        *outputs: str,
        column: int = 0,
    ) -> list[str]:
        """Return a call of an entry as lines: its arguments by parameter, those that it reads."""
        live = self._functions[function]
        inside = [arguments[each.name] for each in live.parameters]
        return call_lines(self._names[function], [*inside, *outputs], column)

    # -- names --

    def _function_names(self) -> dict[RecordedFunction, str]:
        kept = [each for each in self._functions if each not in self._merged]
        taken: dict[RecordedFunction, set[str]] = defaultdict(set)
        for each, function in self._functions.items():
            variables = {safe(name) for name in function.names}
            for called in {*_called(function), each}:
                taken[self._merged.get(called, called)] |= variables
        recordings = Counter(each.source.code for each in kept)
        names: dict[RecordedFunction, str] = {}
        for each in kept:
            name = safe_outside(self._entries.get(each) or each.source.name.lstrip("_"))
            if recordings[each.source.code] > 1 and each not in self._entries:
                name += self._ending(each)
            constants = self._constant_names.values()
            outside = {*names.values(), *constants}
            if name in taken[each] or name in outside:
                package = each.source.module.rpartition(".")[0].rpartition(".")[2]
                name = f"{package}_{name}"
            names[each] = free_name(name, outside)
        return names | {each: names[other] for each, other in self._merged.items()}

    def _ending(self, function: RecordedFunction) -> str:
        """Return the ending that all entries have which need one of several recordings."""
        endings = {
            name.removeprefix(entry.source.name)
            for entry, name in self._entries.items()
            if function in _ordered([entry], self._live)
        }
        return endings.pop() if len(endings) == 1 else ""

    def _constant(self, value: Constant) -> str:
        key = constant_origin(value.module, value.name)
        if key not in self._constant_names:
            name = safe_outside(key[1].lstrip("_"))
            taken = {*self._locals, *self._constant_names.values()}
            self._constant_names[key] = free_name(name, taken)
        name = self._constant_names[key]
        self._constants.setdefault(key, _NamedConstant(*key, name, value.value, self._module))
        return name

    def _merge_equal(self) -> None:
        """Keep one of several recordings of a function that read the same in C."""
        kept: dict[Any, RecordedFunction] = {}
        merged: dict[RecordedFunction, RecordedFunction] = {}
        for place, each in enumerate(self._functions):
            self._names[each] = each.source.name
            key = (each.source.code, tuple(self._function(each)))
            if each in self._entries or key not in kept:
                kept.setdefault(key, each)
                self._names[each] = f"{each.source.name}_{place}"
            else:
                merged[each] = kept[key]
                self._names[each] = self._names[kept[key]]
        self._merged = merged

    # -- functions --

    def _function(self, recorded: RecordedFunction) -> list[str]:
        function = self._functions[recorded]

        def called(call: Call) -> tuple[str, list[Expression]]:
            return self._names[call.function], function.arguments(call)

        printer = ExpressionPrinter(
            variable=function.name,
            constant=self._constant,
            called=called,
            hoisted=function.hoisted,
        )
        body = Body(
            function, printer, type_name=self.type_name, function_name=self._names.__getitem__
        )
        return [
            *comment(recorded.source.docstring),
            *self._prototype(recorded),
            "{",
            *body.lines(),
            "}",
        ]

    def _prototype(self, recorded: RecordedFunction) -> list[str]:
        function = self._functions[recorded]
        result = function.result()
        returned = "void" if result is None else self._kind(result.kind)
        parameters = [self._parameter(each) for each in function.parameters]
        parameters += [self._output(each) for each in function.outputs]
        return call_lines(f"static {returned} {self._names[recorded]}", parameters or ["void"], 0)

    def _kind(self, kind: Any) -> str:
        return kind if isinstance(kind, str) else self.type_name(kind)

    def _parameter(self, variable: Variable) -> str:
        if variable.kind in {"table", "four"}:
            return f"const double {safe(variable.name)}[]"
        if variable.pointer:
            return f"const {self.type_name(variable.kind)} *{safe(variable.name)}"
        return f"{variable.kind} {safe(variable.name)}"

    def _output(self, variable: Variable) -> str:
        return f"{self._kind(variable.kind)} *{safe(variable.name)}"

    def _modules(self) -> dict[str, list[RecordedFunction]]:
        """Return functions by module, called modules first."""
        modules: dict[str, list[RecordedFunction]] = defaultdict(list)
        uses: dict[str, set[str]] = defaultdict(set)
        for each, function in self._functions.items():
            if each not in self._merged:
                modules[each.source.module].append(each)
            for called in _called(function):
                uses[each.source.module].add(called.source.module)
        ordered: dict[str, list[RecordedFunction]] = {}

        def visit(module: str) -> None:
            for used in modules:
                if used in uses[module] and used != module and used not in ordered:
                    visit(used)
            ordered.setdefault(module, modules[module])

        for module in modules:
            visit(module)
        return ordered


class _NamedConstant(NamedTuple):
    """A constant of a module, and the section that first uses it."""

    module: str
    name: str
    c_name: str
    value: float
    section: str

    def lines(self) -> list[str]:
        about = constant_comment(self.module, self.name).rstrip(".")
        text = f"static const double {self.c_name} = {number(self.value)};"
        beside = f"{text} /* {inside_comment(about)} */"
        if not about:
            return [text]
        return [beside] if len(beside) <= WIDTH else [*comment(about), text]


def _called(function: LiveFunction) -> Iterator[RecordedFunction]:
    """Yield the functions that one calls, in order."""
    for statement in walk(function.body):
        for root in function.roots(statement):
            yield from _calls(function, root)
        if isinstance(statement, CallStatement):
            yield statement.function


def _calls(function: LiveFunction, value: Expression) -> Iterator[RecordedFunction]:
    for each in function.operands(value):
        yield from _calls(function, each)
    if isinstance(value, Call):
        yield value.function


def _ordered(entries: Iterable[RecordedFunction], live: Liveness) -> dict[RecordedFunction, None]:
    """Return functions, called ones first."""
    ordered: dict[RecordedFunction, None] = {}

    def visit(function: RecordedFunction) -> None:
        if function not in ordered:
            for called in _called(LiveFunction(function, live)):
                visit(called)
            ordered.setdefault(function)

    for each in entries:
        visit(each)
    return ordered
