"""The command ``motionlab report``."""

from __future__ import annotations

import argparse
from typing import Any

from motionlab.cli.compare import add_comparing, comparing_of
from motionlab.cli.output import add_overwrite, check_output, wrote
from motionlab.errors import DONE

EXAMPLES = """\
examples:
  motionlab report r-gpd6hecc7x3n --out circle.html
  motionlab report r-gpd6hecc7x3n r-cb3v3zvyllhu --tolerance 1e-9,1e-3 --out regression.html

`motionlab docs report` says what is in it.
"""


def add(commands: Any) -> None:
    """Add ``motionlab report``."""
    parser = commands.add_parser(
        "report",
        help="write a run, or a comparison of two, as one HTML file",
        description="Write a report of a run, or of run B compared with run A, as one HTML file "
        "that needs nothing else. The options but --out are those of motionlab compare.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "run", metavar="RUN", help="identifier or name of a run; of two, the baseline"
    )
    parser.add_argument("other", metavar="RUN_B", nargs="?", help="the candidate")
    parser.add_argument("--out", metavar="FILE", required=True, help="file to write: .html")
    add_overwrite(parser)
    add_comparing(parser)
    parser.set_defaults(command=_report)


def _report(options: argparse.Namespace) -> int:
    from motionlab.files import complete_file
    from motionlab.reports.run_reports import comparison_report, run_report

    check_output(options.out, ".html", overwrite=options.overwrite)
    run = _complete("RUN", options.run)
    if options.other is None:
        content = run_report(run)
    else:
        other = _complete("RUN_B", options.other)
        content = comparison_report(run, other, comparing_of(options))
    with complete_file(options.out) as part:
        part.write_bytes(content)
    wrote(options.out)
    return DONE


def _complete(option: str, text: str) -> str:
    """Return the identifier of a run that is there, given that or its name."""
    from motionlab.errors import ConfigError, FieldError, Unknown
    from motionlab.library.library import library

    run_id = library().named(text, option)
    try:
        library().complete(run_id)
    except Unknown as error:
        allowed = "one that `motionlab runs` lists"
        raise ConfigError(FieldError(option, str(error), run_id, allowed)) from None
    return run_id
