"""Friction models that a record is tried with, each linear but for a few shape numbers.

With velocity v, normal force N and constants that are fitted, the friction is::

    Coulomb-viscous   F_c s + sigma_2 v,                 s = tanh(v/v_0)
    Stribeck          (F_c + (F_s - F_c) q) s + sigma_2 v,    q = exp(-(v/v_s)^2)
    LuGre             F_s (u + tau du/dt) + sigma_2 v,   du/dt = (v - abs(v) u/l)/x_0
    LuGre with load   the same, and mu N (u + tau du/dt)/l
    GMS               F_s (sum of four elements) + sigma_2 v

with ``l = c + (1 - c) q``, ``c = F_c/F_s``, ``x_0 = F_s/sigma_0``, ``tau = sigma_1/sigma_0``: the
bristle u is sigma_0 z/F_s of eqs (20) to (22), the load acts as in `motionlab.effects.lugre`, the
elements are those of `motionlab.effects.gms` with the attraction ``C = r F_s``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.effects.effect import MidStep
from motionlab.effects.gms import Gms, GmsState, gms
from motionlab.lanes import WIDTH, Lanes, cached, pack, unpack
from motionlab.plant.friction import LuGre, stribeck_fade
from motionlab.studies.identify.presliding import bristle

Array = NDArray[np.float64]


class Path(NamedTuple):
    """The motion that friction follows, at every sample.

    Attributes
    ----------
    position, velocity : ndarray, shape (n,)
        m and m/s, smoothed.
    lost : ndarray of bool, shape (n,)
        Where an internal state is not known, and zero.
    period : float
        Between two samples, s.
    normal : ndarray, shape (n,), or None
        Normal force, N.
    """

    position: Array
    velocity: Array
    lost: NDArray[np.bool_]
    period: float
    normal: Array | None = None


class Shape(NamedTuple):
    """A shape number: its name, and its range in units of the record's scale of it.

    Attributes
    ----------
    name : str
        As in the equations above.
    low, high : float
        Ends of its range.
    starts : tuple of float
        Where a search begins.
    scale : str
        ``velocity``, the largest of the record; ``length``, m; or ``one``.
    """

    name: str
    low: float
    high: float
    starts: tuple[float, ...]
    scale: str = "one"


Columns = Callable[[Path, Array], Iterator[Sequence[Array]]]
"""Takes a path and sets of shape numbers, (sets, shapes); yields the columns of each, (n,)."""


@dataclass(frozen=True, eq=False)
class Candidate:
    """A friction model.

    Attributes
    ----------
    name, label : str
        In documents, and on the screen.
    order : int
        Number of its parameters: how complex it is.
    shapes : tuple of Shape
        Its nonlinear numbers.
    forces : callable
        The columns of its linear ones.
    linear : tuple of str
        Names of these.
    parameters : callable
        ``parameters(shapes and linear numbers by name)``: the usual parameters by name.
    whole : bool
        Whether the first column is the force itself, without a linear number.
    starts : ndarray, shape (sets, shapes), or None
        Where a search begins, in place of those of `shapes`.
    refused : callable
        Whether shape numbers do not go together.
    units : mapping
        Units of parameters of which `motionlab.studies.friction.units` does not know.
    may_be_zero : frozenset of str
        Parameters that may be zero: intervals far larger than their value say something.
    """

    name: str
    label: str
    order: int
    shapes: tuple[Shape, ...]
    forces: Columns
    linear: tuple[str, ...]
    parameters: Callable[[dict[str, float]], dict[str, float]]
    whole: bool = False
    starts: Array | None = None
    refused: Callable[[Array], bool] = lambda _: False
    units: Mapping[str, str] = field(default_factory=dict)
    may_be_zero: frozenset[str] = frozenset()


# -- forces ---------------------------------------------------------------------------------------


def _static(path: Path, shapes: Array) -> Iterator[Sequence[Array]]:
    v = path.velocity
    for (v_0,) in shapes:
        yield np.tanh(v / v_0), v


def _stribeck(path: Path, shapes: Array) -> Iterator[Sequence[Array]]:
    v = path.velocity
    for v_0, v_s in shapes:
        s = np.tanh(v / v_0)
        yield s, s * stribeck_fade(v, v_s), v


def _bent(path: Path, shape: Sequence[float]) -> Array:
    """Return ``u + tau du/dt``."""
    x_0, c, v_s, tau = shape
    friction = LuGre(1.0 / x_0, 0.0, 0.0, c, 1.0, v_s)
    u = bristle(path.position, path.velocity, path.lost, friction) / x_0
    return u + tau * np.gradient(u, path.period)


def _lugre(path: Path, shapes: Array) -> Iterator[Sequence[Array]]:
    for shape in shapes:
        yield _bent(path, shape), path.velocity


def _loaded(path: Path, shapes: Array) -> Iterator[Sequence[Array]]:
    assert path.normal is not None
    for shape in shapes:
        w, (_, c, v_s, _) = _bent(path, shape), shape
        level = c + (1.0 - c) * stribeck_fade(path.velocity, v_s)
        yield w, path.normal * w / level, path.velocity


class _Force(NamedTuple):
    force: Lanes


@cached
def _elements(
    parameters: Array, position: Array, lost: NDArray[np.bool_], period: float, force: Array
) -> None:
    """Write the mean force of eight sets of elements from each sample to the next, (n, 1, 8)."""
    par = unpack(Gms, parameters, 0)
    zero = 0.0 * par.sigma_0
    rest = GmsState(zero, zero, zero, zero, zero, zero, zero, zero)
    state = rest
    h = zero + period
    for k in range(len(position) - 1):
        if lost[k]:
            state = rest
        v = zero + (position[k + 1] - position[k]) / period
        seen = MidStep(zero, v, zero, zero, zero, zero, zero, zero, zero, h)
        resistance, state = gms(par, state, seen)
        pack(_Force(resistance.force), force[k])


def _gms(path: Path, shapes: Array) -> Iterator[Sequence[Array]]:
    for first in range(0, len(shapes), WIDTH):
        some = shapes[first : first + WIDTH]
        x_0, c, v_s, rate = np.concatenate([some, np.repeat(some[-1:], WIDTH - len(some), 0)]).T
        one, none = np.ones(WIDTH), np.zeros(WIDTH)
        par = np.stack(Gms(1.0 / x_0, none, c, one, v_s, rate, none, none, one))
        within = np.zeros((len(path.position), 1, WIDTH))
        _elements(par, path.position, path.lost, path.period, within)
        at = within[:, 0, : len(some)].T
        at[:, 1:] = 0.5 * (at[:, 1:] + at[:, :-1])  # at the samples
        for force in at:
            yield force, path.velocity


# -- parameters -----------------------------------------------------------------------------------

Numbers = dict[str, float]


def _of_static(n: Numbers) -> Numbers:
    return {name: n[name] for name in ("F_c", "sigma_2", "v_0")}


def _of_stribeck(n: Numbers) -> Numbers:
    return {
        "F_c": n["F_c"],
        "F_s": n["F_c"] + n["falls"],
        "v_s": n["v_s"],
        "sigma_2": n["sigma_2"],
        "v_0": n["v_0"],
    }


def _of_bristle(n: Numbers) -> Numbers:
    sigma_0 = n["F_s"] / n["x_0"]
    known = {"F_c": n["c"] * n["F_s"], "F_s": n["F_s"], "v_s": n["v_s"], "sigma_2": n["sigma_2"]}
    return known | {"sigma_0": sigma_0}


def _of_lugre(n: Numbers) -> Numbers:
    known = _of_bristle(n)
    return known | {"sigma_1": n["tau"] * known["sigma_0"]}


_V_0 = Shape("v_0", 1e-5, 0.1, (1e-3, 1e-2), "velocity")
_V_S = Shape("v_s", 3e-3, 2.0, (0.02, 0.06, 0.2, 0.6), "velocity")
_X_0 = Shape("x_0", 1e-7, 5e-4, (1e-6, 1e-5, 1e-4), "length")
_C = Shape("c", 0.01, 1.5, (0.15, 0.7))
_TAU = Shape("tau", 1e-5, 1.0, (3e-3,))
_RATE = Shape("r", 0.1, 1e5, (10.0, 300.0))
_BRISTLE = (_X_0, _C, _V_S)

COULOMB = Candidate(
    "coulomb", "Coulomb-viscous", 2, (_V_0,), _static, ("F_c", "sigma_2"), _of_static
)
STRIBECK = Candidate(
    "stribeck",
    "Stribeck",
    4,
    (_V_0, _V_S),
    _stribeck,
    ("F_c", "falls", "sigma_2"),
    _of_stribeck,
)
LUGRE = Candidate("lugre", "LuGre", 6, (*_BRISTLE, _TAU), _lugre, ("F_s", "sigma_2"), _of_lugre)
GMS = Candidate(
    "gms",
    "GMS",
    6,
    (*_BRISTLE, _RATE),
    _gms,
    ("F_s", "sigma_2"),
    lambda n: _of_bristle(n) | {"C": n["r"] * n["F_s"]},
)
LOADED = Candidate(
    "lugre-load",
    "LuGre with load",
    7,
    (*_BRISTLE, _TAU),
    _loaded,
    ("F_s", "mu", "sigma_2"),
    lambda n: _of_lugre(n) | {"mu": n["mu"]},
    may_be_zero=frozenset({"mu"}),
)
CANDIDATES = (COULOMB, STRIBECK, LUGRE, GMS, LOADED)
"""In the order of their complexity."""
