"""Packing a co-simulation unit of FMI 3.0: its sources, its description and its binary."""

from __future__ import annotations

import hashlib
import io
import os
import platform
import re
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

from motionlab.config.scenario import Scenario
from motionlab.errors import MotionLabError
from motionlab.export.model_description import Model, Variable, model_description
from motionlab.export.sources import SOURCE, TABLES_FILE, scenario_facts
from motionlab.files import failure, replace
from motionlab.targets.c_words import safe

FMU_SOURCE = Path(__file__).with_name("fmu_source")
"""The interface of FMI, the same in every unit, and templates (.in)."""

HEADERS = Path(__file__).with_name("fmi3")
"""The headers of FMI 3.0 by the Modelica Association, BSD 2-clause; importers have their own."""

MATHS = "psrm_math.h"

COMPILERS = ("cc", "gcc", "clang")
OPTIONS = ("-std=c99", "-O2", "-ffp-contract=off", "-fPIC", "-fvisibility=hidden", "-shared", "-s")

_TIMEOUT = 300.0  # s
_CAUSALITIES = {"input": "PSRM_INPUT", "output": "PSRM_OUTPUT"}


@dataclass(frozen=True)
class UnitExport:
    """Files of an exported unit.

    Attributes
    ----------
    files : tuple of str
        Names in the FMU.
    size : int
        Bytes of the FMU.
    platform : str
        Folder of the binary, such as ``x86_64-linux``; empty without one.
    reason : str
        Why there is no binary: no compiler.
    """

    files: tuple[str, ...]
    size: int
    platform: str
    reason: str

    @property
    def built(self) -> str:
        """What of it is compiled, in words."""
        return f"binary for {self.platform}" if self.platform else f"sources only: {self.reason}"


def export_unit(  # noqa: PLR0913 - what a unit is made of
    path: Path,
    model: Model,
    variables: list[Variable],
    *,
    scenario: Scenario,
    templates: Iterable[Path],
    facts: Mapping[str, str],
) -> UnitExport:
    """Write a unit.

    Parameters
    ----------
    path : Path
        File to write.
    model : Model
        What it is.
    variables : list of Variable
        In the order of their value references.
    scenario : Scenario
        Where it comes from.
    templates : iterable of Path
        Its files beside the interface of FMI; those that end in ``.in`` are templates.
    facts : mapping of str to str
        What templates name, beside the scenario and the version; without ``tables`` there are none.

    Raises
    ------
    MotionLabError
        If a compiler is there and fails.
    StoreError
        If the file cannot be written.
    """
    toml, known = scenario_facts(scenario, facts["tables"])
    facts = {
        **known,
        "identifier": model.identifier,
        "variables": "\n".join(_variable_code(variables)),
        **facts,
    }
    files = _sources([*FMU_SOURCE.iterdir(), SOURCE / MATHS, *templates], facts)
    files["modelDescription.xml"] = model_description(
        model, variables, scenario=scenario.name, token=facts["token"]
    )
    files["documentation/scenario.toml"] = toml
    binary, reason = _compiled(files)
    folder = _platform() if binary else ""
    if binary:
        files[f"binaries/{folder}/{model.identifier}.so"] = binary
    content = _zipped(files)
    try:
        replace(path, content, mode=None)
    except OSError as error:
        raise failure(f"{path}: cannot be written", error) from error
    return UnitExport(tuple(sorted(files)), len(content), folder, reason)


def _sources(paths: Iterable[Path], facts: dict[str, str]) -> dict[str, bytes]:
    """Return sources and documentation by name; `facts` gain the token and the list of sources."""
    files: dict[str, bytes] = {}
    last: dict[str, str] = {}
    for path in sorted(paths, key=lambda path: path.name):
        name = path.name.removesuffix(".in")
        text = path.read_text("utf-8")
        if name in {"psrm_variables.c", "buildDescription.xml"}:
            last[name] = text
        elif name == "license.txt":
            files["documentation/licenses/license.txt"] = text.encode()
        elif name != TABLES_FILE or facts["tables"]:
            folder = "documentation" if name.endswith(".html") else "sources"
            filled = Template(text).substitute(facts) if path.suffix == ".in" else text
            files[f"{folder}/{name}"] = filled.encode()
    variables = Template(last["psrm_variables.c"]).safe_substitute(facts).encode()
    code = [content for name, content in files.items() if name.startswith("sources/")]
    facts["token"] = _token([*code, variables])
    names = [Path(name).name for name in files if name.endswith(".c")]
    facts["sources"] = "\n".join(
        f'      <SourceFile name="{name}"/>' for name in sorted([*names, "psrm_variables.c"])
    )
    for name, text in last.items():
        files[f"sources/{name}"] = Template(text).substitute(facts).encode()
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
        member = re.sub(r"[^\W\d]\w*", lambda name: safe(name[0]), variable.member)
        place = f"offsetof(psrm_memory, {member})"
        yield f'    {{"{variable.name}", {place}, {kind}, {causality}, {", ".join(numbers)}}},'


def _token(contents: Iterable[bytes]) -> str:
    """Return an instantiation token that changes with the C that it stands in."""
    digest = hashlib.sha256(b"\0".join(contents)).digest()
    return f"{{{uuid.UUID(bytes=digest[:16])}}}"


def _platform() -> str:
    return f"{platform.machine()}-{platform.system().lower()}"


def _compiled(files: Mapping[str, bytes]) -> tuple[bytes, str]:
    """Return the shared library; nothing, and the reason for that, where there is no compiler.

    Raises
    ------
    MotionLabError
        If the compiler fails.
    """
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
            raise _failed(command, str(error)) from None
        if done.returncode != 0:
            lines = [*done.stderr.strip().splitlines(), f"exit code {done.returncode}"]
            raise _failed(command, next((each for each in lines if "error" in each), lines[0]))
        return (Path(folder) / "unit.so").read_bytes(), ""


def _failed(command: list[str], reason: str) -> MotionLabError:
    where = "CC in the environment names another compiler"
    return MotionLabError(f"{shlex.join(command)} cannot compile the unit: {reason}; {where}")


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
