"""Expressions checked and compiled: units, constants, and the steps of a stack machine.

The steps are what `evaluate` runs on samples, and what the page runs on those of a live session.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

from motionlab.config.units import PURE, SECOND, Dimension, parse_unit
from motionlab.telemetry.expressions.parse import (
    Call,
    ExpressionError,
    Name,
    Node,
    Number,
    Span,
    parse,
)

CHANNELS_MAX = 8
"""Different channels of an expression."""
HISTORY_MAX = 200_000
"""Most samples that a mean or a delay reaches back."""
_WHOLE, _RATE_ERROR = 1e-2, 1e-6
"""Samples, and share of a time, by which it may be off a whole number of them: periods of
measurements are fitted."""
_NEAR_MAX = 3
"""Names that an error suggests."""


@dataclass(frozen=True)
class Step:
    """One operation on the stack.

    Attributes
    ----------
    op : str
        ``channel`` and ``number`` push; the others take their operands from the stack and push
        their result.
    values : tuple of float
        Place of the channel; the number; whole exponent of ``power``; ``a, b0, b1, g`` of
        ``filter``; samples of ``mean`` and ``delay``; 1/T of ``difference``.
    """

    op: str
    values: tuple[float, ...] = ()


@dataclass(frozen=True)
class Program:
    """A compiled expression.

    Attributes
    ----------
    channels : tuple of str
        What it reads, each once.
    unit : str
        Of its result.
    steps : tuple of Step
        In the order in which they are done.
    """

    channels: tuple[str, ...]
    unit: str
    steps: tuple[Step, ...]


def compile_expression(text: str, units: Mapping[str, str], period: float) -> Program:
    """Check an expression and compile it.

    Parameters
    ----------
    text : str
        As `parse` reads it.
    units : mapping of str to str
        Unit of every channel there is.
    period : float
        Time between samples, s.

    Raises
    ------
    ExpressionError
        If it is no expression, reads what is not there, or its units do not fit.
    """
    compiler = _Compiler(units, period)
    node = parse(text)
    dimension = compiler.emit(node)
    if not compiler.channels:
        raise ExpressionError("reads no channel; name one, such as B.x.following_error", node.span)
    return Program(tuple(compiler.channels), str(dimension), tuple(compiler.steps))


_SAME = {"+": "add", "-": "subtract", "min": "minimum", "max": "maximum", "hypot": "hypot"}
"""Operations on two values of one unit."""
_MEMORYLESS = ("abs", "sqrt", "sign", "sin", "cos")
_FUNCTIONS = {
    "abs": 1,
    "sqrt": 1,
    "sign": 1,
    "sin": 1,
    "cos": 1,
    "min": 2,
    "max": 2,
    "hypot": 2,
    "derivative": 1,
    "integral": 1,
    "lowpass": 2,
    "highpass": 2,
    "bandpass": 3,
    "mean": 2,
    "delay": 2,
}
"""Number of arguments."""


class _Compiler:
    def __init__(self, units: Mapping[str, str], period: float) -> None:
        self.channels: list[str] = []
        self.steps: list[Step] = []
        self._units = units
        self._period = period

    def emit(self, node: Node) -> Dimension:
        """Append the steps of a node; return the dimension of its value."""
        match node:
            case Number():
                return self._number(node)
            case Name():
                return self._channel(node)
            case Call():
                dimension = self._call(node)
                if dimension.excessive:
                    raise ExpressionError(f"the unit of this, {dimension}, has no use", node.span)
                return dimension

    def _push(self, op: str, *values: float) -> None:
        self.steps.append(Step(op, values))

    def _number(self, node: Number) -> Dimension:
        value, dimension = _quantity(node)
        self._push("number", value)
        return dimension

    def _channel(self, node: Name) -> Dimension:
        unit = parse_unit(self._units[node.name]) if node.name in self._units else None
        if unit is None:
            raise ExpressionError(self._unknown(node.name), node.span)
        if node.name not in self.channels:
            if len(self.channels) == CHANNELS_MAX:
                raise ExpressionError(
                    f"is channel {CHANNELS_MAX + 1}; {CHANNELS_MAX} are the most", node.span
                )
            self.channels.append(node.name)
        self._push("channel", self.channels.index(node.name))
        if unit.factor != 1.0:
            self._push("number", unit.factor)
            self._push("multiply")
        return unit.dimension

    def _unknown(self, name: str) -> str:
        from difflib import get_close_matches  # noqa: PLC0415 - only errors need it

        if name in _FUNCTIONS:
            return f"{name} is a function: {name}(...)"
        near = get_close_matches(name, self._units, _NEAR_MAX)
        return f"no channel {name!r}" + (f"; near are {', '.join(near)}" if near else "")

    def _call(self, node: Call) -> Dimension:
        match node.function, node.arguments:
            case ("+" | "-") as sign, (left, right):
                return self._alike(node, sign, left, right)
            case "*", (left, right):
                dimension = self.emit(left) * self.emit(right)
                self._push("multiply")
                return dimension
            case "/", (left, right):
                dimension = self.emit(left) / self.emit(right)
                self._push("divide")
                return dimension
            case "negate", (argument,):
                dimension = self.emit(argument)
                self._push("negate")
                return dimension
            case "power", (base, Number(exponent)):
                dimension = self.emit(base) ** int(exponent)
                self._push("power", exponent)
                return dimension
            case name, arguments:
                return self._function(node, name, arguments)

    def _alike(self, node: Call, function: str, left: Node, right: Node) -> Dimension:
        first, second = self.emit(left), self.emit(right)
        if first != second:
            both = f"{first} and {second}"
            message = f"{function} needs operands of one unit, not {both}"
            if isinstance(right, Number) and not right.unit:
                message += f"; a number can have a unit: {right.value:g} [{first}]"
            elif isinstance(left, Number) and not left.unit:
                message += f"; a number can have a unit: {left.value:g} [{second}]"
            else:
                message += f"; the second would have to be in {first}"
            raise ExpressionError(message, right.span if not _bare(left) else left.span)
        self._push(_SAME[function])
        return first

    def _function(self, node: Call, name: str, arguments: tuple[Node, ...]) -> Dimension:
        if name not in _FUNCTIONS:
            raise ExpressionError(
                f"no function {name!r}; there are {', '.join(_FUNCTIONS)}", node.at
            )
        if len(arguments) != _FUNCTIONS[name]:
            count = _FUNCTIONS[name]
            raise ExpressionError(
                f"{name} takes {count} {'argument' if count == 1 else 'arguments'}, "
                f"not {len(arguments)}",
                node.span,
            )
        if name in _SAME:
            return self._alike(node, name, *arguments)
        first, *constants = arguments
        dimension = self.emit(first)
        if name in _MEMORYLESS:
            return self._memoryless(name, first, dimension)
        return self._with_memory(name, constants, dimension)

    def _memoryless(self, name: str, argument: Node, dimension: Dimension) -> Dimension:
        self._push(name)
        match name:
            case "sign":
                return PURE
            case "sqrt":
                return dimension ** Fraction(1, 2)
            case "sin" | "cos" if not dimension.pure:
                raise ExpressionError(
                    f"{name} needs a pure number (rad), not {dimension}", argument.span
                )
            case _:
                return dimension

    def _with_memory(self, name: str, constants: list[Node], dimension: Dimension) -> Dimension:
        match name:
            case "derivative":
                self._push("difference", 1.0 / self._period)
                return dimension / SECOND
            case "integral":
                half = 0.5 * self._period
                self._push("filter", 1.0, half, half, 0.0)
                return dimension * SECOND
            case "lowpass":
                self._lowpass(self._frequency(constants[0], name))
            case "highpass":
                self._highpass(self._frequency(constants[0], name))
            case "bandpass":
                low, high = (self._frequency(each, name) for each in constants)
                if low >= high:
                    span = Span(constants[0].span.start, constants[1].span.end)
                    raise ExpressionError("bandpass(u, low, high) needs low < high, Hz", span)
                self._lowpass(high)
                self._highpass(low)
            case _:
                self._push(name, self._samples(constants[0], name))
        return dimension

    def _lowpass(self, frequency: float) -> None:
        """Append (1 + s/w)^-1 with w = 2 pi f, by the bilinear transform prewarped at w."""
        k = math.tan(math.pi * frequency * self._period)
        gain = k / (1.0 + k)
        self._push("filter", (1.0 - k) / (1.0 + k), gain, gain, 1.0)

    def _highpass(self, frequency: float) -> None:
        """Append (s/w) (1 + s/w)^-1 with w = 2 pi f, by the bilinear transform prewarped at w."""
        k = math.tan(math.pi * frequency * self._period)
        gain = 1.0 / (1.0 + k)
        self._push("filter", (1.0 - k) / (1.0 + k), gain, -gain, 0.0)

    def _frequency(self, node: Node, name: str) -> float:
        most = 0.5 / self._period
        value = _constant(node, name, SECOND**-1, "Hz")
        if not 0.0 < value < most:
            raise ExpressionError(
                f"{name} needs a frequency above 0 and below {most:g} Hz, half the sample rate; "
                f"got {value:g}",
                node.span,
            )
        return value

    def _samples(self, node: Node, name: str) -> int:
        seconds = _constant(node, name, SECOND, "s")
        most = HISTORY_MAX * self._period
        if not self._period * (1 - 1e-9) <= seconds <= most:
            raise ExpressionError(
                f"{name} needs a time from {self._period:g} to {most:g} s; got {seconds:g}",
                node.span,
            )
        samples = seconds / self._period
        whole = round(samples)
        if abs(samples - whole) > _WHOLE + _RATE_ERROR * samples:
            low, high = (f"{n * self._period:g} s" for n in (int(samples), int(samples) + 1))
            raise ExpressionError(
                f"{name} needs a whole number of samples of {self._period:g} s; "
                f"{seconds:g} s are {samples:.4g}: take {low} or {high}",
                node.span,
            )
        return whole


def _bare(node: Node) -> bool:
    return isinstance(node, Number) and not node.unit


def _quantity(node: Number) -> tuple[float, Dimension]:
    """Return a number in SI and its dimension."""
    unit = parse_unit(node.unit, strict=True)
    if unit is None:
        raise ExpressionError(
            f"[{node.unit[:20]}] is no unit; such as m, um, N, A, W, Hz, m/s, N/m are", node.span
        )
    value = node.value * unit.factor
    if not math.isfinite(value):
        raise ExpressionError("is beyond the largest number", node.span)
    return value, unit.dimension


def _constant(node: Node, name: str, dimension: Dimension, unit: str) -> float:
    """Return a number of one unit, which it need not have."""
    if not isinstance(node, Number):
        raise ExpressionError(
            f"{name} needs a plain number here, in {unit}, which cannot change with time",
            node.span,
        )
    value, actual = _quantity(node)
    if node.unit and actual != dimension:
        raise ExpressionError(f"{name} needs {unit} here, not {actual}", node.span)
    return value


FUNCTIONS: tuple[str, ...] = tuple(_FUNCTIONS)
"""Names of all functions."""
