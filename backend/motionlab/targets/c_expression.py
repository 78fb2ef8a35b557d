"""Expressions as C, on lines of 100 characters."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from motionlab.targets.c_words import safe
from motionlab.targets.record_values import (
    Call,
    Choice,
    Constant,
    Element,
    Expression,
    Four,
    Library,
    Member,
    Operation,
    Read,
    RecordError,
    Variable,
)

WIDTH = 100
INDENT = "    "
UNBOUNDED = "PSRM_UNBOUNDED"
"""What stands for infinity, which is no constant of every target's compiler."""

_LEVELS = {"*": 8, "/": 8, "+": 7, "-": 7, "<": 6, "<=": 6, ">": 6, ">=": 6, "==": 5, "!=": 5}
_LOGICAL = {"&": ("&&", 4), "|": ("||", 3), "!": ("!", 9)}


class ExpressionPrinter:
    """Prints the expressions of one function.

    Parameters
    ----------
    variable : callable
        C's name of a variable after so many assignments.
    constant : callable
        C's name of a named constant.
    called : callable
        C's name of a called function and the arguments that it takes.
    hoisted : callable
        The variable that holds an expression, or None.
    """

    def __init__(
        self,
        *,
        variable: Callable[[Variable, int], str],
        constant: Callable[[Constant], str],
        called: Callable[[Call], tuple[str, Sequence[Expression]]],
        hoisted: Callable[[Expression], Read | None],
    ) -> None:
        self._variable, self._constant = variable, constant
        self._call, self._hoisted = called, hoisted

    def text(self, value: Expression) -> str:
        """Return an expression on one line."""
        kept = self._hoisted(value)
        return self.made(value if kept is None else kept)

    def made(self, value: Expression) -> str:  # noqa: PLR0911 - one for each kind
        """Return an expression on one line, though a variable holds it."""
        match value:
            case Read(variable, version):
                return self._variable(variable, version)
            case Constant():
                return self._constant(value) if value.name else number(value.value)
            case Member(base, name):
                return f"{self.text(base)}{self._arrow(base)}{safe(name)}"
            case Element(base, place):
                return f"{self.text(base)}[{place}]"
            case Four(tables, first):
                return f"&{self.text(tables)}[(uint32_t){self._inner(first)}]"
            case Library(name, operands):
                return f"{name}({', '.join(self.text(each) for each in operands)})"
            case Call():
                name, arguments = self._call(value)
                return f"{name}({', '.join(self.argument(each) for each in arguments)})"
            case Operation(name, (operand,)):
                sign = _LOGICAL[name][0] if name in _LOGICAL else name
                return f"{sign}{self._inner(operand)}"
            case Operation(name, (left, right)):
                a, b = (
                    self._operand(left, name, right=False),
                    self._operand(right, name, right=True),
                )
                return f"{a} {_operator(name)} {b}"
            case Choice(condition, yes, no):
                parts = (self._inner(condition), self._branch(yes), self._branch(no))
                return "{} ? {} : {}".format(*parts)
            case _:
                raise TypeError(f"{value!r} cannot be printed")

    def argument(self, value: Expression) -> str:
        """Return an argument: a structure by its address."""
        text = self.text(value)
        by_value = hasattr(value.kind, "_fields") and not self._is_pointer(value)
        return f"&{text}" if by_value else text

    def value(self, value: Expression) -> str:
        """Return what is assigned: of a pointer the structure that it refers to."""
        text = self.text(value)
        return f"*{text}" if self._is_pointer(value) else text

    def lines(  # noqa: PLR0911 - one for each kind
        self, value: Expression, column: int, tail: int = 1, *, made: bool = False
    ) -> list[str]:
        """Return an assigned expression that begins at a column as lines, with room for a tail.

        With `made`, it is assigned to the variable that holds it.
        """
        text = self.made(value) if made else self.value(value)
        if made and self._is_pointer(value):
            text = f"*{text}"
        if column + len(text) + tail <= WIDTH or (self._hoisted(value) is not None and not made):
            return [text]
        match value:
            case Operation(_, (_, _)):
                return self._chain(value, column, tail)
            case Choice(condition, yes, no):
                inner = column + len(INDENT)
                pad = " " * inner
                return [
                    *self._wrapped(condition, column, 0),
                    *_after(f"{pad}? ", self._wrapped(yes, inner + 2, 0, branch=True)),
                    *_after(f"{pad}: ", self._wrapped(no, inner + 2, tail, branch=True)),
                ]
            case Call():
                name, arguments = self._call(value)
                return call_lines(name, [self.argument(each) for each in arguments], column, tail)
            case Library(name, (operand,)):
                inside = self.lines(operand, column + len(name) + 1, tail + 1)
                return _closed(f"{name}(", inside)
            case Operation(name, (operand,)):
                sign = _LOGICAL[name][0] if name in _LOGICAL else name
                return _after(sign, self._wrapped(operand, column + len(sign), tail))
            case _:
                return [text]

    def _chain(self, value: Expression, column: int, tail: int) -> list[str]:
        """Return operators of one precedence, each line but the first from an operator on."""
        terms: list[tuple[str, Expression]] = []
        level = _level(value)
        first = value
        while isinstance(first, Operation) and len(first.operands) == 2:
            if self._hoisted(first) is not None or _level(first) != level:
                break
            terms.insert(0, (first.operator, first.operands[1]))
            first = first.operands[0]
        lines = self._wrapped(first, column, tail, around=value)
        pad = " " * column
        for place, (name, term) in enumerate(terms):
            end = tail if place == len(terms) - 1 else 0
            head = f"{_operator(name)} "
            flat = head + self._operand(term, name, right=True)
            if len(lines[-1]) + 1 + len(flat) + end + (column if len(lines) == 1 else 0) <= WIDTH:
                lines[-1] += f" {flat}"
            else:
                rest = self._wrapped(term, column + len(head), end, around=value, right=True)
                lines += _after(pad + head, rest)
        return lines

    def _wrapped(  # noqa: PLR0913 - an operand, where it begins and what is around it
        self,
        value: Expression,
        column: int,
        tail: int,
        *,
        around: Expression | None = None,
        right: bool = False,
        branch: bool = False,
    ) -> list[str]:
        """Return an operand as lines, in parentheses if it needs them."""
        if branch:
            bare = not isinstance(value, Choice)
        elif around is None:
            bare = _is_atom(value)
        else:
            bare = _is_bare(value, around, right=right)
        if bare or self._hoisted(value) is not None:
            return self.lines(value, column, tail)
        return _closed("(", self.lines(value, column + 1, tail + 1))

    def _operand(self, value: Expression, operator: str, *, right: bool) -> str:
        around = Operation(operator, (value, value))
        bare = self._hoisted(value) is not None or _is_bare(value, around, right=right)
        return self.text(value) if bare else f"({self.text(value)})"

    def _inner(self, value: Expression) -> str:
        bare = self._hoisted(value) is not None or _is_atom(value)
        return self.text(value) if bare else f"({self.text(value)})"

    def _branch(self, value: Expression) -> str:
        wrapped = isinstance(value, Choice) and self._hoisted(value) is None
        return f"({self.text(value)})" if wrapped else self.text(value)

    def _is_pointer(self, value: Expression) -> bool:
        kept = self._hoisted(value)
        read = value if kept is None else kept
        return isinstance(read, Read) and read.variable.pointer

    def _arrow(self, base: Expression) -> str:
        return "->" if self._is_pointer(base) else "."


def call_lines(name: str, arguments: Sequence[str], column: int, tail: int = 1) -> list[str]:
    """Return a call that begins at a column as lines, with room for a tail."""
    lines = [f"{name}("]
    pad = " " * (column + len(name) + 1)
    for place, argument in enumerate(arguments):
        text = argument + (", " if place < len(arguments) - 1 else ")")
        start = column if len(lines) == 1 else 0
        end = tail if place == len(arguments) - 1 else -1  # a line may end with a comma
        if place and start + len(lines[-1]) + len(text) + end > WIDTH:
            lines[-1] = lines[-1].rstrip()
            lines.append(pad + text)
        else:
            lines[-1] += text
    return lines


def number(value: float) -> str:
    """Return a number as C has it."""
    if isinstance(value, bool):
        return str(value).lower()
    if math.isnan(value):
        raise RecordError("a constant is no number: NaN")
    if math.isinf(value):
        return UNBOUNDED if value > 0.0 else f"-{UNBOUNDED}"
    return repr(float(value))


def _operator(name: str) -> str:
    return _LOGICAL[name][0] if name in _LOGICAL else name


def _level(value: Expression) -> int:
    if isinstance(value, Operation) and len(value.operands) == 2:
        known = _LOGICAL.get(value.operator)
        return known[1] if known else _LEVELS[value.operator]
    return 2 if isinstance(value, Choice) else 9


def _is_atom(value: Expression) -> bool:
    """Tell whether a value needs no parentheses as an operand."""
    if isinstance(value, Constant):
        return value.value >= 0.0 or bool(value.name)
    return _level(value) == 9 and not (isinstance(value, Operation) and value.operator == "-")


def _is_bare(value: Expression, around: Expression, *, right: bool) -> bool:
    """Tell whether an operand of an operator needs no parentheses; MISRA's, more than C's."""
    if _is_atom(value):
        return True
    if isinstance(value, (Constant, Operation)) and _level(value) == 9:
        return not right or _level(around) in {5, 6}
    return not right and _level(value) == _level(around) and _level(value) in {3, 4, 7, 8}


def _after(head: str, lines: list[str]) -> list[str]:
    return [head + lines[0], *lines[1:]]


def _closed(head: str, lines: list[str]) -> list[str]:
    lines = _after(head, lines)
    return [*lines[:-1], lines[-1] + ")"]
