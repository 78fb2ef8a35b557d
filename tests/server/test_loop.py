"""The loop over REST is that of the functions, and says where there is none."""

from __future__ import annotations

import httpx
import pytest

from motionlab.config.load import load_scenario
from motionlab.loop.family import Figures, LoopFamily, stability_limits
from motionlab.loop.linearise import linearise
from motionlab.loop.margins import margins
from tests.server.live import API

GAIN = {"variants.A.controller.x.k_p": 3_200_000.0, "variants.A.controller.x.k_d": 1500.0}


def test_margins_and_limits(client: httpx.Client) -> None:
    answer = client.post(f"{API}/loop", json={"set": GAIN}).json()["variants"]
    scenario = load_scenario("circle", GAIN)
    for variant, axis in (("A", "x"), ("A", "y"), ("B", "x"), ("B", "y")):
        loop = answer[variant]["axes"][axis]
        v = 4.0 * getattr(scenario.plant, axis).friction.v_s
        assert loop["velocity"] == pytest.approx(v)
        assert loop["stable"]
        found = vars(margins(linearise(scenario, variant, axis, v=v).open))
        assert {key: loop[key] for key in found} == pytest.approx(found)
        limits = stability_limits(scenario, variant, axis)
        assert (loop["k_p_limit"], loop["k_d_limit"]) == pytest.approx(tuple(limits.values()))


def test_the_worst_margins_are_those_that_tune_and_why_judge(client: httpx.Client) -> None:
    # The second question differs in gains alone, and the third in the motor.
    for changes in ({}, {"variants.A.controller.x.k_p": 5e5}, {"plant.x.mass": 7.0}):
        answer = client.post(f"{API}/loop", json={"set": changes}).json()["variants"]
        scenario = load_scenario("circle", changes)
        for variant, axis in (("A", "x"), ("A", "y"), ("B", "x"), ("B", "y")):
            gains = getattr(scenario.variants[variant].controller, axis)
            expected = LoopFamily.of(scenario, variant, axis).figures(gains.k_p, gains.k_d)
            worst = answer[variant]["axes"][axis]["worst"]
            assert worst["stable"]
            for name in Figures._fields:
                at = getattr(expected, name)
                assert worst[name] == pytest.approx({"value": at.value, "velocity": at.velocity})


def test_an_unstable_loop_is_told_from_its_limit(client: httpx.Client) -> None:
    high = {"variants.A.controller.x.k_p": 6e6}
    loop = client.post(f"{API}/loop", json={"set": high}).json()["variants"]["A"]["axes"]["x"]
    assert not loop["stable"]
    assert loop["k_p_limit"] < 6e6
    assert not loop["worst"]["stable"]
    assert [loop["worst"][name] for name in Figures._fields] == [None] * 3


def test_the_published_law_has_none(client: httpx.Client) -> None:
    body = {"scenario": "circle-published-k"}
    answer = client.post(f"{API}/loop", json=body).json()["variants"]
    assert answer["B"]["axes"] == {}
    assert "no linearisation" in answer["B"]["note"]
    assert answer["A"]["note"] is None
