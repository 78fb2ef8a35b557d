"""The command ``motionlab challenge``: laws ranked among those that ship."""

from __future__ import annotations

import argparse
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from motionlab.cli.output import add_overwrite, check_output, show, wrote
from motionlab.errors import DONE, ConfigError, FieldError
from motionlab.own_files import VARIABLE
from motionlab.studies.options import add_json, add_scheduler, add_set

EXAMPLES = """\
examples:
  motionlab challenge
  motionlab challenge mine.py -o mine.html
  motionlab challenge mine.py --set mine_share=0.8 --json
  motionlab challenge canudas-de-wit --set gain=100 --seed 7

`motionlab docs challenge` has the rules.
"""


def add(commands: Any) -> None:
    """Add ``motionlab challenge``."""
    parser = commands.add_parser(
        "challenge",
        help="rank laws of friction compensation among those that ship",
        description="Run laws of friction compensation in ten frozen scenarios and on thirty "
        "drawn motors, all under one controller, and rank them among those that ship by error, "
        "effort and margins.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "entrants",
        metavar="LAW",
        nargs="*",
        help="file of a law of one's own, .py, or name of a law; left out: those that ship alone",
    )
    add_set(parser, "a parameter of the named laws (repeatable; default: as they declare it)")
    parser.add_argument(
        "--seed", type=int, help="of the drawn motors (default: the challenge's own)"
    )
    parser.add_argument("-o", "--out", metavar="FILE", help="write a page to FILE, .html")
    add_overwrite(parser)
    add_json(parser)
    add_scheduler(parser)
    parser.set_defaults(command=_challenge)


def _challenge(options: argparse.Namespace) -> int:
    if options.out is not None:
        check_output(options.out, ".html", overwrite=options.overwrite)
    if options.seed is not None and options.seed < 0:
        raise ConfigError(FieldError("--seed", "is negative", options.seed, ">= 0", "1"))
    names = taken(options.entrants)
    # Only now: with the laws come the files.
    from motionlab.config.changes import parse_assignments
    from motionlab.executors.executor import executing
    from motionlab.executors.progress import share_done
    from motionlab.studies.challenge.documents import report
    from motionlab.studies.challenge.entrants import entrants
    from motionlab.studies.challenge.ranking import challenge

    named = entrants(names, parse_assignments(options.assignments))
    with executing(options.scheduler), share_done("challenge") as progress:
        result = challenge(named, seed=options.seed, progress=progress)
    if options.out is not None:
        from motionlab.files import complete_file
        from motionlab.studies.challenge.page import challenge_page

        with complete_file(options.out) as part:
            part.write_bytes(challenge_page(result))
        wrote(options.out)
    if options.json:
        print(result.document.model_dump_json())
    else:
        show(report(result.document))
    return DONE


def taken(laws: Sequence[str]) -> list[str]:
    """Return the names of laws; files are checked in processes of their own, and taken.

    It has to come before anything that imports laws.

    Raises
    ------
    ConfigError
        Why files cannot be taken, with their lines.
    """
    from motionlab.own_laws.check import check_file

    names: list[str] = []
    problems: list[FieldError] = []
    files: dict[str, Path] = {}
    for law in laws:
        if not law.endswith(".py") and os.sep not in law:
            names.append(law)
            continue
        path = Path(law).resolve()
        if not path.is_file():
            problems.append(FieldError("LAW", "is no file", law))
            continue
        result = check_file(path)
        problems += result.problems
        if files.setdefault(result.name, path) != path and not result.problems:
            message = f"has the name of the law of {files[result.name]}"
            problems.append(FieldError(f"{result.name}.name", message, place=str(path)))
        names.append(result.name)
    if problems:
        raise ConfigError(*problems)
    before = filter(None, [os.environ.get(VARIABLE)])
    os.environ[VARIABLE] = os.pathsep.join([*map(str, files.values()), *before])
    return names
