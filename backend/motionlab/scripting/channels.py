"""Channels as arrays with units, and what they are given on as: tables, figures, files."""

from __future__ import annotations

import functools
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.config.named_configs import did_you_mean
from motionlab.errors import ConfigError, FieldError, naming_extras
from motionlab.files import check_target, complete_file
from motionlab.reports import svg_chart as chart
from motionlab.reports.markup import Markup, element
from motionlab.telemetry.channels import Channel
from motionlab.telemetry.decimate import min_max
from motionlab.telemetry.expressions.columns import compile_column, is_math, values_of
from motionlab.telemetry.expressions.parse import ExpressionError
from motionlab.timing import CONTROL_PERIOD

if TYPE_CHECKING:
    import pandas as pd
    import pyarrow as pa
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

BINS = 600
"""Of a curve in a notebook."""

_GRID = "#8a96a04d"


class Samples(np.ndarray[tuple[int, ...], np.dtype[Any]]):
    """An array that knows its unit, until one computes with it.

    Slices and copies keep `name` and `unit`; the result of an operation is a plain array, for its
    unit may be another.

    Attributes
    ----------
    name, unit : str
        Such as ``B.x.following_error`` and ``m``.
    """

    name: str
    unit: str

    def __new__(cls, values: NDArray[Any], name: str, unit: str) -> Samples:
        """Return `values` as samples; a view."""
        made = np.asarray(values).view(cls)
        made.name, made.unit = name, unit
        return made

    def __array_finalize__(self, other: object) -> None:
        """Keep name and unit of what this is a part or a copy of."""
        self.name, self.unit = getattr(other, "name", ""), getattr(other, "unit", "")

    def __array_wrap__(  # pyright: ignore[reportIncompatibleMethodOverride]
        self, array: NDArray[Any], context: Any = None, return_scalar: bool = False
    ) -> Any:
        """Return the result of an operation, without unit."""
        plain = np.asarray(array)
        return plain[()] if return_scalar else plain

    def __repr__(self) -> str:
        """Return the array with its unit."""
        return f"{np.array2string(np.asarray(self), threshold=6)} {self.unit}  # {self.name}"


class Record(NamedTuple):
    """What was recorded.

    Attributes
    ----------
    values : callable
        Takes names of channels; returns their samples, float32, shape (names, ticks).
    ticks : range
        Ticks of the samples, 0.5 ms each.
    metadata : dict of str to str
        Kept in Parquet files: what reproduces the record.
    """

    values: Callable[[Sequence[str]], NDArray[np.float32]]
    ticks: range
    metadata: dict[str, str]


class Kept(NamedTuple):
    """Samples of channels in the order of their names, as a record."""

    names: Sequence[str]
    samples: NDArray[np.float32]
    ticks: range
    metadata: dict[str, str]

    def record(self) -> Record:
        """Return them as a record."""
        return Record(self.values, self.ticks, self.metadata)

    def values(self, names: Sequence[str]) -> NDArray[np.float32]:
        """Return the samples of some channels, shape (names, ticks)."""
        return self.samples[[self.names.index(name) for name in names]]


_OPERATORS = re.compile(r"[()*/+^]|^-|\s-\s")
"""Marks of an expression without a name; no channel's name has one."""


class Channels(Mapping[str, Samples]):
    """Channels over common ticks: ``channels["B.x.following_error"]``.

    A key is a channel, or a math channel such as ``"error = hypot(B.x.following_error,
    B.y.following_error)"``, whose units are checked (docs/expressions.md).

    Parameters
    ----------
    described : mapping of str to Channel
        Unit and meaning of every channel.
    record : callable
        Returns what was recorded; called once, when the first sample is asked for.
    """

    def __init__(self, described: Mapping[str, Channel], record: Callable[[], Record]) -> None:
        self.described = dict(described)
        self._recorded = record

    @functools.cached_property
    def record(self) -> Record:
        """What was recorded."""
        return self._recorded()

    @property
    def ticks(self) -> range:
        """Ticks of the samples, 0.5 ms each."""
        return self.record.ticks

    @property
    def time(self) -> Samples:
        """Time of each sample, s, float64, shape (ticks,)."""
        return Samples(np.asarray(self.ticks) * CONTROL_PERIOD, "time", "s")

    def __getitem__(self, key: str) -> Samples:
        """Return the samples of a channel or a math channel, float32, shape (ticks,).

        Raises
        ------
        KeyError
            If there is no such channel.
        ConfigError
            If an expression cannot be computed.
        """
        if not isinstance(key, str):
            raise KeyError(f"channels are named one by one, by text, not {key!r}")
        if key in self.described:
            return Samples(self.record.values([key])[0], key, self.described[key].unit)
        if not is_math(key) and not _OPERATORS.search(key):
            raise KeyError(f"no channel {key!r}{did_you_mean(key, list(self.described))}")
        units = {name: channel.unit for name, channel in self.described.items()}
        try:
            text = key if is_math(key) else f"={key}"
            math = compile_column(text, units, CONTROL_PERIOD)
        except ExpressionError as error:
            raise ConfigError(FieldError("channel", str(error), key)) from None
        values = values_of(math, lambda name: self.record.values([name])[0])
        return Samples(values, math.name, math.program.unit)

    def __getstate__(self) -> dict[str, Any]:
        """Return what a pickle holds: all samples."""
        names, record = list(self.described), self.record
        kept = Kept(names, record.values(names), record.ticks, record.metadata)
        return {**vars(self), "_recorded": kept.record, "record": None}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Take what a pickle holds."""
        del state["record"]
        vars(self).update(state)

    def __iter__(self) -> Iterator[str]:
        """Iterate over the names."""
        return iter(self.described)

    def __len__(self) -> int:
        """Return the number of channels."""
        return len(self.described)

    def _ipython_key_completions_(self) -> list[str]:
        return list(self.described)

    @naming_extras("to_arrow")
    def to_arrow(self, *channels: str) -> pa.Table:
        """Return channels as an Arrow table, all of them if none is named.

        ``tick`` and ``time`` come first; unit and meaning are the metadata of each field, as in
        Parquet files of the lab.
        """
        import pyarrow as pa

        from motionlab.telemetry.recorder import telemetry_schema

        columns = self._chosen(channels)
        described = [(one.name, self._description(one)) for one in columns]
        schema = telemetry_schema(described, self.record.metadata)
        arrays = [pa.array(np.asarray(self.ticks)), pa.array(np.asarray(self.time))]
        arrays += [pa.array(np.asarray(one), from_pandas=True) for one in columns]
        return pa.Table.from_arrays(arrays, schema=schema)

    @naming_extras("to_pandas")
    def to_pandas(self, *channels: str) -> pd.DataFrame:
        """Return channels as a data frame over time, s; ``attrs["units"]`` has their units.

        Raises
        ------
        NotInstalled
            If pandas is not installed.
        """
        import pandas as pd

        columns = self._chosen(channels)
        frame = pd.DataFrame(
            {one.name: np.asarray(one) for one in columns},
            index=pd.Index(np.asarray(self.time), name="time"),
        )
        frame.attrs["units"] = {one.name: one.unit for one in columns}
        return frame

    @naming_extras("save")
    def save(self, path: str | Path, *channels: str) -> Path:
        """Write channels to a ``.parquet`` or ``.csv`` file, all of them if none is named.

        The file appears under its name when it is complete.

        Raises
        ------
        ConfigError
            If the file has another ending, or cannot be there.
        StoreError
            If it cannot be written.
        """
        from pyarrow import csv

        from motionlab.telemetry.recorder import SUFFIXES, parquet_writer

        check_target(str(path), *SUFFIXES, loc="path")
        table = self.to_arrow(*channels)
        with complete_file(str(path)) as partial:
            if Path(path).suffix == ".csv":
                units = [field.metadata[b"unit"].decode() for field in table.schema]
                names = [f"{n} [{u}]" for n, u in zip(table.column_names, units, strict=True)]
                csv.write_csv(table.rename_columns(names), partial)
            else:
                with parquet_writer(partial, table.schema) as writer:
                    writer.write_table(table)
        return Path(path)

    @naming_extras("plot")
    def plot(
        self,
        *channels: str,
        start: float = 0.0,
        end: float | None = None,
        ax: Axes | Sequence[Axes] | None = None,
        title: str = "",
    ) -> Figure:
        """Draw channels over time with matplotlib; those of one unit and axis share a panel.

        Parameters
        ----------
        *channels : str
            Channels and math channels; of a run the following errors if none is named.
        start, end : float
            Part of the time, s; up to the last sample when left out.
        ax : matplotlib Axes or sequence of them
            Where to draw: one for all channels, which then are of one unit, or one for each panel.
        title : str
            Above the panels.

        Returns
        -------
        Figure
            A new one, or that of `ax`.

        Raises
        ------
        ConfigError
            If nothing is left to draw, or `ax` does not fit.
        NotInstalled
            If matplotlib is not installed.
        """
        from motionlab.scripting.figure import Curve, figure_of

        time = np.asarray(self.time)
        part = slice(*np.searchsorted(time, [start, np.inf if end is None else end]))
        if not part.start < part.stop:
            end_given = "" if end is None else f" to {end}"
            raise ConfigError(
                FieldError("start, end", "leaves nothing to draw", f"{start}{end_given}", unit="s")
            )
        chosen = self._chosen(channels or self.shown())
        curves = [Curve(one.name, one.unit, np.asarray(one[part])) for one in chosen]
        return figure_of(time[part], curves, title, ax)

    def shown(self) -> list[str]:
        """Return the channels that are drawn when none is named: the first six, or an override."""
        return list(self.described)[:6]

    def _chosen(self, channels: Sequence[str]) -> list[Samples]:
        return [self[name] for name in (channels or self.described)]

    def _description(self, one: Samples) -> Channel:
        return self.described.get(one.name) or Channel(one.name, one.unit, "computed")

    def _svg(self, title: str, names: Sequence[str]) -> Markup:
        """Return channels of one unit as a small drawing, for notebooks without matplotlib."""
        values = self.record.values(names)
        low, high = min_max(values, BINS)
        time = np.asarray(self.time)
        size = -(-len(time) // low.shape[1])
        curves = [chart.Curve(name, look_of(name), low[i], high[i]) for i, name in enumerate(names)]
        unit = self.described[names[0]].unit
        return chart.svg(
            chart.Chart(title, unit, time[::size], (float(time[0]), float(time[-1])), curves)
        )


def look_of(name: str) -> str:
    """Return the look of a channel, `motionlab.reports.svg_chart.LOOKS`: that of its variant."""
    variant, dot, _ = name.partition(".")
    if dot and len(variant) == 1 and variant.isupper():
        place = (ord(variant) - ord("A")) % len(chart.VARIANT_LOOKS)
        return chart.VARIANT_LOOKS[place]
    return "reference" if dot else "two"


def in_notebook(*parts: object) -> str:
    """Return parts as HTML of a notebook, with the colours of the curves."""
    inks = "".join(f".motionlab svg .{look}{{stroke:{ink}}}" for look, ink in chart.LOOKS.items())
    style = (
        ".motionlab svg{max-width:46rem;display:block}.motionlab svg text{fill:currentColor}"
        f".motionlab svg .grid{{stroke:{_GRID}}}.motionlab svg .zero{{stroke:#8a96a0}}"
        ".motionlab pre{line-height:1.3}" + inks
    )
    return element("div", element("style", Markup(style)), *parts, class_="motionlab")
