"""Step: aligned positions of the phases, which give their order and the commutation offset."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from motionlab.config.drive import PHASES
from motionlab.config.planar import AXES
from motionlab.drive.commissioning.field import (
    DRAW,
    Field,
    drawn,
    held,
    of_axis,
    reference_model,
    turned,
)
from motionlab.drive.commissioning.record import Finding, Findings
from motionlab.drive.commissioning.run import StepRun, Stopped, ticks_of
from motionlab.drive.link.bounds import OpenLoopTest

Array = NDArray[np.float64]

TOLERANCE = 0.02
"""By which the offset may be off, of a pitch: 7 degrees, 1 % of the force."""

SPREAD = 0.04
"""By which single phases may differ from it, of a pitch."""

VISITS = (4, 5, 6, 5, 4, 3)
"""Phases b, c, a on the way up, then c, b, a on the way down, in thirds of a turn."""

RAMP, DWELL, SPEED = 0.3, 0.4, 1.5  # s, s, thirds of a turn a second
_FOLLOWS = 0.35, 1.65  # of what an axis must move from one phase to the next
_STANDS = 0.35


def commutation_offset(run: StepRun) -> Finding:
    """Draw each axis from phase to phase, up one pitch and down again.

    Friction stalls the mover short of where a phase is aligned: below it on the way up, as far
    above it on the way down. The mean of both is the aligned position.

    Raises
    ------
    Stopped
        If it was ended before.
    """
    model = reference_model()
    findings = Findings()
    for index, axis in enumerate(AXES):
        field = Field(axis, model)
        with run.part(index / len(AXES), (index + 1) / len(AXES), f"{axis}: from phase to phase"):
            at = _visited(run, index, field)
        wrong = _order(axis, np.diff(at[:3]), np.diff(at[2:]), field.pitch, findings)
        if wrong:
            findings.tell(wrong)
        else:
            _offset(getattr(run.config, axis).offset, axis, at, field, findings)
    return findings.finding()


def _visited(run: StepRun, index: int, field: Field) -> Array:
    """Return where the axis came to rest at each of `VISITS`, m."""
    angles = [held(2, DWELL), turned(2, 3, SPEED), held(3, DWELL)]  # it is caught here
    ends, before = [], 3
    for visit in VISITS:
        angles += [turned(before, visit, SPEED), held(visit, DWELL)]
        ends.append(sum(map(len, angles)))
        before = visit
    current = DRAW * getattr(run.config, AXES[index]).current_max
    table = of_axis(drawn(np.concatenate(angles), current, RAMP), index)
    other = 0.5 * field.pitch
    travel = tuple(2.5 * field.pitch if i == index else other for i in range(len(AXES)))
    traced = run.test(OpenLoopTest(table, travel=(travel[0], travel[1])))
    ramp, window = ticks_of(RAMP), ticks_of(DWELL / 2)
    position = traced.position[:, index]
    at = np.array([np.nanmedian(position[ramp + end - window : ramp + end]) for end in ends])
    if not np.isfinite(at).all():
        raise Stopped("positions are missing: the link lost cycles")
    return at


def _order(axis: str, up: Array, down: Array, pitch: float, findings: Findings) -> str:
    """Note the order of the phases; return what is wrong with it, or nothing."""
    moves = np.concatenate((up, -down)) / (pitch / 3.0)
    right = bool(((moves > _FOLLOWS[0]) & (moves < _FOLLOWS[1])).all())
    third = 1e3 * pitch / 3.0
    findings.row(
        f"{axis}, from phase to phase",
        found=f"{third * moves.min():+.2f} to {third * moves.max():+.2f} mm",
        expected=f"{third:+.2f} mm",
        holds=right,
    )
    if right:
        return ""
    if bool(((moves < -_FOLLOWS[0]) & (moves > -_FOLLOWS[1])).all()):
        return (
            f"{axis}: the order of the phases is wrong, the mover goes backwards; exchange two of "
            "them: their cables, or their names in the file of the link"
        )
    if bool((np.abs(moves) < _STANDS).all()):
        return f"{axis}: the mover does not follow; is it blocked, or the current too low?"
    return f"{axis}: the mover does not follow everywhere; is an end stop within a pitch?"


def _offset(now: float, axis: str, at: Array, field: Field, findings: Findings) -> None:
    """Note the commutation offset beside the configured one, and what would have to change."""
    pitch = field.pitch
    # Friction stalls the mover on either side of the aligned position.
    b, c, a = (at[0] + at[4]) / 2, (at[1] + at[3]) / 2, (at[2] - pitch + at[5]) / 2
    expected = [field.position(phase) for phase in range(3)]
    turns = [(place - right) / pitch for place, right in zip((a, b, c), expected, strict=True)]
    # A mean of angles: half a pitch up and half a pitch down are the same place.
    mean = float(np.angle(np.mean(np.exp(2j * np.pi * np.array(turns))))) / (2 * math.pi)
    apart = [math.remainder(turn - mean, 1.0) for turn in turns]
    stall = float(np.mean(np.array([at[4] - at[0], at[3] - at[1], at[5] + pitch - at[2]]))) / 2
    worst = max(apart, key=abs)
    agree = abs(worst) <= SPREAD
    close = abs(mean) <= TOLERANCE
    findings.row(
        f"{axis}, position beside the aligned one",
        found=f"{1e3 * pitch * mean:+.3f} mm",
        expected=f"within {1e3 * pitch * TOLERANCE:.3f} mm",
        holds=close,
    )
    findings.row(
        f"{axis}, phases among each other",
        found=f"{1e3 * pitch * worst:+.3f} mm ({PHASES[apart.index(worst)]}), "
        f"friction stalls {1e3 * stall:.2f} mm short",
        expected=f"within {1e3 * pitch * SPREAD:.3f} mm",
        holds=agree,
    )
    if not agree:
        findings.tell(f"{axis}: the phases do not agree on an offset")
    elif close:
        findings.tell(f"{axis}: offset right within {1e3 * pitch * abs(mean):.3f} mm")
    else:
        findings.change(f"{axis}.offset", now=now, then=round(now - pitch * mean, 7))
        findings.tell(f"{axis}: offset wrong by {1e3 * pitch * mean:+.3f} mm")
