"""Studies and views of one's own: over REST, as jobs, and files that cannot be taken."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx
import pytest

from motionlab.studies.own_check import check_file
from tests.e2e.conftest import Server
from tests.paths import ROOT
from tests.project.test_extending import EXAMPLES

FILES = {each.file.rpartition("/")[2]: each.text for each in EXAMPLES if "studies/" in each.file}
STUDY, VIEW = FILES["elasticity.py"], FILES["error_budget.py"]
FIELD = {"field": "variants.B.controller.x.k_p", "set": {"trajectory.laps": 1}}
PATIENCE = 300.0


def line_of(text: str, part: str) -> int:
    return next(i for i, line in enumerate(text.splitlines(), start=1) if part in line)


@pytest.mark.parametrize(
    ("text", "part", "reason"),
    [
        (
            STUDY.replace("class Elasticity(", "class Elasticity(("),
            "class Elasticity((",
            "SyntaxError",
        ),
        (f"import not_there_at_all\n{STUDY}", "import not", "No module named 'not_there_at_all'"),
        (STUDY.replace("STUDY =", "STUDIES ="), "", "STUDY: is not declared by this file"),
        (STUDY.replace("ElasticityStudy()", "ElasticityStudy"), "", "STUDY: is no object"),
        (STUDY.replace('"elasticity"', '"sweep"'), "", "is the name of another; choose another"),
        (STUDY.replace('"elasticity"', '"replay"'), "", "is the name of another"),
        (STUDY.replace('"elasticity"', '"../runs"'), "", "STUDY.kind: is no name"),
        (STUDY.replace("    request_model =", "    _ ="), "", "STUDY.request_model: is no class"),
        (STUDY.replace("def run(", "def walk("), "", "STUDY.run: is missing"),
        (VIEW.replace("VIEW = View(", "VIEW = str("), "VIEW =", "TypeError"),
        (VIEW.replace('View("error_budget"', 'View("cost"'), "", "is the name of another"),
        (VIEW.replace('"ErrorBudget"', '"Budget"'), "", "VIEW.document_name: is no class"),
        (VIEW.replace("def error_budget", "def budget"), "", "error_budget: is no function"),
        ("def f(:\n", "def f", "SyntaxError"),
        ("import os\nos._exit(3)\nVIEW = 1\n", "", "ends the process that runs it"),
        (f"while True:\n    pass\n{VIEW}", "while", "has not ended within 10 s: an endless loop"),
    ],
    ids=lambda value: value[-24:] if isinstance(value, str) else "",
)
def test_another_file_has_a_reason_and_a_line(
    tmp_path: Path, text: str, part: str, reason: str
) -> None:
    path = tmp_path / "own.py"
    path.write_text(text)
    (problem,) = check_file(path, seconds=10.0).problems
    assert reason in str(problem)
    places = [str(path)]
    if part:
        places = [f"{path}:{line_of(text, part) + more}" for more in (0, 1)]  # or the loop's body
    assert problem.place in places


def test_the_files_of_the_page_can_be_taken(tmp_path: Path) -> None:
    for name, text in FILES.items():
        (tmp_path / name).write_text(text)
        assert check_file(tmp_path / name).problems == ()


def command(*words: str | Path) -> subprocess.CompletedProcess[str]:
    line = [sys.executable, "-m", "motionlab", *map(str, words)]
    return subprocess.run(line, env=os.environ, capture_output=True, text=True, check=False)


def test_a_command_says_why_a_file_is_not_taken(tmp_path: Path) -> None:
    """A name that a command has, and an error while it runs, by its line."""
    (tmp_path / "taken.py").write_text(STUDY.replace('"elasticity"', '"serve"'))
    (tmp_path / "broken.py").write_text("STUDY = 1 +\n")
    failing = VIEW.replace("left = np.var(", "left = 1 / 0 * np.var(")
    (tmp_path / "failing.py").write_text(failing)
    unknown = command("elasticity", "--studies", tmp_path)
    assert unknown.returncode == 2
    assert f"not taken: {tmp_path / 'broken.py'}:1: broken: SyntaxError" in unknown.stderr
    assert f"{tmp_path / 'taken.py'}: STUDY.kind: is the name of a command" in unknown.stderr
    failed = command("view", "error_budget", "circle", "--studies", tmp_path)
    assert failed.returncode == 1
    place = f"{tmp_path / 'failing.py'}:{line_of(failing, '1 / 0')}"
    assert f"{place}: failing: ZeroDivisionError: division by zero" in failed.stderr
    assert "Traceback" not in failed.stderr


def test_a_command_waits_for_no_endless_file(tmp_path: Path) -> None:
    path = tmp_path / "own.py"
    path.write_text(f"while True:\n    pass\n{STUDY}")
    done = command("elasticity", "--studies", path)
    assert done.returncode == 2
    assert re.search(r"own\.py:[12]: .*has not ended within 10 s", done.stderr)


def test_the_end_of_a_process_is_an_error_of_its_line(tmp_path: Path) -> None:
    text = STUDY.replace("        errors = []", "        raise SystemExit(3)")
    assert text != STUDY
    (tmp_path / "own.py").write_text(text)
    done = command("elasticity", "--studies", tmp_path, "--field", FIELD["field"])
    assert done.returncode == 1
    assert f"own.py:{line_of(text, 'raise System')}: own: SystemExit: 3" in done.stderr


def test_an_option_names_what_is_there(tmp_path: Path) -> None:
    for option in ("--studies", "--laws"):
        done = command("scenarios", option, tmp_path / "nofolder")
        assert done.returncode == 2
        assert f"{option}: no such folder or file" in done.stderr


def test_a_pipe_among_the_files_is_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "own.py")
    assert "is no regular file" in command("elasticity", "--studies", tmp_path).stderr


def test_a_study_takes_the_file_of_a_scenario(tmp_path: Path) -> None:
    (tmp_path / "elasticity.py").write_text(STUDY)
    (tmp_path / "mine.toml").write_text(
        'base = "circle"\ntrajectory = { base = "circle", laps = 1 }\n'
    )
    words = ("--studies", tmp_path, "--field", FIELD["field"], "--json")
    done = command("elasticity", tmp_path / "mine.toml", *words)
    assert done.returncode == 0, done.stderr
    assert '"value": 200300.0' in done.stdout


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[httpx.Client]:
    """Return a client of a server that has both files, and others that it cannot take."""
    folder = tmp_path_factory.mktemp("studies")
    for name, text in FILES.items():
        (folder / name).write_text(text)
    (folder / "z_again.py").write_text(VIEW)
    (folder / "exits.py").write_text("import os\nos._exit(3)\nSTUDY = 1\n")
    (folder / "fails.py").write_text(
        STUDY.replace('"elasticity"', '"fails"').replace("        errors = []", "        [][1]")
    )
    data = tmp_path_factory.mktemp("data")
    server = Server(data, "--studies", str(folder))
    with httpx.Client(base_url=f"{server.url}/api/v1", timeout=PATIENCE) as client:
        yield client
    server.stop()


def job(lab: httpx.Client, kind: str) -> dict[str, Any]:
    """Return the report of a job that has ended."""
    accepted = lab.post(f"/studies/{kind}", json=FIELD)
    assert accepted.status_code == 202, accepted.text
    end = time.monotonic() + PATIENCE
    while True:
        report = lab.get(f"/jobs/{accepted.json()['id']}").raise_for_status().json()
        if report["state"] not in {"queued", "running"}:
            return report
        assert time.monotonic() < end, report
        time.sleep(0.1)


def test_a_server_lists_them_and_says_what_it_cannot_take(lab: httpx.Client) -> None:
    listed = lab.get("/studies").raise_for_status().json()
    own = [each for each in listed["studies"] + listed["views"] if each["file"]]
    assert {each["path"]: each["file"] for each in own} == {
        "/studies/fails": "fails.py",
        "/studies/elasticity": "elasticity.py",
        "/views/error_budget": "error_budget.py",
    }
    refused = "\n".join(listed["refused"])
    assert re.search(r"exits\.py: exits: ends the process that runs it", refused)
    assert re.search(r"z_again\.py: VIEW\.name: is the name of another", refused)
    paths = lab.get(f"{lab.base_url.join('/openapi.json')}").raise_for_status().json()["paths"]
    assert {f"/api/v1{each['path']}" for each in own} <= paths.keys()


def test_a_study_is_a_job_and_a_view_an_answer(lab: httpx.Client) -> None:
    report = job(lab, "elasticity")
    assert (report["state"], report["kind"]) == ("done", "elasticity")
    assert -1.2 < report["result"]["elasticity"] < -0.6
    assert any(each["kind"] == "elasticity" for each in lab.get("/jobs/now").json())
    request = {"scenario": "circle", "set": FIELD["set"]}
    view = lab.post("/views/error_budget", json=request).raise_for_status().json()
    assert view["variants"]["B"]["x"]["per_sign"] < 1e-6 < view["variants"]["A"]["x"]["per_sign"]


def test_a_request_is_checked_and_an_error_names_its_line(lab: httpx.Client) -> None:
    refused = lab.post("/studies/elasticity", json={"share": 2.0})
    assert refused.status_code == 422
    assert {each["loc"] for each in refused.json()["errors"]} == {"field", "share"}
    report = job(lab, "fails")
    assert report["state"] == "failed"
    line = line_of(STUDY, "        errors = []")
    assert f"fails.py:{line}: fails: IndexError" in report["error"]
    assert lab.get("/health").status_code == 200


def test_an_installed_package_has_them_by_an_entry_point(tmp_path: Path) -> None:
    (tmp_path / "their_study.py").write_text(STUDY)
    info = tmp_path / "theirs-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: theirs\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[motionlab.studies]\ntheirs = their_study\n")
    code = "from motionlab.studies.table import OWN; print([each.path for each in OWN])"
    done = subprocess.run(
        [sys.executable, "-c", code],
        env=os.environ | {"PYTHONPATH": str(tmp_path)},
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.stdout == "['/studies/elasticity']\n", done.stderr
