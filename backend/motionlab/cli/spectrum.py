"""The command ``motionlab spectrum``."""

from __future__ import annotations

import argparse
import csv
import json
from typing import TYPE_CHECKING, Any

from motionlab.cli.exit_codes import DONE
from motionlab.cli.output import add_overwrite, check_output, show, wrote
from motionlab.studies.options import add_json

if TYPE_CHECKING:
    from motionlab.analysis.loop_spectrum import SpectrumOptions, SpectrumPeak, Taken
    from motionlab.library.run import Run

EXAMPLES = """\
examples:
  motionlab spectrum r-gpd6hecc7x3n --column B.x.following_error
  motionlab spectrum r-gpd6hecc7x3n --column A.x.following_error --column B.x.following_error \\
      --from 4.5 --to 10.5 --averages 4 --out spectrum.csv

`motionlab docs spectrum` defines lines, broad peaks and peaks of the loop.
"""
_UNITS = {"m": (1e9, "nm"), "N": (1e3, "mN"), "A": (1e3, "mA")}


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
    from motionlab.analysis.loop_spectrum import SpectrumOptions, document
    from motionlab.config.validation_errors import checked
    from motionlab.library.library import library
    from motionlab.library.spectrum import run_spectra

    wanted = checked(
        SpectrumOptions, {"window": options.window, "averages": options.averages}, "spectrum"
    )
    if options.out:
        check_output(options.out, ".csv", overwrite=options.overwrite)
    run = library().get(library().named(options.run))
    first, stop = _samples(options, run)
    taken, period = run_spectra(run.id, options.column, first, stop, wanted)
    if options.out:
        _write(options.out, taken)
        wrote(options.out)
    if options.json:
        print(json.dumps(document(taken, wanted, period=period).model_dump(mode="json")))
    else:
        show("\n".join(line for each in taken for line in _table(each, wanted, period)))
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


def _table(taken: Taken, options: SpectrumOptions, period: float) -> list[str]:
    from motionlab.reports.tables import table

    samples, part, found = taken.samples, taken.part, taken.spectrum
    factor, unit = _UNITS.get(samples.unit, (1.0, samples.unit))
    start, stop = (period * (samples.start + end) for end in (part.start, part.stop))
    lines = [
        f"{samples.name}: {start:g} to {stop:g} s, {options.window}, averages {options.averages}",
        f"  resolution {found.resolution:.4g} Hz, noise bandwidth {found.noise_bandwidth:.4g} Hz, "
        f"RMS {factor * found.rms:.4g} {unit}",
    ]
    if missing := len(samples.values) - (part.stop - part.start):
        lines.append(f"  longest stretch without a missing sample, {missing} left out")
    if taken.loop is None:
        lines.append(f"  no response of a loop: {taken.note}")
    else:
        lines.append(
            f"  loop about {1e3 * taken.loop.velocity:.3g} mm/s, fitted with "
            f"{1e3 * taken.loop.force:.3g} mN/sqrt(Hz)"
        )
    heads = ("Hz", "", f"amplitude {unit}", f"RMS {unit}", "above loop dB")
    found_peaks = table(heads, [_row(peak, factor) for peak in taken.peaks], right={0, 2, 3, 4})
    return lines + [f"  {line}" for line in found_peaks.splitlines()]


def _row(peak: SpectrumPeak, factor: float) -> tuple[str, ...]:
    amplitude = "-" if peak.amplitude is None else f"{factor * peak.amplitude:.4g}"
    above = "-" if peak.above_loop is None else f"{peak.above_loop:.1f}"
    rms = f"{factor * peak.rms:.4g}"
    return f"{peak.frequency:.3f}", peak.kind, amplitude, rms, above


def _write(path: str, taken: list[Taken]) -> None:
    """Write every bin of every column, one column below another, as CSV."""
    from motionlab.files import complete_file

    with complete_file(path) as part, part.open("w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(["column", "frequency [Hz]", "density", "amplitude", "cumulative RMS"])
        for each in taken:
            found = each.spectrum
            curves = (found.frequency, found.density, found.amplitude, found.cumulative)
            for values in zip(*(curve.tolist() for curve in curves), strict=True):
                rows.writerow([each.samples.name, *(f"{value:.9g}" for value in values)])
