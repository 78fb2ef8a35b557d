"""The core, installed without extras, is enough for scripts; what is not says which extra it is."""

from __future__ import annotations

import ast
import json
import os
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from importlib import metadata
from pathlib import Path
from typing import Any

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from motionlab.errors import EXTRA_OF
from tests.paths import ROOT
from tests.project.printed_output import same_text
from tests.project.test_python_docs import SCRIPT
from tests.server.servers import PATIENCE

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
EXTRAS = PROJECT["optional-dependencies"]

COMMANDS = [
    "--help",
    "run circle --json",
    "sweep circle --grid variants.B.controller.x.k_p=3e5,4e5",
    "montecarlo circle --cases 2 --scheduler processes:2",
    "tune circle --axis x --starts 1 --evaluations 10",
    "design",
    "loop circle",
    "check circle",
    "view friction circle",
    "trajectory import path.csv path.toml --samples",
    "scenarios",
    "show circle",
    "fields",
    "laws",
    "schema scenario",
    "export-controller circle --out controller",
    "serve --help",
]
"""Commands that the core can carry out."""

REFUSED = {
    "serve": "lab",
    "demo site": "lab",
    "openapi": "lab",
    "completion bash": "lab",
    "runs": "lab",
    "compare r-1 r-2": "lab",
    "replay r-1": "lab",
    "report r-1 --out r.html": "lab",
    "glitches r-1": "lab",
    "spectrum r-1 --column B.x.following_error": "lab",
    "export r-1 run.csv": "lab",
    "import path.csv": "lab",
    "identify --run r-1": "lab",
    "platform": "lab",
    "map --preset preview": "lab",
    "run circle --keep": "lab",
    "run circle --out run.parquet": "lab",
    "plot circle --out figure.png": "notebook",
}
"""Commands that need an extra."""

CALLS = {
    "motionlab.kept('r-1')": "lab",
    "motionlab.kept_runs()": "lab",
    "motionlab.run(keep=True)": "lab",
    "motionlab.identify(run='r-aaaaaaaaaaaa')": "lab",
    "motionlab.trajectory({'kind': 'samples', 'run': 'r-aaaaaaaaaaaa'})": "lab",
    "run.to_arrow()": "lab",
    "run.save('run.csv')": "lab",
    "run.to_pandas()": "notebook",
    "run.plot()": "notebook",
    "motionlab.linearise().to_control()": "control",
    "motionlab.montecarlo(scheduler='tcp://127.0.0.1:1')": "cluster",
    "importlib.import_module('motionlab.gym')": "gym",
}
"""Calls of Python that need an extra, beside `run`, a run."""

INSIDE = """
import contextlib, importlib, io, json, shlex, sys

import motionlab
from motionlab.cli import main

task = json.load(sys.stdin)
answers = []
for kind, text in task:
    code, out, err = 0, io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            if kind == "command":
                code = main(shlex.split(text))
            else:
                exec(text, globals())
        except SystemExit as end:
            code = end.code or 0
        except motionlab.MotionLabError as error:
            code = f"{type(error).__name__}: {error}"
    answers.append((code, out.getvalue(), err.getvalue()))
print(json.dumps(answers))
"""


def brought(requirements: list[str]) -> Iterator[str]:
    """Yield the names of distributions that requirements bring into this environment."""
    pending, seen = [Requirement(each) for each in requirements], set()
    while pending:
        requirement = pending.pop()
        name = canonicalize_name(requirement.name)
        if name in seen or not (requirement.marker is None or requirement.marker.evaluate()):
            continue
        seen.add(name)
        yield name
        try:
            needed = metadata.requires(name) or []
        except metadata.PackageNotFoundError:  # an extra that the tests do without
            continue
        pending += [r for r in map(Requirement, needed) if "extra" not in str(r.marker)]


@pytest.fixture(scope="module")
def python(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the interpreter of an environment with the core and what it requires alone."""
    environment = tmp_path_factory.mktemp("core")
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", environment], check=True)
    (site,) = environment.glob("lib/python*/site-packages")
    for name in brought(PROJECT["dependencies"]):
        distribution = metadata.distribution(name)
        for top in {file.parts[0] for file in distribution.files or ()} - {"..", "__pycache__"}:
            (site / top).symlink_to(Path(str(distribution.locate_file(top))))
    (site / "motionlab.pth").write_text(str(ROOT / "backend"))
    return environment / "bin" / "python"


def carried_out(python: Path, folder: Path, task: list[tuple[str, str]]) -> list[list[Any]]:
    """Return exit code or error, stdout and stderr of commands and code, all in one process."""
    done = subprocess.run(
        [python, "-W", "error", "-c", INSIDE],
        input=json.dumps(task),
        cwd=folder,
        # A force map that another test has kept would be shown, not computed.
        env=os.environ | {"MOTIONLAB_DATA": str(folder.with_name(f"{folder.name}-data"))},
        capture_output=True,
        text=True,
        timeout=5 * PATIENCE,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_the_core_runs_the_scripts_of_the_docs(python: Path, tmp_path: Path) -> None:
    scripts = SCRIPT.findall((ROOT / "docs" / "python.md").read_text())
    local = [(script, expected) for script, expected in scripts if "Client(" not in script]
    assert len(local) >= 3
    task = [("code", script) for script, _ in local]
    for (code, printed, _), (_, expected) in zip(
        carried_out(python, tmp_path, task), local, strict=True
    ):
        assert code == 0
        assert not expected or same_text(printed, re.sub("^    ", "", expected, flags=re.M))


def test_the_core_carries_out_the_commands_of_scripts(python: Path, tmp_path: Path) -> None:
    (tmp_path / "path.csv").write_text("time,x,y\n0,0,0\n0.1,0.00001,0\n0.2,0.00001,0\n")
    task = [("command", text) for text in COMMANDS]
    for (code, _, errors), text in zip(carried_out(python, tmp_path, task), COMMANDS, strict=True):
        assert code == 0, f"{text}: {errors}"


def test_a_command_that_needs_more_says_which_extra(python: Path, tmp_path: Path) -> None:
    (tmp_path / "path.csv").write_text("time,x\n0,0\n1,0\n")
    task = [("command", text) for text in REFUSED]
    answers = carried_out(python, tmp_path, task)
    for (code, printed, errors), (text, extra) in zip(answers, REFUSED.items(), strict=True):
        line = f'motionlab {text} needs the extra {extra}: pip install "motionlab[{extra}]"'
        assert (code, printed, errors) == (1, "", f"motionlab: {line}\n")


def test_a_call_that_needs_more_says_which_extra(python: Path, tmp_path: Path) -> None:
    task = [("code", 'run = motionlab.run(set={"trajectory.laps": 1})')]
    answers = carried_out(python, tmp_path, task + [("code", text) for text in CALLS])[1:]
    for (code, _, _), (text, extra) in zip(answers, CALLS.items(), strict=True):
        pattern = rf'\w+: .* needs the extra {extra}: pip install "motionlab\[{extra}\]".*'
        assert re.fullmatch(pattern, str(code)), (text, code)
        assert not any(tmp_path.iterdir())


def test_every_public_name_is_there_without_extras(python: Path, tmp_path: Path) -> None:
    ((code, _, _),) = carried_out(python, tmp_path, [("code", "from motionlab import *")])
    assert code == 0


def test_every_module_from_elsewhere_is_of_the_core_or_of_an_extra() -> None:
    core = set(brought(PROJECT["dependencies"]))
    of_extra = {name: set(brought(requirements)) for name, requirements in EXTRAS.items()}
    distributions = metadata.packages_distributions()
    for module in imported():
        names = {canonicalize_name(name) for name in distributions.get(module, [module])}
        assert names & (of_extra[EXTRA_OF[module]] if module in EXTRA_OF else core), module


def imported() -> set[str]:
    """Return the modules of others that the package imports anywhere."""
    modules = set()
    for path in (ROOT / "backend" / "motionlab").rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Import):
                modules |= {alias.name.partition(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.module is not None:
                modules.add(node.module.partition(".")[0])
    return modules - sys.stdlib_module_names - {"motionlab"}
