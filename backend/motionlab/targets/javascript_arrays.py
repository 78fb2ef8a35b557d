"""Arrays of NumPy as typed arrays of JavaScript, and matrices as lists of their rows."""

from __future__ import annotations

import ast
from collections.abc import Callable

Expression = Callable[[ast.expr], str]
"""Translates an expression."""

_ELEMENTS = {"minimum": "min", "maximum": "max", "hypot": "hypot"}
"""Functions of NumPy of single elements."""
ARRAYS = """\
const halfEven = (value) => {
  const rounded = Math.round(value);
  return Math.abs(value % 1) === 0.5 && rounded % 2 !== 0 ? rounded - 1 : rounded;
};
const matrix = (rows, columns) => Array.from({ length: rows }, () => new Float64Array(columns));
const like = (values) =>
  values[0]?.length ? matrix(values.length, values[0].length) : new Float64Array(values.length);
// Views, as slices of NumPy are: the rows of a matrix are those of its part.
const part = (values, first, stop) =>
  values.subarray ? values.subarray(first, stop) : values.slice(first, stop);
const searchRight = (sorted, value) => {
  let [low, high] = [0, sorted.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (sorted[middle] <= value) low = middle + 1;
    else high = middle;
  }
  return low;
};
"""
"""What functions on arrays call."""


def element(value: str, key: ast.expr, expression: Expression) -> str:
    """Return an element or a part of an array."""
    match key:
        case ast.Tuple([ast.Slice(None, None, None), column]):
            return f"{value}.map((row) => row[{expression(column)}])"
        case ast.Tuple([row, column]):
            return f"{value}[{expression(row)}][{expression(column)}]"
        case ast.Slice(ast.expr() as first, ast.expr() as stop, None):
            return f"part({value}, {expression(first)}, {expression(stop)})"
        case ast.UnaryOp(ast.USub(), ast.Constant()):
            return f"{value}.at({expression(key)})"
    return f"{value}[{expression(key)}]"


def of_numpy(  # noqa: PLR0911 - one case a function
    node: ast.Call, name: str, expression: Expression
) -> str | None:
    """Return a call of a function of NumPy; None where it is not translated."""
    values = node.args
    match name, values:
        case "ones" | "zeros", [ast.Attribute(_, "shape")]:
            return "1" if name == "ones" else "0"
        case "empty", [ast.Attribute(array, "shape")]:
            return f"like({expression(array)})"
        case "empty" | "zeros", [ast.Tuple([rows, columns])]:
            return f"matrix({expression(rows)}, {expression(columns)})"
        case "empty" | "zeros", [size]:
            return f"new Float64Array({expression(size)})"
        case "searchsorted", [within, value] if "side='right'" in ast.unparse(node):
            return f"searchRight({expression(within)}, {expression(value)})"
    if name not in _ELEMENTS:
        return None
    return f"Math.{_ELEMENTS[name]}({', '.join(expression(each) for each in values)})"
