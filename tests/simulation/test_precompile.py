"""Steps of compiling: all are taken, each is reported after the share of the work."""

from __future__ import annotations

import pytest

from motionlab.simulation import precompile
from motionlab.simulation.precompile import Step


def test_each_step_is_reported_when_it_is_done() -> None:
    taken: list[str] = []
    steps = [
        Step("first", lambda: taken.append("first"), 3.0),
        Step("second", lambda: taken.append("second"), 1.0),
    ]
    told: list[tuple[float, str, int]] = []
    precompile._take(steps, lambda share, name: told.append((share, name, len(taken))))
    assert told == [(0.75, "first", 1), (1.0, "second", 2)]


def test_what_a_first_use_needs_is_reported_up_to_its_end() -> None:
    shares: list[float] = []
    precompile.first_use(shares.append)
    assert shares == sorted(shares)
    assert shares[-1] == 1.0


def test_without_numba_there_is_nothing_to_compile(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("numba.config.DISABLE_JIT", True)
    precompile.first_use(lambda _: pytest.fail("a step was taken"))
    assert precompile.batches_compiled()
