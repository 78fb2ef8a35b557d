"""A run of a scenario, with its metrics and every channel."""

from __future__ import annotations

import functools
import json
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab.config.load import load_scenario
from motionlab.config.planar import AXES
from motionlab.config.scenario import Scenario
from motionlab.reports.markup import element
from motionlab.reports.result_text import report
from motionlab.scripting.channels import Channels, Record, in_notebook
from motionlab.simulation.result import metadata
from motionlab.telemetry.law_channels import all_columns
from motionlab.telemetry.recorder import columns
from motionlab.telemetry.recording import Recording


class Run(Channels):
    """A run: metrics, comparison, and channels as arrays with units.

    Attributes
    ----------
    document : dict
        The result document, as ``motionlab run --json`` prints it (docs/metrics.md).
    id : str or None
        Of the kept run; None where it is not kept.
    """

    def __init__(self, document: dict[str, Any], record: Callable[[], Record]) -> None:
        laws = {name: [each["law"]] for name, each in document["variants"].items()}
        super().__init__(dict(all_columns(laws)), record)
        self.document = document
        self.id: str | None = document.get("run")

    @functools.cached_property
    def scenario(self) -> Scenario:
        """What was run, fully resolved."""
        return load_scenario(json.loads(self.record.metadata["scenario"]))

    @property
    def metrics(self) -> dict[str, dict[str, dict[str, float | None]]]:
        """Metrics by variant and axis, SI, as in ``metrics["B"]["x"]["max_abs_following_error"]``.

        ``metrics["B"]["xy"]`` has those of the contour. None where a run has no such value.
        """
        return {
            name: {**variant["axes"], "xy": variant["contour"]}
            for name, variant in self.document["variants"].items()
        }

    @property
    def comparison(self) -> dict[str, dict[str, float | None]]:
        """B against A by axis, as in ``comparison["x"]["max_abs_following_error_ratio"]``."""
        return self.document["comparison"]

    @property
    def diverged(self) -> dict[str, float]:
        """Variants that diverged, and when, s."""
        divergences = {name: each["diverged"] for name, each in self.document["variants"].items()}
        return {name: each["time"] for name, each in divergences.items() if each is not None}

    @property
    def notes(self) -> list[str]:
        """What to know of its figures, each after its variant, as of an unstable loop."""
        variants = self.document["variants"].items()
        return [f"{name}: {note}" for name, variant in variants for note in variant["notes"]]

    @property
    def window(self) -> tuple[float, float]:
        """Start and end of the time that metrics are taken over, s."""
        window = self.document["window"]
        return window["start"], window["end"]

    def shown(self) -> list[str]:
        """Return the following errors of every variant on each axis that moves."""
        moving = [axis for axis in AXES if any(axis in each for each in self.metrics.values())]
        return [f"{name}.{axis}.following_error" for axis in moving for name in self.metrics]

    def __str__(self) -> str:
        """Return the report that ``motionlab run`` prints."""
        return report(self.document)

    def __repr__(self) -> str:
        """Return a line about the run."""
        return f"<Run of {self.document['scenario']}: {', '.join(self.metrics)}>"

    def _repr_html_(self) -> str:
        errors: dict[str, list[str]] = {}
        for name in self.shown():
            errors.setdefault(name.split(".")[1], []).append(name)
        drawn = [self._svg(f"Following error {axis}", names) for axis, names in errors.items()]
        return in_notebook(*drawn, element("pre", str(self)))


def record_of(recording: Recording, scenario: Scenario) -> Record:
    """Return a recording of a scenario by the names of its columns."""
    places = {name: values for name, _, values in columns(recording)}

    def values(names: Sequence[str]) -> NDArray[np.float32]:
        return np.stack([places[name] for name in names])

    ticks = range(recording.first_tick, recording.first_tick + recording.ticks)
    return Record(values, ticks, metadata(scenario))
