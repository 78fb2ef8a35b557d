"""Whether a measurement was controlled as a scenario says: from what its error and force tell.

The response from following error to force, ``C = G_u/(1 - G_y)``, is that of the controller,
whatever the machine is. What a log has wrong, it has wrong here: the sign or the unit of a column,
the time at which the force is logged, the gains.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from motionlab.errors import ConfigError, FieldError
from motionlab.loop.linearise import Loop
from motionlab.studies.response.documents import MarginInterval
from motionlab.studies.response.report import MARGINS
from motionlab.studies.response.spectral import Signals, local_estimate

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

COHERENT = 0.9
"""Least coherence of error and force at a frequency that is used."""
LINES_MIN = 5
OTHER = "its force is not what the scenario's controller makes of its following error"
"""How every note of this module begins."""
_ALIKE = 0.1  # median distance from the scenario's controller, over its magnitude
_CROSSOVER = 0.04  # share by which two crossovers are apart
_APART = {"phase_margin": 2.0, "gain_margin": 0.5, "gain_reduction": 1.0}  # degrees, and dB
_LATE = 3.0  # periods to either side within which a shift of the force is looked for
_SHIFTS = 241


def controller_notes(signals: Signals, frequency: Array, loop: Loop) -> list[str]:
    """Return a note where a measurement was not controlled as the scenario says.

    Parameters
    ----------
    signals : Signals
        Reference as excitation, force and position of the measurement.
    frequency : ndarray, shape (lines,)
        Hz, of `lines_between`.
    loop : Loop
        With the scenario's controller.

    Raises
    ------
    ConfigError
        If the force has the sign of one that acts the other way.
    """
    error = signals.excitation - signals.position
    turned = Signals(signals.excitation, error, signals.command, signals.period, referred=False)
    measured = local_estimate(turned, frequency)
    sure = np.isfinite(measured.deviation) & (measured.coherence >= COHERENT)
    if sure.sum() < LINES_MIN:
        return []
    f = frequency[sure]
    ratio = measured.response[sure] / loop.controller.response(f)
    size = float(np.median(np.abs(ratio)))
    late, sign, rest = _shift(f, ratio / size, signals.period)
    if rest > _ALIKE:
        off = 100.0 * float(np.median(np.abs(ratio - 1.0)))
        return [
            f"{OTHER}: it differs by {off:.2g} %. Margins are those of the scenario's controller; "
            "check its gains and rate, and the columns"
        ]
    if sign < 0.0:
        message = (
            "acts against the following error: its sign is reversed. Turn it around where it is "
            "imported, such as by the unit -1 N"
        )
        raise ConfigError(FieldError("force_column", message))
    wrong = []
    if abs(math.log(size)) > _ALIKE:
        wrong.append(f"{size:.4g} times that, by the unit of a column or the gains")
    if abs(late) > 0.2 * signals.period:
        when = (
            "later, as a measured current is: log the command"
            if late > 0.0
            else "earlier, as a command is whose delay the scenario counts: leave out that delay"
        )
        wrong.append(f"{1e3 * abs(late):.3g} ms {when}")
    return [f"{OTHER}: it is {', and '.join(wrong)}"] if wrong else []


def with_own_margins(notes: list[str], own: dict[str, MarginInterval]) -> list[str]:
    """Return notes that say where a measurement's own loop has other margins than the scenario's.

    That is added to what `controller_notes` has to say of the controller.
    """
    apart = []
    for name, (title, shown) in MARGINS.items():
        value, ends, model = own[name].value, own[name].interval, own[name].model
        if value is None or ends is None:
            continue
        if model is None:
            apart.append(f"{title} {shown(value):.3g} in place of none")
        elif not ends[0] <= model <= ends[1]:
            here, there = shown(value), shown(model)
            if abs(here - there) > _APART.get(name, _CROSSOVER * there):
                apart.append(f"{title} {here:.3g} in place of {there:.3g}")
    if not apart:
        return notes
    text = f"its own loop, from following error to position, has {'; '.join(apart)}"
    if not any(each.startswith(OTHER) for each in notes):
        return [*notes, f"{OTHER}: {text}"]
    return [f"{each}. So {text}" if each.startswith(OTHER) else each for each in notes]


def _shift(f: Array, ratio: Complex, period: float) -> tuple[float, float, float]:
    """Return delay, s, and sign that bring a ratio nearest to 1, and the median distance left."""
    late = np.linspace(-_LATE, _LATE, _SHIFTS) * period
    turned = ratio * np.exp(2j * np.pi * np.outer(late, f))
    distance = np.array([np.median(np.abs(sign * turned - 1.0), axis=1) for sign in (1.0, -1.0)])
    which, k = np.unravel_index(np.argmin(distance), distance.shape)
    return float(late[k]), (1.0, -1.0)[int(which)], float(distance[which, k])
