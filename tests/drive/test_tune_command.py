"""``motionlab drive tune``: what moves only after a person has agreed, and when it stops."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

from motionlab.cli.main import main
from motionlab.drive import command
from motionlab.errors import DONE
from motionlab.studies.safe_tune.documents import (
    Examined,
    LeastMargins,
    MotionMade,
    NextMotion,
    SafeTuneDocument,
)

IN_PHASE = {"phase_locked": True}
NONE = LeastMargins(gain_margin=None, phase_margin=None)


def document(motions: list[MotionMade]) -> dict[str, Any]:
    proposal = NextMotion(
        k_p=2e5 * (1 + len(motions)),
        k_d=1500.0,
        changes={"variants.B.controller.x.k_p": 2e5 * (1 + len(motions))} if motions else {},
        expected=1e-6,
        error_high=2e-6,
        force_high=5.0,
        margins=NONE,
        plausible=NONE,
        improvement=0.3,
        beyond=True,
        text="beyond every motion made",
    )
    return SafeTuneDocument(
        error=1e-5,
        force=36.0,
        motions=motions,
        proposal=proposal,
        ended="",
        best=0 if motions else None,
        changes={},
        examined=Examined(k_p=[], k_d=[], refused=[], expected=[]),
        warnings=[],
    ).model_dump(mode="json")


class FakeServer:
    """A server whose machine goes beyond its limits in the second motion."""

    def __init__(self, _url: str) -> None:
        self.calls: list[str] = []
        self.sets: list[dict[str, Any]] = []
        self.runs: list[str] = []

    def call(self, method: str, path: str, body: Any = None, headers: Any = None) -> dict[str, Any]:
        self.calls.append(f"{method} {path}")
        if path == "/safe-tune":
            self.runs = body["runs"]
            self.sets.append(body["set"])
        fixed: dict[str, dict[str, Any]] = {
            "/drive/lease": {"lease": "token", "seconds": 60.0},
            "/drive": {"state": self._state, "fault": None, "problem": "", "loop": IN_PHASE},
            "/drive/motions": {"id": "s"},
            "/sessions/s": {"state": "finished", "run": f"r-{len(self.runs)}", "id": "s"},
            "/jobs/j": {"id": "j", "state": "done", "error": None, "result": self._result},
        }
        return fixed.get(path, {"id": "j", "state": "complete"})

    @property
    def _state(self) -> str:
        armed = [each for each in self.calls if each in {"POST /drive/arm", "POST /drive/stop"}]
        return "holding" if armed and armed[-1].endswith("arm") else "ready"

    @property
    def _result(self) -> dict[str, Any]:
        made = [
            MotionMade(
                run=run, k_p=2e5, k_d=1500.0, metric=1e-6, error=1e-6, force=5.0, within=k != 1
            )
            for k, run in enumerate(self.runs)
        ]
        return document(made)


@pytest.fixture
def server(monkeypatch: pytest.MonkeyPatch) -> FakeServer:
    fake = FakeServer("")
    monkeypatch.setattr(command, "LabServer", lambda _url: fake)
    return fake


def answer(monkeypatch: pytest.MonkeyPatch, *texts: str) -> None:
    answers: Iterator[str] = iter(texts)

    def reply(_prompt: str) -> str:
        try:
            return next(answers)
        except StopIteration:
            raise EOFError from None

    monkeypatch.setattr("builtins.input", reply)


LINE = ["drive", "tune", "circle", "--axis", "x"]


@pytest.mark.parametrize("texts", [(), ("n",), ("",), ("maybe",)])
def test_nothing_moves_without_a_yes(
    monkeypatch: pytest.MonkeyPatch, server: FakeServer, texts: tuple[str, ...]
) -> None:
    answer(monkeypatch, *texts)
    assert main(LINE) == DONE
    assert not {"POST /drive/arm", "POST /drive/motions"} & set(server.calls)


def test_each_motion_is_agreed_to_and_one_beyond_its_limits_stops_the_drives(
    monkeypatch: pytest.MonkeyPatch, server: FakeServer
) -> None:
    answer(monkeypatch, "y", "yes", "n")
    assert main(LINE) == DONE
    orders = [each for each in server.calls if each.startswith("POST /drive/")]
    motions = ["POST /drive/arm", "POST /drive/motions", "POST /drive/motions"]
    assert orders == ["POST /drive/lease", *motions, "POST /drive/stop"]
    assert all(each["variants.B.controller.delay"] == 1 for each in server.sets)
