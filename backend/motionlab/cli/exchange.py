"""The commands ``motionlab export`` and ``motionlab import``: runs as files of other tools."""

from __future__ import annotations

import argparse
import contextlib
import dataclasses
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from motionlab.cli.output import add_overwrite, check_output, wrote
from motionlab.errors import BAD_INPUT, DONE
from motionlab.studies.options import add_json

if TYPE_CHECKING:
    from motionlab.exchange.exports import Source
    from motionlab.exchange.measurements.document import Import, ImportedColumn, Merged

EXPORT_EXAMPLES = """\
examples:
  motionlab export r-abcdefghijkl circle.mat
  motionlab export r-abcdefghijkl circle.mcap --columns x.position_reference,A.x.following_error
  motionlab export run.parquet last.csv --from 2.5 --to 3
  motionlab export run.parquet power.csv --columns 'power=A.x.thrust*A.x.velocity'

`motionlab docs exchange` describes the formats.
"""

IMPORT_EXAMPLES = """\
examples:
  motionlab import rig.csv --preview
  motionlab import rig.csv --map 'Pos=M.x.position_measured[um]' --map Temp=- --name 'rig 7'
  motionlab import currents.mat --rate 10000
  motionlab import drive.mat --map 'u=M.x.thrust[35.15 N]' --map 'q=M.x.position_measured[m]'
  motionlab import drive.csv sensor.csv --align Torque=Force --preview

`motionlab docs exchange` has the channels and what is guessed.
"""

_DELIMITERS = ("comma", "semicolon", "tab")
_DECIMALS = ("point", "comma")
"""As in `motionlab.exchange.measurements.document`, whose import would slow down ``--help``."""


def add(commands: Any) -> None:
    """Add ``motionlab export`` and ``motionlab import``."""
    parser = commands.add_parser(
        "export",
        help="write a run as CSV, Parquet, MAT, MCAP or MDF",
        description="Write a run, or a part of it, for other tools.",
        epilog=EXPORT_EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "run",
        metavar="RUN",
        help="identifier or name of a kept run, or a file of motionlab run --out",
    )
    parser.add_argument(
        "file", metavar="FILE", help="file to write: .csv, .parquet, .mat, .mcap or .mf4"
    )
    parser.add_argument(
        "--columns",
        metavar="A,B",
        default="",
        help="channels to write, or NAME=EXPRESSION (default: all channels)",
    )
    parser.add_argument(
        "--from", dest="start", metavar="S", type=float, help="first time, s (default: the first)"
    )
    parser.add_argument(
        "--to", dest="end", metavar="S", type=float, help="last time, s (default: the last)"
    )
    add_overwrite(parser)
    parser.set_defaults(command=_export)

    parser = commands.add_parser(
        "import",
        help="keep a measurement of a real machine as a run",
        description="Keep CSV, Parquet, MAT, NPZ or MCAP of a real machine as a run. What is not "
        "said of its columns is guessed from names, units and ranges, and printed. A second file "
        "of the same motion is merged on the time of the first.",
        epilog=IMPORT_EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "files",
        metavar="FILE",
        nargs="+",
        help="one file, or two with a clock each; the content decides the format",
    )
    parser.add_argument(
        "--map",
        dest="mapping",
        metavar="COLUMN=CHANNEL[UNIT]",
        action="append",
        default=[],
        help="what a column is (repeatable): a channel, time, - to leave it out, or nothing to "
        "keep it under its own name; the unit may have a factor, [35.15 N]",
    )
    parser.add_argument(
        "--rate", metavar="HZ", type=float, help="sample rate of a file without time"
    )
    parser.add_argument(
        "--resample", metavar="HZ", type=float, help="interpolate to this rate (default: do not)"
    )
    parser.add_argument(
        "--delimiter", choices=_DELIMITERS, default="", help="of CSV (default: found out)"
    )
    parser.add_argument(
        "--decimal", choices=_DECIMALS, default="", help="decimal sign of CSV (default: found out)"
    )
    parser.add_argument(
        "--align",
        metavar="A=B",
        default="",
        help="of two files: columns of the first and the second that show the same, A=-B with "
        "opposite signs, or COLUMN of both (default: one that both have)",
    )
    parser.add_argument(
        "--offset",
        metavar="S",
        type=float,
        help="of two files: what is added to times of the second (default: estimated)",
    )
    parser.add_argument("--name", metavar="TEXT", default="", help="what the run is called")
    parser.add_argument("--preview", action="store_true", help="keep nothing, show how it is read")
    add_json(parser)
    parser.set_defaults(command=_import)


def _export(options: argparse.Namespace) -> int:
    from motionlab.exchange.exports import check_selection, export, within
    from motionlab.exchange.selection import FORMATS, Selection
    from motionlab.files import complete_file
    from motionlab.telemetry.expressions.columns import split_columns

    suffixes = (f".{name}" for name in FORMATS)
    check_output(options.file, *suffixes, overwrite=options.overwrite, loc="FILE")
    columns = tuple(split_columns(options.columns)) if options.columns else ()
    with _source(options.run) as source:
        selection = within(source, Selection(columns), options.start, options.end)
        selection = check_selection(source, selection)
        with complete_file(options.file) as part:
            export(source, selection, part, Path(options.file).suffix[1:])
    wrote(options.file)
    return DONE


def _import(options: argparse.Namespace) -> int:
    from motionlab.errors import ConfigError, FieldError
    from motionlab.exchange.measurements.document import ImportOptions
    from motionlab.exchange.measurements.runs import import_file
    from motionlab.library.library import library
    from motionlab.library.run import check_name

    paths = [Path(file) for file in options.files]
    for path in paths:
        if not path.is_file():
            raise ConfigError(FieldError("FILE", "is no file", str(path)))
    path, *others = paths
    if len(others) > 1:
        raise ConfigError(FieldError("FILE", "too many files", len(paths), "one or two"))
    for loc, value in (("--align", options.align or None), ("--offset", options.offset)):
        if value is not None and not others:
            raise ConfigError(FieldError(loc, "is of two files", value))
    check_name(options.name, "--name")
    reading = ImportOptions(
        name=options.name,
        rate=options.rate,
        resample=options.resample,
        mapping=tuple(options.mapping),
        delimiter=options.delimiter,
        decimal=options.decimal,
        align=options.align,
        offset=options.offset,
    )
    kept_in = None if options.preview else library()
    second = others[0] if others else None
    document, _ = import_file(path, reading, library=kept_in, name=path.name, second=second)
    if options.json:
        print(document.model_dump_json())
    else:
        print(_described(document))
    for problem in document.problems:
        print(f"motionlab: {path}: {problem}", file=sys.stderr)
    return BAD_INPUT if document.problems and not options.preview else DONE


def _empty(column: ImportedColumn) -> str:
    """Return what is to be said of rows without a number."""
    return f"; {column.missing} empty, first at {column.missing_at}" if column.missing else ""


def _described(document: Import) -> str:
    """Return for people how a file is read."""
    from motionlab.reports.tables import table

    text = document.text
    form = f", {text['delimiter']}, decimal {text['decimal']}" if text else ""
    lines = [f"{document.format}{form}: {document.rows} rows"]
    if document.rate is not None:
        lines.append(
            f"{document.rate:.6g} Hz from {document.rate_from}, {document.duration:.6g} s, "
            f"jitter {1e6 * (document.jitter or 0.0):.3g} us"
        )
    if document.resampled is not None:
        lines.append(
            f"resampled from {document.resampled:.6g} Hz, median rate "
            f"{document.median_rate:.6g} Hz, by linear interpolation"
        )
    if document.merged is not None:
        lines.append(_merged(document.merged))
    lines += [
        f"gap of {gap.samples} {'sample' if gap.samples == 1 else 'samples'} "
        f"from {gap.start:.6g} s to {gap.end:.6g} s"
        for gap in document.gaps
    ]
    if document.gap_count > len(document.gaps):
        lines.append(f"{document.gap_count} gaps, {document.missing} samples")
    rows = [
        (column.column, column.name or column.channel, column.unit, column.why + _empty(column))
        for column in document.columns
    ]
    lines += [f"  {line}" for line in table(("", "", "", ""), rows).splitlines()]
    lines += [f"  {name}: computed" for name in document.derived]
    lines += [f"  {name}: not read, {why}" for name, why in document.ignored.items()]
    lines += [f"  {note}" for note in document.notes]
    if document.run is not None:
        lines.append(f"kept as {document.run}")
    return "\n".join(lines)


def _merged(merged: Merged) -> str:
    text = f"second file: {merged.rows} rows, {merged.samples} of the first covered, "
    text += f"offset {1e3 * merged.offset:.6g} ms"
    if merged.offset_half_width is not None:
        text += f" +- {1e3 * merged.offset_half_width:.2g}"
    text += f", drift {1e6 * merged.drift:.4g} ppm"
    if merged.drift_half_width is not None:
        text += f" +- {1e6 * merged.drift_half_width:.2g}"
    if merged.correlation is None:
        return text
    return (
        f"{text}, by {merged.first!r} and {merged.second!r}, correlation {merged.correlation:.4f}"
    )


@contextlib.contextmanager
def _source(run: str) -> Iterator[Source]:
    """Open a run by identifier or name, or a file."""
    from motionlab.errors import ConfigError, FieldError, Unknown
    from motionlab.exchange.exports import Source
    from motionlab.library.library import library
    from motionlab.library.run import is_id

    if not is_id(run) and Path(run).is_file():
        source = Source.of_file(Path(run))
    else:
        try:
            detail = library().complete(_named(run))
        except Unknown as error:
            raise ConfigError(FieldError("RUN", str(error))) from None
        source = Source.of(library().files.open(detail.id), detail)
    with source.file:
        yield source


def _named(run: str) -> str:
    from motionlab.errors import ConfigError
    from motionlab.library.library import library

    try:
        return library().named(run)
    except ConfigError as error:
        (wrong,) = error.errors
        if wrong.message.startswith("no "):
            wrong = dataclasses.replace(wrong, message="no such file, and no kept run of that name")
        raise ConfigError(wrong) from None
