"""Garbage is collected in small parts beside motion, and as a whole at rest."""

from __future__ import annotations

import gc
import weakref
from collections.abc import Iterator

import pytest

from motionlab.server import garbage_collection
from motionlab.server.garbage_collection import GarbageCollection


class Node:
    """An object that refers to itself: only the collector finds that it is garbage."""

    def __init__(self) -> None:
        self.itself = self


class Process:
    """What a collection knows of its process."""

    def __init__(self) -> None:
        self.moving = False
        self.held = 0


@pytest.fixture
def process() -> Process:
    return Process()


@pytest.fixture
def garbage(process: Process) -> Iterator[GarbageCollection]:
    collection = GarbageCollection(lambda: process.moving, lambda: process.held)
    collection.begin()
    yield collection
    collection.end()


@pytest.fixture
def frozen(garbage: GarbageCollection) -> weakref.ref[Node]:
    """Return an object that became garbage after it had survived a full collection."""
    node = Node()
    gc.collect()
    return weakref.ref(node)


def test_no_collection_goes_through_what_survived_one(garbage: GarbageCollection) -> None:
    kept = [Node() for _ in range(1000)]
    gc.collect()
    assert gc.get_count()[2] == 0
    assert gc.get_freeze_count() > len(kept)
    assert not [each for each in gc.get_objects(2) if isinstance(each, Node)]


def test_nothing_is_frozen_once_it_has_ended(process: Process) -> None:
    before = gc.get_threshold()
    collection = GarbageCollection(lambda: process.moving, lambda: process.held)
    collection.begin()
    collection.end()
    gc.collect()
    assert gc.get_threshold() == before
    assert gc.get_freeze_count() == 0


def test_garbage_that_was_frozen_goes_at_rest(
    garbage: GarbageCollection,
    process: Process,
    frozen: weakref.ref[Node],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(garbage_collection, "_WORTH", 1)
    gc.collect()
    process.moving = True
    garbage.look(1000.0)
    process.moving = False
    garbage.look(1001.0)  # who has just stopped may go on
    assert frozen() is not None
    garbage.look(1003.0)
    assert frozen() is None


def test_a_sweep_is_made_only_where_it_is_worth_it(
    garbage: GarbageCollection, frozen: weakref.ref[Node]
) -> None:
    garbage.look(float("inf"))
    assert frozen() is not None


def test_a_process_that_grows_does_not_wait_for_rest(
    garbage: GarbageCollection,
    process: Process,
    frozen: weakref.ref[Node],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    process.moving = True
    resident = garbage_collection._resident()
    monkeypatch.setattr(
        garbage_collection,
        "_resident",
        lambda: resident + 3 * garbage_collection.GROWTH_MAX,
    )
    process.held = 3 * garbage_collection.GROWTH_MAX  # of sessions
    garbage.look(0.0)
    assert frozen() is not None
    process.held = 0
    garbage.look(0.0)
    assert frozen() is None
