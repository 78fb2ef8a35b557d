"""Binary frames: the bytes that docs/stream.md describes, and back."""

import itertools
import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from motionlab.telemetry.frames import HEADER_BYTES, Frame, decode, encode
from tests.paths import DOCS, ROOT

FIXTURE = ROOT / "tests" / "fixtures" / "frame.bin"
PAGE = DOCS / "stream.md"

frames = st.builds(
    Frame,
    sequence=st.integers(0, 2**32 - 1),
    first_tick=st.integers(0, 2**64 - 1),
    columns=arrays.arrays(
        np.float32,
        st.tuples(st.integers(0, 8), st.integers(0, 40)),
        elements=st.floats(width=32, allow_subnormal=True),
    ),
)


@given(frame=frames)
def test_decode_undoes_encode(frame):
    data = encode(frame)
    assert len(data) == HEADER_BYTES + frame.columns.nbytes
    back = decode(data)
    assert (back.sequence, back.first_tick) == (frame.sequence, frame.first_tick)
    assert back.columns.shape == frame.columns.shape
    assert back.columns.tobytes() == frame.columns.tobytes()
    assert encode(back) == data


@given(
    columns=arrays.arrays(np.float32, (6, 7), elements=st.floats(width=32)),
    order=st.permutations(range(6)),
)
def test_columns_that_do_not_lie_side_by_side(columns, order):
    frame = Frame(0, 0, columns.T[::-1][:, list(order)])
    assert np.array_equal(decode(encode(frame)).columns, frame.columns, equal_nan=True)


def test_the_fixture_byte_by_byte():
    data = FIXTURE.read_bytes()
    assert len(data) == 24 + 3 * 5 * 4
    assert data[0:4] == b"PSRM"
    assert int.from_bytes(data[4:6], "little") == 1
    assert int.from_bytes(data[6:8], "little") == 3
    assert int.from_bytes(data[8:12], "little") == 4_000_000_000
    assert int.from_bytes(data[12:16], "little") == 5
    assert int.from_bytes(data[16:24], "little") == 2**40 + 12_345
    first, second, third = (struct.unpack_from("<5f", data, 24 + 20 * i) for i in range(3))
    assert first[:4] == (0.0, 0.0, 1.0, -1.5)
    assert np.signbit(first[1])
    assert first[4] == np.float32(0.1)
    assert second[:2] == (np.inf, -np.inf)
    assert np.isnan(second[2])
    assert third[0] == 16777216.0
    assert third[4] == -7.25


def test_the_fixture_is_what_its_command_writes():
    from tests.fixtures.__main__ import example

    data = FIXTURE.read_bytes()
    assert encode(example()) == data
    frame = decode(data)
    assert frame.sequence == 4_000_000_000
    assert frame.first_tick == 2**40 + 12_345
    assert frame.columns.tobytes() == example().columns.tobytes()


def test_the_page_describes_the_header():
    rows = [row.split("|")[1:3] for row in PAGE.read_text().splitlines() if row.startswith("| ")]
    offsets = [(int(a), b.strip()) for a, b in rows if a.strip().isdigit()]
    sizes = {"4 bytes": 4, "uint16": 2, "uint32": 4, "uint64": 8}
    assert [offset for offset, _ in offsets] == [0, 4, 6, 8, 12, 16, HEADER_BYTES]
    for (offset, kind), (following, _) in itertools.pairwise(offsets):
        assert following - offset == sizes[kind]


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"PSRM",
        FIXTURE.read_bytes()[:-1],
        FIXTURE.read_bytes() + b"\0",
        b"PSRX" + FIXTURE.read_bytes()[4:],
        b"PSRM\2\0" + FIXTURE.read_bytes()[6:],
    ],
    ids=["nothing", "no-header", "short", "long", "other-magic", "other-protocol"],
)
def test_what_is_no_frame(data):
    with pytest.raises(ValueError, match=r"bytes|no frame"):
        decode(data)


def test_a_thinned_frame_comes_back_as_it_went() -> None:
    columns = np.arange(12, dtype=np.float32).reshape(3, 4)
    data = encode(Frame(7, 4096, columns, stride=8))
    assert data[4:6] == b"\x02\x00"
    assert data[24:32] == struct.pack("<II", 8, 0)
    frame = decode(data)
    assert (frame.sequence, frame.first_tick, frame.stride, frame.end) == (7, 4096, 8, 4128)
    assert frame.columns.tobytes() == columns.tobytes()
