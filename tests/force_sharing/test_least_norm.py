"""Force sharing on the controller's map: exact while unlimited, within the limits always."""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from motionlab.force_sharing.functions.least_norm import share_in_closed_form
from motionlab.lanes import WIDTH, Lanes, pack, select, unpack
from motionlab.plant.magnetics import AnalyticMap, thrust

Array = NDArray[np.float64]

TAU = 7.2e-3
NOMINAL = AnalyticMap(
    tau=TAU, offset=0.0, F_pk=34.1, N_pk=380.1, I_pk=10.0, I_knee=5.5, h_2=0.0, h_3=0.0
)
LINEAR_UP_TO = 27.3  # N: below it no phase is at its limit, wherever the mover stands
EVERYWHERE = np.linspace(0.0, TAU, 40 * WIDTH, endpoint=False)


class Query(NamedTuple):
    """What is asked of each lane."""

    current_limit: Lanes
    position: Lanes
    force: Lanes


class Answer(NamedTuple):
    """What sharing gives, and the map's thrust of the shared currents."""

    i_a: Lanes
    i_b: Lanes
    i_c: Lanes
    force: Lanes
    limited: Lanes
    thrust: Lanes


@numba.njit(error_model="numpy")
def _share(force_map: Array, query: Array, answer: Array) -> None:
    m = unpack(AnalyticMap, force_map, 0)
    q = unpack(Query, query, 0)
    share = share_in_closed_form(m, q.current_limit, q.position, q.force)
    given_thrust = thrust(m, q.position, share.current)
    i = share.current
    limited = select(share.limited, 1.0, 0.0)
    pack(Answer(i.a, i.b, i.c, share.force, limited, given_thrust), answer)


def share(
    force_map: AnalyticMap, position: Array | float, force: Array | float, limit: float = 10.0
) -> Answer:
    """Share forces of any number of positions, eight lanes at a time."""
    position, force = np.broadcast_arrays(np.atleast_1d(position), np.atleast_1d(force))
    count = position.size
    blocks = -(-count // WIDTH)
    answer = np.empty((blocks, len(Answer._fields), WIDTH))
    rows = np.tile(np.array(force_map, dtype=float)[:, None], WIDTH)
    for block in range(blocks):
        lanes = np.arange(block * WIDTH, (block + 1) * WIDTH) % count
        query = np.stack([np.full(WIDTH, limit), position[lanes], force[lanes]])
        _share(rows, query, answer[block])
    return Answer(*answer.transpose(1, 0, 2).reshape(len(Answer._fields), -1)[:, :count])


positions = st.floats(-0.146, 0.146)
signs = st.sampled_from([-1.0, 1.0])
# Maps with mild harmonics, within which every position keeps a phase that pulls either way.
maps = st.builds(
    AnalyticMap,
    tau=st.floats(1e-3, 2e-2),
    offset=st.floats(-0.01, 0.01),
    F_pk=st.floats(1.0, 500.0),
    N_pk=st.just(380.1),
    I_pk=st.floats(1.0, 50.0),
    I_knee=st.floats(0.5, 100.0),
    h_2=st.floats(-0.05, 0.05),
    h_3=st.floats(-0.05, 0.05),
)


@given(position=positions, force=st.floats(1e-6, LINEAR_UP_TO), sign=signs)
def test_gives_the_commanded_force_while_unlimited(
    position: float, force: float, sign: float
) -> None:
    answer = share(NOMINAL, position, sign * force)
    assert answer.thrust[0] == pytest.approx(sign * force, rel=1e-9)
    assert answer.force[0] == pytest.approx(sign * force, rel=1e-9)
    assert answer.limited[0] == 0.0


@given(force_map=maps, position=positions, fraction=st.floats(1e-6, 2.0), sign=signs)
def test_any_map_gives_the_force_or_says_that_it_is_limited(
    force_map: AnalyticMap, position: float, fraction: float, sign: float
) -> None:
    force = sign * fraction * force_map.F_pk
    answer = share(force_map, position, force, limit=force_map.I_pk)
    currents = np.array([answer.i_a, answer.i_b, answer.i_c])
    assert (currents >= 0.0).all()
    assert (currents <= force_map.I_pk * (1.0 + 1e-12)).all()
    assert answer.thrust[0] == pytest.approx(answer.force[0], rel=1e-9)
    if answer.limited[0]:
        assert abs(answer.force[0]) < abs(force)
        assert currents.max() == pytest.approx(force_map.I_pk, rel=1e-9)
    else:
        assert answer.force[0] == pytest.approx(force, rel=1e-9)


@given(position=positions, force=st.floats(-40.0, 40.0), limit=st.floats(0.1, 10.0))
def test_currents_stay_within_the_limit(position: float, force: float, limit: float) -> None:
    answer = share(NOMINAL, position, force, limit)
    currents = np.array([answer.i_a, answer.i_b, answer.i_c])
    assert (currents >= 0.0).all()
    assert (currents <= limit * (1.0 + 1e-12)).all()
    assert answer.thrust[0] == pytest.approx(answer.force[0], rel=1e-9, abs=1e-12)
    assert abs(answer.force[0]) <= abs(force) * (1.0 + 1e-12)


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_force_at_a_command_of_40_n(sign: float) -> None:
    force = sign * share(NOMINAL, EVERYWHERE, sign * 40.0).force
    assert force.min() == pytest.approx(28.1, abs=0.05)
    assert force.max() == pytest.approx(34.1, abs=0.05)


def test_linear_up_to_27_3_n_and_no_further() -> None:
    assert not share(NOMINAL, EVERYWHERE, LINEAR_UP_TO - 0.05).limited.any()
    assert share(NOMINAL, EVERYWHERE, LINEAR_UP_TO + 0.05).limited.any()


def test_a_phase_pulls_only_the_way_it_is_asked() -> None:
    # Just before phase a is aligned (theta_a = pi) it pulls forward, just behind it backward.
    before, behind = 0.49 * TAU, 0.51 * TAU
    assert share(NOMINAL, before, 10.0).i_a[0] > 0.0
    assert share(NOMINAL, behind, 10.0).i_a[0] == 0.0
    assert share(NOMINAL, behind, -10.0).i_a[0] > 0.0


def test_no_force_takes_no_current() -> None:
    answer = share(NOMINAL, EVERYWHERE, 0.0)
    assert not np.array([answer.i_a, answer.i_b, answer.i_c]).any()
    assert not answer.force.any()
