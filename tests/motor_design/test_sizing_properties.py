"""Sizing holds for any motor: both directions undo each other, and units agree."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from typing import Any

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from pydantic import BaseModel

from motionlab.errors import ConfigError
from motionlab.motor_design import equations as eq
from motionlab.motor_design.design import design
from motionlab.motor_design.document import Rating, Reading, Sizing
from motionlab.motor_design.inputs import Dimensions, Requirements
from motionlab.motor_design.rating import rate
from motionlab.motor_design.sizing import size

TOLERANCE = 1e-9

REQUIREMENTS = st.fixed_dictionaries(
    {
        "f_max": st.floats(0.1, 1e4),
        "v_max": st.floats(0.01, 20.0),
        "i": st.floats(0.1, 200.0),
        "tau": st.floats(1e-3, 0.05),
        "sigma": st.floats(0.1, 10.0),
        "n": st.integers(1, 30),
        "limbs": st.integers(1, 2),
        "g": st.floats(1e-5, 5e-3),
        "B_g": st.floats(0.1, 2.0),
        "H_a": st.floats(0.0, 5e4),
        "l_a": st.floats(0.01, 2.0),
        "K_e": st.floats(0.1, 1.0),
        "K_d": st.floats(0.1, 1.0),
        "lambda": st.floats(1.01, 50.0),
    }
)


def sized(fields: dict[str, Any]) -> tuple[Requirements, Sizing]:
    """Return requirements and what they lead to; a machine out of range is not looked at."""
    requirements = Requirements.model_validate(fields)
    try:
        return requirements, size(requirements)
    except ConfigError:
        assume(False)
        raise


def rated(sizing: Sizing) -> Rating:
    """Return the rating of the dimensions found."""
    return rate(Dimensions.model_validate(sizing.dimensions.model_dump(by_alias=True)))


@settings(deadline=None, derandomize=True)
@given(REQUIREMENTS)
def test_dimensions_give_their_requirements_back(fields: dict[str, Any]) -> None:
    r, sizing = sized(fields)
    rating = rated(sizing)
    assert rating.f_max.value == pytest.approx(r.f_max, rel=TOLERANCE)
    assert rating.P_max.value == pytest.approx(r.f_max * r.v_max, rel=TOLERANCE)
    assert rating.lambda_needed.value is not None
    assert 1 - 1 / rating.lambda_needed.value == pytest.approx(1 - 1 / r.lambda_, rel=1e-7)
    for key in ("w", "A", "K_1", "K_2", "A_g", "psi", "dt", "u"):
        found, again = getattr(sizing, key).value, getattr(rating, key).value
        assert again == pytest.approx(found, rel=TOLERANCE), key


@settings(deadline=None, derandomize=True)
@given(REQUIREMENTS)
def test_requirements_given_back_lead_to_the_same_dimensions(fields: dict[str, Any]) -> None:
    _, sizing = sized(fields)
    rating = rated(sizing)
    found = sizing.dimensions.model_dump(by_alias=True, exclude={"l_m", "N"})
    again = size(
        Requirements.model_validate(
            {**found, "f_max": rating.f_max.value, "lambda": rating.lambda_needed.value}
        )
    ).dimensions
    assert again.l_m == pytest.approx(sizing.dimensions.l_m, rel=1e-7)
    assert again.N == sizing.dimensions.N


@settings(deadline=None, derandomize=True)
@given(REQUIREMENTS)
def test_turns_are_the_fewest_that_reach_the_flux_density(fields: dict[str, Any]) -> None:
    r, sizing = sized(fields)
    rating = rated(sizing)
    assert rating.B_g_reached.value is not None
    assert rating.B_g_reached.value >= r.B_g * (1 - TOLERANCE)
    fewer = sizing.dimensions.N - 1
    assert eq.flux_density(H_a=r.H_a, l_a=r.l_a, g=r.g, N=fewer, i=r.i) <= r.B_g * (1 + TOLERANCE)


@settings(deadline=None, derandomize=True)
@given(REQUIREMENTS)
def test_voltage_times_current_is_the_power(fields: dict[str, Any]) -> None:
    r, sizing = sized(fields)
    assert sizing.u.value is not None
    assert r.K_e * r.K_d * r.i * sizing.u.value == pytest.approx(r.f_max * r.v_max, rel=TOLERANCE)


@settings(deadline=None, derandomize=True)
@given(REQUIREMENTS)
def test_the_document_is_json_and_can_be_sent_back(fields: dict[str, Any]) -> None:
    sized(fields)
    dimensions = {**fields, "l_m": 0.04, "N": 100}
    document = design({"requirements": fields, "dimensions": dimensions}).model_dump(by_alias=True)
    sent = json.loads(json.dumps(document, allow_nan=False))
    again = design({key: sent[key] for key in ("preset", "requirements", "dimensions")})
    assert again.model_dump(by_alias=True) == document


# -- units ----------------------------------------------------------------------------------------

SCALES = {"m": 1.37, "kg": 0.83, "s": 1.21, "A": 0.71}
"""As if all were measured in other base units."""

BASE = {
    "1": {},
    "m": {"m": 1},
    "m^2": {"m": 2},
    "kg": {"kg": 1},
    "s": {"s": 1},
    "A": {"A": 1},
    "m/s": {"m": 1, "s": -1},
    "m/s^2": {"m": 1, "s": -2},
    "A/m": {"A": 1, "m": -1},
    "N": {"kg": 1, "m": 1, "s": -2},
    "W": {"kg": 1, "m": 2, "s": -3},
    "V": {"kg": 1, "m": 2, "s": -3, "A": -1},
    "T": {"kg": 1, "s": -2, "A": -1},
    "Wb": {"kg": 1, "m": 2, "s": -2, "A": -1},
    "H": {"kg": 1, "m": 2, "s": -2, "A": -2},
    "H/m": {"kg": 1, "m": 1, "s": -2, "A": -2},
}


def scale(unit: str) -> float:
    return math.prod(SCALES[base] ** power for base, power in BASE[unit].items())


def scaled(model: BaseModel) -> dict[str, Any]:
    """Return a model's fields in the other base units."""
    fields: dict[str, Any] = {}
    for name, info in type(model).model_fields.items():
        value = getattr(model, name)
        key = info.alias or name
        if isinstance(value, BaseModel):
            fields[key] = scaled(value)
        elif isinstance(value, int) or value is None:
            fields[key] = value
        else:
            extra = info.json_schema_extra
            assert isinstance(extra, dict)
            fields[key] = value * scale(str(extra["unit"]))
    return fields


def readings(section: BaseModel, path: str = "") -> Iterator[tuple[str, Reading]]:
    for name, value in section:
        if isinstance(value, Reading):
            yield f"{path}{name}", value
        elif isinstance(value, Rating) or type(value).__name__ == "AxisRating":
            yield from readings(value, f"{path}{name}.")


def test_every_formula_agrees_with_its_unit(monkeypatch: pytest.MonkeyPatch) -> None:
    requirements = Requirements.model_validate({"sigma": 0.6})
    # Not the paper's masses: printed numbers would not scale.
    dimensions = Dimensions.model_validate(
        {"sigma": 0.6, "x": {"mass": 4.0, "platform_mass": 3.0}, "y": {"mass": 9.0}}
    )
    before = dict(readings(size(requirements))), dict(readings(rate(dimensions)))
    monkeypatch.setattr(eq, "MU_0", eq.MU_0 * scale("H/m"))
    after = (
        dict(readings(size(Requirements.model_validate(scaled(requirements))))),
        dict(readings(rate(Dimensions.model_validate(scaled(dimensions))))),
    )
    assert (len(before[0]), len(before[1])) == (14, 17 + 2 * 5)
    for then, now in zip(before, after, strict=True):
        for key, reading in then.items():
            for which in ("value", "printed_value"):
                value, found = getattr(reading, which), getattr(now[key], which)
                if value is None:
                    assert found is None, key
                else:
                    assert found == pytest.approx(value * scale(reading.unit), rel=1e-9), key


@pytest.mark.parametrize("table", ["requirements", "dimensions"])
@pytest.mark.parametrize("p", [1e-6, 0.3e-3, 6.9e-3, 7.199e-3])
def test_a_ratio_that_follows_has_the_range_of_one_that_is_given(table: str, p: float) -> None:
    with pytest.raises(ConfigError, match=r"must be >= 0\.05 and <= 20, as sigma"):
        design({table: {"p": p}})


@given(st.floats(0.05, 20))
def test_what_is_answered_may_be_asked(sigma: float) -> None:
    for asked in ({"sigma": sigma}, {"p": 7.2e-3 * sigma / (1 + sigma)}):
        try:
            found = design({"dimensions": asked, "requirements": asked})
        except ConfigError:  # at an end of the range, by rounding
            assert "sigma" not in asked
            continue
        again = {
            "dimensions": found.dimensions.model_dump(by_alias=True),  # type: ignore[union-attr]
            "requirements": found.requirements.model_dump(by_alias=True),
        }
        assert design(again).model_dump() == found.model_dump()


def test_a_whole_number_may_have_a_point() -> None:
    for field, value in (("N", 145), ("n", 3), ("limbs", 2)):
        with_point = design({"dimensions": {field: float(value)}})
        assert with_point == design({"dimensions": {field: value}})
        with pytest.raises(ConfigError, match="must be a whole number"):
            design({"dimensions": {field: value + 0.5}})


# -- closed forms ---------------------------------------------------------------------------------


@given(st.integers(1, 50), st.floats(1e-3, 0.1), st.floats(0.05, 20))
def test_the_printed_K_1_is_that_of_one_limb(n: int, tau: float, sigma: float) -> None:
    one_limb = eq.mover_width(tau=tau, s=tau / (1 + sigma), n=n, limbs=1)
    printed = 2 * (n + n * sigma - 1) / (1 + sigma)
    assert eq.K_1(w=one_limb, tau=tau) == pytest.approx(printed, rel=1e-9)


@given(st.floats(0.1, 1e3), st.floats(0.01, 10), st.floats(0.1, 1e3))
def test_velocities_by_integrating_the_motion(f: float, stroke: float, M: float) -> None:
    a = eq.acceleration(f=f, M=M)
    half = math.sqrt(2 * (stroke / 2) / a)  # time to accelerate over half of the stroke
    assert eq.velocity_rest_to_rest(f=f, stroke=stroke, M=M) == pytest.approx(a * half)
    whole = math.sqrt(2 * stroke / a)
    assert eq.velocity_whole_stroke(f=f, stroke=stroke, M=M) == pytest.approx(a * whole)
    v = eq.velocity_rest_to_rest(f=f, stroke=stroke, M=M)
    assert eq.mass_for_velocity(f=f, stroke=stroke, v=v) == pytest.approx(M)
