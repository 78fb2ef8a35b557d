"""Loops in the WebAssembly module against the server's."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings

from motionlab.config.load import load_scenario
from motionlab.config.scenario import Scenario
from motionlab.kernel.build import lane_parameters
from motionlab.kernel.layout import PARAMETERS, parameter_row
from motionlab.laws import LAWS
from motionlab.loop.document import loop_document
from motionlab.loop.family import LoopFamily
from motionlab.targets.wasm_compile import description
from motionlab.targets.wasm_math import FUNCTIONS
from tests.loop.drawn_loops import CHANGES
from tests.targets.module_loops import loops_in_module
from tests.targets.test_wasm import pytestmark as needs_node

pytestmark = needs_node

QUOTIENTS = ("published-k",)


def compare(scenario: Scenario) -> None:
    for (variant, axis), loop in loops_in_module(scenario).items():
        if scenario.variants[variant].controller.compensation.law in QUOTIENTS:
            continue
        family = LoopFamily.of(scenario, variant, axis)
        gains = getattr(scenario.variants[variant].controller, axis)
        radii = family.radii(np.array(gains.k_p), np.array(gains.k_d))
        assert loop.radii == pytest.approx(radii, rel=1e-7)
        if radii.max() < 1.0:
            figures = np.array(family.figures(gains.k_p, gains.k_d))
            assert loop.worst[:, 0] == pytest.approx(figures[:, 0], rel=1e-7)
            assert loop.worst[:, 1] == pytest.approx(figures[:, 1], rel=1e-5)
        limits = np.array(family.limits(gains.k_p, gains.k_d), dtype=float)
        assert loop.limits == pytest.approx(limits, rel=2e-4, nan_ok=True)


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("circle", {}),
        ("circle-reversed-k", {}),
        ("circle-resonant", {}),
        ("pentagram", {}),
        ("circle", {"plant.force_map": "new-design"}),
        ("circle", {"plant": "matched", "variants.A.controller.sharing.law": "sine"}),
        ("circle", {"plant.force": "ideal"}),
    ],
)
def test_margins_are_the_servers(name: str, changes: dict[str, Any]) -> None:
    compare(load_scenario(name, changes))


@settings(max_examples=6, deadline=None)
@given(changes=CHANGES)
def test_margins_of_drawn_loops_are_the_servers(changes: dict[str, Any]) -> None:
    compare(load_scenario("circle", changes))


@pytest.mark.parametrize("share", [0.0, 0.5])
@pytest.mark.parametrize("law", LAWS)
def test_laws_that_are_quotients_are_refused(law: str, share: float) -> None:
    compensation = "variants.A.controller.compensation"
    changes: dict[str, Any] = {f"{compensation}.law": law}
    if law == "reversed-k":
        changes[f"{compensation}.k_d_share"] = share
    scenario = load_scenario("circle", changes)
    lanes, quotients = lane_parameters(scenario)[0, :, 0], description()["quotients"]
    rows = quotients["laws"][int(lanes[parameter_row("compensation.law")])]
    enabled = lanes[parameter_row("compensation.enabled")] > 0.0
    refused = enabled and any(lanes[PARAMETERS.index(row)] > 0.0 for row in rows)
    note = loop_document(scenario).variants["A"].note
    assert (quotients["message"] if refused else None) == note


def test_functions_of_the_c_library() -> None:
    random = np.random.default_rng(1)
    x, y = random.uniform(-20.0, 20.0, (2, 2000))
    inputs = {
        "exp": (x,),
        "log": (np.exp(10.0 * x),),
        "sin": (0.15 * x,),
        "cos": (0.15 * x,),
        "atan2": (y, x),
        "acos": (x / 20.0,),
    }
    for function, parameters in FUNCTIONS.items():
        name = str(function.__name__)
        values = [function(*each) for each in zip(*inputs[name], strict=True)]
        known = {"atan2": "arctan2", "acos": "arccos"}.get(name) or name
        expected = getattr(np, known)(*inputs[name])
        assert len(inputs[name]) == parameters
        np.testing.assert_allclose(values, expected, rtol=1e-14, atol=1e-15, err_msg=name)
