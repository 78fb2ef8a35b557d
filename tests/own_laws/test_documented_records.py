"""The pages on laws and effects of one's own list every field that these may read or give."""

from __future__ import annotations

import re
from typing import Any

import pytest

from motionlab.declarations import field_comments
from motionlab.effects.effect import MidStep, Resistance
from motionlab.laws.law import Estimate, Seen
from motionlab.plant.friction import LuGre
from tests.paths import ROOT

PAGES = {"own-law.md": (Seen, LuGre, Estimate), "own-effect.md": (MidStep, Resistance)}
UNITS = {"m", "m/s", "m/s^2", "N", "N/m", "N s/m", "kg", "s", "A"}
EACH = [(page, record) for page, records in PAGES.items() for record in records]


@pytest.mark.parametrize(("page", "record"), EACH, ids=lambda each: getattr(each, "__name__", ""))
def test_every_field_is_listed_with_its_unit(page: str, record: Any) -> None:
    text = (ROOT / "docs" / page).read_text()
    table = text.partition(f"| `{record.__name__}` | | unit |")[2].partition("\n\n")[0]
    units: dict[str, str] = {}
    for names, unit in re.findall(r"^\| (`.+`) \|.*\| ?(.*) \|$", table, re.MULTILINE):
        fields = re.findall(r"`(\w+)`", names)
        units |= dict(zip(fields, unit.split(", "), strict=True))
    assert sorted(units) == sorted(record._fields)
    for name, comment in field_comments(record).items():
        known = UNITS & set(re.split("[,;] ", comment))
        assert known <= {units[name]} and (known or not comment or units[name] in {"", "1"}), name
