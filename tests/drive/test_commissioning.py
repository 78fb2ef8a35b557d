"""Steps of commissioning: their order, their checks, and the document of what they found."""

from __future__ import annotations

import errno
import json
import math
import stat
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any
from unittest.mock import Mock

import pytest
from pydantic import ValidationError

from motionlab.config.drive import DriveConfig
from motionlab.drive.commissioning import seal
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
    StepName,
    in_effect,
)
from motionlab.drive.commissioning.steps import Commissioning
from motionlab.drive.link.carrier import LinkError
from motionlab.drive.virtual.segment import default_drive
from motionlab.errors import ConfigError, StoreError

SERIALS = (1, 2, 3, 4, 5, 6)


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "commissioning.json"


@pytest.fixture
def steps(file: Path) -> Commissioning:
    return commissioned(file)


def commissioned(
    file: Path, config: DriveConfig | None = None, *, serials: Sequence[int] = SERIALS
) -> Commissioning:
    """Return the steps of a link that has found its drives."""
    steps = Commissioning(default_drive() if config is None else config, file)
    steps.follow(serials)
    return steps


def key_file(file: Path) -> Path:
    return file.with_suffix(".key")


def sealed(file: Path, record: CommissioningRecord, **changes: Any) -> CommissioningRecord:
    """Return a document with changes, as if this server had written it so."""
    key = seal.read_key(key_file(file))
    assert key is not None
    return seal.sealed(record.model_copy(update=changes), key)


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
    assert "none of its findings and changes is in effect" in again.damage
    again.follow(SERIALS)
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
        with pytest.raises(StoreError, match="cannot be written"):
            steps.load(CommissioningRecord(link=before.link))
    assert (steps.config, steps.record) == (default_drive(), before)
    steps.take("encoders", changes)
    assert steps.config.y.direction == -1


def test_a_document_that_could_not_be_read_again_is_not_kept(steps: Commissioning) -> None:
    row = FoundFigure(name="n" * 1000, found="", expected="", holds=True)
    long = Finding(at=0.0, holds=True, text="t" * 1000, rows=[row] * 64)
    steps.put("drives", long)
    with pytest.raises(ConfigError, match=r"findings: the document is too long; .* <= 100000 B"):
        steps.put("identity", long)
    with pytest.raises(ValidationError, match="finite number"):
        Finding(at=math.nan, holds=True, text="")


def test_a_direction_is_no_fraction() -> None:
    for value in (-1.5, 1e300):
        change = ConfigChange(path="x.direction", now=1.0, then=value)
        with pytest.raises(ConfigError, match=r"x.direction: is not one of the choices"):
            in_effect(default_drive(), [change])


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
    again = commissioned(file, edited)
    assert again.record.taken == []
    assert again.config == edited
    with pytest.raises(LinkError, match=r"changes y.direction = 1; the file of the link has -1"):
        again.load(steps.record)


def test_a_document_brings_its_changes(steps: Commissioning) -> None:
    steps.take("encoders", wrong_way(steps))
    record = steps.record
    steps.load(CommissioningRecord(link=record.link))
    assert steps.config == default_drive()
    assert steps.present == "drives"
    kept = json.loads(record.model_dump_json())
    reordered = json.dumps(dict(reversed(kept.items())))  # as another program writes it again
    steps.load(CommissioningRecord.model_validate_json(reordered))
    assert steps.config.y.direction == -1
    assert steps.present == "encoders"


def without(*names: StepName) -> Callable[[CommissioningRecord], CommissioningRecord]:
    def removed(record: CommissioningRecord) -> CommissioningRecord:
        kept = {name: each for name, each in record.findings.items() if name not in names}
        return record.model_copy(update={"findings": kept})

    return removed


def flipped(record: CommissioningRecord) -> CommissioningRecord:
    finding = record.findings["commutation"]
    done = finding.model_copy(update={"holds": True})
    return record.model_copy(update={"findings": record.findings | {"commutation": done}})


def moved(record: CommissioningRecord) -> CommissioningRecord:
    """Change the offset that is in effect in its last digit."""
    (change,) = record.taken
    other = change.model_copy(update={"then": math.nextafter(change.then, 1.0)})
    return record.model_copy(update={"taken": [other]})


def changed_too(record: CommissioningRecord) -> CommissioningRecord:
    more = ConfigChange(path="y.direction", now=1.0, then=-1.0)
    return record.model_copy(update={"taken": [*record.taken, more]})


def of_another_key(record: CommissioningRecord) -> CommissioningRecord:
    return seal.sealed(record, b"k" * 32)


FORGED: dict[str, Callable[[CommissioningRecord], CommissioningRecord]] = {
    "holds": flipped,
    "offset": moved,
    "another change": changed_too,
    "no change": lambda record: record.model_copy(update={"taken": []}),
    "a finding of the middle": without("identity"),
    "the last finding": without("commutation"),
    "no finding": without(*ORDER),
    "no seal": lambda record: record.model_copy(update={"seal": ""}),
    "another key": of_another_key,
    "other serials": lambda record: record.model_copy(update={"serials": [7, 2, 3, 4, 5, 6]}),
    "other link": lambda record: record.model_copy(update={"link": "another"}),
}


@pytest.fixture
def shown(steps: Commissioning) -> CommissioningRecord:
    """Return a document with an offset in effect and a commutation that does not hold."""
    two_done(steps)
    steps.put("encoders", judge_encoders(default_drive(), pushed(1e-3, 1e-3)))
    steps.put("currents", Finding(at=0.0, holds=True, text="all follow"))
    change = ConfigChange(path="x.offset", now=0.0, then=0.0012)
    steps.put("commutation", Finding(at=0.0, holds=False, text="x is off", changes=[change]))
    steps.take("commutation", [change])
    steps.put("commutation", Finding(at=0.0, holds=False, text="x does not follow"))
    return steps.record


@pytest.mark.parametrize("forge", FORGED.values(), ids=FORGED)
def test_a_document_that_was_changed_is_not_taken(
    steps: Commissioning,
    shown: CommissioningRecord,
    file: Path,
    forge: Callable[[CommissioningRecord], CommissioningRecord],
) -> None:
    forged, kept = forge(shown), file.read_bytes()
    with pytest.raises((ConfigError, LinkError), match=r"^seal: |of the link 'another'"):
        steps.load(forged)
    assert (steps.record, steps.config.x.offset) == (shown, 0.0012)
    assert file.read_bytes() == kept
    steps.load(shown)

    file.write_text(forged.model_dump_json())
    again = commissioned(file)
    assert again.record.empty
    assert again.config == default_drive()
    assert "steps are to be done again" in again.damage
    assert file.with_suffix(".unsealed.json").read_text() == forged.model_dump_json()


def test_a_document_of_another_link_or_of_other_drives_is_not_taken(
    steps: Commissioning, shown: CommissioningRecord, file: Path
) -> None:
    with pytest.raises(LinkError, match="of the link 'another'"):
        steps.load(sealed(file, shown, link="another"))
    with pytest.raises(LinkError, match=r"numbers 6, 5, 4, 3, 2, 1; found are 1, 2, 3, 4, 5, 6$"):
        steps.load(sealed(file, shown, serials=[6, 5, 4, 3, 2, 1]))
    with pytest.raises(LinkError, match="found are no drives yet"):
        Commissioning(default_drive(), file).load(shown)
    assert steps.record == shown


def test_only_its_owner_reads_the_key(steps: Commissioning, file: Path) -> None:
    assert not key_file(file).exists()
    steps.put("drives", find_drives(default_drive(), found()))
    assert stat.S_IMODE(key_file(file).stat().st_mode) == 0o600
    key = key_file(file).read_bytes()
    assert len(key) == 32
    steps.put("identity", compare_identity(default_drive(), found()))
    assert key_file(file).read_bytes() == key


@pytest.mark.parametrize("key", [None, b"", b"k" * 32, b"k" * 33])
def test_without_its_key_a_document_is_put_aside(
    steps: Commissioning, file: Path, key: bytes | None
) -> None:
    two_done(steps)
    before = steps.record
    if key is None:
        key_file(file).unlink()
    else:
        key_file(file).write_bytes(key)
    with pytest.raises(ConfigError, match="seal: "):
        steps.load(before)
    again = commissioned(file)
    assert again.present == "drives"
    assert "steps are to be done again" in again.damage
    two_done(again)  # with a key of its own, or the new one
    assert commissioned(file).present == "encoders"


def test_a_document_of_an_earlier_version_is_put_aside(file: Path) -> None:
    done = {"at": 0.0, "holds": True, "text": "done", "rows": [], "changes": [], "run": None}
    change = {"path": "x.offset", "now": 0.0, "then": 0.0012}
    old = {"link": "Virtual drive", "findings": {"drives": done}, "taken": [change]}
    file.write_text(json.dumps(old))
    steps = commissioned(file)
    assert steps.config == default_drive()
    assert steps.present == "drives"
    assert steps.damage.startswith("commissioning.json has no seal: an earlier version wrote it")
    assert json.loads(file.with_suffix(".unsealed.json").read_text()) == old


def test_what_was_found_on_other_drives_is_not_in_effect(
    steps: Commissioning, shown: CommissioningRecord, file: Path
) -> None:
    again = commissioned(file, serials=[1, 2, 77, 4, 5, 6])
    assert again.other_drives.endswith("1, 2, 3, 4, 5, 6 commissioned, 1, 2, 77, 4, 5, 6 found")
    assert (again.present, again.findings, again.taken) == ("drives", {}, [])
    assert again.config == default_drive()
    with pytest.raises(LinkError, match="Find drives comes first"):
        again.begin("identity")
    again.follow(SERIALS)  # the drive is back
    assert again.other_drives == ""
    assert (again.present, again.config.x.offset) == ("commutation", 0.0012)

    again.follow([1, 2, 77, 4, 5, 6])
    two_done(again)
    assert again.other_drives == ""
    assert (again.present, again.taken, again.config) == ("encoders", [], default_drive())
    assert again.record.serials == [1, 2, 77, 4, 5, 6]
    aside = file.with_suffix(".other.json").read_text()
    assert CommissioningRecord.model_validate_json(aside) == shown
    again.follow(SERIALS)
    again.load(shown)
    assert again.config.x.offset == 0.0012


def test_a_document_of_another_link_is_kept_beside_that_of_this_one(
    steps: Commissioning, shown: CommissioningRecord, file: Path
) -> None:
    other = commissioned(file, default_drive().model_copy(update={"title": "another"}))
    two_done(other)
    aside = file.with_suffix(".other.json").read_text()
    assert CommissioningRecord.model_validate_json(aside) == shown


def test_steps_that_held_with_a_value_that_was_edited_since_are_to_be_done_again(
    steps: Commissioning, shown: CommissioningRecord, file: Path
) -> None:
    for offset, kept in ((0.0012, 5), (0.0011, 4)):
        steps.load(shown)
        config = default_drive()
        axis = config.x.model_copy(update={"offset": offset})
        again = commissioned(file, config.model_copy(update={"x": axis}))
        assert (again.config.x.offset, again.taken) == (offset, [])
        assert (again.present, len(again.record.findings)) == ("commutation", kept)
        again.load(again.record)  # its seal is that of what is left


def test_limits_stand_beside_those_that_were_asked_for() -> None:
    name = "object 6072:00, largest torque, per mille of rated"
    drives = found(limits=[{"name": name, "written": 1000, "read": 900}])
    finding = compare_identity(default_drive(), drives)
    (row,) = (row for row in finding.rows if not row.holds)
    assert (row.name, row.found, row.expected) == (f"3 x c, {name}", "900", "1000")
    assert finding.text == "6 of 6 match; 10 A rated; 0 of 1 limits as asked for"
    assert not finding.holds
