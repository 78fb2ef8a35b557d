"""The paper's figures of other machines, sections I, II-A and IV-B: nothing to compute."""

from __future__ import annotations

from functools import partial

from motionlab.paper.printed_number import PrintedNumber

GROUP = "discussion"

_OTHERS = "a result of another machine, in another paper, from data that this one does not print"
_PREVIOUS = "a design of another paper, of which this one prints two numbers: the preset previous"

_STROKES = (
    ("h2w", "Stroke of the Sawyer motor of [27]", (1.0, 1.5), "up to 1.0 m x 1.5 m"),
    ("jung", "Stroke of the DC planar motor of [19]", (0.32, 0.32), "32 cm x 32 cm"),
    ("previous", "Stroke of the previous machine, [30]", (0.1, 0.18), "100 mm x 180 mm"),
)

_RESULTS = (
    ("h2w-step", "I", "Microstep of the Sawyer motor of [27]", 1e-6, "1 um", ""),
    (
        "conveyor-stroke",
        "I",
        "Stroke of the magnetically suspended motors of [28]",
        None,
        "in the centimeter range",
        "No number is printed",
    ),
    ("conveyor-repeatability", "I", "Repeatability of the motors of [28]", 1e-6, "1 um", ""),
    ("zhu-error", "I", "Rms error of the positioner of [29]", 50e-9, "approximately 50 nm", ""),
    ("zhu-step", "I", "Steps that the positioner of [29] tracks", 200e-9, "200 nm", ""),
    (
        "jung-repeatability",
        "I",
        "Repeatability of the DC planar motor of [19]",
        500e-9,
        "approximately 500 nm",
        "",
    ),
    (
        "previous-steady-state",
        "I, IV-B",
        "Steady-state error of the previous machine",
        2e-6,
        "±2 um",
        "Cited as [30] in section I and as [26] in IV-B; it fits [30]",
    ),
    (
        "previous-step",
        "I, IV-B",
        "Travel at the previous machine's steady-state error",
        20e-3,
        "20 mm",
        "",
    ),
    (
        "previous-tracking",
        "IV-B",
        "Following error of the previous machine",
        500e-6,
        "±500 um",
        "Cited as [16]; it fits [13]",
    ),
    (
        "previous-range",
        "IV-B",
        "Range at the previous machine's following error",
        40e-3,
        "40 mm",
        "",
    ),
)


_none = partial(PrintedNumber, group=GROUP, kind="no_data", reason=_OTHERS)

QUANTITIES = (
    *(
        _none(f"{name}-stroke-{axis}", "I", f"{quantity}, {axis}", "m", length, printed)
        for name, quantity, lengths, printed in _STROKES
        for axis, length in zip("xy", lengths, strict=True)
    ),
    *(
        _none(row_id, place, quantity, "m", paper, printed, note=note)
        for row_id, place, quantity, paper, printed, note in _RESULTS
    ),
    *(
        PrintedNumber(
            *(row_id, "II-A-2", f"{quantity} of the previous design", unit, paper, printed),
            group=GROUP,
            kind="input",
            reason=_PREVIOUS,
        )
        for row_id, quantity, paper, unit, printed in (
            ("previous-pitch", "Pole pitch", 9e-3, "m", "9 mm"),
            ("previous-tooth-pairs", "Tooth pairs", 2.0, "1", "n = 2"),
        )
    ),
)
