"""The paper's design choices and data-sheet values: nothing to compute."""

from __future__ import annotations

from functools import partial

from motionlab.paper.printed_number import PrintedNumber

GROUP = "given"

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


_given = partial(PrintedNumber, group=GROUP, kind="input")

QUANTITIES = (
    *(
        _given(row_id, place, quantity, unit, paper, printed, reason=reason)
        for row_id, place, quantity, paper, unit, printed, reason in _GIVEN
    ),
    *(
        _given(
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
