"""The loop over frequency: linearised, and by a frequency sweep of the simulation."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field

from motionlab.config.load import load_scenario
from motionlab.config.plant import OURS
from motionlab.config.quantity import quantity
from motionlab.config.scenario import Scenario
from motionlab.loop.linearise import linearise
from motionlab.loop.margins import NYQUIST, sampled
from motionlab.studies.loop.frequency_sweep import frequency_sweep
from motionlab.studies.study import Source
from motionlab.studies.tune.request import AxisRequest, read_request

Complex = NDArray[np.complex128]
Progress = Callable[[float, "FrequencySweepDocument | None"], None]

SWEPT = tuple(float(f"{f:.3g}") for f in np.geomspace(4.0, 400.0, 16))
"""Frequencies of a sweep, Hz."""

_Frequency = Annotated[float, Field(ge=1.0, le=0.9 * NYQUIST)]


class _Document(BaseModel):
    model_config = ConfigDict(extra="forbid")


def _si(description: str, unit: str) -> Any:
    return Field(description=description, json_schema_extra={"unit": unit})


class FrequencySweepRequest(AxisRequest):
    """Request of a frequency sweep."""

    frequencies: Annotated[
        tuple[_Frequency, ...], Field(strict=False, min_length=1, max_length=100)
    ] = quantity("Frequencies", unit="Hz", source=OURS, default=SWEPT)
    velocity: float = quantity(
        "Velocity of the slow motion that goes on meanwhile",
        unit="m/s",
        source=f"{OURS}: at rest a sweep measures the stuck machine",
        default=0.02,
        gt=0,
        le=0.2,
    )


def loaded(request: Mapping[str, Any]) -> tuple[AxisRequest, Scenario]:
    """Return a checked request and its scenario, which has the requested variant."""
    wanted = read_request(AxisRequest, request)
    scenario = load_scenario(wanted.scenario, wanted.set)
    wanted.chosen(scenario)
    return wanted, scenario


class LoopCurve(_Document):
    """A frequency response."""

    magnitude: list[float] = _si("Absolute value", "1")
    phase: list[float] = _si("Argument, unwrapped from the lowest frequency on", "rad")


class ResponseDocument(_Document):
    """The linearised loop of one axis over frequency, while it slides at one velocity."""

    variant: str
    axis: str
    velocity: float = _si("Sliding velocity", "m/s")
    frequency: list[float] = _si("Frequencies", "Hz")
    open: LoopCurve = Field(description="L = C P")
    closed: LoopCurve = Field(description="T = L/(1 + L)")
    sensitivity: LoopCurve = Field(description="S = 1/(1 + L)")


class FrequencySweepDocument(ResponseDocument):
    """The loop of one axis by a frequency sweep of the simulation, or part of it."""

    linearised: ResponseDocument = Field(description="The same loop, linearised at that velocity")


def response(request: AxisRequest, scenario: Scenario, *, v: float) -> ResponseDocument:
    """Return the linearised loop of one axis.

    Parameters
    ----------
    request : AxisRequest
        Which variant and axis.
    scenario : Scenario
        As loaded from it.
    v : float
        Sliding velocity, m/s.

    Raises
    ------
    ConfigError
        For the law ``published-k``, which has no linearisation.
    """
    variant = request.chosen(scenario)
    frequency, L = sampled(linearise(scenario, variant, request.axis, v=v).open)
    return ResponseDocument(**_table(request, variant, v, frequency, L))


def plan(
    request: FrequencySweepRequest, source: Source | None = None
) -> tuple[FrequencySweepRequest, Scenario]:
    """Return a request and its scenario, which has a linearisation."""
    scenario = load_scenario(request.scenario if source is None else source, request.set)
    linearise(scenario, request.chosen(scenario), request.axis, v=request.velocity)
    return request, scenario


def swept(
    planned: tuple[FrequencySweepRequest, Scenario], progress: Progress | None = None
) -> FrequencySweepDocument:
    """Return the loop of one axis by a frequency sweep of the simulation.

    Parameters
    ----------
    planned : tuple of FrequencySweepRequest and Scenario
        From `plan`.
    progress : callable, optional
        Called with the share done and the points so far.

    Raises
    ------
    ConfigError
        If a measurement would leave the stroke or the loop diverges.
    """
    request, scenario = planned
    variant = request.chosen(scenario)
    linearised = response(request, scenario, v=request.velocity)
    wanted = sorted(request.frequencies)
    frequency: list[float] = []
    L: list[complex] = []
    for done, f in enumerate(wanted):
        found = frequency_sweep(scenario, variant, request.axis, [f], v=request.velocity)
        frequency += found.frequency.tolist()
        L += found.open.tolist()
        if progress is not None:
            so_far = _table(request, variant, request.velocity, np.array(frequency), np.array(L))
            progress(
                (done + 1) / len(wanted), FrequencySweepDocument(**so_far, linearised=linearised)
            )
    made = _table(request, variant, request.velocity, np.array(frequency), np.array(L))
    return FrequencySweepDocument(**made, linearised=linearised)


def _table(
    request: AxisRequest, variant: str, v: float, frequency: NDArray[np.float64], L: Complex
) -> dict[str, Any]:
    return {
        "variant": variant,
        "axis": request.axis,
        "velocity": v,
        "frequency": _figures(frequency),
        "open": _curve(L),
        "closed": _curve(L / (1.0 + L)),
        "sensitivity": _curve(1.0 / (1.0 + L)),
    }


def _curve(values: Complex) -> LoopCurve:
    phase = np.unwrap(np.angle(values))
    # An open loop begins at -180 degrees or below; unwrapped from +180 it would lie a turn above.
    phase -= 2.0 * np.pi * np.round((phase[0] + 0.5 * np.pi) / (2.0 * np.pi))
    return LoopCurve(magnitude=_figures(np.abs(values)), phase=_figures(phase))


def _figures(values: NDArray[np.float64]) -> list[float]:
    return [float(f"{value:.6g}") for value in values]
