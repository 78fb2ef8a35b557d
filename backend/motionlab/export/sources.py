"""The exported controller's sources, and what templates of every export name."""

from __future__ import annotations

import hashlib
from pathlib import Path

import tomli_w

from motionlab import __version__
from motionlab.config.scenario import Scenario
from motionlab.lanes import model_hash

SOURCE = Path(__file__).with_name("source")
"""The exported controller's files, of which every unit has the mathematics; templates are .in."""

TABLES_FILE = "psrm_tables.h"


def scenario_facts(scenario: Scenario, tables: str) -> tuple[bytes, dict[str, str]]:
    """Return a scenario as TOML, and what templates name of it: hash, version, model.

    `tables` is the code of tables; empty without any.
    """
    toml = tomli_w.dumps(scenario.model_dump(mode="json", exclude_none=True)).encode()
    return toml, {
        "scenario": scenario.name,
        "hash": hashlib.sha256(toml).hexdigest(),
        "version": __version__,
        "model": model_hash(),
        "include_tables": f'#include "{TABLES_FILE}"\n' if tables else "",
    }
