"""A lane's bits depend on nothing but its own parameters, state and inputs."""

from __future__ import annotations

import numpy as np
import pytest

from motionlab.lanes import WIDTH
from tests.kernel.every_law import lanes, ride
from tests.kernel.every_sharing_law import table_lanes
from tests.kernel.lane_runs import Array, changed, rows, run


def samples_of(parameters: Array, pieces: int = 1) -> np.ndarray:
    """Return samples of a ride, run in equal pieces, as bits: NaN compares equal to itself."""
    state, driven = ride()
    done = [run(parameters, state, piece) for piece in np.split(driven, pieces)]
    return np.concatenate(done).view(np.uint32)


@pytest.fixture(scope="module")
def parameters() -> Array:
    return rows(lanes(50e-9))


@pytest.fixture(scope="module")
def expected(parameters: Array) -> np.ndarray:
    return samples_of(parameters)


def test_lanes_differ(expected: np.ndarray) -> None:
    assert len({expected[:, :, i].tobytes() for i in range(WIDTH)}) == WIDTH


def test_the_same_run_gives_the_same_bits(parameters: Array, expected: np.ndarray) -> None:
    assert (samples_of(parameters) == expected).all()


def test_bits_do_not_depend_on_how_a_run_is_cut(parameters: Array, expected: np.ndarray) -> None:
    assert (samples_of(parameters, pieces=16) == expected).all()


@pytest.mark.parametrize("order", [(2, 1, 0, 3, 6, 7, 4, 5), (6, 5, 4, 3, 2, 1, 0, 7)])
def test_bits_do_not_depend_on_the_place(
    order: tuple[int, ...], parameters: Array, expected: np.ndarray
) -> None:
    """Places of equal parity: even ones are driven by x, odd ones by y."""
    moved = np.ascontiguousarray(parameters[:, order])
    assert (samples_of(moved) == expected[:, :, order]).all()


@pytest.mark.parametrize("place", range(WIDTH))
def test_bits_do_not_depend_on_twins(place: int, parameters: Array, expected: np.ndarray) -> None:
    twins = np.repeat(parameters[:, place : place + 1], WIDTH, axis=1)
    assert (samples_of(twins)[:, :, place] == expected[:, :, place]).all()


@pytest.mark.parametrize("place", range(WIDTH))
def test_bits_do_not_depend_on_failing_neighbours(
    place: int, parameters: Array, expected: np.ndarray
) -> None:
    broken = [
        changed(each, {"friction.sigma_0": float("nan")} if i % 3 else {"controller.k_p": -1e9})
        for i, each in enumerate(lanes(50e-9))
    ]
    among = rows(broken)
    among[:, place] = parameters[:, place]
    samples = samples_of(among)
    assert (samples[:, :, place] == expected[:, :, place]).all()
    others = np.delete(samples, place, axis=2).view(np.float32)
    assert np.isnan(others).any()


@pytest.mark.parametrize("place", range(WIDTH))
def test_bits_do_not_depend_on_who_reads_tables(
    place: int, parameters: Array, expected: np.ndarray
) -> None:
    """A lane is alone, then among lanes with force maps of the other kind."""
    tabled = rows(table_lanes(50e-9))
    twins = np.repeat(tabled[:, place : place + 1], WIDTH, axis=1)
    alone = samples_of(twins)[:, :, place]
    mixed = np.where(np.arange(WIDTH) == place, tabled, parameters)
    found = samples_of(np.ascontiguousarray(mixed))
    assert (found[:, :, place] == alone).all()
    others = np.arange(WIDTH) != place
    assert (found[:, :, others] == expected[:, :, others]).all()


def test_bits_of_lanes_with_tables_do_not_depend_on_their_place() -> None:
    tabled = rows(table_lanes(50e-9))
    order = (2, 1, 0, 3, 6, 7, 4, 5)
    moved = samples_of(np.ascontiguousarray(tabled[:, order]))
    assert (moved == samples_of(tabled)[:, :, order]).all()
