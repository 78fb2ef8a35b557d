"""The steps of one drive link: which is to be done, what was found, what was changed for it.

A step is offered once those before it hold. Doing one again forgets those after it. What was found
is one document, kept as a file.
"""

from __future__ import annotations

import contextlib
import logging
from collections.abc import Sequence
from pathlib import Path

from pydantic import ValidationError

from motionlab.config.drive import DriveConfig
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
from motionlab.store.files import failure, opened, replace

_LOG = logging.getLogger(__name__)
_FILE_MAX = 100_000  # bytes


class Commissioning:
    """The steps of one drive link and what they found.

    Parameters
    ----------
    file : DriveConfig
        The link, as its file has it.
    path : Path
        File of the document.

    Attributes
    ----------
    record : CommissioningRecord
        The document.
    config : DriveConfig
        The link in effect: its file with the changes that were taken.
    by_hand : ByHand or None
        A mover that is being pushed by hand.
    damage : str
        Why the file of the document could not be read, until another one is written; or nothing.
    """

    def __init__(self, file: DriveConfig, path: Path) -> None:
        self._file = file
        self._path = path
        self.by_hand: ByHand | None = None
        self.damage = ""
        self.record = CommissioningRecord(link=file.title)
        self.config = file
        self._resume()

    @property
    def present(self) -> StepName | None:
        """The step that is to be done; None when all hold."""
        for name in ORDER:
            finding = self.record.findings.get(name)
            if finding is None or not finding.holds:
                return name
        return None

    def begin(self, name: StepName) -> None:
        """Forget a step and those after it.

        Raises
        ------
        LinkError
            If a step before it does not hold.
        """
        present = self.present
        if present is not None and ORDER.index(name) > ORDER.index(present):
            raise LinkError(f"{step_of(present).title} comes first")
        self.record = self._without(name)
        self.by_hand = None

    def _without(self, name: StepName) -> CommissioningRecord:
        """Return the document without a step and those after it."""
        kept = ORDER[: ORDER.index(name)]
        findings = {step: self.record.findings[step] for step in kept}
        return self.record.model_copy(update={"findings": findings})

    def put(self, name: StepName, finding: Finding) -> None:
        """Keep what a step has found, in the file too.

        Raises
        ------
        StoreError
            If the file cannot be written.
        """
        self.begin(name)
        findings = self.record.findings | {name: finding}
        self.record = self.record.model_copy(update={"findings": findings})
        self._keep(self.record)

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
        finding = self.record.findings.get(name)
        if finding is None or not changes or list(changes) != finding.changes:
            raise LinkError(f"these are not the changes that {step_of(name).title} shows")
        taken = {change.path: change for change in self.record.taken}
        for change in changes:
            of_file = value_at(self._file, change.path)
            taken[change.path] = change.model_copy(update={"now": of_file})
        in_use = [change for change in taken.values() if change.then != change.now]
        config = in_effect(self._file, in_use)
        record = self._without(name).model_copy(update={"taken": in_use})
        self._keep(record)  # first: what cannot be kept does not take effect
        self.config, self.record, self.by_hand = config, record, None

    def load(self, record: CommissioningRecord) -> None:
        """Take another document, as far as its steps follow one another.

        Raises
        ------
        LinkError
            If it is of another link, or changes values that the file has not.
        ConfigError
            If a value is out of its range.
        StoreError
            If the file cannot be written.
        """
        if record.link != self._file.title:
            raise LinkError(
                f"this document is of the link {record.link!r}, not of {self._file.title!r}"
            )
        for change in record.taken:
            if not self._fits(change):
                raise LinkError(
                    f"this document changes {change.path} = {change.now:g}; the file of the link "
                    f"has {value_at(self._file, change.path):g}"
                )
        config = in_effect(self._file, record.taken)
        findings: dict[StepName, Finding] = {}
        for name in ORDER:
            if name not in record.findings:
                break
            findings[name] = record.findings[name]
        record = record.model_copy(update={"findings": findings})
        self._keep(record)
        self.config, self.record, self.by_hand = config, record, None

    def _keep(self, record: CommissioningRecord) -> None:
        content = record.model_dump_json(indent=2).encode()
        if len(content) > _FILE_MAX:
            bounds = {"maximum": float(_FILE_MAX)}
            told = "the document is too long"
            raise ConfigError(FieldError("findings", told, len(content), bounds=bounds, unit="B"))
        try:
            replace(self._path, content)
        except OSError as error:
            raise failure("the commissioning document cannot be written", error) from error
        self.damage = ""

    def _resume(self) -> None:
        """Go on with the document of the file, if there is one of this link.

        Changes of a value that was edited in the file of the link since are left out. A file that
        cannot be read is put aside: its changes are not in effect.
        """
        try:
            with opened(self._path) as file:
                record = CommissioningRecord.model_validate_json(file.read(_FILE_MAX))
            if record.link != self._file.title:
                return
            taken = [change for change in record.taken if self._fits(change)]
            self.config = in_effect(self._file, taken)
        except FileNotFoundError:
            return
        except (OSError, ValidationError, ConfigError) as error:
            aside = self._path.with_suffix(".damaged.json")
            with contextlib.suppress(OSError):
                self._path.replace(aside)
            self.damage = (
                f"{self._path.name} cannot be read, and none of its changes is in effect; it is "
                f"put aside as {aside.name}"
            )
            _LOG.warning("%s, in %s: %.300s", self.damage, self._path.parent, error)
            return
        self.record = record.model_copy(update={"taken": taken})

    def _fits(self, change: ConfigChange) -> bool:
        return value_at(self._file, change.path) == change.now
