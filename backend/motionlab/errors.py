"""Failures a user can act on, with the data needed to fix them."""

from __future__ import annotations

import contextlib
import itertools
import json
import reprlib
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Any

DONE, FAILED, BAD_INPUT = 0, 1, 2
"""Exit codes of commands; FAILED, too, of one whose result is that a run or a check has failed."""

INTERRUPTED = 130
"""128 and the number of SIGINT, as shells have it."""

SHOWN_MAX = 20
"""Errors listed in a message; further ones are counted."""

LENGTH_MAX = 200
"""Characters of a value or a path that are shown."""

_WHOLE_MAX = 1e16
_DIGITS, _DIGITS_MAX = 6, 12  # of a value that is beyond a limit

_INTEGER_MAX = 128  # bits; Python refuses to print one of thousands of digits


class Written(str):
    """Text that is shown without quotes: a value as JSON."""

    __slots__ = ()
    __repr__ = str.__str__


class _Json(reprlib.Repr):
    """JSON bounded in depth and breadth, whatever is given."""

    def repr_bool(self, x: bool, level: int) -> str:
        return "true" if x else "false"

    def repr_NoneType(self, x: None, level: int) -> str:
        return "null"

    def repr_str(self, x: str, level: int) -> str:
        text = x if len(x) <= self.maxstring else x[: self.maxstring - 3] + "..."
        return json.dumps(text.encode("utf-8", "backslashreplace").decode(), ensure_ascii=False)

    def repr_tuple(self, x: tuple[Any, ...], level: int) -> str:
        return self.repr_list(list(x), level)

    def repr_dict(self, x: dict[Any, Any], level: int) -> str:
        if level <= 0 and x:
            return "{...}"
        items = [
            f"{self.repr1(key, level - 1)}: {self.repr1(item, level - 1)}"
            for key, item in itertools.islice(x.items(), self.maxdict)
        ]
        return "{" + ", ".join(items + ["..."] * (len(x) > self.maxdict)) + "}"


_REPR = _Json()
_REPR.maxlevel = 3
_REPR.maxdict = _REPR.maxlist = _REPR.maxtuple = 8
_REPR.maxstring = _REPR.maxother = LENGTH_MAX


def shown(value: object, length_max: int = LENGTH_MAX) -> object:
    """Return a value short enough to print: scalars as they are, text cut, the rest as JSON."""
    if isinstance(value, int) and value.bit_length() > _INTEGER_MAX:
        return f"a whole number of {value.bit_length()} bits"
    if value is None or isinstance(value, int | float):
        return value
    try:
        text = value if isinstance(value, str) else _REPR.repr(value)
    except ValueError:  # somewhere inside is a whole number of thousands of digits
        text = f"<{type(value).__name__}>"
    kind = str if type(value) is str else Written
    return kind(text if len(text) <= length_max else text[: length_max - 3] + "...")


class RunWarning(UserWarning):
    """A note of a run: what makes its figures worthless, or how they are to be read."""


class MotionLabError(Exception):
    """Base of every failure that is reported to the user without a traceback."""

    def __reduce__(self) -> tuple[Any, ...]:
        """Return a pickled form that does not depend on the arguments of its class."""
        return _remade, (type(self), self.args, self.__dict__)


def _remade(kind: type[MotionLabError], args: tuple[Any, ...], facts: dict[str, Any]) -> Any:
    error = kind.__new__(kind, *args)
    error.args = args
    error.__dict__.update(facts)
    return error


def _end(value: float) -> str:
    """Return an end of a range; whole numbers with all their digits."""
    whole = float(value).is_integer() and abs(value) < _WHOLE_MAX
    return str(int(value)) if whole else f"{value:.10g}"


SIGNS = {"minimum": ">=", "exclusive_minimum": ">", "maximum": "<=", "exclusive_maximum": "<"}
"""Kinds of bounds, in the words of JSON schema."""


@dataclass(frozen=True)
class FieldError:
    """One input field that cannot be used.

    Attributes
    ----------
    loc : str
        Dotted path of the field, such as ``variants.B.controller.x.k_p``.
    message : str
        What is wrong, in words.
    value : object
        What was given.
    range : str
        What is allowed, such as ``one of x, y``; left out: `bounds` as text, if there are any.
    unit : str
        Unit of the field; empty for names and switches.
    bounds : dict of str to float
        Ends of the allowed range by `SIGNS`.
    place : str
        File and line, such as ``my.toml:7``; empty where there is none.
    """

    loc: str
    message: str
    value: object = None
    range: str = ""
    unit: str = ""
    bounds: dict[str, float] = field(default_factory=dict, hash=False)
    place: str = ""

    def __post_init__(self) -> None:
        """Write the bounds as text."""
        if self.bounds and not self.range:
            ends = (
                f"{sign} {_end(self.bounds[end])}"
                for end, sign in SIGNS.items()
                if end in self.bounds
            )
            object.__setattr__(self, "range", " and ".join(ends))

    def at(self, place: str) -> FieldError:
        """Return it with a file, where it names none."""
        return self if self.place else replace(self, place=place)

    def __str__(self) -> str:
        """Return one line that names file, field, value, range and unit."""
        text = f"{self.place}: " if self.place else ""
        text += f"{shown(self.loc)}: {self.message}"
        if self.value is not None:
            got = (
                _REPR.repr(self.value) if isinstance(self.value, bool) else repr(shown(self.value))
            )
            text += f"; got {got}"
        if self.range:
            text += f"; allowed {self.range}"
        if self.unit not in {"", "1"}:
            text += f" {self.unit}" if self.range else f" (unit {self.unit})"
        return text


class ConfigError(MotionLabError):
    """Input that does not describe a scenario."""

    def __init__(self, *errors: FieldError) -> None:
        self.errors = errors
        lines = [str(error) for error in errors[:SHOWN_MAX]]
        if len(errors) > SHOWN_MAX:
            lines.append(f"and {len(errors) - SHOWN_MAX} more")
        super().__init__("\n".join(lines))


class Infeasible(MotionLabError):
    """A motion that the motor cannot follow, with the first time and place where it fails.

    Parameters
    ----------
    quantity : str
        ``position``, ``velocity``, ``acceleration``, ``thrust`` or ``step``.
    axis : str
        ``x`` or ``y``.
    time : float
        First time at which the limit is exceeded, s.
    place : tuple of float
        Reference position (x, y) at that time, m.
    value, limit : float
        Required and allowed value, in `unit`.
    unit : str
        Unit of `value` and `limit`.
    note : str
        What the limit leaves out.
    remedy : str
        What to do, where that is known.
    """

    def __init__(  # noqa: PLR0913 - one keyword for each fact the user needs
        self,
        *,
        quantity: str,
        axis: str,
        time: float,
        place: tuple[float, float],
        value: float,
        limit: tuple[float, float],
        unit: str,
        note: str = "",
        remedy: str = "",
    ) -> None:
        self.quantity = quantity
        self.axis = axis
        self.time = time
        self.place = place
        self.value = value
        self.limit = limit
        self.unit = unit
        self.note = note
        self.remedy = remedy
        super().__init__(
            f"trajectory: {quantity} on {axis} is {_beyond(value, limit)} {unit} "
            f"at t = {time:.4f} s, x = {place[0]:.6g} m, y = {place[1]:.6g} m; "
            f"allowed {limit[0]:.6g} to {limit[1]:.6g} {unit}{note and f', {note}'}"
            f"{remedy and f'; {remedy}'}"
        )

    def with_remedy(self, remedy: str) -> Infeasible:
        """Return the same error with what to do about it."""
        facts: dict[str, Any] = vars(self) | {"remedy": remedy}
        return Infeasible(**facts)


def _beyond(value: float, limit: tuple[float, float]) -> str:
    """Return a value with as many digits as tell it from the limit that it exceeds."""
    ends = {f"{end:.6g}" for end in limit}
    texts = [f"{value:.{digits}g}" for digits in range(_DIGITS, _DIGITS_MAX + 1)]
    return next((text for text in texts if text not in ends), texts[-1])


class StoreError(MotionLabError):
    """A record that cannot be written or read."""


class StoreFull(StoreError):
    """No room for another record, or none on the disk."""


class Unknown(StoreError):
    """No record of the name or identifier that was given."""


class Busy(StoreError):
    """A record that cannot be changed while it is being written."""


class Shipped(StoreError):
    """A record that ships with the project and cannot be changed."""


class NotReplayable(StoreError):
    """A run that cannot be simulated again from its record."""


class ExperimentFailed(MotionLabError):
    """An experiment on the motor without data to evaluate."""


_MODULES = {
    "lab": "alembic anyio fastapi httptools jinja2 lz4 mcap prometheus_client pyarrow "
    "pydantic_settings shtab skfem sqlalchemy starlette svgelements uvicorn uvloop viser "
    "websockets zstandard",
    "notebook": "IPython matplotlib pandas",
    "control": "control",
    "gym": "gymnasium",
    "cluster": "dask distributed",
    "postgres": "psycopg",
    "mdf": "asammdf",
    "search": "cmaes optuna sklearn",
}
EXTRA_OF = {module: extra for extra, modules in _MODULES.items() for module in modules.split()}
"""Extras of pyproject.toml by the modules that they bring."""


class NotInstalled(MotionLabError, ImportError):
    """A module that is missing because its extra is not installed."""


def needs(module: str) -> str:
    """Return the hint about a missing module: its extra, and how that is installed."""
    extra = EXTRA_OF[module]
    return f'needs the extra {extra}: pip install "motionlab[{extra}]"'


@contextlib.contextmanager
def naming_extras(caller: str) -> Iterator[None]:
    """Name the extra that is missing, in a ``with`` block or as a decorator.

    Raises
    ------
    NotInstalled
        If a module of an extra is missing.
    """
    try:
        yield
    except ModuleNotFoundError as error:
        module = (error.name or "").partition(".")[0]
        if module not in EXTRA_OF:
            raise
        raise NotInstalled(f"{caller} {needs(module)}") from error
