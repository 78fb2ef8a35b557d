"""Step: a low current through each phase alone, which its drive must report and no other."""

from __future__ import annotations

import time

import numpy as np

from motionlab.config.drive import PHASES
from motionlab.config.planar import AXES
from motionlab.drive.commissioning.field import Field, reference_model
from motionlab.drive.commissioning.record import Finding, FoundFigure
from motionlab.drive.commissioning.run import StepRun, ticks_of
from motionlab.drive.link.bounds import OpenLoopTest

SHARE = 0.1
"""Current of the test, of the largest current of the axis."""

TOLERANCE = 0.15
"""By which a current may be off, of that of the test."""

RAMP, HOLD = 0.2, 0.3  # s


def phase_currents(run: StepRun) -> Finding:
    """Give each drive alone a current: up, held, down.

    Raises
    ------
    Stopped
        If it was ended before.
    """
    config, model = run.config, reference_model()
    ramp, hold = ticks_of(RAMP), ticks_of(HOLD)
    up = np.arange(ramp) / ramp
    pulse = np.concatenate((up, np.ones(hold), 1.0 - up))
    table = np.zeros((len(config.nodes) * len(pulse), 3, len(AXES)))
    held = []
    for number, node in enumerate(config.nodes):
        begin = number * len(pulse)
        command = SHARE * getattr(config, node.axis).current_max
        place = PHASES.index(node.phase), AXES.index(node.axis)
        table[begin : begin + len(pulse), *place] = command * pulse
        # Judged over the second half, where the current has settled.
        held.append((slice(begin + ramp + hold // 2, begin + ramp + hold), command, place))
    pitches = [Field(axis, model).pitch for axis in AXES]
    with run.part(0.0, 1.0, "each phase alone, one after the other"):
        traced = run.test(OpenLoopTest(table, travel=(pitches[0], pitches[1])))
    rows, wrong = [], []
    for number, (node, (window, command, place)) in enumerate(
        zip(config.nodes, held, strict=True), start=1
    ):
        currents = np.nanmean(traced.current[window], axis=0)
        own = float(currents[place])
        currents[place] = 0.0
        other = float(np.abs(currents).max())
        follows = abs(own - command) <= TOLERANCE * command
        alone = other <= TOLERANCE * command
        name = f"{number} {node.axis} {node.phase}"
        if not follows:
            wrong.append(f"drive {number} ({node.axis} {node.phase}) does not follow")
        if not alone:
            at, axis = np.unravel_index(int(np.abs(currents).argmax()), currents.shape)
            place_of = f"{AXES[int(axis)]} {PHASES[int(at)]}"
            wrong.append(f"{place_of} has current while only {name[2:]} should")
        rows.append(
            FoundFigure(
                name=name,
                found=f"{own:.3f} A, others up to {other:.3f} A",
                expected=f"{command:.3f} A, others below {TOLERANCE * command:.3f} A",
                holds=follows and alone,
            )
        )
    return Finding(
        at=time.time(),
        holds=not wrong,
        text="; ".join(wrong) or f"all {len(rows)} follow, each alone",
        rows=rows,
    )
