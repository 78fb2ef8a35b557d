"""Plain Python functions as JavaScript: lane parameters of a config, motions by tick.

The functions are translated from their source, not run, so both sides of a branch are there. What
they may contain is arithmetic, branches, loops over ranges, records of numbers, arrays of one or
two axes and calls of one another; anything else raises `UntranslatableError`, naming the function.
A function of NumPy on all elements of an array becomes one of a single number.
"""

from __future__ import annotations

import ast
import dataclasses
import inspect
import json
import math
import re
import textwrap
from collections.abc import Mapping
from types import FunctionType
from typing import Any

import numpy as np

from motionlab.errors import MotionLabError
from motionlab.targets.c_words import free_name
from motionlab.targets.javascript_arrays import element, of_numpy

_BINARY = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.Pow: "**"}
_COMPARE = {ast.Is: "===", ast.IsNot: "!==", ast.Eq: "===", ast.NotEq: "!=="} | {
    ast.Lt: "<",
    ast.LtE: "<=",
    ast.Gt: ">",
    ast.GtE: ">=",
}
_BUILTINS = {name: f"Math.{name}" for name in ("abs", "min", "max")} | {
    "float": "Number",
    "round": "halfEven",
}
_ITSELF = {"model_dump", "values"}
"""Methods that give the fields of a config: a config is plain JSON here."""


class UntranslatableError(MotionLabError):
    """A function has something that is not translated."""


class Translator:
    """Translates functions and whatever they call.

    Parameters
    ----------
    replaced : mapping of callable to str
        Functions that are in JavaScript otherwise, and their names there.
    constants : mapping of str to str
        Names that stand for something else in JavaScript, and what that is.
    methods : mapping of str to callable
        Methods of configs by name; each becomes a function of its object.
    """

    def __init__(
        self,
        *,
        replaced: Mapping[Any, str],
        constants: Mapping[str, str],
        methods: Mapping[str, FunctionType],
    ) -> None:
        self.replaced = replaced
        self.constants = constants
        self.methods = methods
        self._texts: dict[FunctionType, str] = {}
        self._names: dict[FunctionType, str] = {}

    def name(self, function: Any) -> str:
        """Return the JavaScript name of a function, which is translated if it has not been yet."""
        if function in self.replaced:
            return self.replaced[function]
        function = inspect.unwrap(function)  # of what is compiled
        if function not in self._names:
            module = function.__module__.rpartition(".")[2]
            name = re.sub(r"\W", "_", f"{module}_{function.__qualname__}")
            self._names[function] = free_name(name, self._names.values())
            self._texts[function] = ""  # in its place, should it call itself
            self._texts[function] = _Function(self, function).text()
        return self._names[function]

    def code(self) -> str:
        """Return all functions so far."""
        return "\n".join(self._texts.values())


class _Function:
    """One function."""

    def __init__(self, translator: Translator, function: FunctionType) -> None:
        self.translator = translator
        self.function = function
        closed = inspect.getclosurevars(function)
        self.seen: dict[str, Any] = {**function.__globals__, **closed.nonlocals}
        node = ast.parse(textwrap.dedent(inspect.getsource(function))).body[0]
        if not isinstance(node, ast.FunctionDef):
            raise self.refusal(node)
        self.node = node
        self.local = set(inspect.signature(function).parameters)

    def refusal(self, node: ast.AST) -> UntranslatableError:
        what = ast.unparse(node)
        return UntranslatableError(f"{self.function.__qualname__}: {what!r} is not translated")

    def text(self) -> str:
        parameters = inspect.signature(self.function).parameters.values()
        listed = ", ".join(
            _local(each.name)
            if each.default is inspect.Parameter.empty
            else f"{_local(each.name)} = {_literal(each.default)}"
            for each in parameters
        )
        return (
            f"function {self.translator.name(self.function)}({listed}) {self.block(self.node.body)}"
        )

    def block(self, statements: list[ast.stmt]) -> str:
        return "{\n" + "".join(self.statement(each) for each in statements) + "}\n"

    def statement(self, node: ast.stmt) -> str:  # noqa: PLR0911 - one case a construct
        match node:
            case ast.Expr(ast.Constant(str())):
                return ""
            case ast.Assign(targets, value):
                assigned = self.expression(value)
                return "".join(f"{self.target(each)} = {assigned};\n" for each in targets)
            case ast.AugAssign(target, op, value) if type(op) in _BINARY:
                left = self.expression(target)
                return f"{left} = {left} {_BINARY[type(op)]} {self.expression(value)};\n"
            case ast.AnnAssign(target=target, value=ast.expr() as value):
                return f"{self.target(target)} = {self.expression(value)};\n"
            case ast.Assert():
                return ""
            case ast.Expr(ast.Call() as call):
                return f"{self.call(call)};\n"
            case ast.For(ast.Name(name), ast.Call(ast.Name("range"), limits), body, []):
                start, stop = ("0", *(self.expression(each) for each in limits))[-2:]
                self.local.add(name)
                k = _local(name)
                return f"for (var {k} = {start}; {k} < {stop}; {k}++) {self.block(body)}"
            case ast.While(test, body, []):
                return f"while ({self.expression(test)}) {self.block(body)}"
            case ast.Return(value):
                return f"return {'null' if value is None else self.expression(value)};\n"
            case ast.If(test, body, orelse):
                rest = f"else {self.block(orelse)}" if orelse else ""
                return f"if ({self.expression(test)}) {self.block(body)}{rest}"
        raise self.refusal(node)

    def target(self, node: ast.expr) -> str:
        """Return what is assigned to: names, which it declares, or elements of arrays."""
        match node:
            case ast.Name(name):
                self.local.add(name)
                return f"var {_local(name)}"
            case ast.Subscript():
                return self.expression(node)
            case ast.Tuple(parts) if all(isinstance(each, ast.Subscript) for each in parts):
                return self.expression(node)
            case ast.Tuple(parts):
                return f"var [{', '.join(self.target(each)[4:] for each in parts)}]"
        raise self.refusal(node)

    def expression(self, node: ast.expr) -> str:  # noqa: PLR0911, PLR0912 - one case a construct
        match node:
            case ast.Constant(value):
                return _literal(value)
            case ast.Name(name):
                return _local(name) if name in self.local else self.constant(node, name)
            case ast.BinOp(left, ast.FloorDiv(), right):
                return f"Math.floor({self.expression(left)} / {self.expression(right)})"
            case ast.BinOp(left, op, right) if type(op) in _BINARY:
                sides = (self.expression(left), self.expression(right))
                return f"({sides[0]} {_BINARY[type(op)]} {sides[1]})"
            case ast.UnaryOp(ast.USub(), value):
                return f"(-{self.expression(value)})"
            case ast.UnaryOp(ast.Not(), value):
                return f"(!{self.expression(value)})"
            case ast.BoolOp(op, values):
                sign = " && " if isinstance(op, ast.And) else " || "
                return f"({sign.join(self.expression(each) for each in values)})"
            case ast.Compare(left, ops, rights) if all(type(op) in _COMPARE for op in ops):
                sides = [self.expression(each) for each in (left, *rights)]
                pairs = zip(sides, ops, sides[1:], strict=False)
                return f"({' && '.join(f'{a} {_COMPARE[type(op)]} {b}' for a, op, b in pairs)})"
            case ast.IfExp(test, body, orelse):
                parts = (self.expression(each) for each in (test, body, orelse))
                return "({} ? {} : {})".format(*parts)
            case ast.Tuple(parts) | ast.List(parts):
                return f"[{', '.join(self.expression(each) for each in parts)}]"
            case ast.Starred(value):
                return f"...{self.expression(value)}"
            case ast.Subscript(value, key):
                return element(self.expression(value), key, self.expression)
            case ast.Attribute(ast.Name("math" | "np"), "inf"):
                return "Infinity"
            case ast.Attribute(ast.Name("math"), name):
                return f"Math.{name.upper() if name in {'pi', 'e'} else name}"
            case ast.Attribute(value, name):
                return f"{self.expression(value)}.{name}"
            case ast.JoinedStr(parts):
                return f"`{''.join(self.part(each) for each in parts)}`"
            case ast.Call():
                return self.call(node)
        raise self.refusal(node)

    def part(self, node: ast.expr) -> str:
        """Return a piece of a text; numbers in it have few digits."""
        match node:
            case ast.Constant(str(text)):
                return text
            case ast.FormattedValue(value, _, None):
                return f"${{{self.expression(value)}}}"
            case ast.FormattedValue(value, _, ast.JoinedStr([ast.Constant(".4g")])):
                return f"${{Number({self.expression(value)}.toPrecision(4))}}"
            case ast.FormattedValue(value, _, ast.JoinedStr([ast.Constant("g")])):
                return f"${{Number({self.expression(value)}.toPrecision(6))}}"
        raise self.refusal(node)

    def constant(self, node: ast.expr, name: str) -> str:
        if name in self.translator.constants:
            return self.translator.constants[name]
        try:
            return _literal(self.seen[name])
        except (KeyError, TypeError):
            raise self.refusal(node) from None

    def call(self, node: ast.Call) -> str:  # noqa: PLR0911 - one case a kind of call
        match node:
            case ast.Call(ast.Name("getattr"), [value, name]):
                return f"{self.expression(value)}[{self.expression(name)}]"
            case ast.Call(ast.Name("len"), [value], []):
                return f"{self.expression(value)}.length"
            case ast.Call(ast.Attribute(ast.Name("np"), name)):
                if text := of_numpy(node, name, self.expression):
                    return text
            case ast.Call(ast.Attribute(value, "astype"), [_]):
                return self.expression(value)
            case ast.Call(ast.Name(name), [value], []) if name in _BUILTINS:
                return f"{_BUILTINS[name]}({self.expression(value)})"
            case ast.Call(ast.Name("min" | "max" as name), values, []):
                return f"Math.{name}({', '.join(self.expression(each) for each in values)})"
            case ast.Call(ast.Attribute(ast.Name("math")) as function, values, []):
                listed = ", ".join(self.expression(each) for each in values)
                return f"{self.expression(function)}({listed})"
            case ast.Call(ast.Attribute(value, name), []) if name in _ITSELF:
                return self.expression(value)
            case ast.Call(ast.Attribute(value, name), [], []) if name in self.translator.methods:
                method = self.translator.name(self.translator.methods[name])
                return f"{method}({self.expression(value)})"
            case ast.Call(ast.Name(name), positional, keywords) if name in self.seen:
                return self.known(node, self.seen[name], positional, keywords)
        raise self.refusal(node)

    def known(
        self, node: ast.Call, callee: Any, positional: list[ast.expr], keywords: list[ast.keyword]
    ) -> str:
        """Return a call of a function, or a record, whose fields have the order of its class."""
        callee = inspect.unwrap(callee) if callable(callee) else callee
        record = hasattr(callee, "_fields") or dataclasses.is_dataclass(callee)
        if not callable(callee) or not (record or isinstance(callee, FunctionType)):
            raise self.refusal(node)
        names = list(inspect.signature(callee).parameters)
        values = [self.expression(each) for each in positional]
        by_name: dict[str, str] = {}
        for keyword in keywords:
            value = self.expression(keyword.value)
            if keyword.arg is not None:
                by_name[keyword.arg] = value
            else:  # **config: its fields by name
                rest = [each for each in names[len(values) :] if each not in by_name]
                by_name |= {each: f"{value}.{each}" for each in rest}
        if not record:
            following = [by_name[each] for each in names[len(values) :] if each in by_name]
            return f"{self.translator.name(callee)}({', '.join([*values, *following])})"
        if any(isinstance(each, ast.Starred) for each in positional):
            return f"record({json.dumps(names)}, [{', '.join(values)}])"
        values += [by_name[each] for each in names[len(values) :]]
        pairs = zip(names, values, strict=True)
        return f"{{{', '.join(f'{name}: {value}' for name, value in pairs)}}}"


def _local(name: str) -> str:
    """Return the name of a variable: no word of JavaScript, and no other name of the module.

    Those end in no $, which Python does not have.
    """
    return f"{name}$"


def _literal(value: Any) -> str:
    """Return a constant; raises TypeError where it is none."""
    if hasattr(value, "_fields"):
        fields = (f"{name}: {_literal(each)}" for name, each in value._asdict().items())
        return f"{{{', '.join(fields)}}}"
    if isinstance(value, np.ndarray):
        return json.dumps(value.tolist())
    if isinstance(value, (float, np.floating)) and math.isinf(value):
        return "Infinity" if value > 0.0 else "-Infinity"
    return json.dumps(value)
