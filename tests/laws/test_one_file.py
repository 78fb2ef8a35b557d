"""A law that is one file more in the package is wherever a law can be."""

from __future__ import annotations

import csv
import json
import re
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import fmpy
import httpx
import pytest

from motionlab.timing import CONTROL_PERIOD
from tests.export.compilers import call, compiler
from tests.export.unit import Unit
from tests.library.served import API, PATIENCE, SERVE
from tests.one_file import lab_with, printed
from tests.paths import ROOT

LAWS = ROOT / "tests" / "fixtures" / "laws"
COMPENSATION = "variants.B.controller.compensation"


@pytest.fixture(scope="module")
def environment(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """Return the environment of a lab that has the relay, and a law of hostile names."""
    folder = tmp_path_factory.mktemp("lab")
    return lab_with("laws", folder, LAWS / "relay.py", LAWS / "words.py")


def _address(server: subprocess.Popen[bytes], stderr: Path) -> str:
    end = time.monotonic() + PATIENCE
    while (address := re.search(r"Serving (http://[0-9.:]+)", stderr.read_text())) is None:
        assert server.poll() is None and time.monotonic() < end, stderr.read_text()
        time.sleep(0.05)
    return address[1]


@pytest.fixture(scope="module")
def lab(
    environment: dict[str, str], tmp_path_factory: pytest.TempPathFactory
) -> Iterator[httpx.Client]:
    """Return a client of a server that has the law."""
    file = tmp_path_factory.mktemp("served") / "stderr.txt"
    with file.open("wb") as stderr:
        process = subprocess.Popen([sys.executable, *SERVE], env=environment, stderr=stderr)
    try:
        with httpx.Client(base_url=_address(process, file), timeout=120, trust_env=False) as client:
            yield client
    finally:
        process.terminate()
        process.wait(60)


def test_it_is_listed_with_its_parameters(environment: dict[str, str]) -> None:
    laws = json.loads(printed(environment, "motionlab", "laws", "--json"))
    relay = next(law for law in laws if law["name"] == "relay")
    assert relay["title"] == "viscous and relay"
    assert [each["path"] for each in relay["parameters"]] == ["level", "zone"]


def test_it_is_the_one_that_the_documentation_shows() -> None:
    page = (ROOT / "docs" / "compensation.md").read_text()
    assert f"```python\n{(LAWS / 'relay.py').read_text()}```\n" in page


def test_it_is_simulated_linearised_in_the_module_of_the_page_and_in_an_fmu(
    environment: dict[str, str],
) -> None:
    computed: dict[str, Any] = json.loads(printed(environment, "tests.laws.surfaces", "relay"))
    assert 0.3 < computed["recorded"] < 1.0  # the relay's level, and viscous friction
    assert computed["module_error"] < 1e-6
    assert computed["phase_margin"] > 0.0
    assert computed["unit_error"] < 1e-11  # A
    assert {"x.level", "y.zone"} <= set(computed["unit_parameters"])


def test_it_is_served_and_taken_by_a_live_session(lab: httpx.Client) -> None:
    fields = lab.get(f"{API}/fields").json()["fields"]
    choices = [
        each["value"] for each in fields["variants.*.controller.compensation.law"]["choices"]
    ]
    assert "relay" in choices
    level = fields["variants.*.controller.compensation.level"]
    assert (level["unit"], level["used_with"]) == ("N", ["relay"])
    answer = lab.post(f"{API}/sessions", json={"scenario": "circle"}).raise_for_status()
    session = answer.headers["location"]
    changes = {"law": "relay", "level": 0.7, "zone": 1e-6}
    whole = {f"{COMPENSATION}.{name}": value for name, value in changes.items()}
    lab.patch(f"{session}/parameters", json={"set": whole}).raise_for_status()
    refused = lab.patch(f"{session}/parameters", json={"set": {f"{COMPENSATION}.level": 101.0}})
    assert refused.status_code == 422
    assert refused.json()["errors"][0]["unit"] == "N"
    lab.post(f"{session}/step", json={"ticks": 800}).raise_for_status()
    text = lab.get(f"{session}/telemetry", params={"format": "csv"}).raise_for_status().text
    names, *rows = csv.reader(text.splitlines())
    column = names.index("B.x.friction_estimate [N]")
    assert max(abs(float(row[column])) for row in rows[-50:]) >= 0.7

    # Its state, 1 or -1, is no bristle of another law: 1 m would be a force of 1e5 N.
    observer = {f"{COMPENSATION}.law": "lugre-observer"}
    lab.patch(f"{session}/parameters", json={"set": observer}).raise_for_status()
    lab.post(f"{session}/step", json={"ticks": 50}).raise_for_status()
    text = lab.get(f"{session}/telemetry", params={"format": "csv"}).raise_for_status().text
    assert all(abs(float(row[column])) < 10.0 for row in list(csv.reader(text.splitlines()))[-50:])


def test_it_is_exported(environment: dict[str, str], tmp_path: Path) -> None:
    words = ("export-controller", "circle", "-o", str(tmp_path / "new"), "--variant", "B")
    changes = ("compensation.law=relay", "compensation.level=0.25")
    options = [f"--set=variants.B.controller.{change}" for change in changes]
    more = ("--seconds", "0.5", "--set=trajectory.lead_in=0.1")
    printed(environment, "motionlab", *words, *options, *more)
    checked = call("make", "-C", tmp_path / "new", "check", f"CC={compiler('gcc')}")
    assert "1000 periods, 0 numbers beyond" in checked.stdout, checked.stdout + checked.stderr
    code = (tmp_path / "new" / "psrm_controller.c").read_text()
    assert "/* Estimate friction as level side + sigma_2 v_ref. */\nstatic void relay(" in code


def test_its_names_may_be_words_of_c_and_of_javascript(
    environment: dict[str, str], tmp_path: Path
) -> None:
    law = "--set=variants.B.controller.compensation.law=words"
    words = ("motionlab", "export-controller", "circle", "--variant", "B", law)
    more = ("--seconds", "0.5", "--set=trajectory.lead_in=0.1")
    printed(environment, *words, "-o", str(tmp_path / "new"), *more)
    for name in ("gcc", "clang"):
        strict = "CFLAGS=-O2 -Werror -Wshadow"
        checked = call("make", "-C", tmp_path / "new", "check", f"CC={compiler(name)}", strict)
        assert "1000 periods, 0 numbers beyond" in checked.stdout, checked.stdout + checked.stderr
    parts = ("psrm_controller.c", "psrm_parameters.c")
    for option in (["-std=gnu17"], ["-x", "c++", "-std=c++20"]):
        code = call(
            compiler("gcc"), *option, "-Wall", "-Werror", "-c", *parts, cwd=tmp_path / "new"
        )
        assert code.returncode == 0, code.stderr
    printed(environment, *words, "-o", str(tmp_path / "unit.fmu"))
    variables: Any = fmpy.read_model_description(str(tmp_path / "unit.fmu")).modelVariables
    assert {"x.default", "y.errno"} <= {each.name for each in variables}
    unit = Unit(tmp_path / "unit.fmu")
    unit.step(CONTROL_PERIOD)


def test_the_page_makes_lanes_of_any_names(environment: dict[str, str], tmp_path: Path) -> None:
    printed(environment, "motionlab.targets.lane_code", str(tmp_path / "lanes.mjs"))
    changes = {f"{COMPENSATION}.law": "words", f"{COMPENSATION}.default": 0.7}
    document = printed(environment, "tests.laws.lane_rows", json.dumps(changes))
    scenario, first, expected = json.loads(document)
    own = f"rows({json.dumps(scenario)}, 'B', 'x').slice({first}, {first + len(expected)})"
    (tmp_path / "run.mjs").write_text(
        f"import {{ rows }} from './lanes.mjs';\nconsole.log(JSON.stringify({own}));\n"
    )
    command = (ROOT / "frontend" / "npm", "exec", "--", "node", tmp_path / "run.mjs")
    done = call(*command)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout.splitlines()[-1]) == pytest.approx(expected)
