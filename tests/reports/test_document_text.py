"""The text of a document: every figure with its unit, every note, no curve."""

from __future__ import annotations

from typing import Any

import pytest
from pydantic import BaseModel, Field

from motionlab.config.quantity import si
from motionlab.reports.document_text import document_text


class Peak(BaseModel):
    error: float | None = Field(description="Largest error, m; null where it diverged")
    time: float = Field(description="When, s")
    count: int
    share: float = si("Of all", "1", "%")


class Worst(BaseModel):
    value: float
    velocity: float = si("Where", "m/s")


class Part(BaseModel):
    unit: str
    value: float
    ratio: float = si("Over the true value", "1")


class Axis(BaseModel):
    F_c: float = Field(description="Coulomb friction, N")
    phase_margin: Worst | None = si("Worst; null where it is unstable", "rad", "deg")
    curve: list[float] = Field(description="Every sample, m")
    note: str = ""


class Document(BaseModel):
    name: str = "circle"
    version: str = Field(default="0.1", repr=False)
    feasible: bool = True
    axes: dict[str, Axis] = {}
    peaks: list[Peak] = []
    parts: dict[str, Part] = {}
    errors: dict[str, float | None] = Field(default={}, description="By axis, m")
    gone: dict[str, Axis | None] = Field(default={}, description="null where it diverged")
    set: dict[str, object] = {}


def cells(document: BaseModel) -> list[list[str]]:
    return [line.split() for line in document_text(document).splitlines()]


def test_a_document_alone_is_a_list() -> None:
    assert cells(Document()) == [["name", "circle"], ["feasible", "yes"]]


def test_records_that_are_few_stand_side_by_side() -> None:
    worst = Worst(value=0.5, velocity=2.5e-3)
    axis = Axis(F_c=0.24, phase_margin=worst, curve=[0.0] * 9, note="gains are published")
    stuck = axis.model_copy(update={"phase_margin": None, "note": ""})
    text = cells(Document(axes={"x": axis, "y": stuck}))[3:]
    assert text == [
        ["axes", "x", "y"],
        ["F_c", "mN", "240", "240"],
        ["phase", "margin", "deg", "28.65"],
        ["velocity", "mm/s", "2.5"],
        [],
        ["x", "note:", "gains", "are", "published"],
        ["y", "phase", "margin:", "none", "where", "it", "is", "unstable"],
    ]


def test_a_column_has_one_prefix_and_an_absent_number_is_a_dash() -> None:
    peaks = [Peak(error=2e-6, time=1.5, count=3, share=0.25)] * 4
    peaks += [Peak(error=None, time=0.5, count=4, share=0.5)]
    text = cells(Document(peaks=peaks))[3:]
    assert text[:3] == [
        ["peaks"],
        ["error", "time", "count", "share"],
        ["um", "s", "%"],
    ]
    assert text[3] == ["2", "1.5", "3", "25"]
    assert text[-1] == ["-", "0.5", "4", "50"]


def test_records_of_several_units_are_scaled_each() -> None:
    parts = {
        name: Part(unit=unit, value=value, ratio=1.0)
        for name, unit, value in (("M", "kg", 5.9), ("v_s", "m/s", 0.0436), ("k", "N/m", 1.2e5))
    }
    text = cells(Document(parts=parts))[3:]
    assert text == [
        ["parts", "value", "ratio"],
        ["M", "kg", "5.9", "1"],
        ["v_s", "mm/s", "43.6", "1"],
        ["k", "kN/m", "120", "1"],
    ]


def test_what_is_missing_has_its_reason_and_settings_are_options() -> None:
    text = document_text(Document(gone={"A": None}, set={"seed": 7, "plant.x.mass": 4.5}))
    assert "A gone: none where it diverged" in text
    assert text.endswith("set:\n  --set seed=7\n  --set plant.x.mass=4.5")


def test_numbers_by_name_are_one_line() -> None:
    text = cells(Document(errors={"x": 2e-6, "y": None}))
    assert text[-1] == ["errors", "x", "2,", "y", "-", "um"]


def test_records_beside_numbers_are_records() -> None:
    class Open(BaseModel):
        value: Any

    text = document_text(
        Open(
            value={
                "b": 1.0,
                "a": {"c": [1, {"d": 3.0}]},
                "p": Peak(error=1e-6, time=1.0, count=1, share=0.5),
            }
        )
    )
    assert "count" in text


@pytest.mark.parametrize("value", [0.0, 1e-12, 123456.0, 1e12, float("inf")])
def test_no_size_of_a_number_fails(value: float) -> None:
    assert "F_c" in document_text(
        Document(axes={"x": Axis(F_c=value, phase_margin=None, curve=[])})
    )
