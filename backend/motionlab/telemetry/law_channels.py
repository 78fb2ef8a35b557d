"""Channels of laws of one's own: a column for each number of their state, named after its field."""

from __future__ import annotations

import functools
import re
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

from motionlab.config.planar import AXES
from motionlab.config.units import parse_unit
from motionlab.declarations import field_comments
from motionlab.laws import OWN, Law
from motionlab.telemetry.channels import Channel, Owner, stream_columns
from motionlab.telemetry.recording import LAW_PREFIX

MOST = 16
"""Channels of laws of one's own in a live session, which may change to any of them."""


class StateColumn(NamedTuple):
    """A column of a number of a law's state."""

    name: str  # B.x.law_w
    channel: Channel
    variant: str
    axis: int
    rows: Mapping[str, int]  # row of the state of each law that has it


def state_columns(laws: Mapping[str, Iterable[str]], most: int | None = MOST) -> list[StateColumn]:
    """Return the columns of the states of laws of one's own.

    They come after those of `stream_columns`, as ``B.x.law_w``; there is NaN where another law is
    in effect.

    Parameters
    ----------
    laws : mapping of str to iterable of str
        Of each variant the laws that it has, one after another.
    most : int or None
        Channels of an axis at most.
    """
    columns: list[StateColumn] = []
    for variant, names in laws.items():
        channels: dict[str, Channel] = {}
        rows: dict[str, dict[str, int]] = {}
        for law in names:
            for row, channel in enumerate(_channels().get(law, ())):
                channels.setdefault(channel.name, channel)
                rows.setdefault(channel.name, {})[law] = row
        for axis, axis_name in enumerate(AXES):
            columns += [
                StateColumn(f"{variant}.{axis_name}.{name}", channel, variant, axis, rows[name])
                for name, channel in list(channels.items())[:most]
            ]
    return columns


def all_columns(laws: Mapping[str, Iterable[str]]) -> list[tuple[str, Channel]]:
    """Return name and channel of every column of variants, which have some laws."""
    return stream_columns(laws) + [(each.name, each.channel) for each in state_columns(laws)]


def kept_states(columns: Iterable[Mapping[str, str]]) -> list[tuple[str, Channel]]:
    """Return which of the columns of a kept run are states of laws, wherever those are now."""
    named = ((each, each["name"].rpartition(".")[2]) for each in columns)
    return [
        (each["name"], Channel(name, each["unit"], each["meaning"], Owner.CONTROLLER))
        for each, name in named
        if name.startswith(LAW_PREFIX)
    ]


def laws_of_variants(epochs: Iterable[tuple[int, Any]]) -> dict[str, list[str]]:
    """Return of each variant the laws that it has, of parameter sets over time."""
    laws: dict[str, dict[str, None]] = {}
    for _, scenario in epochs:
        for name, variant in scenario.variants.items():
            laws.setdefault(name, {})[variant.controller.compensation.law] = None
    return {name: list(each) for name, each in laws.items()}


def any_law(variants: Iterable[str]) -> dict[str, list[str]]:
    """Return that each variant may have any law of one's own."""
    return {variant: list(OWN) for variant in variants}


def _channels() -> dict[str, tuple[Channel, ...]]:
    """Return the channels of each law of one's own, in the order of its state."""
    units: dict[str, str] = {}
    return {name: tuple(_of_law(law, units)) for name, law in OWN.items()}


def _of_law(law: Law, units: dict[str, str]) -> Iterable[Channel]:
    for field, (meaning, unit) in _described(law.State).items():
        # Laws share a channel of one name and unit; with another unit it is another channel.
        name = LAW_PREFIX + field
        if units.setdefault(name, unit) != unit:
            name += "_" + re.sub(r"\W", "_", law.name)
        yield Channel(name, unit, meaning or f"{field} of the law's state", Owner.CONTROLLER)


@functools.cache
def _described(state: Any) -> dict[str, tuple[str, str]]:
    """Return meaning and unit of each field of a state, of the comment beside it."""
    try:
        comments = field_comments(state)
    except (OSError, TypeError, SyntaxError, AssertionError):  # no text declares it
        comments = {}
    return {field: _parted(comments.get(field, "")) for field in state._fields}


def _parted(comment: str) -> tuple[str, str]:
    """Return what is before the last comma, and the unit after it; 1 if it is none."""
    meaning, comma, unit = comment.rpartition(", ")
    if parse_unit(unit, strict=True) is not None:
        return meaning, unit.strip() or "1"
    return (meaning + comma + unit).strip(), "1"
