"""A frequency sweep of the simulated loop."""

from __future__ import annotations

from motionlab.studies.study import Study, lazy


class FrequencySweepStudy(Study):
    """Measure the loop of one axis by a frequency sweep of the simulation, as a job.

    A slow motion goes on meanwhile. The job's report carries the points as they arrive.
    """

    kind = "frequency-sweep"
    path = "/loop/sweep"
    operation = "sweepLoop"
    tag = "simulate"
    report_name = "FrequencySweepJob"
    request_model = lazy("studies.loop.frequency_sweep:FrequencySweepRequest")
    document_model = lazy("studies.loop.frequency_sweep:FrequencySweepDocument")
    partial_model = lazy("studies.loop.frequency_sweep:FrequencySweepDocument")
    planner = lazy("studies.loop.frequency_sweep:plan")
    run = lazy("studies.loop.frequency_sweep:swept")
    bodies = ({"frequencies": [10.0, 40.0]},)
