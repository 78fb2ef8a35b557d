"""What a report needs to simulate its run anew: the kernel, its numbers, the gains to move."""

from __future__ import annotations

import base64
import functools
import gzip
import hashlib
import zlib
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

from motionlab.errors import ConfigError, NotReplayable
from motionlab.files import page_root
from motionlab.kernel.force_maps import maps_of
from motionlab.lanes import model_hash, module_hash
from motionlab.library.replay import again
from motionlab.library.run import RunDetail
from motionlab.reports.lane_copies import Switch, copied_gains, copied_switches
from motionlab.reports.markup import Markup
from motionlab.reports.predicted_rows import predicted_rows
from motionlab.reports.quantities import field_at
from motionlab.simulation.lane_run import Known, LaneRun, Obstacle, lane_run
from motionlab.simulation.whatif import near_window
from motionlab.timing import CONTROL_PERIOD

NUMBERS_MAX = 300_000
"""Largest numbers of a document's runs, bytes of base64; program and kernel take 80 kB more."""
WORK_MAX = 400.0
"""Longest run of which a state near its window is computed, summed over variants, s."""

_TICK = 200  # bytes of reference, load and what they are made of


class Program(NamedTuple):
    """Script and kernel of the built page.

    Attributes
    ----------
    script : Markup
        Text of the script.
    digest : str
        Its SHA-256 in base64, by which the content policy knows it.
    module : str
        The kernel's WebAssembly module, by gzip, in base64.
    """

    script: Markup
    digest: str
    module: str


class Slider(NamedTuple):
    """A gain of a variant.

    Attributes
    ----------
    path : str
        Dotted path of the field.
    name : str
        As people read it; subscripts follow an underscore.
    value : float
        That of the run, SI.
    least, most : float
        Ends of the slider, SI.
    minimum, maximum : float
        The values that are allowed, SI.
    unit : str
        Unit shown.
    factor : float
        Number shown over SI number.
    """

    path: str
    name: str
    value: float
    least: float
    most: float
    minimum: float
    maximum: float
    unit: str
    factor: float


class Experiment(NamedTuple):
    """A run that a page can simulate.

    Attributes
    ----------
    begin : float
        Time from which other gains hold, s.
    numbers : str
        `LaneRun.packed` by zlib in base64, its inputs as `predicted_rows`.
    sliders : dict
        Gains by variant.
    switches : dict
        Switches by variant.
    """

    begin: float
    numbers: str
    sliders: dict[str, list[Slider]]
    switches: dict[str, list[Switch]]


def program() -> Program | None:
    """Return script and kernel; None where the page is not built, or from other sources."""
    root = page_root()
    if root is None:
        return None
    script, modules = root / "report.js", sorted((root / "assets").glob("kernel-*.wasm.gz"))
    if not script.is_file() or len(modules) != 1:
        return None
    stamps = tuple(path.stat().st_mtime_ns for path in (script, *modules))
    return _program(script, modules[0], stamps)


@functools.lru_cache(maxsize=1)
def _program(script: Path, module: Path, _stamps: tuple[int, ...]) -> Program | None:
    content, packed = script.read_bytes().strip(), module.read_bytes()
    if f'"{module_hash()}"'.encode() not in gzip.decompress(packed):
        return None
    digest = base64.b64encode(hashlib.sha256(content).digest()).decode()
    return Program(Markup(content.decode()), digest, base64.b64encode(packed).decode())


def experiments(
    runs: Mapping[str, RunDetail], room: int = NUMBERS_MAX
) -> dict[str, Experiment | str]:
    """Return runs as numbers of at most `room` bytes of base64, or why one cannot be simulated.

    Inputs and tables that are those of the run before are left out.
    """
    made: dict[str, Experiment | str] = {}
    known = Known()
    for name, run in runs.items():
        try:
            numbers = _obstacle(run) or _numbers(run, known)
        except (NotReplayable, ConfigError, Obstacle) as error:
            numbers = f"{error}."
        if isinstance(numbers, str):
            made[name] = numbers
            continue
        gains, (switches, flags) = copied_gains(numbers.prepared), copied_switches(numbers.prepared)
        text = _packed(numbers, gains | flags)
        if len(text) > room:
            kilobytes, most = len(text) / 1e3, room / 1e3
            made[name] = f"Its inputs take {kilobytes:.0f} kB, more than {most:.0f} kB of a report."
            continue
        room -= len(text)
        known = numbers.keys
        begin = numbers.first * CONTROL_PERIOD
        made[name] = Experiment(begin, text, _sliders(numbers, gains), switches)
    return made


def experiments_memory(*runs: RunDetail) -> int:
    """Return the memory that `experiments` takes, bytes."""
    return _TICK * sum(run.ticks for run in runs if _obstacle(run) is None)


def _work(run: RunDetail) -> float:
    return run.duration * len(run.variants)


def _packed(numbers: LaneRun, copies: dict[str, Any]) -> str:
    more: dict[str, Any] = {"copies": copies}
    if numbers.inputs is not None:
        more["orders"], residuals = predicted_rows(numbers.inputs)
        numbers = replace(numbers, inputs=residuals)
    return base64.b64encode(zlib.compress(numbers.packed(**more), 9)).decode()


def _obstacle(run: RunDetail) -> str | None:
    """Return why the record of a run does not allow it, if so."""
    reasons = {
        "It was recorded live, on drives or by measurement.": run.kind != "simulation",
        "The run is incomplete.": run.state != "complete",
        "Another version of the model has simulated it.": run.model != model_hash(),
        f"It takes more than {WORK_MAX:g} s, summed over variants.": _work(run) > WORK_MAX,
    }
    reason = next((text for text, holds in reasons.items() if holds), None)
    if reason is None and any(each["diverged"] for each in run.result["variants"].values()):
        return "A variant diverged."
    return reason


def _numbers(run: RunDetail, known: Known) -> LaneRun | str:
    prepared = again(run).prepared
    if run.maps != maps_of(prepared.scenario):
        return "A force map that it used has changed since."
    start, stop = near_window(prepared)
    return lane_run(prepared, start, stop, known)


def _sliders(numbers: LaneRun, gains: dict[str, Any]) -> dict[str, list[Slider]]:
    """Return the gains of each variant that are parameters of lanes as they are."""
    scenario = numbers.prepared.scenario
    sliders: dict[str, list[Slider]] = {name: [] for name in scenario.variants}
    for path, place in gains.items():
        _, variant, _, axis, name = path.split(".")
        value = getattr(getattr(scenario.variants[variant].controller, axis), name)
        field = field_at(path)
        least, most = field.usual or (place["minimum"], place["maximum"])
        sliders[variant].append(
            Slider(
                path,
                f"{name} {axis}",
                value=value,
                least=min(least, value or least),
                most=max(most, value),
                minimum=place["minimum"],
                maximum=place["maximum"],
                unit=field.unit,
                factor=field.factor,
            )
        )
    return sliders
