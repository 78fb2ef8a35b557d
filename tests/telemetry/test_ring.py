"""The ring against a plain list that forgets nothing."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from motionlab.telemetry.ring import Ring

COLUMNS, CAPACITY = 3, 16


def append(ring: Ring, columns: np.ndarray) -> None:
    """Add ticks, shape (columns, ticks), in as many pieces as the ring asks for."""
    done = 0
    while done < columns.shape[1]:
        room = ring.room(columns.shape[1] - done)
        count = room.shape[1]
        room[:] = columns[:, done : done + count]
        ring.fill(count)
        done += count


class RingAgainstList(RuleBasedStateMachine):
    """A ring of 16 ticks and the list of every tick since the last clear."""

    def __init__(self):
        super().__init__()
        self.ring = Ring(COLUMNS, CAPACITY)
        self.ticks: list[tuple[float, ...]] = []
        self.next_value = 0.0

    @rule(count=st.integers(0, 3 * CAPACITY))
    def append(self, count):
        new = []
        for _ in range(count):
            new.append(tuple(self.next_value + column / 8 for column in range(COLUMNS)))
            self.next_value += 1.0
        append(self.ring, np.array(new, dtype=np.float32).reshape(count, COLUMNS).T)
        self.ticks += new

    @rule()
    def clear(self):
        self.ring.clear()
        self.ticks = []

    @precondition(lambda self: self.ticks)
    @rule(data=st.data())
    def read_some(self, data):
        first = max(0, len(self.ticks) - CAPACITY)
        start = data.draw(st.integers(first, len(self.ticks)))
        stop = data.draw(st.integers(start, len(self.ticks)))
        columns = data.draw(st.lists(st.integers(0, COLUMNS - 1), max_size=5))
        got = self.ring.read(columns, start, stop)
        assert got.shape == (len(columns), stop - start)
        assert got.dtype == np.float32
        for row, column in zip(got, columns, strict=True):
            assert row.tolist() == [tick[column] for tick in self.ticks[start:stop]]

    @invariant()
    def holds_the_latest(self):
        assert self.ring.end == len(self.ticks)
        assert self.ring.first == max(0, len(self.ticks) - CAPACITY)
        held = self.ring.read(slice(None), self.ring.first, self.ring.end)
        assert held.T.tolist() == [list(tick) for tick in self.ticks[-CAPACITY:]]

    @invariant()
    def refuses_what_it_does_not_hold(self):
        first, end = self.ring.first, self.ring.end
        for start, stop in ((first - 1, first), (end, end + 1), (end, first - 1)):
            with pytest.raises(IndexError, match="ticks"):
                self.ring.read([0], start, stop)


test_ring_against_a_list = RingAgainstList.TestCase


@pytest.mark.parametrize("columns", [[0], slice(None)])
def test_what_was_read_is_not_overwritten(columns):
    ring = Ring(1, 4)
    append(ring, np.arange(4, dtype=np.float32)[None])
    before = ring.read(columns, 0, 4)
    append(ring, np.full((1, 4), 9, dtype=np.float32))
    assert before.tolist() == [[0, 1, 2, 3]]


def test_a_tick_overwritten_while_it_is_read_is_refused(monkeypatch):
    ring = Ring(1, 4)
    append(ring, np.arange(4, dtype=np.float32)[None])
    copy = Ring._copy

    def overtaken(self, columns, start, stop):
        room = self.room(2)
        assert self.first == 2  # given up before it is overwritten
        room[:] = 9
        return copy(self, columns, start, stop)

    monkeypatch.setattr(Ring, "_copy", overtaken)
    with pytest.raises(IndexError, match="ticks 0 to 4 of 2 to 4"):
        ring.read([0], 0, 4)


@given(pieces=st.lists(st.integers(0, 40), max_size=6))
def test_memory_does_not_grow(pieces):
    ring = Ring(2, 8)
    size = ring._data.nbytes
    for count in pieces:
        append(ring, np.zeros((2, count), dtype=np.float32))
    assert ring._data.nbytes == size
    assert ring.end - ring.first <= 8
