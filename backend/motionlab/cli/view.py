"""The command ``motionlab view``."""

from __future__ import annotations

import argparse
import json
from typing import TYPE_CHECKING, Any

from motionlab.analysis.views.table import BY_NAME, VIEWS
from motionlab.cli.output import names_run, show
from motionlab.errors import DONE, ConfigError, FieldError
from motionlab.studies.options import add_fields, add_json, add_set, source

if TYPE_CHECKING:
    from pydantic import BaseModel

    from motionlab.analysis.views.recorded import Recorded
    from motionlab.analysis.views.table import View
    from motionlab.cli.parser import Parser

EXAMPLES = """\
examples:
  motionlab view ballbar circle
  motionlab view ballbar circle-matched --set variants.B.controller.x.k_p=312000 --json
  motionlab view ballbar r-gpd6hecc7x3n --from 0 --to 10.5
  motionlab view positioning circle-matched --axis y --targets 7 --runs 5

`motionlab docs views` defines every figure.
"""


def add(commands: Any) -> None:
    """Add ``motionlab view``."""
    parser = commands.add_parser(
        "view",
        help="circular test and other views of a run or a scenario",
        description="Compute a view of a kept run, or of a scenario that is simulated for it.",
        epilog=EXAMPLES,
        late=_add_options,
    )
    summaries = "; ".join(f"{view.name}: {view.summary}" for view in VIEWS)
    parser.add_argument("view", metavar="VIEW", choices=list(BY_NAME), help=summaries)
    parser.add_argument(
        "scenario",
        metavar="RUN|SCENARIO",
        nargs="?",
        default="circle",
        help="identifier or name of a kept run, path of a .toml file, - for stdin, or a shipped "
        "scenario (default: %(default)s)",
    )
    parser.add_argument("--from", dest="start", metavar="S", type=float, help="begin, s")
    parser.add_argument("--to", dest="end", metavar="S", type=float, help="end, s")
    add_set(parser, "change a field of the scenario (repeatable)")
    add_json(parser)
    parser.set_defaults(command=_view)


def _add_options(parser: Parser) -> None:
    """Add the options of views that have some; those of one name are one option."""
    known: set[str] = set()
    for view in VIEWS:
        if view.options is None:
            continue
        group = parser.add_argument_group(f"options of the view {view.name}")
        add_fields(group, view.options, known)


def _view(options: argparse.Namespace) -> int:
    view = BY_NAME[options.view]
    request = _request(view, options)
    document = view.compute(_recorded(view, request, options), request)
    if options.json:
        print(json.dumps(document.model_dump(mode="json")))
    else:
        from motionlab.reports.document_text import document_text

        show(document_text(document))
    return DONE


def _request(view: View, options: argparse.Namespace) -> BaseModel | None:
    """Return the options of a view; those of other views are refused."""
    from motionlab.config.validation_errors import checked

    own = set(view.options.model_fields) if view.options else set()
    for other in VIEWS:
        for name in set(other.options.model_fields if other.options else ()) - own:
            if (value := getattr(options, name)) is not None:
                message = f"is of the view {other.name}"
                raise ConfigError(FieldError(f"--{name}", message, value))
    if view.options is None:
        return None
    values = {name: getattr(options, name) for name in own}
    present = {name: value for name, value in values.items() if value is not None}
    return checked(view.options, present, view.name)


def _recorded(view: View, request: BaseModel | None, options: argparse.Namespace) -> Recorded:
    from motionlab.config.changes import parse_assignments
    from motionlab.config.load import load_scenario
    from motionlab.library.library import library
    from motionlab.library.recorded import of_run
    from motionlab.simulation.prepare import prepare
    from motionlab.simulation.recorded import of_scenario

    start, end = options.start, options.end
    if names_run(options.scenario):
        if options.assignments:
            message = "changes a scenario; a kept run is as it was"
            raise ConfigError(FieldError("--set", message, options.assignments[0]))
        return of_run(library().named(options.scenario), start, end, window=view.window)
    scenario = load_scenario(source(options), parse_assignments(options.assignments))
    scenario = view.to_simulate(scenario, request, {"--from": start, "--to": end})
    if view.measures:
        start = 0.0  # too long a measurement is refused, not cut to its end
    return of_scenario(prepare(scenario), start, end, window=view.window)
