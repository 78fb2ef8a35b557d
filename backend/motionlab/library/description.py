"""What a list shows of a run: differences from the shipped scenario, metrics, a picture."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from itertools import groupby
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab.config.changes import apply_changes
from motionlab.config.controller import CompensationConfig
from motionlab.config.load import load_scenario, validate
from motionlab.config.named_configs import names
from motionlab.config.planar import AXES
from motionlab.config.scenario import Scenario, VariantConfig
from motionlab.errors import ConfigError, shown
from motionlab.laws import LAWS
from motionlab.library.run import Difference, Event, RunDetail
from motionlab.library.run_name import PATH, rank
from motionlab.library.search import HEADLINE
from motionlab.library.trajectories import known_path, path_words
from motionlab.telemetry.recording import Recording

DIFFERENCES_MAX = 50
_POINTS = 48
_FULL = 1000
_MAGNIFIED = 1 / 3  # of the path's size: the largest error in the picture
_AT_REST = 1e-9  # m
_LEARNT = "learnt"
_NAMED = ("kind", "name", "law")
"""Fields that decide what their neighbours mean: where one differs, the others are not compared."""


def differences(scenario: Scenario) -> list[Difference]:
    """Return the fields whose value is not that of the shipped scenario of its name.

    Those that tell runs apart come first. Another path is one difference, `PATH`, with both names.
    Of a scenario with a name of its own there are none: there is nothing to compare with.
    """
    if scenario.name not in names("scenarios"):
        return []
    shipped = load_scenario(scenario.name)
    changes = differing(*(each.model_dump(mode="json") for each in (shipped, scenario)))
    if any(each.path.startswith(f"{PATH}.") for each in changes):
        before, path = known_path(shipped.trajectory), known_path(scenario.trajectory)
        if path or any(each.path == f"{PATH}.kind" for each in changes):
            other = Difference(
                path=PATH,
                shipped=before or path_words(shipped.trajectory),
                value=path or path_words(scenario.trajectory),
            )
            changes = [other, *(each for each in changes if not each.path.startswith(f"{PATH}."))]
    return sorted(changes, key=rank)


def differences_after(run: RunDetail, events: Iterable[Event]) -> list[Difference]:
    """Return the differences of a live run with all changes made while it ran.

    Those of its beginning where the changes no longer fit the scenario.
    """
    document = run.scenario_document or {}
    changes = (event.set for event in events if event.kind == "change")
    try:
        for _, alike in groupby(changes, key=lambda each: each.keys()):
            *_, last = alike  # of a slider that was dragged, only where it came to rest
            document = apply_changes(document, last)
        return differences(validate(document))
    except ConfigError:
        return run.differences


def differing(before: Mapping[str, Any], after: Mapping[str, Any]) -> list[Difference]:
    """Return the fields of a scenario, as documents, that differ; `DIFFERENCES_MAX` at most."""
    differences = _differing(before, after, "")
    return [each for each, _ in zip(differences, range(DIFFERENCES_MAX), strict=False)]


def _differing(shipped: Any, value: Any, path: str) -> Iterator[Difference]:
    if shipped == value:
        return
    if path == _LEARNT:
        yield Difference(path=path, shipped=_laps(shipped), value=_laps(value))
        return
    if not (isinstance(shipped, dict) and isinstance(value, dict)):
        yield Difference(path=path, shipped=_short(shipped), value=_short(value))
        return
    for key in _NAMED:
        if key in shipped and key in value and shipped[key] != value[key]:
            yield from _differing(shipped[key], value[key], _join(path, key))
            return
    for key in [*shipped, *(key for key in value if key not in shipped)]:
        if not path and key in {"name", "description"}:
            continue
        yield from _differing(shipped.get(key), value.get(key), _join(path, key))


def _join(path: str, key: str) -> str:
    return f"{path}.{key}" if path else key


def _laps(learnt: Mapping[str, Any] | None) -> str | None:
    """Return a learnt force in words, without its numbers."""
    if learnt is None:
        return None
    return f"{learnt['laps']} lap{'' if learnt['laps'] == 1 else 's'}"


def _short(value: Any) -> Any:
    return value if value is None or isinstance(value, bool | int | float | str) else shown(value)


def labels(scenario: Scenario) -> dict[str, str]:
    """Return what the controller of each variant is: its label, or its law where that was changed.

    The label of a shipped variant names the law that it ships with.
    """
    changed = {each.path for each in differences(scenario)}

    def label(name: str, variant: VariantConfig) -> str:
        law, enabled = (
            f"variants.{name}.controller.compensation.{key}" for key in ("law", "enabled")
        )
        if variant.label and not changed & {law, enabled}:
            return variant.label
        return law_title(variant.controller.compensation)

    return {name: label(name, variant) for name, variant in scenario.variants.items()}


def law_title(compensation: CompensationConfig) -> str:
    """Return what a controller does about friction, as the page names it."""
    off = compensation.law != "off" and not compensation.enabled
    return LAWS[compensation.law].label + (", switched off" if off else "")


def headline(result: Mapping[str, Any]) -> dict[str, float]:
    """Return the metrics of a result document that lists show, by variant, axis and name."""
    return {
        f"{variant}.{axis}.{name}": values[name]
        for variant, measured in result.get("variants", {}).items()
        for axis, values in measured["axes"].items()
        for name in HEADLINE.values()
        if values.get(name) is not None
    }


def thumbnail(recording: Recording, window: tuple[int, int]) -> dict[str, list[int]]:
    """Return a small picture of a window: reference and variants, errors magnified alike.

    A motion along one axis only is drawn over time.

    Parameters
    ----------
    recording : Recording
        That holds the window.
    window : tuple of int
        Ticks [start, end).

    Returns
    -------
    dict of str to list of int
        ``x, y, x, y ...`` of 0 to 1000, y upwards; of ``reference`` and each variant.
    """
    start, end = (tick - recording.first_tick for tick in window)
    errors = {
        name: np.stack([record.channel("following_error", axis)[start:end] for axis in AXES])
        for name, record in recording.variants.items()
    }
    return picture(recording.references[0][:, start:end], errors)


def picture(
    reference: NDArray[np.floating[Any]], errors: Mapping[str, NDArray[np.floating[Any]]]
) -> dict[str, list[int]]:
    """Return a small picture of a path and of errors along it, as `thumbnail` does.

    Parameters
    ----------
    reference : ndarray, shape (2, samples)
        x and y; NaN where there is none.
    errors : mapping of str to ndarray, shape (2, samples)
        Following errors by variant.
    """
    samples = reference.shape[1]
    picked = np.unique(np.linspace(0, samples - 1, min(_POINTS, samples)).astype(np.int64))
    extent = np.array([_extent(row) for row in reference])
    some = {name: error[:, picked] for name, error in errors.items()}
    largest = max((float(np.nanmax(np.abs(e), initial=0.0)) for e in some.values()), default=0.0)
    factor = _MAGNIFIED * max(float(extent.max()), _AT_REST) / largest if largest else 0.0
    path = reference[:, picked]
    curves = {"reference": path} | {name: path - factor * error for name, error in some.items()}
    if extent.min() < _AT_REST:  # a line: over time
        axis = int(np.argmax(extent))
        times = picked * (max(float(extent[axis]), _AT_REST) / max(1, samples - 1))
        curves = {name: np.stack([times, curve[axis]]) for name, curve in curves.items()}
    return _scaled(curves)


def _extent(values: NDArray[np.floating[Any]]) -> float:
    finite = values[np.isfinite(values)]
    return float(np.ptp(finite)) if finite.size else 0.0


def _scaled(curves: Mapping[str, NDArray[np.floating[Any]]]) -> dict[str, list[int]]:
    """Return the finite points of curves in a common square of 0 to `_FULL`."""
    finite = {name: curve[:, np.isfinite(curve).all(axis=0)] for name, curve in curves.items()}
    every = np.concatenate(list(finite.values()), axis=1)
    if not every.size:
        return {name: [] for name in curves}
    low, high = every.min(axis=1), every.max(axis=1)
    size = max(float((high - low).max()), np.finfo(float).tiny)
    corner = (low + high - size) / 2
    return {
        name: np.rint((curve - corner[:, np.newaxis]) / size * _FULL).astype(int).T.ravel().tolist()
        for name, curve in finite.items()
    }
