"""The exported controller's sources, and what templates of every export name."""

from __future__ import annotations

import hashlib
import re
from pathlib import Path

import tomli_w

from motionlab import __version__
from motionlab.config.scenario import Scenario
from motionlab.lanes import model_hash

SOURCE = Path(__file__).with_name("source")
"""The exported controller's files, of which every unit has the mathematics; templates are .in."""

TABLES_FILE = "psrm_tables.h"

FOLDERS = (SOURCE, *(SOURCE.with_name(f"{name}_source") for name in ("controller", "fmu")))
"""Files of an exported controller, as C alone and as a unit."""


def interface_names() -> frozenset[str]:
    """Return the names of the files that every exported controller has: types and functions."""
    files = (path for folder in FOLDERS for path in folder.iterdir())
    texts = [path.read_text("utf-8") for path in files]
    return frozenset(name for text in texts for name in re.findall(r"\bpsrm_\w+", text))


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
