"""What the columns of a measurement are: channel and unit, from header, unit and range."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motionlab.config.planar import AXES
from motionlab.errors import ConfigError, FieldError
from motionlab.telemetry.channels import CHANNELS, REFERENCES

VARIANT = "M"
"""The variant of a measurement."""

TARGETS = {f"{axis}.{c.name}": c for axis in AXES for c in REFERENCES} | {
    f"{VARIANT}.{axis}.{c.name}": c for axis in AXES for c in CHANNELS
}
"""The channels that a column can become."""

UNITS = {
    "s": {"s": 1.0, "sec": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9},
    "m": {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "nm": 1e-9},
    "m/s": {"m/s": 1.0, "mm/s": 1e-3, "um/s": 1e-6, "mm/min": 1e-3 / 60, "m/min": 1 / 60},
    "m/s^2": {"m/s^2": 1.0, "mm/s^2": 1e-3, "um/s^2": 1e-6},
    "A": {"a": 1.0, "ma": 1e-3},
    "N": {"n": 1.0, "mn": 1e-3, "kn": 1e3},
    "1": {"1": 1.0},
}
"""Units that are understood, in lower case, by SI unit: factors to it."""

_SPELT_OUT = {
    "second": "s",
    "sekunde": "s",
    "sekunden": "s",
    "seconde": "s",
    "millisecond": "ms",
    "msec": "ms",
    "microsecond": "us",
    "usec": "us",
    "nanosecond": "ns",
    "nsec": "ns",
    "meter": "m",
    "metre": "m",
    "millimeter": "mm",
    "millimetre": "mm",
    "micrometer": "um",
    "micrometre": "um",
    "micron": "um",
    "ampere": "a",
    "amp": "a",
    "newton": "n",
}
_SUFFIXES = {"mm_s": "mm/s", "m_s": "m/s", "mmps": "mm/s", "m_s2": "m/s^2", "mm_s2": "mm/s^2"}
_HEADER_MAX = 100
"""Characters of a header in which a unit is looked for: the time is cubic in them."""
_BRACKETS = {"]": "[", ")": "(", "}": "{"}
_SLASH = re.compile(r"(.+?)(?:\s+/\s*|\s+in\s+)(\S+)")
_SCALED = re.compile(r"([-+]?(?:\d{1,40}\.?\d{0,40}|\.\d{1,40})(?:[eE][-+]?\d{1,3})?)\s+(\S.*)")
_REPEATED = re.compile(r"(.*[^ ]) (\([2-9]\d*\)|\(1\d+\))")
"""A header that comes again in a file, as `csv_form` numbers it."""
_OWN = re.compile(r"(?:[A-Z]\.)?([xy])\.(\w+)")
_WORD = re.compile(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])|\d+")
_WORDS = {
    "reference": "reference ref setpoint soll sollwert befehl cmd command commanded demand "
    "demanded target desired des sp set",
    "measured": "measured meas ist istwert actual act encoder enc feedback fb",
    "position": "position pos lage weg displacement",
    "velocity": "velocity vel speed geschwindigkeit v",
    "acceleration": "acceleration accel acc beschleunigung",
    "error": "error err following schleppfehler schleppabstand lag deviation regelabweichung e",
    "current": "current cur strom i",
    "force": "force kraft thrust f",
    "load": "load last disturbance",
    "time": "time times t zeit zeitstempel uhrzeit timestamp timestamps datetime log_time clock "
    "temps horodatage",
}
_KINDS = {word: kind for kind, words in _WORDS.items() for word in words.split()}
_LONGEST_KIND = max(map(len, _KINDS))
_BESIDE = frozenset(
    "axis achse ax fb value wert val signal data daten drive antrieb stage linear motor channel "
    "kanal raw filtered sensor of the von der des mcs acs nc".split()
)
"""Words that change nothing in what a quantity is; any other makes it something else."""
_BESIDE_TIME = frozenset(
    "stamp relative elapsed absolute sample log since start unix epoch".split()
)
_PART = 3  # letters that each part of a compound has at least, such as Sollkraft, Kraftbefehl
_PHASES = {"a": "a", "b": "b", "c": "c", "u": "a", "v": "b", "w": "c", "1": "a", "2": "b", "3": "c"}
_NUMBERED = frozenset("0 1 2 3 4 5 6 7 8 9".split())
GUESSED_AXIS = "no axis in it, so x"
OWN_NAME = "name of a channel"
_QUANTITIES = {
    "m": ("error", "position"),
    "m/s": ("velocity",),
    "m/s^2": ("acceleration",),
    "A": ("current",),
    "N": ("force",),
    "s": ("time",),
}
_LARGEST = {"m": 0.2, "m/s": 5.0, "m/s^2": 200.0, "A": 100.0, "N": 2000.0, "1": float("inf")}
_EPOCH = 9e8, 2.5e9  # s since 1970: from 1998 to 2049
_SINCE_1970 = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
_FASTEST_PERIOD, _SLOWEST_PERIOD = 1e-6, 0.02  # s, of a measurement without unit of time


@dataclass(frozen=True)
class Label:
    """A header taken apart: name and unit; the unit empty where there is none."""

    name: str
    unit: str


def label(header: str, unit: str = "", *, bare: bool = False) -> Label:
    """Return name and unit of a header such as ``x_ist [um]``, ``x (mm)``, ``pos_um``.

    Parameters
    ----------
    header : str
        What the file calls the column.
    unit : str
        The unit that the file gives elsewhere, if any.
    bare : bool
        Whether the header is the name alone.
    """
    if bare:
        return Label(header, unit)
    if numbered := _REPEATED.fullmatch(header):
        first = label(numbered[1], unit)
        return Label(f"{first.name} {numbered[2]}", first.unit)
    # Brackets elsewhere are an index: axis[0].pos.
    name, opening, inner = header.rpartition(_BRACKETS.get(header[-1:], "\0"))
    inner = inner[:-1].strip()
    if opening and name.strip() and not _is_index(name, opening, inner) and unit in {"", inner}:
        return Label(name.rstrip(), inner)
    if unit or len(header) > _HEADER_MAX:
        return Label(header, unit)
    if (match := _SLASH.fullmatch(header)) and si_of(match[2]) is not None:
        return Label(match[1], match[2])
    return _with_suffix(header)


def _with_suffix(header: str) -> Label:
    """Return name and unit of a header such as ``pos_um``."""
    for count in (2, 1):  # x_mm_s before x_s
        name, *parts = header.rsplit("_", count)
        suffix = "_".join(parts).lower()
        if len(parts) == count and name:
            unit = _SUFFIXES.get(suffix) or (suffix if count == 1 and len(suffix) > 1 else "")
            if si_of(unit) is not None and unit != "1":
                return Label(name, unit)
    return Label(header, "")


def _is_index(name: str, opening: str, inner: str) -> bool:
    """Return whether brackets hold a number of a column, as in ``pos(2)``, and no unit.

    ``[1]`` after a blank is dimensionless.
    """
    return inner.isdecimal() and not (inner == "1" and opening == "[" and name.endswith(" "))


def si_of(unit: str) -> tuple[str, float] | None:
    """Return the SI unit of a unit and the factor to it; None for a unit that is unknown."""
    plain = unicodedata.normalize("NFKC", unit).strip().replace("μ", "u").replace("µ", "u")
    plain = re.sub(r"(?<=s)\^?2$", "^2", plain.lower().replace(" ", "").replace("**", "^"))
    plain = _SPELT_OUT.get(plain.removesuffix("s") if len(plain) > 3 else plain, plain)
    for si, factors in UNITS.items():
        if plain in factors:
            return si, factors[plain]
    return None


def scaled(unit: str) -> tuple[str, float] | None:
    """Return what `si_of` does, also of a unit with a factor before it, such as ``35.15 N``."""
    if (match := _SCALED.fullmatch(unit.strip())) is None:
        return si_of(unit)
    si, factor = si_of(match[2]), float(match[1])
    return (si[0], factor * si[1]) if si and factor and np.isfinite(factor) else None


def channel_of(name: str, si: str) -> tuple[str | None, str]:
    """Return the channel that a name and an SI unit suggest, or ``time``, and why.

    Parameters
    ----------
    name : str
        Of `label`.
    si : str
        The SI unit of the column; empty where the file has none.
    """
    if match := _OWN.fullmatch(name):
        for target in (name, f"{VARIANT}.{match[1]}.{match[2]}"):
            if target in TARGETS:
                return target, OWN_NAME
    *prefixes, leaf = name.split(".")  # of a topic or structure: only an axis counts
    words = _words(leaf)
    kinds = {_KINDS[word] for word in words if word in _KINDS}
    if "time" in kinds and si in {"", "s"} and _only(words, _BESIDE_TIME, "time"):
        return "time", "name"
    above = [word for prefix in prefixes for word in _words(prefix)]
    axis = next((word for word in [*words, *reversed(above)] if word in AXES), None)
    unknown = not set(above) <= _BESIDE | _NUMBERED
    several = "current" not in kinds and any(map(str.isdecimal, words))  # and no phase
    if not _only(words, _BESIDE) or (axis is None and (unknown or several)):
        return None, ""
    allowed = _QUANTITIES.get(si, ()) if si else tuple(q for v in _QUANTITIES.values() for q in v)
    quantities = [quantity for quantity in allowed if quantity in kinds]
    if not quantities and si == "m" and "reference" in kinds and set(words) <= {*AXES, *_KINDS}:
        quantities = ["position"]  # setpoint in mm
    quantity = quantities[0] if quantities else (allowed[-1] if si and allowed else None)
    if quantity is None and axis in words and set(words) <= {axis, *_KINDS} and not si:
        quantity = "position"  # x, x_ist
    if quantity is None or (axis is None and not quantities):
        return None, ""
    if quantity == "time":
        return "time", "unit"
    target = _target(quantity, axis or "x", kinds, words)
    why = "name" if quantities else "axis and unit" if si else "name of the axis"
    return target, why if axis else f"{why}; {GUESSED_AXIS}"


def _only(words: Sequence[str], beside: frozenset[str], kind: str = "") -> bool:
    """Return whether all words are known, of a kind where one is named, or mean nothing.

    A single letter counts only where the other words are an axis or a phase: ``T_motor`` is no
    time, ``V_bat`` no velocity.
    """
    letters = any(len(w) == 1 and w in _KINDS for w in words)
    for word in words:
        if word in beside and not letters:
            continue
        if word in AXES or word in _PHASES or word.isdecimal():
            if not kind:
                continue
        elif word in _KINDS and kind in {"", _KINDS[word]}:
            continue
        return False
    return True


def _target(quantity: str, axis: str, kinds: set[str], words: Sequence[str]) -> str | None:
    reference = "reference" in kinds
    own = f"{VARIANT}.{axis}."
    match quantity:
        case "position" | "velocity":
            return f"{axis}.{quantity}_reference" if reference else f"{own}{quantity}_measured"
        case "acceleration":
            return f"{axis}.acceleration_reference" if reference else f"{own}acceleration"
        case "error":
            return f"{own}following_error"
        case "force" if "load" in kinds:
            return f"{axis}.load_force"
        case "force":
            return f"{own}{'force_command' if reference else 'thrust'}"
        case _:
            phase = next((_PHASES[word] for word in reversed(words) if word in _PHASES), None)
            command = "command_" if reference else ""
            return None if phase is None else f"{own}current_{command}{phase}"


def _words(name: str) -> list[str]:
    plain = unicodedata.normalize("NFKD", name).encode("ascii", "ignore").decode()
    if plain.lower() in _KINDS:
        return [plain.lower()]
    words: list[str] = []
    for word in (part.lower() for part in _WORD.findall(plain)):
        current = re.fullmatch(r"i([abcuvw123])", word)
        joined = re.fullmatch(r"([xy])(soll|ist|ref|act|pos|err|cmd)", word)
        if joined:
            words += [joined[1], joined[2]]
        elif current:
            words += ["i", current[1]]
        else:
            words += _parts(word)
    return words


def _parts(word: str) -> list[str]:
    """Return the two known words that a compound is made of, or the word."""
    if word not in _KINDS and len(word) <= 2 * _LONGEST_KIND:  # slices of longer ones cost squares
        for at in range(_PART, len(word) - _PART + 1):
            if word[:at] in _KINDS and word[at:] in _KINDS:
                return [word[:at], word[at:]]
    return [word]


def unit_by_range(si: str, largest: float) -> str:
    """Return the unit in which values of a quantity are plausible, the largest such.

    Parameters
    ----------
    si : str
        SI unit of the quantity.
    largest : float
        Largest magnitude in the file.
    """
    for unit, factor in sorted(UNITS[si].items(), key=lambda item: -item[1]):
        if unit in {"cm", "mm/min", "m/min", "kn"}:
            continue
        if factor * largest <= _LARGEST[si]:
            return spelt(unit)
    return si


def unit_of_time(times: NDArray[np.float64]) -> tuple[str, str]:
    """Return the unit that times without one are most likely in, and why.

    Instants since 1970 are known by their size. Decimals speak for seconds; whole numbers are taken
    for the unit in which the time between two samples is plausible.
    """
    finite = times[np.isfinite(times)]
    first = float(finite[0]) if finite.size else 0.0
    for unit, factor in _SINCE_1970.items():
        if _EPOCH[0] <= factor * first <= _EPOCH[1]:
            return unit, "instants since 1970"
    if (finite != np.rint(finite)).any():
        return "s", "decimals speak for s"
    steps = np.diff(finite)
    positive = steps[steps > 0]
    step = float(np.median(positive)) if positive.size else 1.0
    for unit in ("s", "ms", "us", "ns"):
        if _FASTEST_PERIOD <= UNITS["s"][unit] * step <= _SLOWEST_PERIOD:
            return unit, "unit from range"
    return "s", "unit from range"


def instant_of(time: float, unit: str) -> float | None:
    """Return the instant that a time is, seconds since 1970; None if it is none."""
    instant = time * UNITS["s"].get(unit, 0.0)
    return instant if _EPOCH[0] <= instant <= _EPOCH[1] else None


def spelt(unit: str) -> str:
    """Return a unit of `UNITS` as people write it."""
    return {"a": "A", "ma": "mA", "n": "N", "mn": "mN", "kn": "kN"}.get(unit, unit)


@dataclass(frozen=True)
class Mapping:
    """What a user says of a column: ``COLUMN=CHANNEL[UNIT]``.

    Attributes
    ----------
    column : str
        Header in the file, or its name without the unit.
    channel : str
        A channel, ``time``, nothing for a column that keeps its own name, ``-`` for one left out.
    unit : str
        With a factor before it or without; empty for the unit that the file gives or the range
        suggests.
    """

    column: str
    channel: str
    unit: str


_MAP = re.compile(r"(?P<column>.+)=(?P<channel>[^=\[\]]*)(?:\[(?P<unit>[^\[\]]*)\])?", re.DOTALL)


def parse_mapping(texts: Sequence[str], loc: str = "map") -> list[Mapping]:
    """Return what a user says of columns.

    Raises
    ------
    ConfigError
        If a text has another form, or names a channel or a unit that is unknown.
    """
    mappings, wrong = [], []
    for index, text in enumerate(texts):
        where = f"{loc}.{index}"
        match = _MAP.fullmatch(text)
        if match is None:
            wrong.append(FieldError(where, "is no mapping", text, "COLUMN=CHANNEL[UNIT]"))
            continue
        channel, unit = match["channel"].strip(), (match["unit"] or "").strip()
        if channel not in {"", "-", "time"} and channel not in TARGETS:
            allowed = "time, -, nothing, x.position_reference, M.x.position_measured, ..."
            wrong.append(FieldError(where, "no channel of that name", text, allowed))
        elif unit and channel not in {"", "-"}:
            expected = "s" if channel == "time" else TARGETS[channel].unit
            si = scaled(unit)
            if si is None or si[0] != expected:
                units = ", ".join(map(spelt, UNITS[expected]))
                allowed = f"{units}; or a factor and one of them, [35.15 {spelt(expected)}]"
                wrong.append(FieldError(where, "is no unit of that channel", text, allowed))
        mappings.append(Mapping(match["column"].strip(), channel, unit))
    if wrong:
        raise ConfigError(*wrong)
    return mappings
