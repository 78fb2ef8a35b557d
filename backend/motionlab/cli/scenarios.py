"""The commands ``motionlab scenarios``, ``show``, ``new`` and ``schema``."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from motionlab.cli.output import add_overwrite, check_output, show, wrote
from motionlab.errors import DONE
from motionlab.studies.options import add_json, add_scenario, add_set, source

EXAMPLES = """\
examples:
  motionlab show circle
  motionlab show fig5 --set plant=matched > mine.toml
  motionlab run mine.toml

`motionlab docs scenarios` explains the fields.
"""

NEW_EXAMPLES = """\
examples:
  motionlab new mine.toml
  motionlab new slow.toml --base rhombus
  motionlab run mine.toml
"""

SCHEMA_EXAMPLES = """\
examples:
  motionlab schema > scenario.schema.json
  motionlab schema motor > motor.schema.json

Editors that know TOML schemas, such as those with Taplo, complete and check a file whose first line
is `#:schema scenario.schema.json`, the path from its own folder.
"""


def add(commands: Any) -> None:
    """Add the commands."""
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

    parser = commands.add_parser(
        "new",
        help="write a scenario of one's own, with comments",
        description="Write a scenario that differs in nothing from a shipped one yet: its fields "
        "stand in comments, with unit and range. In a checkout, editors that know TOML schemas "
        "complete and check it; `motionlab schema` writes the schema for elsewhere.",
        epilog=NEW_EXAMPLES,
    )
    parser.add_argument("file", metavar="FILE", help="file to write: .toml")
    parser.add_argument(
        "--base",
        metavar="SCENARIO",
        default="circle",
        help="shipped scenario to start from (default: %(default)s)",
    )
    add_overwrite(parser)
    parser.set_defaults(command=_new)

    parser = commands.add_parser(
        "schema",
        help="print the JSON schema of scenarios or their parts",
        description="Print the JSON schema of a kind of TOML file: every field with unit, range "
        "and source.",
        epilog=SCHEMA_EXAMPLES,
    )
    kinds = ("scenario", "motor", "controller", "trajectory", "drive")
    parser.add_argument(
        "kind", nargs="?", choices=kinds, default=kinds[0], help="default: %(default)s"
    )
    parser.set_defaults(command=_schema)


def _list(options: argparse.Namespace) -> int:
    from motionlab.config.named_configs import names, read
    from motionlab.reports.tables import table

    titles = {name: read("scenarios", name, loc="")["title"] for name in names("scenarios")}
    if options.json:
        print(json.dumps([{"name": name, "title": title} for name, title in titles.items()]))
        return DONE
    show(table(("", ""), titles.items()))
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


def _new(options: argparse.Namespace) -> int:
    from motionlab.config.load import load_scenario
    from motionlab.config.template import template
    from motionlab.files import complete_file

    text = template(load_scenario(options.base), Path(options.file).parent)
    check_output(options.file, ".toml", overwrite=options.overwrite, loc="FILE")
    with complete_file(options.file) as part:
        part.write_text(text, encoding="utf-8")
    wrote(options.file)
    return DONE


def _schema(options: argparse.Namespace) -> int:
    from motionlab.config.schema import schema_text

    print(schema_text(options.kind), end="")
    return DONE
