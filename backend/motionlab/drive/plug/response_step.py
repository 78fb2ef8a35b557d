"""Step of commissioning: the frequency response of each axis, from recorded multisines."""

from __future__ import annotations

import math
import time
from collections.abc import Callable

from motionlab.config.planar import AXES
from motionlab.drive.commissioning.record import Finding, FoundFigure
from motionlab.drive.commissioning.run import StepRun
from motionlab.drive.commissioning.shaking import shaking
from motionlab.drive.motion import held_parameters
from motionlab.drive.plug.recorded_step import RecordedStep
from motionlab.errors import Unknown
from motionlab.library.library import library
from motionlab.studies.identify.documents import IdentificationDocument
from motionlab.studies.response.documents import FittedPlant, MeasuredResponse, PlantValue

_NORMAL = 1.96  # half of a 95 % interval, over the standard error
_NECESSARY = ("crossover", "phase_margin")  # gain margins may lie beyond what is sure
_MODELLED = 0.2  # coupling of a mode in the model, of the measured one
_MARGINS: dict[str, tuple[str, str, Callable[[float], float]]] = {
    "crossover": ("crossover", "Hz", lambda value: value),
    "phase_margin": ("phase margin", "\u00b0", math.degrees),
    "gain_margin": ("gain margin", "dB", lambda value: 20.0 * math.log10(value)),
    "gain_reduction": ("gain margin down", "dB", lambda value: -20.0 * math.log10(value)),
}


class ResponseStep(RecordedStep):
    """The step, for a server that records runs."""

    def __call__(self, run: StepRun) -> Finding:
        """Shake one axis after the other, record, estimate; called in a thread.

        Raises
        ------
        Stopped
            If it was ended before.
        """
        with run.part(0.0, 0.05, "masses as identified"):
            masses = self._masses(run)
        rows: list[FoundFigure] = []
        runs: list[str] = []
        for number, axis in enumerate(AXES):
            begin = 0.05 + 0.475 * number
            with run.part(begin, begin + 0.01, f"{axis}: size of the multisine"):
                scenario = shaking(run, axis, masses.get(axis))
                parameters = held_parameters(scenario)
            with run.holding(parameters):
                with run.part(begin + 0.01, begin + 0.42, f"{axis}: multisine, recorded"):
                    runs.append(self.recorded(run, scenario))
            with run.part(begin + 0.42, begin + 0.475, f"{axis}: response from {runs[-1]}"):
                body = {"run": runs[-1], "axis": axis}
                rows += rows_of(self.study(run, "response", body, MeasuredResponse))
        return finding_of(rows, runs)

    def _masses(self, run: StepRun) -> dict[str, float]:
        """Return masses from the run of Identification, kg; none where that is not kept."""
        finding = self.drives.commissioning.findings.get("friction")
        if finding is None or finding.run is None:
            return {}
        try:
            library().complete(finding.run)
        except Unknown:
            return {}
        body = {"run": finding.run, "axis": "both"}
        axes = self.study(run, "identify", body, IdentificationDocument).axes
        masses: dict[str, float] = {}
        for axis, identified in axes.items():
            for fit in (identified.sliding, identified.presliding):
                mass = fit.parameters.get("M") if fit else None
                if mass is not None and mass.low is not None and mass.low > 0.0:
                    masses[axis] = mass.value
        return masses


def rows_of(document: MeasuredResponse) -> list[FoundFigure]:
    """Return margins and the fitted plant of an axis, beside those of the model."""
    axis, rows = document.axis, list[FoundFigure]()
    for name, (title, unit, shown) in _MARGINS.items():
        margin = document.margins[name]
        if margin.value is None:
            continue
        ends = sorted(map(shown, margin.interval)) if margin.interval else None
        span = " to ".join(f"{end:.3g}" for end in ends) if ends else "not determined"
        rows.append(
            FoundFigure(
                name=f"{axis} {title}",
                found=f"{shown(margin.value):.3g} {unit} ({span})",
                expected="none" if margin.model is None else f"{shown(margin.model):.3g} {unit}",
                holds=ends is not None or name not in _NECESSARY,
            )
        )
    if document.fitted is None:
        return [*rows, FoundFigure(name=f"{axis} mass", found="nothing", expected="", holds=False)]
    return rows + [_row(f"{axis} {name}", *each) for name, each in _fitted(document.fitted)]


def _fitted(plant: FittedPlant) -> list[tuple[str, tuple[PlantValue, str, float, bool]]]:
    """Return name, value, unit, factor and whether the model has it, of what was fitted."""
    rows = [("mass", (plant.mass, "kg", 1.0, True)), ("delay", (plant.delay, "ms", 1e3, True))]
    if plant.lag is not None:
        rows.append(("lag", (plant.lag, "ms", 1e3, True)))
    for number, mode in enumerate(plant.modes, 1):
        coupling = mode.coupling
        modelled = abs(coupling.model or 0.0) > _MODELLED * abs(coupling.value)
        rows.append((f"mode {number}", (mode.frequency, "Hz", 1.0, modelled)))
        rows.append((f"mode {number}, damping", (mode.damping, "", 1.0, modelled)))
    return rows


def _row(name: str, value: PlantValue, unit: str, factor: float, modelled: bool) -> FoundFigure:
    half = _NORMAL * factor * value.error
    expected = "none"
    if modelled and value.model is not None:
        expected = f"{factor * value.model:.4g} {unit}".strip()
    return FoundFigure(
        name=name,
        found=f"{factor * value.value:.4g} {unit} (\u00b1 {half:.2g})".replace("  ", " "),
        expected=expected,
        holds=math.isfinite(half) and (name[2:] != "mass" or half < factor * value.value),
    )


def finding_of(rows: list[FoundFigure], runs: list[str]) -> Finding:
    """Return what was measured in one run of each axis."""
    measured = " and ".join(f"{run} ({axis})" for axis, run in zip(AXES, runs, strict=True))
    text = f"measured in {measured}"
    unknown = [row.name for row in rows if not row.holds]
    modes = [row.name for row in rows if _is_new_mode(row)]
    if unknown:
        text = f"not determined by {measured}: {', '.join(unknown)}"
    elif modes:
        text += f"; modes that the model has not: {', '.join(modes)}"
    return Finding(at=time.time(), holds=not unknown, text=text, rows=rows, run=runs[0])


def _is_new_mode(row: FoundFigure) -> bool:
    return " mode " in row.name and "damping" not in row.name and row.expected == "none"
