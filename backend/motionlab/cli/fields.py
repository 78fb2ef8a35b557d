"""The commands ``motionlab fields``, ``laws``, ``new-law`` and ``check-law``."""

from __future__ import annotations

import argparse
import dataclasses
import fnmatch
import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from motionlab.cli.messages import say
from motionlab.cli.output import show
from motionlab.errors import DONE, FAILED, ConfigError, FieldError
from motionlab.studies.options import add_json, add_set, source

if TYPE_CHECKING:
    from motionlab.config.fields import FieldValue

EXAMPLES = """\
examples:
  motionlab fields
  motionlab fields friction
  motionlab fields coulomb
  motionlab fields 'variants.B.controller.*.k_p'
  motionlab fields trajectory --scenario fig5
  motionlab fields --kind waypoints

`motionlab docs scenarios` explains them.
"""
_NEW_LAW = """\
examples:
  motionlab new-law mine
  motionlab serve --laws laws
  motionlab run circle --laws laws --set variants.B.controller.compensation.law=mine

  motionlab new-law --effect cable

`motionlab docs own-law` and `motionlab docs own-effect` explain the files.
"""
_LONG = 40  # characters of a value


def add(commands: Any) -> None:
    """Add both commands."""
    parser = commands.add_parser(
        "fields",
        help="list the fields of a scenario: value, unit, range",
        description="List the fields of a scenario by dotted path, as --set takes them, with "
        "value, unit (SI), range and meaning.",
        epilog=EXAMPLES,
    )
    parser.add_argument(
        "pattern",
        metavar="PATTERN",
        nargs="?",
        default="",
        help="part of a path or of the meaning, or a whole path with * for any letters "
        "(default: every field)",
    )
    parser.add_argument(
        "--scenario",
        metavar="SCENARIO",
        default="circle",
        help="path of a .toml file, - for stdin, or a shipped scenario (default: %(default)s)",
    )
    parser.add_argument(
        "--kind",
        metavar="KIND",
        help="the fields of a trajectory of this kind, such as waypoints, with an example",
    )
    add_set(parser, "change a field (repeatable, all applied together)")
    add_json(parser)
    parser.set_defaults(command=_fields)

    parser = commands.add_parser(
        "laws",
        help="list the laws of friction compensation and their parameters",
        description="List the laws of friction compensation, with what each costs in a control "
        "period, and its parameters below variants.B.controller.compensation, with unit and range.",
    )
    add_json(parser)
    parser.set_defaults(command=_laws)

    parser = commands.add_parser(
        "new-law",
        help="write the file of a law, or of an effect of the plant, of one's own",
        description="Write a law to begin with, PD with static friction, or an effect of the plant,"
        " a cable, as a file of 15 lines.",
        epilog=_NEW_LAW,
    )
    parser.add_argument("name", metavar="NAME", help="of the law: small letters, digits and -")
    parser.add_argument(
        "--folder", metavar="FOLDER", type=Path, default=Path("laws"), help="(%(default)s)"
    )
    parser.add_argument(
        "--effect", action="store_true", help="an effect of the plant, such as friction, instead"
    )
    parser.set_defaults(command=_new_law)

    parser = commands.add_parser(
        "check-law",
        help="check the file of a law or an effect of one's own, as a server does",
        description="Import, compile and run a law or an effect in a process of its own, with "
        "bounds of time and memory, and say with file and line why it cannot be taken.",
    )
    parser.add_argument("file", metavar="FILE", type=Path)
    add_json(parser)
    parser.set_defaults(command=_check_law)


def _fields(options: argparse.Namespace) -> int:
    from motionlab.config.changes import parse_assignments
    from motionlab.config.fields import values_of
    from motionlab.config.load import load_scenario
    from motionlab.reports.tables import table

    if options.kind is None:
        scenario = load_scenario(source(options), parse_assignments(options.assignments))
        entries = _matching(list(values_of(scenario)), options.pattern)
    else:
        entries = _matching(_of_kind(options.kind), options.pattern)
    if options.json:
        print(json.dumps([each._asdict() for each in entries], allow_nan=False))
        return DONE
    heads = ("field", "value", "unit", "allowed", "meaning")
    rows = [(f.path, _text(f.value), f.unit, f.range, f.description) for f in entries]
    show(table(heads, rows))
    if options.kind is not None:
        from motionlab.config.trajectory import EXAMPLES

        print(f"\ntrajectory = {{ kind = '{options.kind}', {EXAMPLES[options.kind]} }}")
    return DONE


def _of_kind(kind: str) -> list[FieldValue]:
    """Return the fields of a kind of trajectory, with the values of its example.

    Raises
    ------
    ConfigError
        If there is no such kind.
    """
    from motionlab.config.fields import values_of
    from motionlab.config.named_configs import did_you_mean
    from motionlab.config.trajectory import KINDS, example
    from motionlab.errors import ConfigError, FieldError

    if kind not in KINDS:
        message = f"no such kind of trajectory{did_you_mean(kind, list(KINDS))}"
        raise ConfigError(FieldError("--kind", message, kind, f"one of {', '.join(KINDS)}"))
    fields = values_of(example(kind))
    return [each._replace(path=f"trajectory.{each.path}") for each in fields]


def _matching(fields: list[FieldValue], pattern: str) -> list[FieldValue]:
    """Return the fields whose path fits, or whose meaning has the words.

    Raises
    ------
    ConfigError
        If none does.
    """
    from motionlab.config.named_configs import did_you_mean
    from motionlab.errors import ConfigError, FieldError

    wild = any(sign in pattern for sign in "*?[")
    matching = [
        each
        for each in fields
        if (
            fnmatch.fnmatchcase(each.path, pattern)
            if wild
            else pattern in each.path or pattern.lower() in each.description.lower()
        )
    ]
    if matching:
        return matching
    words = sorted({word for each in fields for word in (each.path, *each.path.split("."))})
    message = f"fits no field{did_you_mean(pattern, words)}"
    allowed = "part of a path such as plant.x.mass, one with *, or a word of a meaning"
    raise ConfigError(FieldError("PATTERN", message, pattern, allowed))


def _text(value: Any) -> str:
    if value is None:
        return "-"
    text = f"{value:.10g}" if isinstance(value, float) else value
    text = text if isinstance(text, str) else json.dumps(text)
    line = " ".join(text.split())
    return line if len(line) <= _LONG else line[: _LONG - 3] + "..."


def _laws(options: argparse.Namespace) -> int:
    from motionlab.config.controller import CompensationConfig
    from motionlab.config.fields import values_of
    from motionlab.laws import LAWS, PROBLEMS, base_of
    from motionlab.own_laws.cost import cost_of
    from motionlab.reports.tables import table

    of = {each.path: each for each in values_of(CompensationConfig())}
    laws = [
        {
            "name": law.name,
            "title": law.label,
            "description": law.description,
            "source": law.source,
            "cost": cost_of(law.name).model_dump(),
            "parameters": [of[each.name]._asdict() for each in law.parameters],
        }
        for law in LAWS.values()
        if law.name == base_of(law.name)  # nothing is saved meanwhile
    ]
    for problem in PROBLEMS:
        print(f"motionlab: not taken: {problem}", file=sys.stderr)
    if options.json:
        print(json.dumps(laws, allow_nan=False))
        return DONE
    rows = []
    for law in laws:
        cost = f"{law['cost']['ns']:.2g}", f"{100.0 * law['cost']['share']:.2g} % of a tick"
        rows.append((law["name"], cost[0], "ns", cost[1], law["description"]))
        for each in law["parameters"]:
            cells = (_text(each["value"]), each["unit"], each["range"], each["description"])
            rows.append((f"  {each['path']}", *cells))
    show(table(("law, parameter", "default", "unit", "allowed", "meaning"), rows))
    return DONE


def _new_law(options: argparse.Namespace) -> int:
    from motionlab.own_laws.template import write_template

    path = write_template(options.name, options.folder, effect=options.effect)
    print(path)
    change = (
        f"'plant.x.effects=[{{effect = \"{options.name}\"}}]'"
        if options.effect
        else f"variants.B.controller.compensation.law={options.name}"
    )
    say(f"motionlab run circle --laws {options.folder} --set {change}")
    return DONE


def _cost(ns: float | None, share: float | None) -> str:
    if ns is None or share is None:
        return ""
    if ns == 0.0:
        return "; what it costs in a control period is too little to be measured"
    return f"; it costs {ns:.2g} ns in a control period, {100.0 * share:.2g} % of it"


def _check_law(options: argparse.Namespace) -> int:
    from motionlab.own_laws.check import check_file

    if not options.file.is_file():
        raise ConfigError(FieldError("FILE", "is no file", str(options.file)))
    result = check_file(options.file.resolve())
    if options.json:
        print(json.dumps(dataclasses.asdict(result)))
    elif result.problems:
        for problem in result.problems:
            print(problem)
    else:
        print(f"{result.name}: can be taken{_cost(result.ns, result.share)}")
    return FAILED if result.problems else DONE
