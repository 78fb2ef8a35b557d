"""The commands ``motionlab export`` and ``motionlab import``: runs as files of other tools."""

from __future__ import annotations

import argparse
import contextlib
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from motionlab.cli.exit_codes import DONE

if TYPE_CHECKING:
    from motionlab.runs.exports import Source

EXPORT_EXAMPLES = """\
examples:
  motionlab export r-abcdefghijkl circle.mat
  motionlab export r-abcdefghijkl circle.mcap --columns x.position_reference,A.x.following_error
  motionlab export run.parquet last.csv --from 2.5 --to 3

docs/exchange.md describes the formats.
"""


def add(commands: Any) -> None:
    """Add ``motionlab export`` and ``motionlab import``."""
    parser = commands.add_parser(
        "export",
        help="write a run as CSV, Parquet, MAT or MCAP",
        description="Write a run, or a part of it, for other tools.",
        epilog=EXPORT_EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("run", metavar="RUN", help="a kept run, or a file of motionlab run --out")
    parser.add_argument("file", metavar="FILE", help="file to write: .csv, .parquet, .mat or .mcap")
    parser.add_argument(
        "--columns", metavar="A,B", default="", help="channels to write (default: all)"
    )
    parser.add_argument(
        "--from", dest="start", metavar="S", type=float, help="first time, s (default: the first)"
    )
    parser.add_argument(
        "--to", dest="end", metavar="S", type=float, help="last time, s (default: the last)"
    )
    parser.set_defaults(command=_export)


def _export(options: argparse.Namespace) -> int:
    from motionlab.runs.exports import check_selection, export, within
    from motionlab.runs.selection import FORMATS, Selection
    from motionlab.store.files import check_target, complete_file

    check_target(options.file, *(f".{name}" for name in FORMATS), loc="FILE")
    columns = tuple(options.columns.split(",")) if options.columns else ()
    with _source(options.run) as source:
        selection = within(source, Selection(columns), options.start, options.end)
        selection = check_selection(source, selection)
        with complete_file(options.file) as part:
            export(source, selection, part, Path(options.file).suffix[1:])
    return DONE


@contextlib.contextmanager
def _source(run: str) -> Iterator[Source]:
    """Open a run by its identifier, or a file."""
    from motionlab.errors import ConfigError, FieldError, Unknown
    from motionlab.runs.exports import Source
    from motionlab.runs.library import library
    from motionlab.runs.run import is_id

    if not is_id(run):
        source = Source.of_file(Path(run))
    else:
        try:
            found = library().complete(run)
        except Unknown as error:
            raise ConfigError(FieldError("RUN", str(error))) from None
        source = Source.of(library().files.open(run), found)
    with source.file:
        yield source
