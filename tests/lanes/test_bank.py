"""The bank of tables: bounded, and nothing goes that is in use."""

from __future__ import annotations

import gc
import threading

import numpy as np
import pytest

from motionlab.config.load import load_scenario
from motionlab.errors import StoreError
from motionlab.force_sharing import pole_pitch
from motionlab.kernel import build, force_maps
from motionlab.lanes.bank import Bank

SIZE = 100
MODEL = "variants.A.controller.model"


def numbers(value: float) -> np.ndarray:
    return np.full(SIZE, value)


@pytest.fixture
def three() -> Bank:
    """Return a bank with room for three tables."""
    return Bank(64 + 3 * SIZE)


def holds(tables: Bank, place: int, value: float) -> bool:
    return bool((tables.values[place : place + SIZE] == value).all())


def test_the_least_recently_used_goes(three: Bank) -> None:
    with three.lease():
        places = {key: three.place(key, lambda k=key: numbers(k)) for key in (1, 2, 3)}
    with three.lease():
        assert three.place(1, lambda: numbers(-1)) == places[1]
    with three.lease():
        assert three.place(4, lambda: numbers(4)) == places[2]
        assert holds(three, places[1], 1)
        assert holds(three, places[2], 4)


def test_what_is_held_stays(three: Bank) -> None:
    with three.lease() as lease:
        held = three.place(1, lambda: numbers(1))
    for key in range(2, 20):
        with three.lease():
            three.place(key, lambda: numbers(9))
    assert holds(three, held, 1)
    assert three.place(1, lambda: numbers(-1)) == held
    del lease


def test_what_everyone_holds_leaves_no_room(three: Bank) -> None:
    with three.lease() as first, three.lease():
        for key in (1, 2, 3):
            three.place(key, lambda: numbers(1))
        with pytest.raises(StoreError, match="those in use take 300 of 364"):
            three.place(4, lambda: numbers(4))
    three.place(4, lambda: numbers(4))
    del first


def test_what_no_lease_holds_was_placed_for_good(three: Bank) -> None:
    kept = three.place(1, lambda: numbers(1))
    for key in range(2, 20):
        with three.lease():
            three.place(key, lambda: numbers(9))
    assert holds(three, kept, 1)


def test_a_lease_ends_with_its_owner(three: Bank) -> None:
    owner = np.zeros(1)
    with three.lease() as lease:
        place = three.place(1, lambda: numbers(1))
        lease.keep_with(owner)
    del lease
    for key in (2, 3, 4):
        with three.lease():
            three.place(key, lambda: numbers(9))
    assert holds(three, place, 1)
    del owner
    gc.collect()
    for key in (2, 3, 4):
        with three.lease():
            three.place(key, lambda: numbers(9))
    assert not holds(three, place, 1)


def test_larger_tables_take_the_place_of_several(three: Bank) -> None:
    for key in (1, 2, 3):
        with three.lease():
            three.place(key, lambda: numbers(1))
    with three.lease():
        place = three.place("large", lambda: np.full(2 * SIZE + 1, 5.0))
        assert (three.values[place : place + 2 * SIZE + 1] == 5.0).all()


def test_a_table_is_made_while_others_find_theirs(three: Bank) -> None:
    three.place(1, lambda: numbers(1))
    found = threading.Event()

    def make() -> np.ndarray:
        thread = threading.Thread(target=lambda: (three.place(1, make), found.set()))
        thread.start()
        assert found.wait(60)
        return numbers(2)

    assert holds(three, three.place(2, make), 2)


def test_what_refers_to_tables_holds_them(monkeypatch: pytest.MonkeyPatch) -> None:
    """A running simulation finds its tables, whatever else is placed meanwhile."""
    tables = Bank()
    for module in (build, force_maps, pole_pitch):
        monkeypatch.setattr(module, "TABLES", tables)
    changes = {f"{where}.force_map": "new-design" for where in ("plant", MODEL)}
    scenario = load_scenario("circle", changes)
    owner: object = build.lane_parameters(scenario)
    placed = list(tables._tables.values())
    assert placed
    assert all(table.holders > 0 and not table.pinned for table in placed)
    del owner
    gc.collect()
    assert not any(table.holders for table in placed)
