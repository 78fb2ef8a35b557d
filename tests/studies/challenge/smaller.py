"""A part of the challenge that takes a second."""

from __future__ import annotations

import dataclasses

from motionlab.studies.challenge.definition import Definition, definition


def smaller(*scenarios: str) -> Definition:
    """Return some of its scenarios, stair and creep if none are named, and four motors."""
    of = definition()
    kept = {name: of.scenarios[name] for name in scenarios or ("stair", "creep")}
    return dataclasses.replace(of, scenarios=kept, on_motors=("stair",), motors=4)
