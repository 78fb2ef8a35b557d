"""Step: the loop closed with low gains, holding and moving each axis slowly forth and back."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab.config.load import load_scenario
from motionlab.config.planar import AXES
from motionlab.config.scenario import Scenario
from motionlab.drive.commissioning.field import SCENARIO, VARIANT
from motionlab.drive.commissioning.record import Finding, FoundFigure
from motionlab.drive.commissioning.run import StepRun, Traced, ticks_of
from motionlab.drive.link.shared import Figure
from motionlab.drive.motion import held_parameters, minimum_jerk, on_drives

Array = NDArray[np.float64]

GAIN = 0.25
"""Share of k_p; k_d has its root, so that damping stays."""

MOVE, SPEED, REST = 2e-3, 5e-3, 1.0  # m, m/s, s
QUIVER = 5e-6
"""Largest movement at rest from peak to peak, m; or four counts."""

_WINDOW = 0.5  # of the following-error window


def low_gains() -> Scenario:
    """Return the scenario whose controller holds, with low gains and no compensation."""
    return on_drives(load_scenario(SCENARIO, low_gain_changes()), VARIANT)


def low_gain_changes() -> dict[str, Any]:
    """Return what low gains change in the scenario, by dotted path."""
    controller = load_scenario(SCENARIO).variants[VARIANT].controller
    place = f"variants.{VARIANT}.controller"
    changes: dict[str, Any] = {f"{place}.compensation.enabled": False}
    for axis in AXES:
        gains = getattr(controller, axis)
        changes[f"{place}.{axis}.k_p"] = GAIN * gains.k_p
        changes[f"{place}.{axis}.k_d"] = GAIN**0.5 * gains.k_d
    return changes


def hold_with_low_gains(run: StepRun) -> Finding:
    """Hold, then move each axis 2 mm forth and back, and hold again.

    Raises
    ------
    Stopped
        If it was ended before.
    """
    rows: list[FoundFigure] = []
    with run.part(0.0, 0.05, "low gains"):
        parameters = held_parameters(low_gains())
    with run.holding(parameters):
        here = np.array(run.link.figure(Figure.REFERENCE))
        for index, axis in enumerate(AXES):
            share = 0.05 + 0.95 * index / len(AXES)
            with run.part(share, share + 0.95 / len(AXES), f"{axis}: forth and back"):
                reference, turn = _forth_and_back(run, index, here)
                traced = run.follow(reference)
            rows += _judged(run, index, traced, turn)
    wrong = [row.name for row in rows if not row.holds]
    kept = f"k_p at {100 * GAIN:.0f} %, k_d at {100 * GAIN**0.5:.0f} % of {SCENARIO} {VARIANT}"
    text = f"not as expected: {'; '.join(wrong)}" if wrong else "follows, and comes to rest"
    return Finding(at=time.time(), holds=not wrong, text=f"{text} ({kept})", rows=rows)


def _forth_and_back(run: StepRun, index: int, here: Array) -> tuple[Array, int]:
    """Return the reference, towards the middle first, and the tick of its turn."""
    config = getattr(run.config, AXES[index])
    middle = (config.position_min + config.position_max) / 2
    there = here.copy()
    there[index] += MOVE if here[index] <= middle else -MOVE
    limits = {"velocity": np.full(2, SPEED), "acceleration": np.full(2, 10 * SPEED)}
    forth, back = minimum_jerk(here, there, **limits), minimum_jerk(there, here, **limits)
    rests = [_resting(place) for place in (here, there, here)]
    reference = np.concatenate((rests[0], forth, rests[1], back, rests[2]))
    return reference, len(rests[0]) + len(forth) + len(rests[1])


def _resting(place: Array) -> Array:
    reference = np.zeros((ticks_of(REST), 3, len(AXES)))
    reference[:, 0] = place
    return reference


def _judged(run: StepRun, index: int, traced: Traced, turn: int) -> list[FoundFigure]:
    """Return way, following error and unrest of an axis."""
    axis = AXES[index]
    config = getattr(run.config, axis)
    position, error = traced.position[:, index], np.abs(traced.error[:, index])
    half = ticks_of(REST / 2)
    still = [position[half : 2 * half], position[turn - half : turn], position[-half:]]
    begin, there, _ = (float(np.nanmean(part)) for part in still)
    # The reference: position and following error together.
    start = position[0] + traced.error[0, index]
    way = there - begin
    meant = float(np.nanmean((position + traced.error[:, index])[turn - half : turn]) - start)
    largest = float(np.nanmax(error))
    quiver = max(float(np.nanmax(part) - np.nanmin(part)) for part in still)
    bound = _WINDOW * config.following_error
    calm = max(QUIVER, 4 * config.resolution)
    return [
        FoundFigure(
            name=f"{axis}, way",
            found=f"{1e3 * way:+.3f} mm",
            expected=f"{1e3 * meant:+.3f} mm within {1e3 * bound:.3f} mm",
            holds=abs(way - meant) <= bound,
        ),
        FoundFigure(
            name=f"{axis}, largest following error",
            found=f"{1e6 * largest:.1f} \u00b5m",
            expected=f"below {1e6 * bound:.0f} \u00b5m",
            holds=largest <= bound,
        ),
        FoundFigure(
            name=f"{axis}, movement at rest, peak to peak",
            found=f"{1e6 * quiver:.2f} \u00b5m",
            expected=f"below {1e6 * calm:.1f} \u00b5m",
            holds=quiver <= calm,
        ),
    ]
