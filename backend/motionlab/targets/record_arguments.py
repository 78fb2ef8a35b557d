"""What recorded functions get and give, and the operations that they use."""

from __future__ import annotations

import math
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any, get_type_hints

from motionlab import lanes
from motionlab.targets.record_statements import RecordedFunction
from motionlab.targets.record_structures import (
    class_of,
    expression_of,
    is_structural,
    structure,
)
from motionlab.targets.record_values import (
    FOUR,
    Choice,
    Constant,
    Element,
    Expression,
    Four,
    Library,
    Member,
    Read,
    RecordError,
    Variable,
    value_of,
)


def value_like(expression: Expression, like: Any) -> Any:
    """Return what Python sees of an expression whose kind is that of another value."""
    if hasattr(like, "_fields"):
        return structure(class_of(like), expression, like)
    if expression.kind == FOUR:
        four = tuple.__new__(FourValues, (Element(expression, place) for place in range(4)))
        four._expression = expression
        return four
    return expression


def zeros(kind: Any) -> Any:
    """Return a NamedTuple of a class with zeros in it, to record a function with."""
    hints = get_type_hints(kind).values()
    return kind(*(zeros(each) if hasattr(each, "_fields") else 0.0 for each in hints))


class FourValues(tuple[Any, ...]):
    """Four neighbouring numbers of the tables."""

    _expression: Expression


def parameter_of(function: RecordedFunction, name: str, value: Any) -> Any:
    """Return what a function sees of an argument; a new parameter unless it is structural."""
    if is_structural(value) and not isinstance(value, FourValues):
        return value
    expression = expression_of(value)
    variable = Variable(name, expression.kind, hasattr(value, "_fields"), parameter=True)
    function.parameters.append(variable)
    return value_like(Read(variable), value)


def signature_of(value: Any) -> Any:
    """Return what of an argument a recording depends on."""
    if isinstance(value, FourValues):
        return FOUR
    if hasattr(value, "_fields"):
        return (class_of(value), tuple(signature_of(each) for each in value))
    if isinstance(value, Constant) and value.structural:
        return ("kept" if value.kept else "fixed", value.value)
    if isinstance(value, Member) and value.compared is not None:
        return ("kept", value.compared)
    if is_structural(value):
        return ("python", value)
    return expression_of(value).kind


def _select(mask: Any, yes: Any, no: Any) -> Expression:
    known = value_of(expression_of(mask))
    if known is not None:
        return expression_of(yes if known else no)
    return Choice(expression_of(mask), expression_of(yes), expression_of(no))


def _load_four(tables: Any, index: Any) -> Any:
    return value_like(Four(expression_of(tables), expression_of(index)), None)


def _library(name: str) -> Callable[[Any], Expression]:
    return lambda x: Library(name, (expression_of(x),))


class _Maths(SimpleNamespace):
    def __getattr__(self, name: str) -> Any:
        raise RecordError(f"math.{name}: of math lanes have {', '.join(vars(self))}")


MATHS = _Maths(
    **{name: _library(name) for name in ("exp", "sqrt", "sin", "cos")}, pi=math.pi, inf=math.inf
)
"""What stands for Python's module of functions."""

PRIMITIVES: dict[Any, Callable[..., Any]] = {
    lanes.select: _select,
    lanes.square_root: _library("sqrt"),
    lanes.round_down: _library("floor"),
    lanes.round_nearest: _library("rint"),
    lanes.power_of_two: _library("power_of_two"),
    lanes.load_four: _load_four,
}
"""What stands for the operations of lanes."""
