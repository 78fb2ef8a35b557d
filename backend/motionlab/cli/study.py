"""The commands of all studies."""

from __future__ import annotations

import argparse
import functools
from collections.abc import Sequence
from typing import Any

from motionlab.cli.output import add_overwrite, check_output, show, wrote
from motionlab.errors import DONE, FAILED
from motionlab.executors.executor import executing
from motionlab.executors.progress import share_done
from motionlab.own_studies import note, wrong
from motionlab.studies.options import add_json, add_scenario, add_scheduler, add_set, source
from motionlab.studies.own import FILES
from motionlab.studies.study import Study
from motionlab.studies.table import OWN, SHIPPED


def add(commands: Any, only: str = "") -> None:
    """Add a command for each study that has one.

    Parameters
    ----------
    commands : object
        What they are added to.
    only : str
        First word of the command line: where it is one of them, the others get no options, some of
        which come from requests whose modules take half a second to import.
    """
    _add(commands, SHIPPED, only)


def add_own(commands: Any) -> None:
    """Add the commands of studies of one's own, whose names none of the others has.

    Those of the others are all known by now.
    """
    for study in OWN:
        if study.kind in commands.choices:
            file, loc = FILES[study.kind], "STUDY.kind"
            note(wrong(file, loc, "is the name of a command; choose another", study.kind), file)
    _add(commands, [study for study in OWN if study.kind not in commands.choices], "")


def _add(commands: Any, studies: Sequence[Study], only: str) -> None:
    named = [study for study in studies if study.command is not None]
    chosen = any(study.command is not None and study.command.name == only for study in named)
    for study in named:
        assert study.command is not None
        parser = commands.add_parser(
            study.command.name,
            help=study.command.help,
            description=study.command.description,
            epilog=study.command.examples,
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        if chosen and study.command.name != only:
            continue
        if study.command.scenario is not None:
            add_scenario(parser, study.command.scenario)
        if study.command.set is not None:
            add_set(parser, study.command.set)
        study.add_options(parser)
        if study.suffixes:
            add_overwrite(parser)
        add_json(parser)
        if study.scatters:
            add_scheduler(parser)
        parser.set_defaults(command=functools.partial(_carry_out, study))


def _carry_out(study: Study, options: argparse.Namespace) -> int:
    """Plan and run a study, and print its report or its document."""
    from motionlab.config.changes import parse_assignments

    assert study.command is not None
    changes = {} if study.command.set is None else parse_assignments(options.assignments)
    scenario = None if study.command.scenario is None else source(options)
    plan = study.plan(study.request_of(options, changes), scenario)
    out = getattr(options, "out", None)
    if out is not None:
        check_output(out, *study.suffixes, overwrite=options.overwrite)
    instead = study.before(plan, options)
    if instead is not None:
        show(instead)
        return DONE
    if study.direct:
        result = study.run(plan, lambda *_: None)
    else:
        scheduler = getattr(options, "scheduler", None)
        with executing(scheduler), share_done(study.command.title) as progress:
            result = study.run(plan, lambda share, _partial=None: progress(share))
    study.after(result, options)
    if out is not None:
        wrote(out)
    if options.json:
        print(study.text(result))
    else:
        show(study.report(result))
    return FAILED if study.has_failed(result) else DONE
