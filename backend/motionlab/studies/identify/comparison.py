"""The circle with the old friction model and with the identified one."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from motionlab.analysis.result_document import ResultDocument
from motionlab.config.load import load_scenario
from motionlab.config.scenario import VariantConfig
from motionlab.simulation.prepare import prepare
from motionlab.simulation.result import document
from motionlab.simulation.run import run
from motionlab.studies.identify.test_bench import Rig


def compared(
    rig: Rig,
    source: str | Path | dict[str, Any],
    given: Mapping[str, Any],
    found: Mapping[str, float],
) -> ResultDocument:
    """Return the result document of the circle with the old model (A) and the new one (B).

    Parameters
    ----------
    rig : Rig
        Motor, and the variant whose model is compared.
    source : str, Path or dict
        The scenario as given.
    given, found : mapping
        Changes of the request, and those that the identification adds.
    """
    new = load_scenario(source, {**given, **found})
    scenario = rig.scenario.model_copy(
        update={
            "name": "circle",
            "trajectory": load_scenario("circle").trajectory,
            "variants": {
                "A": VariantConfig(
                    label="friction model as it was",
                    controller=rig.scenario.variants[rig.apply_to].controller,
                ),
                "B": VariantConfig(
                    label="friction model identified",
                    controller=new.variants[rig.apply_to].controller,
                ),
            },
        }
    )
    prepared = prepare(scenario)
    return ResultDocument.model_validate(document(prepared, run(prepared)))
