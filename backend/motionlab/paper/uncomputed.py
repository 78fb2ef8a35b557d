"""Choices, data-sheet values and other machines: nothing to compute."""

from __future__ import annotations

from functools import partial

from motionlab.paper.printed_number import PrintedNumber

OTHER_MACHINES = "discussion"

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


_none = partial(PrintedNumber, group=OTHER_MACHINES, kind="no_data", reason=_OTHERS)

OTHER_MACHINE_ROWS = (
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
            group=OTHER_MACHINES,
            kind="input",
            reason=_PREVIOUS,
        )
        for row_id, quantity, paper, unit, printed in (
            ("previous-pitch", "Pole pitch", 9e-3, "m", "9 mm"),
            ("previous-tooth-pairs", "Tooth pairs", 2.0, "1", "n = 2"),
        )
    ),
)


CHOSEN_VALUES = "given"

_CHOSEN = "chosen by the paper: an input of everything here"
_HARDWARE = "hardware of the paper's machine: an input of everything here"

_UNUSED = "hardware of the paper's machine; nothing here depends on it"
_LIMIT = "chosen by the paper; commands are cut to it here, so that ours could not exceed it"
_DIAGONAL = f"{_CHOSEN}, as both diagonals of the rhombus"
_EDGE = f"{_CHOSEN}, as an edge of the pentagram: 2 R sin 72 deg of R = 30 mm"

_GIVEN = (
    ("f-max", "II-A-1", "Largest thrust of one phase f_max", 32.0, "N", "32 N", _CHOSEN),
    ("v-max", "II-A-1", "Largest velocity v_max", 1.0, "m/s", "1 m/s", _CHOSEN),
    ("i-max", "II-A-1", "Largest current of a phase", 10.0, "A", "10 A", _CHOSEN),
    ("air-gap", "II-A-2", "Air gap g", 0.3e-3, "m", "0.3 mm", _CHOSEN),
    ("tooth-pairs", "II-A-2", "Tooth pairs per mover n", 3.0, "1", "n = 3", _CHOSEN),
    (
        "field-strength",
        "II-A-2",
        "Field strength in the steel H_a",
        5e3,
        "A/m",
        "5000 A/m",
        _CHOSEN,
    ),
    ("efficiency", "II-A-2", "Efficiency K_e", 0.7, "1", "0.7", _CHOSEN),
    ("duty-cycle", "II-A-2", "Duty cycle K_d", 1.0, "1", "1", _CHOSEN),
    ("phases", "II-A-2", "Phases of an axis", 3.0, "1", "three-phase movers", _CHOSEN),
    ("platform-mass-x", "II-B", "Mass of the x platform", 5.7, "kg", "5.7 kg", _HARDWARE),
    ("mass-x", "IV-A", "Moving mass M_x", 5.9, "kg", "5.9 kg", _HARDWARE),
    ("mass-y", "IV-A", "Moving mass M_y", 13.9, "kg", "13.9 kg", _HARDWARE),
    ("gain-scale", "IV-A", "k in (19)", 1000.0, "1", "1000 mm/m", "a unit: gains are N/mm"),
    ("stroke-x", "V", "Stroke x", 0.17, "m", "170 mm", _HARDWARE),
    ("stroke-y", "V", "Stroke y", 0.29, "m", "290 mm", _HARDWARE),
    ("encoders", "IV-A", "Linear encoders", 2.0, "1", "two encoders", _HARDWARE),
    ("encoder", "IV-A", "Encoder resolution", 50e-9, "m", "50 nm", _HARDWARE),
    ("encoder-rate", "IV-A", "Encoder interface", 1.25e6, "Hz", "1.25 MHz", _UNUSED),
    ("drives", "IV-A", "Servo drives, one for each phase", 6.0, "1", "six drives", _HARDWARE),
    ("processor-rate", "IV-A", "Clock of the control board", 1e9, "Hz", "1 GHz", _UNUSED),
    ("control-period", "IV-A", "Sampling time", 0.5e-3, "s", "0.5 ms", _HARDWARE),
    ("current-limit", "IV-A", "Limit of the current command", 10.0, "A", "10 A", _LIMIT),
    ("force-limit", "IV-A", "Limit of the thrust command", 40.0, "N", "40 N", _LIMIT),
    ("circle-radius", "IV-A", "Radius of the circle", 15e-3, "m", "15 mm", _CHOSEN),
    ("switch-time", "IV-A", "Compensation is switched on", 90.0, "s", "90 s", _CHOSEN),
    ("step-500nm", "Table 1", "Step of the fine staircases", 0.5e-6, "m", "0.5 um", _CHOSEN),
    ("step-50mm", "Table 1", "Step of the coarse staircase", 50e-3, "m", "50 mm", _CHOSEN),
    ("trapezoid-travel", "Table 1", "Travel of the trapezoid", 0.29, "m", "290 mm", _CHOSEN),
    ("rhombus-travel", "Table 1", "Travel of the rhombus", 60e-3, "m", "60.00 mm", _DIAGONAL),
    ("pentagram-travel", "Table 1", "Travel of the pentagram", 57.06e-3, "m", "57.06 mm", _EDGE),
    ("motion-range", "IV-B", "Range of rhombus and pentagram", 60e-3, "m", "60 mm", _CHOSEN),
    ("lap-frequency", "IV-A", "Frequency of rhombus and pentagram", 1 / 3, "Hz", "1/3 Hz", _CHOSEN),
)

_GAINS = (
    ("stair-x-500nm", "x staircase of 0.5 um", {"x": (3200.0, 1.50)}),
    ("stair-y-500nm", "y staircase of 0.5 um", {"y": (6000.0, 3.00)}),
    ("stair-y-50mm", "y staircase of 50 mm", {"y": (800.0, 1.23)}),
    ("trapezoid-y", "y trapezoid of 290 mm", {"y": (987.0, 1.60)}),
    ("rhombus", "rhombus", {"x": (400.0, 1.48), "y": (501.6, 1.57)}),
    ("pentagram", "pentagram", {"x": (200.3, 1.53), "y": (280.5, 1.08)}),
)
_TUNED = (
    "corrected by hand on the machine after a simplex search whose objective is not printed; the "
    "gains that run here"
)


_input = partial(PrintedNumber, group=CHOSEN_VALUES, kind="input")

CHOSEN_VALUE_ROWS = (
    *(
        _input(row_id, place, quantity, unit, paper, printed, reason=reason)
        for row_id, place, quantity, paper, unit, printed, reason in _GIVEN
    ),
    *(
        _input(
            *(f"gain-{name}-{axis}-{symbol}", "Table 1", f"k_{axis}{symbol} of the {what}"),
            *(unit, value * 1e3, f"{value:{digits}} {printed_unit}"),
            reason=_TUNED,
        )
        for name, what, axes in _GAINS
        for axis, (k_p, k_d) in axes.items()
        for symbol, value, unit, printed_unit, digits in (
            ("p", k_p, "N/m", "N/mm", ".1f"),
            ("d", k_d, "N s/m", "N s/mm", ".2f"),
        )
    ),
)
