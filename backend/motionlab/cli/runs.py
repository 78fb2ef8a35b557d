"""The command ``motionlab runs``."""

from __future__ import annotations

import argparse
import json
import re
from collections.abc import Sequence
from datetime import datetime
from typing import TYPE_CHECKING, Any

from motionlab.cli.output import show
from motionlab.errors import DONE
from motionlab.studies.options import add_json

if TYPE_CHECKING:
    from motionlab.library.run import Page, Run
    from motionlab.library.search import Search

EXAMPLES = """\
examples:
  motionlab runs
  motionlab runs tag:rig 'B.x.max<3um' after:2026-11-01
  motionlab runs scenario:circle --sort B.x.max --json

`motionlab docs runs` has the language of searches.
"""


def add(commands: Any) -> None:
    """Add ``motionlab runs``."""
    parser = commands.add_parser(
        "runs",
        help="list the runs that were kept",
        description="List the runs that were kept, the newest first.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("search", metavar="TERM", nargs="*", help="what they must meet, all of it")
    parser.add_argument(
        "--sort",
        metavar="FIELD",
        default="-created",
        help="created, name, duration, size or a metric such as B.x.max; --sort=-created turns "
        "the order around (default: %(default)s)",
    )
    parser.add_argument(
        "--limit", metavar="N", type=int, default=50, help="runs to show (default: %(default)s)"
    )
    add_json(parser)
    parser.set_defaults(command=_list)


def _list(options: argparse.Namespace) -> int:
    from motionlab.errors import ConfigError, FieldError
    from motionlab.library.library import library
    from motionlab.library.search import LIMIT_MAX

    if not 1 <= options.limit <= LIMIT_MAX:
        allowed = f">= 1 and <= {LIMIT_MAX}"
        raise ConfigError(FieldError("--limit", "is out of range", options.limit, allowed))
    search = search_of(options.search)
    library().recover()  # what a killed server left
    while library().add_margins():
        pass
    page = library().index.page(search, sort=options.sort, limit=options.limit)
    if options.json:
        print(json.dumps(page.model_dump(mode="json")))
    else:
        show(_table(page, " ".join(options.search)))
    return DONE


def search_of(terms: Sequence[str]) -> Search:
    """Return what terms on the command line ask for.

    Raises
    ------
    ConfigError
        Naming the term that is none.
    """
    from motionlab.library.search import parse, quoted

    for term in terms:
        _check_key(term)
    return parse(" ".join(quoted(term) for term in terms))


def _check_key(term: str) -> None:
    """Refuse ``foo:bar``; elsewhere it is a text to look for, here more likely an error."""
    from motionlab.config.named_configs import did_you_mean
    from motionlab.errors import ConfigError, FieldError
    from motionlab.library.search import KEYS

    match = re.fullmatch(r"([a-z]+):\S*", term)
    if match and match[1] not in KEYS:
        message = f"no such key{did_you_mean(match[1], list(KEYS))}"
        allowed = f"one of {', '.join(KEYS)}; a text with a colon, in quotes of its own"
        raise ConfigError(FieldError("TERM", message, term, allowed))


def _table(page: Page, search: str) -> str:
    if not page.runs and search:
        return f"no run meets {search!r}"
    if not page.runs:
        return "no run: motionlab run circle --keep keeps one, and so does Play in the Lab"
    from motionlab.reports.tables import table

    rows = [_row(run) for run in page.runs]
    heads = ("run", "began", "kind", "duration", "name", "largest following errors")
    lines = [table(heads, rows)]
    if page.total > len(page.runs):
        lines.append(f"{len(page.runs)} of {page.total} runs")
    return "\n".join(lines)


def _row(run: Run) -> list[str]:
    when = datetime.fromtimestamp(run.created).strftime("%Y-%m-%d %H:%M")
    errors = [
        f"{name[:3]} {1e6 * value:.3g} um"
        for name, value in run.metrics.items()
        if name.endswith(".max_abs_following_error")
    ]
    state = run.kind if run.state == "complete" else f"{run.kind}, {run.state}"
    return [run.id, when, state, f"{run.duration:.4g} s", _printable(run.name), ", ".join(errors)]


def _printable(text: str) -> str:
    """Return a text in which nothing is an order to the terminal."""
    return re.sub(r"[\x00-\x1f\x7f-\x9f\ud800-\udfff]", lambda match: repr(match[0])[1:-1], text)
