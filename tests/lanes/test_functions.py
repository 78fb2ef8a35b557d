"""Functions of lanes, compiled, against exact arithmetic."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Sequence
from decimal import Decimal, localcontext
from typing import Any, NamedTuple

import numba
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from motionlab.lanes import (
    WIDTH,
    Lanes,
    axes_at,
    compiled,
    pack,
    power_of_two,
    record,
    round_down,
    round_nearest,
    select,
    square_root,
    unpack,
)
from motionlab.lanes.functions import clip, decay, exponential, sign, sine_cosine

Array = NDArray[np.float64]

EPS = np.finfo(np.float64).eps
SPECIAL = np.array([math.nan, math.inf, -math.inf, 0.0, -0.0, 1.0, -2.5, 1e300])


class Three(NamedTuple):
    """Arguments or results."""

    a: Lanes
    b: Lanes
    c: Lanes


def on_arrays(function: Callable[..., Any]) -> Callable[..., Array]:
    """Compile ``function(a, b, c) -> Three`` on lanes into one of rows of eight numbers."""

    @numba.njit(error_model="numpy")
    def on_rows(arguments: Array, results: Array) -> None:
        x = unpack(Three, arguments, 0)
        pack(function(x.a, x.b, x.c), results)

    def call(a: Any, b: Any = 0.0, c: Any = 0.0) -> Array:
        arguments = np.array([np.broadcast_to(x, WIDTH) for x in (a, b, c)], dtype=np.float64)
        results = np.full((3, WIDTH), np.nan)
        on_rows(arguments, results)
        return results

    return call


@compiled
def _elementary(a: Lanes, b: Lanes, c: Lanes) -> Three:
    s, co = sine_cosine(a)
    return Three(exponential(a), s, co)


@compiled
def _decay(a: Lanes, b: Lanes, c: Lanes) -> Three:
    e, phi_1 = decay(a, 1.0 / a)
    return Three(e, phi_1, a)


@compiled
def _limits(a: Lanes, b: Lanes, c: Lanes) -> Three:
    return Three(clip(a, b, c), sign(a), select(abs(a) < np.inf, 1.0, 0.0))


@compiled
def _undefined(a: Lanes, b: Lanes, c: Lanes) -> Three:
    return Three(a - a, 0.0 * a, a / a)


@compiled
def _rounding(a: Lanes, b: Lanes, c: Lanes) -> Three:
    return Three(round_nearest(a), round_down(a), square_root(b))


@compiled
def _power(a: Lanes, b: Lanes, c: Lanes) -> Three:
    return Three(power_of_two(a), -a, abs(a))


@compiled
def _masks(a: Lanes, b: Lanes, c: Lanes) -> Three:
    either, both = (a < b) | (b < c), (a < b) & (b < c)
    return Three(select(either, 1, 0), select(both, 1.0, 0.0), select(~both, a, b))


elementary = on_arrays(_elementary)
decays = on_arrays(_decay)
limits = on_arrays(_limits)
undefined = on_arrays(_undefined)
rounding = on_arrays(_rounding)
power = on_arrays(_power)
masks = on_arrays(_masks)


def eight(low: float, high: float) -> st.SearchStrategy[list[float]]:
    return st.lists(st.floats(low, high), min_size=WIDTH, max_size=WIDTH)


def relative_errors(values: Array, exact: Sequence[Decimal]) -> Array:
    """Return how far `values` are from `exact`, relative, in arithmetic of 50 digits."""
    with localcontext(prec=50):
        pairs = zip(values.tolist(), exact, strict=True)
        return np.array([float(abs(Decimal(v) / t - 1)) if t else abs(v) for v, t in pairs])


@given(eight(-700.0, 700.0))
def test_exponential(x: list[float]) -> None:
    with localcontext(prec=50):
        exact = [Decimal(value).exp() for value in x]
    error = relative_errors(elementary(x)[0], exact)
    assert (error <= 1e-14 + 1.2e-16 * np.abs(x)).all()


def test_exponential_at_its_ends() -> None:
    e = elementary([0.0, -700.0, -701.0, -1e6, -math.inf, math.nan, 700.0, 1e-300])[0]
    assert e[0] == 1.0
    assert e[7] == 1.0
    assert (e[2:5] == e[1]).all()
    assert 0.0 < e[1] < 1e-303
    assert math.isnan(e[5])
    assert e[6] > 1e303


@given(eight(-1e5, 1e5))
def test_sine_and_cosine(turns: list[float]) -> None:
    angle = 2.0 * np.pi * np.fmod(np.array(turns), 1.0)  # fmod is exact
    _, sine, cosine = elementary(turns)
    assert np.abs(sine - np.sin(angle)).max() <= 8.0 * EPS
    assert np.abs(cosine - np.cos(angle)).max() <= 8.0 * EPS
    assert np.abs(sine**2 + cosine**2 - 1.0).max() <= 4.0 * EPS


def test_sine_and_cosine_are_exact_at_quarter_turns() -> None:
    turns = 0.25 * np.arange(-9, 7, 2)
    _, sine, cosine = elementary(turns)
    assert (cosine == 0.0).all()
    assert sine.tolist() == [-1.0, 1.0] * 4
    _, sine, cosine = elementary(turns + 0.25)
    assert (sine == 0.0).all()
    assert cosine.tolist() == [1.0, -1.0] * 4


def exact_decay(x: float) -> tuple[Decimal, Decimal]:
    """Return e**-x and phi1 = (1 - e**-x)/x; of 50 digits the difference leaves 38."""
    with localcontext(prec=50):
        e = (-Decimal(x)).exp()
        return e, (1 - e) / Decimal(x)


@given(eight(1e-12, 600.0))
def test_decay(x: list[float]) -> None:
    check_decay(x)


@given(eight(0.029, 0.031))
def test_decay_around_the_switch_to_series(x: list[float]) -> None:
    check_decay(x)


def test_decay_on_both_sides_of_the_switch() -> None:
    below = math.nextafter(0.03, 0.0)
    check_decay([below, 0.03, math.nextafter(0.03, 1.0), 0.0299, 0.0301, 0.02, 0.01, 1e-6])


def check_decay(x: list[float]) -> None:
    """The series of phi1 is cut off at 1.5e-13 where it ends; the quotient is better than that."""
    e, phi_1, _ = decays(x)
    exact = [exact_decay(value) for value in x]
    assert relative_errors(e, [both[0] for both in exact]).max() <= 1e-13
    assert relative_errors(phi_1, [both[1] for both in exact]).max() <= 2e-13


def test_decay_at_rest_and_beyond() -> None:
    e, phi_1, _ = decays([0.0, 5e-324, 1e-300, 1e3, 1e9, math.nan, 1.0, 1e-20])
    assert e[:3].tolist() == phi_1[:3].tolist() == [1.0, 1.0, 1.0]
    assert phi_1[3:5] == pytest.approx([1e-3, 1e-9], rel=1e-14)
    assert np.isnan([e[5], phi_1[5]]).all()


@given(eight(-10.0, 10.0), st.floats(-5.0, 0.0), st.floats(0.0, 5.0))
def test_clip(x: list[float], low: float, high: float) -> None:
    assert (limits(x, low, high)[0] == np.clip(x, low, high)).all()


def test_clip_sign_and_finiteness_of_special_values() -> None:
    clipped, signs, finite = limits(SPECIAL, -1.0, 2.0)
    assert np.array_equal(clipped, [math.nan, 2, -1, 0, 0, 1, -1, 2], equal_nan=True)
    assert signs.tolist() == [0, 1, -1, 0, 0, 1, -1, 1]
    assert finite.tolist() == [0, 0, 0, 1, 1, 1, 1, 1]


def test_undefined_results_are_nan() -> None:
    """A compiler that may assume that there is no NaN would return 0, 0 and 1."""
    with np.errstate(all="ignore"):
        expected = [SPECIAL - SPECIAL, 0.0 * SPECIAL, SPECIAL / SPECIAL]
    assert np.array_equal(undefined(SPECIAL), expected, equal_nan=True)


def test_power_of_two_is_exact() -> None:
    for start in range(-1022, 1024, WIDTH):
        n = np.minimum(np.arange(start, start + WIDTH), 1023)
        powers, negative, magnitude = power(n)
        assert (powers == np.ldexp(1.0, n)).all()
        assert (negative == -n).all()
        assert (magnitude == np.abs(n)).all()


@given(eight(-1e9, 1e9), eight(0.0, 1e9))
def test_rounding_and_square_root(a: list[float], b: list[float]) -> None:
    nearest, down, root = rounding(a, b)
    assert (nearest == np.rint(a)).all()
    assert (down == np.floor(a)).all()
    assert (root == np.sqrt(b)).all()


def test_halves_round_to_even() -> None:
    halves = [-2.5, -1.5, -0.5, 0.5, 1.5, 2.5, 3.5, 4.5]
    assert rounding(halves)[0].tolist() == [-2, -2, 0, 0, 2, 2, 4, 4]


@given(eight(-1.0, 1.0), eight(-1.0, 1.0), eight(-1.0, 1.0))
def test_masks(a: list[float], b: list[float], c: list[float]) -> None:
    x, y, z = np.array([a, b, c])
    either, both, chosen = masks(x, y, z)
    assert (either == ((x < y) | (y < z))).all()
    assert (both == ((x < y) & (y < z))).all()
    assert (chosen == np.where((x < y) & (y < z), y, x)).all()


@pytest.mark.parametrize("name", ["add", "sub", "mul", "truediv", "lt", "le", "gt", "ge", "eq"])
def test_operators_are_those_of_numpy(name: str) -> None:
    """With lanes and with numbers on either side."""
    op = getattr(operator, name)
    number = 1.7
    if name in {"lt", "le", "gt", "ge", "eq"}:

        @compiled
        def apply(a: Lanes, b: Lanes, c: Lanes) -> Three:
            sides = op(a, b), op(a, number), op(number, a)
            return Three(
                select(sides[0], 1.0, 0.0), select(sides[1], 1.0, 0.0), select(sides[2], 1.0, 0.0)
            )
    else:

        @compiled
        def apply(a: Lanes, b: Lanes, c: Lanes) -> Three:
            return Three(op(a, b), op(a, number), op(number, a))

    a = np.array([math.nan, math.inf, number, -3.5, 0.1, 7.0, 1e-300, 2.0])
    b = np.array([1.0, math.inf, 2.0, -3.5, 0.3, math.nan, 1e300, 0.0])
    with np.errstate(all="ignore"):
        expected = np.array([op(a, b), op(a, number), op(number, a)], dtype=np.float64)
    np.testing.assert_array_max_ulp(on_arrays(apply)(a, b), expected, maxulp=1)


def test_axes_alternate_and_records_land_in_their_tick() -> None:
    @numba.njit
    def copy(inputs: Array, doubles: Array, singles: NDArray[np.float32]) -> None:
        for k in range(len(inputs)):
            three = axes_at(Three, inputs, k)
            record(three, doubles, k)
            record(three, singles, k)

    inputs = np.arange(24.0).reshape(4, 3, 2) + 0.1
    doubles = np.zeros((4, 3, WIDTH))
    singles = np.zeros((4, 3, WIDTH), dtype=np.float32)
    copy(inputs, doubles, singles)
    assert (doubles == np.tile(inputs, WIDTH // 2)).all()
    assert (singles == doubles.astype(np.float32)).all()
