"""Size limits of parsed input, checked in linear time."""

from __future__ import annotations

import re
from typing import Any

from motionlab.errors import ConfigError, FieldError

TEXT_MAX = 256_000
"""Largest TOML text of a remote caller, bytes."""

FILE_MAX = 4_000_000
"""Largest TOML file, bytes."""

KEYS_MAX = 5000
"""Keys and tables of a TOML text; the largest scenario has some hundreds."""

DEPTH_MAX = 16
"""Tables and lists inside one another, and parts of a dotted key; a scenario has 8."""

# Strings first: what looks like a comment or a key inside a string is not. Each token is matched
# once, without backtracking, so that parsing takes linear time. Atomic groups, because possessive
# repeats of a group miss matches in Python 3.11.2, which Debian 12 has.
TOKEN = re.compile(
    r'"""(?>(?:[^"\\]+|\\(?:.|\Z)|"(?!""))*)(?>"{3,5}|\Z)'
    r"|'''(?>(?:[^']+|'(?!''))*)(?>'{3,5}|\Z)"
    r'|"(?>(?:[^"\\\n]+|\\[^\n])*)"?'
    r"|'(?>[^'\n]*)'?"
    r"|\#(?>[^\n]*)"
    r"|[\[\]{}.,=\n]",
    re.DOTALL,
)

_HALF = re.compile("[\ud800-\udfff]")
_ENDS_A_KEY = frozenset("[]{},=\n")


def check_toml(text: str, *, loc: str) -> None:
    """Refuse a TOML text that takes long to parse: the parser's time is quadratic in nested keys.

    Raises
    ------
    ConfigError
        If it has too many keys, too long dotted keys or too deep brackets, naming `loc`.
    """
    keys = parts = depth = 0
    at_start = True
    for match in TOKEN.finditer(text):
        token = match[0]
        match token:
            case "[" | "{":
                keys += at_start
                depth += 1
            case "]" | "}":
                depth -= 1
            case "=":
                keys += 1
            case ".":
                parts += 1
        if token in _ENDS_A_KEY:
            parts = 0
        at_start = token == "\n"
        if keys > KEYS_MAX:
            raise ConfigError(
                FieldError(loc, "has too many keys and tables", bounds={"maximum": KEYS_MAX})
            )
        if depth > DEPTH_MAX or parts >= DEPTH_MAX:
            raise _too_deep(loc)


def check_depth(value: Any, *, loc: str) -> None:
    """Refuse tables and lists that are nested too deeply.

    Raises
    ------
    ConfigError
        If so, naming `loc`.
    """
    level = [value] if isinstance(value, dict | list) else []
    for _ in range(DEPTH_MAX):
        items = (each.values() if isinstance(each, dict) else each for each in level)
        level = [item for some in items for item in some if isinstance(item, dict | list)]
        if not level:
            return
    raise _too_deep(loc)


def check_text(value: Any, *, loc: str) -> None:
    """Refuse text that no file, message or database can hold: half of a surrogate pair.

    Raises
    ------
    ConfigError
        If any text or key in the value has one, naming where.
    """
    if isinstance(value, str):
        if not value.isascii() and (half := _HALF.search(value)):
            message = f"holds half of a surrogate pair, U+{ord(half[0]):04X}, which is no character"
            raise ConfigError(FieldError(loc, message, value))
    elif isinstance(value, dict):
        for key, item in value.items():
            check_text(key, loc=loc)
            check_text(item, loc=f"{loc}.{key}")
    elif isinstance(value, list | tuple):
        for index, item in enumerate(value):
            if isinstance(item, str | dict | list | tuple):
                check_text(item, loc=f"{loc}.{index}")


def text(value: str) -> str:
    """Return text that can be encoded; a validator of pydantic.

    Raises
    ------
    ValueError
        If it holds half of a surrogate pair.
    """
    try:
        check_text(value, loc="text")
    except ConfigError as error:
        raise ValueError(error.errors[0].message) from None
    return value


def _too_deep(loc: str) -> ConfigError:
    return ConfigError(FieldError(loc, "is nested too deeply", range=f"{DEPTH_MAX} levels"))
