"""Text of an expression to its tree: numbers, channels, operators and functions, nothing else."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

from motionlab.errors import MotionLabError

LENGTH_MAX = 200
"""Characters of an expression."""
DEPTH_MAX = 24
"""Parentheses, functions and signs within each other."""
EXPONENT_MAX = 8
"""Largest power."""

_TOKEN = re.compile(
    r"""\s*(?:
        (?P<number>(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)
        |(?P<name>[A-Za-z_][A-Za-z0-9_]*(?:\.[A-Za-z_][A-Za-z0-9_]*)*)
        |"(?P<quoted>[^"]+)"
        |(?P<unit>\[[^\]\[]*\])
        |(?P<sign>\*\*|[-+*/^(),])
    )""",
    re.VERBOSE | re.ASCII,
)


class Span(NamedTuple):
    """Characters [start, end) of a text."""

    start: int
    end: int


class ExpressionError(MotionLabError):
    """An expression that cannot be used, and where.

    Parameters
    ----------
    message : str
        What is wrong, and what would be right.
    span : Span
        The characters that it is about.
    """

    def __init__(self, message: str, span: Span) -> None:
        self.message = message
        self.span = span
        super().__init__(f"character {span.start + 1}: {message}")


@dataclass(frozen=True)
class Number:
    """A number and its unit, as written; empty without one."""

    value: float
    unit: str
    span: Span


@dataclass(frozen=True)
class Name:
    """A channel by its name."""

    name: str
    span: Span


@dataclass(frozen=True)
class Call:
    """An operator or a function of other nodes.

    Attributes
    ----------
    function : str
        ``+``, ``-``, ``*``, ``/``, ``negate``, ``power``, or a name.
    arguments : tuple of nodes
        What it is of; of ``power`` the base and a Number.
    span : Span
        All of it.
    at : Span
        Its sign or name.
    """

    function: str
    arguments: tuple[Node, ...]
    span: Span
    at: Span


Node: TypeAlias = Number | Name | Call

CONSTANTS = {"pi": math.pi}


class _Token(NamedTuple):
    kind: str
    text: str
    span: Span


def parse(text: str) -> Node:
    """Return the tree of an expression.

    The grammar, in order of precedence: ``+ -``, then ``* /``, then signs, then ``**`` or ``^``
    with a whole number, then numbers with an optional unit in brackets, channels, functions and
    parentheses. A channel whose name is not made of letters, digits, ``_`` and dots stands in
    double quotes.

    Raises
    ------
    ExpressionError
        If it is none, is too long or too deep.
    """
    if len(text) > LENGTH_MAX:
        span = Span(LENGTH_MAX, len(text))
        raise ExpressionError(
            f"has {len(text)} characters; {LENGTH_MAX} are the most; "
            "make two channels, or shorten it",
            span,
        )
    parser = _Parser(text)
    node = parser.sum(0)
    parser.expect("end")
    return node


def _tokens(text: str) -> list[_Token]:
    tokens, place = [], 0
    while place < len(text.rstrip()):
        match = _TOKEN.match(text, place)
        if not match:
            at = place + len(text[place:]) - len(text[place:].lstrip())
            raise ExpressionError(
                f"{text[at]!r} has no meaning here; allowed are numbers, channels, functions and "
                "+ - * / ** ( )",
                Span(at, at + 1),
            )
        kind = match.lastgroup or ""
        span = Span(*match.span(kind))
        tokens.append(_Token(kind, match[kind], span))
        place = match.end()
    tokens.append(_Token("end", "", Span(len(text), len(text))))
    return tokens


class _Parser:
    def __init__(self, text: str) -> None:
        self._tokens = _tokens(text)
        self._place = 0

    @property
    def _token(self) -> _Token:
        return self._tokens[self._place]

    def _next(self) -> _Token:
        token = self._token
        self._place += 1
        return token

    def _sign(self, *signs: str) -> _Token | None:
        """Take the next token if it is one of these signs."""
        token = self._token
        return self._next() if token.kind == "sign" and token.text in signs else None

    def expect(self, text: str) -> _Token:
        """Take the next token, which must be this sign or the end."""
        token = self._token
        if text in {token.text, token.kind}:
            return self._next()
        expected = "an operator or the end" if text == "end" else f"'{text}'"
        raise ExpressionError(f"{_text(token)} stands where {expected} belongs", token.span)

    def sum(self, depth: int) -> Node:
        """Read terms joined by + and -."""
        if depth > DEPTH_MAX:
            raise ExpressionError(
                f"more than {DEPTH_MAX} parentheses, functions and signs within each other",
                self._token.span,
            )
        node = self._product(depth)
        while sign := self._sign("+", "-"):
            node = _joined(sign, node, self._product(depth))
        return node

    def _product(self, depth: int) -> Node:
        node = self._signed(depth)
        while sign := self._sign("*", "/"):
            node = _joined(sign, node, self._signed(depth))
        return node

    def _signed(self, depth: int) -> Node:
        signs = []
        while sign := self._sign("+", "-"):
            signs.append(sign)
            if depth + len(signs) > DEPTH_MAX:
                raise ExpressionError(f"more than {DEPTH_MAX} signs in a row", sign.span)
        node = self._power(depth)
        for sign in reversed(signs):
            if sign.text == "-":
                span = Span(sign.span.start, node.span.end)
                node = Call("negate", (node,), span, sign.span)
        return node

    def _power(self, depth: int) -> Node:
        base = self._operand(depth)
        sign = self._sign("**", "^")
        if sign is None:
            return base
        minus = self._sign("-")
        token = self._next()
        whole = token.kind == "number" and token.text.isdigit()
        if not whole or len(token.text) > 1 or int(token.text) > EXPONENT_MAX:
            raise ExpressionError(
                f"{_text(token)} is no power; allowed are whole numbers from -{EXPONENT_MAX} to "
                f"{EXPONENT_MAX}",
                token.span,
            )
        if again := self._sign("**", "^"):
            raise ExpressionError("a power of a power needs parentheses", again.span)
        value = -float(token.text) if minus else float(token.text)
        span = Span(base.span.start, token.span.end)
        return Call("power", (base, Number(value, "", token.span)), span, sign.span)

    def _operand(self, depth: int) -> Node:
        token = self._next()
        match token.kind:
            case "number":
                return self._number(token)
            case "quoted":
                return Name(token.text, token.span)
            case "name" if self._token.text == "(" and self._token.kind == "sign":
                return self._call(token, depth)
            case "name" if token.text in CONSTANTS:
                return Number(CONSTANTS[token.text], "", token.span)
            case "name":
                return Name(token.text, token.span)
            case "sign" if token.text == "(":
                node = self.sum(depth + 1)
                self.expect(")")
                return node
            case _:
                raise ExpressionError(
                    f"{_text(token)} stands where a number, a channel, a function or '(' belongs",
                    token.span,
                )

    def _number(self, token: _Token) -> Number:
        value = float(token.text)
        if not math.isfinite(value):
            raise ExpressionError(f"{token.text} is beyond the largest number", token.span)
        unit = self._token
        if unit.kind != "unit":
            return Number(value, "", token.span)
        self._next()
        return Number(value, unit.text[1:-1].strip() or "1", Span(token.span.start, unit.span.end))

    def _call(self, name: _Token, depth: int) -> Call:
        self._next()
        arguments = []
        if self._token.text != ")":
            arguments.append(self.sum(depth + 1))
            while self._sign(","):
                arguments.append(self.sum(depth + 1))
        end = self.expect(")")
        return Call(name.text, tuple(arguments), Span(name.span.start, end.span.end), name.span)


def _joined(sign: _Token, left: Node, right: Node) -> Call:
    return Call(sign.text, (left, right), Span(left.span.start, right.span.end), sign.span)


def _text(token: _Token) -> str:
    return "the end" if token.kind == "end" else f"{token.text!r}"
