"""What the best controller shipped reaches on the paper's circle, with a structural resonance."""

from __future__ import annotations

from collections.abc import Iterator

from tests.bench.table import Row
from tests.loop.shipped_controller import (
    GAIN_MARGIN,
    PHASE_MARGIN,
    PLACES,
    TARGETS,
    errors_over_the_pitch,
    least_margins,
    loop_margins,
)

_AIMS = {"x": 0.7e-6, "y": 1.3e-6}  # m, at mid-stroke


def controllers() -> Iterator[Row]:
    """Measure largest following errors and margins of both axes."""
    places = errors_over_the_pitch()
    for axis, (middle, anywhere) in TARGETS.items():
        here, worst = places[0][axis], max(place[axis] for place in places)
        aim = f"aim: {_AIMS[axis] * 1e6:g} um"
        yield _error(f"circle {axis}, max |e| at mid-stroke", here, middle, aim)
        where = f"worst of {PLACES} places"
        yield _error(f"circle {axis}, max |e| over the pole pitch", worst, anywhere, where)
    for axis in TARGETS:
        there, least = loop_margins(axis), least_margins(axis)
        rows = (
            ("gain", there.gain, least.gain, GAIN_MARGIN, "dB"),
            ("phase", there.phase, least.phase, PHASE_MARGIN, "deg"),
        )
        for name, margin, lowest, target, unit in rows:
            yield Row(
                f"  {name} margin {axis}, observer in the loop",
                f">= {target:g} {unit}",
                f"{margin:.1f} {unit}",
                f"any velocity: {lowest:.1f}",
                "",
                min(margin, lowest) >= target,
            )


def _error(what: str, error: float, target: float, reference: str) -> Row:
    met = error <= target
    return Row(what, f"<= {target * 1e6:g} um", f"{error * 1e6:.2f} um", reference, "", met)
