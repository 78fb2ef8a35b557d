"""What lane functions compute with while they are recorded: expressions in place of numbers."""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

DOUBLE, BOOL, TABLE, FOUR = "double", "bool", "table", "four"
"""Kinds of an expression; that of a structure is its NamedTuple class."""

_COMPUTE: dict[str, Callable[..., Any]] = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": operator.truediv,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "==": operator.eq,
    "!=": operator.ne,
    "&": operator.and_,
    "|": operator.or_,
}
_COMPARISONS = frozenset({"<", "<=", ">", ">=", "==", "!="})


class RecordError(Exception):
    """A function does something that lanes cannot, such as a branch on their values."""


class LocatedError(RecordError):
    """The same, with the name of the function and its module."""


def _binary(name: str, *, swapped: bool = False) -> Any:
    def operated(self: Any, other: Any) -> Expression:
        return operation(name, other, self) if swapped else operation(name, self, other)

    return operated


class Expression:
    """A value that is not known until the recorded code runs."""

    kind: Any = DOUBLE
    __hash__ = object.__hash__  # none where == is another, unless it is asked for

    __add__, __radd__ = _binary("+"), _binary("+", swapped=True)
    __sub__, __rsub__ = _binary("-"), _binary("-", swapped=True)
    __mul__, __rmul__ = _binary("*"), _binary("*", swapped=True)
    __truediv__, __rtruediv__ = _binary("/"), _binary("/", swapped=True)
    __lt__, __le__, __gt__, __ge__ = _binary("<"), _binary("<="), _binary(">"), _binary(">=")
    __eq__, __ne__ = _binary("=="), _binary("!=")
    __and__, __or__ = _binary("&"), _binary("|")

    def __invert__(self) -> Expression:
        """Return ``not self`` of a truth value."""
        known = value_of(self)
        if known is None:
            return Operation("!", (self,), BOOL)
        return Constant(not known, structural=True)

    def __neg__(self) -> Expression:
        """Return ``-self``."""
        return Operation("-", (self,))

    def __abs__(self) -> Expression:
        """Return the magnitude."""
        return Library("fabs", (self,))

    def __pow__(self, exponent: Any) -> Expression:
        """Return the square, the only power that is recorded."""
        if exponent != 2:
            raise RecordError(f"a power of {exponent!r}: only squares are recorded")
        return self * self

    def __float__(self) -> float:
        """Return the number of an expression of constants."""
        return float(self._known("a number"))

    def __index__(self) -> int:
        """Return the whole number of an expression of constants."""
        return operator.index(self._known("a whole number"))

    def __bool__(self) -> bool:
        """Return whether a comparison of constants holds."""
        return bool(self._known("true or false"))

    def _known(self, what: str) -> Any:
        known = value_of(self)
        if known is None:
            select = "select" if what != "true or false" else "select, and & | ~ of comparisons"
            raise RecordError(
                f"lanes are used as {what}, which differs from lane to lane: {select}"
            )
        return known


@dataclass(eq=False)
class Constant(Expression):
    """A number that is the same in every run; `module` is where it is named.

    A structural one is fixed for what is exported, such as the kind of a force map: comparisons
    with it are decided while recording. Where it is `kept`, its number may change all the same, but
    not how it compares, such as the place of a table.
    """

    value: float
    name: str = ""
    module: str = ""
    structural: bool = False
    kept: bool = False

    def __post_init__(self) -> None:
        """Derive the kind."""
        self.kind = BOOL if isinstance(self.value, bool) else DOUBLE


@dataclass(eq=False)
class Variable:
    """A local variable or a parameter of a recorded function.

    One that is a pointer refers to a structure elsewhere, which it leaves as it is.
    """

    name: str
    kind: Any
    pointer: bool = False
    parameter: bool = False
    output: bool = False
    versions: int = 1


@dataclass(eq=False)
class Read(Expression):
    """A variable, after so many assignments."""

    variable: Variable
    version: int = 0

    def __post_init__(self) -> None:
        """Derive the kind."""
        self.kind = self.variable.kind


@dataclass(eq=False)
class Member(Expression):
    """One field of a structure; `compared` is what comparisons take it for, where that is known."""

    base: Expression
    name: str
    kind: Any = DOUBLE
    compared: float | None = None


@dataclass(eq=False)
class Operation(Expression):
    """An operator, with one operand or two."""

    operator: str
    operands: tuple[Expression, ...]
    kind: Any = DOUBLE


@dataclass(eq=False)
class Choice(Expression):
    """What `select` returns."""

    condition: Expression
    yes: Expression
    no: Expression


@dataclass(eq=False)
class Library(Expression):
    """A function of C's library."""

    name: str
    operands: tuple[Expression, ...]


@dataclass(eq=False)
class Call(Expression):
    """A call of a recorded function that returns one value: arguments by parameter."""

    function: Any
    arguments: Mapping[Variable, Expression]
    kind: Any = DOUBLE


@dataclass(eq=False)
class Structure(Expression):
    """A structure made of its fields."""

    kind: Any
    fields: dict[str, Expression] = field(default_factory=dict)


@dataclass(eq=False)
class Four(Expression):
    """Four neighbouring numbers of the tables."""

    tables: Expression
    first: Expression
    kind: Any = FOUR


@dataclass(eq=False)
class Element(Expression):
    """One of four numbers."""

    base: Expression
    place: int


def value_of(expression: Expression) -> Any:
    """Return the number that an expression of constants has; None where it depends on others."""
    match expression:
        case Constant():
            return expression.value
        case Member(compared=known):
            return known
        case Operation("-", (operand,)):
            known = value_of(operand)
            return None if known is None else -known
        case Operation(name, (left, right)):
            a, b = value_of(left), value_of(right)
            return None if a is None or b is None else _COMPUTE[name](a, b)
        case _:
            return None


def operation(name: str, left: Any, right: Any) -> Expression:
    """Return an operator's result; that of known truth values, or comparisons, is known."""
    a, b = number_or_lanes(left), number_or_lanes(right)
    if name in "&|":
        for one, other in ((a, b), (b, a)):
            known = value_of(one)
            if known is not None:
                return other if known == (name == "&") else one
        return Operation(name, (a, b), BOOL)
    result = Operation(name, (a, b), BOOL if name in _COMPARISONS else DOUBLE)
    known = value_of(result) if name in _COMPARISONS else None
    return result if known is None else Constant(bool(known), structural=True)


def number_or_lanes(value: Any) -> Expression:
    """Return an operand as an expression."""
    if isinstance(value, Expression):
        return value
    if isinstance(value, (bool, int, float)):
        return Constant(value)
    raise RecordError(f"{value!r} is neither a number nor lanes")


def operands_of(expression: Expression) -> Iterator[Expression]:
    """Yield the expressions that one is directly made of."""
    match expression:
        case Member(base) | Element(base):
            yield base
        case Operation(_, operands) | Library(_, operands):
            yield from operands
        case Choice(condition, yes, no):
            yield from (condition, yes, no)
        case Call(_, arguments):
            yield from arguments.values()
        case Structure(_, fields):
            yield from fields.values()
        case Four(tables, first):
            yield from (tables, first)
        case _:
            pass
