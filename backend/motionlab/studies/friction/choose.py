"""Which friction model a record supports, or why it cannot be told.

Models are compared by what they leave of the force in windows that they were not fitted to. With
the rests a and b of two models there, ``D = sum (a^2 - b^2)``. The motion is known, so that only
the noise of the force makes D uncertain, of which b is the best estimate::

    a = b + delta,   D = sum (2 b delta + delta^2),   SE(D)^2 = sum_g (sum_{i in g} 2 b delta)^2

over blocks g of the record, within which noise may be correlated. A model is clearly worse where
the error is larger by a share that matters, and beyond scatter: D is, or the mean over the blocks
of the logarithm of the ratio of errors, which a single block cannot decide.

The simplest model that is not clearly worse than the best is selected, but only where the record
would have shown what the others add: stiction at speeds that it has, a bristle longer than the
encoder's noise, friction by a normal force that changes.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.studies.friction.candidates import COULOMB, LOADED, LUGRE, STRIBECK, Candidate
from motionlab.studies.friction.fit import BLOCKS, Fit, Windows, ends_of, parameters_of, rest_at
from motionlab.studies.identify.fit import scatter, student

Array = NDArray[np.float64]

_CLEAR, _CLEAR_EACH = 2.5, 3.0  # standard errors, of D and of the ratios of the blocks
_MATTERS = 0.1  # of an error
_EFFECT = 0.1
"""Share of F_c of an effect that a record must show or exclude."""

_SPEEDS = (0.03, 0.1, 0.3)
"""Stribeck velocities at which stiction is looked for, as shares of the largest velocity."""

BRISTLE = 1e-6
"""Displacement before sliding that a record must show or exclude, m."""

_UNEXPLAINED = 0.3
"""Error of the best model, as a share of the friction, beyond which none explains it."""


class Difference(NamedTuple):
    """Error of a model less that of another, N RMS, and its standard error."""

    value: float
    error: float


@dataclass(frozen=True)
class Choice:
    """What a record says of friction models.

    Attributes
    ----------
    best : str
        Model of the least held-out error.
    selected : str or None
        The model; None where it cannot be told.
    among : tuple of str
        Models between which it cannot be told; the one that is selected.
    reasons : tuple of str
        Why, in sentences.
    friction : float
        RMS of the best model's friction, N.
    explained : bool
        Whether the best model explains the force.
    """

    best: str
    selected: str | None
    among: tuple[str, ...]
    reasons: tuple[str, ...]
    friction: float
    explained: bool


def rms(errors: Array) -> float:
    """Return a root mean square."""
    return float(np.sqrt(np.mean(errors**2)))


def difference(errors: Array, best: Array, block: NDArray[np.intp]) -> Difference:
    """Return by how much a model's held-out error is larger than another's."""
    cross = np.bincount(block, 2.0 * best * (errors - best), minlength=BLOCKS)
    size = 2.0 * len(errors) * rms(best)
    spread = float(np.sqrt(np.sum(cross**2))) / size
    return Difference(rms(errors) - rms(best), spread)


def clearly_worse(errors: Array, best: Array, block: NDArray[np.intp]) -> bool:
    """Return whether a model's held-out error is larger by what matters, and beyond scatter."""
    if rms(errors) <= (1.0 + _MATTERS) * rms(best):
        return False
    gap = float(np.sum(errors**2 - best**2))
    cross = np.bincount(block, 2.0 * best * (errors - best), minlength=BLOCKS)
    if gap > _CLEAR * float(np.sqrt(np.sum(cross**2))):
        return True
    squares = [np.bincount(block, each**2, minlength=BLOCKS) for each in (errors, best)]
    ratio = np.log(squares[0] / squares[1])
    return float(ratio.mean()) > _CLEAR_EACH * float(ratio.std(ddof=1)) / np.sqrt(BLOCKS)


def choose(
    windows: Windows,
    fits: Mapping[str, Fit],
    errors: Mapping[str, Array],
    left_out: Mapping[str, str],
) -> Choice:
    """Select a model.

    Parameters
    ----------
    windows : Windows
        The record.
    fits : mapping
        Models fitted to all of it, by name.
    errors : mapping
        Their held-out errors, N, (m,).
    left_out : mapping
        Models that were not tried because the record cannot show them, and why.
    """
    possible = [name for name, fitted in fits.items() if _is_possible(fitted)]
    best = min(possible, key=lambda name: rms(errors[name]))
    block = windows.block
    equal = [n for n in possible if not clearly_worse(errors[n], errors[best], block)]
    order = {name: each.candidate.order for name, each in fits.items()}
    simplest = [n for n in equal if order[n] == min(order[n] for n in equal)]
    reasons = [*dict.fromkeys(left_out.values())]
    among = [*simplest, *left_out]
    if len(simplest) > 1:
        labels = " and ".join(fits[name].candidate.label for name in simplest)
        reasons.append(f"{labels} leave the same error: the record does not tell them apart")
    else:
        (one,) = simplest
        for other in equal:
            if order[other] > order[one] and (why := _hidden(windows, fits, one, other)):
                among.append(other)
                reasons.append(why)
    friction = _friction(fits[best])
    explained = rms(errors[best]) <= _UNEXPLAINED * friction
    if not explained:
        among = [*fits, *left_out]
        reasons = [
            f"no model explains the force: the best leaves {rms(errors[best]):.3g} of a friction "
            f"of {friction:.3g} RMS"
        ]
    selected = among[0] if len(among) == 1 else None
    reasons = [*dict.fromkeys(reasons)]
    return Choice(best, selected, tuple(among), tuple(reasons), friction, explained)


def _is_possible(fitted: Fit) -> bool:
    """Return whether friction does not fall with the normal force."""
    linear = fitted.candidate.linear
    return "mu" not in linear or fitted.linear[linear.index("mu")] > 0.0


def _friction(fitted: Fit) -> float:
    own = len(fitted.candidate.linear)
    return rms(fitted.jacobian[:, :own] @ fitted.linear[:own])


def _hidden(windows: Windows, fits: Mapping[str, Fit], one: str, other: str) -> str | None:
    """Return why a record cannot show what another model adds to one, or None if it would."""
    pair: tuple[Candidate, Candidate] = fits[one].candidate, fits[other].candidate
    if pair[1].whole:
        return None  # what an effect adds is not known
    if pair == (COULOMB, STRIBECK):
        return _hidden_stiction(windows, fits[one])
    if pair[0] in {COULOMB, STRIBECK}:
        return _hidden_bristle(windows, fits[one], fits[LUGRE.name])
    if pair == (LUGRE, LOADED):
        return _hidden_load(windows, fits[other])
    return None


def _hidden_stiction(windows: Windows, coulomb: Fit) -> str | None:
    F_c, v_0 = coulomb.linear[0], coulomb.shape[0]
    for share in _SPEEDS:
        v_s = share * windows.velocity
        shape = np.array([v_0, np.log(v_s)])
        table, linear, rest = rest_at(windows, STRIBECK, shape)
        spread = scatter(table, rest, windows.block)
        at = STRIBECK.linear.index("falls")
        high = abs(linear[at]) + student(spread.degrees)[at] * spread.errors[at]
        if not high <= _EFFECT * F_c:
            return (
                f"stiction that is gone at {windows.machine.speed(v_s)} would not be seen within "
                f"{100 * _EFFECT:.0f} % of F_c: the record has too little slow and fast sliding"
            )
    return None


def _hidden_bristle(windows: Windows, static: Fit, lugre: Fit) -> str | None:
    shape = lugre.shape.copy()
    low, high = ends_of(windows, LUGRE)
    shape[0] = np.clip(np.log(BRISTLE), low[0], high[0])
    rest = rest_at(windows, LUGRE, shape)[2]
    if clearly_worse(rest, static.rest, windows.block):
        return None
    return (
        f"a displacement of {windows.machine.displacement(BRISTLE)} before sliding would not be "
        "seen: reversals are few or fast, or the encoder is too coarse"
    )


def _hidden_load(windows: Windows, loaded: Fit) -> str | None:
    mu = parameters_of(windows, loaded)["mu"]
    F_c = parameters_of(windows, loaded)["F_c"].value
    normal = windows.path.normal
    assert normal is not None
    if mu.value + mu.half <= _EFFECT * F_c / float(np.nanmean(np.abs(normal))):
        return None
    return (
        f"friction by normal force may be mu = {mu.value:.2g} +- {mu.half:.1g}: the record neither "
        "shows nor excludes it"
    )
