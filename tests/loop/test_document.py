"""The loops of a scenario, over again while a slider moves one of them."""

from __future__ import annotations

from typing import Any

import pytest

from motionlab.config.load import load_scenario
from motionlab.loop import document
from motionlab.loop.document import loop_document
from motionlab.loop.margins import margins


def test_a_slider_moves_one_loop(monkeypatch: pytest.MonkeyPatch) -> None:
    before = loop_document(load_scenario("circle"))
    computed: list[Any] = []

    def counted(response: Any) -> Any:
        computed.append(response)
        return margins(response)

    monkeypatch.setattr(document, "margins", counted)
    moved = {"variants.B.controller.x.k_p": 287654.0}
    after = loop_document(load_scenario("circle", moved))
    assert len(computed) == 2  # sliding and at standstill, of B's x
    old, new = (each.variants["B"].axes for each in (before, after))
    assert (old["x"] != new["x"], old["y"] == new["y"]) == (True, True)
    assert before.variants["A"] == after.variants["A"]
    document._loop_of_axis.cache_clear()
    assert loop_document(load_scenario("circle", moved)) == after
