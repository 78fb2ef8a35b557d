"""What is known of a run at its beginning."""

from __future__ import annotations

import time
from typing import Any

from motionlab import __version__
from motionlab.config.scenario import Scenario
from motionlab.effects import SOURCES as EFFECT_SOURCES
from motionlab.kernel.force_maps import maps_of
from motionlab.lanes import model_hash
from motionlab.laws import SOURCES, before_of
from motionlab.library.description import differences, labels
from motionlab.library.run import Kind, RunDetail, new_id
from motionlab.library.run_name import run_name
from motionlab.timing import CONTROL_PERIOD


def new_run(
    kind: Kind, scenario: Scenario, result: dict[str, Any], *, name: str = "", drive: str = ""
) -> RunDetail:
    """Return a run without samples of this moment, this program and this processor.

    Parameters
    ----------
    kind : Kind
        What it is of.
    scenario : Scenario
        What is in effect at tick 0.
    result : dict
        Result document of a simulation; empty for a live run.
    name : str
        Given by a person; `run_name` when left out.
    drive : str
        Title of the drive link that moves; empty for a simulation.
    """
    from motionlab.executors.code import processor  # noqa: PLC0415 - loads the compiler

    run = RunDetail(
        id=new_id(),
        kind=kind,
        state="complete",
        name=name,
        named=bool(name),
        drive=drive,
        scenario=scenario.name,
        note="",
        tags=[],
        pinned=False,
        kept=kind == "simulation",  # else recorded without being asked to
        created=time.time(),
        duration=0.0,
        ticks=0,
        period=CONTROL_PERIOD,
        size=0,
        variants=list(scenario.variants),
        labels=labels(scenario),
        differences=differences(scenario),
        metrics={},
        thumbnail={},
        seed=scenario.seed,
        version=__version__,
        model=model_hash(),
        processor=processor(),
        maps=maps_of(scenario),
        scenario_document=scenario.model_dump(mode="json"),
        laws=own_laws_of(scenario),
        events=[],
        result=result,
        columns=[],
    )
    return run if name else run.model_copy(update={"name": run_name(run)})


def own_laws_of(scenario: Scenario) -> dict[str, str]:
    """Return the text of the file of each law and effect of one's own that a scenario has."""
    used = {each.controller.compensation.law for each in scenario.variants.values()}
    axes = scenario.plant.x, scenario.plant.y
    effects = {each.effect for axis in axes for each in axis.effects} & EFFECT_SOURCES.keys()
    laws = {name: SOURCES[name] for name in sorted(used & SOURCES.keys())}
    return laws | {name: EFFECT_SOURCES[name] for name in sorted(effects)}


def variants_with(scenario: Scenario, law: str) -> list[str]:
    """Return the variants whose controllers have a law, or its version before."""
    names = {law, before_of(law)}
    variants = scenario.variants.items()
    return [name for name, each in variants if each.controller.compensation.law in names]


def live_run(scenario: Scenario, run_id: str, created: float, *, drive: str = "") -> RunDetail:
    """Return what is known of a live run at its beginning.

    Parameters
    ----------
    scenario : Scenario
        What is in effect at tick 0.
    run_id : str
        Its identifier.
    created : float
        When it began, seconds since 1970.
    drive : str
        Title of the drive link that moves; empty for a simulated session.
    """
    update = {"id": run_id, "created": created, "state": "recording"}
    begun = new_run("drive" if drive else "live", scenario, {}, drive=drive)
    return begun.model_copy(update=update)
