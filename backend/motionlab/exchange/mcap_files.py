"""Runs as MCAP: a topic for each group of channels, messages in protobuf, as its page describes.

Messages of a topic have one length, so whole chunks are laid out as arrays of bytes.
"""

from __future__ import annotations

import re
import struct
import zlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import BinaryIO

import numpy as np
import pyarrow as pa
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)
from numpy.typing import NDArray

from motionlab import __version__

MAGIC = b"\x89MCAP0\r\n"
ENCODING = "protobuf"

_CHUNK = 1 << 20  # bytes of a chunk before compression, about
_HEAD = struct.Struct("<BQHIQQ")  # opcode, length, channel, sequence, log and publish time
_AFTER_LENGTH = _HEAD.size - 9
_SEQUENCE, _LOG_TIME, _PUBLISH_TIME = 11, 15, 23  # offsets in a message record
_FLOAT, _OPTIONAL = 2, 1  # of a protobuf field: its type and label
_CHANNEL_NAME = re.compile(r"(?:(?P<variant>[A-Z])\.)?(?P<axis>[xy])\.(?P<field>\w+)")


@dataclass(frozen=True)
class Topic:
    """A group of channels that share their messages.

    Attributes
    ----------
    name : str
        ``/reference/x``, ``/A/x`` and so on; ``/other`` for channels of other names.
    columns : tuple of str
        Names of its channels.
    fields : tuple of str
        Their names in a message, identifiers of protobuf.
    """

    name: str
    columns: tuple[str, ...]
    fields: tuple[str, ...]


@dataclass(frozen=True)
class Extras:
    """What an MCAP file carries beside messages.

    Attributes
    ----------
    metadata : mapping of str to str
        The metadata record ``motionlab``.
    attachments : sequence of (str, str, bytes)
        Name, media type and content of each.
    """

    metadata: Mapping[str, str]
    attachments: Sequence[tuple[str, str, bytes]] = ()


def topics(columns: Sequence[str]) -> list[Topic]:
    """Return the topics of some channels, in the order of their first ones."""
    grouped: dict[str, list[tuple[str, str]]] = {}
    for column in columns:
        match = _CHANNEL_NAME.fullmatch(column)
        if match is None:
            grouped.setdefault("/other", []).append((column, column))
        else:
            name = f"/{match['variant'] or 'reference'}/{match['axis']}"
            grouped.setdefault(name, []).append((column, match["field"]))
    return [
        Topic(name, tuple(c for c, _ in members), tuple(identifiers([f for _, f in members])))
        for name, members in grouped.items()
    ]


def identifiers(names: Sequence[str], length_max: int = 63, taken: Iterable[str] = ()) -> list[str]:
    """Return different identifiers of letters, digits and underscores for some names."""
    used, unique_names = set(taken), []
    for name in names:
        plain = re.sub(r"[^A-Za-z0-9_]", "_", name)[:length_max]
        plain = plain if re.match(r"[A-Za-z]", plain) else f"c_{plain}"[:length_max]
        number, unique = 2, plain
        while unique in used:
            unique = f"{plain[: length_max - len(str(number)) - 1]}_{number}"
            number += 1
        used.add(unique)
        unique_names.append(unique)
    return unique_names


def write_mcap(
    stream: BinaryIO,
    batches: Iterable[pa.RecordBatch],
    units: Mapping[str, str],
    created: float,
    extras: Extras,
) -> None:
    """Write samples as MCAP.

    Parameters
    ----------
    stream : binary file
        At its beginning.
    batches : iterable of RecordBatch
        ``tick``, ``time`` and float32 columns, in the order of time.
    units : mapping of str to str
        Unit of every column.
    created : float
        Instant of time 0, seconds since 1970.
    extras : Extras
        Metadata and attachments.
    """
    file_topics = topics(list(units))
    file = _File(stream)
    file.put(Header(profile="", library=f"motionlab {__version__}"))
    for number, topic in enumerate(file_topics, start=1):
        file.register(number, topic, {f: units[c] for c, f in _pairs(topic)})
    epoch = 1000 * round(created * 1e6)  # a double has no more digits
    layout = _Layout(file_topics)
    rows = max(1, _CHUNK // layout.template.size)
    sequence = 0
    for batch in batches:
        for start in range(0, batch.num_rows, rows):
            piece = batch.slice(start, rows)
            times = epoch + np.rint(piece["time"].to_numpy() * 1e9).astype(np.int64)
            file.chunk(layout, layout.records(piece, times, sequence), times)
            sequence += piece.num_rows
    for name, media_type, content in extras.attachments:
        file.attach(name, media_type, content, epoch)
    file.metadata("motionlab", dict(extras.metadata))
    file.finish()


def _pairs(topic: Topic) -> Iterable[tuple[str, str]]:
    return zip(topic.columns, topic.fields, strict=True)


class _Layout:
    """Where everything lies in the message records of one tick, all topics one after another."""

    def __init__(self, topics: Sequence[Topic]) -> None:
        template, self.starts = b"", []
        self.places: dict[str, int] = {}
        for number, topic in enumerate(topics, start=1):
            self.starts.append(len(template))
            fields = b""
            for index, column in enumerate(topic.columns, start=1):
                fields += _varint(index << 3 | 5)  # wire type 5: four bytes
                self.places[column] = len(template) + _HEAD.size + len(fields)
                fields += bytes(4)
            length = _AFTER_LENGTH + len(fields)
            template += _HEAD.pack(Opcode.MESSAGE, length, number, 0, 0, 0) + fields
        self.template = np.frombuffer(template, dtype=np.uint8)

    def records(
        self, batch: pa.RecordBatch, times: NDArray[np.int64], sequence: int
    ) -> NDArray[np.uint8]:
        """Return the records of some ticks, shape (ticks, bytes)."""
        block = np.tile(self.template, (batch.num_rows, 1))
        counts = np.arange(sequence, sequence + batch.num_rows).astype("<u4")
        for start in self.starts:
            _fill(block, start + _SEQUENCE, counts)
            _fill(block, start + _LOG_TIME, times.astype("<u8"))
            _fill(block, start + _PUBLISH_TIME, times.astype("<u8"))
        for column, place in self.places.items():
            _fill(block, place, batch[column].to_numpy(zero_copy_only=False).astype("<f4"))
        return block


def _fill(block: NDArray[np.uint8], place: int, values: NDArray[np.generic]) -> None:
    size = values.dtype.itemsize
    block[:, place : place + size] = np.ascontiguousarray(values).view(np.uint8).reshape(-1, size)


class _File:
    """Writes records, and the summary of them at the end."""

    def __init__(self, stream: BinaryIO) -> None:
        self._stream = stream
        self._offset = 0
        self._codec = pa.Codec("zstd", 3)
        self._schemas: list[McapRecord] = []
        self._channels: list[McapRecord] = []
        self._chunks: list[McapRecord] = []
        self._attachments: list[McapRecord] = []
        self._metadata: list[McapRecord] = []
        self._counts: dict[int, int] = {}
        self._times: tuple[int, int] | None = None
        self._write(MAGIC)

    def put(self, record: McapRecord) -> tuple[int, int]:
        """Write a record; return its offset and length."""
        start = self._offset
        self._write(_bytes([record]))
        return start, self._offset - start

    def register(self, number: int, topic: Topic, units: dict[str, str]) -> None:
        """Announce a topic and the schema of its messages."""
        name = "motionlab." + topic.name.strip("/").replace("/", "_")
        schema = Schema(
            id=number, name=name, encoding=ENCODING, data=_descriptor(name, topic.fields)
        )
        channel = Channel(
            id=number,
            topic=topic.name,
            message_encoding=ENCODING,
            metadata={f"unit.{field}": unit for field, unit in units.items()}
            | {f"channel.{field}": column for column, field in _pairs(topic)},
            schema_id=number,
        )
        self.put(schema)
        self.put(channel)
        self._schemas.append(schema)
        self._channels.append(channel)
        self._counts[number] = 0

    def chunk(self, layout: _Layout, records: NDArray[np.uint8], times: NDArray[np.int64]) -> None:
        """Write the messages of some ticks, and where each lies among them."""
        first, last = int(times[0]), int(times[-1])
        content = records.tobytes()
        packed = self._codec.compress(content, asbytes=True)
        start, length = self.put(
            Chunk(
                compression="zstd",
                data=packed,
                message_start_time=first,
                message_end_time=last,
                uncompressed_crc=zlib.crc32(content),
                uncompressed_size=len(content),
            )
        )
        places: dict[int, int] = {}
        rows, width = records.shape
        for number, begin in enumerate(layout.starts, start=1):
            places[number] = self._offset
            entries = np.empty((rows, 2), dtype="<u8")
            entries[:, 0] = times
            entries[:, 1] = begin + width * np.arange(rows)
            head = struct.pack("<BQHI", Opcode.MESSAGE_INDEX, 6 + 16 * rows, number, 16 * rows)
            self._write(head + entries.tobytes())
            self._counts[number] += rows
        self._chunks.append(
            ChunkIndex(
                chunk_length=length,
                chunk_start_offset=start,
                compression="zstd",
                compressed_size=len(packed),
                message_end_time=last,
                message_index_length=self._offset - start - length,
                message_index_offsets=places,
                message_start_time=first,
                uncompressed_size=len(content),
            )
        )
        self._times = (first if self._times is None else self._times[0], last)

    def attach(self, name: str, media_type: str, content: bytes, instant: int) -> None:
        """Attach a file."""
        start, length = self.put(Attachment(instant, instant, name, media_type, content))
        self._attachments.append(
            AttachmentIndex(start, length, instant, instant, len(content), name, media_type)
        )

    def metadata(self, name: str, content: dict[str, str]) -> None:
        """Write a metadata record."""
        start, length = self.put(Metadata(name=name, metadata=content))
        self._metadata.append(MetadataIndex(offset=start, length=length, name=name))

    def finish(self) -> None:
        """Write the summary, by which readers find everything."""
        self.put(DataEnd(data_section_crc=0))
        begun = self._offset
        first, last = self._times or (0, 0)
        statistics = Statistics(
            attachment_count=len(self._attachments),
            channel_count=len(self._channels),
            channel_message_counts=self._counts,
            chunk_count=len(self._chunks),
            message_count=sum(self._counts.values()),
            message_end_time=last,
            message_start_time=first,
            metadata_count=len(self._metadata),
            schema_count=len(self._schemas),
        )
        groups: dict[int, list[McapRecord]] = {
            Opcode.SCHEMA: self._schemas,
            Opcode.CHANNEL: self._channels,
            Opcode.STATISTICS: [statistics],
            Opcode.CHUNK_INDEX: self._chunks,
            Opcode.ATTACHMENT_INDEX: self._attachments,
            Opcode.METADATA_INDEX: self._metadata,
        }
        summary, offsets = b"", []
        for opcode, records in groups.items():
            content = _bytes(records)
            if content:
                offsets.append(SummaryOffset(opcode, begun + len(summary), len(content)))
            summary += content
        offsets_begun = begun + len(summary)
        summary += _bytes(offsets)
        self._write(summary)
        head = struct.pack("<BQQQ", Opcode.FOOTER, 20, begun, offsets_begun)
        self.put(Footer(begun, offsets_begun, zlib.crc32(head, zlib.crc32(summary))))
        self._write(MAGIC)

    def _write(self, content: bytes) -> None:
        self._stream.write(content)
        self._offset += len(content)


def _bytes(records: Iterable[McapRecord]) -> bytes:
    builder = RecordBuilder()
    for record in records:
        record.write(builder)
    return bytes(builder.end())


def _descriptor(name: str, fields: Sequence[str]) -> bytes:
    """Return a FileDescriptorSet of one message of optional floats, numbered from 1."""
    package, _, message = name.rpartition(".")
    described = b"".join(
        _text(2, _text(1, f) + _number(3, i) + _number(4, _OPTIONAL) + _number(5, _FLOAT))
        for i, f in enumerate((field.encode() for field in fields), start=1)
    )
    message_type = _text(1, message.encode()) + described
    file = _text(1, f"{name}.proto".encode()) + _text(2, package.encode())
    return _text(1, file + _text(4, message_type) + _text(12, b"proto3"))


def _text(number: int, content: bytes) -> bytes:
    return _varint(number << 3 | 2) + _varint(len(content)) + content


def _number(number: int, value: int) -> bytes:
    return _varint(number << 3) + _varint(value)


def _varint(value: int) -> bytes:
    """Return a whole number in groups of seven bits, the least significant first."""
    content = bytearray()
    while value > 0x7F:
        content.append(value & 0x7F | 0x80)
        value >>= 7
    content.append(value)
    return bytes(content)
