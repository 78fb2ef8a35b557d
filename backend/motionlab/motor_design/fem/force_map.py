"""A force map: co-energy, thrust and normal force of one phase over position and current."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from functools import cached_property
from typing import Any, Literal, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import Field, ValidationError, model_validator

from motionlab import __version__
from motionlab.config.quantity import Config
from motionlab.config.validation_errors import field_errors
from motionlab.errors import ConfigError, FieldError
from motionlab.motor_design.fem.cells import Cells
from motionlab.motor_design.fem.geometry import Geometry

FORMAT = "motionlab-force-map"
FORMAT_VERSION = 1
METHOD_VERSION = 1
"""Raised whenever the same geometry and preset would give other numbers."""

SIZE_MOST = 20_000_000
"""Largest file that is read, bytes."""

_NUMBER_MOST = 1e9
"""Largest number of a table, J, Wb or N: far beyond any motor, far below what overflows."""

_CONTRADICTION = 0.05
"""Largest share by which thrust and linkage may differ from the derivatives of the co-energy; those
of finite elements differ by 0.2 %."""

PresetName = Literal["preview", "default", "reference"]

Array = NDArray[np.float64]
Table = list[list[float]]


class ForceMapDocument(Config):
    """The file format: everything about one map, SI."""

    format: Literal["motionlab-force-map"] = FORMAT
    format_version: int = Field(default=FORMAT_VERSION, ge=FORMAT_VERSION, le=FORMAT_VERSION)
    method_version: int = Field(default=METHOD_VERSION, ge=1)
    motionlab_version: str = Field(default_factory=lambda: __version__)
    preset: PresetName
    method: str = Field(description="How the numbers were found, in words")
    content_hash: str = Field(description="Of geometry, preset and method_version")
    geometry: Geometry
    positions: list[float] = Field(min_length=5, max_length=1000, description="x, m, one pitch")
    currents: list[float] = Field(min_length=4, max_length=1000, description="i, A, from 0")
    coenergy: Table = Field(description="W'(x, i), J: a row for each position")
    linkage: Table = Field(description="Flux linkage dW'/di, Wb")
    thrust: Table = Field(description="By the stress tensor, N; the plant takes dW'/dx instead")
    normal_force: Table = Field(description="Attraction of mover and stator, N")

    @model_validator(mode="after")
    def _tables_fit(self) -> Self:
        x, i = np.array(self.positions), np.array(self.currents)
        tau = self.geometry.tau
        if not np.allclose(x, np.linspace(-tau / 2, tau / 2, len(x)), rtol=0, atol=1e-9 * tau):
            raise ValueError(f"positions must run evenly from {-tau / 2:g} to {tau / 2:g} m")
        if i[0] != 0 or not np.allclose(i, np.linspace(0, i[-1], len(i)), rtol=1e-9) or i[-1] <= 0:
            raise ValueError("currents must rise evenly from 0 A")
        for name in ("coenergy", "linkage", "thrust", "normal_force"):
            table = getattr(self, name)
            if len(table) != len(x) or any(len(row) != len(i) for row in table):
                raise ValueError(f"{name} must have {len(x)} rows of {len(i)} numbers")
            if np.abs(np.array(table)).max() > _NUMBER_MOST:
                raise ValueError(f"{name} must hold numbers up to {_NUMBER_MOST:g}")
        if np.ptp(np.array(self.coenergy)[:, -1]) == 0.0:
            raise ValueError("coenergy must change with position, or there is no thrust")
        return self


def content_hash(geometry: Geometry, preset: PresetName) -> str:
    """Return a map's name: a hash of all inputs of its numbers, 16 hexadecimal digits."""
    content = [METHOD_VERSION, preset, geometry.model_dump(mode="json")]
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:16]


class ForceMap:
    """Bicubic cells of one phase's co-energy and normal force, see `Cells`.

    ``x`` is 0 where mover and stator teeth are aligned and may be any number: the map repeats every
    pitch. In the plant ``x = p + offset - tau/2 - k tau/3`` for phase k at position p.

    Parameters
    ----------
    document : ForceMapDocument
        The map's nodes.
    """

    def __init__(self, document: ForceMapDocument) -> None:
        self.document = document
        self.tau = document.geometry.tau
        self.i_max = document.currents[-1]

    @classmethod
    def from_tables(cls, tables: Mapping[str, Any], where: str = "map") -> Self:
        """Return the map that a parsed file describes.

        Raises
        ------
        ConfigError
            Naming what is wrong with it.
        """
        try:
            return cls(ForceMapDocument.model_validate(tables))
        except ValidationError as error:
            problems = field_errors(error, ForceMapDocument)
            raise ConfigError(
                *(
                    FieldError(**{**vars(e), "loc": f"{where}: {e.loc}".rstrip(": ")})
                    for e in problems
                )
            ) from None

    def check_tables(self, where: str) -> None:
        """Refuse tables that contradict the co-energy, and the hash of another geometry.

        Raises
        ------
        ConfigError
            Naming the place, what the co-energy says there, and what is allowed.
        """
        d = self.document
        nodes = np.meshgrid(np.array(d.positions), np.array(d.currents), indexing="ij")
        for name, of in (("thrust", "dW'/dx"), ("linkage", "dW'/di")):
            table, derived = np.array(getattr(d, name)), getattr(self, name)(*nodes)
            scale = max(float(np.abs(table).max()), float(np.abs(derived).max()))
            deviation = np.abs(table - derived) / scale
            if deviation.max() <= _CONTRADICTION:
                continue
            row, column = np.unravel_index(int(deviation.argmax()), deviation.shape)
            message = (
                f"contradicts coenergy: {of} is {derived[row, column]:.4g} there, off by "
                f"{deviation.max():.0%} of the largest"
            )
            allowed = f"within {_CONTRADICTION:.0%} of the largest"
            loc = f"{where}: {name}.{row}.{column}"
            raise ConfigError(FieldError(loc, message, float(table[row, column]), allowed))
        right = content_hash(d.geometry, d.preset)
        if d.method_version == METHOD_VERSION and d.content_hash != right:
            message = "is not that of its geometry and preset"
            raise ConfigError(FieldError(f"{where}: content_hash", message, d.content_hash, right))

    @classmethod
    def from_text(cls, text: bytes, where: str) -> Self:
        """Return the map in a file's text.

        Parameters
        ----------
        text : bytes
            JSON, up to `SIZE_MOST` bytes.
        where : str
            What errors call it.

        Raises
        ------
        ConfigError
            If it is too large or not a map.
        """
        if len(text) > SIZE_MOST:
            raise ConfigError(FieldError(loc=where, message=f"is larger than {SIZE_MOST} bytes"))
        try:
            tables = json.loads(text)
        except (ValueError, RecursionError):
            raise ConfigError(FieldError(loc=where, message="is not JSON")) from None
        return cls.from_tables(tables, where)

    @cached_property
    def digest(self) -> str:
        """Hash of the map's numbers, 16 hexadecimal digits."""
        d = self.document
        numbers = [d.positions, d.currents, d.coenergy, d.normal_force]
        return hashlib.sha256(json.dumps(numbers).encode()).hexdigest()[:16]

    def text(self) -> str:
        """Return the file's text: JSON, one object."""
        return json.dumps(self.document.model_dump(mode="json"), allow_nan=False) + "\n"

    def coenergy(self, x: ArrayLike, i: ArrayLike) -> Array:
        """Return W', J, at positions `x`, m, and currents `i`, A, 0 to the largest.

        Raises
        ------
        ValueError
            If a current is outside of the map; the same for all that follow.
        """
        return self._at(self._coenergy, x, i)

    def thrust(self, x: ArrayLike, i: ArrayLike) -> Array:
        """Return dW'/dx, N: the derivative of the co-energy, so that energy is kept."""
        return self._at(self._coenergy, x, i, dx=1)

    def linkage(self, x: ArrayLike, i: ArrayLike) -> Array:
        """Return the flux linkage dW'/di, Wb."""
        return self._at(self._coenergy, x, i, di=1)

    def normal_force(self, x: ArrayLike, i: ArrayLike) -> Array:
        """Return the attraction of mover and stator, N."""
        return self._at(self._normal_force, x, i)

    def hermite(self, table: Literal["coenergy", "normal_force"] = "coenergy") -> Array:
        """Return the Hermite coefficients of co-energy or normal force, cell by cell.

        Returns
        -------
        array, shape (4, positions, currents)
            ``W', dW'/dx, dW'/di, d2W'/dx di`` at the nodes; J, N, Wb, Wb/m. A cell's bicubic
            follows from its four corners alone, which is what a compiled kernel needs.
        """
        return (self._coenergy if table == "coenergy" else self._normal_force).nodes.copy()

    def _at(self, cells: Cells, x: ArrayLike, i: ArrayLike, **order: int) -> Array:
        x, i = np.asarray(x, dtype=float), np.asarray(i, dtype=float)
        if not np.all((i >= 0) & (i <= self.i_max)):
            raise ValueError(f"currents must be 0 to {self.i_max:g} A")
        return cells.at(x - self.tau * np.round(x / self.tau), i, **order)

    @cached_property
    def _coenergy(self) -> Cells:
        return self._cells(self.document.coenergy)

    @cached_property
    def _normal_force(self) -> Cells:
        return self._cells(self.document.normal_force)

    def _cells(self, table: Table) -> Cells:
        d = self.document
        return Cells(np.array(d.positions), np.array(d.currents), np.array(table))
