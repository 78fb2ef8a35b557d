"""Spectra of columns as a document, a following error's beside the response of its own loop."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, Field

from motionlab.analysis.spectrum import (
    AVERAGES_MAX,
    Bands,
    Peak,
    Spectrum,
    Window,
    decibels_above,
    level,
    longest_whole,
    peaks,
    spectrum,
    thinned,
)
from motionlab.config.scenario import Scenario
from motionlab.errors import ConfigError, FieldError
from motionlab.library.library import library
from motionlab.library.recorded import scenario_of
from motionlab.library.run import RunDetail
from motionlab.library.telemetry import check_columns, read_columns
from motionlab.loop.disturbance import DisturbanceResponse, disturbance_response
from motionlab.telemetry.expressions.columns import MathChannel
from motionlab.telemetry.parquet import read_ticks

Array = NDArray[np.float64]

COLUMNS_MAX = 8
"""Most columns of one document."""

POINTS_MAX = 20_000
"""Most points of a curve."""

SAMPLES_MAX = 2_000_000
"""Most samples of a column."""

OWN = 6.0
"""A peak that stands less above the loop's own response is the loop's, dB."""

_DIGITS = 6
_ERROR = re.compile(r"([A-Z])\.([xy])\.following_error")


class SpectrumOptions(BaseModel):
    """Settings of spectra, and the frequency range to return."""

    window: Window = Field(default="hann", description="Window function")
    averages: int = Field(
        default=8,
        ge=1,
        le=AVERAGES_MAX,
        description="Segments, overlapping by half; 1: no average",
        examples=[4],
    )
    low: float | None = Field(
        default=None,
        gt=0,
        le=1e9,
        allow_inf_nan=False,
        description="Least frequency, Hz",
        examples=[10],
    )
    high: float | None = Field(
        default=None,
        gt=0,
        le=1e9,
        allow_inf_nan=False,
        description="Largest frequency, Hz",
        examples=[500],
    )
    points: int = Field(
        default=2000,
        ge=10,
        le=POINTS_MAX,
        description="Points of a curve at most; fewer bins are all sent",
    )


class SpectrumPeak(BaseModel):
    """A peak that stands out."""

    frequency: float = Field(description="Interpolated, Hz")
    kind: Literal["line", "broad", "loop"] = Field(
        description="line: as narrow as the window resolves; broad; loop: the loop's own, less "
        "than 6 dB above its response"
    )
    amplitude: float | None = Field(description="Peak value of a line; null of a broad peak")
    rms: float = Field(description="Of the line, or of the broad peak above half its density")
    density: float = Field(description="At its highest, unit^2/Hz")
    above_loop: float | None = Field(
        description="10 log10 of density over that of `loop`, dB; null without one"
    )


class LoopResponse(BaseModel):
    """Response of the linearised loop to a white disturbance and to quantisation of the encoder."""

    variant: str
    axis: str
    velocity: float = Field(description="About which the loop is linearised, m/s; 0: stuck")
    force: float = Field(
        description="White disturbance of the thrust that explains the median of the spectrum, a "
        "fit, N/sqrt(Hz)"
    )
    count: float = Field(description="Noise of the encoder's counts, m/sqrt(Hz)")
    frequency: list[float] = Field(description="Hz")
    density: list[float] = Field(description="Of the following error by both, m^2/Hz")
    gain: list[float] = Field(description="Following error by a disturbance of the thrust, m/N")


class ColumnSpectrum(BaseModel):
    """The spectrum of the longest stretch of a column without missing samples."""

    name: str
    unit: str
    start: int = Field(description="First sample")
    stop: int = Field(description="Sample after the last")
    missing: int = Field(description="Samples asked for that are not in the stretch")
    resolution: float = Field(description="Distance of the bins, Hz")
    noise_bandwidth: float = Field(description="Of a bin, Hz")
    bins: int = Field(description="Of the whole spectrum")
    rms: float = Field(description="Of the stretch without its mean")
    frequency: list[float] = Field(description="Of bins: the least and largest of each step, Hz")
    density: list[float] = Field(description="Power spectral density, one-sided, unit^2/Hz")
    amplitude: list[float] = Field(description="Peak value of a sine at that frequency")
    cumulative: list[float] = Field(description="RMS of all at this frequency and below")
    peaks: list[SpectrumPeak] = Field(description="The strongest, by frequency")
    loop: LoopResponse | None = Field(description="null where there is none")
    note: str = Field(description="Why there is no response of a loop; empty otherwise")


class SpectrumDocument(BaseModel):
    """Spectra of some columns."""

    period: float = Field(description="Time between samples, s")
    window: Window
    averages: int
    columns: list[ColumnSpectrum]


class Samples(NamedTuple):
    """A column of samples, NaN where they are missing, and where the first lies."""

    name: str
    unit: str
    values: Array
    start: int = 0


class OwnLoop(NamedTuple):
    """The loop that a following error is of, and the velocity about which it is linearised."""

    scenario: Scenario
    variant: str
    axis: Literal["x", "y"]
    velocity: float


NO_LOOP = "only a following error has a loop"
"""Why other columns have none."""


def error_of(column: str) -> tuple[str, Literal["x", "y"]] | None:
    """Return variant and axis of a following error, or None for another column."""
    match = _ERROR.fullmatch(column)
    return (match[1], "x" if match[2] == "x" else "y") if match else None


class Taken(NamedTuple):
    """The whole spectrum of a column, its peaks, and the response of its loop."""

    samples: Samples
    part: slice
    spectrum: Spectrum
    peaks: list[SpectrumPeak]
    loop: LoopResponse | None
    note: str


def take(
    samples: Samples, options: SpectrumOptions, *, period: float, loop: OwnLoop | str
) -> Taken:
    """Return the spectrum of a column.

    Parameters
    ----------
    samples : Samples
        The column; its longest stretch without a missing sample is taken.
    options : SpectrumOptions
        Window and averages.
    period : float
        Time between samples, s.
    loop : OwnLoop or str
        Its loop, or why there is none.

    Raises
    ------
    ConfigError
        If the stretch is too long, or too short for so many segments.
    """
    part = longest_whole(samples.values)
    if part.stop - part.start > SAMPLES_MAX:
        bounds: dict[str, float] = {"maximum": SAMPLES_MAX}
        count = part.stop - part.start
        raise ConfigError(FieldError("samples", "too many for one spectrum", count, bounds=bounds))
    density = spectrum(
        samples.values[part], period=period, window=options.window, averages=options.averages
    )
    strongest, bands = peaks(density)
    note, own = (loop, None) if isinstance(loop, str) else _own(loop)
    if own is None or isinstance(loop, str):
        rows = [_row(peak, None, own=False) for peak in strongest]
        return Taken(samples, part, density, rows, None, note)
    shape = _Expected.fitted(own, bands, counts=_counts(loop, period))
    return Taken(
        samples,
        part,
        density,
        [shape.row(peak, bands) for peak in strongest],
        LoopResponse(
            variant=loop.variant,
            axis=loop.axis,
            velocity=loop.velocity,
            force=shape.force**0.5,
            count=shape.counts**0.5,
            frequency=_figures(own.frequency),
            density=_figures(shape.at(own.frequency)),
            gain=_figures(own.force),
        ),
        "",
    )


def run_spectra(
    run_id: str, columns: Sequence[str], start: int, stop: int | None, options: SpectrumOptions
) -> tuple[list[Taken], float]:
    """Return the spectra of some columns of a run, and the time between its samples, s.

    Parameters
    ----------
    run_id : str
        The run.
    columns : sequence of str
        Their names, or expressions as ``name=expression``.
    start, stop : int or None
        Samples [start, stop); None is the end of the run.
    options : SpectrumOptions
        Window and averages.

    Raises
    ------
    Unknown
        If there is no such run.
    Busy
        If it is being recorded.
    ConfigError
        If a column is not there, or there are too many of them or of samples, or too few samples.
    """
    run = library().complete(run_id)
    stop = min(stop or run.ticks, run.ticks)
    if len(columns) > COLUMNS_MAX:
        most: dict[str, float] = {"maximum": COLUMNS_MAX}
        raise ConfigError(FieldError("columns", "too many", len(columns), bounds=most))
    if not 0 < stop - start <= SAMPLES_MAX:
        ends: dict[str, float] = {"exclusive_minimum": start, "maximum": start + SAMPLES_MAX}
        raise ConfigError(FieldError("to", "too few or too many samples", stop, bounds=ends))
    with library().files.open(run_id) as file:
        math = check_columns(file, columns, run.period)
        units = {column["name"]: column["unit"] for column in run.columns}
        units |= {text: each.program.unit for text, each in math.items()}
        known = set(file.schema_arrow.names)
        taken = []
        for name in columns:
            values = read_columns(file, [name], _only(math, name), start, stop)[0]
            speed = None
            error = error_of(name)
            if error and (velocity := f"{error[1]}.velocity_reference") in known:
                reference = read_ticks(file, [velocity], start, stop)[0]
                speed = float(np.nanmedian(np.abs(reference)))
            samples = Samples(name, units[name], values.astype(np.float64), start)
            own = _loop_of(run, name, speed, start, stop)
            taken.append(take(samples, options, period=run.period, loop=own))
    return taken, run.period


def _only(math: Mapping[str, MathChannel], name: str) -> dict[str, MathChannel]:
    return {name: math[name]} if name in math else {}


def _loop_of(
    run: RunDetail, column: str, speed: float | None, start: int, stop: int
) -> OwnLoop | str:
    """Return the loop of a column as it was at the first sample, or why there is none."""
    error = error_of(column)
    if error is None:
        return NO_LOOP
    if run.scenario_document is None or speed is None or not np.isfinite(speed):
        return "the run has no scenario, and so no loop that is known"
    variant, axis = error
    about = f"variants.{variant}", "plant"
    scenario = scenario_of(run, start, stop, lambda path: path.startswith(about))
    if isinstance(scenario, str):
        return scenario
    return OwnLoop(scenario, variant, axis, speed)


def document(taken: list[Taken], options: SpectrumOptions, *, period: float) -> SpectrumDocument:
    """Return spectra as a document, thinned to the frequencies and points that are wanted.

    Raises
    ------
    ConfigError
        If there is no bin between the frequencies.
    """
    return SpectrumDocument(
        period=period,
        window=options.window,
        averages=options.averages,
        columns=[_column(each, options) for each in taken],
    )


def _column(taken: Taken, options: SpectrumOptions) -> ColumnSpectrum:
    samples, density = taken.samples, taken.spectrum
    low, high = options.low or 0.0, options.high or density.frequency[-1]
    first = int(np.searchsorted(density.frequency, low))
    stop = int(np.searchsorted(density.frequency, high, side="right"))
    if stop <= first:
        ends: dict[str, float] = {"maximum": float(density.frequency[-1])}
        message = "there is no bin between the least and the largest frequency"
        raise ConfigError(FieldError("low", message, options.low, unit="Hz", bounds=ends))
    own = first + thinned(
        density.density[first:stop], density.frequency[first:stop], options.points
    )
    loop = taken.loop
    if loop is not None:
        inside = [
            i for i, f in enumerate(loop.frequency) if max(low, density.resolution) <= f <= high
        ]
        curves = {
            name: [getattr(loop, name)[i] for i in inside]
            for name in ("frequency", "density", "gain")
        }
        loop = loop.model_copy(update=curves)
    return ColumnSpectrum(
        name=samples.name,
        unit=samples.unit,
        start=samples.start + taken.part.start,
        stop=samples.start + taken.part.stop,
        missing=len(samples.values) - (taken.part.stop - taken.part.start),
        resolution=density.resolution,
        noise_bandwidth=density.noise_bandwidth,
        bins=len(density.frequency),
        rms=density.rms,
        frequency=_figures(density.frequency[own]),
        density=_figures(density.density[own]),
        amplitude=_figures(density.amplitude[own]),
        cumulative=_figures(density.cumulative[own]),
        peaks=taken.peaks,
        loop=loop,
        note=taken.note,
    )


class _Expected(NamedTuple):
    """The following error's density by white force and white encoder noise."""

    response: DisturbanceResponse
    force: float  # N^2/Hz
    counts: float  # m^2/Hz

    @classmethod
    def fitted(cls, response: DisturbanceResponse, bands: Bands, *, counts: float) -> _Expected:
        shape, noise = (_at(bands.frequency, response, each) for each in response[1:3])
        return cls(response, level(bands, shape**2, counts * noise**2), counts)

    def at(self, frequency: Array) -> Array:
        shape, noise = (_at(frequency, self.response, each) for each in self.response[1:3])
        return self.force * shape**2 + self.counts * noise**2

    def row(self, peak: Peak, bands: Bands) -> SpectrumPeak:
        """Return a peak, compared with the response of the loop to a white disturbance.

        A line is the loop's own only if its response also rises as high beside its surroundings.
        """
        expected = float(self.at(np.array([peak.frequency]))[0])
        above = 10.0 * math.log10(peak.density / expected) if expected > 0.0 else None
        own = above is not None and above < OWN
        if own and peak.narrow:
            beside = decibels_above(peak, bands, self.at(bands.frequency), expected)
            own = beside is not None and beside < OWN
        return _row(peak, above, own=own)


def _at(frequency: Array, response: DisturbanceResponse, values: Array) -> Array:
    return np.exp(np.interp(np.log(frequency), np.log(response.frequency), np.log(values)))


def _own(loop: OwnLoop) -> tuple[str, DisturbanceResponse | None]:
    """Return the responses of a loop, or why there are none."""
    try:
        response = disturbance_response(loop.scenario, loop.variant, loop.axis, v=loop.velocity)
    except ConfigError as error:
        return str(error), None
    if not response.stable:
        return f"the loop linearised about {1e3 * loop.velocity:.3g} mm/s is unstable", None
    return "", response


def _counts(loop: OwnLoop, period: float) -> float:
    """Return the one-sided density of counts as white noise, q^2/12 up to half the rate, m^2/Hz."""
    count: float = getattr(loop.scenario.plant, loop.axis).encoder.resolution
    return count**2 / 6.0 * period


def _row(peak: Peak, above: float | None, *, own: bool) -> SpectrumPeak:
    return SpectrumPeak(
        frequency=peak.frequency,
        kind="loop" if own else "line" if peak.narrow else "broad",
        amplitude=math.sqrt(2.0) * peak.rms if peak.narrow else None,
        rms=peak.rms,
        density=peak.density,
        above_loop=above,
    )


def _figures(values: Array) -> list[float]:
    return [float(f"{value:.{_DIGITS}g}") for value in values.tolist()]
