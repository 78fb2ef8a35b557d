"""The fitted model of a measured plant as a document, beside that of the linearised plant."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motionlab.studies.loop.frequency_sweep import ResponseDocument, loop_curve, loop_table
from motionlab.studies.response.documents import (
    FittedMode,
    FittedPlant,
    PlantValue,
    ResponseRequest,
)
from motionlab.studies.response.margins import BESIDE, measured_margins
from motionlab.studies.response.model import FittedModel, fit, fit_alike
from motionlab.studies.response.recorded import RecordedEstimate

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

NO_MODEL = "no model of mass, delay and modes comes near the plant at these frequencies"
_FAR = 0.3  # RMS distance from the lines, over their magnitude
_POINTS = 300  # of the curve, besides the measured lines
_ABOUT_MODE = np.linspace(-4.0, 4.0, 33)  # points there, in half widths of the peak
_BESIDE_MODE = np.geomspace(1.0 / BESIDE, BESIDE, 60)  # where notches against it act


def fitted_plant(
    request: ResponseRequest, variant: str, measured: RecordedEstimate, period: float
) -> FittedPlant | None:
    """Return the model of a measured plant; None if there are too few lines, or none is near.

    Parameters
    ----------
    request, variant
        Whose loop it is.
    measured : RecordedEstimate
        The plant at its lines, and the linearised loop.
    period : float
        For which each command is held, s.
    """
    f, of_plant = measured.frequency, measured.of_plant
    deviation = of_plant.deviation
    if of_plant.shared is not None:
        deviation = deviation * np.sqrt(of_plant.shared)
    model = fit(f, of_plant.response, deviation, period)
    if model is None:
        return None
    off = np.abs(model.response(f) / of_plant.response - 1.0)
    if np.sqrt(np.mean(off**2)) > _FAR:
        return None
    linearised = fit_alike(model, f, measured.loop.plant.response(f), deviation)
    values, modes = _values(model, linearised)
    grid = _frequencies(model, f)
    P = model.response(grid)
    L = P * measured.loop.controller.response(grid)
    zeros, poles, gain = model.zeros_poles_gain()
    half = of_plant.half_width / deviation
    return FittedPlant(
        mass=values["mass"],
        delay=values["delay"],
        lag=values.get("lag"),
        damping=values.get("damping"),
        stiffness=values.get("stiffness"),
        modes=modes,
        misfit=_short(model.misfit),
        residual=[_short(each) for each in np.abs(model.residual) / half],
        period=period,
        zeros=_pairs(zeros),
        poles=_pairs(poles),
        gain=gain,
        loop=ResponseDocument(**loop_table(request, variant, measured.velocity, grid, L)),
        plant=loop_curve(P),
        margins=measured_margins(grid, L),
    )


def _values(
    model: FittedModel, linearised: FittedModel | None
) -> tuple[dict[str, PlantValue], list[FittedMode]]:
    """Return parameters by their names, and modes, the lowest first."""
    values: dict[str, PlantValue] = {}
    modes: list[FittedMode] = []
    others = model.parts() if linearised is None else linearised.parts()
    for (term, parameters), (_, of_other) in zip(model.parts(), others, strict=True):
        here = {
            name: PlantValue(
                value=value,
                error=error,
                model=None if linearised is None else of_other[name][0],
            )
            for name, (value, error) in parameters.items()
        }
        if term == "mode":
            modes.append(
                FittedMode(
                    frequency=here["mode_frequency"],
                    damping=here["mode_damping"],
                    coupling=here["mode_coupling"],
                )
            )
        else:
            values |= here
    return values, sorted(modes, key=lambda mode: mode.frequency.value)


def _frequencies(model: FittedModel, lines: Array) -> Array:
    """Return the lines and others, close enough to show every mode."""
    parts = [lines, np.geomspace(lines[0], lines[-1], _POINTS)]
    for term, parameters in model.parts():
        if term == "mode":
            f, ratio = parameters["mode_frequency"][0], parameters["mode_damping"][0]
            parts += [f * (1.0 + ratio * _ABOUT_MODE), f * _BESIDE_MODE]
    grid = np.unique(np.concatenate(parts))
    return grid[(grid >= lines[0]) & (grid <= lines[-1])]


def _pairs(values: Complex) -> list[tuple[float, float]]:
    return [(float(each.real), float(each.imag)) for each in values]


def _short(value: float) -> float:
    return float(f"{value:.4g}")
