"""The command ``motionlab spectrum``."""

from __future__ import annotations

import argparse
import csv
import json
from typing import TYPE_CHECKING, Any

from motionlab.cli.output import add_overwrite, check_output, show, wrote
from motionlab.errors import DONE
from motionlab.studies.options import add_json

if TYPE_CHECKING:
    from motionlab.library.run import Run
    from motionlab.studies.spectrum import Taken

EXAMPLES = """\
examples:
  motionlab spectrum r-gpd6hecc7x3n --column B.x.following_error
  motionlab spectrum r-gpd6hecc7x3n --column A.x.following_error --column B.x.following_error \\
      --from 4.5 --to 10.5 --averages 4 --out spectrum.csv

`motionlab docs spectrum` defines lines, broad peaks and peaks of the loop.
"""


def add(commands: Any) -> None:
    """Add ``motionlab spectrum``."""
    parser = commands.add_parser(
        "spectrum",
        help="find the lines and peaks of a run over frequency",
        description="Take the spectrum of columns of a kept run.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("run", metavar="RUN", help="identifier or name of a run")
    parser.add_argument(
        "--column", action="append", required=True, metavar="NAME", help="column; repeatable"
    )
    parser.add_argument(
        "--from", dest="start", metavar="S", type=float, help="first time, s (default: the first)"
    )
    parser.add_argument(
        "--to", dest="end", metavar="S", type=float, help="last time, s (default: the last)"
    )
    parser.add_argument(
        "--window",
        default="hann",
        help="hann, rectangular, blackman-harris or flat-top (default: %(default)s)",
    )
    parser.add_argument(
        "--averages",
        type=int,
        default=8,
        help="segments; 1 is no average (default: %(default)s)",
    )
    parser.add_argument("--out", metavar="FILE", help="every bin as CSV")
    add_overwrite(parser)
    add_json(parser)
    parser.set_defaults(command=_spectrum)


def _spectrum(options: argparse.Namespace) -> int:
    from motionlab.config.validation_errors import checked
    from motionlab.library.library import library
    from motionlab.studies.spectrum import SpectrumOptions, document, run_spectra

    settings = checked(
        SpectrumOptions, {"window": options.window, "averages": options.averages}, "spectrum"
    )
    if options.out:
        check_output(options.out, ".csv", overwrite=options.overwrite)
    run = library().get(library().named(options.run))
    first, stop = _samples(options, run)
    taken, period = run_spectra(run.id, options.column, first, stop, settings)
    if options.out:
        _write(options.out, taken)
        wrote(options.out)
    spectra = document(taken, settings, period=period)
    if options.json:
        print(json.dumps(spectra.model_dump(mode="json")))
    else:
        from motionlab.reports.document_text import document_text

        show(document_text(spectra))
    return DONE


def _samples(options: argparse.Namespace, run: Run) -> tuple[int, int | None]:
    """Return the first sample that is wanted and the one after the last."""
    from motionlab.errors import ConfigError, FieldError

    bounds: dict[str, float] = {"minimum": 0.0, "maximum": run.duration}
    for name, time in (("--from", options.start), ("--to", options.end)):
        if time is not None and not 0.0 <= time <= run.duration:
            raise ConfigError(FieldError(name, "is not in the run", time, bounds=bounds, unit="s"))
    first = round((options.start or 0.0) / run.period)
    return first, None if options.end is None else round(options.end / run.period) + 1


def _write(path: str, taken: list[Taken]) -> None:
    """Write every bin of every column, one column below another, as CSV."""
    from motionlab.files import complete_file

    with complete_file(path) as part, part.open("w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(["column", "frequency [Hz]", "density", "amplitude", "cumulative RMS"])
        for each in taken:
            spectrum = each.spectrum
            curves = (spectrum.frequency, spectrum.density, spectrum.amplitude, spectrum.cumulative)
            for values in zip(*(curve.tolist() for curve in curves), strict=True):
                rows.writerow([each.samples.name, *(f"{value:.9g}" for value in values)])
