"""A kept run, read back: what it was, what came of it, and its channels."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Any

from motionlab.config.load import load_scenario
from motionlab.config.scenario import Scenario
from motionlab.scripting.channels import Channels
from motionlab.scripting.session import described_in, record_of_file

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from pyarrow.parquet import ParquetFile


class KeptRun(Channels):
    """A kept run: channels as arrays with units, and what the list of runs says of it.

    Attributes
    ----------
    detail : mapping
        Name, note, tags, variants, metrics, events and the resolved scenario, as
        ``GET /runs/{run_id}`` answers (docs/runs.md).
    """

    def __init__(self, detail: Mapping[str, Any], file: Callable[[], ParquetFile]) -> None:
        opened = functools.cache(file)
        columns = described_in(detail["columns"])
        super().__init__(columns, lambda: record_of_file(opened()))
        self.detail = detail

    @property
    def id(self) -> str:
        """Its identifier, as ``motionlab runs`` lists it."""
        return self.detail["id"]

    @property
    def name(self) -> str:
        """What it is called."""
        return self.detail["name"]

    @property
    def metrics(self) -> dict[str, float]:
        """Metrics by variant, axis and name, SI, as in ``metrics["B.x.rms_following_error"]``."""
        return self.detail["metrics"]

    @functools.cached_property
    def scenario(self) -> Scenario | None:
        """What was run, fully resolved; None for a measurement."""
        tables = self.detail["scenario_document"]
        return None if tables is None else load_scenario(tables)

    def __repr__(self) -> str:
        """Return a line about the run."""
        seconds = f"{self.detail['duration']:g} s"
        return f"<KeptRun {self.id} {self.name!r}: {seconds}, {len(self)} channels>"
