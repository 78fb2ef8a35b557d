"""What a law's step has that lanes do not have is said before it is compiled or exported."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from typing import Any

import pytest

from motionlab.cli import main
from motionlab.config.load import load_scenario
from motionlab.errors import ConfigError
from motionlab.lanes import select
from motionlab.laws import LAWS
from motionlab.laws.law import Estimate, NoState, Seen
from motionlab.targets.record_law import lane_error

STATELESS = dataclasses.replace(LAWS["off"], State=NoState)


def branch(par: Any, state: NoState, seen: Seen) -> tuple[Estimate, NoState]:
    force = 1.0 if seen.v > 0.0 else -1.0
    return Estimate(force, 0.0, 0.0), state


def both(par: Any, state: NoState, seen: Seen) -> tuple[Estimate, NoState]:
    force = select(seen.v > 0.0 and seen.v_ref > 0.0, 1.0, -1.0)
    return Estimate(force, 0.0, 0.0), state


def square(par: Any, state: NoState, seen: Seen) -> tuple[Estimate, NoState]:
    force = seen.v
    force **= 2
    return Estimate(force, 0.0, 0.0), state


def squared_number(par: Any, state: NoState, seen: Seen) -> tuple[Estimate, NoState]:
    return Estimate(seen.v * 3.0**2, 0.0, 0.0), state


def forever(par: Any, state: NoState, seen: Seen) -> tuple[Estimate, NoState]:
    force = seen.v
    while True:
        force = force + 1.0
    return Estimate(force, 0.0, 0.0), state


def long(par: Any, state: NoState, seen: Seen) -> tuple[Estimate, NoState]:
    force = seen.v
    for turn in range(10**9):
        force = force + turn
    return Estimate(force, 0.0, 0.0), state


def endless(par: Any, state: NoState, seen: Seen) -> tuple[Estimate, NoState]:
    return endless(par, state, seen)


def printing(par: Any, state: NoState, seen: Seen) -> tuple[Estimate, NoState]:
    print(1)
    return Estimate(seen.v, 0.0, 0.0), state


def tangent(par: Any, state: NoState, seen: Seen) -> tuple[Estimate, NoState]:
    return Estimate(math.tanh(seen.v), 0.0, 0.0), state


def half(par: Any, state: NoState, seen: Seen) -> Estimate:
    return Estimate(seen.v, 0.0, 0.0)


def two(par: Any, state: NoState) -> tuple[Estimate, NoState]:
    return Estimate(0.0, 0.0, 0.0), state


@pytest.mark.parametrize(
    ("step", "reason"),
    [
        (branch, "lanes are used as true or false, which differs from lane to lane: select"),
        (both, "lanes are used as true or false"),
        (square, "lanes have no powers, not even squares: write a product"),
        (forever, "while: a loop has a number of turns that is known"),
        (long, "loops turn more than 10000 times"),
        (endless, "calls itself"),
        (printing, "print(1): a call without use of its result"),
        (tangent, "math.tanh: of math lanes have exp, sqrt, sin, cos, pi, inf"),
        (half, "returns no (Estimate, NoState)"),
        (two, "takes 2 arguments, not 3"),
    ],
)
def test_what_lanes_do_not_have(step: Callable[..., Any], reason: str) -> None:
    error = lane_error(dataclasses.replace(STATELESS, step=step))
    assert error.startswith(f"{step.__name__} in {step.__module__}: "), error
    assert reason in error


@pytest.mark.parametrize("law", LAWS.values(), ids=lambda law: law.name)
def test_every_law_is_made_of_lanes(law: Any) -> None:
    assert lane_error(law) == ""


def test_a_number_may_be_squared() -> None:
    assert lane_error(dataclasses.replace(STATELESS, step=squared_number)) == ""


def test_runs_and_exports_say_it_alike(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Any
) -> None:
    monkeypatch.setitem(LAWS, "published-k", dataclasses.replace(STATELESS, step=branch))
    law = "variants.B.controller.compensation.law"
    with pytest.raises(ConfigError, match=f"^{law}: is not made of lanes: branch in "):
        load_scenario("circle", {law: "published-k"})
    messages = set()
    for words in (["run", "circle"], ["export-controller", "circle", "-o", str(tmp_path / "new")]):
        assert main([*words, f"--set={law}=published-k"]) == 2
        messages.add(capsys.readouterr().err)
    (message,) = messages
    assert message.endswith("; got 'published-k'\n")  # which is one of the choices
