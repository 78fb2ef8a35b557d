"""The challenge is frozen: its digest, what it covers, and the keys of its document."""

from __future__ import annotations

import dataclasses
from typing import Any

import pytest

from motionlab.config.named_configs import names
from motionlab.simulation.prepare import prepare
from motionlab.studies.challenge.definition import definition
from motionlab.studies.challenge.documents import ChallengeDocument

DIGESTS = {1: "9dcd84026062f8e86af031bfd7a61a737fa97ab3e790177dc6ad7398f02b15d7"}
"""By version. A new one comes with a new version; former ones stay here."""

KEYS = {
    "AxisDocument": "max_error rms_error rms_force rms_force_change",
    "ChallengeDocument": "challenge digest seed own_seed motors version model titles laws",
    "LawDocument": "rank law label description parameters shipped entered source verdict reasons "
    "score error motors effort gain_margin phase_margin scenarios",
    "MarginDocument": "value motor axis velocity",
    "MotorsDocument": "ratios median q95 diverged left_out",
    "ScenarioDocument": "axes error effort motors",
}
"""Of ``--json``: what others read; more may come, none may go."""

LAWS = [{"law": "off"}, {"law": "canudas-de-wit", "gain": 100.0}]


def test_its_digest_is_that_of_its_version() -> None:
    of = definition()
    assert of.digest() == DIGESTS[of.version]


@pytest.mark.parametrize(
    "changes",
    [
        {"seed": 1},
        {"motors": 31},
        {"margins": ("nominal",)},
        {"controller": definition().controller | {"feedforward": False}},
    ],
    ids=lambda changes: next(iter(changes)),
)
def test_its_digest_covers_what_decides(changes: dict[str, Any]) -> None:
    of = definition()
    assert dataclasses.replace(of, **changes).digest() != of.digest()


def test_words_do_not_count() -> None:
    of = definition()
    other = {name: tables | {"title": "other"} for name, tables in of.scenarios.items()}
    assert dataclasses.replace(of, scenarios=other).digest() == of.digest()


def test_it_has_ten_scenarios_that_can_be_run_under_one_controller() -> None:
    of = definition()
    assert len(of.scenarios) == 10
    assert of.motors == 30
    assert set(of.on_motors) <= of.scenarios.keys()
    assert set(of.margins) <= set(names("motors"))
    for name in of.scenarios:
        scenario = prepare(of.scenario(name, LAWS)).scenario
        off, other = (variant.controller for variant in scenario.variants.values())
        assert other.compensation.values()["gain"] == 100.0
        assert other.model_copy(update={"compensation": off.compensation}) == off
        assert off.feedforward
        assert not off.disturbance_observer.enabled


def test_its_document_keeps_its_keys() -> None:
    schema = ChallengeDocument.model_json_schema()
    models = schema["$defs"] | {"ChallengeDocument": schema}
    assert {name: " ".join(models[name]["properties"]) for name in models} == KEYS
