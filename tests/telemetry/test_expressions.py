"""Math channels: what is an expression, what its unit is, and what its values are."""

from __future__ import annotations

import itertools
import json

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from motionlab.config.units import parse_unit
from motionlab.errors import ConfigError
from motionlab.telemetry.channels import stream_columns
from motionlab.telemetry.expressions import evaluate as evaluation
from motionlab.telemetry.expressions.columns import (
    compile_column,
    compile_columns,
    split_columns,
)
from motionlab.telemetry.expressions.compile import FUNCTIONS, compile_expression
from motionlab.telemetry.expressions.evaluate import Evaluation, evaluate, reach
from motionlab.telemetry.expressions.parse import ExpressionError
from tests.fixtures.__main__ import EXPRESSIONS, expressions

UNITS = {name: channel.unit for name, channel in stream_columns("AB")}
PURE = {"u": "1", "v": "1"}
T = 0.0005


def value_of(text: str, *samples: NDArray[np.float32]) -> NDArray[np.float32]:
    return evaluate(compile_expression(text, PURE, T), np.stack(samples).astype(np.float32))


def refused(text: str) -> ExpressionError:
    with pytest.raises(ExpressionError) as found:
        compile_column(text, UNITS, T)
    return found.value


@pytest.mark.parametrize(
    ("text", "unit"),
    [
        ("hypot(B.x.following_error, B.y.following_error)", "m"),
        ("B.x.thrust * B.x.velocity", "W"),
        ("integral(B.x.thrust * B.x.velocity)", "J"),
        ("derivative(B.x.position)", "m/s"),
        ("derivative(derivative(B.x.velocity))", "m/s^3"),
        ("B.x.thrust / B.x.position", "N/m"),
        ("B.x.thrust / B.x.velocity", "N s/m"),
        ("integral(B.x.thrust)", "N s"),
        ("B.x.thrust / B.x.acceleration", "kg"),
        ("sqrt(B.x.current_a ** 2 + B.x.current_b ^ 2)", "A"),
        ("sqrt(B.x.thrust)", "N^0.5"),
        ("B.x.thrust / B.x.friction", "1"),
        ("sign(B.x.velocity)", "1"),
        ("200e3 [N/m] * B.x.following_error + B.x.friction", "N"),
        ("B.x.following_error - 50 [nm]", "m"),
        ("lowpass(B.x.thrust, 50) - mean(B.x.thrust, 20 [ms])", "N"),
        ("B.x.force_saturated + 1", "1"),
        ("1 / B.x.current_a", "1/A"),
    ],
)
def test_units(text: str, unit: str) -> None:
    assert compile_expression(text, UNITS, T).unit == unit
    found = parse_unit(unit)
    assert found is not None
    assert str(found.dimension) == unit


@pytest.mark.parametrize(
    ("text", "start", "said"),
    [
        ("=B.x.position + B.x.thrust", 16, "not m and N; the second would have to be in m"),
        ("=B.x.position - 1", 16, "a number can have a unit: 1 [m]"),
        ("=1 + B.x.position", 1, "a number can have a unit: 1 [m]"),
        ("power =  max(B.x.thrust, A.x.velocity)", 25, "max needs operands of one unit"),
        ("=sin(B.x.position)", 5, "needs a pure number (rad), not m"),
        ("=B.x.folowing_error", 1, "near are B.x.following_error"),
        ("=lowpass(A.x.thrust, 1000)", 21, "below 1000 Hz, half the sample rate; got 1000"),
        ("=lowpass(A.x.thrust, 3 [s])", 21, "needs Hz here, not s"),
        ("=mean(A.x.thrust, A.x.thrust)", 18, "needs a plain number here, in s"),
        ("=mean(A.x.thrust, 1e9)", 18, "from 0.0005 to 100 s"),
        ("=delay(A.x.thrust, 0.00075)", 19, "0.00075 s are 1.5: take 0.0005 s or 0.001 s"),
        ("=delay(A.x.thrust, 0.60025)", 19, "needs a whole number of samples of 0.0005 s"),
        ("=mean(A.x.thrust, 1.25 [ms])", 18, "0.00125 s are 2.5: take 0.001 s or 0.0015 s"),
        ("=A.x.thrust\u00b2", 11, "'\u00b2' has no meaning here"),
        ("=\u221aA.x.thrust", 1, "'\u221a' has no meaning here"),
        ('="A.x.\u00f6"', 2, "no channel 'A.x.\u00f6'"),
        ("=bandpass(A.x.thrust, 9, 3)", 22, "low < high"),
        ("=A.x.thrust ** 9", 15, "whole numbers from -8 to 8"),
        ("=A.x.thrust ** 999999999", 15, "whole numbers from -8 to 8"),
        ("=A.x.thrust ** A.x.K", 15, "is no power"),
        ("=A.x.thrust ** 2 ** 2", 17, "parentheses"),
        ("=abs(A.x.thrust, 1)", 1, "abs takes 1 argument, not 2"),
        ("=__import__('os')", 12, "has no meaning here"),
        ("=__import__(A.x.thrust)", 1, "no function '__import__'; there are abs"),
        ("=A.x.thrust.__class__", 1, "no channel"),
        ("=A.x.thrust[0]", 11, "stands where an operator or the end belongs"),
        ("=A.x.thrust; 1", 11, "has no meaning here"),
        ("=A.x.thrust + ", 13, "the end stands where a number"),
        ("=\uff41", 1, "has no meaning here"),
        ("=1 [parsec] * A.x.thrust", 1, "is no unit"),
        ("=1e999 * A.x.thrust", 1, "beyond the largest number"),
        ("=3 * 4", 1, "reads no channel"),
        ("=", 1, "the end stands where"),
        ("=" + "(" * 150 + "A.x.K", 26, "within each other"),
        ("=" + "-" * 190 + "A.x.K", 25, "signs in a row"),
        ("=" + "1+" * 150 + "A.x.K", 201, "200 are the most"),
        ("=" + "+".join(f"B.{a}.current_{p}" for a in "xy" for p in "abc"), None, ""),
        (";=A.x.thrust", 0, "a name begins with a letter"),
        ("A.x.thrust=A.x.friction", 0, "is the name of a channel"),
    ],
)
def test_errors_name_the_place_and_what_would_be_right(
    text: str, start: int | None, said: str
) -> None:
    if start is None:
        assert compile_column(text, UNITS, T).program.unit == "A"
        return
    error = refused(text)
    assert said in str(error)
    assert error.span.start == start
    assert str(error).startswith(f"character {start + 1}: ")


ALPHABET = st.one_of(
    st.sampled_from(
        [*"uv(),+-*/^ =\x00", "**", '"', "[m]", "1e3", ".5", "\u03c0", "__"]
        + [f"{name}(" for name in FUNCTIONS]
    ),
    st.text(max_size=2),
)


@settings(max_examples=300, deadline=None)
@given(st.lists(ALPHABET, max_size=60).map("".join))
@example("(" * 100_000)
@example("u" + "**8" * 60)
def test_any_text_is_refused_by_one_error_or_has_values(text: str) -> None:
    try:
        program = compile_expression(text, PURE, T)
    except ExpressionError as error:
        assert 0 <= error.span.start <= error.span.end <= max(len(text), error.span.start)
        return
    values = evaluate(program, np.zeros((len(program.channels), 5), np.float32))
    assert not np.isinf(values).any()


NODES = st.recursive(
    st.sampled_from(["u", "v", "0.75", "3"]),
    lambda inner: st.one_of(
        st.tuples(inner, st.sampled_from(["+", "-", "*", "/"]), inner).map(
            lambda each: f"({each[0]} {each[1]} {each[2]})"
        ),
        st.tuples(st.sampled_from(["abs", "sign", "sin", "cos"]), inner).map(
            lambda each: f"{each[0]}({each[1]})"
        ),
        st.tuples(st.sampled_from(["hypot", "min", "max"]), inner, inner).map(
            lambda each: f"{each[0]}({each[1]}, {each[2]})"
        ),
        inner.map(lambda each: f"-({each})**2"),
    ),
    max_leaves=8,
)
NUMPY = {"min": np.minimum, "max": np.maximum, "pi": np.pi} | {
    name: getattr(np, name) for name in ("abs", "sign", "sin", "cos", "hypot")
}


@settings(max_examples=100, deadline=None)
@given(NODES.filter(lambda text: len(text) < 150 and ("u" in text or "v" in text)))
def test_values_are_those_of_numpy(text: str) -> None:
    draw = np.random.default_rng(1).normal(size=(2, 20)).astype(np.float32)
    names = {"u": draw[0].astype(float), "v": draw[1].astype(float)}
    with np.errstate(all="ignore"):
        wanted = np.broadcast_to(eval(text, NUMPY | names), 20).astype(np.float32)
    program = compile_expression(text, PURE, T)
    found = evaluate(program, np.stack([names[name] for name in program.channels]).astype("f4"))
    finite = np.isfinite(wanted) & np.isfinite(found)
    np.testing.assert_allclose(found[finite], wanted[finite], rtol=1e-6)
    assert not np.isinf(found).any()


def test_operations_with_memory_keep_to_their_equations() -> None:
    from scipy import signal

    u = np.random.default_rng(3).normal(size=400).astype(np.float32)
    k = np.tan(np.pi * 40 * T)
    zi = [u[0] * (1 - k / (1 + k))]
    low, _ = signal.lfilter(np.array([k, k]) / (1 + k), [1, (k - 1) / (k + 1)], u, zi=zi)
    np.testing.assert_allclose(value_of("lowpass(u, 40)", u), low, rtol=1e-5, atol=1e-7)
    np.testing.assert_allclose(value_of("highpass(u, 40)", u), u - low, rtol=1e-4, atol=1e-6)
    slope = value_of("derivative(u)", u)
    assert np.isnan(slope[0])
    np.testing.assert_allclose(slope[1:], np.diff(u.astype(float)) / T, rtol=1e-6)
    area = np.concatenate(([0], np.cumsum(0.5 * T * (u[1:].astype(float) + u[:-1]))))
    np.testing.assert_allclose(value_of("integral(u)", u), area, rtol=1e-5, atol=1e-9)
    mean = [u[max(0, i - 19) : i + 1].astype(float).mean() for i in range(400)]
    np.testing.assert_allclose(value_of("mean(u, 0.01)", u), mean, rtol=1e-5, atol=1e-7)
    late = value_of("delay(u, 0.01)", u)
    assert np.isnan(late[:20]).all()
    np.testing.assert_array_equal(late[20:], u[:-20])


def test_a_lowpass_is_3_db_down_at_its_frequency() -> None:
    time = np.arange(8000) * T
    out = value_of("lowpass(u, 100)", np.sin(2 * np.pi * 100 * time).astype(np.float32))
    assert np.std(out[4000:]) == pytest.approx(0.5, rel=1e-3)


def test_what_is_not_finite_is_a_gap_after_which_memory_begins_anew() -> None:
    u = np.array([1, 0, 4, 4, 4], np.float32)
    np.testing.assert_array_equal(value_of("1 / u", u), [1, np.nan, 0.25, 0.25, 0.25])
    assert np.isnan(value_of("sqrt(-u)", u)).tolist() == [True, False, True, True, True]
    after = value_of("integral(1 / u)", u)
    np.testing.assert_allclose(after, [0, np.nan, 0, 0.25 * T, 0.5 * T])
    np.testing.assert_array_equal(value_of("mean(1 / u, 1)", u)[1:3], [np.nan, 0.25])
    # Beyond float32, and beyond any number.
    assert np.isnan(value_of("(u * 1e30) ** 2 * u", u)).tolist() == [True, False, True, True, True]
    assert np.isnan(value_of("(u * 1e60) ** 8", u)).tolist() == [True, False, True, True, True]


@pytest.mark.parametrize(
    "text", ["mean(lowpass(u, 3) * v, 0.03)", "delay(derivative(v), 0.02)", "integral(1 / u)"]
)
@settings(max_examples=20, deadline=None)
@given(cuts=st.lists(st.integers(0, 300), max_size=5))
def test_how_a_record_is_cut_changes_no_bit(text: str, cuts: list[int]) -> None:
    samples = np.random.default_rng(5).normal(size=(2, 300)).astype(np.float32)
    samples[:, 100:103] = np.nan
    samples[0, 170] = 0.0
    program = compile_expression(text, PURE, T)
    ordered = samples[[("u", "v").index(name) for name in program.channels]]
    whole = evaluate(program, ordered)
    part = Evaluation(program)
    ends = sorted({0, *cuts, 300})
    pieces = [part(ordered[:, a:b]) for a, b in itertools.pairwise(ends)]
    np.testing.assert_array_equal(np.concatenate(pieces), whole)
    reached = reach(program)
    if reached is not None:
        np.testing.assert_array_equal(
            evaluate(program, ordered[:, 150 - reached :])[reached:], whole[150:]
        )


def test_blocks_change_no_bit(monkeypatch: pytest.MonkeyPatch) -> None:
    u = np.random.default_rng(5).normal(size=300).astype(np.float32)
    whole = value_of("mean(lowpass(u, 3), 0.03)", u)
    monkeypatch.setattr(evaluation, "BLOCK", 64)
    np.testing.assert_array_equal(value_of("mean(lowpass(u, 3), 0.03)", u), whole)


def test_columns_are_parted_outside_of_expressions() -> None:
    text = 'A.x.thrust,e=hypot(u, v),=min("a,b", (v)),Temp (degC),=u'
    parts = ["A.x.thrust", "e=hypot(u, v)", '=min("a,b", (v))', "Temp (degC)", "=u"]
    assert split_columns(text) == parts
    odd = {"a,b": "um", "v": "m"}
    assert compile_columns(['=min("a,b", (v))'], odd, T)['=min("a,b", (v))'].program.unit == "m"
    with pytest.raises(ConfigError, match=r"(?s)columns.1: character 3.*columns.2: comes twice"):
        compile_columns(["v", "= w", "=v", "v= "], {"v": "m"} | odd, T)


def test_a_column_in_another_unit_counts_in_si() -> None:
    program = compile_expression("u + v", {"u": "mm", "v": "m"}, T)
    values = evaluate(program, np.array([[1.0], [2.0]], np.float32))
    assert (program.unit, values[0]) == ("m", np.float32(2.001))


def test_the_fixture_of_the_page_is_what_is_computed() -> None:
    kept, now = json.loads(EXPRESSIONS.read_text()), expressions()
    assert kept["functions"] == now["functions"]
    for old, new in zip(kept["cases"], now["cases"], strict=True):
        for before, after in zip(old["steps"], new["steps"], strict=True):
            assert before["op"] == after["op"]
            assert before["values"] == pytest.approx(after["values"], rel=1e-12)
        values = (np.array(each["values"], dtype=float) for each in (old, new))
        np.testing.assert_allclose(*values, rtol=1e-6, err_msg="run python -m tests.fixtures")
