"""Steps of commissioning: their order, their checks, and the document of what they found."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from motionlab.drive.commissioning import ByHand, Commissioning, CommissioningRecord
from motionlab.drive.link.carrier import LinkError
from motionlab.drive.virtual.segment import default_drive


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "commissioning.json"


@pytest.fixture
def steps(file: Path) -> Commissioning:
    return Commissioning(default_drive(), file)


def found(**changes: Any) -> list[dict[str, Any]]:
    """Return what the configured drives say of themselves, with changes of the third."""
    drives = [
        {
            "vendor": node.vendor,
            "product": node.product,
            "revision": 1,
            "serial": number,
            "name": "drive",
            "rated_current": node.rated_current,
        }
        for number, node in enumerate(default_drive().nodes, start=1)
    ]
    drives[2] |= changes
    return drives


def pushed(x: float, y: float) -> ByHand:
    by_hand = ByHand((0.01, -0.02))
    by_hand.note((0.01 + x, -0.02 + y))
    return by_hand


def two_done(steps: Commissioning) -> None:
    steps.put("drives", steps.find_drives(found()))
    steps.put("identity", steps.compare_identity(found()))


def test_each_step_waits_for_those_before_it(steps: Commissioning) -> None:
    assert steps.present == "drives"
    with pytest.raises(LinkError, match="Find drives comes first"):
        steps.begin("encoders")
    two_done(steps)
    assert steps.present == "encoders"
    steps.put("encoders", steps.judge_encoders(pushed(1e-3, 1e-3)))
    assert steps.present is None


def test_doing_a_step_again_forgets_those_after_it(steps: Commissioning) -> None:
    two_done(steps)
    steps.put("encoders", steps.judge_encoders(pushed(1e-3, 1e-3)))
    steps.put("drives", steps.find_drives(found()))
    assert list(steps.record.findings) == ["drives"]
    assert steps.present == "identity"


def test_a_missing_drive_holds_up_what_follows(steps: Commissioning) -> None:
    finding = steps.find_drives(found()[:5])
    assert not finding.holds
    assert finding.text.startswith("5 of 6 found")
    steps.put("drives", finding)
    with pytest.raises(LinkError, match="Find drives comes first"):
        steps.begin("identity")


@pytest.mark.parametrize("change", [{"vendor": 1}, {"product": 2}, {"rated_current": 5.0}])
def test_another_drive_than_expected(steps: Commissioning, change: dict[str, Any]) -> None:
    finding = steps.compare_identity(found(**change))
    assert [row.holds for row in finding.rows] == [True, True, False, True, True, True]
    assert not finding.holds
    assert finding.rows[2].found != finding.rows[2].expected
    assert finding.text == "5 of 6 match; 10 A rated"


def test_directions_of_encoders(steps: Commissioning) -> None:
    right = steps.judge_encoders(pushed(0.6e-3, 0.7e-3))
    assert (right.holds, right.changes, right.text) == (True, [], "both signs right")
    wrong = steps.judge_encoders(pushed(0.6e-3, -0.7e-3))
    assert not wrong.holds
    assert wrong.text == "y counts the wrong way"
    assert [change.model_dump() for change in wrong.changes] == [
        {"path": "y.direction", "now": 1.0, "then": -1.0}
    ]


def test_the_first_move_tells_the_direction() -> None:
    by_hand = ByHand((0.0, 0.0))
    for x, y in ((0.4e-3, -0.4e-3), (0.55e-3, -0.1e-3), (-2e-3, 0.0)):
        by_hand.note((x, y))
    assert by_hand.travel == [0.55e-3, None]
    assert not by_hand.complete
    by_hand.note((0.0, -0.5e-3))
    assert by_hand.complete


def test_the_document_outlives_the_server(steps: Commissioning, file: Path) -> None:
    two_done(steps)
    again = Commissioning(default_drive(), file)
    assert again.record == steps.record
    assert again.present == "encoders"
    other = default_drive().model_copy(update={"title": "another"})
    assert Commissioning(other, file).present == "drives"
    file.write_text("damaged")
    assert Commissioning(default_drive(), file).present == "drives"


def test_a_document_is_loaded_as_far_as_its_steps_follow(steps: Commissioning) -> None:
    two_done(steps)
    record = steps.record
    findings = {name: record.findings[name] for name in ("identity",)}
    steps.load(record.model_copy(update={"findings": findings}))
    assert steps.present == "drives"
    steps.load(record)
    assert steps.present == "encoders"
    with pytest.raises(LinkError, match="of the link 'another'"):
        steps.load(CommissioningRecord(link="another"))
    assert steps.present == "encoders"
