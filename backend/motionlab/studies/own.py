"""Studies of one's own: a file with a `STUDY`; what it leaves out follows from its kind."""

from __future__ import annotations

import inspect
from collections.abc import Iterable
from functools import partial
from pathlib import Path
from typing import Any

from motionlab.declarations import DeclarationError
from motionlab.own_files import OwnFile
from motionlab.own_studies import (
    check_document,
    check_model,
    check_name,
    declared,
    note,
    placed,
    wrong,
)
from motionlab.studies.options import add_fields, set_options
from motionlab.studies.study import Source, Study, StudyCommand

FILES: dict[str, OwnFile] = {}
"""The file of each, by kind."""

_CALLED = ("read", "run", "report", "excess", "kept", "before", "after", "text")
"""What calls the file's code."""
_SCENARIO = frozenset({"scenario", "set"})


def own_studies(shipped: Iterable[Study], kinds: Iterable[str]) -> tuple[Study, ...]:
    """Return the studies of one's own that can be taken, and note why others cannot.

    Parameters
    ----------
    shipped : iterable of Study
        Those whose kinds and commands are not free.
    kinds : iterable of str
        Further kinds of jobs.
    """
    taken = {each.kind for each in shipped} | set(kinds)
    taken |= {each.command.name for each in shipped if each.command is not None}
    studies: list[Study] = []
    for study, file in declared("STUDY"):
        try:
            _check(study, file, frozenset(taken))
        except DeclarationError as error:
            note(error, file)
        else:
            _complete(study, file)
            taken.add(study.kind)
            FILES[study.kind] = file
            studies.append(study)
    return tuple(studies)


def _check(study: Any, file: OwnFile, taken: frozenset[str]) -> None:
    if not isinstance(study, Study):
        raise wrong(file, "STUDY", "is no object of a class of motionlab.studies.study.Study")
    check_name(file, "STUDY.kind", getattr(study, "kind", None), taken, "-")
    for name in ("request_model", "document_model"):
        check_model(file, f"STUDY.{name}", getattr(study, name, None))
    if study.partial_model is not None:
        check_model(file, "STUDY.partial_model", study.partial_model)
    if type(study).run is Study.run:
        raise wrong(file, "STUDY.run", "is missing: run(self, plan, progress)")


def _complete(study: Study, file: OwnFile) -> None:
    """Add what follows from the kind; errors of the file's functions name its lines."""
    name = "".join(part.title() for part in study.kind.split("-"))
    text = inspect.getdoc(type(study)) or name
    has_scenario = "scenario" in study.request_model.model_fields
    planned, document = placed(file, study.plan), placed(file, study.document)

    def plan(request: dict[str, Any], source: Source | None = None) -> Any:
        if isinstance(source, Path):
            from motionlab.config.load import load_scenario

            source = load_scenario(source).model_dump(mode="json")
        return planned(request if source is None else {**request, "scenario": source}, source)

    def request_of(options: Any, changes: dict[str, Any]) -> dict[str, Any]:
        base = Study.request_of(study, options, changes) if has_scenario else {}
        names = study.request_model.model_fields.keys() & vars(options).keys() - _SCENARIO
        return base | set_options(options, *names)

    facts: dict[str, Any] = {each: placed(file, getattr(study, each)) for each in _CALLED} | {
        "path": f"/studies/{study.kind}",
        "operation": f"study{name}",
        "tag": "studies",
        "report_name": f"{name}StudyJob",
        "plan": plan,
        "document": lambda result: check_document(
            file, f"{study.kind}.run", document(result), study.document_model
        ),
        "command": StudyCommand(
            name=study.kind,
            help=text.partition("\n")[0].rstrip("."),
            description=text,
            examples="",
            scenario="" if has_scenario else None,
            set=StudyCommand._field_defaults["set"] if has_scenario else None,
            title=study.kind,
        ),
    }
    if type(study).add_options is Study.add_options:
        facts["add_options"] = partial(add_fields, model=study.request_model, known=set(_SCENARIO))
        facts["request_of"] = request_of
    vars(study).update(facts)
