"""Writing a scenario's motor as an FMU: FMI 3.0 for co-simulation, in C99."""

from __future__ import annotations

import hashlib
import io
import os
import platform
import shlex
import shutil
import subprocess
import tempfile
import uuid
import zipfile
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from string import Template

import tomli_w

from motionlab import __version__
from motionlab.config.scenario import Scenario
from motionlab.errors import ConfigError, FieldError
from motionlab.export.export import SOURCE
from motionlab.export.model_description import (
    MODEL_IDENTIFIER,
    Variable,
    model_description,
    variables_of,
)
from motionlab.export.plant_code import plant_code
from motionlab.files import check_target, failure, replace
from motionlab.lanes import model_hash
from motionlab.simulation.prepare import prepare
from motionlab.timing import CONTROL_PERIOD

PLANT_SOURCE = Path(__file__).with_name("plant_source")
"""The files that are the same in every FMU, and templates (.in) of the others."""

HEADERS = Path(__file__).with_name("fmi3")
"""The headers of FMI 3.0 by the Modelica Association, BSD 2-clause; importers have their own."""

MATHS = "psrm_math.h"
"""Of the exported controller."""

GENERATED = ("psrm_plant.h", "psrm_plant.c", "psrm_tables.h", "psrm_variables.c")
"""From templates, last the one with the hash of the others."""

COMPILERS = ("cc", "gcc", "clang")
OPTIONS = ("-std=c99", "-O2", "-ffp-contract=off", "-fPIC", "-fvisibility=hidden", "-shared", "-s")

_TIMEOUT = 300.0  # s
_CAUSALITIES = {"input": "PSRM_INPUT", "output": "PSRM_OUTPUT"}


@dataclass(frozen=True)
class PlantExport:
    """Files of an exported motor.

    Attributes
    ----------
    files : tuple of str
        Names in the FMU.
    size : int
        Bytes of the FMU.
    platform : str
        Folder of the binary, such as ``x86_64-linux``; empty without one.
    reason : str
        Why there is no binary.
    """

    files: tuple[str, ...]
    size: int
    platform: str
    reason: str


def export_plant(scenario: Scenario, path: Path) -> PlantExport:
    """Write the motor of a scenario as an FMU.

    It has sources, and a binary for this platform where a C compiler is found: that of the
    environment's CC, else cc, gcc or clang. Equal scenarios and compilers give equal bytes.

    Parameters
    ----------
    scenario : Scenario
        Resolved scenario; exported is the motor that it begins with, without noise.
    path : Path
        File to write, ``.fmu``.

    Raises
    ------
    ConfigError
        If the motor has no phases, a force map is not there, or the file cannot be.
    Infeasible
        If the motor cannot follow the trajectory, at whose start it stands.
    StoreError
        If the file cannot be written.
    """
    check_target(str(path), ".fmu")
    if scenario.plant.force != "phases":
        raise ConfigError(
            FieldError(
                "plant.force", "has no phases, whose currents an FMU takes", "ideal", "phases"
            )
        )
    files = _files(scenario)
    binary, reason = _compiled(files)
    folder = _platform() if binary else ""
    if binary:
        files[f"binaries/{folder}/{MODEL_IDENTIFIER}.so"] = binary
    content = _zipped(files)
    try:
        replace(path, content, mode=0o644)
    except OSError as error:
        raise failure(f"{path}: cannot be written", error) from error
    return PlantExport(tuple(sorted(files)), len(content), folder, reason)


def _files(scenario: Scenario) -> dict[str, bytes]:
    """Return everything but the binary, by name."""
    reference = prepare(scenario).reference
    x, y = reference.position[0]
    variables = variables_of(scenario.plant, (float(x), float(y)))
    toml = tomli_w.dumps(scenario.model_dump(mode="json", exclude_none=True)).encode()
    files = {f"sources/{MATHS}": (SOURCE / MATHS).read_bytes()}
    templates: dict[str, str] = {}
    for source in sorted(PLANT_SOURCE.iterdir()):
        if source.suffix == ".in":
            templates[source.stem] = source.read_text("utf-8")
        elif source.name != "license.txt":
            files[f"sources/{source.name}"] = source.read_bytes()
    code = plant_code(scenario)
    facts = {
        "scenario": scenario.name,
        "hash": hashlib.sha256(toml).hexdigest(),
        "version": __version__,
        "model": model_hash(),
        "variables": "\n".join(_variable_code(variables)),
        "include_tables": '#include "psrm_tables.h"\n' if code.tables else "",
        **code._asdict(),
    }
    for name in GENERATED:
        if name == "psrm_variables.c":
            text = Template(templates[name]).safe_substitute(facts)
            facts["token"] = _token([*files.values(), text.encode()])
        if name != "psrm_tables.h" or code.tables:
            files[f"sources/{name}"] = Template(templates[name]).substitute(facts).encode()
    files["modelDescription.xml"] = model_description(
        variables,
        scenario=scenario.name,
        token=facts["token"],
        seconds=reference.ticks * CONTROL_PERIOD,
    )
    files["documentation/index.html"] = Template(templates["index.html"]).substitute(facts).encode()
    files["documentation/scenario.toml"] = toml
    files["documentation/licenses/license.txt"] = (PLANT_SOURCE / "license.txt").read_bytes()
    return files


def _variable_code(variables: Iterable[Variable]) -> Iterable[str]:
    """Yield the table of variables that psrm_fmi3.h describes."""
    for variable in variables:
        if variable.causality == "parameter":
            causality = "PSRM_FIXED" if variable.fixed else "PSRM_TUNABLE"
        else:
            causality = _CAUSALITIES.get(variable.causality, "PSRM_OUTPUT")
        switch = isinstance(variable.start, bool)
        bounds = {"minimum": 0.0, "maximum": 1.0} if switch else variable.bounds
        least = bounds.get("minimum", bounds.get("exclusive_minimum"))
        most = bounds.get("maximum")
        numbers = (
            repr(float(variable.start or 0.0)),
            "-DBL_MAX" if least is None else repr(float(least)),
            "DBL_MAX" if most is None else repr(float(most)),
            f"{int('exclusive_minimum' in bounds)}U",
        )
        kind = "PSRM_BOOLEAN" if switch else "PSRM_FLOAT64"
        place = f"offsetof(psrm_memory, {variable.member})"
        yield f'    {{"{variable.name}", {place}, {kind}, {causality}, {", ".join(numbers)}}},'


def _token(contents: Iterable[bytes]) -> str:
    """Return an instantiation token that changes with the C that it stands in."""
    digest = hashlib.sha256(b"\0".join(contents)).digest()
    return f"{{{uuid.UUID(bytes=digest[:16])}}}"


def _platform() -> str:
    return f"{platform.machine()}-{platform.system().lower()}"


def _compiled(files: Mapping[str, bytes]) -> tuple[bytes, str]:
    """Return the shared library, or nothing and the reason for that."""
    compiler = shlex.split(os.environ.get("CC", ""))
    command = compiler or next(([name] for name in COMPILERS if shutil.which(name)), [])
    if not command:
        return b"", "there is no C compiler"
    with tempfile.TemporaryDirectory() as folder:
        names = [Path(name).name for name in files if name.startswith("sources/")]
        for name in names:
            (Path(folder) / name).write_bytes(files[f"sources/{name}"])
        sources = sorted(name for name in names if name.endswith(".c"))
        words = [*command, *OPTIONS, f"-I{HEADERS}", *sources, "-lm", "-o", "unit.so"]
        try:
            done = subprocess.run(
                words, cwd=folder, capture_output=True, text=True, timeout=_TIMEOUT, check=False
            )
        except (OSError, subprocess.TimeoutExpired) as error:
            return b"", f"{command[0]} failed: {error}"
        if done.returncode != 0:
            messages = [*done.stderr.strip().splitlines(), f"exit code {done.returncode}"]
            return b"", f"{command[0]} failed: {messages[0]}"
        return (Path(folder) / "unit.so").read_bytes(), ""


def _zipped(files: Mapping[str, bytes]) -> bytes:
    """Return a zip file whose bytes depend on the files alone."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in sorted(files):
            entry = zipfile.ZipInfo(name)  # of 1980
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = (0o755 if name.endswith(".so") else 0o644) << 16
            archive.writestr(entry, files[name])
    return buffer.getvalue()
