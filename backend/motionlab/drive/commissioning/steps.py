"""The steps of one drive link: which is to be done, what was found, what was changed for it.

A step is offered once those before it hold. Doing one again forgets those after it. What was found
is one document, kept as a file. It is of the drives on which it was found, by their serial numbers:
while others are found, none of it holds.
"""

from __future__ import annotations

import contextlib
import logging
from collections.abc import Sequence
from pathlib import Path

from pydantic import ValidationError

from motionlab.config.drive import DriveConfig
from motionlab.drive.commissioning import seal
from motionlab.drive.commissioning.checks import ByHand
from motionlab.drive.commissioning.record import (
    ORDER,
    CommissioningRecord,
    ConfigChange,
    Finding,
    StepName,
    in_effect,
    step_of,
    value_at,
)
from motionlab.drive.link.carrier import LinkError
from motionlab.errors import ConfigError, FieldError
from motionlab.files import failure, opened, replace

_LOG = logging.getLogger(__name__)
_FILE_MAX = 100_000  # bytes
_SHOWN_BY: dict[str, StepName] = {"direction": "encoders", "offset": "commutation"}


class Commissioning:
    """The steps of one drive link and what they found.

    `file` is the link as its file has it, `path` the file of the document. `damage` says why that
    was not taken, until another one is written; or nothing.
    """

    def __init__(self, file: DriveConfig, path: Path) -> None:
        self._file = file
        self._path = path
        self._key_path = path.with_suffix(".key")
        self._key: bytes | None = None
        self._serials: list[int] = []
        self._of_others = False  # what is in the file, and neither of these drives nor of this link
        self.by_hand: ByHand | None = None
        self.damage = ""
        self.record = CommissioningRecord(link=file.title)
        self._changed = file
        self._resume()

    @property
    def config(self) -> DriveConfig:
        """The link in effect: its file with the changes that were taken on its drives."""
        return self._file if self.other_drives else self._changed

    @property
    def findings(self) -> dict[StepName, Finding]:
        """What was found on the drives that are there."""
        return {} if self.other_drives else self.record.findings

    @property
    def taken(self) -> list[ConfigChange]:
        """Changes in effect."""
        return [] if self.other_drives else self.record.taken

    @property
    def other_drives(self) -> str:
        """Why the document is not of the drives that were found; or nothing."""
        commissioned, serials = self.record.serials, self._serials
        if self.record.empty or not serials or serials == commissioned:
            return ""
        return (
            "the drives are not those that were commissioned: serial numbers "
            f"{_listed(commissioned)} commissioned, {_listed(serials)} found"
        )

    def follow(self, serials: Sequence[int]) -> None:
        """Note the serial numbers of the drives that were found, in the order of the bus."""
        if serials:
            self._serials = list(serials)

    @property
    def present(self) -> StepName | None:
        """The step that is to be done; None when all hold."""
        for name in ORDER:
            finding = self.findings.get(name)
            if finding is None or not finding.holds:
                return name
        return None

    def begin(self, name: StepName) -> None:
        """Forget a step and those after it; the first one, on other drives, begins a new document.

        Raises
        ------
        LinkError
            If a step before it does not hold.
        """
        present = self.present
        if present is not None and ORDER.index(name) > ORDER.index(present):
            raise LinkError(f"{step_of(present).title} comes first")
        if self.other_drives:
            self._of_others = True
            self._changed = self._file
        self.record = self._without(name)
        self.by_hand = None

    def _without(self, name: StepName) -> CommissioningRecord:
        """Return the document without a step and those after it."""
        findings: dict[StepName, Finding] = {
            step: self.findings[step] for step in ORDER[: ORDER.index(name)]
        }
        record = CommissioningRecord(
            link=self._file.title, serials=self._serials, findings=findings, taken=self.taken
        )
        return seal.sealed(record, self._key) if self._key else record

    def put(self, name: StepName, finding: Finding) -> None:
        """Keep what a step has found, in the file too.

        Raises
        ------
        StoreError
            If the file cannot be written.
        """
        self.begin(name)
        findings = self.record.findings | {name: finding}
        self.record = self.record.model_copy(update={"findings": findings, "seal": ""})
        self.record = self._keep(self.record)

    def take(self, name: StepName, changes: Sequence[ConfigChange]) -> None:
        """Take the changes that a step shows, and forget it: it is to be done again with them.

        Raises
        ------
        LinkError
            If these are not the changes that it shows.
        ConfigError
            If a value is out of its range.
        StoreError
            If the file cannot be written.
        """
        finding = self.findings.get(name)
        if finding is None or not changes or list(changes) != finding.changes:
            raise LinkError(f"these are not the changes that {step_of(name).title} shows")
        taken = {change.path: change for change in self.record.taken}
        for change in changes:
            of_file = value_at(self._file, change.path)
            taken[change.path] = change.model_copy(update={"now": of_file})
        in_use = [change for change in taken.values() if change.then != change.now]
        config = in_effect(self._file, in_use)
        record = self._without(name).model_copy(update={"taken": in_use})
        self.record = self._keep(record)  # what cannot be kept does not take effect
        self._changed, self.by_hand = config, None

    def load(self, record: CommissioningRecord) -> None:
        """Take a document that was found on these drives; an empty one starts over.

        Raises
        ------
        LinkError
            If it is of another link or of other drives, or changes values that the file has not.
        ConfigError
            If it is not as this server wrote it.
        StoreError
            If the file cannot be written.
        """
        if record.link != self._file.title:
            raise LinkError(
                f"this document is of the link {record.link!r}, not of {self._file.title!r}"
            )
        if record.empty:
            record = CommissioningRecord(link=record.link)
        else:
            self._check(record)
        config = in_effect(self._file, record.taken)
        self._of_others = self._of_others or bool(self.other_drives)
        self.record = self._keep(record)
        self._changed, self.by_hand = config, None

    def _check(self, record: CommissioningRecord) -> None:
        """Refuse a document that was not found on these drives, or was changed since."""
        try:
            key = seal.read_key(self._key_path)
        except OSError as error:
            raise failure(f"{self._key_path.name} cannot be read", error) from error
        # Before all else: serial numbers of a document that was changed prove nothing.
        if not seal.holds(record, key):
            text = (
                "the document was changed since it was found, or another server found it: load it "
                "as it was written, or do the steps on these drives"
            )
            raise ConfigError(FieldError("seal", text))
        if record.serials != self._serials:
            present = _listed(self._serials) if self._serials else "no drives yet"
            raise LinkError(
                "this document is of drives with the serial numbers "
                f"{_listed(record.serials)}; found are {present}"
            )
        for change in record.taken:
            if not self._fits(change):
                raise LinkError(
                    f"this document changes {change.path} = {change.now:g}; the file of the link "
                    f"has {value_at(self._file, change.path):g}"
                )

    def _keep(self, record: CommissioningRecord) -> CommissioningRecord:
        """Write a document with its seal, and return it."""
        try:
            self._key = seal.read_key(self._key_path) or seal.make_key(self._key_path)
            record = seal.sealed(record, self._key)
            content = record.model_dump_json(indent=2).encode()
            if len(content) > _FILE_MAX:
                bounds = {"maximum": float(_FILE_MAX)}
                text = "the document is too long"
                raise ConfigError(
                    FieldError("findings", text, len(content), bounds=bounds, unit="B")
                )
            if self._of_others:
                self._put_aside("other")
            replace(self._path, content)
        except OSError as error:
            raise failure("the commissioning document cannot be written", error) from error
        self._of_others, self.damage = False, ""
        return record

    def _put_aside(self, what: str) -> Path:
        """Keep the file beside its place."""
        aside = self._path.with_suffix(f".{what}.json")
        with contextlib.suppress(FileNotFoundError):
            self._path.replace(aside)
        return aside

    def _resume(self) -> None:
        """Go on with the document of the file, if there is one of this link.

        Changes of a value that was edited in the file of the link since are left out, with the
        steps that held with them. A file that cannot be read, or is not as this server sealed it,
        is put aside.
        """
        try:
            with opened(self._path) as file:
                record = CommissioningRecord.model_validate_json(file.read(_FILE_MAX))
            self._key = seal.read_key(self._key_path)
            if not record.empty and not seal.holds(record, self._key):
                self._refuse_file("unsealed", _unsealed(record, self._key))
                return
            if record.link != self._file.title:
                self._of_others = True
                return
            taken = [change for change in record.taken if self._fits(change)]
            self._changed = in_effect(self._file, taken)
        except FileNotFoundError:
            return
        except (OSError, ValidationError, ConfigError) as error:
            self._refuse_file("damaged", "cannot be read")
            _LOG.warning("%s: %.300s", self._path, error)
            return
        self.record = record
        # The seal is of the whole document, so one with less in it needs another.
        if taken != record.taken and self._key:
            findings = self._still_hold(record)
            lapsed = record.model_copy(update={"taken": taken, "findings": findings})
            self.record = seal.sealed(lapsed, self._key)

    def _still_hold(self, record: CommissioningRecord) -> dict[StepName, Finding]:
        """Return what was found before the first step whose change the file now contradicts."""
        edited = [
            ORDER.index(_SHOWN_BY[change.path.partition(".")[2]])
            for change in record.taken
            if value_at(self._file, change.path) not in {change.now, change.then}
        ]
        kept = ORDER[: min(edited, default=None)]
        return {name: finding for name, finding in record.findings.items() if name in kept}

    def _refuse_file(self, what: str, why: str) -> None:
        """Put the file aside, and say why none of it is in effect."""
        aside = self._path.with_suffix(f".{what}.json")
        with contextlib.suppress(OSError):
            self._path.replace(aside)
        self.damage = (
            f"{self._path.name} {why}; none of its findings and changes is in effect, and its "
            f"steps are to be done again; it is put aside as {aside.name}"
        )
        _LOG.warning("%s, in %s", self.damage, self._path.parent)

    def _fits(self, change: ConfigChange) -> bool:
        return value_at(self._file, change.path) == change.now


def _listed(serials: Sequence[int]) -> str:
    return ", ".join(map(str, serials))


def _unsealed(record: CommissioningRecord, key: bytes | None) -> str:
    if not record.seal:
        return "has no seal: an earlier version wrote it, or somebody did by hand"
    if key is None:
        return "cannot be checked: the key of its seal is missing"
    return "is not as this server wrote it: its seal is of another key, or of other content"
