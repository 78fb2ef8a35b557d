"""Gain sets: named values of controllers, with the metrics and margins that they have."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any

from pydantic import BaseModel, Field

from motionlab.config.changes import as_tables
from motionlab.config.named_configs import names
from motionlab.config.planar import AXES
from motionlab.config.scenario import Scenario
from motionlab.errors import ConfigError, FieldError
from motionlab.library.description import headline
from motionlab.loop.linearise import SLIDING, NoLinearisation, linearise
from motionlab.loop.margins import Margins, margins
from motionlab.simulation.prepare import prepare
from motionlab.simulation.result import document
from motionlab.simulation.run import run

if TYPE_CHECKING:
    from motionlab.library.table_documents import TableDocuments

NAME = r"^[A-Za-z0-9][A-Za-z0-9 ._,()+-]{0,59}$"
"""Form of the name of a set."""

VALUES_MAX = 500
METRICS_MAX = 600.0
"""Longest simulated time, summed over variants, of which metrics are computed, s."""

_ALLOWED = "variants.NAME.controller.FIELD"


class LoopMargins(BaseModel):
    """Margins of the loop of one axis while it slides; null where there is no such crossing."""

    gain_margin: float | None = Field(description="Factor > 1 up to the stability boundary")
    phase_margin: float | None = Field(description="rad")


class GainSet(BaseModel):
    """A named set of controller values."""

    name: str
    created: float = Field(description="When it was saved, seconds since 1970")
    note: str
    scenario: str = Field(description="Scenario that it was saved with")
    values: dict[str, Any] = Field(description="Dotted path of the scenario to value, SI")
    metrics: dict[str, float] = Field(
        description="By variant, axis and metric, of that scenario; empty of one too long to run"
    )
    margins: dict[str, LoopMargins] = Field(
        description="By variant and axis, such as B.x; none of a law without linearisation"
    )


def gain_sets() -> TableDocuments[GainSet]:
    """Return the store of gain sets."""
    from motionlab.library.library import library
    from motionlab.library.table_documents import TableDocuments
    from motionlab.library.tables import GAIN_SETS

    return TableDocuments(library().index, GAIN_SETS, GainSet, "gain set")


def measured(name: str, note: str, scenario: Scenario, values: dict[str, Any]) -> GainSet:
    """Return a set with the metrics and margins that a scenario has with it.

    Raises
    ------
    ConfigError
        If a path leads elsewhere, or the motor cannot follow the scenario.
    """
    wrong = [
        FieldError(f"values.{path}", "is no field of a controller", path, _ALLOWED)
        for path in values
        if not _is_of_a_controller(path)
    ]
    if wrong:
        raise ConfigError(*wrong)
    prepared = prepare(scenario)
    metrics: dict[str, float] = {}
    if prepared.work <= METRICS_MAX:
        metrics = headline(document(prepared, run(prepared)))
    return GainSet(
        name=name,
        created=time.time(),
        note=note,
        scenario=scenario.name,
        values=values,
        metrics=metrics,
        margins=_margins(scenario),
    )


def tables_of(gain_set: GainSet) -> dict[str, Any]:
    """Return a set as tables of a scenario file, complete where its scenario ships."""
    shipped = gain_set.scenario in names("scenarios")
    return ({"base": gain_set.scenario} if shipped else {}) | as_tables(gain_set.values)


def _is_of_a_controller(path: str) -> bool:
    steps = path.split(".")
    return len(steps) > 3 and steps[0] == "variants" and steps[2] == "controller"


def margins_at(scenario: Scenario, speed: float) -> dict[str, Margins | str]:
    """Return the margins of each loop, by variant and axis; a text where there are none.

    Parameters
    ----------
    scenario : Scenario
        Motor and controllers.
    speed : float
        Sliding velocity, in Stribeck velocities of the axis; 0 is stuck.
    """
    by_loop: dict[str, Margins | str] = {}
    for variant in scenario.variants:
        for axis in AXES:
            v = speed * getattr(scenario.plant, axis).friction.v_s
            try:
                loop = linearise(scenario, variant, axis, v=v)
            except NoLinearisation as error:
                by_loop[f"{variant}.{axis}"] = error.errors[0].message
                continue
            by_loop[f"{variant}.{axis}"] = margins(loop.open) if loop.stable else "unstable"
    return by_loop


def _margins(scenario: Scenario) -> dict[str, LoopMargins]:
    return {
        name: LoopMargins(gain_margin=loop.gain_margin, phase_margin=loop.phase_margin)
        for name, loop in margins_at(scenario, SLIDING).items()
        if isinstance(loop, Margins)
    }
