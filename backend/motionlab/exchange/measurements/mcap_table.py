"""MCAP files of machines as tables: JSON messages, and those that exports write."""

from __future__ import annotations

import io
import json
import math
import struct
from array import array
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import lz4.frame
import numpy as np
import zstandard
from mcap.exceptions import McapError
from mcap.records import Channel, Chunk, McapRecord, Message, Schema
from mcap.stream_reader import StreamReader
from numpy.typing import NDArray

from motionlab.errors import ConfigError, FieldError
from motionlab.exchange.mcap_files import MAGIC
from motionlab.exchange.measurements.document import COLUMNS_MAX

_DEPTH_MAX = 4
_RECORD_MAX = 64 << 20  # bytes of a record, also of a chunk when it is uncompressed
_ELEMENTS_MAX = 64  # of an array that becomes columns
_MESSAGE_MAX = 8 << 20  # bytes of a message that is read as JSON


@dataclass
class McapTable:
    """Columns of an MCAP file: name, unit and values; what is ignored; when it begins."""

    columns: list[tuple[str, str, NDArray[np.float64]]]
    ignored: dict[str, str]
    begun: float
    notes: list[str]
    own: bool


@dataclass
class _Topic:
    """Numbers of the messages of one topic; columns may end before the last message."""

    name: str
    units: dict[str, str]
    own: bool = False
    times: array[int] = field(default_factory=lambda: array("q"))
    columns: dict[str, array[float]] = field(default_factory=dict)

    @property
    def size(self) -> int:
        return len(self.times) * max(1, len(self.columns))

    def add(self, time: int, row: dict[str, float]) -> None:
        for name, value in row.items():
            column = self.columns.setdefault(name, array("d"))
            column.extend([math.nan] * (len(self.times) - len(column)))
            column.append(value)
        self.times.append(time)


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
    cut, own = not _has_end(path), False
    try:
        with path.open("rb") as stream:
            for schema, channel, message in _messages(stream):
                decode = _decoder(channel, schema, ignored)
                if decode is None:
                    ignored[channel.topic] = f"its messages are {channel.message_encoding}"
                    continue
                topic = topics.get(channel.topic)
                if topic is None:
                    own |= _is_own(channel, schema)
                    topic = topics[channel.topic] = _topic(channel, own=_is_own(channel, schema))
                count -= topic.size
                topic.add(message.log_time, decode(message.data))
                count += topic.size
                if count > values_max:
                    raise _refused(f"has more than {values_max} numbers")
                if len(topic.columns) > COLUMNS_MAX or len(topics) > COLUMNS_MAX:
                    raise _refused(f"has more than {COLUMNS_MAX} columns")
    except _UNREADABLE as error:
        # Without its end it was cut off, by a power loss as a rule: what is before holds.
        if not cut:
            why = str(error) or type(error).__name__
            raise _refused(f"is no MCAP file that can be read: {why}") from None
    numeric_topics = [topic for topic in topics.values() if topic.columns]
    if not numeric_topics:
        others = "".join(f"; {topic}: {why}" for topic, why in [*ignored.items()][:5])
        what = "has no message with numbers, in JSON or as exports write them"
        if cut:
            what = "is no MCAP file that can be read: it ends before its first whole chunk"
        raise _refused(f"{what}{others}")
    columns = sum(len(topic.columns) for topic in numeric_topics)
    if columns > COLUMNS_MAX:
        raise _refused(f"has more than {COLUMNS_MAX} columns")
    if columns * max(len(topic.times) for topic in numeric_topics) > values_max:
        raise _refused(f"has more than {values_max} numbers")
    table = _table(numeric_topics, ignored, own=own)
    if cut:
        table.notes.append(
            "the file ends in the middle: the recorder was cut off; messages after the last whole "
            "chunk are lost"
        )
    return table


def _has_end(path: Path) -> bool:
    """Return whether a file has the mark at its end."""
    with path.open("rb") as stream:
        stream.seek(-min(len(MAGIC), path.stat().st_size), 2)
        return stream.read() == MAGIC


def _is_own(channel: Any, schema: Any) -> bool:
    """Return whether an export wrote the messages of a channel."""
    named = schema is not None and schema.name.startswith("motionlab.")
    return channel.message_encoding == "protobuf" and named


def _topic(channel: Any, *, own: bool) -> _Topic:
    """Return a topic; fields that an export wrote have the names of their channels."""
    units = _prefixed(channel.metadata, "unit.")
    names = _prefixed(channel.metadata, "channel.") if own else {}
    return _Topic(channel.topic, {names.get(k, k): unit for k, unit in units.items()}, own)


_UNREADABLE = (
    McapError,
    OSError,
    ValueError,
    EOFError,
    ArithmeticError,  # numbers that float64 or int64 cannot hold
    RuntimeError,  # of lz4; RecursionError of JSON
    struct.error,
    zstandard.ZstdError,
)


def _messages(stream: Any) -> Iterator[tuple[Schema | None, Channel, Message]]:
    """Yield messages in the order of the file, one chunk in memory at a time."""
    schemas: dict[int, Schema] = {}
    channels: dict[int, Channel] = {}
    for record in _records(stream):
        if isinstance(record, Schema):
            schemas[record.id] = record
        elif isinstance(record, Channel):
            channels[record.id] = record
        elif isinstance(record, Message):
            channel = channels.get(record.channel_id)
            if channel is None:
                raise ValueError(f"a message is of channel {record.channel_id}, which there is not")
            yield schemas.get(channel.schema_id), channel, record


def _records(stream: Any) -> Iterator[McapRecord]:
    bounded: Any = _Bounded(stream)
    reader = StreamReader(bounded, emit_chunks=True, record_size_limit=_RECORD_MAX)
    for record in reader.records:
        if isinstance(record, Chunk):
            data = io.BytesIO(content := _uncompressed(record))
            inside = StreamReader(data, skip_magic=True, emit_chunks=True).records
            while data.tell() < len(content):
                yield next(inside)
        else:
            yield record


class _Bounded:
    """A stream that is not asked for more than a record may have, whatever a length in it says."""

    def __init__(self, stream: Any) -> None:
        self._stream = stream

    def read(self, size: int) -> bytes:
        if size > _RECORD_MAX:
            raise ValueError(f"a length of {size} bytes is more than a record may have")
        return self._stream.read(size)


def _uncompressed(chunk: Chunk) -> bytes:
    """Return the records of a chunk; refused if they are large, whatever size it claims."""
    if chunk.compression == "zstd":
        with zstandard.ZstdDecompressor().stream_reader(chunk.data) as reader:
            data = reader.read(_RECORD_MAX + 1)
    elif chunk.compression == "lz4":
        data = lz4.frame.LZ4FrameDecompressor().decompress(chunk.data, max_length=_RECORD_MAX + 1)
    elif not chunk.compression:
        data = chunk.data
    else:
        raise ValueError(f"its compression {chunk.compression} is unknown")
    if len(data) > _RECORD_MAX:
        raise _refused(f"has a chunk of more than {_RECORD_MAX} bytes uncompressed")
    return data


def _table(topics: list[_Topic], ignored: dict[str, str], *, own: bool) -> McapTable:
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
        for name, column in topic.columns.items():
            samples = np.full(len(times), np.nan)
            samples[: len(column)] = column
            values = np.full(len(instants), np.nan)
            values[places[near]] = samples[near]
            full = name if topic.own else _full(topic.name, name)
            columns.append((full, topic.units.get(name, ""), values))
    return McapTable(columns, ignored, first / 1e9, [], own)


def _full(topic: str, name: str) -> str:
    return ".".join([*(part for part in topic.split("/") if part), name])


def _decoder(channel: Any, schema: Any, ignored: dict[str, str]) -> Any:
    if channel.message_encoding == "json":
        return lambda data: _json(data, channel.topic, ignored)
    if _is_own(channel, schema):
        names = list(_prefixed(channel.metadata, "channel.").values())
        return lambda data: _floats(data, names)
    return None


def _json(data: bytes, topic: str, ignored: dict[str, str]) -> dict[str, float]:
    if len(data) > _MESSAGE_MAX:
        raise _refused(f"has a message of more than {_MESSAGE_MAX} bytes")
    unread: dict[str, str] = {}
    numbers = dict(_scalars("", json.loads(data), 0, unread))
    for name, why in unread.items():
        if len(ignored) < COLUMNS_MAX:
            ignored[_full(topic, name)] = why
    return numbers


def _scalars(
    prefix: str, value: Any, depth: int, unread: dict[str, str]
) -> Iterator[tuple[str, float]]:
    """Yield the numbers of a message under their names; elements of arrays by their number."""
    if isinstance(value, int | float):
        number = float(value)
        yield prefix or "value", number if math.isfinite(number) else math.nan
    elif isinstance(value, dict | list):
        items = list(value.items() if isinstance(value, dict) else enumerate(value))
        if depth >= _DEPTH_MAX:
            unread[prefix] = "is nested too deeply"
        elif isinstance(value, list) and len(items) > _ELEMENTS_MAX:
            unread[prefix or "value"] = f"is an array of more than {_ELEMENTS_MAX} values"
        else:
            for key, item in items:
                full = f"{prefix}.{key}" if prefix else str(key)
                yield from _scalars(full, item, depth + 1, unread)
    elif isinstance(value, str):
        unread[prefix or "value"] = "is text"


def _floats(data: bytes, names: list[str]) -> dict[str, float]:
    """Return the fields of a message that an export wrote: a tag and four bytes each."""
    fields, place = {}, 0
    for number, name in enumerate(names, start=1):
        place += 1 if number < 16 else 2
        fields[name] = float(np.frombuffer(data, "<f4", 1, place)[0])
        place += 4
    return fields


def _prefixed(metadata: dict[str, str], prefix: str) -> dict[str, str]:
    return {k.removeprefix(prefix): v for k, v in metadata.items() if k.startswith(prefix)}


def _refused(message: str) -> ConfigError:
    return ConfigError(FieldError("file", message))
