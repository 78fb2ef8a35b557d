"""A frequency sweep of the simulated loop."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from motionlab.studies.study import Models, Progress, Source, Study

if TYPE_CHECKING:
    from motionlab.config.scenario import Scenario
    from motionlab.studies.loop.response import FrequencySweepDocument, FrequencySweepRequest


class FrequencySweep(Study["tuple[FrequencySweepRequest, Scenario]", "FrequencySweepDocument"]):
    """Measure the loop of one axis by a frequency sweep of the simulation, as a job.

    A slow motion goes on meanwhile. The job's report carries the points as they arrive.
    """

    kind = "frequency-sweep"
    path = "/loop/sweep"
    operation = "sweepLoop"
    tag = "simulate"
    report_name = "FrequencySweepJob"
    bodies = ({"frequencies": [10.0, 40.0]},)

    def models(self) -> Models:
        """Return the types of request, document and partial result."""
        from motionlab.studies.loop.response import FrequencySweepDocument, FrequencySweepRequest

        return Models(FrequencySweepRequest, FrequencySweepDocument, FrequencySweepDocument)

    def plan(
        self, request: Mapping[str, Any], source: Source | None = None
    ) -> tuple[FrequencySweepRequest, Scenario]:
        """Return the request and its scenario, which has a linearisation; see `Study.plan`."""
        from motionlab.loop.linearise import linearise
        from motionlab.studies.loop.response import FrequencySweepRequest, loaded

        wanted, scenario = loaded(FrequencySweepRequest, request, source)
        linearise(scenario, wanted.chosen(scenario), wanted.axis, v=wanted.velocity)
        return wanted, scenario

    def run(
        self, plan: tuple[FrequencySweepRequest, Scenario], progress: Progress
    ) -> FrequencySweepDocument:
        """Measure the loop, frequency by frequency."""
        from motionlab.studies.loop.response import swept

        return swept(*plan, progress)
