"""Running a scenario from its first tick to its last."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from motionlab.config.planar import AXES
from motionlab.kernel.layout import SAMPLE_ROWS
from motionlab.simulation.prepare import Prepared
from motionlab.simulation.record import write_states
from motionlab.simulation.simulation import (
    Simulation,
    Snapshot,
    sample_page,
    variant_columns,
)
from motionlab.telemetry.channels import CHANNELS
from motionlab.telemetry.law_channels import laws_of_variants, state_columns
from motionlab.telemetry.recording import Divergence, Recording, VariantRecord, states_of

_LAST_STATES = 5


def run(
    prepared: Prepared,
    progress: Callable[[int], None] | None = None,
    *,
    start: Snapshot | None = None,
    stop: int | None = None,
) -> Recording:
    """Run a scenario and record every channel.

    Parameters
    ----------
    prepared : Prepared
        What to run.
    progress : callable, optional
        Called with the number of ticks done since its last call.
    start : Snapshot, optional
        Where to begin; at tick 0 when left out. No variant of it has diverged.
    stop : int, optional
        Tick at which to end; the scenario's end when left out.

    Returns
    -------
    Recording
        The same bits for the same scenario on the same machine. A variant that diverged holds NaN
        from there on; the others are not touched by it.
    """
    names = list(prepared.scenario.variants)
    simulation = Simulation(prepared, start=start)
    first = simulation.tick
    stop = prepared.reference.ticks if stop is None else stop
    of_laws = state_columns(laws_of_variants(prepared.epochs))
    states = np.empty((len(of_laws), stop - first), dtype=np.float32)
    page = sample_page(len(names), states=bool(of_laws))
    columns = np.empty((len(names), SAMPLE_ROWS, len(AXES), stop - first), dtype=np.float32)
    scenario = simulation.scenario  # whose laws are in effect until `advance` returns
    while count := simulation.advance(page[:, : stop - simulation.tick]):
        done = slice(simulation.tick - count - first, simulation.tick - first)
        for variant in range(len(names)):
            columns[variant, :, :, done] = variant_columns(page, variant, count)[:SAMPLE_ROWS]
        write_states(scenario, of_laws, page, states[:, done])
        scenario = simulation.scenario
        if progress is not None:
            progress(count)

    records = {}
    for variant, (name, failed) in enumerate(zip(names, simulation.failed_ticks, strict=True)):
        divergence = None if failed is None else _divergence(columns[variant], failed, first)
        if failed is not None:
            columns[variant, :, :, failed - first :] = np.nan
        own = {each.name: each.channel for each in of_laws if each.variant == name}
        named = {each.name: row for each, row in zip(of_laws, states, strict=True)}
        if failed is not None:
            for each in own:
                named[each][failed - first :] = np.nan
        records[name] = VariantRecord(columns[variant], divergence, states_of(name, named, own))
    reference = prepared.reference
    shared = (reference.position, reference.velocity, reference.acceleration, prepared.load)
    return Recording(np.stack([column[first:stop].T for column in shared]), records, first)


def _divergence(columns: NDArray[np.float32], tick: int, first_tick: int) -> Divergence:
    """Name the first channel that is not finite at `tick`, else the following error."""
    failed = tick - first_tick
    at = columns[:, :, failed]
    bad = np.argwhere(~np.isfinite(at))
    if len(bad):
        channel, axis = bad[0]
    else:
        channel = [c.name for c in CHANNELS].index("following_error")
        axis = np.argmax(np.abs(at[channel]))
    first = max(0, failed + 1 - _LAST_STATES)
    last = tuple(
        {
            f"{AXES[a]}.{CHANNELS[c].name}": float(columns[c, a, k])
            for a in range(len(AXES))
            for c in range(len(CHANNELS))
        }
        for k in range(first, failed + 1)
    )
    return Divergence(tick, f"{AXES[axis]}.{CHANNELS[channel].name}", last)
