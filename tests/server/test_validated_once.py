"""A request validates its scenario once, and once more with each scheduled event."""

from __future__ import annotations

import asyncio
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import pytest

from motionlab.config.load import load_scenario
from motionlab.config.scenario import Scenario
from motionlab.server.live.clock import Clock
from motionlab.server.live.session import Session
from motionlab.server.routes.simulate import SimulateRequest, prepare_request
from motionlab.server.routes.whatif import WhatIfRequest, _answer
from motionlab.server.settings import Settings
from motionlab.simulation import whatif
from motionlab.simulation.prepare import prepare

GAIN = {"variants.B.controller.x.k_p": 312000.0}
EVENT = {"time": 3.0, "set": {"plant.x.friction.F_s": 4.5}}
RESOLVED = load_scenario("circle", {"trajectory.laps": 2}).model_dump(mode="json")
SOURCES = [
    ("circle", 1),
    (RESOLVED, 1),
    ({"base": "circle", "load": {"x": 1.0}}, 1),
    (RESOLVED | {"schedule": [EVENT]}, 2),
    ({"base": "circle", "schedule": [EVENT]}, 2),
]


class Alone:
    """A call without a server."""

    def hold(self, size: int) -> None:
        assert size >= 0


@pytest.fixture
def validations(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    validated: list[Any] = []
    validate = Scenario.model_validate

    def counted(tables: Any) -> Scenario:
        validated.append(tables)
        return validate(tables)

    monkeypatch.setattr(Scenario, "model_validate", counted)
    return validated


def answer(source: Any, changes: dict[str, float]) -> None:
    request = WhatIfRequest(scenario=source, set=changes, columns=["B.x.following_error"])
    _answer(Alone(), request, Settings())  # pyright: ignore[reportArgumentType]


@pytest.mark.parametrize(("source", "count"), SOURCES)
def test_a_what_if(validations: list[Any], source: Any, count: int) -> None:
    answer(source, GAIN)
    assert len(validations) == count


def test_a_what_if_from_a_state(validations: list[Any], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(whatif, "SOON", 0)
    answer(RESOLVED, GAIN)
    assert len(validations) == 2  # the unchanged one too, of which the state is
    answer(RESOLVED, {"variants.B.controller.x.k_p": 311000.0})
    assert len(validations) == 3


@pytest.mark.parametrize(("source", "count"), SOURCES)
def test_a_simulation(validations: list[Any], source: Any, count: int) -> None:
    prepare_request(SimulateRequest(scenario=source, set=GAIN), Settings())
    assert len(validations) == count


def test_a_change_of_a_session(validations: list[Any]) -> None:
    prepared = prepare(load_scenario("circle"))

    async def change() -> None:
        with ThreadPoolExecutor(1) as threads:
            clock = Clock()
            session = Session(prepared, clock, threads)
            validations.clear()
            await session.change(GAIN)
            clock.close()

    asyncio.run(change())
    assert len(validations) == 1
