"""Steps of commissioning: their order, their checks, and the document of what they found."""

from __future__ import annotations

import errno
import math
from pathlib import Path
from typing import Any
from unittest.mock import Mock

import pytest
from pydantic import ValidationError

from motionlab.drive.commissioning.checks import (
    ByHand,
    compare_identity,
    find_drives,
    judge_encoders,
)
from motionlab.drive.commissioning.record import (
    ORDER,
    CommissioningRecord,
    ConfigChange,
    Finding,
    FoundFigure,
    in_effect,
)
from motionlab.drive.commissioning.steps import Commissioning
from motionlab.drive.link.carrier import LinkError
from motionlab.drive.virtual.segment import default_drive
from motionlab.errors import ConfigError, StoreError


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
            "limits": [],
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
    steps.put("drives", find_drives(default_drive(), found()))
    steps.put("identity", compare_identity(default_drive(), found()))


def test_each_step_waits_for_those_before_it(steps: Commissioning) -> None:
    assert steps.present == "drives"
    with pytest.raises(LinkError, match="Find drives comes first"):
        steps.begin("encoders")
    two_done(steps)
    assert steps.present == "encoders"
    steps.put("encoders", judge_encoders(default_drive(), pushed(1e-3, 1e-3)))
    assert steps.present == "currents"


def test_doing_a_step_again_forgets_those_after_it(steps: Commissioning) -> None:
    two_done(steps)
    steps.put("encoders", judge_encoders(default_drive(), pushed(1e-3, 1e-3)))
    steps.put("drives", find_drives(default_drive(), found()))
    assert list(steps.record.findings) == ["drives"]
    assert steps.present == "identity"


def test_a_missing_drive_holds_up_what_follows(steps: Commissioning) -> None:
    finding = find_drives(default_drive(), found()[:5])
    assert not finding.holds
    assert finding.text.startswith("5 of 6 found")
    steps.put("drives", finding)
    with pytest.raises(LinkError, match="Find drives comes first"):
        steps.begin("identity")


@pytest.mark.parametrize("change", [{"vendor": 1}, {"product": 2}, {"rated_current": 5.0}])
def test_another_drive_than_expected(steps: Commissioning, change: dict[str, Any]) -> None:
    finding = compare_identity(default_drive(), found(**change))
    assert [row.holds for row in finding.rows] == [True, True, False, True, True, True]
    assert not finding.holds
    assert finding.rows[2].found != finding.rows[2].expected
    assert finding.text == "5 of 6 match; 10 A rated; 0 of 0 limits as asked for"


def test_directions_of_encoders(steps: Commissioning) -> None:
    right = judge_encoders(default_drive(), pushed(0.6e-3, 0.7e-3))
    assert (right.holds, right.changes, right.text) == (True, [], "both signs right")
    wrong = judge_encoders(default_drive(), pushed(0.6e-3, -0.7e-3))
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


def test_a_damaged_document_is_put_aside_and_told(
    steps: Commissioning, file: Path, caplog: pytest.LogCaptureFixture
) -> None:
    two_done(steps)
    file.write_text("damaged")
    again = Commissioning(default_drive(), file)
    assert again.present == "drives"
    assert again.damage in caplog.text
    assert "none of its changes is in effect" in again.damage
    again.put("drives", find_drives(default_drive(), found()))
    assert file.with_suffix(".damaged.json").read_text() == "damaged"
    assert again.damage == ""


def test_what_cannot_be_kept_does_not_take_effect(
    steps: Commissioning, monkeypatch: pytest.MonkeyPatch
) -> None:
    changes = wrong_way(steps)
    before = steps.record
    full = OSError(errno.ENOSPC, "No space left on device")
    with monkeypatch.context() as patch:
        patch.setattr("motionlab.drive.commissioning.steps.replace", Mock(side_effect=full))
        with pytest.raises(StoreError, match="cannot be written"):
            steps.take("encoders", changes)
        taken = [changes[0].model_copy(update={"now": 1.0})]
        with pytest.raises(StoreError, match="cannot be written"):
            steps.load(CommissioningRecord(link=before.link, taken=taken))
    assert (steps.config, steps.record) == (default_drive(), before)
    steps.take("encoders", changes)
    assert steps.config.y.direction == -1


def test_a_document_that_could_not_be_read_again_is_not_taken(steps: Commissioning) -> None:
    row = FoundFigure(name="n" * 1000, found="", expected="", holds=True)
    long = Finding(at=0.0, holds=True, text="", rows=[row] * 64)
    record = CommissioningRecord(link=steps.record.link, findings=dict.fromkeys(ORDER, long))
    with pytest.raises(ConfigError, match=r"findings: the document is too long; .* <= 100000 B"):
        steps.load(record)
    assert steps.record.findings == {}
    with pytest.raises(ValidationError, match="finite number"):
        Finding(at=math.nan, holds=True, text="")


def test_a_direction_is_no_fraction(steps: Commissioning) -> None:
    for value in (-1.5, 1e300):
        change = ConfigChange(path="x.direction", now=1.0, then=value)
        with pytest.raises(ConfigError, match=r"x.direction: is not one of the choices"):
            steps.load(CommissioningRecord(link=steps.record.link, taken=[change]))


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


def wrong_way(steps: Commissioning) -> list[ConfigChange]:
    """Have y count the wrong way, and return the changes that are shown."""
    two_done(steps)
    finding = judge_encoders(steps.config, pushed(1e-3, -1e-3))
    steps.put("encoders", finding)
    return finding.changes


def test_only_the_changes_that_are_shown_are_taken(steps: Commissioning, file: Path) -> None:
    (change,) = wrong_way(steps)
    for others in (
        [],
        [change, change],
        [change.model_copy(update={"then": 1.0})],
        [change.model_copy(update={"path": "x.direction"})],
    ):
        with pytest.raises(LinkError, match="not the changes that Encoders"):
            steps.take("encoders", others)
    assert steps.config == default_drive()
    steps.take("encoders", [change])
    assert steps.config.y.direction == -1
    assert steps.config.x == default_drive().x
    assert steps.present == "encoders"  # it is to be done again
    with pytest.raises(LinkError, match="not the changes that Encoders"):
        steps.take("encoders", [change])
    assert Commissioning(default_drive(), file).config == steps.config


def test_a_change_that_is_taken_back_leaves_the_file_as_it_is(steps: Commissioning) -> None:
    steps.take("encoders", wrong_way(steps))
    finding = judge_encoders(steps.config, pushed(1e-3, -1e-3))
    assert [(c.now, c.then) for c in finding.changes] == [(-1.0, 1.0)]
    steps.put("encoders", finding)
    steps.take("encoders", finding.changes)
    assert steps.record.taken == []
    assert steps.config == default_drive()


def test_a_change_of_a_value_that_was_edited_since_is_left_out(
    steps: Commissioning, file: Path
) -> None:
    steps.take("encoders", wrong_way(steps))
    edited = in_effect(default_drive(), steps.record.taken)
    again = Commissioning(edited, file)
    assert again.record.taken == []
    assert again.config == edited
    with pytest.raises(LinkError, match=r"changes y.direction = 1; the file of the link has -1"):
        again.load(steps.record)


def test_a_document_brings_its_changes(steps: Commissioning) -> None:
    steps.take("encoders", wrong_way(steps))
    record = steps.record
    steps.load(CommissioningRecord(link=record.link))
    assert steps.config == default_drive()
    steps.load(record)
    assert steps.config.y.direction == -1
    far = ConfigChange(path="x.offset", now=0.0, then=5.0)
    with pytest.raises(ConfigError, match=r"x.offset"):
        steps.load(record.model_copy(update={"taken": [far]}))
    assert steps.config.y.direction == -1


def test_limits_stand_beside_those_that_were_asked_for() -> None:
    name = "object 6072:00, largest torque, per mille of rated"
    drives = found(limits=[{"name": name, "asked": 1000, "read": 900}])
    finding = compare_identity(default_drive(), drives)
    (row,) = (row for row in finding.rows if not row.holds)
    assert (row.name, row.found, row.expected) == (f"3 x c, {name}", "900", "1000")
    assert finding.text == "6 of 6 match; 10 A rated; 0 of 1 limits as asked for"
    assert not finding.holds
