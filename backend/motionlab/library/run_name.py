"""Names of runs: scenario or path, and what differs from what ships."""

from __future__ import annotations

import functools
import re
from collections.abc import Collection, Iterator, Sequence
from itertools import product
from typing import NamedTuple

from motionlab.config.fields import FieldEntry, fields_of
from motionlab.config.planar import AXES
from motionlab.config.scenario import Scenario
from motionlab.laws import REDECLARED
from motionlab.library.run import NAME_MAX, Difference, Run

LISTED = 2
"""Differences that a name has."""
PATH = "trajectory"
"""Path of a difference whose values name two trajectories."""

_VARIANT = re.compile(r"^variants\.([A-Z])(?=\.|$)")
_AXIS = re.compile(r"\.([xy])(?=\.|$)")
_TEXT_MAX = 40  # characters of a text that is a value
_BARE = re.compile(r"\.(law|name)$")  # the value says it alone


class _Change(NamedTuple):
    """A difference, apart from whose it is."""

    variant: str
    axis: str
    difference: Difference


def run_name(run: Run) -> str:
    """Return the name of a run that has no name of its own: circle, B k_p 400 N/mm and 3 more."""
    path = next((each.value for each in run.differences if each.path == PATH), None)
    head = str(path or run.scenario)
    differences = [
        each for each in run.differences if each.path != PATH and not each.path.endswith(".label")
    ]
    if run.drive:
        head += f" {' '.join(run.variants)} on {run.drive}"
        differences = [each for each in differences if not _is_of_drives(each)]
    phrases = list(_phrases(differences, run.variants))
    name = ", ".join([head, *phrases[:LISTED]])
    if len(phrases) > LISTED:
        name += f" and {len(phrases) - LISTED} more"
    if run.stopped_at is not None:
        what = "stopped" if run.stopped == "STOP" else "fault"
        name += f", {what} at {run.stopped_at:.1f} s"
    return name[:NAME_MAX]


def rank(difference: Difference) -> int:
    """Return the place of a difference among others: what tells runs apart comes first."""
    path = difference.path
    if path == PATH:
        return 0
    if _VARIANT.match(path):
        if path.count(".") == 1:
            return 1
        return 6 if path.endswith(".delay") else 2 if _BARE.search(path) else 3
    return 4 if path.startswith(("plant", "load", PATH)) else 5


def _is_of_drives(difference: Difference) -> bool:
    """Return whether a motion on drives always differs so: one variant, one period later."""
    _, _, rest = difference.path.partition(".")
    return difference.path.startswith("variants.") and ("." not in rest or rest.endswith(".delay"))


def _phrases(differences: Sequence[Difference], variants: Collection[str]) -> Iterator[str]:
    whole = [each for each in differences if _VARIANT.fullmatch(each.path)]
    if left_out := [each.path[-1] for each in whole if each.value is None]:
        yield f"{' '.join(variants)} alone" if len(variants) == 1 else f"no {' '.join(left_out)}"
    if added := [each.path[-1] for each in whole if each.value is not None]:
        yield f"{' '.join(added)} added"
    groups: dict[str, list[_Change]] = {}
    for each in differences:
        if each in whole:
            continue
        variant, axis = (_first(form, each.path) for form in (_VARIANT, _AXIS))
        key = _AXIS.sub(".*", _VARIANT.sub("variants.*", each.path))
        groups.setdefault(key, []).append(_Change(variant, axis, each))
    for changes in groups.values():
        yield from _shortest(changes, variants)


def _first(form: re.Pattern[str], path: str) -> str:
    match = form.search(path)
    return match[1] if match else ""


def _shortest(changes: list[_Change], variants: Collection[str]) -> Iterator[str]:
    """Yield what was set: for all variants and axes at once where that is the same, else each."""
    letters = variants if changes[0].variant else [""]
    axes = AXES if changes[0].axis else [""]
    splits = (
        ([("", "")], letters, axes),
        ([(letter, "") for letter in letters], [""], axes),
        ([("", axis) for axis in axes], letters, [""]),
    )
    for owners, others, of_axes in splits:
        texts = []
        for letter, axis in owners:
            part = [c for c in changes if letter in {"", c.variant} and axis in {"", c.axis}]
            whole = {(letter or each, axis or of) for each, of in product(others, of_axes)}
            if part and {(c.variant, c.axis) for c in part} == whole:
                texts.append(_same(letter, axis, [c.difference for c in part]))
            elif part:
                texts.append(None)
        if None not in texts:
            yield from (text for text in texts if text)
            return
    yield from (_text(c.variant, c.axis, c.difference, _value(c.difference)) for c in changes)


def _same(variant: str, axis: str, differences: Sequence[Difference]) -> str | None:
    """Return what was done alike with all of them: the same value or the same factor."""
    values, ratios = ({of(each) for each in differences} for of in (_value, _ratio))
    if len(values) == 1:
        return _text(variant, axis, differences[0], values.pop())
    if len(ratios) == 1 and "" not in ratios:
        return _text(variant, axis, differences[0], f"\N{MULTIPLICATION SIGN} {ratios.pop()}")
    return None


def _ratio(difference: Difference) -> str:
    numbers = (difference.shipped, difference.value)
    if any(isinstance(each, bool) or not isinstance(each, int | float) for each in numbers):
        return ""
    return f"{difference.value / difference.shipped:.3g}" if difference.shipped else ""


def _text(variant: str, axis: str, difference: Difference, value: str) -> str:
    path = difference.path
    label = "" if _BARE.search(path) else _label(path, axis)
    owner = "plant" if path.startswith("plant.") else variant
    return " ".join(filter(None, (owner, label, axis, value)))


def one_line(text: str, most: int) -> str:
    """Return a text as one line of printable characters, `most` of them at most."""
    printable = "".join(letter if letter.isprintable() else " " for letter in text)
    return " ".join(printable.split())[:most].rstrip()


def _label(path: str, axis: str) -> str:
    entry = _entry(path)
    if entry is None:
        return " ".join(path.split(".")[-2:]).replace("_", " ")
    words = entry.label.split()
    if words[-1] in AXES:
        words.pop()
    if path == "load.steps":
        words = ["load", *words]
    return words[-1] if "_" in words[-1] or not words[:-1] else " ".join(words)


def _value(difference: Difference) -> str:
    value, entry = difference.value, _entry(difference.path)
    match value:
        case None:
            return "none"
        case bool():
            return "on" if value else "off"
        case int() | float():
            factor, unit = (1.0, "") if entry is None else (entry.factor, entry.unit)
            return f"{value * factor:.4g} {unit}".rstrip().replace("-", "\N{MINUS SIGN}")
        case str() if not value.startswith(("[", "{", "(")):
            choices = (entry.choices if entry else None) or ()
            label = next((each.label for each in choices if each.value == value), None)
            return label or one_line(value, _TEXT_MAX) or "changed"
        case _:
            return "changed"


def _entry(path: str) -> FieldEntry | None:
    return _fields().get(re.sub(r"\.\d+(?=\.|$)", ".*", _VARIANT.sub("variants.*", path)))


@functools.cache
def _fields() -> dict[str, FieldEntry]:
    return fields_of(Scenario)


REDECLARED.append(_fields.cache_clear)
