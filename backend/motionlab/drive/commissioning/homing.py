"""Step: both end stops, which tell the pitch that the mover is in, and the stroke."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from motionlab.config.drive import DriveAxisConfig
from motionlab.config.planar import AXES
from motionlab.drive.commissioning.field import (
    DRAW,
    EDGE,
    Field,
    drawn,
    of_axis,
    reference_model,
    turned,
)
from motionlab.drive.commissioning.record import Finding, Findings
from motionlab.drive.commissioning.run import StepRun, Traced, ticks_of
from motionlab.drive.link.bounds import OpenLoopTest
from motionlab.drive.link.shared import Figure

SPEED = 10e-3
"""At which the mover is drawn, m/s."""

BEYOND = 10e-3
"""By which the ends may be further apart than the limits of position, m."""

RAMP, REST = 0.3, 0.2  # s
_DOUBT = 0.25  # of a pitch, by which the middle may be off its nearest multiple


class _Ends(NamedTuple):
    """Where an axis was stopped, m; None where nothing stopped it."""

    low: float | None
    high: float | None


def find_stops(run: StepRun) -> Finding:
    """Draw each axis to both of its end stops, then to the middle between them.

    Raises
    ------
    Stopped
        If it was ended before.
    """
    model = reference_model()
    findings = Findings()
    for index, axis in enumerate(AXES):
        field = Field(axis, model)
        ends = _ends(run, index, field)
        _judge(getattr(run.config, axis), axis, ends, field.pitch, findings)
    return findings.finding()


def _ends(run: StepRun, index: int, field: Field) -> _Ends:
    """Return both ends of an axis; the mover is in the middle afterwards."""
    axis = AXES[index]
    config = getattr(run.config, axis)
    stroke = config.position_max - config.position_min + BEYOND
    begin, third = index / len(AXES), 1.0 / len(AXES) / 3.0
    ends: list[float | None] = []
    for number, (way, end) in enumerate(((1, "positive"), (-1, "negative"))):
        share = begin + number * third
        with run.part(share, share + third, f"{axis}: to its {end} end stop"):
            traced = _drawn(run, index, field, way * stroke, may_rest=True)
        ends.append(_last(traced, index) if traced.at_stop else None)
        if not traced.at_stop:
            return _Ends(None, *ends) if number == 0 else _Ends(*reversed(ends))
    high, low = ends
    assert low is not None
    assert high is not None
    with run.part(begin + 2 * third, begin + 3 * third, f"{axis}: to the middle"):
        _drawn(run, index, field, (high - low) / 2, may_rest=False)
    return _Ends(low, high)


def _drawn(run: StepRun, index: int, field: Field, way: float, *, may_rest: bool) -> Traced:
    """Draw an axis some way, m, from where it is, until it rests against a stop."""
    here = run.link.figure(Figure.POSITION)[index]
    speed = 3.0 * SPEED / field.pitch
    angles = turned(field.angle(here), field.angle(here + way), speed)
    current = DRAW * getattr(run.config, AXES[index]).current_max
    table = of_axis(drawn(angles, current, RAMP), index)
    travel = [0.5 * field.pitch] * len(AXES)
    travel[index] = abs(way) + field.pitch
    rest = ticks_of(REST) if may_rest else 0
    traced = run.test(OpenLoopTest(table, (travel[0], travel[1]), rest, ticks_of(RAMP + EDGE)))
    before_its_end = len(traced.position) < ticks_of(RAMP) + len(angles)
    return traced._replace(at_stop=traced.at_stop and before_its_end)


def _last(traced: Traced, index: int) -> float:
    return float(np.nanmedian(traced.position[-ticks_of(REST / 4) :, index]))


def _judge(
    config: DriveAxisConfig, axis: str, ends: _Ends, pitch: float, findings: Findings
) -> None:
    """Compare the ends that were found with the limits of position."""
    low, high = ends
    expected = f"beyond {1e3 * config.position_min:.1f} to {1e3 * config.position_max:.1f} mm"
    if low is None or high is None:
        side = "positive" if high is None else "negative"
        reach = 1e3 * (config.position_max - config.position_min + BEYOND)
        findings.row(f"{axis}, end stops", found=f"no {side} one", expected=expected, holds=False)
        findings.tell(f"{axis}: no {side} end stop within {reach:.0f} mm")
        return
    stroke, middle = high - low, (low + high) / 2
    off = middle - (config.position_min + config.position_max) / 2
    # Whole pitches off, the offset is wrong; part of a pitch off, the limits or the stops are.
    pitches = round(off / pitch)
    wide = stroke >= config.position_max - config.position_min
    sure = abs(off - pitches * pitch) <= _DOUBT * pitch
    shift = pitches * pitch
    inside = low - shift <= config.position_min and high - shift >= config.position_max
    findings.row(
        f"{axis}, end stops",
        found=f"{1e3 * low:.2f} to {1e3 * high:.2f} mm, stroke {1e3 * stroke:.2f} mm",
        expected=expected,
        holds=wide and inside and pitches == 0,
    )
    findings.row(
        f"{axis}, middle beside that of the limits",
        found=f"{1e3 * off:+.2f} mm" + (f", {_in_pitches(pitches)}" if pitches else ""),
        expected=f"within {1e3 * _DOUBT * pitch:.2f} mm",
        holds=sure and pitches == 0,
    )
    if not wide:
        findings.tell(
            f"{axis}: stopped after {1e3 * stroke:.2f} mm, less than its limits are apart; "
            "is something in its way, or are the limits too wide?"
        )
    elif not sure:
        findings.tell(
            f"{axis}: the middle is {1e3 * off:+.2f} mm off, no multiple of the pitch; "
            "are the limits those of this machine?"
        )
    elif pitches:
        then = round(config.offset - shift, 7)
        findings.change(f"{axis}.offset", now=config.offset, then=then)
        findings.tell(f"{axis}: offset wrong by {_in_pitches(pitches)}")
    elif not inside:
        findings.tell(f"{axis}: an end stop lies within the limits of position")
    else:
        findings.tell(f"{axis}: stroke {1e3 * stroke:.2f} mm, offset right")


def _in_pitches(count: int) -> str:
    return f"{count:+d} {'pitch' if abs(count) == 1 else 'pitches'}"
