"""Parameters of an exported controller as C: initial values of `psrm_parameters`, and tables."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.config.planar import AXES
from motionlab.config.scenario import Scenario
from motionlab.control.compensation import (
    CANUDAS_DE_WIT,
    OBSERVER,
    OFF,
    PUBLISHED,
    RESIDUAL,
    REVERSED,
)
from motionlab.force_sharing.functions import (
    CUBIC,
    FORCE_PER_AMPERE,
    INVERSE_LEVELS,
    INVERSE_POSITIONS,
    LEAST_NORM,
    SHARE_LEVELS,
    SHARE_POSITIONS,
    SINE,
)
from motionlab.kernel.build import lane
from motionlab.kernel.layout import Parameters
from motionlab.lanes.bank import TABLES
from motionlab.plant.magnetics import AnalyticMap
from motionlab.plant.table_map import NORMAL_TERMS, THRUST_TERMS, TableMap

Array = NDArray[np.float64]

_LAWS = {
    OFF: "PSRM_LAW_OFF",
    OBSERVER: "PSRM_LAW_OBSERVER",
    PUBLISHED: "PSRM_LAW_PUBLISHED_K",
    RESIDUAL: "PSRM_LAW_RESIDUAL_K",
    CANUDAS_DE_WIT: "PSRM_LAW_CANUDAS_DE_WIT",
    REVERSED: "PSRM_LAW_REVERSED_K",
}
_FUNCTIONS = {
    LEAST_NORM: "PSRM_SHARING_LEAST_NORM",
    FORCE_PER_AMPERE: "PSRM_SHARING_FORCE_PER_AMPERE",
    SINE: "PSRM_SHARING_SINE",
    CUBIC: "PSRM_SHARING_CUBIC",
}
_UNBOUNDED = 1e300
_INDENT = "    "
_IN_A_LINE = 4


class _Field(NamedTuple):
    name: str
    value: str | Sequence[_Field]
    comment: str = ""


class ParameterCode(NamedTuple):
    """C of the parameters of both axes."""

    values: str  # the initialiser of psrm_parameters
    tables: str  # static const arrays that it names; empty with formulas alone


class Tables:
    """Static arrays, each once, whichever axes read them."""

    def __init__(self) -> None:
        self._names: dict[tuple[str, bytes], str] = {}
        self.definitions: list[str] = []

    def name(self, kind: str, shape: str, numbers: Array) -> str:
        """Return the name of an array of such numbers, which is defined if it is new."""
        key = (kind, numbers.tobytes())
        if key not in self._names:
            name = f"{kind}_{sum(k == kind for k, _ in self._names)}"
            self._names[key] = name
            self.definitions.append(_definition(name, shape, numbers))
        return self._names[key]


def parameter_code(scenario: Scenario, variant: str) -> ParameterCode:
    """Return the parameters of a variant's controller at the start of a scenario as C.

    Raises
    ------
    ConfigError
        If a force map is not there, or cannot be read.
    """
    controller = scenario.variants[variant].controller
    tables = Tables()
    with TABLES.lease():
        axes = [_Field("", _axis(lane(scenario, controller, axis), tables), axis) for axis in AXES]
    lines = _lines([_Field(".axis", axes)], _INDENT)
    return ParameterCode("\n".join(["{", *lines, "}"]), "\n".join(tables.definitions))


def _axis(par: Parameters, tables: Tables) -> list[_Field]:
    controller, law, sharing = par.controller, par.compensation, par.force_model.sharing
    return [
        _number("k_p", controller.k_p, "N/m"),
        _number("k_d", controller.k_d, "N s/m"),
        _number("M", controller.M, "kg"),
        _number("force_limit", controller.force_limit, "N"),
        _number("error_limit", par.limits.error, "m"),
        _flag("feedforward", controller.feedforward),
        _flag("disturbance_observer", controller.observer),
        _number("disturbance_alpha", controller.observer_alpha, "1"),
        _flag("delay", controller.delay),
        _flag("ideal_force", controller.ideal_force),
        _group("notch", [_number(name, b, "1") for name, b in par.notch._asdict().items()]),
        _group(
            "compensation",
            [
                _Field(".law", _LAWS[law.law]),
                _flag("enabled", law.enabled),
                _flag("from_reference", law.from_reference),
                _number("gain", law.gain, "1/s"),
                _number("residual_alpha", law.residual_alpha, "1"),
                _number("regularisation", law.regularisation, "1"),
                _number("bristle_limit", law.z_limit, "m"),
                _number("k_d_share", law.k_d_share, "1"),
            ],
        ),
        _group(
            "friction",
            [
                _number(name, value, unit)
                for (name, value), unit in zip(
                    par.model_friction._asdict().items(),
                    ("N/m", "N s/m", "N s/m", "N", "N", "m/s"),
                    strict=True,
                )
            ],
        ),
        _group(
            "sharing",
            [
                _Field(".function", _FUNCTIONS[sharing.law]),
                _number("overlap", sharing.overlap, "1"),
                _number("current_limit", sharing.current_limit, "A"),
                *_inverse(par, tables),
                _formula(par.force_model.map.formula),
                _Field(".table", table_code(par.force_model.map.table, tables)),
            ],
        ),
    ]


def _formula(formula: AnalyticMap) -> _Field:
    units = {"tau": "m", "offset": "m", "F_pk": "N", "I_pk": "A", "I_knee": "A"}
    names = ("tau", "offset", "F_pk", "I_pk", "I_knee", "h_2", "h_3")
    values = formula._asdict()
    return _group("formula", [_number(name, values[name], units.get(name, "1")) for name in names])


def _inverse(par: Parameters, tables: Tables) -> Iterator[_Field]:
    """Yield what a sharing function reads of a controller's table."""
    sharing = par.force_model.sharing
    current = share = "0"
    if par.force_model.map.table.thrust >= 0.0:
        inverse = _nodes(_placed(sharing.inverse, (INVERSE_POSITIONS, INVERSE_LEVELS, 4)))
        current = tables.name("CURRENT", "A, [position][sqrt(thrust)]", inverse)
    if sharing.shares >= 0.0:
        shape = (2 * SHARE_POSITIONS, SHARE_LEVELS, 4)
        share = tables.name(
            "SHARE", "share, [sense][position][force]", _nodes(_placed(sharing.shares, shape))
        )
    yield _Field(".current", current)
    yield _Field(".share", share)


def table_code(table: TableMap, tables: Tables, *, normal: bool = False) -> str:
    """Return the initialiser of a `psrm_table`, with the normal force or without.

    The caller holds a lease of the tables.
    """
    if table.thrust < 0.0:
        return "{0, 0, 0U, 0U, 1.0, 1.0}"
    cells = (int(table.positions), int(table.currents))
    thrust = tables.name(
        "THRUST", "N, [position][current][term]", _placed(table.thrust, (*cells, THRUST_TERMS))
    )
    attraction = "0"
    if normal:
        attraction = tables.name(
            "NORMAL", "N, [position][current][term]", _placed(table.normal, (*cells, NORMAL_TERMS))
        )
    sizes = f"{cells[0]}U, {cells[1]}U, {float(table.per_ampere)!r}, {float(table.gain)!r}"
    return f"{{{thrust}, {attraction}, {sizes}}}"


def _placed(first: float, shape: tuple[int, ...]) -> Array:
    """Return a table among all tables."""
    start = int(first)
    return TABLES.values[start : start + math.prod(shape)].reshape(shape).copy()


def _nodes(cells: Array) -> Array:
    """Return the nodes of cells that each hold their corners, shape (positions, levels + 1)."""
    return np.concatenate([cells[:, :, 0], cells[:, -1:, 1]], axis=1)


def _definition(name: str, shape: str, numbers: Array) -> str:
    texts = [repr(float(number)) for number in numbers.ravel()]
    lines = [", ".join(texts[i : i + _IN_A_LINE]) for i in range(0, len(texts), _IN_A_LINE)]
    body = ",\n    ".join(lines)
    return f"/* {shape} */\nstatic const double {name}[{len(texts)}] = {{\n    {body}\n}};\n"


def _number(name: str, value: float, unit: str) -> _Field:
    if math.isinf(value):
        return _Field(f".{name}", repr(_UNBOUNDED), f"{unit}: none")
    return _Field(f".{name}", repr(float(value)), unit)


def _flag(name: str, value: float) -> _Field:
    return _Field(f".{name}", f"{int(value)}U")


def _group(name: str, fields: Sequence[_Field]) -> _Field:
    return _Field(f".{name}", fields)


def _lines(fields: Sequence[_Field], indent: str) -> Iterator[str]:
    """Yield the lines of an initialiser's inside."""
    for name, value, comment in fields:
        aside = f" /* {comment} */" if comment else ""
        head = f"{name} = " if name else ""
        if isinstance(value, str):
            yield f"{indent}{head}{value},{aside}"
        else:
            yield f"{indent}{head}{{{aside}"
            yield from _lines(value, indent + _INDENT)
            yield f"{indent}}},"
