"""MCAP files of machines as tables: JSON messages, and those that exports write."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from mcap.exceptions import McapError
from mcap.reader import make_reader
from numpy.typing import NDArray

from motionlab.errors import ConfigError, FieldError

_DEPTH_MAX = 4


@dataclass
class McapTable:
    """Columns of an MCAP file: name, unit and values; what is ignored; when it begins."""

    columns: list[tuple[str, str, NDArray[np.float64]]]
    ignored: dict[str, str]
    begun: float


@dataclass
class _Topic:
    """Messages of one topic."""

    name: str
    units: dict[str, str]
    times: list[int] = field(default_factory=list)
    rows: list[dict[str, float]] = field(default_factory=list)


def read_mcap(path: Path, values_max: int) -> McapTable:
    """Read the scalars of all messages, on the instants of the topic that has most of them.

    A message of another topic belongs to the nearest of these instants, if it is nearer than half
    the time between two of them.

    Raises
    ------
    ConfigError
        If it cannot be read, or no message has a number.
    """
    topics: dict[str, _Topic] = {}
    ignored: dict[str, str] = {}
    count = 0
    try:
        with path.open("rb") as stream:
            for schema, channel, message in make_reader(stream).iter_messages():
                decode = _decoder(channel, schema)
                if decode is None:
                    ignored[channel.topic] = f"its messages are {channel.message_encoding}"
                    continue
                topic = topics.get(channel.topic)
                if topic is None:
                    units = _prefixed(channel.metadata, "unit.")
                    topic = topics[channel.topic] = _Topic(channel.topic, units)
                row = decode(message.data)
                count += len(row)
                if count > values_max:
                    raise _refused(f"has more than {values_max} numbers")
                topic.times.append(message.log_time)
                topic.rows.append(row)
    except (McapError, OSError, ValueError, EOFError, UnicodeError) as error:
        raise _refused(
            f"is no MCAP file that can be read: {error or type(error).__name__}"
        ) from None
    found = [topic for topic in topics.values() if any(topic.rows)]
    if not found:
        raise _refused("has no message with numbers, in JSON or as exports write them")
    return _table(found, ignored)


def _table(topics: list[_Topic], ignored: dict[str, str]) -> McapTable:
    base = max(topics, key=lambda topic: len(topic.times))
    instants = np.sort(np.array(base.times, dtype=np.int64))
    first = int(instants[0])
    half = float(np.median(np.diff(instants))) / 2 if len(instants) > 1 else 0.0
    columns = [("log_time", "s", (instants - first) / 1e9)]
    for topic in topics:
        times = np.array(topic.times, dtype=np.int64)
        after = np.clip(np.searchsorted(instants, times), 1, max(1, len(instants) - 1))
        after = np.minimum(after, len(instants) - 1)
        before = np.maximum(after - 1, 0)
        nearer = np.abs(times - instants[before]) <= np.abs(instants[after] - times)
        places = np.where(nearer, before, after)
        near = np.abs(times - instants[places]) <= half
        if not near.all():
            ignored[topic.name] = f"{np.count_nonzero(~near)} messages lie between two instants"
        for name in dict.fromkeys(name for row in topic.rows for name in row):
            given = np.array([row.get(name, math.nan) for row in topic.rows])
            values = np.full(len(instants), np.nan)
            values[places[near]] = given[near]
            columns.append((_full(topic.name, name), topic.units.get(name, ""), values))
    return McapTable(columns, ignored, first / 1e9)


def _full(topic: str, name: str) -> str:
    """Return the name of a column; that of an export is its channel's."""
    parts = [part for part in topic.split("/") if part]
    if parts[:1] == ["reference"]:
        parts = parts[1:]
    if parts == ["other"]:
        parts = []
    return ".".join([*parts, name])


def _decoder(channel: Any, schema: Any) -> Any:
    if channel.message_encoding == "json":
        return _json
    own = schema is not None and schema.name.startswith("motionlab.")
    if channel.message_encoding == "protobuf" and own:
        names = list(_prefixed(channel.metadata, "channel."))
        return lambda data: _floats(data, names)
    return None


def _json(data: bytes) -> dict[str, float]:
    return dict(_scalars("", json.loads(data), 0))


def _scalars(prefix: str, value: Any, depth: int) -> Iterator[tuple[str, float]]:
    if isinstance(value, dict) and depth < _DEPTH_MAX:
        for key, item in value.items():
            yield from _scalars(f"{prefix}.{key}" if prefix else key, item, depth + 1)
    elif isinstance(value, int | float) and prefix:
        number = float(value)
        yield prefix, number if math.isfinite(number) else math.nan


def _floats(data: bytes, names: list[str]) -> dict[str, float]:
    """Return the fields of a message that an export wrote: a tag and four bytes each."""
    found, place = {}, 0
    for number, name in enumerate(names, start=1):
        place += 1 if number < 16 else 2
        found[name] = float(np.frombuffer(data, "<f4", 1, place)[0])
        place += 4
    return found


def _prefixed(metadata: dict[str, str], prefix: str) -> dict[str, str]:
    return {k.removeprefix(prefix): v for k, v in metadata.items() if k.startswith(prefix)}


def _refused(message: str) -> ConfigError:
    return ConfigError(FieldError("file", message))
