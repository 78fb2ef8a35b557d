"""The body of a C function, with the comments and blank lines of its source."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

from motionlab.targets.c_comments import comment, inside_comment
from motionlab.targets.c_expression import INDENT, WIDTH, ExpressionPrinter, call_lines
from motionlab.targets.c_function import LiveFunction
from motionlab.targets.c_words import free_name, safe
from motionlab.targets.record_statements import (
    Assignment,
    CallStatement,
    Loop,
    RecordedFunction,
    Return,
    Statement,
)
from motionlab.targets.record_values import Expression, Four, Structure, Variable


class Body:
    """Prints the statements of one function.

    Parameters
    ----------
    function : LiveFunction
    printer : ExpressionPrinter
        Of its expressions.
    type_name : callable
        C's name of a NamedTuple class.
    function_name : callable
        C's name of a recorded function.
    """

    def __init__(
        self,
        function: LiveFunction,
        printer: ExpressionPrinter,
        *,
        type_name: Callable[[Any], str],
        function_name: Callable[[RecordedFunction], str],
    ) -> None:
        self._function, self._printer = function, printer
        self._type_name, self._function_name = type_name, function_name
        self._declared: set[str] = {safe(each.name) for each in function.parameters}
        self._comments = dict(function.function.source.comments)
        self._trailing = dict(function.function.source.trailing)
        self._line = 0

    def lines(self) -> list[str]:
        """Return the lines between the braces."""
        return self._block(self._function.body, INDENT)

    def _block(self, body: Sequence[Statement], indent: str) -> list[str]:
        lines: list[str] = []
        for statement in body:
            made = self._statement(statement, indent)
            if made:
                lines += self._above(statement.line, indent, first=not lines)
                lines += self._beside(statement.line, made, indent)
        return lines

    def _above(self, line: int, indent: str, *, first: bool) -> list[str]:
        """Return a blank line and the comments that stand above a line of the source."""
        if line <= self._line:
            return []
        source = self._function.function.source
        blank = any(each in source.blank_lines for each in range(max(self._line, 1), line))
        since, self._line = self._line, line
        start = line
        while start - 1 > max(since, source.first_line) and start - 1 not in source.blank_lines:
            start -= 1
        texts = [
            self._comments.pop(each) for each in range(start, line + 1) if each in self._comments
        ]
        above = comment(" ".join(texts), indent)
        return ([""] if blank and since and not first else []) + above

    def _beside(self, line: int, made: list[str], indent: str) -> list[str]:
        """Return statements with the trailing comment of a line of the source."""
        text = self._trailing.pop(line, "")
        if not text:
            return made
        beside = f"{made[-1]} /* {inside_comment(text)} */"
        if len(made) == 1 and len(beside) <= WIDTH:
            return [beside]
        return [*comment(text, indent), *made]

    def _statement(self, statement: Statement, indent: str) -> list[str]:
        match statement:
            case Assignment(variable, version, value):
                return self._assignment(variable, version, value, indent)
            case CallStatement():
                return self._call(statement, indent)
            case Loop():
                return self._loop(statement, indent)
            case Return():
                return self._return(indent)

    def _assignment(
        self, variable: Variable, version: int, value: Expression, indent: str
    ) -> list[str]:
        name = self._function.name(variable, version)
        head = f"{indent}{name} = "
        if name not in self._declared:
            self._declared.add(name)
            constant = self._function.assignments(variable, name) <= 1
            head = f"{indent}{self.declaration(variable, name, constant=constant)} = "
        elif isinstance(value, Structure):  # which may read the one that it replaces
            after = self._fresh(f"{name}_next")
            declared = f"{indent}{self.declaration(variable, after, constant=True)} = "
            return [*self._structure(declared, value, indent), f"{head}{after};"]
        if isinstance(value, Structure):
            return self._structure(head, value, indent)
        if variable.pointer and not isinstance(value, Four):
            return [f"{head}{self._printer.argument(value)};"]
        if isinstance(value, Four):
            return [f"{head}{self._printer.made(value)};"]
        return self._filled(head, value, indent)

    def _filled(self, head: str, value: Expression, indent: str) -> list[str]:
        """Return an assignment, broken after its head where that saves lines."""
        below = indent + INDENT
        lines = self._printer.lines(value, len(head), made=True)
        if len(lines) > 1:
            lower = self._printer.lines(value, len(below), made=True)
            if len(lower) + 1 < len(lines) or len(lower) == 1 or len(head) > WIDTH // 2:
                return [head.rstrip(), *_joined(below, lower)]
        return _joined(head, lines)

    def _structure(self, head: str, value: Structure, indent: str) -> list[str]:
        fields = self._function.fields(value)
        nested = any(isinstance(each, Structure) for each in fields.values())
        if len(fields) <= 3 and not nested:
            flat = f"{head}{self._flat(value)};"
            if len(flat) <= WIDTH:
                return [flat]
        return [f"{head}{{", *self._fields(value, indent + INDENT), f"{indent}}};"]

    def _flat(self, value: Structure) -> str:
        parts = (
            f".{safe(name)} = {self._printer.value(each)}"
            for name, each in self._function.fields(value).items()
        )
        return f"{{{', '.join(parts)}}}"

    def _fields(self, value: Structure, indent: str) -> Iterator[str]:
        for name, each in self._function.fields(value).items():
            head = f"{indent}.{safe(name)} = "
            if isinstance(each, Structure) and self._function.hoisted(each) is None:
                yield f"{head}{{"
                yield from self._fields(each, indent + INDENT)
                yield f"{indent}}},"
            else:
                yield from _joined(head, self._printer.lines(each, len(head)), ",")

    def _call(self, statement: CallStatement, indent: str) -> list[str]:
        targets = self._function.targets(statement)
        lines: list[str] = []
        names: list[str] = []
        single = len(targets) == 1
        for target in targets:
            name = self._function.name(target.variable, target.version)
            names.append(name)
            if name not in self._declared:
                self._declared.add(name)
                if not single:
                    declaration = self.declaration(target.variable, name, constant=False)
                    lines.append(f"{indent}{declaration};")
                else:
                    constant = self._function.assignments(target.variable, name) <= 1
                    names[0] = self.declaration(target.variable, name, constant=constant)
        called = self._function_name(statement.function)
        arguments = [self._printer.argument(each) for each in self._function.arguments(statement)]
        head = f"{indent}{names[0]} = " if single else indent
        if not single:
            arguments += [f"&{name}" for name in names]
        return [*lines, *_joined(head, call_lines(called, arguments, len(head)))]

    def _loop(self, loop: Loop, indent: str) -> list[str]:
        count = self._printer.text(loop.count)
        line = self._line
        self._line = loop.line
        inside = self._block(loop.body, indent + INDENT)
        self._line = max(line, self._line)
        k = free_name("k", self._function.names)  # it hides no variable
        head = f"{indent}for (uint32_t {k} = 0U; {k} < (uint32_t){count}; {k}++) {{"
        return [head, *inside, f"{indent}}}"]

    def _return(self, indent: str) -> list[str]:
        result = self._function.result()
        if result is None:
            return [
                line
                for output, value in zip(
                    self._function.outputs, self._function.returned(), strict=True
                )
                for line in self._output(output, value, indent)
            ]
        if isinstance(result, Structure):
            name = safe(self._function.result_name)
            head = f"{indent}const {self._type_name(result.kind)} {name} = "
            return [*self._structure(head, result, indent), f"{indent}return {name};"]
        return self._filled(f"{indent}return ", result, indent)

    def _output(self, output: Variable, value: Expression, indent: str) -> list[str]:
        if isinstance(value, Structure):
            return list(self._members(f"{indent}{safe(output.name)}->", value, indent))
        return self._filled(f"{indent}*{safe(output.name)} = ", value, indent)

    def _members(self, path: str, value: Structure, indent: str) -> Iterator[str]:
        for name, each in self._function.fields(value).items():
            if isinstance(each, Structure) and self._function.hoisted(each) is None:
                yield from self._members(f"{path}{safe(name)}.", each, indent)
            else:
                yield from self._filled(f"{path}{safe(name)} = ", each, indent)

    def _fresh(self, label: str) -> str:
        name = free_name(label, self._declared | self._function.names)
        self._declared.add(name)
        return name

    def declaration(self, variable: Variable, name: str, *, constant: bool) -> str:
        """Return a declaration without a value."""
        match variable.kind:
            case "double" | "bool":
                head = f"const {variable.kind}" if constant else variable.kind
                return f"{head} {name}"
            case "four" | "table":
                return f"const double *{name}"
            case kind:
                star = "*" if variable.pointer else ""
                const = "const " if constant or variable.pointer else ""
                return f"{const}{self._type_name(kind)} {star}{name}"


def _joined(head: str, lines: list[str], end: str = ";") -> list[str]:
    """Return lines between a head and an end."""
    joined = [head + lines[0], *lines[1:]]
    joined[-1] += end
    return joined
