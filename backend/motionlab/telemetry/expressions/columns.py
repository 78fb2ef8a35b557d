"""Columns that are asked for: channels by name, and math channels as ``name=expression``."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motionlab.errors import ConfigError, FieldError
from motionlab.telemetry.expressions.compile import Program, compile_expression
from motionlab.telemetry.expressions.evaluate import evaluate
from motionlab.telemetry.expressions.parse import LENGTH_MAX, ExpressionError, Span

NAME_MAX = 40
"""Characters of the name of a math channel."""
TEXT_MAX = NAME_MAX + 1 + LENGTH_MAX
"""Characters of a math channel."""
MATH_MAX = 32
"""Math channels of a request."""

_NAME = re.compile(rf"[^\W_](?:[\w .+/%^-]{{0,{NAME_MAX - 1}}})", re.UNICODE)


@dataclass(frozen=True)
class MathChannel:
    """A column that is computed from others.

    Attributes
    ----------
    text : str
        As it was asked for: ``name=expression``, the name may be empty.
    name : str
        What it is called: its name, or else its expression.
    program : Program
        What is computed.
    """

    text: str
    name: str
    program: Program

    @property
    def expression(self) -> str:
        """What is computed, as written."""
        return self.text.partition("=")[2].strip()


def is_math(column: str) -> bool:
    """Return whether a column is a math channel."""
    return "=" in column


def split_columns(text: str) -> list[str]:
    """Return columns that are parted by commas; those within parentheses part nothing."""
    columns, begin, depth, math, quoted = [], 0, 0, False, False
    for place, sign in enumerate(text):
        if sign == "=":
            math = True
        elif sign == '"' and math:
            quoted = not quoted
        elif math and not quoted and sign in "()":
            depth += 1 if sign == "(" else -1
        elif sign == "," and not quoted and depth <= 0:
            columns.append(text[begin:place])
            begin, depth, math = place + 1, 0, False
    return [*columns, text[begin:]]


def compile_column(text: str, units: Mapping[str, str], period: float) -> MathChannel:
    """Check a math channel and compile it.

    Parameters
    ----------
    text : str
        ``name=expression``; the name may be empty.
    units : mapping of str to str
        Unit of every channel there is.
    period : float
        Time between samples, s.

    Raises
    ------
    ExpressionError
        If its name or its expression cannot be used; its places count within `text`.
    """
    label, _, rest = text.partition("=")
    name = label.strip()
    if name and (not _NAME.fullmatch(name) or len(name) > NAME_MAX):
        raise ExpressionError(
            f"a name begins with a letter or a digit and has up to {NAME_MAX} letters, digits, "
            "spaces and . + - / % ^ _",
            Span(0, len(label)),
        )
    if name in units:
        raise ExpressionError("is the name of a channel; choose another", Span(0, len(label)))
    expression = rest.strip()
    shift = len(label) + 1 + len(rest) - len(rest.lstrip())
    try:
        program = compile_expression(expression, units, period)
    except ExpressionError as error:
        span = Span(error.span.start + shift, error.span.end + shift)
        raise ExpressionError(error.message, span) from None
    return MathChannel(text, name or expression, program)


def compile_columns(
    columns: Sequence[str], units: Mapping[str, str], period: float
) -> dict[str, MathChannel]:
    """Refuse columns that are not there, come twice or cannot be computed; compile the others.

    Parameters
    ----------
    columns : sequence of str
        Names of channels, and math channels.
    units : mapping of str to str
        Unit of every channel there is.
    period : float
        Time between samples, s.

    Returns
    -------
    dict of str to MathChannel
        The math channels by their texts.

    Raises
    ------
    ConfigError
        Naming each.
    """
    math_channels: dict[str, MathChannel] = {}
    wrong: list[FieldError] = []
    seen: set[str] = set()
    for index, text in enumerate(columns):
        loc = f"columns.{index}"
        name = text
        if is_math(text) and text not in units:
            if len(math_channels) == MATH_MAX:
                bounds: dict[str, float] = {"maximum": MATH_MAX}
                count = sum(map(is_math, columns))
                wrong.append(FieldError("columns", "too many expressions", count, bounds=bounds))
                break
            try:
                math_channels[text] = compile_column(text, units, period)
                name = math_channels[text].name
            except ExpressionError as error:
                wrong.append(FieldError(loc, str(error), text))
        elif text not in units:
            wrong.append(FieldError(loc, "no column of that name", text))
        if name in seen:
            wrong.append(FieldError(loc, "comes twice", text))
        seen.add(name)
    if wrong:
        raise ConfigError(*wrong)
    return math_channels


def sources_of(columns: Sequence[str], math: Mapping[str, MathChannel]) -> list[str]:
    """Return the recorded channels that columns need, each once."""
    names = dict.fromkeys(
        name
        for column in columns
        for name in (math[column].program.channels if column in math else (column,))
    )
    return list(names)


def values_of(
    math: MathChannel, channel: Callable[[str], NDArray[np.floating]]
) -> NDArray[np.float32]:
    """Return a math channel of a whole record, whose channels `channel` returns by name."""
    samples = [np.asarray(channel(name), dtype=np.float32) for name in math.program.channels]
    return evaluate(math.program, np.stack(samples))
