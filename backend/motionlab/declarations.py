"""What laws and force-sharing functions declare, one file each: parameters; reading the files."""

from __future__ import annotations

import ast
import functools
import inspect
import io
import keyword
import math
import operator
import pkgutil
import re
import textwrap
import tokenize
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from importlib import import_module
from typing import Any

from motionlab.errors import FieldError, MotionLabError

PAPER = "Huang et al., IEEE Access 2019"
OURS = "this project's choice"

NAME_MAX = 40
"""Most characters of a name."""


class DeclarationError(MotionLabError, TypeError):
    """A law or a force-sharing function that cannot be used as it is declared.

    Parameters
    ----------
    error : FieldError
        File, field, value and what is allowed.
    """

    def __init__(self, error: FieldError) -> None:
        self.error = error
        super().__init__(str(error))


@dataclass(frozen=True)
class Parameter:
    """A parameter: a field of a controller's config.

    Attributes
    ----------
    name : str
        As in the lanes' record of parameters, where that is not derived from others.
    description : str
        What the number is.
    unit : str
        SI unit; ``1`` for a pure number, and nothing for a choice.
    default : float, str or None
        None: its owner decides.
    ge, gt, le, lt : float, optional
        Bounds, in `unit`.
    usual : tuple of float, optional
        Range of a slider, in `unit`.
    shown : str
        Unit on the screen, as `motionlab.config.quantity.FACTORS` has it; empty for `unit` itself.
    choices : tuple of str
        The values of a parameter that is no number.
    label, source : str
        Name on the screen; where the number or its range comes from.
    """

    name: str
    description: str
    unit: str = ""
    default: float | str | None = None
    ge: float | None = None
    gt: float | None = None
    le: float | None = None
    lt: float | None = None
    usual: tuple[float, float] | None = None
    shown: str = ""
    choices: tuple[str, ...] = ()
    label: str | None = None
    source: str = OURS


def allows(parameter: Parameter, value: Any) -> bool:
    """Return whether a parameter can have a value; None where its owner then decides."""
    each = parameter
    if each.choices:
        return value in each.choices
    if value is None:
        return each.default is None
    ends = (each.ge, operator.ge), (each.gt, operator.gt), (each.le, operator.le)
    return _is_number(value) and all(
        end is None or within(value, end) for end, within in (*ends, (each.lt, operator.lt))
    )


def declared_in(package: str, path: Iterable[str], variable: str) -> list[Any]:
    """Return what the modules of a package declare in a variable, in the order of their names.

    Raises
    ------
    DeclarationError
        If one cannot be used as it is declared, or two have the same name.
    """
    owners: dict[str, Any] = {}
    for each in pkgutil.iter_modules(path):
        module = import_module(f"{package}.{each.name}")
        if not hasattr(module, variable):
            continue
        owner, place = getattr(module, variable), _file(module.__name__)
        check_owner(owner, variable, place)
        if owner.name in owners:
            message = f"two files declare a {variable.lower()} of this name"
            raise DeclarationError(FieldError(owner.name, message, place=place))
        owners[owner.name] = owner
    return list(owners.values())


def check_owner(owner: Any, variable: str, place: str) -> None:
    """Check what a file declares in a variable.

    Raises
    ------
    DeclarationError
        If it cannot be used as it is declared.
    """
    for loc, *rest in _wrong(owner, variable):
        raise DeclarationError(FieldError(loc, *rest, place=place))


def parameters_of(owners: Iterable[Any], taken: frozenset[str]) -> dict[str, Parameter]:
    """Return the parameters of all owners by name; owners share those that are declared alike.

    Raises
    ------
    DeclarationError
        If a name is `taken`, or is declared otherwise by another.
    """
    shared: dict[str, Parameter] = {}
    for owner in owners:
        for each in owner.parameters:
            if each.name in taken:
                message = f"a parameter may not be called {each.name}"
                raise DeclarationError(FieldError(owner.name, message))
            if shared.setdefault(each.name, each) != each:
                message = f"{each.name} is declared otherwise by another"
                raise DeclarationError(FieldError(owner.name, message))
    return shared


_FOR_TOOLS = "# noqa", "# type:", "# pyright:"


def comments_by_line(text: str, first: int) -> dict[int, str]:
    """Return the comments of a text by line, where `first` is the number of its first one."""
    tokens = tokenize.generate_tokens(io.StringIO(text).readline)
    return {
        token.start[0] + first - 1: token.string.lstrip("#").strip()
        for token in tokens
        if token.type == tokenize.COMMENT and not token.string.startswith(_FOR_TOOLS)
    }


@functools.cache
def field_comments(record: Any) -> dict[str, str]:
    """Return the comments beside the fields of a NamedTuple class, such as unit and meaning."""
    if hasattr(record, "comments"):
        return record.comments
    lines, _ = inspect.getsourcelines(getattr(record, "_like", record))
    comments = comments_by_line(textwrap.dedent("".join(lines)), 1)
    definition = ast.parse(textwrap.dedent("".join(lines))).body[0]
    assert isinstance(definition, ast.ClassDef)
    return {
        line.target.id: comments.get(line.lineno, "")
        for line in definition.body
        if isinstance(line, ast.AnnAssign) and isinstance(line.target, ast.Name)
    }


# -- checks ---------------------------------------------------------------------------------------

_Wrong = tuple[Any, ...]
"""Field, message, value and what is allowed, as in `FieldError`."""


def _file(module: str) -> str:
    return module.replace(".", "/") + ".py"


def _of_every_config(name: str) -> bool:
    """Tell whether configs have an attribute of this name."""
    from pydantic import BaseModel  # noqa: PLC0415 - imported on first use

    return name.startswith("model_") or hasattr(BaseModel, name)


def _wrong(owner: Any, variable: str) -> Iterator[_Wrong]:
    """Yield what cannot be in the declaration of a law or a force-sharing function."""
    fields = () if isinstance(owner, type) else getattr(owner, "__dataclass_fields__", ())
    if "parameters" not in fields:
        yield variable, f"is no {variable.lower()}", owner
        return
    name: Any = owner.name
    if not _is_name(name, r"[A-Za-z][A-Za-z0-9_-]*"):
        allowed = f"a letter, then letters, digits, - and _; {NAME_MAX} characters"
        yield f"{variable}.name", "is no name for configs and files", name, allowed
        return
    for text in ("label", "description", "source"):
        if not isinstance(getattr(owner, text), str):
            yield f"{name}.{text}", "is no text", getattr(owner, text)
    if not isinstance(owner.parameters, tuple):
        yield f"{name}.parameters", "is no tuple of Parameter", owner.parameters
        return
    for parameter in owner.parameters:
        if not isinstance(parameter, Parameter):
            yield f"{name}.parameters", "holds what is no Parameter", parameter
            return
        yield from _wrong_parameter(f"{name}.{parameter.name}", parameter)
    if hasattr(owner, "Parameters"):
        yield from _wrong_records(owner)


def _is_name(name: Any, pattern: str) -> bool:
    return isinstance(name, str) and len(name) <= NAME_MAX and bool(re.fullmatch(pattern, name))


def _wrong_parameter(loc: str, each: Parameter) -> Iterator[_Wrong]:
    if not _is_name(each.name, r"[A-Za-z][A-Za-z0-9_]*") or keyword.iskeyword(each.name):
        allowed = f"a letter, then letters, digits and _, no word of Python; {NAME_MAX} characters"
        yield loc, "is no name for a field", each.name, allowed
        return
    if _of_every_config(each.name):
        yield loc, "has a name that every config uses for itself; name it otherwise"
        return
    for text in ("description", "unit", "shown", "source"):
        if not isinstance(getattr(each, text), str):
            yield f"{loc}.{text}", "is no text", getattr(each, text)
    if each.choices:
        if each.default not in each.choices:
            yield f"{loc}.default", "is none of its choices", each.default, ", ".join(each.choices)
        return
    numbers = {name: getattr(each, name) for name in ("default", "ge", "gt", "le", "lt")}
    for name, number in numbers.items():
        if number is not None and not _is_number(number):
            yield f"{loc}.{name}", "is no finite number", number
            return
    if (each.ge is None) == (each.gt is None):
        yield loc, "needs a lower bound", None, "one of ge and gt"
        return
    if (each.le is None) == (each.lt is None):
        yield loc, "needs an upper bound", None, "one of le and lt"
        return
    yield from _wrong_range(loc, each)


def _wrong_range(loc: str, each: Parameter) -> Iterator[_Wrong]:
    if not each.unit:
        yield f"{loc}.unit", "is missing", None, "an SI unit, or 1 for a pure number"
    signs = {"ge": ">=", "gt": ">", "le": "<=", "lt": "<"}
    ends = {sign: end for name, sign in signs.items() if (end := getattr(each, name)) is not None}
    low, high = ends.values()
    allowed = " and ".join(f"{sign} {end:g}" for sign, end in ends.items())
    if not low < high:
        yield loc, "has bounds between which no number is", allowed
        return
    default: Any = each.default
    if _is_number(default) and not (low <= default <= high and default not in (each.gt, each.lt)):
        yield f"{loc}.default", "is outside of its range", default, allowed, each.unit
    if each.usual is None:
        return
    usual: Any = each.usual
    if not isinstance(usual, tuple) or len(usual) != 2 or not all(map(_is_number, usual)):
        yield f"{loc}.usual", "is no pair of finite numbers", str(usual)
    elif not low <= usual[0] < usual[1] <= high:
        yield f"{loc}.usual", "is no range within its bounds", str(usual), allowed, each.unit


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def _wrong_resets(owner: Any) -> Iterator[_Wrong]:
    """Yield what cannot be among the fields of a law's state that a new version resets."""
    loc, names, fields = f"{owner.name}.resets", owner.resets, owner.State._fields
    if not isinstance(names, tuple):
        yield loc, 'is no tuple of names, such as ("w",)', names
        return
    for name in names:
        if name not in fields:
            yield loc, "names no field of its State", name, ", ".join(fields) or "none: no State"


def _wrong_records(owner: Any) -> Iterator[_Wrong]:
    """Yield what cannot be in a law's records of lanes."""
    for kind in ("Parameters", "State"):
        record = getattr(owner, kind)
        if not (
            isinstance(record, type) and issubclass(record, tuple) and hasattr(record, "_fields")
        ):
            yield f"{owner.name}.{kind}", "is no NamedTuple class", record
            return
    if hasattr(owner, "resets"):
        yield from _wrong_resets(owner)
    if not callable(owner.step):
        yield f"{owner.name}.step", "is no function", owner.step
    if owner.lane is not None:
        return
    declared = {each.name: each for each in owner.parameters}
    for name in owner.Parameters._fields:
        loc = f"{owner.name}.{name}"
        if name not in declared:
            yield loc, "is in its Parameters, but not declared; declare it, or give a lane function"
        elif not _is_number(declared[name].default):
            message = "is no number that a lane can have; give a default, or a lane function"
            yield f"{loc}.default", message, declared[name].default
