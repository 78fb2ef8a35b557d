"""The command ``motionlab export-plant``."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from motionlab.cli.output import add_overwrite, check_output, wrote
from motionlab.errors import DONE
from motionlab.studies.options import add_scenario, add_set, source

EXAMPLES = """\
examples:
  motionlab export-plant circle --out plant.fmu
  motionlab export-plant circle --out plant.fmu --set plant=matched-resonant

`motionlab docs fmu` says what is in the FMU, and how to close a loop around it.
"""


def add(commands: Any) -> None:
    """Add ``motionlab export-plant``."""
    parser = commands.add_parser(
        "export-plant",
        help="write the motor as an FMU for Simulink and OpenModelica",
        description="Write the motor of a scenario as an FMU 3.0 for co-simulation: C99 sources, "
        "and a binary for this platform where a C compiler is found.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add_scenario(parser)
    parser.add_argument("-o", "--out", metavar="FILE", required=True, help="file to write, .fmu")
    add_overwrite(parser)
    add_set(parser, "change a field of the scenario (repeatable), as in motionlab run")
    parser.set_defaults(command=_export)


def _export(options: argparse.Namespace) -> int:
    from motionlab.config.changes import parse_assignments
    from motionlab.config.load import load_scenario
    from motionlab.export.plant import export_plant

    check_output(options.out, ".fmu", overwrite=options.overwrite)
    scenario = load_scenario(source(options), parse_assignments(options.assignments))
    done = export_plant(scenario, Path(options.out))
    wrote(options.out)
    print(f"motor of {scenario.name}, {done.built}")
    return DONE
