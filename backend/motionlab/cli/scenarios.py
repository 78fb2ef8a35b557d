"""The commands ``motionlab scenarios`` and ``motionlab show``."""

from __future__ import annotations

import argparse
import json
from typing import Any

from motionlab.cli.exit_codes import DONE
from motionlab.studies.options import add_json, add_scenario, add_set, source

EXAMPLES = """\
examples:
  motionlab show circle
  motionlab show fig5 --set plant=matched > mine.toml
  motionlab run mine.toml

docs/scenarios.md explains the fields.
"""


def add(commands: Any) -> None:
    """Add both commands."""
    parser = commands.add_parser(
        "scenarios",
        help="list the shipped scenarios",
        description="List the shipped scenarios: what each is called, and what it shows.",
    )
    add_json(parser)
    parser.set_defaults(command=_list)

    parser = commands.add_parser(
        "show",
        help="show a scenario with every field, as a file",
        description="Show a scenario with every field and its value, SI, as TOML that "
        "`motionlab run` takes.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add_scenario(parser)
    add_set(parser, "change a field (repeatable, all applied together)")
    add_json(parser)
    parser.set_defaults(command=_show)


def _list(options: argparse.Namespace) -> int:
    from motionlab.config.load import load_scenario
    from motionlab.config.shipped import names

    titles = {name: load_scenario(name).title for name in names("scenarios")}
    if options.json:
        print(json.dumps([{"name": name, "title": title} for name, title in titles.items()]))
        return DONE
    width = max(map(len, titles))
    for name, title in titles.items():
        print(f"{name.ljust(width)}  {title}")
    return DONE


def _show(options: argparse.Namespace) -> int:
    from motionlab.config.changes import parse_assignments
    from motionlab.config.load import load_scenario

    scenario = load_scenario(source(options), parse_assignments(options.assignments))
    tables = scenario.model_dump(mode="json", exclude_none=True)
    if options.json:
        print(json.dumps(tables, allow_nan=False))
        return DONE
    import tomli_w

    print(tomli_w.dumps(tables), end="")
    return DONE
