"""What-if runs: the whole scenario if short, else its window from a stored state."""

from __future__ import annotations

import functools
import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from motionlab.config.changes import check_schedulable
from motionlab.config.includes import resolve
from motionlab.config.load import epochs, load_scenario, read_source
from motionlab.config.scenario import Scenario
from motionlab.errors import ConfigError, FieldError
from motionlab.kernel.force_maps import map_digests
from motionlab.laws import REDECLARED, SOURCES
from motionlab.simulation.prepare import Prepared, needs_plan, prepare
from motionlab.simulation.run import run
from motionlab.simulation.simulation import Simulation, Snapshot, sample_page
from motionlab.telemetry.recording import Recording
from motionlab.timing import to_ticks

SOON = to_ticks(30.0)
"""Ticks that are simulated from the start all the same."""

LEAD = to_ticks(1.0)
"""Least number of ticks from a stored state to the window; a period where the motion has one."""


@dataclass(frozen=True)
class Extent:
    """Simulated ticks of a what-if.

    Attributes
    ----------
    exact : bool
        Whether to run from the start although that takes a while.
    work_max : float
        Simulated time, summed over variants, beyond which nothing runs from the start, s.
    wanted : tuple of int
        Ticks [start, stop) that are to be recorded besides the window of the metrics, where that
        needs no run from the start of a scenario that is too long for it.
    """

    exact: bool
    work_max: float
    stretch: tuple[int, int] | None = None


def run_changed(
    changed: Prepared,
    source: str | Mapping[str, Any],
    changes: Mapping[str, Any],
    extent: Extent,
) -> Recording:
    """Run a changed scenario from where `beginning` has it begin; parameters and errors as there.

    Returns
    -------
    Recording
        The whole run, or from the state's tick, its `first_tick`, to the end of the window.
    """
    start, stop = beginning(changed, source, changes, extent)
    return run(changed, start=start, stop=stop)


def beginning(
    changed: Prepared,
    source: str | Mapping[str, Any],
    changes: Mapping[str, Any],
    extent: Extent,
) -> tuple[Snapshot | None, int]:
    """Return the state at which a changed scenario begins, None at rest, and the tick of its end.

    A state is used where the run up to the window's end is long and a running session would take
    the changes. Then the unchanged scenario runs up to the state's tick and the changes hold from
    there on: to the last bit what the same changes, scheduled for that tick, give.

    Parameters
    ----------
    changed : Prepared
        The scenario with the changes, checked.
    source : str or mapping
        The scenario before the changes: name of a shipped one, or its tables.
    changes : mapping of str to value
        Dotted path to value.
    extent : Extent
        How much of it is wanted.

    Raises
    ------
    ConfigError
        If it would have to run from the start and is too long for that.
    """
    work_max = extent.work_max
    if may_begin_late(changed, changes, extent):
        tick, stop = _stretch(changed, extent)
        tables = json.dumps(resolve(read_source(source)))
        unchanged = _unchanged(tables)
        stored = None
        if list(unchanged.variants) == list(changed.scenario.variants):
            versions = *map_digests(epochs(unchanged)), *SOURCES.values()
            stored = _state(tables, tick, versions)
        if stored is not None:
            return stored, stop
    if changed.work > work_max:
        raise ConfigError(
            FieldError(
                loc="trajectory",
                message="simulated time times variants is too large for a what-if from the start; "
                "simulate makes it a job",
                value=changed.work,
                bounds={"maximum": work_max},
                unit="s",
            )
        )
    return None, changed.reference.ticks


def may_begin_late(changed: Prepared, changes: Mapping[str, Any], extent: Extent) -> bool:
    """Return whether `beginning` runs the unchanged scenario, unless it has the state already."""
    tick, stop = _stretch(changed, extent)
    exact = extent.exact and changed.work <= extent.work_max
    return not exact and stop > SOON and tick > 0 and _fits_a_running_session(changes)


def near_window(prepared: Prepared) -> tuple[Snapshot | None, int]:
    """Return `beginning` of a scenario that no change has been made to, however long it is."""
    scenario = prepared.scenario.model_dump(mode="json")
    return beginning(prepared, scenario, {}, Extent(exact=False, work_max=prepared.work))


def recorded_ticks_max(changed: Prepared, extent: Extent) -> int:
    """Return the most ticks that `run_changed` records of a scenario."""
    tick, stop = _stretch(changed, extent)
    affordable = changed.work <= extent.work_max
    return changed.reference.ticks if affordable else stop - tick


def _stretch(changed: Prepared, extent: Extent) -> tuple[int, int]:
    """Return the tick of the state to begin at, if one is used, and that to stop at."""
    lead = max(LEAD, changed.reference.period)
    start, stop = changed.window
    first, last = extent.stretch or (start, stop)
    tick = min(start, first) - lead
    if tick <= 0 and changed.work > extent.work_max:
        tick = start - lead
    return tick, max(stop, last)


def _fits_a_running_session(changes: Mapping[str, Any]) -> bool:
    try:
        check_schedulable(changes, "set")
    except ConfigError:
        return False
    return True


@functools.lru_cache(maxsize=4)
def _unchanged(tables: str) -> Scenario:
    """Return the scenario of resolved tables, given as JSON."""
    return load_scenario(json.loads(tables))


REDECLARED.append(_unchanged.cache_clear)


@functools.lru_cache(maxsize=4)
def _state(tables: str, tick: int, _versions: tuple[str, ...]) -> Snapshot | None:
    """Return the state of a scenario; None if it has to be planned first or a variant diverges."""
    scenario = _unchanged(tables)
    if needs_plan(scenario.trajectory):
        return None
    simulation = Simulation(prepare(scenario))
    page = sample_page(len(scenario.variants))
    while simulation.advance(page[:, : tick - simulation.tick]):
        pass
    failed = any(tick is not None for tick in simulation.failed_ticks)
    return None if failed else simulation.snapshot()
