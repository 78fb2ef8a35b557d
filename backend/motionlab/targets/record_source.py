"""Source of a lane function: its comments, and a copy that tells a recorder its names.

Python runs the copy, so that it may use whatever a lane function may. In it

* ``x = value`` reads ``x = __record__.name("x", value, line)``, also for several names;
* ``return value`` reads ``return __record__.returned(value, names, line)``;
* ``for _ in range(n)`` runs its block once, between two calls that tell where it begins and ends;
* ``for x in values`` reads ``for x in __record__.turns(values, line)``, which ends some time;
* ``a ** b`` reads ``__record__.power(a, b)``.
"""

from __future__ import annotations

import ast
import functools
import inspect
import sys
import textwrap
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from types import CodeType
from typing import Any

from motionlab.declarations import comments_by_line
from motionlab.targets.record_values import RecordError

HOOK = "__record__"
"""Name of the recorder in the copy."""


@dataclass(frozen=True)
class FunctionSource:
    """A lane function's source; lines are counted in its file.

    Attributes
    ----------
    comments, trailing : dict
        Comments on lines of their own, and beside code, by line.
    """

    name: str
    module: str
    first_line: int
    docstring: str
    comments: dict[int, str]
    trailing: dict[int, str]
    blank_lines: frozenset[int]
    code: CodeType


def plain(function: Any) -> Callable[..., Any]:
    """Return the Python function of a compiled one."""
    return getattr(function, "py_func", function)


@functools.cache
def source_of(function: Callable[..., Any]) -> FunctionSource:
    """Return the source of a plain Python function."""
    lines, first = inspect.getsourcelines(function)
    text = textwrap.dedent("".join(lines))
    tree = ast.parse(text)
    ast.increment_lineno(tree, first - 1)
    definition = tree.body[0]
    if not isinstance(definition, ast.FunctionDef):
        raise TypeError(f"{function!r} is not defined by a def statement")
    definition.decorator_list = []
    docstring = ast.get_docstring(definition) or ""
    if docstring:
        definition.body = definition.body[1:]
    _rewrite(definition)
    ast.fix_missing_locations(tree)
    comments = comments_by_line(text, first)
    alone = {first + i for i, line in enumerate(lines) if line.lstrip().startswith("#")}
    return FunctionSource(
        name=function.__name__,
        module=function.__module__,
        first_line=first,
        docstring=docstring,
        comments={at: each for at, each in comments.items() if at in alone},
        trailing={at: each for at, each in comments.items() if at not in alone},
        blank_lines=frozenset(first + i for i, line in enumerate(lines) if not line.strip()),
        code=compile(tree, inspect.getfile(function), "exec"),
    )


@functools.cache
def _module_tree(module: str) -> tuple[ast.Module, dict[int, str]]:
    text = inspect.getsource(sys.modules[module])
    return ast.parse(text), comments_by_line(text, 1)


def constant_origin(module: str, name: str) -> tuple[str, str]:
    """Return the module and the name with which a constant is defined that a module may import."""
    for statement in _module_tree(module)[0].body:
        match statement:
            case ast.ImportFrom(module=str(origin), names=names):
                for alias in names:
                    if (alias.asname or alias.name) == name:
                        return constant_origin(origin, alias.name)
            case ast.Assign(targets=[ast.Name(id=target)], value=ast.Name(id=other)):
                if target == name:
                    return constant_origin(module, other)
            case _:
                pass
    return module, name


def constant_comment(module: str, name: str) -> str:
    """Return the trailing comment of a module's constant, or the string below it."""
    tree, comments = _module_tree(module)
    for statement, below in zip(tree.body, [*tree.body[1:], None], strict=True):
        match statement:
            case ast.Assign(targets=[ast.Name(id=target)]) if target == name:
                if isinstance(below, ast.Expr) and isinstance(below.value, ast.Constant):
                    return str(below.value.value).partition("\n")[0]
                return comments.get(statement.lineno, "")
            case _:
                pass
    return ""


def module_docstring(module: str) -> str:
    """Return the docstring of a module."""
    return inspect.getdoc(sys.modules[module]) or ""


# -- the copy -------------------------------------------------------------------------------------


def _hook(name: str, *arguments: ast.expr) -> ast.Call:
    function = ast.Attribute(ast.Name(HOOK, ast.Load()), name, ast.Load())
    return ast.Call(function, list(arguments), [])


def _rewrite(definition: ast.FunctionDef) -> None:
    arguments = definition.args
    parameters = [*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs]
    for parameter in parameters:
        parameter.annotation = None
    definition.returns = None
    for statement in ast.walk(definition):
        _check(statement)
    definition.body = _block(definition.body, {parameter.arg for parameter in parameters})
    _Powers().visit(definition)


def _check(node: ast.AST) -> None:
    """Refuse a statement that lanes do not have, whatever it is about."""
    match node:
        case ast.While():
            what = "while: a loop has a number of turns that is known, for _ in range(n)"
        case ast.Expr(value=ast.Call() as call):
            what = f"{ast.unparse(call)[:60]}: a call without use of its result"
        case ast.Try() | ast.With() | ast.Raise() | ast.Global() | ast.Nonlocal() | ast.Delete():
            what = f"{type(node).__name__.lower()}: lanes do not have it"
        case _:
            return
    raise RecordError(f"line {node.lineno}: {what}")


class _Powers(ast.NodeTransformer):
    """Has the recorder compute powers."""

    def visit_BinOp(self, node: ast.BinOp) -> ast.expr:
        self.generic_visit(node)
        if not isinstance(node.op, ast.Pow):
            return node
        return ast.copy_location(_hook("power", node.left, node.right), node)


def _block(body: Iterable[ast.stmt], known: set[str]) -> list[ast.stmt]:
    """Return the statements of a block, rewritten; `known` are names that have a value by then."""
    rewritten: list[ast.stmt] = []
    for statement in body:
        match statement:
            case ast.Assign(targets=[target], value=value) if _pattern(target) is not None:
                rewritten.append(_named(statement, target, value))
            case ast.AnnAssign(target=ast.Name() as target, value=ast.expr() as value):
                rewritten.append(_named(statement, target, value))
            case ast.AugAssign(target=ast.Name(id=name) as target, op=op, value=value):
                total = ast.BinOp(ast.Name(name, ast.Load()), op, value)
                rewritten.append(_named(statement, target, total))
            case ast.Return(value=ast.expr() as value):
                names = ast.parse(repr(_names(value)), mode="eval").body
                line = ast.Constant(statement.lineno)
                rewritten.append(_at(statement, ast.Return(_hook("returned", value, names, line))))
            case ast.For() if _is_counted(statement):
                rewritten += _loop(statement, known)
            case ast.If() | ast.For():
                if isinstance(statement, ast.For):
                    line = ast.Constant(statement.lineno)
                    statement.iter = _hook("turns", statement.iter, line)
                statement.body = _block(statement.body, known)
                statement.orelse = _block(statement.orelse, known)
                rewritten.append(statement)
            case _:
                rewritten.append(statement)
        known |= _assigned([statement])
    return rewritten


def _at(place: ast.stmt, statement: ast.stmt) -> ast.stmt:
    return ast.copy_location(statement, place)


def _pattern(target: ast.expr) -> Any:
    """Return the names of an assignment's target, nested as they are; None if there are others."""
    match target:
        case ast.Name(id=name):
            return name
        case ast.Tuple(elts=elements):
            inner = tuple(_pattern(element) for element in elements)
            return None if None in inner else inner
        case _:
            return None


def _named(place: ast.stmt, target: ast.expr, value: ast.expr) -> ast.stmt:
    pattern = ast.parse(repr(_pattern(target)), mode="eval").body
    named = _hook("name", pattern, value, ast.Constant(place.lineno))
    return _at(place, ast.Assign([target], named))


def _names(value: ast.expr) -> tuple[str, ...]:
    """Return the names of what is returned, empty for what has none."""
    elements = value.elts if isinstance(value, ast.Tuple) else [value]
    return tuple(each.id if isinstance(each, ast.Name) else "" for each in elements)


def _is_counted(loop: ast.For) -> bool:
    """Tell whether a loop repeats its block the same way each time."""
    match loop:
        case ast.For(
            target=ast.Name(id="_"), iter=ast.Call(func=ast.Name(id="range"), args=[_]), orelse=[]
        ):
            return not any(isinstance(each, (ast.Break, ast.Continue)) for each in ast.walk(loop))
        case _:
            return False


def _loop(loop: ast.For, known: set[str]) -> list[ast.stmt]:
    assert isinstance(loop.iter, ast.Call)
    line = ast.Constant(loop.lineno)
    begin = _at(loop, ast.Expr(_hook("loop_begin", loop.iter.args[0], line)))
    carried = [
        _at(
            loop,
            ast.Assign(
                [ast.Name(name, ast.Store())],
                _hook("carried", ast.Constant(name), ast.Name(name, ast.Load())),
            ),
        )
        for name in sorted(_assigned(loop.body) & known)
    ]
    end = _at(loop, ast.Expr(_hook("loop_end")))
    return [begin, *carried, *_block(loop.body, set(known)), end]


def _assigned(body: Iterable[ast.stmt]) -> set[str]:
    return {
        node.id
        for statement in body
        for node in ast.walk(statement)
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)
    }
