"""Experiments behind the rows, each run once, and their curves for figures."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from motionlab.config.load import load_scenario
from motionlab.config.named_configs import data_root
from motionlab.motor_design.computed_maps import computed_or_kept
from motionlab.motor_design.design import design
from motionlab.motor_design.document import DesignDocument
from motionlab.motor_design.fem.force_map import ForceMap, content_hash
from motionlab.motor_design.fem.geometry import Geometry
from motionlab.motor_design.kept_maps import MapStore, named_map
from motionlab.paper.documents import FigureSeries, PaperFigure, Role
from motionlab.simulation.prepare import Prepared, prepare
from motionlab.simulation.result import document
from motionlab.simulation.run import run
from motionlab.studies.identify.documents import IdentificationDocument, IdentifyRequest
from motionlab.studies.identify.experiment import identify, plan
from motionlab.studies.montecarlo.cases import plan as plan_cases
from motionlab.studies.montecarlo.cases import run_cases
from motionlab.studies.montecarlo.documents import MonteCarloDocument, MonteCarloRequest
from motionlab.telemetry.decimate import min_max
from motionlab.telemetry.recording import Recording
from motionlab.timing import CONTROL_PERIOD

Progress = Callable[[float], None]
"""Takes the share of one experiment that is done; what it raises ends the work."""

CASES = 300
"""Plants of a Monte Carlo study."""

_NEW_DESIGN = "new-design"
_LONG = 100_000
"""Ticks; a recording of two variants takes 400 bytes of each."""


@dataclass(frozen=True)
class Run:
    """A scenario that was run."""

    prepared: Prepared
    recording: Recording
    document: dict[str, Any]


class Experiments:
    """Experiments, computed on first use and cached; `progress` takes the share of one done."""

    def __init__(self, progress: Progress | None = None) -> None:
        self.progress = progress or (lambda share: None)
        self._runs: dict[str, Run] = {}
        self._studies: dict[str, MonteCarloDocument] = {}
        self._design: DesignDocument | None = None
        self._force_map: ForceMap | None = None
        self._identification: IdentificationDocument | None = None

    def run(self, scenario: str, changes: Mapping[str, Any] | None = None) -> Run:
        """Return a run of a shipped scenario with changes, dotted path to value."""
        key = f"{scenario} {json.dumps(changes or {}, sort_keys=True)}"
        if key not in self._runs:
            prepared = prepare(load_scenario(scenario, changes))
            done = 0

            def count(ticks: int) -> None:
                nonlocal done
                done += ticks
                self.progress(done / prepared.reference.ticks)

            recording = run(prepared, count)
            self._runs[key] = Run(prepared, recording, document(prepared, recording))
        return self._runs[key]

    def forget_long_runs(self) -> None:
        """Drop runs with large recordings."""
        self._runs = {
            key: kept for key, kept in self._runs.items() if kept.recording.ticks <= _LONG
        }

    def study(self, scenario: str) -> MonteCarloDocument:
        """Return the Monte Carlo study of a shipped scenario over the default plants."""
        if scenario not in self._studies:
            planned = plan_cases(MonteCarloRequest(scenario=scenario, cases=CASES))
            self._studies[scenario] = run_cases(planned, self.progress)
        return self._studies[scenario]

    def design(self) -> DesignDocument:
        """Return the paper's example, sized and rated."""
        if self._design is None:
            self._design = design({})
        return self._design

    def force_map(self) -> ForceMap:
        """Return the force map of the paper's geometry by finite elements.

        The shipped one, unless the finite-element code has changed since.
        """
        if self._force_map is None:
            shipped = named_map(_NEW_DESIGN, _NEW_DESIGN)
            if shipped.document.content_hash == content_hash(Geometry(), "default"):
                self._force_map = shipped
            else:
                store = MapStore(data_root() / "maps")
                self._force_map, _ = computed_or_kept(
                    store, Geometry(), "default", progress=self.progress
                )
        return self._force_map

    def identification(self) -> IdentificationDocument:
        """Return the friction of the nominal motor, identified as the paper does."""
        if self._identification is None:
            self._identification = identify(
                plan(IdentifyRequest()), lambda share, _: self.progress(share)
            )
        return self._identification


Build = Callable[[Experiments], PaperFigure]

_BINS = 400
_DIGITS = 6


def figure_series(
    label: str,
    role: Role,
    x: ArrayLike,
    y: ArrayLike,
    *,
    kind: Literal["line", "points"] = "line",
) -> FigureSeries:
    """Return a curve; samples that are not finite become gaps.

    Parameters
    ----------
    label, role, kind : str
        See `motionlab.paper.documents.FigureSeries`.
    x, y : array_like, shape (n,)
        SI.
    """
    return FigureSeries(
        label=label,
        role=role,
        kind=kind,
        x=[_rounded(value) or 0.0 for value in np.asarray(x, dtype=float)],
        y=[_rounded(value) for value in np.asarray(y, dtype=float)],
    )


def trace(
    label: str, role: Role, samples: NDArray[np.floating], *, start: float = 0.0
) -> FigureSeries:
    """Return one sample a tick over time: of each bin the smallest and the largest.

    Parameters
    ----------
    label, role : str
        See `motionlab.paper.documents.FigureSeries`.
    samples : ndarray, shape (ticks,)
        SI.
    start : float
        Time of the first, s.
    """
    ticks = len(samples)
    if ticks <= 2 * _BINS:
        return figure_series(label, role, start + np.arange(ticks) * CONTROL_PERIOD, samples)
    low, high = min_max(np.asarray(samples, dtype=np.float32)[None], _BINS)
    size = -(-ticks // _BINS)
    first = start + np.arange(low.shape[1]) * size * CONTROL_PERIOD
    time = np.stack([first, first + 0.5 * size * CONTROL_PERIOD], axis=1)
    return figure_series(label, role, time.ravel(), np.stack([low[0], high[0]], axis=1).ravel())


def _rounded(value: float) -> float | None:
    return float(f"{value:.{_DIGITS}g}") if np.isfinite(value) else None
