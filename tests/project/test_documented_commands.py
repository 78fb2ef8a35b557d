"""Every command of the README and of docs/ is run, or says here why not and who runs it instead."""

from __future__ import annotations

import contextlib
import importlib.util
import io
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import httpx
import pytest

from motionlab.cli import main
from motionlab.config.load import load_scenario
from motionlab.paper.registry import quantities
from motionlab.simulation.inputs import load_force
from motionlab.timing import to_ticks
from tests.paths import ROOT
from tests.project.forked_programs import programs
from tests.project.printed_output import same_text
from tests.server.servers import Server

PATIENCE = 1200  # s; one of them compiles first, others share the cores
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
PROGRAMS = (
    r"(?:motionlab|make|pip|curl|docker|git|systemctl|python3?|\.venv/bin/\S+|/opt/\S+) \S"
    r"|[A-Z]+=\S|export |\(umask "
)
FENCE = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
INDENTED = re.compile(r"(?:^    .*\n)+", re.MULTILINE)
SPAN = re.compile(r"`([^`]+)`")
INLINE = re.compile(r"(?:make|\.venv/bin/\S+|motionlab|pip|docker|systemctl) \S.*")
NUMBER = re.compile(r"(?<![\w-])\d+(?:\.\d+)?")
PRINTS = re.compile(r"\nprints.*\n\n((?:    .*\n|\n)+)")
MENTIONED = {
    "motionlab serve",
    "motionlab run",
    "motionlab run --json",
    "motionlab trajectory import",
}
PLAIN = re.compile(r"motionlab [^|<>$&;\n]*")
PLACEHOLDER = re.compile(r"\b(?:SCENARIO|ADDRESS|FOLDER|IMAGE)\b")

ELSEWHERE = {
    r"make .*": "builds, serves or measures; each is asked of make below without being done",
    r"docker compose .*": "needs an engine: tests/project/test_container.py checks the file",
    r"docker buildx .*": "needs an engine and the network",
    r"\(umask 077; .* > /etc/.*": "writes to /etc; the same line with .env is run",
    r"python3 -m venv /opt/.*|/opt/motionlab/.*": "installs as root: see test_wheel.py",
    r"pip (install|wheel) .*": "changes this environment: see test_wheel.py",
    r"systemctl .*": "needs systemd; deploy.md says what was tried",
    r"git pull": "needs the repository's origin",
    r"motionlab serve (?!--show-settings).*": "runs until interrupted: test_wheel.py",
    r"motionlab drive .*": "needs a server with drives: tests/drive/plug/test_motion.py",
    r"motionlab identify --run .*": "needs a run of drives: tests/drive/test_against_simulation.py",
    r"\.venv/bin/python examples/drive_ab\.py": "tests/drive/plug/test_motion.py",
    r"(ARM=.*|motionlab import (DATA_EMPS|idf_|a3MR).*)": "files of others: "
    "tests/exchange/test_public_data.py",
    r"motionlab (response|shape) .*--run .*": "needs a kept run: tests/studies/test_shape.py",
    r"motionlab safe-tune .*--run .*": "needs kept runs: tests/studies/test_safe_tune.py",
    r"motionlab import rig(-again)?\.csv --name .*": "as above: tests/studies/test_rig.py",
    r"motionlab friction-models .*": "needs a kept run: tests/studies/friction",
    r"(motionlab|curl) .*\bminute\b.*": "needs a kept run: tests/studies/test_minute.py",
    r"motionlab run learnt\.toml .*": "needs what was learnt: tests/simulation/test_learnt.py",
    r"motionlab (check-law|(run|tune) circle --laws) .*": "needs the file of a law: tests/own_laws",
    r"motionlab challenge \S+\.py.*": "needs one too: tests/studies/challenge",
    r"python lissajous\.py|motionlab (elasticity|view error_budget) .*": "needs the file of its "
    "page: test_extending.py",
    r"\.venv/bin/python examples/effects\.py": "run below, beside its table",
    r"motionlab vdrive( .*)?": "runs until interrupted; tests/drive/virtual/test_process.py",
    r"motionlab map( --json .*| --preset reference .*| --set g=0\.27.*)?": "minutes: test_map.py "
    "has smaller ones",
    r"motionlab reproduce( --only fig5 .*)?": "minutes, whose rows "
    "tests/paper/test_reproduce.py reads; that --only finds these is asked below",
    r"motionlab map .*--out configs/.*": "minutes; test_table_map.py solves a position again",
    r"\.venv/bin/python -m tests\.bench.*": "minutes; timing is never asserted",
    r"\.venv/bin/python -m tests\.e2e\.pictures": "writes docs/; test_docs.py sees that they exist",
    r"\.venv/bin/python docs/plots\.py": "writes docs/; test_docs.py draws into another folder",
    r"\.venv/bin/python examples/ab\.py": "tests/server/test_examples.py",
    r"\.venv/bin/python examples/rig\.py.*": "with all of its page: tests/studies/test_rig.py",
    r"\.venv/bin/python examples/learn_residual\.py": "tests/gym/test_documents.py, fewer policies",
    r"\.venv/bin/python examples/compare_(laws|controllers)\.py": "run below, beside its tables",
}
"""What is not run as written, by regular expression, and why or where it is run."""

SMALLER = [
    ("seq 16", "seq 2"),
    ('"trajectory.laps": 1190', '"trajectory.laps": 5'),
    ('$(pgrep -f "motionlab serve --port 8001")', str(os.getpid())),
]
"""Of deploy.md's load: fewer sessions, a shorter job, and the server of this process."""

SMALLER_STUDIES = {
    r"motionlab tune .*": "--evaluations 20",
    r"motionlab identify (?:circle|--axis) .*": "--speeds 0.001 0.003 0.01 0.03 0.1",
    r"motionlab identify .*": "--speeds 0.001 0.003 0.01 0.03 0.1 --places 4",
    r"motionlab identify": "--axis x --no-presliding",
    r"motionlab montecarlo .*": "--cases 40",
    r"motionlab platform --axis .*": "--set cells=4",
    r"motionlab safe-tune .*": "--motions 2 --no-measure",
}
"""Studies that take many seconds with their defaults, and what makes them smaller.

All speeds are used by one that identifies x alone, all ramps by that of a scenario.
"""

WHOLE = {"motionlab tune circle", "motionlab montecarlo circle"}
"""Studies that are run with all their defaults, once each."""

AS_INSTALLED = {".venv/bin/motionlab run circle"}
"""What is run by the program in .venv itself, not by a fork of it."""

FAILS_AS_DOCUMENTED = {("rest.md", '"plant.x.mass": 0'): 22}
"""Page, part of the command, and the exit code of ``curl --fail-with-body`` on 4xx."""


@dataclass(frozen=True)
class Command:
    """A command as a page has it, and the output that the page prints for it, or none."""

    page: str
    text: str
    output: str | None = None

    @property
    def elsewhere(self) -> str | None:
        return next((e for e in ELSEWHERE if re.fullmatch(e, self.text, re.DOTALL)), None)


def outdent(text: str) -> str:
    return re.sub(r"^    ", "", text, flags=re.MULTILINE)


def split(script: str) -> list[str]:
    """Return the commands of a block, or all of it where a variable ties them together."""
    if re.match(r"[A-Z]+=", script):
        return [script]
    joined = re.sub(r"\\\n\s*", "", script)
    return [re.sub(r"\s{2,}# .*", "", line).strip() for line in joined.splitlines()]


def commands_of(page: Path) -> list[Command]:
    text = page.read_text()
    plain = FENCE.sub(lambda m: "" if m[1] else outdent(m[0]), text)
    found: list[Command] = []
    for block in INDENTED.finditer(plain):
        script = outdent(block[0])
        if not re.match(PROGRAMS, script):
            continue
        printed = PRINTS.match(plain, block.end())
        commands = split(script)
        outputs: list[str | None] = [None] * len(commands)
        outputs[-1] = outdent(printed[1]).rstrip() if printed else None
        pairs = zip(commands, outputs, strict=True)
        found += [Command(page.name, command, output) for command, output in pairs]
    spans = [span for span in SPAN.findall(plain) if INLINE.fullmatch(span)]
    found += [Command(page.name, span) for span in spans]
    return [command for command in found if command.elsewhere or not _is_mention(command.text)]


def _is_mention(text: str) -> bool:
    """Tell whether a span in a sentence only names a command, without all that it needs."""
    return bool(PLACEHOLDER.search(text)) or text in MENTIONED


def every_command() -> list[Command]:
    once: dict[str, Command] = {}
    for page in PAGES:
        for command in commands_of(page):
            key = command.text.removeprefix(".venv/bin/")
            if key not in once or command.output:
                once[key] = command
    return list(once.values())


COMMANDS = every_command()
RUN = [command for command in COMMANDS if command.elsewhere is None]


def need(program: str) -> None:
    """Skip where a program is missing that the pages use and `make setup` does not bring."""
    if shutil.which(program) is None:
        reason = f"no {program} on this machine: apt-get install {program}"
        if os.environ.get("CI") == "true":
            pytest.fail(reason, pytrace=False)
        pytest.skip(reason)


@pytest.fixture(scope="module")
def forked(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Return a stand-in for .venv whose programs are forked, and so start at once."""
    with programs(tmp_path_factory.mktemp("venv")) as folder:
        yield folder


def bash(
    script: str, folder: Path, venv: Path, server: Server | None = None
) -> subprocess.CompletedProcess[str]:
    """Run commands as a reader would: .venv in the folder, its programs on the path."""
    if server is not None:
        script = re.sub(r"127\.0\.0\.1:800[01]", f"127.0.0.1:{server.port}", script)
    for whole, part in SMALLER:
        script = script.replace(whole, part)
    (folder / ".venv").symlink_to(venv)
    for name in ("examples", "docs"):
        (folder / name).symlink_to(ROOT / name)
    failing = 'curl() { command curl --fail-with-body "$@"; }\n'
    return subprocess.run(
        ["bash", "-e", "-o", "pipefail", "-c", failing + script],
        cwd=folder,
        env=os.environ | {"PATH": f"{venv}/bin:{sys.prefix}/bin:{os.environ['PATH']}"},
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        check=False,
    )


def in_this_process(text: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """Run a command that needs no shell, without the second that an interpreter takes to start."""
    arguments = shlex.split(text)[1:]
    with (
        contextlib.chdir(folder),
        contextlib.redirect_stdout(io.StringIO()) as printed,
        contextlib.redirect_stderr(io.StringIO()) as said,
    ):
        try:
            code = main(arguments)
        except SystemExit as ended:  # as --version and --help end
            code = int(ended.code or 0)
    return subprocess.CompletedProcess(text, code, printed.getvalue(), said.getvalue())


def smaller(command: Command) -> str:
    """Return a study with fewer evaluations, speeds or cases if no output is compared."""
    if command.text in WHOLE or command.output is not None:
        return command.text
    for pattern, options in SMALLER_STUDIES.items():
        if re.fullmatch(pattern, command.text) and options.split()[0] not in command.text.split():
            return f"{command.text} {options}"
    return command.text


def scenario_of(page: str, name: str = "") -> str:
    """Return the TOML of a page that follows a file name in parentheses, or its first."""
    text = next(path for path in PAGES if path.name == page).read_text()
    text = text[max(text.find(f"{name}`)"), 0) :] if name else text
    return next(body for kind, body in FENCE.findall(text) if kind == "toml")


@pytest.mark.parametrize("command", RUN, ids=lambda c: f"{c.page}: {c.text.splitlines()[0][:60]}")
def test_it_runs_as_written(command: Command, tmp_path: Path, server: Server, forked: Path) -> None:
    for program in ("curl", "openssl", "gcc"):
        if program in command.text:
            need(program)
    written = re.findall(r" (?:new|import \S+|--out) ([\w-]+\.toml)", command.text)
    for name in set(re.findall(r"(?<= )[\w-]+\.toml", command.text)) - set(written):
        (tmp_path / name).write_text(scenario_of(command.page, name))
    if PLAIN.fullmatch(command.text):
        done = in_this_process(smaller(command), tmp_path)
    else:
        venv = Path(sys.prefix) if command.text in AS_INSTALLED else forked
        done = bash(smaller(command), tmp_path, venv, server)
    expected = next(
        (
            code
            for (page, part), code in FAILS_AS_DOCUMENTED.items()
            if page == command.page and part in command.text
        ),
        0,
    )
    assert done.returncode == expected, done.stderr + done.stdout
    if command.output is not None:
        assert same_text(command.output, done.stdout), done.stdout
    for file in re.findall(r"(?:--out|--output|>) ([\w.-]+)", command.text):
        assert (tmp_path / file).stat().st_size > 0, file


def test_the_table_of_laws_is_what_its_example_prints(tmp_path: Path, forked: Path) -> None:
    """All rows but those of the published K, whose runs are chaotic."""
    done = bash(".venv/bin/python examples/compare_laws.py", tmp_path, forked)
    page = (ROOT / "docs" / "compensation.md").read_text()
    rows = [row for row in done.stdout.splitlines() if not row.startswith("| K as published")]
    assert len(rows) > 10
    shown = page.splitlines()
    assert [row for row in rows if not any(same_text(line, row) for line in shown)] == []


def test_the_table_of_effects_is_what_its_example_prints(tmp_path: Path, forked: Path) -> None:
    """Within a twentieth of a micrometre, in which processors differ, and a twentieth."""
    done = bash(".venv/bin/python examples/effects.py", tmp_path, forked)
    page = (ROOT / "docs" / "own-effect.md").read_text()
    shown = page[page.index("| effect | x K = 0") :].splitlines()
    first, second = done.stdout.split("\n\n")
    printed = first.splitlines()
    assert printed[:2] == shown[:2] and len(printed) > 12
    for ours, theirs in zip(printed[2:], shown[2:], strict=False):
        title, *numbers = ours.strip("| ").split(" | ")
        name, *others = theirs.strip("| ").split(" | ")
        assert title == name
        expected = pytest.approx([float(each) for each in others], rel=0.05, abs=0.05)
        assert [float(each) for each in numbers] == expected
    laws = [row for row in second.splitlines() if row[2] == "`" and "published-k" not in row]
    numbers_of = re.compile(r"\d+\.\d+")
    for ours in laws:
        name = ours.split("|")[1]
        (theirs,) = (row for row in shown if row.startswith(f"|{name}|"))
        expected = pytest.approx([*map(float, numbers_of.findall(theirs))], rel=0.05, abs=0.05)
        assert [*map(float, numbers_of.findall(ours))] == expected


def test_the_tables_of_controllers_are_what_their_example_prints(
    tmp_path: Path, forked: Path
) -> None:
    """Row by row, within a tenth and a count; K as published is chaotic and left out."""
    done = bash(".venv/bin/python examples/compare_controllers.py", tmp_path, forked)
    page = (ROOT / "docs" / "compensation.md").read_text()
    tables = page[page.index("| on `nominal`") :].splitlines()
    documented = [row for row in tables if row.startswith("| ")]
    printed = [row for row in done.stdout.splitlines() if row.startswith("| ")]
    assert len(printed) > 35
    chaotic = printed[0].split("|").index(" K as published ")

    def read(row: str) -> tuple[list[float], str]:
        cells = row.split("|")
        if len(cells) > chaotic + 2 and not row.startswith("| margins"):
            del cells[chaotic]
        text = "|".join(cells)
        return [float(n) for n in NUMBER.findall(text)], NUMBER.sub("#", text)

    for ours, theirs in zip(map(read, printed), map(read, documented), strict=False):
        assert ours[1] == theirs[1]
        assert ours[0] == pytest.approx(theirs[0], rel=0.1, abs=0.06)


@pytest.mark.parametrize("target", sorted({c.text for c in COMMANDS if c.text.startswith("make ")}))
def test_make_knows_what_to_do(target: str) -> None:
    asked = target.replace("make ", "make --dry-run --no-print-directory ", 1)
    done = subprocess.run(
        ["bash", "-c", asked], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr


def test_what_is_not_run_is_there() -> None:
    found = {command.elsewhere for command in COMMANDS}
    assert set(ELSEWHERE) <= found, "no page has these any more"
    for command in COMMANDS:
        if asked := re.match(r"motionlab reproduce --only ([\w -]+?)(?: --|$)", command.text):
            assert quantities(asked[1].split()), command
        if module := re.search(r"python -m (tests\.[\w.]+)", command.text):
            assert importlib.util.find_spec(module[1]) is not None, command
        if file := re.match(r"\.venv/bin/python (\S+\.py)", command.text):
            assert (ROOT / file[1]).is_file(), command


def test_no_block_escapes() -> None:
    """A page that has shell in a fence, or a line after a prompt, would not be seen here."""
    for page in PAGES:
        kinds = {kind for kind, _ in FENCE.findall(page.read_text())}
        assert kinds <= {"c", "python", "toml", "yaml", "nginx", "ini"}, page.name
        assert not re.search(r"^    \$ ", page.read_text(), re.MULTILINE), page.name
    assert len(RUN) > 15
    assert sum(command.output is not None for command in RUN) >= 2


def test_every_call_of_the_page_exists(server: Server, document: dict[str, Any]) -> None:
    paths = document["paths"]
    known = {(m.upper(), re.sub(r"\{\w+\}", "{}", path)) for path in paths for m in paths[path]}
    text = (ROOT / "docs" / "rest.md").read_text()
    calls = re.findall(r"`(GET|POST|PUT|PATCH|DELETE) (/[^` ]*)`?", text)
    assert len(calls) > 50
    metrics = httpx.get(f"{server.url}/metrics", timeout=PATIENCE)
    assert metrics.status_code == 200  # not of the API: no OpenAPI
    calls.remove(("GET", "/metrics"))
    for method, path in calls:
        bare = re.sub(r"\{\w+\}", "{}", path)
        assert {(method, bare), (method, f"/api/v1{bare}")} & known, f"{method} {path}"


def test_the_decoder_of_the_page_decodes(server: Server) -> None:
    (script,) = (
        body
        for kind, body in FENCE.findall((ROOT / "docs" / "rest.md").read_text())
        if kind == "python"
    )
    names: dict[str, Any] = {}
    exec(script.replace("127.0.0.1:8000", f"127.0.0.1:{server.port}"), names)
    lowest, highest = names["curves"]["B.x.following_error"]
    assert len(lowest) == len(highest) == names["count"]
    assert 2e-6 < float(highest.max()) < 3e-6


def test_the_load_and_the_schedule_of_the_page(tmp_path: Path, forked: Path) -> None:
    """The file with a load has the forces that its comments state; the schedule switches B."""
    blocks = [body for _, body in FENCE.findall((ROOT / "docs" / "scenarios.md").read_text())]
    loaded, switched = (tmp_path / "loaded.toml", tmp_path / "switched.toml")
    loaded.write_text(next(body for body in blocks if "[load]" in body))
    switched.write_text(next(body for body in blocks if "[[schedule]]" in body))
    load = load_scenario(loaded).load
    force = load_force(load, to_ticks(6.0))
    at = {time: force[to_ticks(time)].tolist() for time in (0.0, 4.0, 5.0)}
    assert at == {0.0: [1.5, 0.0], 4.0: [3.5, -1.0], 5.0: [1.5, -1.0]}
    assert load.noise == 0.05
    done = bash("motionlab run switched.toml --json", tmp_path, forked)
    before, after = (
        segment["variants"]["B"]["axes"]["x"]["max_abs_following_error"]
        for segment in json.loads(done.stdout)["segments"]
    )
    assert after < before / 4


def test_the_path_of_the_page_can_be_followed(tmp_path: Path, forked: Path) -> None:
    body = scenario_of("trajectories.md")
    (tmp_path / "path.toml").write_text(f'base = "circle"\n[trajectory]\n{body}')
    assert bash("motionlab run path.toml", tmp_path, forked).returncode == 0
