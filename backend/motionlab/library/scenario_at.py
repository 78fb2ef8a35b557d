"""The scenario of a run as it was over a stretch of it."""

from __future__ import annotations

from collections.abc import Callable

from motionlab.config.changes import apply_changes
from motionlab.config.load import validate
from motionlab.config.scenario import Scenario
from motionlab.errors import ConfigError
from motionlab.library.run import RunDetail


def scenario_of(
    run: RunDetail, start: int, stop: int, matters: Callable[[str], bool]
) -> Scenario | str:
    """Return the scenario of a run at a sample, without schedule, or why there is none.

    Parameters
    ----------
    run : RunDetail
        The run.
    start, stop : int
        Samples [start, stop).
    matters : callable
        Of a dotted path: whether its change within the stretch leaves no scenario for all of it.
    """
    if run.scenario_document is None:
        return "the run has no scenario"
    document = dict(run.scenario_document)
    changes = [(round(one["time"] / run.period), one["set"]) for one in document["schedule"]]
    changes += [(event.tick, event.set) for event in run.events if event.kind == "change"]
    start, stop = start + run.first_tick, stop + run.first_tick
    for tick, paths in sorted(changes, key=lambda change: change[0]):
        if tick <= start:
            document = apply_changes(document, paths)
        elif tick < stop and any(matters(path) for path in paths):
            return f"motor or controller change at {tick * run.period:g} s, within the stretch"
    document["schedule"] = []
    try:
        return validate(document)
    except ConfigError as problem:  # a motor or a map of one's own that is gone
        return str(problem)
