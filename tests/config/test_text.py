"""No text that UTF-8 cannot hold is taken, whichever field it stands in."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

from motionlab.config.bounds import check_text
from motionlab.config.load import load_scenario
from motionlab.config.scenario import Scenario
from motionlab.errors import ConfigError

HALVES = ("\ud800", "a\udfff", "\udc80b", "\ude00\ud83d")


def texts(value: Any, path: str = "") -> Iterator[str]:
    """Yield the dotted path of every text of a document."""
    for key, item in value.items():
        if isinstance(item, dict):
            yield from texts(item, f"{path}{key}.")
        elif isinstance(item, str):
            yield f"{path}{key}"


DOCUMENT = load_scenario("circle").model_dump(mode="json")


@pytest.mark.parametrize("path", list(texts(DOCUMENT)))
@pytest.mark.parametrize("text", HALVES)
def test_every_text_of_a_scenario_refuses_half_a_pair(path: str, text: str) -> None:
    with pytest.raises(ConfigError) as refused:
        load_scenario("circle", {path: text})
    assert refused.value.errors[0].loc.startswith(path)
    str(refused.value).encode()


@pytest.mark.parametrize("path", ["plant.description", "plant.name", "variants.B.controller.name"])
def test_a_scheduled_change_refuses_it_too(path: str) -> None:
    event = {"time": 1.0, "set": {path: "\ud800"}}
    with pytest.raises(ConfigError):
        load_scenario(DOCUMENT | {"schedule": [event]})


def test_whole_pairs_and_other_scripts_are_text() -> None:
    text = "µm, 中文, 😀, é, \u200f"
    scenario: Scenario = load_scenario("circle", {"plant.description": text})
    assert scenario.plant.description == text


def test_keys_and_items_are_looked_at_and_named() -> None:
    for value, where in (
        ({"a": ["b", {"c": "\ud800"}]}, "x.a.1.c: "),
        ({"a": {"\udfff": 1}}, "x.a: "),
        ([1, "\ud800"], "x.1: "),
    ):
        with pytest.raises(ConfigError, match="surrogate") as refused:
            check_text(value, loc="x")
        assert str(refused.value).startswith(where)
    check_text({"a": ["😀", 1.0, None]}, loc="x")
