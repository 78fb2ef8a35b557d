"""The analytic force map: its symmetries, its zeros, its inverse and its limits."""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from motionlab.lanes import WIDTH, Lanes, pack, unpack
from motionlab.plant.magnetics import (
    AnalyticMap,
    Phases,
    current_for,
    force_fraction,
    normal_force,
    thrust,
)

Array = NDArray[np.float64]

TAU, F_PK, N_PK = 7.2e-3, 34.1, 380.1
NOMINAL = AnalyticMap(
    tau=TAU, offset=0.0, F_pk=F_PK, N_pk=N_PK, I_pk=10.0, I_knee=5.5, h_2=0.0, h_3=0.0
)
MEASURED = NOMINAL._replace(F_pk=38.4, N_pk=427.4, h_3=0.039)
UNEVEN = NOMINAL._replace(h_2=0.05, h_3=-0.03, offset=1e-3)
MAPS = [NOMINAL, MEASURED, UNEVEN]


class Query(NamedTuple):
    """Where, and with which currents."""

    position: Lanes
    i_a: Lanes
    i_b: Lanes
    i_c: Lanes


class Answer(NamedTuple):
    """What the map gives."""

    thrust: Lanes
    normal: Lanes
    fraction: Lanes  # of phase a
    current: Lanes  # the inverse of that


@numba.njit(error_model="numpy")
def _evaluate(force_map: Array, query: Array, answer: Array) -> None:
    m = unpack(AnalyticMap, force_map, 0)
    q = unpack(Query, query, 0)
    current = Phases(q.i_a, q.i_b, q.i_c)
    fraction = force_fraction(m, q.i_a)
    pack(
        Answer(
            thrust(m, q.position, current),
            normal_force(m, q.position, current),
            fraction,
            current_for(m, fraction),
        ),
        answer,
    )


def evaluate(force_map: AnalyticMap, position: float, *currents: float) -> Answer:
    """Return what the map gives at one place."""
    rows = np.tile(np.array(force_map, dtype=float)[:, None], WIDTH)
    query = np.tile(np.array([position, *currents])[:, None], WIDTH)
    answer = np.empty((len(Answer._fields), WIDTH))
    _evaluate(rows, query, answer)
    return Answer(*answer[:, 0])


positions = st.floats(-0.146, 0.146)
currents = st.tuples(*[st.floats(0.0, 10.0)] * 3)
maps = st.sampled_from(MAPS)


@given(force_map=maps, position=positions, i=currents)
def test_thrust_repeats_every_pole_pitch(
    force_map: AnalyticMap, position: float, i: tuple[float, float, float]
) -> None:
    here = evaluate(force_map, position, *i)
    there = evaluate(force_map, position + TAU, *i)
    assert there.thrust == pytest.approx(here.thrust, rel=1e-9, abs=1e-9)
    assert there.normal == pytest.approx(here.normal, rel=1e-9, abs=1e-8)


@given(force_map=maps, position=positions, i=currents)
def test_phases_are_a_third_of_a_pole_pitch_apart(
    force_map: AnalyticMap, position: float, i: tuple[float, float, float]
) -> None:
    a, b, c = i
    here = evaluate(force_map, position, a, b, c)
    there = evaluate(force_map, position + TAU / 3.0, c, a, b)
    assert there.thrust == pytest.approx(here.thrust, rel=1e-9, abs=1e-9)
    assert there.normal == pytest.approx(here.normal, rel=1e-9, abs=1e-8)


@given(position=positions, i=currents, force_map=st.sampled_from([NOMINAL, MEASURED]))
def test_the_mirrored_place_pulls_the_other_way(
    force_map: AnalyticMap, position: float, i: tuple[float, float, float]
) -> None:
    a, b, c = i
    here = evaluate(force_map, position, a, b, c)
    there = evaluate(force_map, -position, a, c, b)
    assert there.thrust == pytest.approx(-here.thrust, rel=1e-9, abs=1e-9)
    assert there.normal == pytest.approx(here.normal, rel=1e-9, abs=1e-8)


@pytest.mark.parametrize("force_map", [NOMINAL, MEASURED])
@pytest.mark.parametrize("phase", [0, 1, 2])
def test_no_thrust_where_aligned_and_unaligned(force_map: AnalyticMap, phase: int) -> None:
    i = [0.0, 0.0, 0.0]
    i[phase] = 10.0
    unaligned = phase * TAU / 3.0
    aligned = unaligned + TAU / 2.0
    for place in (unaligned, aligned):
        assert evaluate(force_map, place, *i).thrust == pytest.approx(0.0, abs=1e-9)
    # it pulls towards the aligned place from both sides
    assert evaluate(force_map, aligned - 1e-3, *i).thrust > 1.0
    assert evaluate(force_map, aligned + 1e-3, *i).thrust < -1.0


def test_peaks_are_the_papers() -> None:
    assert evaluate(NOMINAL, TAU / 4.0, 10.0, 0.0, 0.0).thrust == pytest.approx(34.1, rel=1e-9)
    single = max(evaluate(MEASURED, p, 10.0, 0.0, 0.0).thrust for p in np.linspace(0, TAU, 721))
    assert single == pytest.approx(38.4, rel=1e-3)
    # two phases: 43.1 N where both pull alike; h_3 follows from it
    two = max(evaluate(MEASURED, p, 10.0, 10.0, 0.0).thrust for p in np.linspace(0, TAU, 721))
    assert two == pytest.approx(43.1, abs=0.05)


@given(force_map=maps, i=st.floats(0.0, 10.0))
def test_inverse_of_the_saturation_curve(force_map: AnalyticMap, i: float) -> None:
    assert evaluate(force_map, 0.0, i, 0.0, 0.0).current == pytest.approx(i, rel=1e-9, abs=1e-12)


@given(force_map=maps, low=st.floats(0.0, 10.0), high=st.floats(0.0, 10.0))
def test_more_current_gives_more_force(force_map: AnalyticMap, low: float, high: float) -> None:
    low, high = sorted((low, high))
    first = evaluate(force_map, 0.0, low, 0.0, 0.0).fraction
    second = evaluate(force_map, 0.0, high, 0.0, 0.0).fraction
    assert 0.0 <= first <= second <= 1.0 + 1e-12
    if high > low + 1e-6:
        assert second > first


def test_force_saturates_above_the_knee() -> None:
    fractions = [evaluate(NOMINAL, 0.0, i, 0.0, 0.0).fraction for i in (1.0, 2.0, 5.0, 10.0)]
    assert fractions[1] / fractions[0] == pytest.approx(4.0, rel=0.12)  # quadratic at first
    assert fractions[3] / fractions[2] < 2.0  # less than linear at the end
    assert fractions[3] == pytest.approx(1.0, rel=1e-12)


@given(force_map=maps, position=positions, i=currents)
def test_normal_force_attracts_and_is_bounded(
    force_map: AnalyticMap, position: float, i: tuple[float, float, float]
) -> None:
    normal = evaluate(force_map, position, *i).normal
    assert -1e-9 <= normal <= 3.0 * force_map.N_pk


def test_normal_force_of_one_phase() -> None:
    assert evaluate(NOMINAL, 0.0, 10.0, 0.0, 0.0).normal == pytest.approx(0.0, abs=1e-9)
    assert evaluate(NOMINAL, TAU / 2.0, 10.0, 0.0, 0.0).normal == pytest.approx(N_PK, rel=1e-9)
    most = max(evaluate(NOMINAL, p, 10.0, 10.0, 10.0).normal for p in np.linspace(0.0, TAU, 73))
    assert most == pytest.approx(1.5 * N_PK, rel=1e-9)  # three phases: constant


def test_the_offset_shifts_the_map() -> None:
    shifted = NOMINAL._replace(offset=0.7e-3)
    here = evaluate(NOMINAL, 2.0e-3, 3.0, 4.0, 5.0)
    there = evaluate(shifted, 1.3e-3, 3.0, 4.0, 5.0)
    assert there.thrust == pytest.approx(here.thrust, rel=1e-9)
